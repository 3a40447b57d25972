//! Lattice, cells and panels: known answers on simple surfaces, topology on all.

use crate::common::{Stages, figures, genus_two, punched_plane, shape, valences};
use crate::directions::turns::{cones, smallest_turns};
use crate::directions::{DirectionOptions, Directions};
use crate::layout::cells::clusters::seeds;
use crate::layout::cells::voronoi::{PartCells, UNREACHED, grow};
use crate::layout::lattice::boundary::{Pin, PinnedTo};
use crate::layout::lattice::charted::ChartedSurface;
use crate::layout::lattice::dislocations::annihilate;
use crate::layout::lattice::eisenstein::{Charts, Eisenstein, Plane};
use crate::layout::lattice::seamless::{OffsetSystem, Offsets};
use crate::layout::lattice::{polish, waves};
use crate::layout::seeds::Seed;
use crate::layout::{Layout, LayoutOptions, VertexKind, place_seeds};
use crate::progress::Silent;
use phex_mesh::{FaceId, PerEdge, PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// A flat square whose charts all have the x axis as their axis, and 12 lattice spacings to its
/// side.
struct FlatLattice {
    stages: Stages,
    charts: Charts,
    /// No vertex is pinned to a row along a boundary.
    free: PerVertex<Option<Pin>>,
}

const SPACINGS: f64 = 12.0;

impl FlatLattice {
    fn new() -> Self {
        let panels = (SPACINGS * SPACINGS / crate::layout::lattice::eisenstein::CELL) as usize;
        let mut stages = Stages::new(&shape("plane", 500), panels);
        let angle = x_axis(&stages.surface, &stages.directions);
        let (topology, directions) = (stages.surface.topology(), &mut stages.directions);
        directions.turn = smallest_turns(topology, &directions.intrinsic, &angle);
        directions.cone = cones(topology, &directions.intrinsic, &angle, &directions.turn);
        directions.angle = angle;
        let charts = Charts::new(stages.topology(), &stages.directions);
        let free = PerVertex::filled(stages.topology().n_vertices(), None);
        Self {
            stages,
            charts,
            free,
        }
    }

    fn topology(&self) -> &Topology {
        self.stages.topology()
    }

    /// Vector from the middle of the square to a vertex, in lattice spacings.
    fn at(&self, v: VertexId) -> Plane {
        let p = self.stages.surface.positions()[v] / self.stages.length;
        Plane::new(p.x, p.y)
    }

    fn charted(&self) -> ChartedSurface<'_> {
        ChartedSurface {
            topology: self.topology(),
            mesh: &self.stages.directions.intrinsic,
            charts: &self.charts,
            pins: &self.free,
        }
    }

    /// Offsets of the lattice that has a point at `origin`.
    fn exact(&self, origin: Plane) -> PerVertex<Plane> {
        PerVertex::from_fn(self.topology().n_vertices(), |v| {
            let z = origin - self.at(v);
            z - Eisenstein::nearest(z).to_plane()
        })
    }

    /// Burgers vector of a triangle: all charts agree, so jumps simply add up.
    fn burgers(&self, jump: &PerEdge<Eisenstein>, f: FaceId) -> Eisenstein {
        let topology = self.topology();
        topology
            .face_half_edges(f)
            .fold(Eisenstein::ZERO, |sum, h| {
                sum + topology.along(h, jump[topology.edge(h)])
            })
    }

    fn dislocations(&self, jump: &PerEdge<Eisenstein>) -> usize {
        let faces = self.topology().faces();
        faces
            .filter(|&f| self.burgers(jump, f) != Eisenstein::ZERO)
            .count()
    }
}

/// The lattice that all tests share.
fn flat() -> &'static FlatLattice {
    static FLAT: OnceLock<FlatLattice> = OnceLock::new();
    FLAT.get_or_init(FlatLattice::new)
}

/// The polar angle of the x axis at every vertex.
fn x_axis(surface: &TriangleSurface, directions: &Directions) -> PerVertex<f64> {
    let topology = surface.topology();
    PerVertex::from_fn(topology.n_vertices(), |v| {
        let h = topology.outgoing(v).next().unwrap();
        let e = surface.positions()[topology.target(h)] - surface.positions()[v];
        directions.intrinsic.polar(topology, h) - e.y.atan2(e.x)
    })
}

/// Distance between two lattice offsets modulo the lattice.
fn apart(a: Plane, b: Plane) -> f64 {
    (a - b - Eisenstein::nearest(a - b).to_plane()).norm()
}

