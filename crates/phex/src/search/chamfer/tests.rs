use super::super::draft::Draft;
use super::{ChamferStrip, FoldRun, chamfered};
use phex_mesh::{HexMesh, ValidateOptions, Vec3, Violation, violations};
use std::collections::BTreeMap;

fn draft(places: Vec<Vec3>, faces: &[&[u32]], at_boundary: bool) -> Draft {
    Draft {
        on_boundary: vec![at_boundary; places.len()],
        places,
        open: vec![true; faces.len()],
        origin: (0..faces.len()).collect(),
        faces: faces.iter().map(|f| f.to_vec()).collect(),
    }
}

/// A prism over a triangle with an angle of `2 atan(half)` at its blade.
fn wedge(half: f64) -> Draft {
    let triangle = [[0.0, 0.0], [-1.0, half], [-1.0, -half]];
    let ring = |z: f64| triangle.map(|[x, y]| Vec3::new(x, y, z));
    let faces: [&[u32]; 5] = [
        &[0, 2, 1],
        &[3, 4, 5],
        &[0, 1, 4, 3],
        &[1, 2, 5, 4],
        &[2, 0, 3, 5],
    ];
    draft([ring(0.0), ring(1.5)].concat(), &faces, false)
}

/// Two panels like the sides of a knife, with nothing at their ends.
fn knife() -> Draft {
    let place = |x: f64, y: f64, z: f64| Vec3::new(x, 0.3 * y, z);
    let places = vec![
        place(0.0, 0.0, 0.0),
        place(0.0, 0.0, 1.0),
        place(-1.0, 1.0, 1.2),
        place(-1.0, 1.0, -0.1),
        place(-1.2, -1.2, 0.9),
        place(-1.0, -1.0, 0.1),
    ];
    draft(places, &[&[0, 3, 2, 1], &[1, 4, 5, 0]], true)
}

/// The panels as a mesh, how many edges of it fold, and what is wrong in all.
fn built(draft: &Draft) -> (HexMesh, usize, usize) {
    let faces: Vec<Vec<u32>> = (draft.faces.iter().filter(|face| !face.is_empty()))
        .cloned()
        .collect();
    let mesh = crate::trim::compact(&draft.places, &faces).unwrap();
    let found = violations(&mesh, None, &ValidateOptions::default());
    let is_fold = |v: &&Violation| matches!(v, Violation::Fold { .. });
    (mesh, found.iter().filter(is_fold).count(), found.len())
}

#[test]
fn blades_are_cut_off() {
    for half in [0.9, 0.5, 0.2] {
        let whole = wedge(half);
        assert_eq!(built(&whole).1, 3, "the blade and both edges of the back");
        let (mesh, folds, wrong) = built(&chamfered(&whole, None, f64::INFINITY).unwrap());
        assert_eq!((folds, wrong), (0, 0), "{half}");
        let topology = mesh.topology();
        assert_eq!(topology.euler_characteristic(), 2);
        assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
        let heights = phex_mesh::measure(&mesh).planarity.max;
        assert!(heights < 1e-14, "{heights}");
    }
}

/// Two rows of bricks that meet in a ridge, over which they turn by two right angles less that
/// of which `half` is the tangent of the half; each of them is two long, but the first and the
/// last one of the other side.
fn ridge(half: f64) -> Draft {
    slanting_ridge(half, 0.0)
}

/// The same with edges that leave the ridge aslant.
fn slanting_ridge(half: f64, slant: f64) -> Draft {
    let (mut places, mut faces, mut on_boundary) = (Vec::new(), Vec::new(), Vec::new());
    let mut number = BTreeMap::new();
    let mut corner = |x: i32, y: i32| {
        *number.entry((x, y)).or_insert_with(|| {
            let (along, out) = (f64::from(x), f64::from(y));
            let along = along + slant * out.abs();
            places.push(Vec3::new(along, 2.0 * half * out, -2.0 * out.abs()));
            on_boundary.push(y != 0 || !(2..=7).contains(&x));
            places.len() as u32 - 1
        })
    };
    for (side, first) in [(1, 0), (-1, 1)] {
        for x in (first..first + 8).step_by(2) {
            let ring = [(x, 0), (x + 1, 0), (x + 2, 0), (x + 2, side), (x, side)];
            let square = ring.map(|(x, y)| (x.clamp(1, 8), y));
            let mut face: Vec<u32> = square.iter().map(|&(x, y)| corner(x, y)).collect();
            face.dedup();
            if side < 0 {
                face.reverse();
            }
            faces.push(face);
        }
    }
    Draft {
        open: vec![true; faces.len()],
        origin: (0..faces.len()).collect(),
        faces,
        places,
        on_boundary,
    }
}

