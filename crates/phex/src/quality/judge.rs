//! The judge: by how much each face of a mesh, or of a part of one, is outside its limits.

use super::advice::crossings_of;
use super::findings::Findings;
use super::merit::Merit;
use super::{Limits, References, USUAL_DEVIATION};
use phex_mesh::measure::{
    LEAST_RIM_AREA, WANTED_ANGLE, WANTED_LENGTH, WANTED_RIM_AREA, WANTED_RIM_ASPECT,
    WANTED_RIM_DISTANCE, aspect, boundary_fit, points_on_boundary, wanted_clearance,
};
use phex_mesh::polygon::{interior_angles, sides};
use phex_mesh::validate::{ValidateOptions, Violation, add_flips, violations};
use phex_mesh::{
    BoundaryCurve, FaceId, FlatFace, HexMesh, PerFace, PerVertex, TriangleSurface, Vec3, VertexId,
    closest_faces,
};

/// Excess over a limit, in limits, above which it does not matter how far it is exceeded.
const LARGEST_EXCESS: f64 = 10.0;

/// What a distance between the boundaries costs that is twice as large as it should be.
const RAGGED: f64 = 0.5;

/// What lengths and areas of a part are compared with: those of the whole mesh.
#[derive(Clone, Copy, Debug)]
pub struct Yardstick {
    /// Mean length of the edges.
    pub mean_edge: f64,
    /// Mean area of the faces.
    pub mean_area: f64,
    /// Mean area of the inner faces, and mean length of their edges.
    inner: [f64; 2],
    /// Number of faces.
    pub panels: usize,
    /// Largest planarity, mean edges.
    planarity: f64,
    /// What of the shapes of faces counts: nothing as long as something is worse.
    pub shapes: Shapes,
}

impl Yardstick {
    /// That of a mesh, in which shapes do not count.
    pub fn of(mesh: &HexMesh, limits: &Limits) -> Self {
        let panels = mesh.topology().n_faces();
        let flat = FlatFace::all(mesh);
        let area: f64 = flat.iter().map(FlatFace::area).sum();
        Self {
            mean_edge: mesh.mean_edge(),
            mean_area: area / panels as f64,
            inner: inner_means(mesh, &flat),
            panels,
            planarity: limits.validity.planarity_limit(mesh),
            shapes: Shapes::Any,
        }
    }

    /// How large a face should be: an inner one as the area that it is to have, if that is more
    /// than the mean of the inner ones.
    pub fn wanted_size(&self, at_rim: bool, wished: f64) -> WantedSize {
        let [area, edge] = self.inner;
        let length = WANTED_LENGTH * edge * (wished / area).sqrt().max(1.0);
        let counts = self.shapes >= Shapes::Sizes;
        WantedSize {
            edge: (counts && !at_rim && wished > 0.0).then_some(length),
            area: (counts && at_rim).then_some(WANTED_RIM_AREA * self.mean_area),
            aspect: (counts && at_rim).then_some(WANTED_RIM_ASPECT),
        }
    }

    /// Notes by how much the sharpest corner of a face is below what it should be, and its longest
    /// edge and its area are above.
    fn add_shape(&self, flat: &FlatFace, wanted: &WantedSize, found: &mut Findings) {
        let polygon = &flat.polygon;
        let least = interior_angles(polygon).fold(f64::INFINITY, f64::min);
        let lengths = sides(polygon).map(|[a, b]| (b - a).norm());
        let beyond =
            |value: f64, most: Option<f64>| most.map_or(0.0, |most| (value / most - 1.0).max(0.0));
        found.sharp = (1.0 - least.to_degrees() / WANTED_ANGLE).max(0.0);
        found.large = beyond(lengths.fold(0.0, f64::max), wanted.edge);
        found.large += beyond(flat.area(), wanted.area);
        // A face without width has an infinite aspect.
        let slender = |most: f64| (1.0 - most / aspect(polygon)).max(0.0);
        found.large += wanted.aspect.map_or(0.0, slender);
    }
}

