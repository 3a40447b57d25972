//! Limits of panels in the optimiser: what a workshop can make, room, least areas and blunt
//! corners, as inequalities with slack, see [`super::inequality`].
//!
//! Every limit is a number `c`, without unit, that is to be at least 0:
//!
//! | limit | `c` |
//! |---|---|
//! | least, largest edge | `l / least - 1`, `1 - l / largest` |
//! | least angle | `a / least - 1` at each corner that is not re-entrant |
//! | clearance | `d / least - 1` for each corner and edge that does not hold it |
//! | least area | `A / least - 1` |
//! | largest area | `1 - A / largest`, `A` the length of the vector area |
//! | sheet | `1 - (x_i - x_j) . u / side` for all corners, `u` the sheet's sides where it fits best, fixed for a phase |
//! | coverage | `1 - (|q - y| / largest)^2`, `y` the point of the panel nearest to a point `q` of the surface, see [`super::coverage`] |
//! | aspect | `1 - sqrt(l_1 / l_2) / largest`, `l` the second moments of the area about its principal axes; with less weight for what a layout wishes |
//!
//! Derivatives are exact on planar panels; Hessians are their Gauss-Newton part `c' c'^T`. How
//! faces meet is the matter of [`super::folds`].

use super::coverage::covered;
use super::inequality::{Elastic, Inequality};
use super::spatial_barrier::{SpatialApproach, for_each_approach};
use crate::layout::Layout;
use crate::optimise::options::OptimiseOptions;
use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, Panels, add_block, extent, picked};
use crate::optimise::simple::areas;
use nalgebra::Matrix2;
use phex_mesh::measure::wanted_clearance;
use phex_mesh::{PanelLimits, Vec2, Vec3, rectangle_fit};

/// Weight of a shape that is wished for over that of a limit: areas that differ by less than a
/// third are borne for it.
const WISHED: f64 = 0.3;

/// Shape that a face is wished to have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShapeWish {
    /// Length over width at the most.
    pub aspect: f64,
    /// Weight, over that of a limit; 0 where any shape will do.
    pub weight: f64,
}

impl ShapeWish {
    /// Any shape.
    pub const ANY: Self = Self {
        aspect: f64::INFINITY,
        weight: 0.0,
    };
}

/// What faces are to have; lengths in the unit of the mesh.
#[derive(Clone, Debug)]
pub(crate) struct FaceLimits {
    /// What a workshop can make of each face, and corners as blunt as is wished for.
    pub panels: Vec<PanelLimits>,
    /// Least clearance of each face.
    pub clearance: Vec<f64>,
    /// Shape that each face is wished to have.
    pub shape: Vec<ShapeWish>,
    /// Least area of each face; 0 for any.
    pub area: Vec<f64>,
    /// Largest distance to the surface; infinite for any.
    pub distance: f64,
    /// Points of the surface that each face is to lie as near to.
    pub cover: Vec<Vec<Vec3>>,
}

impl FaceLimits {
    /// No limits.
    pub(in crate::optimise) fn none(faces: usize) -> Self {
        Self {
            panels: vec![PanelLimits::default(); faces],
            clearance: vec![0.0; faces],
            shape: vec![ShapeWish::ANY; faces],
            area: vec![0.0; faces],
            distance: f64::INFINITY,
            cover: vec![Vec::new(); faces],
        }
    }

    /// What the options ask of faces that lie at `x`: room as their areas allow.
    pub(in crate::optimise) fn of(panels: &Panels, x: &[f64], options: &OptimiseOptions) -> Self {
        let shape = FaceShapes::at(panels, x);
        let areas = areas(panels, &shape);
        let mean = areas.iter().sum::<f64>() / areas.len().max(1) as f64;
        let unit = options.wished_clearance * panels.mean_edge(x);
        let limit = options.max_deviation;
        Self {
            panels: vec![options.panel_limits(mean); areas.len()],
            clearance: (areas.iter())
                .map(|a| unit * wanted_clearance(a / mean))
                .collect(),
            distance: limit.map_or(f64::INFINITY, |share| share * extent(x)),
            ..Self::none(areas.len())
        }
    }

