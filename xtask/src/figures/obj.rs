//! OBJ files as the figures need them: read, changed, written.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

/// Panels of a strip on each side of the one that it is drawn through.
const STRIP: usize = 9;

/// Points and faces (numbers from 0).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    pub points: Vec<[f64; 3]>,
    pub faces: Vec<Vec<usize>>,
}

impl Obj {
    /// Reads vertices and faces; everything else is left out.
    pub fn read(path: &Path) -> Result<Self, String> {
        Self::parse(&crate::read(path)?)
            .ok_or_else(|| format!("{}: not understood", path.display()))
    }

    fn parse(text: &str) -> Option<Self> {
        let mut obj = Self::default();
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let numbers: Vec<f64> = words.map(|w| w.parse().ok()).collect::<Option<_>>()?;
                    obj.points
                        .push([*numbers.first()?, *numbers.get(1)?, *numbers.get(2)?]);
                }
                Some("f") => {
                    let corner =
                        |w: &str| w.split('/').next()?.parse::<usize>().ok()?.checked_sub(1);
                    obj.faces.push(words.map(corner).collect::<Option<_>>()?);
                }
                _ => {}
            }
        }
        Some(obj)
    }

    /// Writes the mesh.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let mut text = String::new();
        for [x, y, z] in &self.points {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
            let _ = writeln!(text, "f {}", corners.join(" "));
        }
        std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// The same faces with every point mapped.
    pub fn mapped(&self, mut map: impl FnMut([f64; 3]) -> [f64; 3]) -> Self {
        Self {
            points: self.points.iter().map(|p| map(*p)).collect(),
            faces: self.faces.clone(),
        }
    }

    /// The faces whose centre is wanted, with their points.
    pub fn part(&self, wanted: impl Fn([f64; 3]) -> bool) -> Self {
        let kept = self.faces.iter().filter(|f| wanted(self.centre(f)));
        let mut number: HashMap<usize, usize> = HashMap::new();
        let mut part = Self::default();
        for face in kept {
            let renumbered = face.iter().map(|&v| {
                *number.entry(v).or_insert_with(|| {
                    part.points.push(self.points[v]);
                    part.points.len() - 1
                })
            });
            let renumbered = renumbered.collect();
            part.faces.push(renumbered);
        }
        part
    }

    /// Both meshes in one.
    pub fn with(&self, other: &Self) -> Self {
        let first = self.points.len();
        let mut both = self.clone();
        both.points.extend(&other.points);
        let shifted = other
            .faces
            .iter()
            .map(|f| f.iter().map(|v| v + first).collect());
        both.faces.extend(shifted);
        both
    }

    /// Regular hexagons in rings about one, in the plane.
    pub fn honeycomb(rings: i32) -> Self {
        let mut number: HashMap<[i64; 2], usize> = HashMap::new();
        let mut obj = Self::default();
        let cells = (-rings..=rings).flat_map(|q| (-rings..=rings).map(move |r| (q, r)));
        for (q, r) in cells.filter(|(q, r)| (q + r).abs() <= rings) {
            let (q, r) = (f64::from(q), f64::from(r));
            let (x, y) = (1.5 * q, 3f64.sqrt() * (r + 0.5 * q));
            let corner = |k: i32| {
                let (sin, cos) = (std::f64::consts::FRAC_PI_3 * f64::from(k)).sin_cos();
                let p = [x + cos, y + sin];
                *number
                    .entry(p.map(|x| (4.0 * x).round() as i64))
                    .or_insert_with(|| {
                        obj.points.push([p[0], p[1], 0.0]);
                        obj.points.len() - 1
                    })
            };
            let face = (0..6).map(corner).collect();
            obj.faces.push(face);
        }
        obj
    }

    /// What lies between two heights along an axis ([`along`]); faces are cut there.
    pub fn between(&self, axis: usize, low: f64, high: f64) -> Self {
        let cut = self.cut(axis, low, 1.0).cut(axis, high, -1.0);
        cut.part(|_| true)
    }

    /// What lies on one side of a height along an axis, `side` 1 above it, -1 below it.
    fn cut(&self, axis: usize, height: f64, side: f64) -> Self {
        let mut points = self.points.clone();
        let mut on_edge: HashMap<[usize; 2], usize> = HashMap::new();
        let over = |p: &[f64; 3]| side * (along(*p, axis) - height);
        let faces = self.faces.iter().map(|face| {
            let mut kept = Vec::new();
            for (k, &v) in face.iter().enumerate() {
                let w = face[(k + 1) % face.len()];
                let [a, b] = [v, w].map(|v| over(&self.points[v]));
                if a >= 0.0 {
                    kept.push(v);
                }
                if (a < 0.0) != (b < 0.0) {
                    // From the same end on both faces of the edge, to the last bit.
                    let ends = [v.min(w), v.max(w)];
                    kept.push(*on_edge.entry(ends).or_insert_with(|| {
                        let [p, q] = ends.map(|v| self.points[v]);
                        let t = over(&p) / (over(&p) - over(&q));
                        points.push(std::array::from_fn(|k| p[k] + t * (q[k] - p[k])));
                        points.len() - 1
                    }));
                }
            }
            kept
        });
        let faces = faces.collect::<Vec<_>>();
        let faces = faces.into_iter().filter(|f| f.len() > 2).collect();
        Self { points, faces }
    }

    /// Mean of a face's corners.
    pub fn centre(&self, face: &[usize]) -> [f64; 3] {
        let sum = face.iter().fold([0.0; 3], |s, &v| {
            std::array::from_fn(|k| s[k] + self.points[v][k])
        });
        sum.map(|x| x / face.len() as f64)
    }

    /// The centre of the hexagon nearest to a point.
    pub fn hexagon_near(&self, p: [f64; 3]) -> Option<usize> {
        let hexagons = (0..self.faces.len()).filter(|&f| self.faces[f].len() == 6);
        let far = |f: usize| distance(self.centre(&self.faces[f]), p);
        hexagons.min_by(|&a, &b| far(a).total_cmp(&far(b)))
    }

    /// One face alone.
    pub fn face(&self, face: usize) -> Self {
        let corners = &self.faces[face];
        Self {
            points: corners.iter().map(|&v| self.points[v]).collect(),
            faces: vec![(0..corners.len()).collect()],
        }
    }

    /// Interior angles of the only, convex face.
    pub fn angles(&self) -> Vec<f64> {
        let n = self.points.len();
        let corner = |k: usize| {
            let p = self.points[k];
            let (a, b) = (
                minus(self.points[(k + 1) % n], p),
                minus(self.points[(k + n - 1) % n], p),
            );
            (dot(a, b) / (dot(a, a) * dot(b, b)).sqrt())
                .clamp(-1.0, 1.0)
                .acos()
        };
        (0..n).map(corner).collect()
    }

    /// The circle through every second corner of the only face, and how far the others are off it,
    /// over its radius.
    pub fn circle(&self) -> (Vec<[f64; 3]>, f64) {
        let [a, b, c] = [0, 2, 4].map(|k| self.points[k]);
        let (u, v) = (minus(b, a), minus(c, a));
        let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
        let twice = 2.0 * (uu * vv - uv * uv);
        let (s, t) = (vv * (uu - uv) / twice, uu * (vv - uv) / twice);
        let centre: [f64; 3] = std::array::from_fn(|k| a[k] + s * u[k] + t * v[k]);
        let radius = distance(centre, a);
        let e = minus(a, centre);
        let across: [f64; 3] = std::array::from_fn(|k| v[k] - uv / uu * u[k]);
        let (along, across) = (unit(u), unit(across));
        let (x, y) = (dot(e, along), dot(e, across));
        let start = y.atan2(x);
        let at = |i: usize| {
            let (sin, cos) = (start + std::f64::consts::TAU * i as f64 / 120.0).sin_cos();
            std::array::from_fn(|k| centre[k] + radius * (cos * along[k] + sin * across[k]))
        };
        let off = self
            .points
            .iter()
            .map(|p| (distance(*p, centre) / radius - 1.0).abs());
        ((0..=120).map(at).collect(), off.fold(0.0, f64::max))
    }

    /// The face on the other side of each directed edge.
    fn across(&self) -> HashMap<(usize, usize), usize> {
        let edges = |(f, face): (usize, &Vec<usize>)| {
            let n = face.len();
            (0..n)
                .map(|k| ((face[k], face[(k + 1) % n]), f))
                .collect::<Vec<_>>()
        };
        self.faces.iter().enumerate().flat_map(edges).collect()
    }

    /// The strips of hexagons through one of them, up to [`STRIP`] panels to each side: across each
    /// of its three pairs of opposite edges, the panels of the strip.
    pub fn strips(&self, face: usize) -> Vec<Vec<usize>> {
        let across = self.across();
        let walk = |edge: usize| {
            let (mut f, mut k, mut way) = (face, edge, Vec::new());
            while way.len() <= STRIP && self.faces[f].len() == 6 {
                way.push(f);
                let (a, b) = (self.faces[f][k], self.faces[f][(k + 1) % 6]);
                let Some(&next) = across.get(&(b, a)) else {
                    break;
                };
                let entered = self.faces[next].iter().position(|&v| v == b);
                let (Some(entered), 6) = (entered, self.faces[next].len()) else {
                    break;
                };
                (f, k) = (next, (entered + 3) % 6);
                if f == face {
                    break;
                }
            }
            way
        };
        let whole = |k: usize| {
            let mut way = walk(k + 3);
            way.reverse();
            way.extend(walk(k).into_iter().skip(1));
            way
        };
        (0..3).map(whole).collect()
    }
}

