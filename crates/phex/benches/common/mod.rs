//! What the benchmarks of all stages start from: built-in shapes, made ready for a stage.
#![allow(dead_code)] // Each benchmark uses some of these.

use phex::curvature::{Curvature, curvature};
use phex::directions::{Directions, directions};
use phex::layout::CELL;
use phex::layout::Seed;
use phex::layout::{CellSurface, Layout, Placed, panelling, place_seeds};
use phex::smooth_surface::{Affinity, SmoothTarget, smooth_target};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{TriangleSurface, VertexId};
use std::collections::HashSet;

/// Shapes of both signs of curvature, closed and open, at two numbers of panels.
pub const CASES: [(&str, usize); 4] = [
    ("torus", 300),
    ("torus", 1000),
    ("wave", 300),
    ("wave", 1000),
];

/// Vertices per panel of the surface on which cells are drawn.
const DENSITY: usize = 25;

/// A built-in shape.
pub fn shape(name: &str) -> TriangleSurface {
    let shape = Shape::from_name(name, &[]).expect("a built-in shape");
    triangulate(&shape, &TriangulationOptions::default()).expect("default options")
}

/// A surface with diagonal 1.
pub fn normalised(surface: &TriangleSurface) -> TriangleSurface {
    let affinity = Affinity::normalising(surface);
    surface.mapped(|p| affinity.normalise(*p))
}

/// The smooth target of a shape for a number of panels.
pub fn target(name: &str, panels: usize) -> SmoothTarget {
    let surface = normalised(&shape(name));
    smooth_target(&surface, DENSITY * panels, &Default::default())
}

/// Distance of neighbouring panel centres.
pub fn panel_length(surface: &TriangleSurface, panels: usize) -> f64 {
    (surface.area() / (CELL * panels as f64)).sqrt()
}

/// Everything before the layout, on the finest level.
pub struct Prepared {
    pub surface: TriangleSurface,
    pub length: f64,
    pub curvature: Curvature,
    pub directions: Directions,
    pub corners: HashSet<VertexId>,
}

impl Prepared {
    pub fn new((name, panels): (&str, usize)) -> Self {
        let target = target(name, panels);
        let length = panel_length(target.finest(), panels);
        let curvature = curvature(target.finest(), length, &Default::default());
        let directions = directions(target.finest(), &curvature, length, &Default::default())
            .expect("built-in shapes are regular");
        Self {
            surface: target
                .finest()
                .clone()
                .with_normals(curvature.normal.clone()),
            length,
            curvature,
            directions,
            corners: target.corners.into_iter().collect(),
        }
    }

    pub fn seeds(&self) -> Placed {
        place_seeds(
            self.surface.topology(),
            &self.directions,
            &Default::default(),
            &phex::Silent,
        )
        .expect("built-in shapes are regular")
    }

    pub fn panelling(&self, seeds: &[Seed]) -> Layout {
        let cells = CellSurface {
            surface: &self.surface,
            metric: &self.directions.metric,
            mesh: &self.directions.intrinsic,
            corners: &self.corners,
        };
        panelling(&cells, seeds, &phex::Silent).expect("panels are small enough")
    }
}