    /// With the shapes that a layout asks for: the boundary cuts the outer faces anywhere.
    pub(crate) fn with_shapes(mut self, layout: &Layout) -> Self {
        let topology = layout.mesh.topology();
        for (f, wish) in layout.face_wish.enumerate() {
            if !topology.is_boundary_face(f) {
                self.shape[f.index()] = ShapeWish {
                    aspect: wish.aspect,
                    weight: WISHED * wish.share,
                };
            }
        }
        self
    }

    /// Least angle between neighbours, degrees, the same everywhere.
    pub(in crate::optimise) fn min_dihedral(&self) -> Option<f64> {
        self.panels.first().and_then(|limits| limits.min_dihedral)
    }

    /// Those of some faces.
    pub(in crate::optimise) fn part(&self, faces: &[u32]) -> Self {
        Self {
            panels: picked(&self.panels, faces),
            clearance: picked(&self.clearance, faces),
            shape: picked(&self.shape, faces),
            area: picked(&self.area, faces),
            cover: picked(&self.cover, faces),
            distance: self.distance,
        }
    }
}

/// The limits of all faces, and how they lie.
pub(in crate::optimise) struct ShapeLimits<'a> {
    limits: &'a FaceLimits,
    /// Area of each face at the start.
    area: Vec<f64>,
    /// Directions of the sheet's sides for each face.
    sides: Vec<[Vec3; 2]>,
}

impl<'a> ShapeLimits<'a> {
    /// Limits for faces that lie as in `shape`.
    pub fn new(limits: &'a FaceLimits, panels: &Panels, shape: &FaceShapes) -> Self {
        let mut made = Self {
            limits,
            area: areas(panels, shape),
            sides: Vec::new(),
        };
        made.turn(panels, shape);
        made
    }

    /// Turns sheets to where they fit best.
    pub fn turn(&mut self, panels: &Panels, shape: &FaceShapes) {
        let Some(sheet) = self.limits.panels.first().and_then(|p| p.max_panel) else {
            return;
        };
        let sides = |f: usize| {
            let polygon: Vec<Vec2> = shape.face(panels, f).iter().map(|c| c.flat).collect();
            let along = rectangle_fit(&polygon, sheet).1;
            let axes = shape.frames[f].plane.axes;
            [along, Vec2::new(-along.y, along.x)].map(|d| axes[0] * d.x + axes[1] * d.y)
        };
        self.sides = (0..panels.n_faces()).map(sides).collect();
    }

    /// How far each face is within its limits, the least of all; negative beyond one.
    pub fn margins(&self, panels: &Panels, shape: &FaceShapes) -> Vec<f64> {
        let margin = |f: usize| {
            let (mut least, corners) = (f64::INFINITY, shape.face(panels, f));
            self.visit(f, corners, &shape.frames[f], |i| least = least.min(i.c));
            least
        };
        (0..panels.n_faces()).map(margin).collect()
    }

    fn elastic(&self, f: usize, weight: f64) -> Elastic {
        Elastic {
            weight: weight * self.area[f],
        }
    }

    /// Energy of a face.
    pub fn energy(&self, f: usize, corners: &[Corner], frame: &FaceFrame, weight: f64) -> f64 {
        let (elastic, mut sum) = (self.elastic(f, weight), 0.0);
        self.visit(f, corners, frame, |i| sum += elastic.value(i.c));
        sum
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        f: usize,
        (corners, frame): (&[Corner], &FaceFrame),
        weight: f64,
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        let elastic = self.elastic(f, weight);
        self.visit(f, corners, frame, |inequality| {
            let [first, second] = elastic.derivatives(inequality.c);
            if first == 0.0 {
                return;
            }
            for (i, row) in &inequality.rows {
                gradient[*i] += row * first;
                for (j, other) in inequality.rows.iter().filter(|(j, _)| j <= i) {
                    add_block(block, *i, *j, &(row * other.transpose() * second));
                }
            }
        });
    }

