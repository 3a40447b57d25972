//! Mirror planes and rotations of a surface.
//!
//! Both leave the centroid where it is, and map axes of inertia to such of the same moment. An axis
//! of rotation of order three or more has two equal moments across it, so a mirror plane or an axis
//! of a group with one is found among the three axes, however the equal ones are chosen. Angles
//! about an axis come from the harmonics `c_m = sum w exp(i m phi) dA` of a few weights `w(r, z)`:
//! a rotation by a turn over `n` leaves those alone whose `m` is a multiple of `n`, and a mirror
//! plane lies at `arg(c_m) / m`, up to multiples of `pi / m`. What is found so is checked: every
//! vertex of the surface is mapped, and must lie on the surface, those of the boundary on the
//! boundary, within a tolerance. So triangles need not be symmetric. At last the frame is moved to
//! where these distances are least.

use super::group::{Group, reflection, turn};
use nalgebra::{Complex, Matrix3, Matrix6, SymmetricEigen, Vector6};
use phex_mesh::{BoundaryCurve, TriangleSurface, Vec3, VertexId};
use rayon::prelude::*;

/// Largest order of a rotation that is looked for.
const MOST_FOUND: u32 = 24;
/// Harmonics over the zeroth below which they count as none.
const NO_HARMONIC: f64 = 2e-3;
/// Vertices that a candidate is tried on first.
const FEW: usize = 60;
/// Vertices on which the frame is refined.
const SOME: usize = 500;
/// Rounds of that.
const ROUNDS: usize = 4;
/// Tolerances within which a candidate is worth refining.
const ROUGHLY: f64 = 6.0;
/// Cosine of the angle between axes beyond which they are one.
const SAME_AXIS: f64 = 0.9999;

/// Where a group lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// A point of all mirror planes.
    pub origin: Vec3,
    /// Rows are the axes: the normal of the first mirror plane is the second, the axis the third.
    pub axes: Matrix3<f64>,
}

impl Frame {
    /// A point in the frame.
    pub fn inside(&self, p: Vec3) -> Vec3 {
        self.axes * (p - self.origin)
    }

    /// A point of the frame outside.
    pub fn outside(&self, q: Vec3) -> Vec3 {
        self.axes.transpose() * q + self.origin
    }
}

/// The symmetries of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub frame: Frame,
    pub group: Group,
    /// Whether every rotation about the axis is one.
    pub revolution: bool,
}

/// What was found of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Symmetries {
    /// The largest group of mirror planes.
    pub mirrored: Option<Found>,
    /// The largest order of a rotation, with mirror planes or without.
    pub turns: Option<u32>,
    /// Where there is no mirror plane the least distance of an image of the surface to it that
    /// was found, in a plane that nearly is one.
    pub nearly: Option<f64>,
}

/// What a surface allows about one axis.
#[derive(Clone, Copy)]
struct About {
    frame: Frame,
    turns: u32,
    mirrors: bool,
    /// Distance of the image in a plane that nearly is a mirror plane.
    nearly: Option<f64>,
    level: bool,
    revolution: bool,
}

impl Found {
    /// The part of the group with a rotation of order two about the line in which its first plane
    /// and the level one meet, in a frame with that axis; `None` without a level plane. Of an odd
    /// number of rotations none about the axis is of order two.
    pub fn half_turn_across(&self) -> Option<Self> {
        let [x, y, z] = [0, 1, 2].map(|k| self.frame.axes.row(k));
        self.group.level.then(|| Self {
            frame: Frame {
                axes: Matrix3::from_rows(&[-z, y.into_owned(), x.into_owned()]),
                ..self.frame
            },
            group: Group {
                rotations: 2,
                level: false,
            },
            revolution: false,
        })
    }
}

/// The symmetries of a surface; lengths in the surface's unit.
pub(crate) fn find(surface: &TriangleSurface, tolerance: f64) -> Symmetries {
    let search = AxisSearch::new(surface, tolerance);
    let axes = search.axes();
    let mut about: Vec<About> = axes.par_iter().map(|axis| search.about(*axis)).collect();
    about.sort_by_key(About::rank);
    let with_mirrors = about.iter().rev().filter(|a| a.mirrors).copied();
    // A door in one wall leaves the mirror plane through it.
    let one_plane = with_mirrors.clone().map(About::one_plane);
    // Only some vertices have been looked at.
    let off = |a: &About| search.distance(&a.frame, &a.generators(), usize::MAX);
    let (missed, mirrored) = first_within(with_mirrors.chain(one_plane), off, tolerance);
    let mirrored = mirrored.map(|a| Found {
        frame: a.frame,
        group: Group {
            rotations: a.turns,
            level: a.level,
        },
        revolution: a.revolution,
    });
    let nearly = about.iter().filter_map(|a| a.nearly).chain(missed);
    Symmetries {
        nearly: nearly.reduce(f64::min).filter(|_| mirrored.is_none()),
        turns: about.iter().map(|a| a.turns).max().filter(|n| *n > 1),
        mirrored,
    }
}

