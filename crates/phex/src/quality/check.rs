//! One check: a figure, its limit, the panels that exceed it, the worst place, and what would help.

use super::Limits;
use crate::layout::MAX_PANELS;
use phex_mesh::measure::{BoundaryFit, Deviation, MeshMeasures, Spot};
use phex_mesh::validate::{ValidateOptions, Violation, planarity_floor};
use phex_mesh::{BoundaryCurve, FaceId, HexMesh, PerVertex, TriangleSurface, Vec3, VertexId};
use serde::Serialize;
use std::collections::BTreeSet;

/// The kind of element that a check's ids number, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ElementKind {
    /// Vertices.
    Vertex,
    /// Edges.
    Edge,
    /// Faces.
    Face,
    /// The mesh as a whole.
    Mesh,
}

/// What a check's limit and figure are given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// A number of elements.
    Count,
    /// Mean edges of the mesh.
    MeanEdges,
    /// Diagonals of the surface's bounding box.
    Diagonals,
    /// Share of the surface's area, 0 to 1.
    Area,
    /// Model units.
    Length,
    /// Squared model units.
    SquareLength,
    /// Degrees.
    Degrees,
    /// A ratio without unit.
    Ratio,
}

/// Limit and figure in the unit in which the limit was typed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// The unit.
    pub unit: String,
    /// The limit.
    pub limit: f64,
    /// The figure.
    pub value: f64,
    /// For a sheet, of which the two are the shorter sides, its longer side and that of the least
    /// sheet of its proportions that holds every panel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub across: Option<[f64; 2]>,
}

/// A figure, its limit, and the elements that exceed it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Name, as in the table of the documentation.
    pub name: &'static str,
    /// The limit.
    pub limit: f64,
    /// Whether it is a smallest one, else a largest one.
    pub is_least: bool,
    /// The figure; for checks that count, the number of offenders.
    pub value: f64,
    /// What the two are given in.
    pub scale: Scale,
    /// The limit as a length in model units; `None` where it is none.
    pub limit_length: Option<f64>,
    /// The figure as a length in model units; `None` where it is none.
    pub value_length: Option<f64>,
    /// Both as the user typed the limit; `None` where none was typed, or in the unit of `scale`.
    pub reading: Option<Reading>,
    /// Whether the check holds.
    pub pass: bool,
    /// Whether a failure means that the mesh is no panelling at all.
    pub decisive: bool,
    /// What the ids number.
    pub element: ElementKind,
    /// The offenders, in order.
    pub ids: Vec<usize>,
    /// The figure of each of them, where a limit of panels is checked; else empty.
    pub values: Vec<f64>,
    /// How near each face is to a limit of panels: its worst figure over a largest limit, a
    /// smallest limit over its worst figure, so that 1 is at the limit and more beyond it; NaN for
    /// a face without a figure, empty for other checks.
    #[serde(skip)]
    pub of_face: Vec<f64>,
    /// The faces that take part in a failure, in order: the offenders, those that hold them, or
    /// those closest to the place.
    pub faces: Vec<usize>,
    /// Where it is worst, in model coordinates; `None` where the check holds.
    pub place: Option<[f64; 3]>,
    /// What would help; `None` where the check holds, or where nothing general can be said.
    pub advice: Option<String>,
}

/// Checks whose limit is a smallest one.
const LEAST: [&str; 3] = ["edge_length", "clearance", "covered_area"];

impl Check {
    /// A check without offenders.
    pub(super) fn new(
        name: &'static str,
        [limit, value]: [f64; 2],
        scale: Scale,
        pass: bool,
    ) -> Self {
        Self {
            name,
            limit,
            is_least: LEAST.contains(&name),
            value,
            scale,
            limit_length: None,
            value_length: None,
            reading: None,
            pass,
            decisive: false,
            element: ElementKind::Face,
            ids: Vec::new(),
            values: Vec::new(),
            of_face: Vec::new(),
            faces: Vec::new(),
            place: None,
            advice: None,
        }
    }

    /// The same with both figures as lengths; `unit` is the length of 1 in its scale.
    pub(super) fn in_lengths(self, unit: f64) -> Self {
        Self {
            limit_length: Some(self.limit * unit),
            value_length: Some(self.value * unit),
            ..self
        }
    }

