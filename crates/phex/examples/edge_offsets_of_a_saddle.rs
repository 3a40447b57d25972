//! Panels of a saddle with two layers at constant edge distance, and the hexagons that make it.
//!
//! `cargo run -p phex --example edge_offsets_of_a_saddle -- FOLDER` writes the panels, their Koebe
//! mesh, both layers, and a row of hexagons whose edges run against those of a regular one, as OBJ.

use phex::offset::{OffsetOptions, beam_axes, distance_error, edge_gauss_image, layer};
use phex::pipeline::Method;
use phex::{Boundary, MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{HexMesh, Vec3};
use std::error::Error;
use std::f64::consts::FRAC_PI_3;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name a folder")?);
    let shape = Shape::from_name("hyperbolic-paraboloid", &[("side", 1.6)])?;
    let surface = triangulate(&shape, &TriangulationOptions::default())?;
    let options = MeshOptions {
        size: PanelSize::Panels(150),
        method: Method::Koebe,
        boundary: Boundary::Whole,
        ..MeshOptions::default()
    };
    let run = mesh_surface(&surface, &options, &Silent)?;
    let mesh = run.mesh;
    let (panels, edges) = (mesh.topology().n_faces(), mesh.topology().n_edges());
    let reversed = run.statistics.classical.and_then(|c| c.reversed_edges);
    let reversed = reversed.unwrap_or(0);
    println!("{panels} panels, {edges} edges; {reversed} run against those of the Koebe mesh");

    let options = OffsetOptions::default();
    let found = edge_gauss_image(&mesh, &options)?;
    let distance = 0.3 * mesh.mean_edge();
    let mut layers = Vec::new();
    for d in [distance, -distance] {
        let made = layer(&mesh, &found.image, d, &options)?;
        let error = distance_error(&mesh, &made, found.image.kind, d)?;
        println!("layer at {d:.3}: edges keep their distance to {error:.1e}");
        layers.push(made);
    }
    let beams = beam_axes(&layers[1], &layers[0])?;
    let torsion = beams.iter().map(|b| b.torsion).fold(0.0, f64::max);
    println!(
        "{} beams, torsion at most {torsion:.1e} radians",
        beams.len()
    );

    for (name, mesh) in [
        ("saddle", &mesh),
        ("koebe", &found.image.mesh(&mesh)),
        ("above", &layers[0]),
        ("below", &layers[1]),
        ("hexagons", &hexagons(&[0.6, 1.0, 1.3, 2.0, 4.0])?),
    ] {
        mesh.write(&folder.join(name).with_extension("obj"))?;
    }
    Ok(())
}

/// Hexagons with edges `-b, 1, 1, -b, 1, 1` in a row, for some `b`: closed waists up to 1.
fn hexagons(lengths: &[f64]) -> Result<HexMesh, Box<dyn Error>> {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let mut left = 0.0;
    for &b in lengths {
        let first = u32::try_from(positions.len())?;
        let mut at = Vec3::new(left + b, 0.0, 0.0);
        for k in 0..6 {
            positions.push(at);
            let length = if k % 3 == 0 { -b } else { 1.0 };
            let (sin, cos) = (FRAC_PI_3 * f64::from(k)).sin_cos();
            at += Vec3::new(cos, sin, 0.0) * length;
        }
        // The other way round: they turn clockwise.
        faces.push((first..first + 6).rev().collect::<Vec<u32>>());
        left += b + 1.0;
    }
    Ok(HexMesh::new(positions, &faces)?)
}
