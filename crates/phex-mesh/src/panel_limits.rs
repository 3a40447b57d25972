//! What a workshop can make: the largest sheet, the shortest and the longest edge, the sharpest
//! corner, the sharpest and the flattest joint.
//!
//! | limit | of | figure |
//! |---|---|---|
//! | `max_panel` | a face | the factor by which a rectangle of the sheet's proportions must grow to hold it, see [`rectangle_fit`] |
//! | `min_edge`, `max_edge` | an edge | its length |
//! | `min_angle` | a corner | interior angle in the face's plane, degrees |
//! | `max_area` | a face | its area |
//! | `max_aspect` | a face | length over width, see [`aspect`](crate::measure::aspect) |
//! | `min_dihedral`, `max_dihedral` | an inner edge | angle between its faces on the hollow side, degrees; 180 is flat |
//!
//! Figures that meet a limit but for rounding ([`ROUNDING`] of it) are within.

use crate::measure::aspect;
use crate::polygon::{HEXAGON, interior_angles, sides};
use crate::{EdgeId, FaceId, FlatFace, HexMesh, PerFace, Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Share of a limit that is rounding.
pub const ROUNDING: f64 = 1e-9;

/// Share of a rectangle that an affine image of a regular hexagon fills at the most.
const OF_RECTANGLE: f64 = 0.75;

/// Limits of panels, their edges and corners; `None` does not limit. Lengths are in the unit of the
/// mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PanelLimits {
    /// Sides of the rectangle from which a panel is cut, however it lies on it; > 0.
    pub max_panel: Option<[f64; 2]>,
    /// Length of the shortest edge, > 0.
    pub min_edge: Option<f64>,
    /// Length of the longest edge, > 0.
    pub max_edge: Option<f64>,
    /// Least interior angle of a panel, degrees, in (0, 180).
    pub min_angle: Option<f64>,
    /// Area of the largest panel, > 0.
    pub max_area: Option<f64>,
    /// Largest length over width of a panel, at least 1.
    pub max_aspect: Option<f64>,
    /// Least angle between neighbouring panels on the hollow side, degrees, in (0, 180]; 180 is
    /// flat.
    pub min_dihedral: Option<f64>,
    /// Largest such angle: joints of thin plates carry only where they are folded.
    pub max_dihedral: Option<f64>,
}

/// One of the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelLimit {
    /// The rectangle that holds each panel.
    MaxPanel,
    /// The shortest edge.
    MinEdge,
    /// The longest edge.
    MaxEdge,
    /// The sharpest corner.
    MinAngle,
    /// The largest panel.
    MaxArea,
    /// The longest panel for its width.
    MaxAspect,
    /// The sharpest joint.
    MinDihedral,
    /// The flattest joint.
    MaxDihedral,
}

/// A figure that a limit is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitedFigure {
    /// The limit.
    pub kind: PanelLimit,
    /// What is to hold; 1 for `MaxPanel`.
    pub limit: f64,
    /// What the mesh has, in the same unit.
    pub value: f64,
    /// Number of the edge, or of the face.
    pub element: usize,
    /// The faces that it concerns.
    pub faces: [Option<FaceId>; 2],
    /// Where it is.
    pub place: Vec3,
}

impl PanelLimit {
    /// Name as in [`PanelLimits`].
    pub fn name(self) -> &'static str {
        match self {
            Self::MaxPanel => "max_panel",
            Self::MinEdge => "min_edge",
            Self::MaxEdge => "max_edge",
            Self::MinAngle => "min_angle",
            Self::MaxArea => "max_area",
            Self::MaxAspect => "max_aspect",
            Self::MinDihedral => "min_dihedral",
            Self::MaxDihedral => "max_dihedral",
        }
    }

    /// Whether the figure must not be less.
    pub fn is_least(self) -> bool {
        matches!(self, Self::MinEdge | Self::MinAngle | Self::MinDihedral)
    }

    /// Whether it limits edges, else faces.
    pub fn is_of_edges(self) -> bool {
        use PanelLimit::{MaxDihedral, MaxEdge, MinDihedral, MinEdge};
        matches!(self, MinEdge | MaxEdge | MinDihedral | MaxDihedral)
    }

    /// Whether smaller panels help.
    pub fn wants_smaller(self) -> bool {
        matches!(
            self,
            Self::MaxPanel | Self::MaxEdge | Self::MaxArea | Self::MinDihedral
        )
    }
}