    /// The same with faces as offenders, if it fails.
    pub(super) fn at(self, faces: impl IntoIterator<Item = FaceId>, place: Option<Vec3>) -> Self {
        if self.pass {
            return self;
        }
        let faces: BTreeSet<usize> = faces.into_iter().map(FaceId::index).collect();
        Self {
            ids: faces.iter().copied().collect(),
            faces: faces.into_iter().collect(),
            place: place.map(Into::into),
            ..self
        }
    }

    /// The same with the elements of violations as offenders.
    fn named(self, mesh: &HexMesh, found: &[&Violation], element: ElementKind) -> Self {
        let faces = found.iter().flat_map(|v| v.faces(mesh.topology()));
        let worst = found.iter().rev();
        let worst = worst.max_by(|a, b| a.severity().total_cmp(&b.severity()));
        let ids: BTreeSet<usize> = found.iter().map(|v| number(v)).collect();
        Self {
            element,
            ids: ids.into_iter().collect(),
            ..self.at(faces, worst.and_then(|v| v.place(mesh)))
        }
    }

    /// The same with what would help, if it fails.
    pub(super) fn advised(self, advice: &str) -> Self {
        let advice = (!self.pass).then(|| advice.to_owned());
        Self { advice, ..self }
    }
}

/// Number of the element that a violation is listed under.
fn number(violation: &Violation) -> usize {
    match *violation {
        Violation::NotFinite { vertex }
        | Violation::WrongFan { vertex, .. }
        | Violation::WrongDegree { vertex, .. } => vertex.index(),
        Violation::NotSimple { face }
        | Violation::NotPlanar { face, .. }
        | Violation::SmallClearance { face, .. }
        | Violation::FoldedCorner { face, .. }
        | Violation::FlippedFace { face, .. } => face.index(),
        Violation::CollapsedEdge { edge, .. }
        | Violation::Fold { edge, .. }
        | Violation::Crossing { edge, .. } => edge.index(),
    }
}

/// Checks that count violations of a kind: name, kind, what the ids number, whether one offender is
/// decisive.
const COUNTED: [(&str, &str, ElementKind, bool); 8] = [
    ("finite", "not_finite", ElementKind::Vertex, true),
    ("faces_not_simple", "not_simple", ElementKind::Face, true),
    ("folded_corners", "folded_corner", ElementKind::Face, true),
    ("flipped_faces", "flipped_face", ElementKind::Face, true),
    ("wrong_fans", "wrong_fan", ElementKind::Vertex, true),
    ("wrong_degree", "wrong_degree", ElementKind::Vertex, true),
    ("crossings", "crossing", ElementKind::Edge, true),
    ("folds", "fold", ElementKind::Edge, false),
];

/// The checks of a mesh in itself.
pub(super) fn validity_checks(
    mesh: &HexMesh,
    measures: &MeshMeasures,
    violations: &[Violation],
    limits: &ValidateOptions,
) -> Vec<Check> {
    let of_kind = |kind: &str| -> Vec<&Violation> {
        violations.iter().filter(|v| v.kind() == kind).collect()
    };
    let counted = COUNTED.map(|(name, kind, element, decisive)| {
        let found = of_kind(kind);
        let check = Check::new(name, [0.0, 0.0], Scale::Count, found.is_empty());
        let check = check.named(mesh, &found, element);
        Check {
            value: check.ids.len() as f64,
            decisive,
            ..check
        }
    });
    let planarity = limits.planarity_limit(mesh);
    use ElementKind::{Edge, Face};
    #[rustfmt::skip]
    let measured = [
        ("planarity", "not_planar", Face, [planarity, measures.planarity.max]),
        ("clearance", "small_clearance", Face, [limits.clearance, measures.clearance.min]),
        ("edge_length", "collapsed_edge", Edge, [limits.edge_length_rel, measures.edge_length.min]),
    ];
    let measured = measured.map(|(name, kind, element, figures)| {
        let found = of_kind(kind);
        let check = Check::new(name, figures, Scale::MeanEdges, found.is_empty());
        let check = check.in_lengths(measures.mean_edge);
        check.named(mesh, &found, element)
    });
    let rounding = planarity_floor(mesh);
    let [planar, rest @ ..] = measured;
    let planar = if planarity < rounding {
        planar.advised(&format!(
            "coordinates are rounded to {rounding:.1e} mean edges: move the model nearer to the origin, or ask for no less"
        ))
    } else {
        planar
    };
    [planar].into_iter().chain(rest).chain(counted).collect()
}

