//! Measures, checks and verdict of a mesh.

use phex_mesh::measure::{
    BoundaryFit, Deviation, MeshMeasures, boundary_fit, deviation_beyond, measure,
};
use phex_mesh::validate::{ValidateOptions, Violation, planarity_floor, violations};
use phex_mesh::{HexMesh, TriangleSurface, add_flips};
use serde::{Deserialize, Serialize};

/// What a mesh must keep to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tolerances {
    /// Limits of validity; lengths in mean edges.
    pub validity: ValidateOptions,
    /// Largest distance between mesh and reference surface, over the diagonal of the surface's bounding box; `None` does
    /// not limit it. PH-CPF allows 0.005.
    pub deviation_rel: Option<f64>,
    /// What the mesh must keep to at the boundary of an open surface; `None` does not limit it.
    pub boundary: Option<BoundaryLimit>,
}

/// What a mesh must keep to at the boundary of an open surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryLimit {
    /// The two boundaries lie within this distance of each other, over the diagonal of the surface's bounding box.
    Follows(f64),
    /// Panels cover at least this share of the surface's area.
    Covers(f64),
}

/// The surfaces that a mesh stands for, in its coordinates.
#[derive(Clone, Copy, Default)]
pub struct References<'a> {
    /// The smooth surface through the input's vertices, which the optimiser looked at.
    pub smooth: Option<&'a TriangleSurface>,
    /// The input's facets.
    pub facets: Option<&'a TriangleSurface>,
    /// Both continued beyond the boundary, where panels may stick out: their distance is measured to these.
    pub beyond: Option<[&'a TriangleSurface; 2]>,
}

impl<'a> References<'a> {
    /// The surface that the tolerances refer to: the smooth one where there is one.
    fn judge(&self) -> Option<&'a TriangleSurface> {
        self.smooth.or(self.facets)
    }
}

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

/// A figure, its limit, and the elements that exceed it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Name, as in the table of the documentation.
    pub name: &'static str,
    /// The limit; a smallest one for `edge_length`, `clearance` and `covered_area`, else a largest one.
    pub limit: f64,
    /// The figure; for checks that count, the number of offenders.
    pub value: f64,
    /// Whether the check holds.
    pub pass: bool,
    /// Whether a failure means that the mesh is no panelling at all.
    pub decisive: bool,
    /// What the ids number.
    pub element: ElementKind,
    /// The offenders, in order.
    pub ids: Vec<usize>,
}

/// What the checks amount to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every check holds.
    Pass,
    /// A valid mesh, but a figure is outside its limit.
    OutsideTolerance,
    /// No valid mesh.
    Invalid,
}

/// Measures, deviations, violations, checks and verdict of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assessment {
    /// What the checks amount to.
    pub verdict: Verdict,
    /// Every check that was made.
    pub checks: Vec<Check>,
    /// Figures of the mesh.
    pub measures: MeshMeasures,
    /// Distance to the smooth target.
    pub deviation_smooth: Option<Deviation>,
    /// Distance to the original facets.
    pub deviation_facets: Option<Deviation>,
    /// How the mesh ends where the surface ends; `None` without a surface, or if one of the two is closed.
    pub boundary: Option<BoundaryFit>,
    /// Everything that is wrong, located.
    pub violations: Vec<Violation>,
}

impl Assessment {
    /// Judges a mesh.
    pub fn new(mesh: &HexMesh, references: References<'_>, tolerances: &Tolerances) -> Self {
        let measures = measure(mesh);
        let mut violations = violations(mesh, references.judge(), &tolerances.validity);
        if let (Some(_), Some(facets)) = (references.smooth, references.facets) {
            add_flips(&mut violations, mesh, facets);
        }
        let away = |s, k: usize| deviation_beyond(mesh, s, references.beyond.map_or(s, |b| b[k]));
        let deviation_smooth = references.smooth.map(|s| away(s, 0));
        let deviation_facets = references.facets.map(|s| away(s, 1));
        let boundary = references.judge().and_then(|s| boundary_fit(mesh, s));
        let mut checks = validity_checks(mesh, &measures, &violations, &tolerances.validity);
        if let Some(deviation) = deviation_smooth.as_ref().or(deviation_facets.as_ref()) {
            checks.extend(surface_checks(mesh, deviation, tolerances));
        }
        if let (Some(fit), Some(limit)) = (&boundary, tolerances.boundary) {
            checks.push(boundary_check(fit, limit));
        }
        Self {
            verdict: verdict(&checks),
            checks,
            measures,
            deviation_smooth,
            deviation_facets,
            boundary,
            violations,
        }
    }