/// The first whose distance is within a tolerance, and the distances of those before it.
fn first_within(
    candidates: impl Iterator<Item = About>,
    distance: impl Fn(&About) -> f64,
    tolerance: f64,
) -> (Vec<f64>, Option<About>) {
    let mut missed = Vec::new();
    for candidate in candidates {
        let off = distance(&candidate);
        if off <= tolerance {
            return (missed, Some(candidate));
        }
        missed.push(off);
    }
    (missed, None)
}

/// Whether a surface has a rotation of an order about the axis of a frame.
pub(crate) fn has_turn(
    surface: &TriangleSurface,
    frame: &Frame,
    order: u32,
    tolerance: f64,
) -> bool {
    let search = AxisSearch::new(surface, tolerance);
    // A small turn moves little, whatever the surface; its powers tell.
    let powers = [1, order / 3, order / 2].map(|k| turn(k.max(1), order));
    search.distance(frame, &powers, usize::MAX) <= tolerance
}

/// Largest distance of vertices' images under a group to the surface.
pub(crate) fn distance(surface: &TriangleSurface, frame: &Frame, group: Group) -> f64 {
    let search = AxisSearch::new(surface, 0.0);
    let maps: Vec<Matrix3<f64>> = group.walls().into_iter().map(reflection).collect();
    search.distance(frame, &maps, usize::MAX)
}

impl About {
    /// The more elements the later.
    fn rank(&self) -> u32 {
        let turns = if self.revolution {
            u32::MAX / 8
        } else {
            self.turns
        };
        turns * (1 + u32::from(self.level))
    }

    /// The mirror plane through the axis alone.
    fn one_plane(self) -> Self {
        Self {
            turns: 1,
            level: false,
            revolution: false,
            ..self
        }
    }

    fn generators(&self) -> Vec<Matrix3<f64>> {
        let mut maps = Vec::new();
        if self.mirrors {
            maps.push(reflection(Vec3::y()));
        }
        if self.revolution {
            maps.extend([7, 16].map(|k| turn(k, 100)));
        } else if self.turns > 1 {
            maps.push(turn(1, self.turns));
        }
        if self.level {
            maps.push(reflection(Vec3::z()));
        }
        maps
    }
}

struct AxisSearch<'a> {
    surface: &'a TriangleSurface,
    boundary: Option<BoundaryCurve>,
    tolerance: f64,
    centroid: Vec3,
    /// Middles of the sides of triangles and their areas, in any unit: sums over them are integrals
    /// of squares, to the last bit, however polygons were cut into triangles.
    middles: Vec<(Vec3, f64)>,
}

impl<'a> AxisSearch<'a> {
    fn new(surface: &'a TriangleSurface, tolerance: f64) -> Self {
        let of_sides = |f| {
            let [a, b, c] = surface.corners(f);
            let area = surface.area_vector(f).norm();
            [a + b, b + c, c + a].map(|sum| (sum / 2.0, area))
        };
        let middles: Vec<(Vec3, f64)> = surface.topology().faces().flat_map(of_sides).collect();
        let area: f64 = middles.iter().map(|m| m.1).sum();
        let sum: Vec3 = middles.iter().map(|(p, a)| p * *a).sum();
        Self {
            boundary: BoundaryCurve::of(surface),
            surface,
            tolerance,
            centroid: sum / area,
            middles,
        }
    }

    /// Axes of inertia, and the coordinate axes where there are none; of a flat surface that across
    /// it.
    fn axes(&self) -> Vec<Vec3> {
        let mut moments = Matrix3::zeros();
        for (p, a) in &self.middles {
            let d = p - self.centroid;
            moments += d * d.transpose() * *a;
        }
        let eigen = SymmetricEigen::new(moments);
        let of_inertia = (0..3).map(|k| eigen.eigenvectors.column(k).into());
        let mut axes: Vec<Vec3> = Vec::new();
        for axis in of_inertia.chain([Vec3::x(), Vec3::y(), Vec3::z()]) {
            if axes.iter().all(|a| a.dot(&axis).abs() < SAME_AXIS) {
                axes.push(axis);
            }
        }
        let across = axes.iter().copied().find(|axis| self.lies_across(*axis));
        across.map_or(axes, |axis| vec![axis])
    }

