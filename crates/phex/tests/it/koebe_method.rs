//! The method `koebe`: panels with offsets at constant edge distance, on patches of both signs of
//! the Gauss curvature, and on closed convex surfaces.
#[path = "common/patches.rs"]
mod patches;

use patches::{PATCHES, patch};
use phex::classical::DomainError;
use phex::layout::LayoutError;
use phex::offset::{
    OffsetOptions, beam_axes, edge_gauss_image, face_curvatures, layer, panel_solids,
};
use phex::pipeline::Method;
use phex::{Boundary, MeshOptions, MeshRun, PanelSize, PipelineError, Silent, mesh_surface};
use phex_mesh::measure::deviation;
use phex_mesh::{FacePlane, HexMesh, TriangleSurface, Violation, measure};

/// A patch by its name.
fn named(name: &str) -> TriangleSurface {
    let found = PATCHES.iter().find(|p| p.0 == name).unwrap();
    patch(60, found.1, found.3)
}

fn options(panels: usize) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(panels),
        method: Method::Koebe,
        boundary: Boundary::Whole,
        ..Default::default()
    }
}

fn run(surface: &TriangleSurface, options: &MeshOptions) -> MeshRun {
    mesh_surface(surface, options, &Silent).unwrap()
}

/// Distance and direction of each pair of corresponding edges, from coordinates alone; over the
/// diagonal. Of inner edges only, if boundary edges are free.
fn worst_of_edges(mesh: &HexMesh, moved: &HexMesh, distance: f64, free: bool) -> f64 {
    let t = mesh.topology();
    let counts = t.edges().filter(|e| !(free && t.is_boundary_edge(*e)));
    let worst = counts.map(|e| {
        let [a, b] = t.edge_vertices(e);
        let [u, w] = [mesh, moved].map(|m| (m.position(b) - m.position(a)).normalize());
        let off = moved.position(a) - mesh.position(a);
        let away = (off - u * off.dot(&u)).norm();
        (away - distance.abs())
            .abs()
            .max(u.cross(&w).norm() * mesh.mean_edge())
    });
    worst.fold(0.0, f64::max) / mesh.diagonal()
}

fn assert_edge_offsets(name: &str, mesh: &HexMesh) {
    let found = edge_gauss_image(mesh, &OffsetOptions::default()).unwrap();
    assert!(found.free_edges.is_empty(), "{name}");
    for share in [0.01, 0.003, -0.003, -0.01] {
        let distance = share * mesh.diagonal();
        let error = worst_of_edges(mesh, &found.image.offset(mesh, distance), distance, false);
        assert!(error < 1e-12, "{name}: {error:e} at {share}");
    }
}

fn assert_hexagons(name: &str, mesh: &HexMesh) {
    let t = mesh.topology();
    assert!(
        t.faces().all(|f| t.valence(f) == 6),
        "{name}: hexagons only"
    );
}

#[test]
fn patches_of_both_signs_have_edge_offsets_on_both_sides() {
    let small = PATCHES.into_iter().map(|p| (p, 150));
    let large = PATCHES.into_iter().take(3).map(|p| (p, 500));
    for ((name, size, saddle, point), panels) in small.chain(large) {
        let surface = patch(60, size, point);
        let run = run(&surface, &options(panels));
        assert!(run.is_sound(), "{name}: {:?}", run.violations().first());
        assert_hexagons(name, &run.mesh);
        let measures = measure(&run.mesh);
        assert!(
            measures.planarity.max < 1e-12,
            "{name}: {}",
            measures.planarity.max
        );
        assert!(
            measures.clearance.min >= 0.2,
            "{name}: {}",
            measures.clearance.min
        );
        let concave = if saddle { measures.faces } else { 0 };
        assert_eq!(measures.faces_concave_simple, concave, "{name}");
        let off = deviation(&run.mesh, &surface);
        let beyond = run.beyond.as_ref().map(|b| deviation(&run.mesh, &b.smooth));
        let most = beyond.map_or(off.deviation_max, |b| b.deviation_max);
        assert!(most < 5e-3, "{name}: {most}");
        let told = run.statistics.classical.unwrap();
        assert_eq!(told.reversed_edges.unwrap() > 0, saddle, "{name}");
        assert_edge_offsets(name, &run.mesh);
    }
}

/// Largest angle between the planes of corresponding panels and height over them, mean edges.
fn worst_of_panels(mesh: &HexMesh, moved: &HexMesh) -> f64 {
    let normal = |m: &HexMesh, f| FacePlane::fit(&m.corners(f).collect::<Vec<_>>()).normal;
    let faces = mesh.topology().faces();
    let turned = faces.map(|f| normal(mesh, f).cross(&normal(moved, f)).norm());
    turned.fold(measure(moved).planarity.max, f64::max)
}

