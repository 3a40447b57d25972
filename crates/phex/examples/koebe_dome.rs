//! A dome of planar hexagons with constant mean curvature and two layers at constant edge distance.
//!
//! `cargo run -p phex --example koebe_dome -- FOLDER` writes the Koebe mesh, the dome and its
//! second layer as OBJ.

use phex::Silent;
use phex::koebe::{KoebeOptions, koebe};
use phex::offset::{FitOptions, fit_parallel};
use phex::offset::{edge_distances, edge_offset};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{HexMesh, Vec3};
use std::collections::HashMap;
use std::error::Error;
use std::f64::consts::FRAC_PI_3;
use std::path::PathBuf;

const RINGS: i32 = 8;
const DISTANCE: f64 = 0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("name a folder")?);
    let options = KoebeOptions {
        opening: 30.0,
        ..KoebeOptions::default()
    };
    let gauss_image = koebe(&honeycomb()?, &options, &Silent)?.mesh;
    let shape = Shape::from_name("elliptic-paraboloid", &[("a", 1.2), ("b", 1.8)])?;
    let surface = triangulate(&shape, &TriangulationOptions::default())?;
    let options = FitOptions {
        constant_mean_curvature: 100.0,
        ..FitOptions::default()
    };
    let dome = fit_parallel(&gauss_image, &surface, &options, &Silent)?;
    let layer = edge_offset(&dome.mesh, &gauss_image, DISTANCE);
    let distances = edge_distances(&dome.mesh, &layer);
    let error = distances
        .iter()
        .map(|d| (d - DISTANCE).abs())
        .fold(0.0, f64::max);
    let panels = dome.mesh.topology().n_faces();
    println!(
        "{panels} panels, {:?} after {} rounds",
        dome.status, dome.rounds
    );
    println!(
        "off the surface by {:.1e} rms, {:.1e} max",
        dome.rms_distance, dome.max_distance
    );
    println!(
        "mean curvature {:.4}, spread {:.1e}",
        dome.mean_curvature, dome.mean_curvature_spread
    );
    println!("edge distances constant to {error:.1e}");
    for (name, mesh) in [
        ("koebe", &gauss_image),
        ("dome", &dome.mesh),
        ("layer", &layer),
    ] {
        mesh.write(&folder.join(name).with_extension("obj"))?;
    }
    Ok(())
}

/// Regular hexagons in rings about one.
fn honeycomb() -> Result<HexMesh, Box<dyn Error>> {
    let (mut numbers, mut positions) = (HashMap::new(), Vec::new());
    let mut faces: Vec<Vec<u32>> = Vec::new();
    let cells = (-RINGS..=RINGS).flat_map(|q| (-RINGS..=RINGS).map(move |r| (q, r)));
    for (q, r) in cells.filter(|(q, r)| (q + r).abs() <= RINGS) {
        let (q, r) = (f64::from(q), f64::from(r));
        let centre = Vec3::new(1.5 * q, 3f64.sqrt() * (r + 0.5 * q), 0.0);
        let mut corner = |k: u32| {
            let (sin, cos) = (FRAC_PI_3 * f64::from(k)).sin_cos();
            let p = centre + Vec3::new(cos, sin, 0.0);
            let key = [p.x, p.y].map(|x| (4.0 * x).round() as i64);
            *numbers.entry(key).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        };
        faces.push((0..6).map(&mut corner).collect());
    }
    Ok(HexMesh::new(positions, &faces)?)
}