    /// The largest order of a rotation about the axis of a frame that is within a tolerance.
    fn turns_within(&self, frame: &Frame) -> Option<u32> {
        let fits = |n: &u32| {
            let maps = [turn(1, *n)];
            self.distance(frame, &maps, FEW) <= self.tolerance
                && self.distance(frame, &maps, SOME) <= self.tolerance
        };
        (2..=MOST_FOUND).rev().find(fits)
    }

    /// What the surface allows about an axis through its centroid.
    fn about(&self, axis: Vec3) -> About {
        let frame = frame_about(self.centroid, axis, Vec3::x());
        let harmonics = self.harmonics(&frame);
        let mut about = About {
            frame,
            turns: 1,
            mirrors: false,
            nearly: None,
            level: false,
            revolution: false,
        };
        let strongest = |m: usize| harmonics[m].norm();
        let most = (1..harmonics.len()).map(strongest).fold(0.0, f64::max);
        // Facets have harmonics of their own: images tell where these are small but not that small.
        let round = [7, 16].map(|k| turn(k, 100));
        about.revolution = if most < NO_HARMONIC {
            round.iter().all(|map| self.holds(&frame, map))
        } else {
            self.distance(&frame, &round, FEW) <= self.tolerance
                && self.distance(&frame, &round, SOME) <= self.tolerance
        };
        if about.revolution {
            about.mirrors = self.holds(&frame, &reflection(Vec3::y()));
            about.turns = MOST_FOUND;
        } else {
            let turns = (2..=MOST_FOUND).rev();
            let possible = |n: &u32| {
                let others = (1..harmonics.len()).filter(|m| !m.is_multiple_of(*n as usize));
                others.map(strongest).fold(0.0, f64::max) < 0.2 * most + NO_HARMONIC
            };
            let found = turns
                .filter(possible)
                .find(|n| self.holds(&frame, &turn(1, *n)));
            about.turns = found.unwrap_or(1);
            if let Some(mirrored) = self.mirror(&frame, &harmonics) {
                (about.frame, about.mirrors) = (mirrored, true);
            }
        }
        about.level = self.holds(&about.frame, &reflection(Vec3::z())) && !self.lies_across(axis);
        self.refine(&mut about);
        about
    }

