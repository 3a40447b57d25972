//! Inputs that are finer than panels need: the surface with fewer vertices, and panels on it.
use crate::common::{
    figures, genus_two, mapped, normalised, punched_plane, shape, shape_with, triangles,
};
use phex::smooth_surface::{Coarsened, Normalised, boundary_corners, coarsened};
use phex::{Boundary, MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::{BoundaryCurve, PolygonSoup, TriangleSurface, Vec3, VertexId};
use std::f64::consts::TAU;

const CORNER: f64 = 0.7;

fn coarse(surface: &TriangleSurface, vertices: usize) -> Coarsened {
    coarsened(surface, &boundary_corners(surface, CORNER), vertices)
}

/// Side of the equilateral triangles that cover a surface with so many vertices.
fn spacing(surface: &TriangleSurface, vertices: usize) -> f64 {
    (surface.area() * 2.0 / (3.0_f64.sqrt() * vertices as f64)).sqrt()
}

/// Too many vertices, too few, handles that are filled or holes that are closed are caught.
#[test]
fn as_many_vertices_as_asked_for_and_the_same_topology() {
    let cases = [
        (shape("sphere", 20_000), (2, 0)),
        (shape("torus", 20_000), (0, 0)),
        (shape("wave", 20_000), (1, 1)),
        (shape("catenoid", 20_000), (0, 2)),
        (split(&genus_two(), 3), (-2, 0)),
        (split(&punched_plane(0.25), 2), (-1, 3)),
    ];
    for (surface, expected) in cases {
        for asked in [1200, 2500] {
            let found = coarse(&surface, asked);
            assert_eq!(figures(found.surface.topology()), expected);
            let ratio = found.surface.positions().len() as f64 / asked as f64;
            assert!(
                (0.99..1.3).contains(&ratio),
                "{expected:?} {asked}: {ratio}"
            );
            let place = |v: VertexId| surface.positions()[v];
            let pairs = found.surface.positions().iter().zip(found.source.iter());
            pairs.for_each(|(p, v)| assert_eq!(*p, place(*v)));
        }
    }
}

/// A bowl turned on a lathe has 720 narrow triangles in each row, 5 to 50 times as long as wide: of
/// two beside one another each gets a little thinner when the other goes.
#[test]
fn narrow_triangles_in_rows_go() {
    let (around, rows) = (720, 53);
    let place = |row: u32, k: u32| {
        let (down, turn) = (0.05 + 0.025 * f64::from(row), TAU * f64::from(k) / 720.0);
        Vec3::new(down.sin() * turn.cos(), down.sin() * turn.sin(), down.cos())
    };
    let number = |row: u32, k: u32| row * around + k % around;
    let cells = (0..rows).flat_map(|row| (0..around).map(move |k| (row, k)));
    let faces = cells.flat_map(|(row, k)| {
        let [a, b] = [k, k + 1].map(|k| number(row, k));
        let [d, c] = [k, k + 1].map(|k| number(row + 1, k));
        [vec![a, d, c], vec![a, c, b]]
    });
    let vertices = (0..=rows).flat_map(|row| (0..around).map(move |k| place(row, k)));
    let soup = PolygonSoup {
        positions: vertices.collect(),
        faces: faces.collect(),
    };
    let bowl = TriangleSurface::from_soup(&soup).unwrap();
    let found = coarse(&bowl.components[0].surface, 2000);
    let left = found.surface.positions().len();
    assert!((2000..2400).contains(&left), "{left}");
}

/// Slivers and gaps are caught.
#[test]
fn triangles_are_even() {
    for name in ["torus", "b-spline", "ellipsoid"] {
        let surface = shape(name, 24_000);
        let found = coarse(&surface, 2000);
        let side = spacing(&surface, 2000);
        let topology = found.surface.topology();
        let place = |v: VertexId| found.surface.positions()[v];
        let lengths = topology.edges().map(|e| topology.edge_vertices(e));
        let lengths = lengths.map(|[a, b]| (place(a) - place(b)).norm() / side);
        let (least, most) =
            lengths.fold((f64::INFINITY, 0.0_f64), |(a, b), l| (a.min(l), b.max(l)));
        assert!(least > 0.3 && most < 2.0, "{name}: {least} {most}");
    }
}

/// A boundary that shrinks, corners that are cut, and holes of which a triangle is left are caught.
#[test]
fn the_boundary_stays() {
    let plane = normalised(&shape_with("plane", &[("width", 3.0)], 20_000));
    let found = coarse(&plane, 500);
    assert!((found.surface.area() - plane.area()).abs() < 1e-9);
    let corners = boundary_corners(&found.surface, CORNER);
    assert_eq!(corners.len(), 4);
    let punched = split(&normalised(&punched_plane(0.25)), 2);
    let found = coarse(&punched, 1000);
    let side = spacing(&punched, 1000);
    let curve = BoundaryCurve::of(&punched).unwrap();
    for boundary in found.surface.boundary_loops() {
        assert!(boundary.len() >= 6, "{}", boundary.len());
        for (i, &v) in boundary.iter().enumerate() {
            let place = |v: VertexId| found.surface.positions()[v];
            let middle = (place(v) + place(boundary[(i + 1) % boundary.len()])) * 0.5;
            assert!((curve.closest_point(middle).position - middle).norm() < 0.1 * side);
        }
    }
}

/// A crease that is cut across is caught: the sides of a box stay flat.
#[test]
fn creases_stay() {
    let fine = split(&normalised(&genus_two()), 4);
    let found = coarse(&fine, 1200);
    assert!(found.surface.positions().len() < 2 * 1200);
    assert!((found.surface.area() - fine.area()).abs() < 1e-9 * fine.area());
}

/// Where a surface bends within the spacing it stays fine: the ends of a long ellipsoid are no
/// worse than its waist.
#[test]
fn what_bends_stays_fine() {
    let surface = shape_with("ellipsoid", &[("a", 6.0), ("b", 1.0), ("c", 1.0)], 60_000);
    let found = coarse(&surface, 1500);
    let topology = found.surface.topology();
    let normal = |f| found.surface.area_vector(f).normalize();
    let turns = topology.edges().filter_map(|e| {
        let [a, b] = topology.faces_beside(e)?.map(normal);
        Some(a.angle(&b))
    });
    let most = turns.fold(0.0, f64::max);
    assert!(most < 0.45, "{most}");
}

/// Triangles in four, `times` times, without moving anything.
fn split(surface: &TriangleSurface, times: usize) -> TriangleSurface {
    let mut now = surface.clone();
    for _ in 0..times {
        let topology = now.topology();
        let mut positions = now.positions().as_slice().to_vec();
        let middle = |[a, b]: [VertexId; 2]| (now.positions()[a] + now.positions()[b]) * 0.5;
        let ends = topology.edges().map(|e| topology.edge_vertices(e));
        positions.extend(ends.map(middle));
        let number = |h| (topology.n_vertices() + topology.edge(h).index()) as u32;
        let four = |f| {
            let sides: Vec<_> = topology.face_half_edges(f).collect();
            let [a, b, c] = [0, 1, 2].map(|k: usize| topology.origin(sides[k]).index() as u32);
            let [x, y, z] = [0, 1, 2].map(|k: usize| number(sides[k]));
            [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
        };
        let faces: Vec<[u32; 3]> = topology.faces().flat_map(four).collect();
        now = TriangleSurface::new(positions, &faces).unwrap();
    }
    now
}

#[test]
fn the_smallest_surfaces_stay_what_they_are() {
    for surface in [shape("sphere", 100), shape("plane", 100)] {
        let found = coarse(&surface, 1);
        assert_eq!(
            figures(found.surface.topology()),
            figures(surface.topology())
        );
    }
}

/// The unit does not matter, and a second run gives the same.
#[test]
fn fewer_vertices_are_the_same_in_any_unit() {
    let input = shape("b-spline", 9000);
    let of = |surface: &TriangleSurface| coarse(&Normalised::of(surface).surface, 1500);
    let reference = of(&input);
    for again in [of(&input), of(&mapped(&input, |p| p * 1e3))] {
        assert_eq!(triangles(&reference.surface), triangles(&again.surface));
        assert!(reference.surface.positions() == again.surface.positions());
    }
}

fn panels(count: usize) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(count),
        ..Default::default()
    }
}

