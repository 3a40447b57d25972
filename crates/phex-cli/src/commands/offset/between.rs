//! What lies between two layers: solid panels, beams, nodes.

use crate::commands::in_unit;
use crate::exit::{Exit, Failure, OrExit};
use phex::offset::{OffsetError, PanelSolid, beam_axes, joined, node_axes, panel_solids};
use phex_job::Unit;
use phex_mesh::{HexMesh, PolygonSoup, Vec3};
use std::fmt::Write as _;

/// All solids of a pair, and the sum of their volumes.
///
/// # Errors
/// If the gap is too wide, or a panel has no volume.
pub(super) fn solids(
    [lower, upper]: [&HexMesh; 2],
    gap: f64,
    unit: Unit,
) -> Result<(PolygonSoup, f64), Failure> {
    let solids = panel_solids(lower, upper, gap);
    let solids = solids.map_err(|error| match error {
        OffsetError::Gap { .. } => in_unit(error, unit),
        error => Failure::new(Exit::NoValidResult, error),
    })?;
    let volume = solids.iter().map(PanelSolid::volume).sum();
    Ok((joined(&solids), volume))
}

/// The beams of a pair, one a line.
pub(super) fn beam_table([lower, upper]: [&HexMesh; 2]) -> Result<String, Failure> {
    let mut text = "edge,from,to,x0,y0,z0,x1,y1,z1,length,nx,ny,nz,torsion_degrees\n".to_owned();
    for beam in beam_axes(lower, upper).or_exit(Exit::Internal)? {
        let [from, to] = beam.vertices.map(|v| v.index());
        let [a, b] = beam.ends;
        let _ = writeln!(
            text,
            "{},{from},{to},{},{},{},{},{:e}",
            beam.edge.index(),
            numbers(a),
            numbers(b),
            (b - a).norm(),
            numbers(beam.plane_normal),
            beam.torsion.to_degrees()
        );
    }
    Ok(text)
}

/// The nodes of a pair, one a line.
pub(super) fn node_table([lower, upper]: [&HexMesh; 2]) -> Result<String, Failure> {
    let mut text = "vertex,x,y,z,axis_x,axis_y,axis_z,length\n".to_owned();
    for node in node_axes(lower, upper).or_exit(Exit::Internal)? {
        let _ = writeln!(
            text,
            "{},{},{},{}",
            node.vertex.index(),
            numbers(node.base),
            numbers(node.direction),
            node.length
        );
    }
    Ok(text)
}

fn numbers(p: Vec3) -> String {
    format!("{},{},{}", p.x, p.y, p.z)
}
