//! A search cures what was spoiled, changes nothing where there is nothing to cure, and leaves the
//! rest as it was.

use super::*;
use crate::optimise::{BoundaryHold, OptimiseOptions, SurfaceTarget};
use crate::progress::Silent;
use crate::quality::{Assessment, Judge, Limits, Merit, References};
use crate::trim::Boundary;
use crate::{Effort, MeshOptions, PanelSize, mesh_surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{BoundaryCurve, PerVertex, TriangleSurface, Vec3, VertexId};
use std::sync::OnceLock;

/// A wave, and a sound mesh of it.
fn wave() -> &'static (TriangleSurface, HexMesh) {
    static WAVE: OnceLock<(TriangleSurface, HexMesh)> = OnceLock::new();
    WAVE.get_or_init(|| meshed("wave", &[]))
}

fn meshed(name: &str, parameters: &[(&str, f64)]) -> (TriangleSurface, HexMesh) {
    let triangulation = TriangulationOptions {
        triangles: 3000,
        ..Default::default()
    };
    let shape = Shape::from_name(name, parameters).unwrap();
    let surface = triangulate(&shape, &triangulation).unwrap();
    let options = MeshOptions {
        size: PanelSize::Panels(150),
        effort: Effort::Draft,
        ..Default::default()
    };
    let run = mesh_surface(&surface, &options, &Silent).unwrap();
    assert!(run.is_sound());
    (run.target, run.mesh)
}

/// Searches a mesh of the wave with a largest deviation.
fn searched(mesh: &HexMesh, deviation: f64) -> Searched {
    searched_between(&wave().0, mesh, deviation, &[])
}

/// The same of any surface, between mirror planes.
fn searched_between(
    surface: &TriangleSurface,
    mesh: &HexMesh,
    deviation: f64,
    mirrors: &[Vec3],
) -> Searched {
    let limits = Limits::new(Some(deviation), Some(Boundary::Snap));
    let options = OptimiseOptions {
        max_deviation: Some(deviation),
        ..Default::default()
    };
    search(
        mesh.clone(),
        &Site {
            judge: &Judge::new(surface, References::default(), limits),
            close_to: &SurfaceTarget::new(surface),
            hold: Some(BoundaryHold {
                curves: BoundaryCurve::of(surface).unwrap(),
                corners: Vec::new(),
            }),
            mirrors,
            areas: None,
            options: &options,
        },
        &Silent,
    )
}

fn bits(mesh: &HexMesh) -> (Vec<[u64; 3]>, Vec<Vec<u32>>) {
    let place = |p: &Vec3| [p.x, p.y, p.z].map(f64::to_bits);
    let places = mesh.positions.iter().map(place).collect();
    (places, mesh.topology().face_lists())
}

/// What a mesh is compared by.
fn merit(mesh: &HexMesh, deviation: f64) -> Merit {
    let surface = &wave().0;
    let limits = Limits::new(Some(deviation), Some(Boundary::Snap));
    let any = vec![0.0; mesh.topology().n_faces()];
    Judge::new(surface, References::default(), limits)
        .whole(mesh, &any)
        .merit
}

/// The largest distance between the mesh and the wave, over the diagonal.
fn farthest(mesh: &HexMesh) -> f64 {
    let judged = searched(mesh, 5e-3).judgement;
    5e-3 * judged.of_face.iter().map(|f| f.off).fold(0.0, f64::max)
}

/// The mesh with an inner vertex moved nearly onto one of its neighbours.
fn squeezed(mesh: &HexMesh) -> (HexMesh, Vec3) {
    let topology = mesh.topology();
    let at_rim = |f: FaceId| topology.is_boundary_face(f);
    let inner = |v: &VertexId| {
        let mut faces = topology.faces_at(*v);
        !topology.is_boundary_vertex(*v) && !faces.any(at_rim)
    };
    let v = topology.vertices().find(inner).unwrap();
    squeezed_at(mesh, v)
}

