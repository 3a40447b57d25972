//! The brick wall: its formulas on quadrics, how it closes, what its meshes reach, and what it
//! refuses.

use crate::common::{figures, normalised, panel_length, shape, valences};
use crate::curvature::{Curvature, curvature};
use crate::directions::network::{NetworkFamily, NetworkOptions, RowField, row_field};
use crate::layout::Layout;
use crate::layout::brick_wall::bricks::{Brick, Junction};
use crate::layout::brick_wall::{BrickSurface, BrickWallOptions, BrickWallStatistics, brick_wall};
use crate::smooth_surface::smooth_target;
use phex_mesh::polygon::is_simple;
use phex_mesh::{FacePlane, TriangleSurface, Vec2, Vec3, VertexId, measure};
use proptest::prelude::*;
use std::collections::HashSet;

/// The six junctions of a brick, counter-clockwise from its lower left corner, with a kink.
fn outline(brick: Brick, kink: f64) -> Vec<[f64; 2]> {
    let at = |half: i64, line: i64| Junction { half, line }.place(kink);
    let lower = (0..3).map(|k| at(brick.half + k, brick.row));
    let upper = (0..3).rev().map(|k| at(brick.half + k, brick.row + 1));
    lower.chain(upper).collect()
}

/// Corners of a brick `a` long and `b` high on `z = (p x^2 + q y^2) / 2`.
fn on_quadric(brick: Brick, kink: f64, [a, b]: [f64; 2], [p, q]: [f64; 2]) -> Vec<Vec3> {
    let lift = |[u, v]: [f64; 2]| {
        let (x, y) = (a * u, b * v);
        Vec3::new(x, y, 0.5 * (p * x * x + q * y * y))
    };
    outline(brick, kink).into_iter().map(lift).collect()
}

fn height(corners: &[Vec3]) -> f64 {
    let plane = FacePlane::fit(corners);
    let distance = |c: &Vec3| (c - plane.centre).dot(&plane.normal).abs();
    corners.iter().map(distance).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn bricks_with_the_kink_are_planar_on_quadrics_and_simple_up_to_the_limit(
        a in 0.1..2.0f64, b in 0.1..2.0f64, p in -2.0..2.0f64, q in 0.1..2.0f64, sign in prop::bool::ANY,
        u in -3.0..3.0f64, v in -3.0..3.0f64,
    ) {
        let q = if sign { q } else { -q };
        let rho = p * a * a / (4.0 * q * b * b);
        let brick = Brick::containing([u, v]);
        let size = a.max(b);
        let corners = on_quadric(brick, rho, [a, b], [p, q]);
        let bend = |kink: f64| height(&on_quadric(brick, kink, [a, b], [p, q]));
        prop_assert!(bend(rho) < 1e-10 * size * (1.0 + size), "{}", bend(rho));
        if rho.abs() > 0.2 {
            prop_assert!(bend(0.0) > 1e-3 * (p * a * a).abs().min(b));
        }
        prop_assume!((rho.abs() - 1.0).abs() > 1e-6);
        // The projection along z keeps a graph's faces simple or not.
        let plan: Vec<Vec2> = corners.iter().map(|c| c.xy()).collect();
        prop_assert_eq!(is_simple(&plan), (a * a * p).abs() < (4.0 * b * b * q).abs());
    }
}

/// Everything that a wall is laid on.
struct Ground {
    surface: TriangleSurface,
    curvature: Curvature,
    field: RowField,
    corners: HashSet<VertexId>,
}

impl Ground {
    fn new(surface: &TriangleSurface, panels: usize, options: &NetworkOptions) -> Self {
        let smooth = smooth_target(&normalised(surface), 25 * panels, &Default::default());
        let surface = smooth.finest().clone();
        let length = panel_length(&surface, panels);
        let curvature = curvature(&surface, length, &Default::default());
        let field = row_field(&surface, &curvature, length, options).unwrap();
        Self {
            surface: surface.with_normals(curvature.normal.clone()),
            curvature,
            field,
            corners: smooth.corners.into_iter().collect(),
        }
    }

