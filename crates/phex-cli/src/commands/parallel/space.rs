//! The space of parallel meshes: its dimension and basis, and the mesh in it with edge lengths
//! closest to wishes.

use super::ParallelMesh;
use crate::exit::{Exit, Failure, OrExit};
use crate::parallel_arguments::ParallelCommand;
use crate::summary::SummaryTable;
use phex::offset::ParallelSpace;
use phex_job::{JobError, NumberLine, edges_by_vertices, read_numbers};
use phex_mesh::{EdgeId, HexMesh, PerEdge};
use serde_json::json;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

/// The space of a mesh.
///
/// # Errors
/// If a face is not planar or an edge has no length.
pub(super) fn of(mesh: &HexMesh) -> Result<ParallelSpace, Failure> {
    ParallelSpace::new(mesh).or_exit(Exit::InputUnusable)
}

/// The mesh with the lengths that were asked for or, without any, the given one, and the figures of
/// its space.
///
/// # Errors
/// If the mesh has no such space, or the lengths are not those of edges.
pub(super) fn made(command: &ParallelCommand, mesh: HexMesh) -> Result<ParallelMesh, Failure> {
    let space = of(&mesh)?;
    let rank = space.rank();
    let (edges, dimension) = (mesh.topology().n_edges(), space.dimension());
    let mut table = SummaryTable::default();
    table.row(
        "space",
        format!("{dimension} dimensions (and 3 of translations): {edges} edges, {} independent closing equations", rank.rank),
    );
    let mut statistics = json!({ "dimension": dimension, "rank": rank.rank });
    let mut result = mesh;
    if let Some(path) = &command.lengths {
        let wish = wished(path, &space)?;
        let lengths = space.project_lengths(&wish);
        let miss = |(w, l): (&f64, &f64)| (w - l).abs();
        let missed = wish.iter().zip(&lengths).map(miss).fold(0.0, f64::max);
        let turned = lengths.iter().filter(|&&l| l <= 0.0).count();
        table.row(
            "lengths",
            format!("off the wished ones by up to {missed:.3e}"),
        );
        if turned > 0 {
            table.row("TURNED", format!("{turned} edges point backwards"));
        }
        statistics["largest_miss"] = json!(missed);
        statistics["edges_turned"] = json!(turned);
        result = space.mesh_with_lengths(&lengths);
    }
    Ok(ParallelMesh {
        mesh: result,
        surface: None,
        input: None,
        settings: json!({ "lengths": command.lengths }),
        statistics,
        table,
        basis: command.basis.is_some().then(|| basis(&space)),
    })
}

/// The lengths of all edges, with those of a file in place of some.
fn wished(path: &Path, space: &ParallelSpace) -> Result<PerEdge<f64>, Failure> {
    let mut lengths = space.lengths(space.mesh());
    let edges = edges_by_vertices(space.mesh().topology());
    for line in read_numbers(path)? {
        let [from, to, length] = line.numbers[..] else {
            return Err(line.wrong("`from to length`").into());
        };
        if length < 0.0 {
            return Err(line.wrong("a length of at least 0").into());
        }
        let edge = between(&edges, [from, to]);
        let edge = edge.ok_or_else(|| line.wrong("an edge between two vertices of the mesh"))?;
        lengths[edge] = length;
    }
    Ok(lengths)
}

/// Edges of a file, by their vertices.
pub(super) fn edges(path: &Path, mesh: &HexMesh) -> Result<Vec<EdgeId>, Failure> {
    let by_vertices = edges_by_vertices(mesh.topology());
    let edge = |line: NumberLine| {
        let [from, to] = line.numbers[..] else {
            return Err(line.wrong("`from to`"));
        };
        between(&by_vertices, [from, to])
            .ok_or_else(|| line.wrong("an edge between two vertices of the mesh"))
    };
    let edges: Result<_, JobError> = read_numbers(path)?.into_iter().map(edge).collect();
    Ok(edges?)
}

/// The edge between two vertices whose numbers are given.
fn between(edges: &HashMap<(usize, usize), EdgeId>, [from, to]: [f64; 2]) -> Option<EdgeId> {
    let whole = |x: f64| (x >= 0.0 && x.fract() == 0.0).then_some(x as usize);
    let ends = (whole(from.min(to))?, whole(from.max(to))?);
    edges.get(&ends).copied()
}

/// A sparse basis, an entry a line.
pub(super) fn basis(space: &ParallelSpace) -> String {
    let topology = space.mesh().topology();
    let mut text = "vector,edge,from,to,change\n".to_owned();
    for (k, change) in space.basis().iter().enumerate() {
        for &(edge, by) in change {
            let [from, to] = topology.edge_vertices(edge).map(|v| v.index());
            // Writing to a string does not fail.
            let _ = writeln!(text, "{k},{},{from},{to},{by}", edge.index());
        }
    }
    text
}