/// Mean area of the inner faces, and mean length of their edges.
fn inner_means(mesh: &HexMesh, flat: &PerFace<FlatFace>) -> [f64; 2] {
    let topology = mesh.topology();
    let inner = || topology.inner_faces();
    let areas: Vec<f64> = inner().map(|f| flat[f].area()).collect();
    let edges = inner().flat_map(|f| topology.face_half_edges(f));
    let lengths: Vec<f64> = edges.map(|h| mesh.edge_length(topology.edge(h))).collect();
    [areas, lengths].map(|all| all.iter().sum::<f64>() / all.len().max(1) as f64)
}

/// What counts that is allowed and not liked in the shapes of faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shapes {
    /// Nothing.
    #[default]
    Any,
    /// Sharp corners.
    Corners,
    /// Sharp corners, long edges of inner faces, and large or slender faces at the boundary.
    Sizes,
}

/// How large a face should be at the most, and need not be.
#[derive(Clone, Copy, Debug)]
pub struct WantedSize {
    /// Length of its edges.
    pub edge: Option<f64>,
    /// Its area.
    pub area: Option<f64>,
    /// Its length over its width.
    pub aspect: Option<f64>,
}

/// What is looked at: a mesh, or a part of one as a mesh of its own.
pub struct Scope<'a> {
    /// The mesh.
    pub mesh: &'a HexMesh,
    /// Whether each face counts; in a part those at its rim do not.
    pub counts: &'a [bool],
    /// Vertices of the surface that the faces are to cover.
    pub points: &'a [VertexId],
    /// Area that each face is to have; 0 for any.
    pub wished: &'a [f64],
}

/// What a judge says.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// By face.
    pub of_face: PerFace<Findings>,
    /// In all.
    pub merit: Merit,
    /// The face closest to each of the points that were to be covered, and its distance, a length.
    pub closest: Vec<(FaceId, f64)>,
}

impl Judgement {
    /// The same where shapes count; nothing if there is nothing against them.
    pub fn counting_shapes(
        &self,
        mesh: &HexMesh,
        wished: &[f64],
        yardstick: &Yardstick,
    ) -> Option<Self> {
        let mut found = self.clone();
        for (f, flat) in FlatFace::all(mesh).enumerate() {
            let at_rim = mesh.topology().is_boundary_face(f);
            let wanted = yardstick.wanted_size(at_rim, wished[f.index()]);
            yardstick.add_shape(flat, &wanted, &mut found.of_face[f]);
            found.merit.cost += found.of_face[f].misshapen();
        }
        (found.merit.cost > self.merit.cost).then_some(found)
    }

    /// The same of a whole mesh where shapes do not count.
    pub(crate) fn without_shapes(mut self) -> Self {
        for face in self.of_face.iter_mut() {
            (face.sharp, face.large) = (0.0, 0.0);
        }
        self.merit = Merit::of(self.of_face.iter(), self.of_face.len());
        self
    }

    /// What sharp corners cost.
    pub fn sharp(&self) -> f64 {
        self.of_face.iter().map(|face| face.sharp).sum()
    }

    /// What irregular and uneven faces cost, of all of a mesh.
    pub(crate) fn irregular_and_uneven(&self) -> f64 {
        let mean = |of: &dyn Fn(&Findings) -> f64| {
            let sum: f64 = self.of_face.iter().map(of).sum();
            sum / self.of_face.len().max(1) as f64
        };
        let irregular = mean(&|face| f64::from(u8::from(face.irregular)));
        Merit::cost_of_layout(irregular, mean(&|face| face.uneven), 0.0)
    }

    /// How bad the faces are that count.
    pub fn amount(&self, counts: &[bool]) -> f64 {
        let faces = self.of_face.as_slice().iter().zip(counts);
        faces.filter(|(_, c)| **c).map(|(f, _)| f.amount()).sum()
    }
}

/// Surfaces and limits by which meshes are judged.
pub struct Judge<'a> {
    references: References<'a>,
    surface: &'a TriangleSurface,
    limits: Limits,
    curve: Option<BoundaryCurve>,
    on_boundary: PerVertex<bool>,
    diagonal: f64,
}

