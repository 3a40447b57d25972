//! From a direction field to the cells of a panelling: the torus has nothing but hexagons, the
//! ellipsoid twelve pentagons.

use phex::Silent;
use phex::curvature::{CurvatureOptions, curvature};
use phex::directions::{DirectionOptions, directions};
use phex::layout::{CellSurface, Layout, LayoutOptions, panelling, place_seeds};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use std::collections::{BTreeMap, HashSet};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["torus", "ellipsoid"] {
        let layout = lay_out(name, 0.1)?;
        let topology = layout.mesh.topology();
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
        for f in topology.faces() {
            *sizes.entry(topology.valence(f)).or_default() += 1;
        }
        println!("{name}: panels by number of corners {sizes:?}");
    }
    Ok(())
}

/// Cells of panels of length `panel_length_rel` diagonals on a built-in surface.
fn lay_out(name: &str, panel_length_rel: f64) -> Result<Layout, Box<dyn std::error::Error>> {
    let shape = Shape::from_name(name, &[])?;
    let surface = triangulate(&shape, &TriangulationOptions::default())?;
    let length = panel_length_rel * surface.diagonal();
    let curvature = curvature(&surface, length, &CurvatureOptions::default());
    let field = directions(&surface, &curvature, length, &DirectionOptions::default())?;
    let placed = place_seeds(
        surface.topology(),
        &field,
        &LayoutOptions::default(),
        &Silent,
    )?;
    let count = placed.seeds.len();
    println!("{name}: {count} seeds, {:?}", placed.statistics);
    let corners = HashSet::new();
    let cells = CellSurface {
        surface: &surface.with_normals(curvature.normal),
        metric: &field.metric,
        mesh: &field.intrinsic,
        corners: &corners,
    };
    Ok(panelling(&cells, &placed.seeds, &Silent)?)
}