#[test]
fn charts_of_a_flat_square_do_not_turn() {
    let flat = flat();
    for e in flat.topology().edges() {
        let [i, j] = flat.topology().edge_vertices(e);
        let transition = flat.charts.edge(e);
        assert_eq!(transition.turn, 0);
        assert!((transition.offset - (flat.at(j) - flat.at(i))).norm() < 1e-3);
        let z = Plane::new(0.3, -0.2);
        assert!((transition.inverse().apply(transition.apply(z)) - z).norm() < 1e-12);
    }
}

/// A polish that moves a lattice which fits already is caught.
#[test]
fn polishing_keeps_an_exact_lattice() {
    let flat = flat();
    let exact = flat.exact(Plane::new(0.17, 0.31));
    let mut polished = exact.clone();
    polish::polish(&flat.charted(), &mut polished, 50);
    for v in flat.topology().vertices() {
        assert!(apart(exact[v], polished[v]) < 2e-3, "{v}");
    }
}

/// ... and one that does not bring a disturbed lattice back, too.
#[test]
fn polishing_mends_a_disturbed_lattice() {
    let flat = flat();
    let exact = flat.exact(Plane::new(0.0, 0.0));
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut shift = || random.random_range(-0.2..0.2);
    let mut position = exact.map(|z| z + Plane::new(shift(), shift()));
    let distortion = |z: &PerVertex<Plane>| {
        let offsets = Offsets::rounded(&flat.charted(), z.clone());
        let all = offsets.distortion(&flat.charted());
        all.iter().sum::<f64>() / all.len() as f64
    };
    let before = distortion(&position);
    polish::polish(&flat.charted(), &mut position, 200);
    let after = distortion(&position);
    assert!(after < 0.05 * before, "{before} {after}");
}

/// Diffusion from a random start finds a lattice: nearly everywhere the offsets fit.
#[test]
fn waves_find_the_lattice_of_a_flat_square() {
    let flat = flat();
    let position = waves::diffuse(&flat.charted(), 4, &Silent);
    let offsets = Offsets::rounded(&flat.charted(), position);
    let mut distortion = offsets.distortion(&flat.charted()).into_vec();
    distortion.sort_by(f64::total_cmp);
    let median = distortion[distortion.len() / 2];
    assert!(median < 0.15, "{median}");
}

/// The exact lattice gives the exact panelling: hexagons only, from the second row on (rim cells
/// are evened out).
#[test]
fn an_exact_lattice_gives_regular_hexagons() {
    let flat = flat();
    let position = flat.exact(Plane::new(0.0, 0.0));
    let offsets = Offsets::rounded(&flat.charted(), position);
    assert_eq!(flat.dislocations(&offsets.jump), 0);
    let layout = flat
        .stages
        .panelling(&seeds(&flat.charted(), &offsets))
        .unwrap();
    let topology = layout.mesh.topology();
    let mut interior = 0;
    let at_rim = |f: FaceId| {
        let sides = topology.face_half_edges(f);
        sides
            .map(|h| topology.across(h))
            .any(|g| g.is_none_or(|g| topology.is_boundary_face(g)))
    };
    for f in topology.faces().filter(|&f| !at_rim(f)) {
        interior += 1;
        assert_eq!(topology.valence(f), 6);
        let centre = layout.face_point[f] / flat.stages.length;
        assert!(apart(Plane::new(centre.x, centre.y), Plane::new(0.0, 0.0)) < 0.1);
    }
    let cells = SPACINGS * SPACINGS / crate::layout::lattice::eisenstein::CELL;
    assert!(f64::from(interior) > 0.35 * cells, "{interior} of {cells}");
}

/// Random jumps make pairs of opposite dislocations; all of them must find an opposite or the
/// boundary.
#[test]
fn annihilation_leaves_no_dislocation() {
    let flat = flat();
    let mut offsets = Offsets::rounded(&flat.charted(), flat.exact(Plane::new(0.1, 0.0)));
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..30 {
        let e = phex_mesh::EdgeId::new(random.random_range(0..flat.topology().n_edges() as u32));
        offsets.jump[e] += Eisenstein { a: 1, b: 0 }.rotated(random.random_range(0..6));
    }
    let before = flat.dislocations(&offsets.jump);
    let (done, _) = annihilate(&flat.charted(), &mut offsets.jump, f64::INFINITY);
    assert!(
        before > 40 && done.dislocations == before && done.kept == 0,
        "{done:?}"
    );
    assert_eq!(flat.dislocations(&offsets.jump), 0);
}