    /// The frame turned about its axis so that `y = 0` is a mirror plane: as harmonics have it, or
    /// with an axis of the model in it.
    fn mirror(&self, frame: &Frame, harmonics: &[Complex<f64>]) -> Option<Frame> {
        let strength = |m: &usize| harmonics[*m].norm();
        let m = (1..harmonics.len()).max_by(|a, b| strength(a).total_cmp(&strength(b)))?;
        let first = harmonics[m].arg() / m as f64;
        let turned = |k: usize| {
            let angle = first + std::f64::consts::PI * k as f64 / m as f64;
            frame.axes.transpose() * Vec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let about = |x| frame_about(frame.origin, frame.axes.row(2).transpose(), x);
        let distance = |f: &Frame| self.distance(f, &[reflection(Vec3::y())], FEW);
        let best = (0..m)
            .map(turned)
            .chain(axes)
            .map(|x| (distance(&about(x)), about(x)))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.holds(&best.1, &reflection(Vec3::y()))
            .then_some(best.1)
    }

    /// Whether the surface lies in the plane across an axis, which then is no mirror plane: nothing
    /// lies on its sides.
    fn lies_across(&self, axis: Vec3) -> bool {
        let off = |p: &Vec3| axis.dot(&(p - self.centroid)).abs();
        let mut places = self.surface.positions().iter();
        places.all(|p| off(p) <= self.tolerance)
    }

    /// Moments of the angle about the axis, each for the weight with which it is strongest; they
    /// are relative to the zeroth.
    fn harmonics(&self, frame: &Frame) -> Vec<Complex<f64>> {
        const WEIGHTS: usize = 4;
        let count = MOST_FOUND as usize + 1;
        let mut sums = vec![[Complex::default(); WEIGHTS]; count];
        let mut totals = [0.0; WEIGHTS];
        for (p, area) in &self.middles {
            let q = frame.inside(*p);
            let direction = Complex::new(q.x, q.y);
            let r = direction.norm();
            if r == 0.0 {
                continue;
            }
            let unit = direction / r;
            let weights = [r * r, r * r * q.z, r * r * q.z * q.z, r.powi(4)];
            let mut power = Complex::new(1.0, 0.0);
            for sum in &mut sums {
                for (s, w) in sum.iter_mut().zip(weights) {
                    *s += power * (w * area);
                }
                power *= unit;
            }
            for (t, w) in totals.iter_mut().zip(weights) {
                *t += w.abs() * area;
            }
        }
        let strongest = |sum: &[Complex<f64>; WEIGHTS]| {
            let relative = sum
                .iter()
                .zip(&totals)
                .map(|(s, t)| s / t.max(f64::MIN_POSITIVE));
            relative
                .max_by(|a, b| a.norm().total_cmp(&b.norm()))
                .unwrap_or_default()
        };
        sums.iter().map(strongest).collect()
    }

    /// Whether a map of the frame is a symmetry, roughly: what is found is refined afterwards.
    fn holds(&self, frame: &Frame, map: &Matrix3<f64>) -> bool {
        let limit = ROUGHLY * self.tolerance;
        let maps = std::slice::from_ref(map);
        self.distance(frame, maps, FEW) <= limit && self.distance(frame, maps, SOME) <= limit
    }

    /// Largest distance of images of about `count` vertices.
    fn distance(&self, frame: &Frame, maps: &[Matrix3<f64>], count: usize) -> f64 {
        let topology = self.surface.topology();
        let step = (topology.n_vertices() / count).max(1);
        let vertices: Vec<VertexId> = topology.vertices().step_by(step).collect();
        let off = |v: &VertexId| {
            let p = frame.inside(self.surface.positions()[*v]);
            let curve = self.boundary.as_ref();
            let curve = curve.filter(|_| topology.is_boundary_vertex(*v));
            let of_map = |map: &Matrix3<f64>| {
                let image = frame.outside(map * p);
                let inside = (self.surface.closest_point(image).position - image).norm();
                let along = |c: &BoundaryCurve| (c.closest_point(image).position - image).norm();
                inside.max(curve.map_or(0.0, along))
            };
            maps.iter().map(of_map).fold(0.0, f64::max)
        };
        let offs = vertices.par_iter().with_min_len(64).map(off);
        offs.reduce(|| 0.0, f64::max)
    }

    /// Moves the frame to where images fit best, and drops what does not fit within the tolerance
    /// then.
    fn refine(&self, about: &mut About) {
        let maps = about.generators();
        if maps.is_empty() {
            return;
        }
        for _ in 0..ROUNDS {
            about.frame = self.refined(&about.frame, &maps);
        }
        let simple = self.simplified(&about.frame);
        let [now, then] = [&about.frame, &simple].map(|f| self.distance(f, &maps, SOME));
        if then <= self.tolerance && then <= 1.5 * now + 0.1 * self.tolerance {
            about.frame = simple;
        }
        let frame = about.frame;
        let off = |map: &Matrix3<f64>| self.distance(&frame, std::slice::from_ref(map), SOME);
        let fits = |map: &Matrix3<f64>| off(map) <= self.tolerance;
        if about.mirrors {
            let nearly = off(&reflection(Vec3::y()));
            about.mirrors = nearly <= self.tolerance;
            about.nearly = (!about.mirrors).then_some(nearly);
        }
        about.level &= fits(&reflection(Vec3::z()));
        about.revolution &= fits(&turn(7, 100)) && fits(&turn(16, 100));
        if about.turns > 1 && !about.revolution && !fits(&turn(1, about.turns)) {
            about.turns = self.turns_within(&about.frame).unwrap_or(1);
        }
    }

    /// One step of Gauss and Newton: distances of images to the tangent planes at their feet, and
    /// of those of the boundary to it, by a small motion of the frame. The boundary alone tells how
    /// a dome of revolution with a square plan lies.
    fn refined(&self, frame: &Frame, maps: &[Matrix3<f64>]) -> Frame {
        let topology = self.surface.topology();
        let step = (topology.n_vertices() / SOME).max(1);
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        for v in topology.vertices().step_by(step) {
            let p = self.surface.positions()[v] - frame.origin;
            for map in maps {
                let full = frame.axes.transpose() * map * frame.axes;
                let image = full * p;
                let at = image + frame.origin;
                let foot = self.surface.closest_point(at);
                let curve = self.boundary.as_ref();
                let rim = curve
                    .filter(|_| topology.is_boundary_vertex(v))
                    .map(|curve| {
                        let foot_on_rim = curve.closest_point(at);
                        let across = foot.normal.cross(&foot_on_rim.tangent);
                        (across, foot_on_rim.position)
                    });
                for (n, foot) in rim.into_iter().chain([(foot.normal, foot.position)]) {
                    // The motion p -> p + w x p + t of the frame moves images by
                    // (w x) R p - R (w x p) + t - R t.
                    let turned = full.transpose() * n;
                    let rotation = image.cross(&n) - p.cross(&turned);
                    let shift = n - turned;
                    let row = Vector6::new(
                        rotation.x, rotation.y, rotation.z, shift.x, shift.y, shift.z,
                    );
                    normal += row * row.transpose();
                    right -= row * n.dot(&(at - foot));
                }
            }
        }
        let damping = 1e-9 * normal.trace();
        let Some(solved) = (normal + Matrix6::identity() * damping)
            .try_inverse()
            .map(|i| i * right)
        else {
            return *frame;
        };
        let spin = nalgebra::Rotation3::new(solved.fixed_rows::<3>(0).into_owned());
        Frame {
            origin: frame.origin + solved.fixed_rows::<3>(3),
            axes: frame.axes * spin.inverse().matrix(),
        }
    }

    /// The frame with its axis and its mirror plane along axes of the model, and its origin at the
    /// model's, where they nearly are.
    fn simplified(&self, frame: &Frame) -> Frame {
        const NEAR: f64 = 2e-3;
        let row = |k: usize| frame.axes.row(k).transpose();
        let simple = |v: Vec3| v.map(|x| if x.abs() < NEAR { 0.0 } else { x }).normalize();
        let (axis, normal) = (simple(row(2)), simple(row(1)));
        // One of both gives way where they are no longer at right angles.
        let [axis, normal] = match axis.iter().any(|x| x.abs() == 1.0) {
            true => [axis, across(normal, axis)],
            false => [across(axis, normal), normal],
        };
        let rows = [normal.cross(&axis), normal, axis].map(|v| v.transpose());
        let near = self.tolerance;
        let origin = frame.origin.map(|x| if x.abs() < near { 0.0 } else { x });
        Frame {
            origin,
            axes: Matrix3::from_rows(&rows),
        }
    }
}

/// The unit vector at right angles to another one that is nearest to `v`.
fn across(v: Vec3, unit: Vec3) -> Vec3 {
    (v - unit * unit.dot(&v)).normalize()
}

/// A right-handed frame about an axis, its first axis as near to `x` as can be.
fn frame_about(origin: Vec3, axis: Vec3, x: Vec3) -> Frame {
    let axis = axis.normalize();
    let across = [x, Vec3::y(), Vec3::z()].map(|d| d - axis * axis.dot(&d));
    let first = across.into_iter().find(|d| d.norm() > 0.1);
    let first = first.map_or_else(Vec3::x, |d| d.normalize());
    Frame {
        origin,
        axes: Matrix3::from_rows(&[
            first.transpose(),
            axis.cross(&first).transpose(),
            axis.transpose(),
        ]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_plane_gives_a_half_turn_of_the_same_group() {
        for rotations in [1, 3] {
            let all = Found {
                frame: frame_about(
                    Vec3::new(1.0, 2.0, 3.0),
                    Vec3::new(1.0, 1.0, 2.0),
                    Vec3::x(),
                ),
                group: Group {
                    rotations,
                    level: true,
                },
                revolution: false,
            };
            let part = all.half_turn_across().unwrap();
            assert!((part.frame.axes.determinant() - 1.0).abs() < 1e-12);
            let outside = |found: &Found| {
                let axes = found.frame.axes;
                let maps = found.group.elements().into_iter();
                maps.map(move |map| axes.transpose() * map * axes)
                    .collect::<Vec<_>>()
            };
            let (whole, maps) = (outside(&all), outside(&part));
            assert_eq!(maps.len(), 4);
            for map in maps {
                assert!(whole.iter().any(|of_all| (of_all - map).amax() < 1e-12));
            }
            let flat = Group {
                level: false,
                ..all.group
            };
            assert!(Found { group: flat, ..all }.half_turn_across().is_none());
        }
    }
}
