//! The smoothest aligned six-fold direction field (Knoeppel, Crane, Pinkall, Schroeder 2013, with a
//! diffusion-projection polish).

use super::boundary::BoundaryFrame;
use super::intrinsic::IntrinsicMesh;
use super::{DirectionOptions, FAR_REACH, boundary, mirrors};
use crate::curvature::Principal;
use nalgebra::{Complex, Matrix3};
use phex_mesh::{EdgeId, PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use phex_numeric::{
    Cholesky, ConjugateGradientOptions, NumericError, SymmetricMatrix, conjugate_gradients,
};
use std::collections::BTreeMap;

/// Symmetry of the field.
const N: f64 = 6.0;
/// Diffusion time of the polish, in squared lattice spacings, and its steps.
const POLISH_TIME: f64 = 0.3;
const POLISH_STEPS: usize = 3;
const POLISHED: ConjugateGradientOptions = ConjugateGradientOptions {
    tolerance: 1e-6,
    max_iterations: 200,
};
/// Weight of the fixed direction that decides where nothing else does.
const TIE_BREAK: f64 = 1e-4;

/// A six-fold field and what it was asked for.
pub(crate) struct SixFoldField {
    /// Angle at each vertex, radians modulo pi / 3.
    pub angle: PerVertex<f64>,
    /// Wish at each vertex: strength, integrated over the vertex, times `exp(6 i t)` of the
    /// direction `t`.
    pub wish: PerVertex<Complex<f64>>,
}

/// The smoothest field that is drawn to the small curvature's direction, and to the boundary. The
/// factorisation that is left there serves the next field on the same triangles.
pub(crate) fn field(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    metric: &PerVertex<Matrix3<f64>>,
    principal: &PerVertex<Principal>,
    weight: &PerVertex<f64>,
    options: &DirectionOptions,
    factor: &mut Option<Cholesky<Complex<f64>>>,
) -> Result<SixFoldField, NumericError> {
    let topology = surface.topology();
    let wish = |v: VertexId, along: Vec3, across: Vec3| {
        Complex::from_polar(
            1.0,
            N * (polar_of(surface, mesh, metric, v, along, across) + options.rotate),
        )
    };
    let [rim, mirrored] = open_and_mirrored(topology, mesh, weight, options.rotate);
    let rim_weight = |v: VertexId| {
        let open = rim[v].map_or(0.0, |r| {
            options.boundary_alignment * r.length * r.alignment.norm()
        });
        open + mirrored[v].map_or(0.0, |r| MIRROR_ALIGNMENT * r.length)
    };
    // Weights and wishes are integrated: over the area of a vertex, over its length of the
    // boundary.
    let curved = |v: VertexId| {
        let p = &principal[v];
        wish(v, p.small_direction, p.large_direction) * weight[v] * mesh.mass[v]
    };
    let fixed = |v: VertexId| {
        let [along, across] = global_frame(surface.normals()[v]);
        let rim = rim[v].map_or(Complex::default(), |r| r.alignment * r.length);
        wish(v, along, across) * TIE_BREAK * mesh.mass[v] + rim * options.boundary_alignment
    };
    let mut source: Vec<Complex<f64>> = topology.vertices().map(|v| curved(v) + fixed(v)).collect();
    let free = source.clone();
    let total = |v: VertexId| mesh.mass[v] * (weight[v] + TIE_BREAK) + rim_weight(v);
    let stiffness = |t: f64, inertia: f64| {
        let diagonal = |v: VertexId| mesh.mass[v] * inertia + t * total(v);
        let transport = |e: EdgeId| N * mesh.transport(e);
        connection_laplacian(topology, mesh, transport, t, diagonal)
    };
    let smooth = Cholesky::again(factor.take(), &stiffness(1.0, 0.0)?, 1)?;
    let mut u = source.clone();
    smooth.precondition(&source, &mut u);
    let is_calm = options.cancel_reach.is_some_and(|reach| reach >= FAR_REACH);
    let classes = is_calm.then(|| classes_of_sides(topology, mesh, &u, &mirrored));
    let at_axes = || classes_at_axes(topology, mesh, &u, &mirrored);
    let meeting = classes.flatten().unwrap_or_else(at_axes);
    draw_to_mirrors(&mut source, &u, &mirrored, &meeting);
    *factor = Some(smooth);
    let wishes = (&free[..], &mut source[..]);
    let diffusion = stiffness(POLISH_TIME, 1.0)?;
    polish(&diffusion, mesh, wishes, &mut u, (&mirrored, &meeting));
    Ok(SixFoldField {
        angle: PerVertex::from_vec(u.iter().map(|z| angle(*z)).collect()),
        wish: PerVertex::from_vec(source),
    })
}

/// Diffuses a field for a short time and makes its values of one length, step by step; after each,
/// the wishes that draw it to mirror planes are added anew to the `free` ones.
fn polish(
    diffusion: &SymmetricMatrix<Complex<f64>>,
    mesh: &IntrinsicMesh,
    (free, source): (&[Complex<f64>], &mut [Complex<f64>]),
    u: &mut [Complex<f64>],
    (mirrored, meeting): (&PerVertex<Option<BoundaryFrame>>, &BTreeMap<VertexId, f64>),
) {
    let diagonal: Vec<f64> = diffusion.diagonal().collect();
    let steps = match mirrored.iter().any(Option::is_some) {
        true => MIRROR_STEPS,
        false => POLISH_STEPS,
    };
    for _ in 0..steps {
        let wished = source.iter().zip(&mesh.mass);
        let right = (u.iter().zip(wished))
            .map(|(z, (s, mass))| z * (mass / (z.norm() + 1e-12)) + s * POLISH_TIME);
        let right: Vec<Complex<f64>> = right.collect();
        let apply = |x: &[Complex<f64>], y: &mut [Complex<f64>]| diffusion.mul(x, y);
        conjugate_gradients(apply, &diagonal, &right, u, &POLISHED);
        source.copy_from_slice(free);
        draw_to_mirrors(source, u, mirrored, meeting);
    }
}

/// Frames of the boundary, and those of the vertices in mirror planes. On a plane rows follow the
/// longest side alone, turned as is asked for.
fn open_and_mirrored(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    weight: &PerVertex<f64>,
    rotate: f64,
) -> [PerVertex<Option<BoundaryFrame>>; 2] {
    let mut rim = boundary::frames(topology, mesh);
    if is_flat(mesh, weight) {
        rim = boundary::on_longest_side(topology, &rim);
        let turn = Complex::from_polar(1.0, N * rotate);
        let frames = rim.iter_mut().flatten();
        frames.for_each(|f| f.alignment *= turn);
    }
    let mirrored = mirror_frames(&mut rim, &mesh.multiplicity);
    [rim, mirrored]
}

/// Weight of the alignment with mirror planes, per panel length of them, and steps of the polish
/// where there are any: at each vertex a row runs along the plane or at right angles to it, and
/// which of both is found on the way.
const MIRROR_ALIGNMENT: f64 = 10.0;
const MIRROR_STEPS: usize = 12;

/// Takes the frames of the vertices in mirror planes out of those of the boundary. Where two planes
/// meet nothing is wished for.
fn mirror_frames(
    rim: &mut PerVertex<Option<BoundaryFrame>>,
    multiplicity: &PerVertex<u32>,
) -> PerVertex<Option<BoundaryFrame>> {
    let mut mirrored = PerVertex::filled(rim.len(), None);
    for (v, count) in multiplicity.enumerate().filter(|(_, count)| **count > 1) {
        let frame = rim[v].take();
        mirrored[v] = frame.filter(|f| *count == 2 && !f.ends_mirror());
    }
    mirrored
}

/// Sets wishes in mirror planes: a row along the plane, or at right angles to it, whichever is
/// nearer to `field`.
fn draw_to_mirrors(
    source: &mut [Complex<f64>],
    field: &[Complex<f64>],
    mirrored: &PerVertex<Option<BoundaryFrame>>,
    meeting: &BTreeMap<VertexId, f64>,
) {
    for (v, frame) in mirrored.enumerate() {
        let Some(frame) = frame else { continue };
        let along = (field[v.index()].conj() * frame.alignment).re;
        let nearer = if along < 0.0 { -1.0 } else { 1.0 };
        let sign = meeting.get(&v).copied().unwrap_or(nearer);
        source[v.index()] += frame.alignment * (sign * MIRROR_ALIGNMENT * frame.length);
    }
}

/// Distance from the place where two mirror planes meet, lattice spacings, up to which that place
/// decides which way rows run.
const AT_AXIS: f64 = 1.2;

/// Which way rows run beside the places where two mirror planes meet, 1 along the plane, -1 at
/// right angles to it. The field turns from one plane to the other by a multiple of a twelfth of a
/// turn, so that a panel closes there: an odd one if rows run along one of the planes alone. Of the
/// multiples the one nearest to the angle is taken, 0 excepted.
fn classes_at_axes(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    field: &[Complex<f64>],
    mirrored: &PerVertex<Option<BoundaryFrame>>,
) -> BTreeMap<VertexId, f64> {
    let mut classes = BTreeMap::new();
    for (v, count) in mesh.multiplicity.enumerate().filter(|(_, k)| **k > 2) {
        let sides = [true, false].map(|ahead| beside(topology, v, ahead, mirrored));
        let [first, second] = [&sides[0], &sides[1]].map(|side| -> f64 {
            let along = |w: &VertexId| {
                mirrored[*w].map_or(0.0, |f| (field[w.index()].conj() * f.alignment).re)
            };
            side.iter().map(along).sum()
        });
        let is_odd = mirrors::twelfths_between(*count) % 2.0 == 1.0;
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let class = match is_odd {
            true => [sign(first - second), -sign(first - second)],
            false => [sign(first + second); 2],
        };
        for (side, class) in sides.iter().zip(class) {
            classes.extend(side.iter().map(|w| (*w, class)));
        }
    }
    classes
}

/// Sides of the surface in mirror planes up to which all ways of rows along them are compared.
const MOST_SIDES: usize = 10;

/// One way of rows for each whole side in a mirror plane, 1 along it, -1 at right angles to it:
/// where it changes there is a cone in the plane. Of all ways that one is taken that closes the
/// panels where most planes meet, and of these the one nearest to a field. `None` where there are
/// many sides.
fn classes_of_sides(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    field: &[Complex<f64>],
    mirrored: &PerVertex<Option<BoundaryFrame>>,
) -> Option<BTreeMap<VertexId, f64>> {
    let (mut sides, mut meetings) = (Vec::<Vec<VertexId>>::new(), Vec::new());
    for mut rim in topology.boundary_loops() {
        let end = rim.iter().position(|v| mirrored[*v].is_none());
        rim.rotate_left(end.unwrap_or(0));
        let first = sides.len();
        let runs = rim.split(|v| mirrored[*v].is_none());
        sides.extend(runs.filter(|run| !run.is_empty()).map(<[_]>::to_vec));
        let of_rim = sides.len() - first;
        let count_of = |side: &Vec<VertexId>| {
            let [out, _] = boundary::boundary_half_edges(topology, *side.last()?);
            Some(mesh.multiplicity[topology.target(out)]).filter(|count| *count > 2)
        };
        for k in 0..of_rim {
            let next = first + (k + 1) % of_rim;
            let count = count_of(&sides[first + k]);
            meetings.extend(count.map(|count| (first + k, next, count)));
        }
    }
    if sides.is_empty() || sides.len() > MOST_SIDES {
        return None;
    }
    let along = |w: &VertexId| {
        let along = |f: BoundaryFrame| f.length * (field[w.index()].conj() * f.alignment).re;
        mirrored[*w].map_or(0.0, along)
    };
    let sums: Vec<f64> = sides
        .iter()
        .map(|side| side.iter().map(along).sum())
        .collect();
    let class = |ways: usize, side: usize| if ways >> side & 1 == 0 { 1.0 } else { -1.0 };
    let open = |ways: usize| {
        let is_open = |(a, b, count): &&(usize, usize, u32)| {
            let is_odd = mirrors::twelfths_between(*count) % 2.0 == 1.0;
            (class(ways, *a) != class(ways, *b)) != is_odd
        };
        meetings.iter().filter(is_open).count()
    };
    let nearness = |ways: usize| -> f64 {
        sums.iter()
            .enumerate()
            .map(|(side, sum)| class(ways, side) * sum)
            .sum()
    };
    let best = (0..1_usize << sides.len()).min_by(|a, b| {
        let nearer = || nearness(*b).total_cmp(&nearness(*a));
        open(*a).cmp(&open(*b)).then_with(nearer)
    })?;
    let of_side = |(side, vertices): (usize, &Vec<VertexId>)| {
        let class = class(best, side);
        vertices
            .iter()
            .map(move |v| (*v, class))
            .collect::<Vec<_>>()
    };
    Some(sides.iter().enumerate().flat_map(of_side).collect())
}

/// Vertices of the boundary on one side of `v`, up to [`AT_AXIS`] from it.
fn beside(
    topology: &Topology,
    v: VertexId,
    ahead: bool,
    mirrored: &PerVertex<Option<BoundaryFrame>>,
) -> Vec<VertexId> {
    let (mut side, mut at, mut way) = (Vec::new(), v, 0.0);
    loop {
        let [out, back] = boundary::boundary_half_edges(topology, at);
        at = match ahead {
            true => topology.target(out),
            false => topology.origin(back),
        };
        let Some(frame) = mirrored[at].filter(|_| way < AT_AXIS) else {
            return side;
        };
        way += frame.length;
        side.push(at);
    }
}

/// Share of a surface that wants its rows to run somewhere, below which it counts as flat.
const FLAT: f64 = 1e-3;

/// Whether curvature and guides leave rows free everywhere.
fn is_flat(mesh: &IntrinsicMesh, weight: &PerVertex<f64>) -> bool {
    let area: f64 = mesh.mass.iter().sum();
    let wishing: f64 = mesh
        .mass
        .iter()
        .zip(weight.iter())
        .map(|(m, w)| m * w)
        .sum();
    wishing < FLAT * area
}

/// The angle of a direction, one of six: the cut between them lies where no symmetry puts a field
/// exactly, so that rounding does not choose.
fn angle(z: Complex<f64>) -> f64 {
    const CUT: f64 = 0.7;
    ((z * Complex::from_polar(1.0, -CUT)).arg() + CUT) / N
}

/// A tangent pair that varies smoothly over most of space: the x axis projected to the tangent
/// plane.
fn global_frame(n: Vec3) -> [Vec3; 2] {
    let axis = if n.x.abs() < 0.95 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let along = (axis - n * axis.dot(&n)).normalize();
    [along, n.cross(&along)]
}

/// Hermitian matrix of `t sum w |z_j - exp(i transport) z_i|^2 + sum diagonal |z|^2`, sums over the
/// edges from `i` to `j` and over the vertices.
pub(super) fn connection_laplacian(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    transport: impl Fn(EdgeId) -> f64,
    t: f64,
    diagonal: impl Fn(VertexId) -> f64,
) -> Result<SymmetricMatrix<Complex<f64>>, NumericError> {
    let own = topology.vertices().map(diagonal).collect();
    let turned = |e: EdgeId, w: f64, is_along: bool| {
        let turned = -Complex::from_polar(w, transport(e));
        if is_along { turned } else { turned.conj() }
    };
    let entries = mesh.laplacian(topology, t, own, turned);
    SymmetricMatrix::from_triplets(topology.n_vertices(), entries.into_iter())
}

/// Polar angle at `v` of the tangent direction `along` (with `across` to its left or right),
/// measured in the metric against all edges of the vertex and averaged.
fn polar_of(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    metric: &PerVertex<Matrix3<f64>>,
    v: VertexId,
    along: Vec3,
    across: Vec3,
) -> f64 {
    let (topology, m) = (surface.topology(), &metric[v]);
    // Left of `along`, whatever the handedness of the pair.
    let left = across * surface.normals()[v].cross(&along).dot(&across).signum();
    let length = along.dot(&(m * along)).sqrt();
    let ortho = left - along * (along.dot(&(m * left)) / (length * length));
    let ortho_length = ortho.dot(&(m * ortho)).sqrt();
    let mut mean = Complex::new(0.0, 0.0);
    for h in topology.outgoing(v) {
        let e = surface.positions()[topology.target(h)] - surface.positions()[v];
        let angle = (e.dot(&(m * ortho)) / ortho_length).atan2(e.dot(&(m * along)) / length);
        mean += Complex::from_polar(1.0, mesh.polar(topology, h) - angle);
    }
    mean.arg()
}