/// An edge of the run goes back on the one before it.
#[test]
fn a_run_that_turns_back_has_finite_places() {
    let mut whole = ridge(0.4);
    let at = |x: i32| {
        let place = Vec3::new(f64::from(x), 0.0, 0.0);
        let found = whole.places.iter().position(|p| (p - place).norm() < 1e-9);
        found.unwrap() as u32
    };
    let run = FoldRun {
        vertices: (2..=7).map(at).collect(),
        is_closed: false,
    };
    let incidence = whole.incidence();
    let edge = |side| whole.run_edge(&incidence, side, 0.01).unwrap();
    let edges = run.edges().map(edge).collect();
    let turning = run.vertices[2] as usize;
    whole.places[turning].x = 2.5;
    let strip = ChamferStrip::new(&whole, run, edges).unwrap();
    let cut = strip.laid().unwrap();
    assert!(cut.places.iter().flatten().all(|x| x.is_finite()));
}

#[test]
fn a_run_of_folds_becomes_one_row_of_hexagons() {
    let whole = ridge(0.4);
    assert_eq!(built(&whole).1, 7);
    let cut = chamfered(&whole, None, f64::INFINITY).unwrap();
    let (mesh, folds, wrong) = built(&cut);
    assert_eq!((folds, wrong, mesh.topology().n_faces()), (0, 0, 11));
    assert!(phex_mesh::measure(&mesh).planarity.max < 1e-14);
    assert!(cut.faces[8..].iter().all(|face| face.len() == 6));
    let depth = |deepest: f64| {
        let cut = chamfered(&whole, None, deepest).unwrap();
        let new = cut.places[whole.places.len()..].iter();
        new.map(|p| -p.z).fold(0.0, f64::max)
    };
    assert!((depth(0.1) - 0.1).abs() < 1e-12, "{}", depth(0.1));
}

#[test]
fn edges_across_a_strip_lie_between_those_that_leave_it_aslant() {
    for slant in [-1.5, 0.8, 1.5] {
        let whole = slanting_ridge(0.4, slant);
        let cut = chamfered(&whole, None, 0.3).unwrap();
        assert_eq!(built(&cut).2, 0, "{slant}");
        assert!(phex_mesh::measure(&built(&cut).0).planarity.max < 1e-14);
    }
}