impl LimitedFigure {
    /// By how much it is outside, over the limit; 0 within.
    pub fn excess(&self) -> f64 {
        let over = match self.kind.is_least() {
            true => 1.0 - self.value / self.limit,
            false => self.value / self.limit - 1.0,
        };
        // What is no number is outside.
        match over <= ROUNDING {
            true => 0.0,
            false => over.min(f64::MAX),
        }
    }
}

impl PanelLimits {
    /// Whether nothing is limited.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether angles between panels are limited.
    pub fn limits_joints(&self) -> bool {
        self.min_dihedral.is_some() || self.max_dihedral.is_some()
    }

    /// The same where all lengths are `factor` times as long.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.with_sizes(|length| length * factor, |area| area * factor * factor)
    }

    /// The same with other lengths and areas.
    #[must_use]
    pub fn with_sizes(&self, length: impl Fn(f64) -> f64, area: impl Fn(f64) -> f64) -> Self {
        Self {
            max_panel: self.max_panel.map(|sides| sides.map(&length)),
            min_edge: self.min_edge.map(&length),
            max_edge: self.max_edge.map(&length),
            max_area: self.max_area.map(&area),
            ..*self
        }
    }

    /// Those that even hexagons of a mean area can keep: a rectangle holds affine images of regular
    /// ones of three quarters of its area, and the longest edge of none is shorter, or the shortest
    /// edge of a convex one longer, than that of the regular one. To pull panels towards the others
    /// moves them off the surface, and none of them gets there.
    #[must_use]
    pub fn within_reach(&self, area: f64) -> Self {
        let edge = (area / HEXAGON).sqrt();
        Self {
            max_panel: (self.max_panel).filter(|[a, b]| area <= OF_RECTANGLE * a * b),
            min_edge: self.min_edge.filter(|least| *least <= edge),
            max_edge: self.max_edge.filter(|most| *most >= edge),
            max_area: self.max_area.filter(|most| *most >= area),
            ..*self
        }
    }

    /// The limits that are set, each with its value; 1 for `MaxPanel`.
    pub fn set(&self) -> impl Iterator<Item = (PanelLimit, f64)> {
        let all = [
            (PanelLimit::MaxPanel, self.max_panel.map(|_| 1.0)),
            (PanelLimit::MinEdge, self.min_edge),
            (PanelLimit::MaxEdge, self.max_edge),
            (PanelLimit::MinAngle, self.min_angle),
            (PanelLimit::MaxArea, self.max_area),
            (PanelLimit::MaxAspect, self.max_aspect),
            (PanelLimit::MinDihedral, self.min_dihedral),
            (PanelLimit::MaxDihedral, self.max_dihedral),
        ];
        all.into_iter()
            .filter_map(|(kind, limit)| Some((kind, limit?)))
    }

    /// All figures of a mesh that are limited.
    ///
    /// ```
    /// use phex_mesh::{HexMesh, PanelLimit, PanelLimits, Vec3};
    ///
    /// let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
    /// let places = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
    /// let mesh = HexMesh::new(places, &[[0, 1, 2, 3]])?;
    /// let limits = PanelLimits { max_edge: Some(1.5), max_panel: Some([2.5, 1.0]), ..Default::default() };
    /// let outside: Vec<PanelLimit> = (limits.figures(&mesh).iter())
    ///     .filter(|f| f.excess() > 0.0)
    ///     .map(|f| f.kind)
    ///     .collect();
    /// assert_eq!(outside, [PanelLimit::MaxEdge; 2]);
    /// # Ok::<(), phex_mesh::TopologyError>(())
    /// ```
    pub fn figures(&self, mesh: &HexMesh) -> Vec<LimitedFigure> {
        if self.is_empty() {
            return Vec::new();
        }
        let faces = FlatFace::all(mesh);
        let mut figures = self.of_edges(mesh, &faces);
        for (f, flat) in faces.enumerate() {
            let values = [
                (
                    PanelLimit::MaxPanel,
                    1.0,
                    self.max_panel.map(|s| rectangle_fit(&flat.polygon, s).0),
                ),
                limited(PanelLimit::MaxArea, self.max_area, || flat.area()),
                limited(PanelLimit::MaxAspect, self.max_aspect, || {
                    aspect(&flat.polygon)
                }),
            ];
            let corner = self.min_angle.and_then(|_| sharpest(flat));
            let centre = mesh.centre(f);
            let corner = corner.map(|(k, angle)| {
                let place = mesh.corners(f).nth(k).unwrap_or(centre);
                (PanelLimit::MinAngle, angle, place)
            });
            let values = values
                .into_iter()
                .filter_map(|(kind, limit, value)| Some((kind, limit, value?, centre)));
            let corner = corner.zip(self.min_angle);
            let corner = corner.map(|((kind, angle, place), limit)| (kind, limit, angle, place));
            figures.extend(
                values
                    .chain(corner)
                    .map(|(kind, limit, value, place)| LimitedFigure {
                        kind,
                        limit,
                        value,
                        element: f.index(),
                        faces: [Some(f), None],
                        place,
                    }),
            );
        }
        figures
    }

    fn of_edges(&self, mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Vec<LimitedFigure> {
        let topology = mesh.topology();
        let figures = topology.edges().flat_map(|e| {
            let length = || mesh.edge_length(e);
            let joint = self
                .limits_joints()
                .then(|| joint_angle(mesh, faces, e))
                .flatten();
            let values = [
                limited(PanelLimit::MinEdge, self.min_edge, length),
                limited(PanelLimit::MaxEdge, self.max_edge, length),
                (
                    PanelLimit::MinDihedral,
                    self.min_dihedral.unwrap_or(0.0),
                    joint.filter(|_| self.min_dihedral.is_some()),
                ),
                (
                    PanelLimit::MaxDihedral,
                    self.max_dihedral.unwrap_or(0.0),
                    joint.filter(|_| self.max_dihedral.is_some()),
                ),
            ];
            let h = topology.edge_half_edge(e);
            let beside = topology.across(h);
            let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
            values.into_iter().filter_map(move |(kind, limit, value)| {
                Some(LimitedFigure {
                    kind,
                    limit,
                    value: value?,
                    element: e.index(),
                    faces: [Some(topology.face(h)), beside],
                    place: (a + b) * 0.5,
                })
            })
        });
        figures.collect()
    }
}