fn squeezed_at(mesh: &HexMesh, v: VertexId) -> (HexMesh, Vec3) {
    let w = mesh.topology().neighbours(v)[0];
    let mut positions: Vec<Vec3> = mesh.positions.as_slice().to_vec();
    positions[v.index()] += (mesh.position(w) - mesh.position(v)) * 0.97;
    let at = positions[v.index()];
    (mesh.with_positions(PerVertex::from_vec(positions)), at)
}

#[test]
fn a_mesh_without_defects_stays_as_it_is() {
    let mesh = &wave().1;
    let result = searched(mesh, 5e-3);
    assert_eq!(bits(&result.mesh), bits(mesh));
    let nothing = SearchSummary::default();
    assert_eq!(result.summary, nothing);
    assert!(result.judgement.merit.is_within());
}

#[test]
fn a_spoiled_place_is_cured_and_the_rest_keeps_its_bytes() {
    let mesh = &wave().1;
    let (spoiled, at) = squeezed(mesh);
    let result = searched(&spoiled, 5e-3);
    assert!(result.summary.kept > 0, "{:?}", result.summary);
    assert_eq!(result.summary.left, 0);
    assert!(result.judgement.merit.is_within());
    // Far from it every vertex of before is there, to the last bit.
    let far = |p: &&Vec3| (**p - at).norm() > 8.0 * mesh.mean_edge();
    let (places, _) = bits(&result.mesh);
    let before: Vec<&Vec3> = mesh.positions.iter().filter(far).collect();
    assert!(before.len() > 50);
    for p in before {
        assert!(places.contains(&[p.x, p.y, p.z].map(f64::to_bits)));
    }
}

/// Corners in a mirror plane are those of their images, too: they stay where they are, and slide
/// along the boundary where there is no plane.
#[test]
fn corners_in_a_mirror_plane_rest() {
    let (surface, mesh) = wave();
    let least = |p: &PerVertex<Vec3>| p.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let shift = Vec3::x() * least(surface.positions());
    let surface = surface.mapped(|p| p - shift);
    let near = 1e-6 * mesh.diagonal();
    let into_plane = |p: &Vec3| match p - shift {
        q if q.x.abs() < near => Vec3::new(0.0, q.y, q.z),
        q => q,
    };
    let mesh = mesh.mapped(into_plane);
    let topology = mesh.topology();
    let in_plane = |v: &VertexId| mesh.position(*v).x == 0.0;
    let beside = |v: &VertexId| !in_plane(v) && topology.neighbours(*v).iter().any(in_plane);
    let inner = |v: &VertexId| beside(v) && !topology.is_boundary_vertex(*v);
    let v = topology.vertices().filter(inner).nth(3).unwrap();
    let spoiled = squeezed_at(&mesh, v).0;
    let rests = |mirrors: &[Vec3]| {
        let result = searched_between(&surface, &spoiled, 5e-3, mirrors);
        assert!(result.summary.kept > 0, "{:?}", result.summary);
        let (places, _) = bits(&result.mesh);
        let mut held = topology.vertices().filter(in_plane);
        held.all(|v| places.contains(&mesh.position(v).data.0[0].map(f64::to_bits)))
    };
    assert!(rests(&[Vec3::x()]));
    assert!(!rests(&[]));
}

#[test]
fn a_change_that_is_no_better_is_taken_back() {
    let mesh = &wave().1;
    // A limit that so many panels can't keep to everywhere: what is tried in vain must not make the
    // mesh worse.
    let limit = 0.6 * farthest(mesh);
    let result = searched(mesh, limit);
    let before = merit(mesh, limit);
    assert!(before.outside > 0.0);
    assert!(!before.is_less(&result.judgement.merit));
}