    fn visit(
        &self,
        f: usize,
        corners: &[Corner],
        frame: &FaceFrame,
        mut visit: impl FnMut(&Inequality),
    ) {
        let limits = &self.limits.panels[f];
        visit_edges(corners, limits, &mut visit);
        for_each_approach(corners, 2.0 * self.limits.clearance[f], |a| {
            visit(&roomy(a, self.limits.clearance[f]));
        });
        for q in &self.limits.cover[f] {
            let inequality = covered(*q, corners, frame, self.limits.distance);
            inequality.iter().for_each(&mut visit);
        }
        if let Some(most) = limits.max_area {
            let (area, rows) = area_and_rows(corners);
            visit(&Inequality::at_most(area, most, &rows));
        }
        if self.limits.area[f] > 0.0 {
            let (area, rows) = area_and_rows(corners);
            visit(&Inequality::at_least(area, self.limits.area[f], &rows));
        }
        if let Some(most) = limits.max_aspect {
            aspect(corners, frame, most).iter().for_each(&mut visit);
        }
        let wish = &self.limits.shape[f];
        if wish.weight > 0.0 {
            let inequality = aspect(corners, frame, wish.aspect);
            let inequality = inequality.map(|i| i.weighted(wish.weight));
            inequality.iter().for_each(&mut visit);
        }
        self.visit_widths(f, corners, &mut visit);
    }

    /// A panel is no wider than sheets in the directions of its sides.
    fn visit_widths(&self, f: usize, corners: &[Corner], visit: &mut impl FnMut(&Inequality)) {
        let most = self.limits.panels[f].max_panel.into_iter().flatten();
        let sides = self.sides.get(f).into_iter().flatten();
        for (side, length) in sides.zip(most) {
            for (i, p) in corners.iter().enumerate() {
                for (j, q) in corners.iter().enumerate().filter(|(j, _)| *j != i) {
                    let c = 1.0 - (p.position - q.position).dot(side) / length;
                    let row = side / -length;
                    visit(&Inequality {
                        c,
                        rows: vec![(i, row), (j, -row)],
                    });
                }
            }
        }
    }
}

/// Lengths of the edges of a panel, and its angles.
fn visit_edges(corners: &[Corner], limits: &PanelLimits, visit: &mut impl FnMut(&Inequality)) {
    let k = corners.len();
    for i in 0..k {
        let along = corners[(i + 1) % k].position - corners[i].position;
        let length = along.norm().max(f64::MIN_POSITIVE);
        let rows = |scale: f64| {
            let row = along * (scale / length);
            vec![((i + 1) % k, row), (i, -row)]
        };
        if let Some(least) = limits.min_edge {
            let (c, rows) = (length / least - 1.0, rows(1.0 / least));
            visit(&Inequality { c, rows });
        }
        if let Some(most) = limits.max_edge {
            let (c, rows) = (1.0 - length / most, rows(-1.0 / most));
            visit(&Inequality { c, rows });
        }
        if let Some(least) = limits.min_angle {
            angle(corners, i, least.to_radians())
                .iter()
                .for_each(&mut *visit);
        }
    }
}

/// The angle at a corner that is not re-entrant.
fn angle(corners: &[Corner], i: usize, least: f64) -> Option<Inequality> {
    let k = corners.len();
    let around = [(i + k - 1) % k, i, (i + 1) % k];
    let [p, q, r] = around.map(|j| &corners[j]);
    if (q.flat - p.flat).perp(&(r.flat - q.flat)) < 0.0 {
        return None;
    }
    let (a, b) = (p.position - q.position, r.position - q.position);
    let across = a.cross(&b);
    let normal = across.try_normalize(f64::MIN_POSITIVE)?;
    let angle = across.norm().atan2(a.dot(&b));
    // An arm turns the angle by its motion across, over its length.
    let by_a = a.cross(&normal) / a.norm_squared();
    let by_b = normal.cross(&b) / b.norm_squared();
    let rows = [by_a, -(by_a + by_b), by_b].map(|row| row / least);
    Some(Inequality {
        c: angle / least - 1.0,
        rows: around.into_iter().zip(rows).collect(),
    })
}

/// Room between a corner and an edge.
fn roomy(approach: &SpatialApproach, least: f64) -> Inequality {
    let unit = approach.offset / (approach.distance * least);
    let pairs = approach.corners.into_iter().zip(approach.coefficients);
    Inequality {
        c: approach.distance / least - 1.0,
        rows: pairs.map(|(i, c)| (i, unit * c)).collect(),
    }
}