impl<'a> Judge<'a> {
    /// The judge of meshes that stand for a smooth surface, and for what `others` has besides.
    pub fn new(surface: &'a TriangleSurface, others: References<'a>, limits: Limits) -> Self {
        let topology = surface.topology();
        let references = References {
            smooth: Some(surface),
            ..others
        };
        Self {
            on_boundary: PerVertex::from_fn(topology.n_vertices(), |v| {
                topology.is_boundary_vertex(v)
            }),
            diagonal: surface.diagonal(),
            curve: BoundaryCurve::of(surface),
            references,
            surface,
            limits,
        }
    }

    /// The surface that meshes are compared with.
    pub fn surface(&self) -> &'a TriangleSurface {
        self.surface
    }

    /// The limits.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// All vertices of the surface.
    pub fn points(&self) -> Vec<VertexId> {
        self.surface.topology().vertices().collect()
    }

    /// Looks at a whole mesh.
    pub fn whole(&self, mesh: &HexMesh, wished: &[f64]) -> Judgement {
        self.whole_by(&Yardstick::of(mesh, &self.limits), mesh, wished)
    }

    /// The same with a yardstick of its own.
    pub fn whole_by(&self, yardstick: &Yardstick, mesh: &HexMesh, wished: &[f64]) -> Judgement {
        let scope = Scope {
            mesh,
            counts: &vec![true; mesh.topology().n_faces()],
            points: &self.points(),
            wished,
        };
        self.judge(&scope, yardstick)
    }

    /// Looks at a mesh or a part of one.
    pub fn judge(&self, scope: &Scope<'_>, yardstick: &Yardstick) -> Judgement {
        let mesh = scope.mesh;
        let mut of_face: PerFace<Findings> =
            PerFace::filled(mesh.topology().n_faces(), Findings::default());
        self.add_violations(mesh, yardstick, &mut of_face);
        self.add_distances(mesh, &mut of_face);
        let closest = self.closest_faces(mesh, scope.points);
        self.add_coverage((scope.points, &closest), yardstick, &mut of_face);
        self.add_boundary(scope, &closest, yardstick, &mut of_face);
        self.add_panel_limits(mesh, &mut of_face);
        add_shapes(scope, yardstick, &mut of_face);
        let counted = of_face.as_slice().iter().zip(scope.counts);
        let counted = counted.filter(|(_, c)| **c).map(|(f, _)| f);
        Judgement {
            merit: Merit::of(counted, yardstick.panels),
            of_face,
            closest,
        }
    }

    /// The merit of a whole mesh, and by how much it covers less of the surface than it is to,
    /// which no single panel lacks.
    pub(crate) fn with_cover(&self, merit: Merit, mesh: &HexMesh) -> Merit {
        let limit = self
            .limits
            .covered
            .filter(|_| self.references.elsewhere.is_empty());
        let lacks = |limit: f64| {
            let fit = boundary_fit(mesh, self.surface)?;
            Some((1.0 - fit.covered_area / limit).max(0.0_f64))
        };
        Merit {
            outside: merit.outside + limit.and_then(lacks).unwrap_or(0.0),
            ..merit
        }
    }

    /// The face closest to each of some points of the surface, and its distance, a length.
    pub fn closest_faces(&self, mesh: &HexMesh, points: &[VertexId]) -> Vec<(FaceId, f64)> {
        let places: Vec<Vec3> = self.places(points).collect();
        closest_faces(mesh, &places)
    }

    fn places(&self, points: &[VertexId]) -> impl Iterator<Item = Vec3> {
        points.iter().map(|v| self.surface.positions()[*v])
    }

    /// What lies at the rim of a part is judged as far as it can be seen.
    fn add_violations(
        &self,
        mesh: &HexMesh,
        yardstick: &Yardstick,
        of_face: &mut PerFace<Findings>,
    ) {
        let scale = yardstick.mean_edge / mesh.mean_edge();
        let validity = &self.limits.validity;
        let options = ValidateOptions {
            planarity: Some(yardstick.planarity * scale),
            edge_length_rel: validity.edge_length_rel * scale,
            clearance: validity.clearance * scale,
            ..*validity
        };
        let mut found = violations(mesh, Some(self.surface), &options);
        if let Some(facets) = self.references.facets {
            add_flips(&mut found, mesh, facets);
        }
        let facets = self.references.facets.unwrap_or(self.surface);
        let is_own = crossings_of(facets, mesh);
        for violation in &found {
            if is_own(violation) {
                continue;
            }
            let faces = violation.faces(mesh.topology());
            let share = 1.0 / faces.len().max(1) as f64;
            for f in &faces {
                add_violation(violation, share, &mut of_face[*f]);
            }
            if let (Violation::Crossing { face, .. }, Some(other)) = (violation, faces.first()) {
                of_face[*face].crossed = Some(*other);
                of_face[*other].crossed = Some(*face);
            }
        }
    }

    /// What a workshop can't make.
    fn add_panel_limits(&self, mesh: &HexMesh, of_face: &mut PerFace<Findings>) {
        for figure in self.limits.panels.figures(mesh) {
            let excess = figure.excess().min(LARGEST_EXCESS);
            for f in figure.faces.into_iter().flatten().filter(|_| excess > 0.0) {
                let face = &mut of_face[f];
                face.unfit += excess;
                face.too_large |= figure.kind.wants_smaller();
            }
        }
    }

    /// Largest distance between panels and surface that is allowed, a length.
    pub fn largest_distance(&self) -> f64 {
        self.diagonal * self.limits.deviation_rel.unwrap_or(USUAL_DEVIATION)
    }

    fn excess(&self, limit: Option<f64>, distance: f64) -> f64 {
        let over =
            |limit: f64| (distance / (limit * self.diagonal) - 1.0).clamp(0.0, LARGEST_EXCESS);
        limit.map_or(0.0, over)
    }

    fn add_distances(&self, mesh: &HexMesh, of_face: &mut PerFace<Findings>) {
        let surface = self.references.beyond.map_or(self.surface, |b| b[0]);
        let distances = |points: &[Vec3]| -> Vec<f64> {
            let feet = surface.closest_points(points);
            let pairs = points.iter().zip(&feet);
            pairs.map(|(p, foot)| (foot.position - p).norm()).collect()
        };
        let corners = distances(mesh.positions.as_slice());
        let centres = distances(mesh.centres().as_slice());
        for (f, centre) in mesh.topology().faces().zip(centres) {
            let vertices = mesh.topology().face_vertices(f).iter();
            let farthest = vertices.map(|v| corners[v.index()]).fold(centre, f64::max);
            let face = &mut of_face[f];
            face.off = face.off.max(farthest / self.largest_distance());
            face.far = self.excess(self.limits.deviation_rel, farthest);
        }
    }

    /// Points of the surface that are farther from a mesh of `n_faces` than a share of the largest
    /// distance, by the face that is `closest` to each; those near the boundary do not count.
    pub fn far_points(
        &self,
        n_faces: usize,
        (points, closest): (&[VertexId], &[(FaceId, f64)]),
        (mean_edge, share): (f64, f64),
    ) -> Vec<Vec<Vec3>> {
        let mut far = vec![Vec::new(); n_faces];
        for (p, &(f, distance)) in self.places(points).zip(closest) {
            if distance > share * self.largest_distance() && self.is_inside(p, f, mean_edge) {
                far[f.index()].push(p);
            }
        }
        far
    }

    /// Whether a point of the surface is so far from its boundary that it is to be covered; `f` is
    /// the face that is closest to it.
    fn is_inside(&self, p: Vec3, f: FaceId, mean_edge: f64) -> bool {
        let is_led = self.references.is_led(f);
        let rim = (self.limits).bare_rim([mean_edge, self.diagonal], is_led);
        self.curve.as_ref().is_none_or(|c| !c.is_within(p, rim))
    }

    fn add_coverage(
        &self,
        (points, closest): (&[VertexId], &[(FaceId, f64)]),
        yardstick: &Yardstick,
        of_face: &mut PerFace<Findings>,
    ) {
        for (p, &(f, distance)) in self.places(points).zip(closest) {
            let face = &mut of_face[f];
            let off = distance / self.largest_distance();
            let bare = self.excess(self.limits.deviation_rel, distance);
            let adds = off > face.off || bare > face.bare;
            if adds && self.is_inside(p, f, yardstick.mean_edge) {
                face.off = face.off.max(off);
                face.bare = face.bare.max(bare);
            }
        }
    }

    /// How far the boundaries are apart, from both.
    fn add_boundary(
        &self,
        scope: &Scope<'_>,
        closest: &[(FaceId, f64)],
        yardstick: &Yardstick,
        of_face: &mut PerFace<Findings>,
    ) {
        let (Some(curve), Some(limit)) = (&self.curve, self.limits.boundary_rel) else {
            return;
        };
        let is_led = |f: &FaceId| self.references.is_led(*f);
        let counts = |f: &FaceId| scope.counts[f.index()] && !is_led(f);
        let rim = points_on_boundary(scope.mesh);
        let mut add = |f: FaceId, distance: f64| {
            let face = &mut of_face[f];
            face.rim = face.rim.max(self.excess(Some(limit), distance));
            let seen = distance / yardstick.mean_edge / WANTED_RIM_DISTANCE;
            face.ragged = face.ragged.max(RAGGED * (seen - 1.0));
        };
        for (f, p) in rim.iter().filter(|(f, _)| counts(f)) {
            add(*f, (curve.closest_point(*p).position - p).norm());
        }
        let Some(own) = rim_curve(scope, &rim) else {
            return;
        };
        let points = scope.points.iter().zip(closest);
        for (v, (f, _)) in points.filter(|(v, (f, _))| self.on_boundary[**v] && !is_led(f)) {
            let p = self.surface.positions()[*v];
            add(*f, (own.closest_point(p).position - p).norm());
        }
    }
}

