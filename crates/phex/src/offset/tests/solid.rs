//! Panels, beams and nodes between layers.

use super::fixtures::*;
use crate::offset::*;
use crate::optimise::tests::fixtures::planar_paraboloid;
use phex_mesh::{FlatFace, HexMesh, Topology};

fn layers(mesh: &HexMesh, from: f64, to: f64) -> [HexMesh; 2] {
    let image = face_gauss_image(mesh, &OffsetOptions::default()).unwrap();
    [from, to].map(|d| image.offset(mesh, d))
}

fn total(solids: &[PanelSolid]) -> f64 {
    solids.iter().map(PanelSolid::volume).sum()
}

#[test]
fn solids_are_closed_and_fill_the_shell() {
    for mesh in [
        cuboid(2.0, 2.0, 3.0),
        l_prism(),
        dodecahedron(),
        polar_dual(&spread_points(40)),
    ] {
        let [lower, upper] = layers(&mesh, 0.05, 0.2);
        let solids = panel_solids(&lower, &upper, 0.0).unwrap();
        let shell = upper.to_soup().volume() - lower.to_soup().volume();
        assert!((total(&solids) - shell).abs() < 1e-12 * shell);
        for solid in &solids {
            let soup = solid.surface();
            let topology = Topology::from_faces(soup.positions.len(), &soup.faces).unwrap();
            assert!(topology.boundary_loops().is_empty(), "watertight");
            assert_eq!(topology.euler_characteristic(), 2);
            // All sides are mitres: planar quadrilaterals.
            assert_eq!(soup.faces.len(), solid.bottom.len() + 2);
        }
    }
}

/// Neighbours meet in the mitre: each side has its twin, corner by corner.
#[test]
fn neighbours_share_their_mitre() {
    let mesh = dodecahedron();
    let [lower, upper] = layers(&mesh, 0.0, 0.1);
    let solids = panel_solids(&lower, &upper, 0.0).unwrap();
    let (topology, n) = (mesh.topology(), 5);
    for h in topology.half_edges() {
        let t = topology.twin(h).unwrap();
        let side = |h| {
            let solid = &solids[topology.face(h).index()];
            let i = topology
                .face_half_edges(topology.face(h))
                .position(|g| g == h)
                .unwrap();
            [i, (i + 1) % n].map(|k| (solid.bottom[k], solid.top[k]))
        };
        let ([a, b], [c, d]) = (side(h), side(t));
        assert_eq!((a, b), (d, c));
    }
}

#[test]
fn an_open_shell_has_solids_too() {
    let mesh = planar_paraboloid(12, 6);
    let [lower, upper] = layers(&mesh, 0.0, 0.02);
    for gap in [0.0, 0.004] {
        for solid in panel_solids(&lower, &upper, gap).unwrap() {
            let soup = solid.surface();
            let topology = Topology::from_faces(soup.positions.len(), &soup.faces).unwrap();
            assert!(topology.boundary_loops().is_empty());
            let thickness = solid.volume() / FlatFace::of(&lower, solid.face).area();
            assert!(thickness > 0.012 && thickness < 0.026, "{thickness}");
        }
    }
}

/// Between the edges of neighbouring panels lies the gap, in the plane of each face.
#[test]
fn gaps_have_their_width() {
    let mesh = dodecahedron();
    let [lower, upper] = layers(&mesh, 0.0, 0.1);
    let gap = 0.06;
    let solids = panel_solids(&lower, &upper, gap).unwrap();
    for solid in &solids {
        let outline = FlatFace::of(&lower, solid.face);
        for p in &solid.bottom {
            let to_edges = (0..5).map(|i| {
                let (a, b) = (outline.polygon[i], outline.polygon[(i + 1) % 5]);
                phex_mesh::polygon::point_segment_distance(outline.plane.project(*p), a, b)
            });
            let nearest = to_edges.fold(f64::INFINITY, f64::min);
            assert!((nearest - 0.5 * gap).abs() < 1e-13);
        }
        let soup = solid.surface();
        assert_eq!(soup.faces.len(), 7, "sides stay planar");
    }
}

/// A gap takes the same width everywhere, so a corner of 180 degrees stays one.
#[test]
fn a_straight_corner_keeps_straight() {
    let polygon = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
    let mesh = prism(&polygon, 1.0);
    // The two faces over the straight side lie in one plane.
    let image = face_gauss_image(&mesh, &OffsetOptions::default()).unwrap();
    let upper = image.offset(&mesh, 0.1);
    let solids = panel_solids(&mesh, &upper, 0.02).unwrap();
    let lid = &solids[1];
    assert!((lid.bottom[1] - phex_mesh::Vec3::new(1.0, 0.01, 1.0)).norm() < 1e-13);
}

#[test]
fn wrong_gaps_and_layers_are_refused() {
    let mesh = cuboid(1.0, 1.0, 1.0);
    let [lower, upper] = layers(&mesh, 0.0, 0.1);
    let wide = panel_solids(&lower, &upper, 1.5).unwrap_err();
    assert!(matches!(wide, OffsetError::Gap { gap: 1.5, most, .. } if most < 1.0 && most > 0.999));
    assert!(wide.to_string().contains("(model units)"), "{wide}");
    let negative = panel_solids(&lower, &upper, -0.1).unwrap_err();
    assert_eq!(negative, OffsetError::BadGap { gap: -0.1 });
    let inside_out = panel_solids(&upper, &lower, 0.0).unwrap_err();
    assert!(matches!(inside_out, OffsetError::Volume { volume, .. } if volume < 0.0));
    let other = panel_solids(&lower, &dodecahedron(), 0.0).unwrap_err();
    assert_eq!(other, OffsetError::Connectivity);
}

#[test]
fn one_soup_for_all_solids() {
    let mesh = dodecahedron();
    let [lower, upper] = layers(&mesh, 0.0, 0.1);
    let solids = panel_solids(&lower, &upper, 0.01).unwrap();
    let soup = joined(&solids);
    let topology = Topology::from_faces(soup.positions.len(), &soup.faces).unwrap();
    assert_eq!(topology.components().1, 12);
    assert!((soup.volume() - total(&solids)).abs() < 1e-13);
}

/// Between a mesh and its offset, edges and node axes at both ends lie in one plane.
#[test]
fn beams_have_no_torsion() {
    let mesh = polar_dual(&spread_points(40));
    let [lower, upper] = layers(&mesh, 0.0, 0.1);
    for beam in beam_axes(&lower, &upper).unwrap() {
        assert!(beam.torsion < 1e-12, "{:?}", beam);
        let along = (beam.ends[1] - beam.ends[0]).normalize();
        assert!(beam.plane_normal.dot(&along).abs() < 1e-14);
    }
    for node in node_axes(&lower, &upper).unwrap() {
        let reached = node.base + node.direction * node.length;
        assert!((reached - upper.position(node.vertex)).norm() < 1e-14);
    }
    let mut twisted = upper.clone();
    let v = phex_mesh::VertexId::new(3);
    twisted.positions[v] += phex_mesh::Vec3::new(0.03, 0.02, -0.03);
    let beams = beam_axes(&lower, &twisted).unwrap();
    assert!(beams.iter().any(|b| b.torsion > 0.05));
}