/// Panels are laid out on few vertices and kept close to all of them, whatever happens at the
/// boundary; sizes at the input's vertices mean what they did.
#[test]
fn panels_on_a_fine_input_are_as_good_as_on_a_coarse_one() {
    let fine = shape("wave", 30_000);
    for boundary in [Boundary::Snap, Boundary::Whole, Boundary::Clip] {
        let options = MeshOptions {
            boundary,
            ..panels(60)
        };
        let run = mesh_surface(&fine, &options, &Silent).unwrap();
        assert!(run.is_sound(), "{boundary:?}");
        let vertices = run.statistics.target_vertices[0];
        assert!((375..1200).contains(&vertices), "{vertices}");
        // What panels are compared with is the input itself.
        assert_eq!(run.target.positions().len(), fine.positions().len());
        let count = run.mesh.topology().n_faces();
        assert!((50..80).contains(&count), "{boundary:?}: {count}");
    }
    let sized = MeshOptions {
        size_field: Some(
            fine.positions()
                .iter()
                .map(|p| 1.0 + 2.0 * f64::from(p.x > 0.0))
                .collect(),
        ),
        ..panels(120)
    };
    let run = mesh_surface(&fine, &sized, &Silent).unwrap();
    assert!(run.is_sound());
    let mesh = &run.mesh;
    let right = mesh
        .topology()
        .faces()
        .filter(|f| mesh.centre(*f).x > 0.0)
        .count();
    assert!(3 * right < mesh.topology().n_faces(), "{right}");
}