/// How far a point is along an axis; the fourth one is the distance from the z axis.
pub fn along(p: [f64; 3], axis: usize) -> f64 {
    p.get(axis).copied().unwrap_or_else(|| p[0].hypot(p[1]))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Distance of two points.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Writes polylines as OBJ.
pub fn write_curves(path: &Path, curves: &[Vec<[f64; 3]>]) -> Result<(), String> {
    let mut text = String::new();
    let mut next = 1;
    for curve in curves {
        for [x, y, z] in curve {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        let numbers: Vec<String> = (next..next + curve.len()).map(|i| i.to_string()).collect();
        let _ = writeln!(text, "l {}", numbers.join(" "));
        next += curve.len();
    }
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_is_straight_and_shared_by_both_faces_of_an_edge() {
        let cut = Obj::honeycomb(2).between(1, -0.3, 1.1);
        let heights = || cut.points.iter().map(|p| p[1]);
        assert!(heights().all(|y| (-0.3 - 1e-12..=1.1 + 1e-12).contains(&y)));
        assert!(heights().filter(|y| (y - 1.1).abs() < 1e-12).count() > 4);
        // Every point once: an edge that is cut has one point on the cut.
        for (i, p) in cut.points.iter().enumerate() {
            assert!(cut.points[..i].iter().all(|q| distance(*p, *q) > 1e-9));
        }
        assert_eq!(Obj::honeycomb(2).faces.len(), 19);
    }

    /// Three by three hexagons of a honeycomb, by their corners' places.
    fn honeycomb() -> Obj {
        let mut obj = Obj::default();
        let mut number: HashMap<(i64, i64), usize> = HashMap::new();
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let (cx, cy) = (
                1.5 * f64::from(i),
                3.0f64.sqrt() * (f64::from(j) + 0.5 * f64::from(i)),
            );
            let face = (0..6).map(|k| {
                let angle = std::f64::consts::FRAC_PI_3 * f64::from(k);
                let (x, y) = (cx + angle.cos(), cy + angle.sin());
                let key = ((x * 1e6).round() as i64, (y * 1e6).round() as i64);
                *number.entry(key).or_insert_with(|| {
                    obj.points.push([x, y, 0.0]);
                    obj.points.len() - 1
                })
            });
            let face = face.collect();
            obj.faces.push(face);
        }
        obj
    }

    #[test]
    fn strips_run_straight_through_a_honeycomb() {
        let obj = honeycomb();
        let strips = obj.strips(4);
        assert_eq!(strips.len(), 3);
        for strip in &strips {
            assert!(strip.len() == 3 && strip[1] == 4, "{strip:?}");
            let [a, b, c] = [0, 1, 2].map(|k| obj.centre(&obj.faces[strip[k]]));
            assert!((0..3).all(|k| (a[k] + c[k] - 2.0 * b[k]).abs() < 1e-9));
        }
    }

    #[test]
    fn a_regular_hexagon_has_a_circle_and_angles_of_120_degrees() {
        let hexagon = honeycomb().face(4);
        let (circle, off) = hexagon.circle();
        assert!(off < 1e-12);
        assert!(
            circle
                .iter()
                .all(|p| (distance(*p, hexagon.centre(&hexagon.faces[0])) - 1.0).abs() < 1e-12)
        );
        assert!(
            hexagon
                .angles()
                .iter()
                .all(|a| (a.to_degrees() - 120.0).abs() < 1e-9)
        );
    }

    #[test]
    fn a_part_has_its_own_points() {
        let obj = honeycomb();
        let part = obj.part(|c| c[0] < 0.1);
        assert_eq!((part.faces.len(), part.points.len()), (3, 14));
        let both = part.with(&part);
        assert_eq!((both.faces.len(), both.faces[3][0]), (6, 14));
    }
}