/// The boundary edges of the faces of a scope as curves.
fn rim_curve(scope: &Scope<'_>, rim: &[(FaceId, Vec3)]) -> Option<BoundaryCurve> {
    let topology = scope.mesh.topology();
    if rim.is_empty() {
        return None;
    }
    let edges = topology.boundary_edges();
    let ends = edges.map(|e| {
        let ends = topology.edge_vertices(e).map(|v| scope.mesh.position(v));
        ends.to_vec()
    });
    BoundaryCurve::of_polylines(&ends.collect::<Vec<_>>())
}

fn add_violation(violation: &Violation, share: f64, face: &mut Findings) {
    match *violation {
        Violation::NotPlanar {
            planarity, limit, ..
        } => {
            // From the limit, counted as a hundredth, to a mean edge, counted as 1.
            let decades = (planarity / limit).log10() / -limit.log10();
            face.invalid += share * decades.clamp(0.01, 1.0);
        }
        Violation::Fold { .. } => face.folded += share,
        Violation::SmallClearance {
            clearance, limit, ..
        } => face.narrow += share * (1.0 - clearance / limit),
        Violation::CollapsedEdge {
            length_rel, limit, ..
        } => face.narrow += share * (1.0 - length_rel / limit),
        _ => face.invalid += share,
    }
}