    fn wall(&self, panels: usize, options: &BrickWallOptions) -> (Layout, BrickWallStatistics) {
        let on = BrickSurface {
            surface: &self.surface,
            curvature: &self.curvature,
            field: &self.field,
            corners: &self.corners,
        };
        brick_wall(&on, panels, options).unwrap()
    }
}

fn wall(surface: &TriangleSurface, panels: usize) -> (Layout, BrickWallStatistics) {
    let options = BrickWallOptions::default();
    Ground::new(surface, panels, &options.network).wall(panels, &options)
}

#[test]
fn torus_closes_with_hexagons_alone_whatever_its_proportions() {
    for (minor, panels) in [(0.4, 150), (0.4, 300), (0.25, 230), (0.6, 410)] {
        let torus = crate::common::shape_with("torus", &[("minor", minor)], 6000);
        let (layout, statistics) = wall(&torus, panels);
        let mesh = &layout.mesh;
        assert_eq!(valences(mesh).into_keys().collect::<Vec<_>>(), [6]);
        assert_eq!(figures(mesh.topology()), (0, 0));
        let count = mesh.topology().n_faces() as f64;
        assert!(
            (count / panels as f64).ln().abs() < 0.15,
            "{count} for {panels}"
        );
        assert_eq!(statistics.alignment_kept, 1.0);
    }
}

#[test]
fn planarity_of_the_start_falls_with_the_square_of_the_panels_size() {
    let torus = shape("torus", 12_000);
    let relative = |panels: usize| measure(&wall(&torus, panels).0.mesh).planarity.max;
    let (coarse, fine) = (relative(300), relative(1200));
    assert!(coarse < 0.02 && coarse / fine > 3.0, "{coarse:e} {fine:e}");
}

#[test]
fn annuli_close_and_their_rims_lie_on_rows() {
    for name in ["catenoid", "hyperboloid", "cylinder"] {
        let (layout, _) = wall(&shape(name, 6000), 300);
        let topology = layout.mesh.topology();
        assert_eq!(figures(topology), (0, 2), "{name}");
        let inner = topology.inner_faces();
        for f in inner {
            assert_eq!(topology.valence(f), 6, "{name} face {f}");
        }
    }
}

#[test]
fn sides_of_the_wave_are_rows_and_columns() {
    let (layout, _) = wall(&shape("wave", 6000), 300);
    let counts = valences(&layout.mesh);
    // Whole bricks against rows, whole and half bricks against columns: nothing else.
    assert_eq!(
        counts.keys().copied().collect::<Vec<_>>(),
        [4, 5, 6],
        "{counts:?}"
    );
}

#[test]
fn a_ratio_that_is_asked_for_is_built() {
    let torus = shape("torus", 6000);
    let ground = Ground::new(&torus, 300, &NetworkOptions::default());
    for ratio in [0.8, 1.2] {
        let options = BrickWallOptions {
            ratio: Some(ratio),
            ..Default::default()
        };
        let (_, statistics) = ground.wall(300, &options);
        assert!(
            (statistics.ratio / ratio).ln().abs() < 0.1,
            "{statistics:?}"
        );
    }
}

#[test]
fn columns_follow_an_axis_and_rows_are_conjugate_to_them() {
    let options = NetworkOptions {
        family: NetworkFamily::ConjugateTo([0.6, 0.8, 0.0]),
        ..Default::default()
    };
    let ground = Ground::new(&shape("elliptic-paraboloid", 4000), 200, &options);
    let mut worst: f64 = 0.0;
    for (v, row) in ground.field.row.enumerate() {
        let (form, column) = (ground.curvature.tensor[v], ground.field.column[v]);
        worst = worst.max(row.dot(&(form * column)).abs() / form.norm());
        let n = ground.curvature.normal[v];
        let axis = Vec3::new(0.6, 0.8, 0.0);
        let along = (axis - n * axis.dot(&n)).normalize();
        assert!(column.dot(&along).abs() > 0.95);
    }
    assert!(worst < 0.06, "{worst}");
}

#[test]
fn the_wall_does_not_depend_on_the_number_of_threads() {
    let surface = shape("catenoid", 3000);
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap();
        pool.install(|| wall(&surface, 150).0.mesh)
    };
    assert_eq!(with(1), with(3));
}