/// Dislocations in the middle of the square meet each other: nothing crosses the boundary, and the
/// sum stays 0.
#[test]
fn annihilation_within_reach_conserves_the_burgers_vector() {
    let flat = flat();
    let topology = flat.topology();
    let exact = Offsets::rounded(&flat.charted(), flat.exact(Plane::new(0.1, 0.0)));
    let mut jump = exact.jump.clone();
    let middle = |e: &phex_mesh::EdgeId| {
        topology
            .edge_vertices(*e)
            .iter()
            .all(|v| flat.at(*v).norm() < 2.5)
    };
    for (k, e) in topology.edges().filter(middle).step_by(11).enumerate() {
        jump[e] += Eisenstein { a: 1, b: 0 }.rotated((k % 6) as u8);
    }
    let total = |jump: &PerEdge<Eisenstein>| {
        let faces = topology.faces();
        faces.fold(Eisenstein::ZERO, |sum, f| sum + flat.burgers(jump, f))
    };
    let before = (flat.dislocations(&jump), total(&jump));
    let (done, _) = annihilate(&flat.charted(), &mut jump, 3.0);
    assert!(
        before.0 > 10 && done.moved > 0 && done.kept == 0,
        "{done:?}"
    );
    assert_eq!(total(&jump), before.1);
    for e in topology.boundary_edges() {
        assert_eq!(jump[e], exact.jump[e]);
    }
}

/// Zero length: nothing moves.
#[test]
fn annihilation_keeps_to_its_length() {
    let flat = flat();
    let mut offsets = Offsets::rounded(&flat.charted(), flat.exact(Plane::new(0.1, 0.0)));
    let e = phex_mesh::EdgeId::new(flat.topology().n_edges() as u32 / 2);
    offsets.jump[e] += Eisenstein { a: 0, b: 1 };
    let jump = offsets.jump.clone();
    let (done, _) = annihilate(&flat.charted(), &mut offsets.jump, 0.0);
    assert_eq!((done.moved, done.kept), (0, 2));
    assert_eq!(jump, offsets.jump);
}

/// With exact jumps the linear solve finds the lattice from any start near it, up to a translation.
#[test]
fn the_solve_finds_the_lattice_of_exact_jumps() {
    let flat = flat();
    let topology = flat.topology();
    let exact = flat.exact(Plane::new(0.2, 0.1));
    let jump = Offsets::rounded(&flat.charted(), exact.clone()).jump;
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut shift = || random.random_range(-0.3..0.3);
    let start = exact.map(|z| z + Plane::new(shift(), shift()));
    let system = OffsetSystem::new(flat.charted()).unwrap();
    let solved = system.solve(&jump, &start);
    let translation = solved[VertexId::new(0)] - exact[VertexId::new(0)];
    for v in topology.vertices() {
        assert!((solved[v] - exact[v] - translation).norm() < 5e-3);
    }
    assert!(translation.norm() < 0.1);
}

/// Pins ask for the real form of the system; one that weighs nothing changes no offset.
#[test]
fn the_real_form_agrees_with_the_complex_one() {
    let flat = flat();
    let topology = flat.topology();
    let start = flat.exact(Plane::new(0.2, 0.1));
    let jump = Offsets::rounded(&flat.charted(), start.clone()).jump;
    let mut weightless = flat.free.clone();
    weightless[VertexId::new(3)] = Some(Pin {
        wave: 0,
        normal: Plane::new(0.6, 0.8),
        weight: 0.0,
        to: PinnedTo::HalfRow,
    });
    let [complex, real] = [&flat.free, &weightless].map(|pins| {
        let charted = ChartedSurface {
            pins,
            ..flat.charted()
        };
        let system = OffsetSystem::new(charted).unwrap();
        system.solve(&jump, &start)
    });
    for v in topology.vertices() {
        assert!((complex[v] - real[v]).norm() < 1e-9);
    }
}

/// Distances of a front that follows edges only are up to 15 % too long.
#[test]
fn voronoi_distances_are_straight_on_a_plane() {
    let flat = flat();
    let (topology, mesh) = (flat.topology(), &flat.stages.directions.intrinsic);
    let centre = topology
        .vertices()
        .min_by(|a, b| flat.at(*a).norm().total_cmp(&flat.at(*b).norm()))
        .unwrap();
    let cells = grow(topology, mesh, &[Seed::at(centre)]);
    for v in topology.vertices() {
        let straight = (flat.at(v) - flat.at(centre)).norm();
        let error = cells.distance[v] - straight;
        assert!(
            error > -1e-3 && error < 0.02 * straight + 1e-3,
            "{v}: {error} {straight}"
        );
        assert_eq!(cells.label[v], 0);
    }
}