/// Room, areas and corners.
fn add_shapes(scope: &Scope<'_>, yardstick: &Yardstick, of_face: &mut PerFace<Findings>) {
    let topology = scope.mesh.topology();
    for (f, flat) in FlatFace::all(scope.mesh).enumerate() {
        if !scope.counts[f.index()] {
            continue;
        }
        let face = &mut of_face[f];
        let (area, at_rim) = (flat.area(), topology.is_boundary_face(f));
        let clearance = flat.clearance().distance / yardstick.mean_edge;
        let wanted = wanted_clearance(area / yardstick.mean_area);
        face.tight = (1.0 - clearance / wanted).max(0.0).powi(2);
        face.irregular = !at_rim && topology.valence(f) != 6;
        let wished = scope.wished[f.index()];
        if yardstick.shapes >= Shapes::Corners {
            yardstick.add_shape(flat, &yardstick.wanted_size(at_rim, wished), face);
        }
        if !at_rim && wished > 0.0 && area > 0.0 {
            face.uneven = (area / wished).ln().powi(2);
        }
        if at_rim {
            let share = area / yardstick.mean_area / LEAST_RIM_AREA;
            face.small = if share < 1.0 { 1.5 - share } else { 0.0 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::tests::fixtures::{Shape, brick_wall};
    use crate::quality::{Assessment, defects};
    use crate::trim::Boundary;

    /// A wall of flat bricks, and the rectangle around it.
    fn wall() -> (TriangleSurface, HexMesh) {
        let wall = brick_wall(Shape::Square, 25, 12);
        let (mut low, mut high) = (wall.position(VertexId::new(0)), Vec3::zeros());
        wall.positions
            .iter()
            .for_each(|p| (low, high) = (low.inf(p), high.sup(p)));
        let n = 30;
        let at = |v: u32| Vec3::new(f64::from(v % (n + 1)), f64::from(v / (n + 1)), 0.0);
        let place = |v: u32| low + at(v).component_mul(&(high - low)) / f64::from(n);
        let cells = (0..n * n).map(|c| c % n + (c / n) * (n + 1));
        let triangles = cells.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        let places = (0..(n + 1) * (n + 1)).map(place).collect();
        let surface = TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap();
        (surface, wall)
    }

    fn judge(surface: &TriangleSurface) -> Judge<'_> {
        let limits = Limits::new(Some(5e-3), None);
        Judge::new(surface, References::default(), limits)
    }

    /// The wall with one inner vertex moved.
    fn moved(mesh: &HexMesh, by: Vec3) -> (HexMesh, VertexId) {
        let topology = mesh.topology();
        let mut vertices = topology.vertices();
        let near = |v: &VertexId| mesh.position(*v).norm() < 0.15 && topology.face_degree(*v) == 3;
        let v = vertices.find(near).unwrap();
        let mut positions = mesh.positions.as_slice().to_vec();
        positions[v.index()] += by;
        (mesh.with_positions(PerVertex::from_vec(positions)), v)
    }

    #[test]
    fn the_judge_and_the_report_agree() {
        let (surface, wall) = wall();
        let judge = judge(&surface);
        let edge = wall.mean_edge();
        let shifts = [
            Vec3::zeros(),
            Vec3::new(0.0, 0.0, 1e-3 * edge),
            Vec3::new(0.0, 0.0, 2.0 * edge),
            Vec3::new(3.0 * edge, 0.0, 0.0),
            Vec3::new(0.3 * edge, 0.2 * edge, 0.0),
        ];
        let mut within = Vec::new();
        for by in shifts {
            let (mesh, _) = moved(&wall, by);
            let any = vec![0.0; mesh.topology().n_faces()];
            let merit = judge.whole(&mesh, &any).merit;
            let told = Assessment::new(&mesh, judge.references, judge.limits());
            let failures: Vec<&str> = told.failures().map(|c| c.name).collect();
            assert_eq!(merit.is_within(), failures.is_empty(), "{by}: {failures:?}");
            within.push(merit.is_within());
        }
        assert_eq!(within, [true, false, false, false, true], "{edge}");
    }

    /// What shapes are said to cost, where they count; the same as a judge says who counts them
    /// from the start.
    fn shaped(mesh: &HexMesh, wished: &[f64], shapes: Shapes) -> Option<Judgement> {
        let (surface, _) = wall();
        let judge = judge(&surface);
        let plain = judge.whole(mesh, wished);
        let mut yardstick = Yardstick::of(mesh, judge.limits());
        yardstick.shapes = shapes;
        let found = plain.counting_shapes(mesh, wished, &yardstick)?;
        let judged = judge.whole_by(&yardstick, mesh, wished);
        assert!((judged.merit.cost - found.merit.cost).abs() < 1e-9);
        assert!(found.merit.cost > plain.merit.cost);
        let without = judged.clone().without_shapes();
        assert_eq!(without.merit, plain.merit);
        assert_eq!(without.of_face, plain.of_face);
        for (f, face) in plain.of_face.enumerate() {
            assert!(face.misshapen() == 0.0);
            assert_eq!(found.of_face[f].misshapen(), judged.of_face[f].misshapen());
        }
        Some(found)
    }

    #[test]
    fn sharp_corners_count_where_they_are_asked_for() {
        let (_, wall) = wall();
        let any = vec![0.0; wall.topology().n_faces()];
        assert!(shaped(&wall, &any, Shapes::Any).is_none());
        assert!(shaped(&wall, &any, Shapes::Corners).is_none());
        // The right angles of bricks become such of 14 degrees.
        let sheared = wall.positions.map(|p| Vec3::new(p.x + 4.0 * p.y, p.y, p.z));
        let sheared = wall.with_positions(sheared);
        let expected = 1.0 - 0.25_f64.atan().to_degrees() / WANTED_ANGLE;
        let found = shaped(&sheared, &any, Shapes::Corners).unwrap();
        for face in found.of_face.iter() {
            // Six degrees are more than another weight would cure.
            assert!((face.sharp - expected).abs() < 1e-9 && !face.is_slight());
        }
        assert!((found.sharp() - expected * any.len() as f64).abs() < 1e-9);
    }

    #[test]
    fn long_edges_and_large_panels_at_the_boundary_count_after_corners() {
        let (surface, wall) = wall();
        let areas: Vec<f64> = FlatFace::all(&wall).iter().map(FlatFace::area).collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        let (edge, any) = (wall.mean_edge(), vec![mean; areas.len()]);
        // A corner inside moves so far that the edges there become long.
        let topology = wall.topology();
        let is_inner = |f: &FaceId| !topology.is_boundary_face(*f);
        let inner = topology.faces().find(is_inner).unwrap();
        let v = topology.origin(topology.face_half_edges(inner).next().unwrap());
        let long = |by: f64| {
            let mut positions = wall.positions.clone();
            positions[v] += Vec3::new(0.0, by * edge, 0.0);
            wall.with_positions(positions)
        };
        assert!(shaped(&wall, &any, Shapes::Sizes).is_none());
        let moved = long(3.0);
        let found = shaped(&moved, &any, Shapes::Sizes).unwrap();
        assert!(found.of_face[inner].large > 0.0);
        // At the boundary it is the area that counts.
        let mut yardstick = Yardstick::of(&wall, judge(&surface).limits());
        yardstick.shapes = Shapes::Sizes;
        let at_rim = yardstick.wanted_size(true, mean);
        assert!(
            at_rim.edge.is_none() && at_rim.area == Some(WANTED_RIM_AREA * yardstick.mean_area)
        );
        let rim = wall
            .topology()
            .faces()
            .find(|f| wall.topology().is_boundary_face(*f));
        let flat = &FlatFace::all(&wall)[rim.unwrap()];
        yardstick.mean_area = flat.area() / (1.5 * WANTED_RIM_AREA);
        let mut face = Findings::default();
        yardstick.add_shape(flat, &yardstick.wanted_size(true, mean), &mut face);
        assert!((face.large - 0.5).abs() < 1e-9 && face.sharp == 0.0);
        // Where areas are to be four times as large edges may be twice as long.
        let wished = vec![4.0 * mean; areas.len()];
        let fewer = shaped(&moved, &wished, Shapes::Sizes);
        let large = |found: &Judgement| found.of_face.iter().map(|f| f.large).sum::<f64>();
        assert!(fewer.map_or(0.0, |f| large(&f)) < large(&found));
        // Bricks of any proportions may be drawn out inside, but not at the boundary.
        let slender = wall.positions.map(|p| Vec3::new(6.0 * p.x, p.y, p.z));
        let flat = &FlatFace::all(&wall.with_positions(slender))[inner];
        let beyond = 1.0 - WANTED_RIM_ASPECT / aspect(&flat.polygon);
        yardstick.mean_area = flat.area();
        for (at_rim, expected) in [(true, beyond), (false, 0.0)] {
            let mut face = Findings::default();
            yardstick.inner[1] = f64::MAX;
            yardstick.add_shape(flat, &yardstick.wanted_size(at_rim, mean), &mut face);
            assert!((face.large - expected).abs() < 1e-9 && beyond > 0.3);
        }
    }

    #[test]
    fn a_ragged_boundary_costs_by_the_size_of_panels_within_its_limit() {
        let (surface, wall) = wall();
        let limits = Limits::new(Some(5e-3), Some(Boundary::Snap));
        let judge = Judge::new(&surface, References::default(), limits);
        let edge = wall.mean_edge();
        let rim = |v: &VertexId| wall.topology().is_boundary_vertex(*v);
        let low = |v: &VertexId| wall.position(*v).y;
        let rim: Vec<VertexId> = wall.topology().vertices().filter(rim).collect();
        let v = rim.into_iter().min_by(|a, b| low(a).total_cmp(&low(b)));
        // The farther the lowest corner lies below the surface the more its panels cost.
        let with = |below: f64| {
            let mut positions = wall.positions.clone();
            positions[v.unwrap()].y -= below * edge;
            let any = vec![0.0; wall.topology().n_faces()];
            let moved = wall.with_positions(positions);
            let judged = judge.whole(&moved, &any);
            let at = wall.topology().faces_at(v.unwrap());
            let ragged = at.map(|f| judged.of_face[f].ragged).fold(0.0, f64::max);
            let off = below * edge / moved.mean_edge();
            (ragged, RAGGED * (off / WANTED_RIM_DISTANCE - 1.0))
        };
        for below in [3.0, 4.0] {
            let (found, expected) = with(below);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn defects_are_where_the_mesh_was_spoiled() {
        let (surface, wall) = wall();
        let edge = wall.mean_edge();
        let (mesh, v) = moved(&wall, Vec3::new(0.0, 0.0, 0.5 * edge));
        let any = vec![0.0; mesh.topology().n_faces()];
        let found = defects(&mesh, &judge(&surface).whole(&mesh, &any));
        let around: Vec<FaceId> = mesh.topology().faces_at(v).collect();
        assert!(!found[0].is_allowed && around.contains(&found[0].faces[0]));
        let named: Vec<FaceId> = found.iter().flat_map(|d| d.faces.clone()).collect();
        assert!(around.iter().all(|f| named.contains(f)), "{named:?}");
        let near = |f: &FaceId| (mesh.centre(*f) - mesh.position(v)).norm() < 3.0 * edge;
        assert!(named.iter().all(near), "{found:?}");
    }

    #[test]
    fn a_part_is_judged_as_it_is_in_the_whole() {
        let (surface, wall) = wall();
        let judge = judge(&surface);
        let (mesh, v) = moved(&wall, Vec3::new(0.0, 0.0, 0.5 * wall.mean_edge()));
        let any = vec![0.0; mesh.topology().n_faces()];
        let whole = judge.whole(&mesh, &any);
        let topology = mesh.topology();
        let near = |f: &FaceId| (mesh.centre(*f) - mesh.position(v)).norm() < 0.5;
        let faces: Vec<FaceId> = topology.faces().filter(near).collect();
        let lists: Vec<Vec<u32>> = (faces.iter())
            .map(|f| {
                topology
                    .face_vertices(*f)
                    .iter()
                    .map(|v| v.index() as u32)
                    .collect()
            })
            .collect();
        let part = crate::trim::compact(mesh.positions.as_slice(), &lists).unwrap();
        let inner = |f: FaceId| (mesh.centre(f) - mesh.position(v)).norm() < 0.3;
        let counts: Vec<bool> = faces.iter().map(|f| inner(*f)).collect();
        let scope = Scope {
            mesh: &part,
            counts: &counts,
            points: &[],
            wished: &vec![0.0; faces.len()],
        };
        let judged = judge.judge(&scope, &Yardstick::of(&mesh, judge.limits()));
        let mut compared = 0;
        for (k, f) in faces.iter().enumerate().filter(|(k, _)| counts[*k]) {
            let (a, b) = (&judged.of_face.as_slice()[k], &whole.of_face[*f]);
            // A part has another mean edge, and planarity counts by decades.
            assert!((a.invalid - b.invalid).abs() < 1e-2, "{f}: {a:?} {b:?}");
            assert!((a.far - b.far).abs() < 1e-9 && (a.tight - b.tight).abs() < 1e-9);
            compared += 1;
        }
        assert!(compared > 5);
        assert!((judged.merit.invalid - whole.merit.invalid).abs() < 0.05);
    }
}