    /// The deviation that the tolerance refers to, where there is a surface.
    pub fn judged_deviation(&self) -> Option<&Deviation> {
        self.deviation_smooth
            .as_ref()
            .or(self.deviation_facets.as_ref())
    }

    /// The checks that do not hold.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|c| !c.pass)
    }
}

fn verdict(checks: &[Check]) -> Verdict {
    let of = |check: &Check| match (check.pass, check.decisive) {
        (true, _) => Verdict::Pass,
        (false, false) => Verdict::OutsideTolerance,
        (false, true) => Verdict::Invalid,
    };
    checks.iter().map(of).max().unwrap_or(Verdict::Pass)
}

/// Checks that count violations of a kind: name, kind, what the ids number, whether one offender is decisive.
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

fn validity_checks(
    mesh: &HexMesh,
    measures: &MeshMeasures,
    violations: &[Violation],
    limits: &ValidateOptions,
) -> Vec<Check> {
    let counted = COUNTED.map(|(name, kind, element, decisive)| {
        let ids = offenders(violations, kind);
        let value = ids.len() as f64;
        Check {
            name,
            limit: 0.0,
            value,
            pass: ids.is_empty(),
            decisive,
            element,
            ids,
        }
    });
    let planarity = limits.planarity.max(planarity_floor(mesh));
    let (clearance, edge) = (limits.clearance, limits.edge_length_rel);
    use ElementKind::{Edge, Face};
    let measured = [
        (
            "planarity",
            "not_planar",
            Face,
            planarity,
            measures.planarity.max,
        ),
        (
            "clearance",
            "small_clearance",
            Face,
            clearance,
            measures.clearance.min,
        ),
        (
            "edge_length",
            "collapsed_edge",
            Edge,
            edge,
            measures.edge_length.min,
        ),
    ];
    let measured = measured.map(|(name, kind, element, limit, value)| {
        let ids = offenders(violations, kind);
        Check {
            name,
            limit,
            value,
            pass: ids.is_empty(),
            decisive: false,
            element,
            ids,
        }
    });
    measured.into_iter().chain(counted).collect()
}