#[test]
fn voronoi_labels_name_the_nearest_seed() {
    let flat = flat();
    let (topology, mesh) = (flat.topology(), &flat.stages.directions.intrinsic);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut vertex = || VertexId::new(random.random_range(0..topology.n_vertices() as u32));
    let sources: Vec<Seed> = (0..40).map(|_| Seed::at(vertex())).collect();
    let cells = grow(topology, mesh, &sources);
    for v in topology.vertices() {
        let to = |s: &Seed| (flat.at(v) - flat.at(s.vertex)).norm();
        let nearest = sources.iter().map(to).fold(f64::INFINITY, f64::min);
        let named = to(&sources[cells.label[v] as usize]);
        // Half an edge: a front may have to walk round another one.
        assert!(named < nearest + 0.1, "{v}: {named} {nearest}");
    }
    let again = grow(topology, mesh, &sources);
    assert_eq!(cells.label, again.label);
    assert_eq!(cells.distance, again.distance);
}

#[test]
fn cells_of_a_part_are_those_of_all_that_it_holds() {
    let flat = flat();
    let (topology, mesh) = (flat.topology(), &flat.stages.directions.intrinsic);
    let all: Vec<VertexId> = topology.vertices().collect();
    let right = |v: &VertexId| flat.at(*v).re > 0.0;
    let part: Vec<VertexId> = all.iter().copied().filter(right).collect();
    let seeds = [part[0], part[part.len() / 2]].map(Seed::at);
    let mut cells = PartCells::new(topology, mesh);
    let grown = cells.grow(&seeds, &part);
    assert_eq!(grown[0], (0, 0.0));
    assert!(grown.iter().all(|(label, _)| *label != UNREACHED));
    // What was grown before leaves nothing behind.
    let whole = grow(topology, mesh, &seeds);
    let again = cells.grow(&seeds, &all);
    for (v, (label, distance)) in all.iter().zip(again) {
        assert_eq!((label, distance), (whole.label[*v], whole.distance[*v]));
    }
    assert_eq!(cells.grow(&seeds, &part), grown);
}

/// Interior vertices of degree 3, boundary vertices of at most two panels, every vertex of the
/// right kind.
fn check_panels(name: &str, layout: &Layout) {
    let topology = layout.mesh.topology();
    for v in topology.vertices() {
        let expected = match layout.vertex_kind[v] {
            VertexKind::Interior => (false, 3),
            VertexKind::Boundary => (true, topology.face_degree(v).clamp(1, 2)),
            VertexKind::BoundaryCorner => (true, 1),
        };
        let found = (topology.is_boundary_vertex(v), topology.face_degree(v));
        assert_eq!(found, expected, "{name}: {v}");
    }
    for f in topology.faces() {
        assert!(topology.valence(f) >= 3, "{name}: {f}");
        assert!((layout.face_normal[f].norm() - 1.0).abs() < 1e-9);
        assert!(layout.face_length[f] > 0.0);
    }
}

#[test]
fn panels_have_the_topology_of_the_surface() {
    let cases = [
        ("sphere", shape("sphere", 1000), (2, 0)),
        ("torus", shape("torus", 800), (0, 0)),
        ("genus two", genus_two(), (-2, 0)),
        ("holes", punched_plane(0.25), (-1, 3)),
        ("holes smaller than panels", punched_plane(0.06), (-1, 3)),
        ("annulus", shape("catenoid", 800), (0, 2)),
        ("disc", shape("monkey-saddle", 800), (1, 1)),
    ];
    for (name, surface, expected) in cases {
        let stages = Stages::new(&surface, 60);
        assert_eq!(figures(stages.topology()), expected, "{name}");
        let layout = stages.layout();
        assert_eq!(figures(layout.mesh.topology()), expected, "{name}");
        check_panels(name, &layout);
    }
}

/// A corner of the plan is a corner of one panel, at the same place.
#[test]
fn sharp_corners_are_corners_of_panels() {
    for name in ["plane", "wave", "b-spline", "hyperbolic-paraboloid"] {
        let stages = Stages::new(&shape(name, 1100), 80);
        assert_eq!(stages.corners.len(), 4, "{name}");
        let layout = stages.layout();
        check_panels(name, &layout);
        let mut corners: Vec<Vec3> = Vec::new();
        for (v, kind) in layout.vertex_kind.enumerate() {
            if *kind == VertexKind::BoundaryCorner {
                corners.push(layout.mesh.position(v));
            }
        }
        assert_eq!(corners.len(), 4, "{name}");
        for c in &stages.corners {
            assert!(corners.contains(&stages.surface.positions()[*c]), "{name}");
        }
    }
}