/// A figure for a limit that is set.
fn limited(
    kind: PanelLimit,
    limit: Option<f64>,
    value: impl FnOnce() -> f64,
) -> (PanelLimit, f64, Option<f64>) {
    (kind, limit.unwrap_or(0.0), limit.map(|_| value()))
}

/// The sharpest corner of a face, and its angle in degrees.
fn sharpest(flat: &FlatFace) -> Option<(usize, f64)> {
    let angles = interior_angles(&flat.polygon).enumerate();
    let least = angles.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map(|(k, angle)| (k, angle.to_degrees()))
}

/// Angle in degrees between the faces of an edge on the hollow side, in [0, 180]; `None` on the
/// boundary.
fn joint_angle(mesh: &HexMesh, faces: &PerFace<FlatFace>, e: EdgeId) -> Option<f64> {
    let [a, b] = (mesh.topology().faces_beside(e)?).map(|f| faces[f].normal());
    let turn = a.cross(&b).norm().atan2(a.dot(&b));
    Some(180.0 - turn.to_degrees())
}

/// The factor by which a rectangle of sides `a` and `b` must grow (or, below 1, may shrink) to just
/// hold a polygon in its plane, however it is turned, and the direction of the side `a` then.
///
/// *Method*: turned by an angle, the polygon's extents over `a` and `b` are to be both as small as
/// can be. Between two angles at which an edge of the convex hull lies along a side they are arcs
/// of sines, so that the larger one is least at such an angle, or where both are equal.
///
/// ```
/// use phex_mesh::{Vec2, rectangle_fit};
///
/// let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
/// assert!((rectangle_fit(&square, [1.0, 2.0]).0 - 1.0).abs() < 1e-12);
/// // A diagonal of length 3 lies askew in a sheet of 2.9 x 1.
/// let needle = [[0.0, 0.0], [3.0, 0.0]].map(Vec2::from);
/// assert!(rectangle_fit(&needle, [2.9, 1.0]).0 < 1.0);
/// ```
pub fn rectangle_fit(polygon: &[Vec2], [a, b]: [f64; 2]) -> (f64, Vec2) {
    use std::f64::consts::{FRAC_PI_2, PI};
    let hull = convex_hull(polygon);
    let extreme = |d: Vec2| {
        let along = |p: &&Vec2| p.dot(&d);
        let by = |p: &&Vec2, q: &&Vec2| along(p).total_cmp(&along(q));
        let [low, high] = [hull.iter().min_by(by), hull.iter().max_by(by)];
        low.zip(high)
            .map_or(Vec2::zeros(), |(low, high)| high - low)
    };
    let direction = |angle: f64| Vec2::new(angle.cos(), angle.sin());
    let across = |d: Vec2| Vec2::new(-d.y, d.x);
    let factor = |d: Vec2| (extreme(d).dot(&d) / a).max(extreme(across(d)).dot(&across(d)) / b);
    let mut flush: Vec<f64> = sides(&hull)
        .map(|[p, q]| q - p)
        .map(|s| s.y.atan2(s.x).rem_euclid(FRAC_PI_2))
        .collect();
    flush.sort_by(f64::total_cmp);
    let Some(first) = flush.first().copied() else {
        return (0.0, Vec2::x());
    };
    let mut angles = Vec::new();
    let ends = flush.iter().skip(1).copied().chain([first + FRAC_PI_2]);
    for (from, to) in flush.iter().zip(ends) {
        for turned in [0.0, FRAC_PI_2] {
            let middle = direction(0.5 * (from + to) + turned);
            let (p, q) = (extreme(middle), extreme(across(middle)));
            // p . d / a = q . across(d) / b for d = (cos, sin).
            let equal = (q.y / b - p.x / a).atan2(p.y / a + q.x / b);
            angles.extend([from + turned, equal, equal + PI]);
        }
    }
    let tried = angles.into_iter().map(|angle| {
        let d = direction(angle);
        (factor(d), d)
    });
    tried
        .min_by(|x, y| x.0.total_cmp(&y.0))
        .unwrap_or((0.0, Vec2::x()))
}