#[test]
fn strips_meet_in_a_vertex_at_a_corner() {
    // A cube drawn out along a diagonal: at both of its ends three edges are sharper than a
    // right angle.
    let t = 0.2;
    let place =
        |x: f64, y: f64, z: f64| Vec3::new(x + t * (y + z), y + t * (z + x), z + t * (x + y));
    let corner = |k: u32| place(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
    let faces: [&[u32]; 6] = [
        &[0, 2, 3, 1],
        &[4, 5, 7, 6],
        &[0, 1, 5, 4],
        &[2, 6, 7, 3],
        &[0, 4, 6, 2],
        &[1, 3, 7, 5],
    ];
    let drawn_out = draft((0..8).map(corner).collect(), &faces, false);
    assert_eq!(built(&drawn_out).1, 6);
    let cut = chamfered(&drawn_out, None, 0.05).unwrap();
    let (mesh, folds, _) = built(&cut);
    let topology = mesh.topology();
    assert_eq!((folds, topology.n_faces()), (0, 12));
    assert_eq!(topology.euler_characteristic(), 2);
    assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
    for end in [0, 7] {
        let nearest = farthest_corner(&mesh, &[drawn_out.places[end]]);
        assert!(nearest < 0.05, "{nearest}");
    }
}

/// The largest distance of some points to the nearest vertex.
fn farthest_corner(mesh: &HexMesh, points: &[Vec3]) -> f64 {
    let nearest = |p: &Vec3| {
        let away = mesh.positions.iter().map(|q| (q - p).norm());
        away.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn a_panel_of_a_strip_cuts_no_bend_short() {
    // A flat pyramid without its top over a square, each side of which is one edge.
    let square = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let ring = |size: f64, z: f64| square.map(|(x, y)| Vec3::new(size * x, size * y, z));
    let faces: [&[u32]; 6] = [
        &[3, 2, 1, 0],
        &[4, 5, 6, 7],
        &[0, 1, 5, 4],
        &[1, 2, 6, 5],
        &[2, 3, 7, 6],
        &[3, 0, 4, 7],
    ];
    let whole = draft([ring(1.0, 0.0), ring(0.3, 0.8)].concat(), &faces, false);
    assert_eq!(built(&whole).1, 4);
    let (mesh, folds, _) = built(&chamfered(&whole, None, 0.05).unwrap());
    let topology = mesh.topology();
    assert_eq!((folds, topology.n_faces()), (0, 6 + 8));
    assert_eq!(topology.euler_characteristic(), 2);
    let off = farthest_corner(&mesh, &ring(1.0, 0.0));
    assert!(off < 0.1, "{off}");
}

#[test]
fn a_run_ends_before_what_may_not_change() {
    let mut part = ridge(0.4);
    part.open[7] = false;
    let cut = chamfered(&part, None, f64::INFINITY).unwrap();
    assert_eq!(cut.faces[7], part.faces[7]);
    let (mesh, folds, _) = built(&cut);
    assert!((1..=3).contains(&folds), "{folds}");
    assert_eq!(mesh.topology().boundary_loops().len(), 1);
}

#[test]
fn a_closed_run_becomes_a_closed_row() {
    // Two pyramids over a polygon, whose panels are as wide as two of its sides, on one
    // pyramid one side on from those on the other.
    let n = 24_u32;
    let ring = |k: u32| {
        let turn = std::f64::consts::TAU * f64::from(k) / f64::from(n);
        Vec3::new(turn.cos(), turn.sin(), 0.0)
    };
    let mut places: Vec<Vec3> = (0..n).map(ring).collect();
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for (first, up) in [(0, 1.0), (1, -1.0)] {
        let top = places.len() as u32;
        let crown = (0..n / 2).map(|k| ring(2 * k + first) * 0.5 + Vec3::new(0.0, 0.0, 0.2 * up));
        places.extend(crown);
        let around = |k: u32| (2 * k + first) % n;
        let oriented = |mut face: Vec<u32>| {
            if up < 0.0 {
                face.reverse();
            }
            face
        };
        for k in 0..n / 2 {
            let next = (k + 1) % (n / 2);
            let [a, b, c] = [around(k), (around(k) + 1) % n, around(next)];
            faces.push(oriented(vec![a, b, c, top + next, top + k]));
        }
        faces.push(oriented((top..top + n / 2).collect()));
    }
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    let whole = draft(places, &faces, false);
    assert_eq!(built(&whole).1, n as usize);
    let cut = chamfered(&whole, None, f64::INFINITY).unwrap();
    let mesh = built(&cut).0;
    let topology = mesh.topology();
    assert_eq!(topology.euler_characteristic(), 2);
    assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
    let row = &cut.faces[faces.len()..];
    assert!(row.len() == 12 && row.iter().all(|face| face.len() == 6));
    assert_eq!(built(&cut).1, 0);
}

#[test]
fn a_blade_at_the_boundary_is_cut_to_it() {
    let cut = chamfered(&knife(), None, f64::INFINITY).unwrap();
    let (mesh, folds, wrong) = built(&cut);
    assert_eq!((folds, wrong, mesh.topology().n_faces()), (0, 0, 3));
    assert_eq!(mesh.topology().boundary_loops().len(), 1);
    assert!(cut.on_boundary[6..].iter().all(|at| *at));
}

#[test]
fn what_is_closed_or_not_meant_stays() {
    let mut whole = wedge(0.5);
    let back = chamfered(&whole, Some(&[3]), f64::INFINITY).unwrap();
    assert!(built(&back).1 < 3, "the edges of the back, not the blade");
    whole.open = vec![false; 5];
    assert!(chamfered(&whole, None, f64::INFINITY).is_none());
    assert!(
        chamfered(&wedge(1.5), Some(&[0]), f64::INFINITY).is_none(),
        "no fold"
    );
}