#[test]
fn one_bad_change_spoils_few_others() {
    let mut looks = 0;
    let mut without = |bad: &[usize], count| {
        looks = 0;
        first_better(count, |run| {
            looks += 1;
            !bad.iter().any(|k| run.contains(k))
        })
    };
    assert_eq!(without(&[], 3), [Some(true); 3]);
    assert_eq!(without(&[], 0), []);
    assert_eq!(without(&[3], 4), [Some(true), Some(true), None, None]);
    assert_eq!(without(&[0], 4), [Some(false), Some(true), None, None]);
    assert_eq!(without(&[0, 1], 2), [Some(false); 2]);
    let kept = without(&[1000], 2000);
    assert_eq!(kept.iter().filter(|k| **k == Some(true)).count(), 1000);
    assert_eq!(looks, 2);
}

/// The mesh with two inner panels merged into one.
fn without_an_edge(mesh: &HexMesh) -> HexMesh {
    let topology = mesh.topology();
    let inner = |f: FaceId| !topology.is_boundary_face(f);
    let faces = |e| topology.faces_beside(e);
    let mut edges = topology
        .edges()
        .filter(|e| faces(*e).is_some_and(|f| f.into_iter().all(inner)));
    let edge = edges.nth(60).unwrap();
    let [f, g] = faces(edge).unwrap();
    let ends = topology.edge_vertices(edge);
    // The ring of `f` from the edge's end on, then that of `g`; the ends are corners of none.
    let open = |f: FaceId| {
        let ring = topology.face_vertices(f);
        let n = ring.len();
        let is_end = |i: usize| ends.contains(&ring[i % n]);
        let first = (0..n).find(|i| is_end(*i) && is_end(i + n - 1)).unwrap();
        (1..n - 1).map(move |i| ring[(first + i) % n])
    };
    let others = topology.faces().filter(|h| ![f, g].contains(h));
    let others = others.map(|h| topology.face_vertices(h).to_vec());
    let all: Vec<Vec<VertexId>> = others.chain([open(f).chain(open(g)).collect()]).collect();
    let kept: Vec<VertexId> = topology.vertices().filter(|v| !ends.contains(v)).collect();
    let number = |v: &VertexId| kept.binary_search(v).ok().map(|k| k as u32);
    let lists: Vec<Vec<u32>> = all
        .iter()
        .map(|f| f.iter().filter_map(number).collect())
        .collect();
    HexMesh::new(kept.iter().map(|v| mesh.position(*v)).collect(), &lists).unwrap()
}

#[test]
fn panels_are_split_where_the_surface_stands_off() {
    let merged = without_an_edge(&wave().1);
    let limit = 0.9 * farthest(&wave().1);
    let (before, result) = (merit(&merged, limit), searched(&merged, limit));
    let panels = [&merged, &result.mesh].map(|m| m.topology().n_faces());
    assert!(result.summary.kept > 0, "{:?}", result.summary);
    assert!(panels[1] > panels[0], "{panels:?} {:?}", result.summary);
    let after = &result.judgement.merit;
    assert!(before.invalid > 0.0 && after.invalid == 0.0, "{after:?}");
}

#[test]
fn nothing_is_tried_where_most_panels_are_broken() {
    let mesh = &wave().1;
    // Every second vertex is moved by half of an edge: hardly a panel is left planar.
    let lifted = mesh
        .positions
        .enumerate()
        .map(|(v, p)| match v.index() % 2 {
            0 => p + Vec3::z() * (0.5 * mesh.mean_edge()),
            _ => *p,
        });
    let crumpled = mesh.with_positions(PerVertex::from_vec(lifted.collect()));
    let result = searched(&crumpled, 5e-3);
    assert!(result.summary.is_hopeless && result.summary.left > 0);
    assert_eq!((result.summary.sweeps, result.summary.tried), (0, 0));
    assert_eq!(bits(&result.mesh), bits(&crumpled));
    assert!(result.judgement.merit.invalid > 0.0);
}