/// The convex hull of points, counter-clockwise (Andrew's chains).
fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut chain: Vec<Vec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(p - b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    fn regular(n: usize) -> Vec<Vec2> {
        let angle = |k: usize| 2.0 * PI * k as f64 / n as f64;
        let corner = |k| Vec2::new(angle(k).cos(), angle(k).sin());
        (0..n).map(corner).collect()
    }

    /// The least factor over many angles.
    fn by_trial(polygon: &[Vec2], [a, b]: [f64; 2]) -> f64 {
        let extent = |d: Vec2| {
            let along = polygon.iter().map(|p| p.dot(&d));
            let ends = along.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
            ends.1 - ends.0
        };
        let factor = |k: usize| {
            let angle = PI * k as f64 / 20_000.0;
            let d = Vec2::new(angle.cos(), angle.sin());
            (extent(d) / a).max(extent(Vec2::new(-d.y, d.x)) / b)
        };
        (0..20_000).map(factor).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_best_fit_is_that_of_all_angles() {
        let uneven: Vec<Vec2> = regular(7)
            .iter()
            .enumerate()
            .map(|(k, p)| Vec2::new(p.x * (1.0 + 0.3 * (k % 3) as f64), p.y * 0.6) * 10.0)
            .collect();
        for polygon in [regular(3), regular(4), regular(6), uneven] {
            for sheet in [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [5.0, 1.0]] {
                let (factor, along) = rectangle_fit(&polygon, sheet);
                assert!((along.norm() - 1.0).abs() < 1e-12);
                let trial = by_trial(&polygon, sheet);
                assert!(factor <= trial * (1.0 + 1e-12), "{factor} {trial}");
                assert!(factor >= trial * (1.0 - 1e-3), "{factor} {trial}");
            }
        }
        assert_relative_eq!(
            rectangle_fit(&regular(6), [2.0, 3.0_f64.sqrt()]).0,
            1.0,
            epsilon = 1e-12
        );
        assert_eq!(rectangle_fit(&[], [1.0, 1.0]).0, 0.0);
    }

    /// Two unit squares that meet at an edge with an angle.
    fn book(degrees: f64) -> HexMesh {
        let (s, c) = degrees.to_radians().sin_cos();
        let at = [
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0],
            [c, 0.0, s],
            [c, 1.0, s],
        ];
        let faces = [[0, 1, 2, 3], [3, 2, 5, 4]];
        HexMesh::new(at.map(Vec3::from).to_vec(), &faces).unwrap()
    }

    fn outside(limits: PanelLimits, mesh: &HexMesh) -> Vec<PanelLimit> {
        let figures = limits.figures(mesh).into_iter();
        figures
            .filter(|f| f.excess() > 0.0)
            .map(|f| f.kind)
            .collect()
    }

    #[test]
    fn each_limit_is_of_its_figure() {
        let mesh = book(120.0);
        let none = PanelLimits::default();
        let within = PanelLimits {
            max_panel: Some([1.0, 1.0]),
            min_edge: Some(1.0),
            max_edge: Some(1.0),
            min_angle: Some(90.0),
            max_area: Some(1.0),
            max_aspect: Some(1.0),
            min_dihedral: Some(120.0),
            max_dihedral: Some(120.0),
        };
        assert_eq!(outside(none, &mesh), []);
        assert_eq!(outside(within, &mesh), []);
        assert_eq!(within.set().count(), 8);
        let tighter = [
            (
                PanelLimits {
                    max_panel: Some([1.0, 0.99]),
                    ..none
                },
                PanelLimit::MaxPanel,
                2,
            ),
            (
                PanelLimits {
                    min_edge: Some(1.01),
                    ..none
                },
                PanelLimit::MinEdge,
                7,
            ),
            (
                PanelLimits {
                    max_edge: Some(0.99),
                    ..none
                },
                PanelLimit::MaxEdge,
                7,
            ),
            (
                PanelLimits {
                    min_angle: Some(91.0),
                    ..none
                },
                PanelLimit::MinAngle,
                2,
            ),
            (
                PanelLimits {
                    max_area: Some(0.99),
                    ..none
                },
                PanelLimit::MaxArea,
                2,
            ),
            (
                PanelLimits {
                    min_dihedral: Some(121.0),
                    ..none
                },
                PanelLimit::MinDihedral,
                1,
            ),
            (
                PanelLimits {
                    max_dihedral: Some(119.0),
                    ..none
                },
                PanelLimit::MaxDihedral,
                1,
            ),
        ];
        for (limits, kind, count) in tighter {
            assert_eq!(outside(limits, &mesh), vec![kind; count], "{kind:?}");
        }
        let valley = book(240.0);
        assert_eq!(
            outside(
                PanelLimits {
                    min_dihedral: Some(119.0),
                    ..none
                },
                &valley
            ),
            []
        );
        assert_eq!(
            outside(
                PanelLimits {
                    min_dihedral: Some(121.0),
                    ..none
                },
                &valley
            ),
            [PanelLimit::MinDihedral]
        );
    }

    #[test]
    fn lengths_and_areas_scale_with_the_mesh() {
        let mesh = book(100.0);
        let large = mesh.mapped(|p| p * 1000.0);
        let limits = PanelLimits {
            max_panel: Some([0.8, 1.2]),
            min_edge: Some(1.1),
            max_area: Some(0.7),
            max_aspect: Some(1.5),
            ..PanelLimits::default()
        };
        let excesses = |mesh: &HexMesh, limits: PanelLimits| -> Vec<f64> {
            limits
                .figures(mesh)
                .iter()
                .map(LimitedFigure::excess)
                .collect()
        };
        let (small, large) = (
            excesses(&mesh, limits),
            excesses(&large, limits.scaled(1000.0)),
        );
        assert!(small.iter().any(|e| *e > 0.0));
        for (a, b) in small.iter().zip(&large) {
            assert_relative_eq!(a, b, epsilon = 1e-9);
        }
    }
}