/// The checks of a mesh against a surface.
pub(super) fn surface_checks(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    deviation: &Deviation,
    (limits, panels): (&Limits, usize),
) -> Vec<Check> {
    let topology = topology_check(mesh, surface, deviation);
    let Some(limit) = limits.deviation_rel else {
        return vec![topology];
    };
    vec![
        topology,
        deviation_check(mesh, deviation, (limit, panels)),
        coverage_check(surface, deviation, (limit, panels)),
    ]
}

/// What would help where the surface is missed inside.
pub(super) const SMALLER: &str = "smaller ones there (--adaptive)";

/// Share by which a number of panels that is told is on the safe side: from one number to the next
/// the worst figure of a mesh varies by about a tenth (the median over six surfaces of its standard
/// deviation from 280 to 330 panels, times their number).
pub(super) const SPARE: f64 = 0.1;

/// What would help where a distance is beyond its limit: it falls with the area of panels. `panels`
/// is the number that is changed, that which was asked for where there is one.
fn nearer(panels: usize, [limit, value]: [f64; 2], or: &str) -> String {
    let enough = (panels as f64 * value / limit * (1.0 + SPARE)).ceil();
    if enough > MAX_PANELS as f64 {
        return format!(
            "no number of panels up to {MAX_PANELS}: a larger deviation or, if the mesh is nowhere near the surface, \
             another unit or origin, or a surface without a spike there"
        );
    }
    format!(
        "about {enough} panels instead of {panels}, if all shrink alike, {or}, or a larger deviation"
    )
}

fn deviation_check(mesh: &HexMesh, deviation: &Deviation, (limit, panels): (f64, usize)) -> Check {
    let length = limit * deviation.diagonal;
    let topology = mesh.topology();
    let far = |f: &FaceId| {
        let mut corners = topology.face_vertices(*f).iter();
        deviation.face_distance[*f] > length
            || corners.any(|&v| deviation.vertex_distance[v] > length)
    };
    let vertices = (deviation.vertex_distance.enumerate()).map(|(v, d)| (*d, mesh.position(v)));
    let centres = (deviation.face_distance.enumerate()).map(|(f, d)| (*d, mesh.centre(f)));
    let value = deviation.deviation_max;
    Check::new(
        "deviation",
        [limit, value],
        Scale::Diagonals,
        value <= limit,
    )
    .in_lengths(deviation.diagonal)
    .at(topology.faces().filter(far), worst(vertices.chain(centres)))
    .advised(&nearer(panels, [limit, value], SMALLER))
}

fn coverage_check(
    surface: &TriangleSurface,
    deviation: &Deviation,
    (limit, panels): (f64, usize),
) -> Check {
    let length = limit * deviation.diagonal;
    let inside = || {
        let distances = deviation.coverage_distance.enumerate();
        distances.filter(|(v, _)| deviation.inside[*v])
    };
    let far = inside().filter(|(_, d)| **d > length);
    let faces = far.map(|(v, _)| deviation.coverage_face[v]);
    let points = inside().map(|(v, d)| (*d, surface.positions()[v]));
    let value = deviation.coverage_inner_max;
    Check::new(
        "coverage_inner",
        [limit, value],
        Scale::Diagonals,
        value <= limit,
    )
    .in_lengths(deviation.diagonal)
    .at(faces, worst(points))
    .advised(&nearer(panels, [limit, value], SMALLER))
}

/// The point with the largest distance.
fn worst(points: impl Iterator<Item = (f64, Vec3)>) -> Option<Vec3> {
    points.max_by(|a, b| a.0.total_cmp(&b.0)).map(|p| p.1)
}

/// Bare points are named with the worst one where they are at least this share as far from the
/// panels.
const AS_BAD: f64 = 0.25;