/// The judge's surface has bumps that panels are not drawn to: no change helps there.
#[test]
fn a_search_ends_where_nothing_is_found() {
    let (surface, mesh) = wave();
    let farthest = farthest(mesh) * mesh.diagonal();
    let middle = surface.positions().iter().sum::<Vec3>() / surface.positions().len() as f64;
    let bump = |p: &Vec3| {
        let near = (p - middle).norm() < 1.5 * mesh.mean_edge();
        p + Vec3::z() * if near { 6.0 * farthest } else { 0.0 }
    };
    let topology = surface.topology();
    let corners = topology.faces().map(|f| topology.face_vertices(f));
    let triangles: Vec<[u32; 3]> = corners
        .map(|t| [0, 1, 2].map(|k| t[k].index() as u32))
        .collect();
    let places = surface.positions().iter().map(bump).collect();
    let bumpy = TriangleSurface::new(places, &triangles).unwrap();
    let deviation = 2.0 * farthest / mesh.diagonal();
    let site = Site {
        judge: &Judge::new(
            &bumpy,
            References::default(),
            Limits::new(Some(deviation), None),
        ),
        close_to: &SurfaceTarget::new(surface),
        hold: None,
        mirrors: &[],
        areas: None,
        options: &OptimiseOptions::default(),
    };
    let found = search(mesh.clone(), &site, &Silent).summary;
    assert!(found.left > 2, "{found:?}");
    // As many sweeps after the last change, and between two of them, as there are widths.
    assert!(found.sweeps <= (found.kept + 1) * RINGS.len(), "{found:?}");
    assert!(found.sweeps < SWEEPS, "{found:?}");
}

#[test]
fn the_same_for_any_number_of_threads() {
    let (spoiled, _) = squeezed(&wave().1);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let run = || searched(&spoiled, 5e-3);
        bits(&pool.build().unwrap().install(run).mesh)
    };
    assert_eq!(with(1), with(2));
}

/// Panels at a right-angled edge fold by less than rounding shows: all of them are tilted at once.
#[test]
fn the_edges_of_a_box_are_no_folds() {
    let corner = |k: u32| {
        Vec3::new(
            6.0 * f64::from(k & 1),
            4.0 * f64::from(k >> 1 & 1),
            3.0 * f64::from(k >> 2),
        )
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let cut = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles: Vec<[u32; 3]> = sides.into_iter().flat_map(cut).collect();
    let cuboid = TriangleSurface::new((0..8).map(corner).collect(), &triangles).unwrap();
    let options = MeshOptions {
        size: PanelSize::Panels(350),
        ..Default::default()
    };
    let run = mesh_surface(&cuboid, &options, &Silent).unwrap();
    let references = References {
        smooth: Some(&run.target),
        facets: Some(&cuboid),
        ..Default::default()
    };
    let found = Assessment::new(&run.mesh, references, &Limits::new(Some(5e-3), None));
    let failed: Vec<&str> = found.failures().map(|c| c.name).collect();
    assert!(failed.is_empty(), "{failed:?}");
    // Its twelve large facets are followed, not a smooth surface through its corners.
    let far = found.deviation_facets.unwrap();
    assert!(
        far.deviation_max < 5e-3 && far.coverage_max < 5e-3,
        "{} {}",
        far.deviation_max,
        far.coverage_max
    );
    let search = run.statistics.search.unwrap();
    assert!(
        search.defects > 8 && search.left == 0 && search.tried < 20,
        "{search:?}"
    );
}

/// A draft without a place for each corner is no candidate.
#[test]
fn drafts_with_places_that_are_not_finite_are_left_out() {
    let mesh = &wave().1;
    let patch = Patch::around(mesh, &[FaceId::new(70)], 1, &BTreeSet::new());
    let mut draft = patch.draft.clone();
    assert!(patch.built(&draft).is_some());
    draft.places[0].y = f64::NAN;
    assert!(patch.built(&draft).is_none());
}
