//! What the three kinds of boundary promise, on surfaces with one and two loops, with and without
//! corners.

use phex::{Boundary, MeshOptions, MeshRun, PanelSize, Silent, mesh_surface};
use phex_mesh::{
    BoundaryCurve, FlatFace, HexMesh, PolygonSoup, TriangleSurface, Vec3, ear_clip, io,
    small_rim_faces, validate::ValidateOptions,
};
use std::f64::consts::{PI, TAU};

const PANELS: usize = 220;

/// A grid of `m` by `n` quads, split; the second direction is closed if `closed`.
fn grid(m: usize, n: usize, closed: bool, point: impl Fn(f64, f64) -> Vec3) -> TriangleSurface {
    let columns = if closed { n } else { n + 1 };
    let share = |i: usize, n: usize| i as f64 / n as f64;
    let positions = (0..=m)
        .flat_map(|i| (0..columns).map(move |k| (i, k)))
        .map(|(i, k)| point(share(i, m), share(k, n)));
    let id = |i: usize, k: usize| (i * columns + k % columns) as u32;
    let cells = (0..m).flat_map(|i| (0..n).map(move |k| (i, k)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, k)| {
            let [a, b, c, d] = [id(i, k), id(i + 1, k), id(i + 1, k + 1), id(i, k + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriangleSurface::new(positions.collect(), &triangles).unwrap()
}

fn wave() -> TriangleSurface {
    grid(24, 24, false, |u, v| {
        Vec3::new(TAU * u, TAU * v, 0.4 * (TAU * u).sin() * (TAU * v).cos())
    })
}

fn half_torus() -> TriangleSurface {
    grid(24, 24, true, |u, v| {
        let (s, c) = (PI * u).sin_cos();
        let (t, d) = (TAU * v).sin_cos();
        Vec3::new((3.0 + d) * c, (3.0 + d) * s, t)
    })
}

fn plane_with_hole() -> TriangleSurface {
    grid(10, 48, true, |u, v| {
        let (t, d) = (TAU * v).sin_cos();
        Vec3::new(d, t, 0.0) * (0.35 + 0.65 * u)
    })
}

fn roof() -> TriangleSurface {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/roof.obj");
    let soup = io::read_soup(path.as_ref()).unwrap();
    let parts = TriangleSurface::from_soup(&soup).unwrap();
    parts.components.into_iter().next().unwrap().surface
}

fn surfaces() -> [(&'static str, TriangleSurface); 4] {
    [
        ("wave", wave()),
        ("half torus", half_torus()),
        ("plane with hole", plane_with_hole()),
        ("roof", roof()),
    ]
}

fn meshed(surface: &TriangleSurface, boundary: Boundary) -> MeshRun {
    let mut options = MeshOptions {
        size: PanelSize::Panels(PANELS),
        boundary,
        ..Default::default()
    };
    if boundary == Boundary::Snap {
        // At the usual limit the boundary of the half torus gives way.
        options.optimise.max_deviation = Some(0.01);
    }
    mesh_surface(surface, &options, &Silent).unwrap()
}

/// The faces of a mesh, ear-clipped.
fn clipped(mesh: &HexMesh) -> TriangleSurface {
    let lists = mesh.topology().face_lists();
    let flat = FlatFace::all(mesh);
    let triangles: Vec<[u32; 3]> = lists
        .iter()
        .zip(flat.iter())
        .flat_map(|(face, flat)| {
            let triangles = ear_clip(&flat.polygon).unwrap();
            triangles.into_iter().map(|t| t.map(|k| face[k]))
        })
        .collect();
    TriangleSurface::new(mesh.positions.as_slice().to_vec(), &triangles).unwrap()
}

/// Largest distance of points on the boundary of one surface to that of another.
fn boundary_distance(from: &TriangleSurface, to: &TriangleSurface) -> f64 {
    let curve = BoundaryCurve::of(to).unwrap();
    let mut largest: f64 = 0.0;
    for rim in from.boundary_loops() {
        for (i, v) in rim.iter().enumerate() {
            let (a, b) = (
                from.positions()[*v],
                from.positions()[rim[(i + 1) % rim.len()]],
            );
            for k in 0..8 {
                let p = a + (b - a) * (f64::from(k) / 8.0);
                largest = largest.max((curve.closest_point(p).position - p).norm());
            }
        }
    }
    largest
}

/// Largest distance of a sharp corner of the boundary to a vertex on the mesh's boundary.
fn corner_distance(surface: &TriangleSurface, mesh: &HexMesh) -> f64 {
    let corners = phex::smooth_surface::boundary_corners(surface, 0.7);
    let topology = mesh.topology();
    let rim = topology.boundary_vertices();
    let rim: Vec<Vec3> = rim.map(|v| mesh.position(v)).collect();
    let nearest = |p: Vec3| {
        rim.iter()
            .map(|q| (q - p).norm())
            .fold(f64::INFINITY, f64::min)
    };
    corners
        .iter()
        .map(|v| nearest(surface.positions()[*v]))
        .fold(0.0, f64::max)
}

fn is_sound(name: &str, surface: &TriangleSurface, run: &MeshRun) {
    assert!(run.is_sound(), "{name}: {:?}", run.violations());
    let again = phex_mesh::violations(&run.mesh, Some(&run.target), &ValidateOptions::default());
    assert!(again.is_empty(), "{name}: {again:?}");
    let figures = |t: &phex_mesh::Topology| (t.euler_characteristic(), t.boundary_loops().len());
    let (want, got) = (figures(surface.topology()), figures(run.mesh.topology()));
    assert_eq!(want, got, "{name}");
}

fn follows_the_boundary(name: &str, surface: &TriangleSurface, run: &MeshRun) {
    let mesh = clipped(&run.mesh);
    let limit = 5e-3 * surface.diagonal();
    // The vertex next to a corner may lie a little along the boundary, too.
    let distances = [
        boundary_distance(&mesh, &run.target),
        boundary_distance(&run.target, &mesh),
        corner_distance(surface, &run.mesh) / 1.5,
    ];
    assert!(
        distances.iter().all(|d| *d < limit),
        "{name}: {distances:?} of {limit}"
    );
}

#[test]
fn snapped_panels_follow_the_boundary_and_are_not_small() {
    for (name, surface) in surfaces() {
        let run = meshed(&surface, Boundary::Snap);
        is_sound(name, &surface, &run);
        follows_the_boundary(name, &surface, &run);
        assert_eq!(small_rim_faces(&run.mesh), [], "{name}");
    }
}

/// Share of the ends of edges from the inside that lie on the boundary curve, to rounding.
fn on_the_curve(run: &MeshRun) -> f64 {
    let curve = BoundaryCurve::of(&run.target).unwrap();
    let topology = run.mesh.topology();
    let ends = topology.vertices();
    let ends = ends.filter(|v| topology.is_boundary_vertex(*v) && topology.face_degree(*v) == 2);
    let places: Vec<Vec3> = ends.map(|v| run.mesh.position(v)).collect();
    let limit = 1e-9 * run.target.diagonal();
    let off = |p: &&Vec3| (curve.closest_point(**p).position - **p).norm() > limit;
    1.0 - places.iter().filter(off).count() as f64 / places.len() as f64
}

#[test]
fn panels_meet_the_boundary_exactly_where_they_can() {
    for (name, surface) in surfaces() {
        let run = meshed(&surface, Boundary::Snap);
        let share = on_the_curve(&run);
        // The boundary of the others is an asymptotic curve in places, where neighbours can't both
        // lie on it.
        let free = ["half torus", "plane with hole"].contains(&name);
        let least = if free { 1.0 } else { 0.3 };
        assert!(share >= least, "{name}: {share}");
        let corner = corner_distance(&surface, &run.mesh);
        assert!(corner < 1e-3 * surface.diagonal(), "{name}: {corner}");
    }
}

#[test]
fn clipped_panels_follow_the_boundary_and_are_planar_and_not_small() {
    for (name, surface) in surfaces() {
        let run = meshed(&surface, Boundary::Clip);
        is_sound(name, &surface, &run);
        follows_the_boundary(name, &surface, &run);
        let flat = FlatFace::all(&run.mesh);
        let worst = flat.iter().map(|f| f.planarity_length).fold(0.0, f64::max);
        assert!(worst <= 1e-12 * run.mesh.mean_edge(), "{name}: {worst}");
        // The search may leave one that no change in its surroundings makes larger.
        let small = small_rim_faces(&run.mesh);
        assert!(small.len() <= 1, "{name}: {small:?}");
    }
}

#[test]
fn whole_panels_cover_the_surface_and_are_hexagons_at_the_rim() {
    for (name, surface) in surfaces() {
        let run = meshed(&surface, Boundary::Whole);
        is_sound(name, &surface, &run);
        let mesh = clipped(&run.mesh);
        let near = 5e-3 * surface.diagonal();
        let (mut covered, mut total) = (0.0, 0.0);
        for f in run.target.topology().faces() {
            let p = run.target.centroid(f);
            let area = run.target.area_vector(f).norm();
            total += area;
            if (mesh.closest_point(p).position - p).norm() < near {
                covered += area;
            }
        }
        assert!(covered >= 0.97 * total, "{name}: {}", covered / total);
        let topology = run.mesh.topology();
        let rim = topology.boundary_faces();
        let valences: Vec<usize> = rim.map(|f| topology.valence(f)).collect();
        let hexagons = valences.iter().filter(|v| **v == 6).count();
        assert!(2 * hexagons > valences.len(), "{name}: {valences:?}");
    }
}

/// A facade of 58 by 19 that curves in both directions, with eight windows of 3.2 by 2.4.
fn facade() -> TriangleSurface {
    let (across, up) = (145u32, 48u32);
    let cell = [58.0 / f64::from(across), 19.2 / f64::from(up)];
    let is_window = |i: u32, k: u32| {
        let columns = [15, 50, 85, 120].iter().any(|c| (*c..c + 8).contains(&i));
        columns && [10, 30].iter().any(|r| (*r..r + 6).contains(&k))
    };
    let place = |i: u32, k: u32| {
        let (x, z) = (cell[0] * f64::from(i), cell[1] * f64::from(k));
        let y = 1.8 * (x / 7.0).sin() * (0.4 + z / 19.0) + 0.05 * z;
        Vec3::new(x, y, z)
    };
    let number = |i: u32, k: u32| k * (across + 1) + i;
    let cells = (0..up).flat_map(|k| (0..across).map(move |i| (i, k)));
    let faces = cells.filter(|c| !is_window(c.0, c.1)).flat_map(|(i, k)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| number(i + x, k + y));
        [vec![a, b, c], vec![a, c, d]]
    });
    let soup = PolygonSoup {
        positions: (0..=up)
            .flat_map(|k| (0..=across).map(move |i| place(i, k)))
            .collect(),
        faces: faces.collect(),
    };
    let parts = TriangleSurface::from_soup(&soup).unwrap();
    parts.components[0].surface.clone()
}

/// The search moves panels at windows; a corner that nothing held was cut by a quarter of an edge.
#[test]
fn corners_of_windows_stay() {
    let surface = facade();
    for panels in [281, 400] {
        let options = MeshOptions {
            size: PanelSize::Panels(panels),
            ..MeshOptions::default()
        };
        let run = mesh_surface(&surface, &options, &Silent).unwrap();
        let off = corner_distance(&surface, &run.mesh) / run.mesh.mean_edge();
        assert!(off < 0.05, "{panels}: {off} mean edges");
    }
}