/// Numbers of the elements with a violation of a kind, in order.
fn offenders(violations: &[Violation], kind: &str) -> Vec<usize> {
    let of_kind = violations.iter().filter(|v| v.kind() == kind);
    let mut ids: Vec<usize> = of_kind.map(element).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// Number of the element that a violation is listed under.
fn element(violation: &Violation) -> usize {
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

fn surface_checks(mesh: &HexMesh, deviation: &Deviation, tolerances: &Tolerances) -> Vec<Check> {
    let mut checks = vec![topology_check(deviation)];
    let Some(limit) = tolerances.deviation_rel else {
        return checks;
    };
    let length = limit * deviation.diagonal;
    let topology = mesh.topology();
    let far = topology.faces().filter(|&f| {
        let corners = topology.face_vertices(f).iter();
        deviation.face_distance[f] > length
            || corners
                .into_iter()
                .any(|&v| deviation.vertex_distance[v] > length)
    });
    let within = |name, value: f64, element, ids| Check {
        name,
        limit,
        value,
        pass: value <= limit,
        decisive: false,
        element,
        ids,
    };
    let faces = far.map(|f| f.index()).collect();
    checks.push(within(
        "deviation",
        deviation.deviation_max,
        ElementKind::Face,
        faces,
    ));
    let value = deviation.coverage_inner_max;
    checks.push(within(
        "coverage_inner",
        value,
        ElementKind::Mesh,
        Vec::new(),
    ));
    checks
}

fn boundary_check(fit: &BoundaryFit, limit: BoundaryLimit) -> Check {
    let (name, limit, value, pass) = match limit {
        BoundaryLimit::Follows(limit) => {
            let distance = fit.distance_max();
            ("boundary", limit, distance, distance <= limit)
        }
        BoundaryLimit::Covers(limit) => {
            let covered = fit.covered_area;
            ("covered_area", limit, covered, covered >= limit)
        }
    };
    Check {
        name,
        limit,
        value,
        pass,
        decisive: false,
        element: ElementKind::Mesh,
        ids: Vec::new(),
    }
}

fn topology_check(deviation: &Deviation) -> Check {
    Check {
        name: "same_topology",
        limit: 0.0,
        value: f64::from(u8::from(!deviation.same_topology)),
        pass: deviation.same_topology,
        decisive: false,
        element: ElementKind::Mesh,
        ids: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// Three panels round one vertex; `lift` raises a corner of the first out of its plane, `slide` moves it along.
    fn three_panels(lift: f64, slide: f64) -> HexMesh {
        let mut positions = vec![Vec3::zeros()];
        for k in 0..6 {
            let a = std::f64::consts::FRAC_PI_3 * k as f64;
            positions.push(Vec3::new(a.cos(), a.sin(), 0.0));
        }
        positions[2] += Vec3::new(-slide, -slide, lift);
        HexMesh::new(positions, &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]).unwrap()
    }

    fn failing(a: &Assessment) -> Vec<&str> {
        a.failures().map(|c| c.name).collect()
    }

    #[test]
    fn flat_panels_pass() {
        let a = Assessment::new(
            &three_panels(0.0, 0.0),
            References::default(),
            &Tolerances::default(),
        );
        assert_eq!((a.verdict, failing(&a)), (Verdict::Pass, vec![]));
    }

    #[test]
    fn lifted_corner_is_outside_tolerance_and_named() {
        let a = Assessment::new(
            &three_panels(0.01, 0.0),
            References::default(),
            &Tolerances::default(),
        );
        assert_eq!(failing(&a), ["planarity"]);
        assert_eq!(a.verdict, Verdict::OutsideTolerance);
        let planarity = a.failures().next().unwrap();
        assert_eq!(planarity.ids, [0]);
        assert!(planarity.value > planarity.limit);
    }

    #[test]
    fn self_intersecting_panel_is_invalid() {
        let a = Assessment::new(
            &three_panels(0.0, 2.0),
            References::default(),
            &Tolerances::default(),
        );
        assert_eq!(a.verdict, Verdict::Invalid);
        assert!(
            failing(&a)
                .iter()
                .any(|name| ["faces_not_simple", "flipped_faces", "wrong_fans"].contains(name))
        );
    }

    #[test]
    fn distance_to_the_surface_is_judged_against_the_diagonal() {
        let square = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
        let positions = square
            .iter()
            .map(|&(x, y)| Vec3::new(x, y, -0.05))
            .collect();
        let surface = TriangleSurface::new(positions, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let references = References {
            facets: Some(&surface),
            ..Default::default()
        };
        let judged = |limit| {
            let tolerances = Tolerances {
                deviation_rel: Some(limit),
                ..Default::default()
            };
            Assessment::new(&three_panels(0.0, 0.0), references, &tolerances)
        };
        let rel = 0.05 / 32.0_f64.sqrt();
        assert!(!failing(&judged(rel * 1.001)).contains(&"deviation"));
        let strict = judged(rel * 0.999);
        let check = strict.failures().find(|c| c.name == "deviation").unwrap();
        assert_eq!(check.ids, [0, 1, 2]);
        assert!((check.value - rel).abs() < 1e-12);
    }
}