/// The checks of a mesh against the boundary of an open surface.
pub(super) fn boundary_checks(
    fit: &BoundaryFit,
    (panels, diagonal): (usize, f64),
    limits: &Limits,
    elsewhere: &[FaceId],
) -> Vec<Check> {
    let place = |spots: &[Spot]| worst(spots.iter().map(|s| (s.distance, s.point)));
    let follows = limits.boundary_rel.map(|limit| {
        let follows = |s: &&Spot| elsewhere.binary_search(&s.face).is_err();
        let apart: Vec<Spot> = fit.apart.iter().filter(follows).copied().collect();
        let value = apart.iter().map(|s| s.distance).fold(0.0, f64::max);
        let far = apart.iter().filter(|s| s.distance > limit);
        Check::new("boundary", [limit, value], Scale::Diagonals, value <= limit)
            .in_lengths(diagonal)
            .at(far.map(|s| s.face), place(&apart))
            .advised(&nearer(panels, [limit, value], "another --boundary"))
    });
    let covered = limits.covered.filter(|_| elsewhere.is_empty());
    let covers = covered.map(|limit| {
        let value = fit.covered_area;
        let farthest = fit.bare.iter().map(|s| s.distance).fold(0.0, f64::max);
        let far = fit.bare.iter().filter(|s| s.distance >= AS_BAD * farthest);
        Check::new("covered_area", [limit, value], Scale::Area, value >= limit)
            .at(far.map(|s| s.face), place(&fit.bare))
            .advised("more panels, or another --boundary")
    });
    follows.into_iter().chain(covers).collect()
}

fn topology_check(mesh: &HexMesh, surface: &TriangleSurface, deviation: &Deviation) -> Check {
    let pass = deviation.same_topology;
    let value = f64::from(u8::from(!pass));
    let check = Check::new("same_topology", [0.0, value], Scale::Count, pass);
    if pass {
        return check;
    }
    let ours = mesh.topology().boundary_loops();
    let theirs = surface.topology().boundary_loops();
    let closed = |l: &[VertexId], positions: &PerVertex<Vec3>| -> Vec<Vec3> {
        l.iter().chain(l.first()).map(|v| positions[*v]).collect()
    };
    let [mine, given] = [
        (ours.iter().map(|l| closed(l, &mesh.positions))).collect::<Vec<_>>(),
        (theirs.iter().map(|l| closed(l, surface.positions()))).collect(),
    ];
    let (faces, place): (Vec<FaceId>, Option<Vec3>) = if mine.len() > given.len() {
        let odd = loneliest(&mine, &given);
        let around = (ours[odd].iter()).flat_map(|v| mesh.topology().faces_at(*v));
        (around.collect(), mine[odd].first().copied())
    } else if mine.len() < given.len() {
        let odd = loneliest(&given, &mine);
        let faces = theirs[odd].iter().map(|v| deviation.coverage_face[*v]);
        (faces.collect(), given[odd].first().copied())
    } else {
        // Parts or handles differ: where the mesh is farthest from the surface.
        let distances = deviation.coverage_distance.enumerate();
        let far = distances.max_by(|a, b| a.1.total_cmp(b.1)).map(|d| d.0);
        let faces = far.map(|v| deviation.coverage_face[v]);
        (
            faces.into_iter().collect(),
            far.map(|v| surface.positions()[v]),
        )
    };
    check.at(faces, place).advised(
        "more panels; a hole or a handle is closed or torn, or parts hang together by a corner",
    )
}

/// The loop that is farthest from all of the others.
fn loneliest(loops: &[Vec<Vec3>], others: &[Vec<Vec3>]) -> usize {
    let others = BoundaryCurve::of_polylines(others);
    let gap = |l: &Vec<Vec3>| {
        let to = |p: &Vec3| {
            let distance = |o: &BoundaryCurve| (o.closest_point(*p).position - p).norm();
            others.as_ref().map_or(f64::INFINITY, distance)
        };
        l.iter().map(to).fold(0.0, f64::max)
    };
    let gaps: Vec<f64> = loops.iter().map(gap).collect();
    let order = (0..gaps.len()).max_by(|&i, &j| gaps[i].total_cmp(&gaps[j]));
    order.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rim of many vertices lies on the one of four, far from its corners.
    #[test]
    fn the_loneliest_loop_is_far_from_edges_and_not_from_corners_alone() {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let square = |extent: f64| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
            corners.map(|(x, y)| at(extent * x, extent * y)).to_vec()
        };
        let rim = (0..=40).map(|k| at(0.25 * f64::from(k), 0.0)).collect();
        let hole = square(0.4).iter().map(|p| p + at(0.3, 0.3)).collect();
        assert_eq!(loneliest(&[hole, rim], &[square(10.0)]), 0);
    }
}