#[test]
fn inner_edges_of_cut_panels_keep_their_distance() {
    for (name, size, _, point) in PATCHES {
        let clip = MeshOptions {
            boundary: Boundary::Clip,
            ..options(150)
        };
        let run = run(&patch(60, size, point), &clip);
        // The cut may leave panels that are small; nothing else is wrong with them.
        let small = |v: &Violation| {
            matches!(
                v,
                Violation::SmallClearance { .. } | Violation::CollapsedEdge { .. }
            )
        };
        assert!(run.violations().iter().all(small), "{name}");
        let (mesh, given) = (&run.mesh, OffsetOptions::default());
        let found = edge_gauss_image(mesh, &given).unwrap();
        let t = mesh.topology();
        let rim = t.boundary_edges();
        assert_eq!(found.free_edges, rim.collect::<Vec<_>>(), "{name}");
        let layers = [0.003, 0.001, -0.001, -0.003].map(|share| {
            let distance = share * mesh.diagonal();
            let moved = layer(mesh, &found.image, distance, &given).unwrap();
            let error = worst_of_edges(mesh, &moved, distance, true);
            assert!(error < 1e-12, "{name}: {error:e} at {share}");
            assert!(worst_of_panels(mesh, &moved) < 1e-10, "{name} at {share}");
            moved
        });
        let [upper, .., lower] = &layers;
        let beams = beam_axes(lower, upper).unwrap();
        let inner = beams.iter().filter(|b| !t.is_boundary_edge(b.edge));
        assert!(
            inner.map(|b| b.torsion).fold(0.0, f64::max) < 1e-9,
            "{name}"
        );
        assert_eq!(panel_solids(lower, upper, 0.0).unwrap().len(), t.n_faces());
    }
}

/// Where the radii of curvature differ by nearly 3 the sign rule has edges that all but vanish:
/// they are no shorter than a quarter of the mean.
#[test]
fn edges_of_a_wide_cap_are_not_short() {
    let cap = patch(100, 0.69, PATCHES[1].3);
    let run = run(&cap, &options(500));
    assert!(run.is_sound(), "{:?}", run.violations().first());
    let (measures, t) = (measure(&run.mesh), run.mesh.topology());
    let lengths = t.edges().map(|e| run.mesh.edge_length(e));
    assert!(lengths.fold(f64::INFINITY, f64::min) > 0.2 * run.mesh.mean_edge());
    assert!(measures.clearance.min >= 0.2, "{}", measures.clearance.min);
    assert_edge_offsets("cap", &run.mesh);
}

#[test]
fn a_closed_convex_surface_has_twelve_pentagons_and_edge_offsets() {
    let surface =
        crate::common::shape_with("ellipsoid", &[("a", 1.2), ("b", 1.0), ("c", 0.9)], 4000);
    let run = run(&surface, &options(150));
    assert!(run.is_sound(), "{:?}", run.violations().first());
    let t = run.mesh.topology();
    let pentagons = t.faces().filter(|f| t.valence(*f) == 5).count();
    let hexagons = t.faces().filter(|f| t.valence(*f) == 6).count();
    assert!(pentagons >= 12 && pentagons + hexagons + 12 >= t.n_faces());
    assert_edge_offsets("ellipsoid", &run.mesh);
}

#[test]
fn minimal_surfaces_have_mean_curvature_zero_by_steiner() {
    for name in ["catenoid", "Enneper", "helicoid", "Scherk"] {
        let surface = named(name);
        let mut options = options(120);
        options.dual.minimal = true;
        let run = run(&surface, &options);
        assert!(run.is_sound(), "{name}: {:?}", run.violations().first());
        let found = edge_gauss_image(&run.mesh, &OffsetOptions::default()).unwrap();
        let image = found.image.mesh(&run.mesh);
        let curvatures = face_curvatures(&run.mesh, &image);
        let square: f64 = curvatures.iter().map(|c| c.mean.powi(2)).sum();
        let rms = (square / curvatures.len() as f64).sqrt() * surface.diagonal();
        assert!(rms < 1e-3 * 12f64.sqrt(), "{name}: {rms}");
        assert_edge_offsets(name, &run.mesh);
    }
}

#[test]
fn panels_are_closer_where_they_are_smaller() {
    let surface = named("catenoid");
    let rms = |panels| {
        let run = run(&surface, &options(panels));
        let beyond = run.beyond.unwrap();
        deviation(&run.mesh, &beyond.smooth).deviation_rms
    };
    let ratio = rms(60) / rms(240);
    assert!(
        ratio > 2.0,
        "four times as many panels, {ratio} times as close"
    );
}

#[test]
fn other_surfaces_are_refused_with_a_vertex() {
    let refused = |surface: &TriangleSurface| match mesh_surface(surface, &options(120), &Silent) {
        Err(PipelineError::Layout(LayoutError::Domain(error))) => error,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused"),
    };
    let plane = refused(&crate::common::shape("plane", 3000));
    assert!(matches!(plane, DomainError::Developable { .. }), "{plane}");
    assert!(plane.to_string().contains("vertex"), "{plane}");
    let cylinder = refused(&crate::common::shape("cylinder", 3000));
    assert!(
        matches!(cylinder, DomainError::Developable { .. }),
        "{cylinder}"
    );
    let torus = refused(&crate::common::shape("torus", 3000));
    assert!(
        matches!(torus, DomainError::MixedCurvature { .. }),
        "{torus}"
    );
    let catenoid = refused(&crate::common::shape("catenoid", 3000));
    assert!(
        matches!(catenoid, DomainError::Holes { loops: 2, .. }),
        "{catenoid}"
    );
    // More than a turn of a helicoid: normals come back.
    let turns = patch(60, 1.0, |u, v| {
        [u * (5.0 * v).cos(), u * (5.0 * v).sin(), 2.0 * v]
    });
    let overlapping = refused(&turns);
    assert!(
        matches!(overlapping, DomainError::ManyToOne { .. }),
        "{overlapping}"
    );
}

#[test]
fn vertices_are_not_moved_to_the_boundary() {
    let snap = MeshOptions {
        boundary: Boundary::Snap,
        ..options(120)
    };
    let Err(error) = mesh_surface(&named("catenoid"), &snap, &Silent) else {
        panic!("not refused");
    };
    assert!(matches!(error, PipelineError::Snap { .. }), "{error}");
}