/// A torus has no cones, so its seamless lattice is all hexagons; dislocations that stay are 5|7
/// pairs.
#[test]
fn a_torus_is_all_hexagons() {
    let stages = Stages::new(&shape("torus", 2000), 150);
    assert!(stages.directions.cone.iter().all(|c| *c == 0));
    let placed = stages.seeds();
    assert_eq!(placed.statistics.annihilation.kept, 0);
    let layout = stages.panelling(&placed.seeds).unwrap();
    let count = layout.mesh.topology().n_faces();
    assert_eq!(valences(&layout.mesh), BTreeMap::from([(6, count)]));
}

/// Euler: twelve pentagons, when there is nothing else than hexagons.
#[test]
fn an_ellipsoid_has_twelve_pentagons() {
    let stages = Stages::new(&shape("ellipsoid", 2000), 150);
    let layout = stages.layout();
    let count = layout.mesh.topology().n_faces();
    assert_eq!(
        valences(&layout.mesh),
        BTreeMap::from([(5, 12), (6, count - 12)])
    );
}

#[test]
fn the_number_of_panels_is_near_what_the_length_says() {
    for name in ["torus", "ellipsoid", "wave"] {
        let panels = Stages::new(&shape(name, 2100), 150).layout().mesh;
        let count = panels.topology().n_faces() as f64;
        assert!((count / 150.0 - 1.0).abs() < 0.25, "{name}: {count}");
    }
}

#[test]
fn the_same_seed_gives_the_same_seeds() {
    let stages = Stages::new(&shape("wave", 1100), 80);
    let place = |seed| {
        let options = LayoutOptions {
            seed,
            ..Default::default()
        };
        place_seeds(stages.topology(), &stages.directions, &options, &Silent)
            .unwrap()
            .seeds
    };
    assert_eq!(place(0), place(0));
    assert_ne!(place(0), place(1));
}

/// One panel for a torus cannot be a disc with three panels at every vertex; this must be said, not
/// forced.
#[test]
fn impossible_panellings_are_refused() {
    let stages = Stages::new(&shape("torus", 1000), 60);
    let seeds = stages.seeds().seeds;
    let message = |seeds: &[Seed]| stages.panelling(seeds).err().map(|e| e.to_string());
    assert!(message(&[]).unwrap().contains("no panel"));
    if let Some(text) = message(&seeds[..1]) {
        assert!(text.contains("smaller panels"), "{text}");
    }
}

/// Where a lattice without dislocations is strained too much, fewer come back than any bound on the
/// length of their ways keeps.
#[test]
fn dislocations_come_back_where_strain_pulls() {
    let even = DirectionOptions {
        conformal_limit: 0.0,
        ..Default::default()
    };
    let stages = Stages::with(&shape("enneper", 3000), 300, &even);
    let reached = |options: LayoutOptions| {
        let placed = place_seeds(stages.topology(), &stages.directions, &options, &Silent).unwrap();
        let reached = placed.statistics;
        (reached.distortion_p95, reached.annihilation.kept)
    };
    let placed = |annihilation_length: Option<f64>, max_distortion: f64| {
        reached(LayoutOptions {
            annihilation_length,
            max_distortion,
            ..Default::default()
        })
    };
    let [all, none] = [None, Some(0.0)].map(|length| placed(length, f64::MAX));
    assert!(
        all.1 == 0 && none.1 > 10 && all.0 > none.0,
        "{all:?} {none:?}"
    );
    let bound = 0.5 * (all.0 + none.0);
    let (distortion, kept) = placed(None, bound);
    assert!(distortion <= bound && kept > 0, "{distortion} {kept}");
    let by_length = (1..40).map(|k| placed(Some(0.25 * f64::from(k)), f64::MAX));
    let fewest = by_length.filter(|(d, _)| *d <= bound).map(|(_, kept)| kept);
    let fewest = fewest.min().unwrap();
    assert!(kept < fewest, "{kept} against {fewest}");

    let by_pull = [8.0, 4.0, 2.0, 1.0].map(|most| {
        reached(LayoutOptions {
            max_distortion: f64::MAX,
            max_pull: Some(most),
            ..Default::default()
        })
    });
    assert!(
        by_pull.is_sorted_by(|a, b| a.1 <= b.1 && a.0 >= b.0 - 0.02),
        "{by_pull:?}"
    );
    assert!(by_pull[3].1 > 0 && by_pull[3].0 < all.0, "{by_pull:?}");
}