/// Length of the vector area of a face, and its derivatives by the corners.
fn area_and_rows(corners: &[Corner]) -> (f64, Vec<Vec3>) {
    let k = corners.len();
    let at = |i: usize| corners[i % k].position;
    let origin = at(0);
    let sides = (0..k).map(|i| (at(i) - origin).cross(&(at(i + 1) - origin)));
    let twice: Vec3 = sides.sum();
    let normal = twice
        .try_normalize(f64::MIN_POSITIVE)
        .unwrap_or_else(Vec3::zeros);
    let row = |i: usize| (at(i + 1) - at(i + k - 1)).cross(&normal) * 0.5;
    (0.5 * twice.norm(), (0..k).map(row).collect())
}

/// Length over width of a face; `None` where it has no area.
fn aspect(corners: &[Corner], frame: &FaceFrame, most: f64) -> Option<Inequality> {
    let moments = Moments::of(corners);
    if moments.area == 0.0 {
        return None;
    }
    let second = moments.about_centroid();
    let (mean, apart) = (
        0.5 * (second.m11 + second.m22),
        0.5 * (second.m11 - second.m22),
    );
    let radius = apart.hypot(second.m12);
    let [length, width] = [mean + radius, mean - radius].map(|l| l.max(f64::MIN_POSITIVE));
    let (sin, cos) = (0.5 * second.m12.atan2(apart)).sin_cos();
    let (by_length, by_width) = (
        moments.derivatives(corners, Vec2::new(cos, sin)),
        moments.derivatives(corners, Vec2::new(-sin, cos)),
    );
    let ratio = (length / width).sqrt();
    let row = |i: usize| {
        let flat = (by_length[i] / length - by_width[i] / width) * (0.5 * ratio);
        frame.plane.axes[0] * flat.x + frame.plane.axes[1] * flat.y
    };
    let rows: Vec<Vec3> = (0..corners.len()).map(row).collect();
    Some(Inequality::at_most(ratio, most, &rows))
}

/// Area, first and second moments of a polygon in its plane.
struct Moments {
    area: f64,
    first: Vec2,
    second: Matrix2<f64>,
}

impl Moments {
    fn of(corners: &[Corner]) -> Self {
        let mut moments = Self {
            area: 0.0,
            first: Vec2::zeros(),
            second: Matrix2::zeros(),
        };
        for [a, b] in sides(corners) {
            let twice = a.perp(&b);
            let mixed = a * b.transpose();
            moments.area += twice / 2.0;
            moments.first += (a + b) * (twice / 6.0);
            let squares = a * a.transpose() + b * b.transpose();
            moments.second += (squares * 2.0 + mixed + mixed.transpose()) * (twice / 24.0);
        }
        moments
    }

    fn about_centroid(&self) -> Matrix2<f64> {
        let centroid = self.first / self.area;
        self.second / self.area - centroid * centroid.transpose()
    }

    /// Derivatives by the corners of `S / A - (F / A)^2`, the second moment along an axis.
    fn derivatives(&self, corners: &[Corner], axis: Vec2) -> Vec<Vec2> {
        let (area, first) = (self.area, self.first.dot(&axis));
        let second = (self.second * axis).dot(&axis);
        let by_area = -second / (area * area) + 2.0 * first * first / area.powi(3);
        let by_first = -2.0 * first / (area * area);
        let mut rows = vec![Vec2::zeros(); corners.len()];
        for (i, [a, b]) in sides(corners).enumerate() {
            let (s, t) = (a.dot(&axis), b.dot(&axis));
            let twice = a.perp(&b);
            // What the side adds, by its cross product and by s and t.
            let by_cross =
                by_area / 2.0 + by_first * (s + t) / 6.0 + (s * s + s * t + t * t) / (12.0 * area);
            let by_s = twice * (by_first / 6.0 + (2.0 * s + t) / (12.0 * area));
            let by_t = twice * (by_first / 6.0 + (s + 2.0 * t) / (12.0 * area));
            rows[i] += Vec2::new(b.y, -b.x) * by_cross + axis * by_s;
            rows[(i + 1) % corners.len()] += Vec2::new(-a.y, a.x) * by_cross + axis * by_t;
        }
        rows
    }
}

fn sides(corners: &[Corner]) -> impl Iterator<Item = [Vec2; 2]> + '_ {
    let k = corners.len();
    (0..k).map(move |i| [corners[i].flat, corners[(i + 1) % k].flat])
}
