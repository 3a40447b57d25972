//! Panels as rigid bodies of convex pieces, and how deep two of them are in one another.

use super::Placement;
use crate::outline::outward;
use phex_mesh::Vec2;
use phex_mesh::polygon::sides;

/// A convex polygon, counter-clockwise, with the outward unit normals of its sides.
#[derive(Clone, Debug)]
struct Convex {
    corners: Vec<Vec2>,
    normals: Vec<Vec2>,
}

/// A panel (with half of the spacing round it), about its centroid.
#[derive(Clone, Debug)]
pub struct Body {
    pieces: Vec<Convex>,
    /// Centroid in the panel's own frame.
    centroid: Vec2,
    /// Distance of the farthest corner from the centroid, in mm.
    pub radius: f64,
    /// Area, in mm².
    pub area: f64,
    /// Moment of inertia over area, in mm².
    inertia: f64,
    /// The angles that it may have; any if there is none.
    pub angles: Option<Vec<f64>>,
}

/// A body in its place.
#[derive(Clone, Debug)]
pub struct Posed {
    /// Where its centroid is.
    pub centre: Vec2,
    /// How far it is turned, in radians.
    pub angle: f64,
    pieces: Vec<Convex>,
}

/// Where two bodies are in one another.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// How far the second has to move along the normal.
    pub depth: f64,
    /// Unit vector from the first to the second.
    pub normal: Vec2,
    /// The deepest point.
    pub point: Vec2,
}

impl Body {
    /// From convex pieces that cover a polygon once.
    pub fn new(pieces: &[Vec<Vec2>], angles: Option<Vec<f64>>) -> Self {
        let parts: Vec<[f64; 4]> = pieces.iter().flat_map(|p| moments(p)).collect();
        let sum = |k: usize| parts.iter().map(|m| m[k]).sum::<f64>();
        let area = sum(0);
        let centroid = Vec2::new(sum(1), sum(2)) / area;
        let about = |piece: &Vec<Vec2>| Convex {
            corners: piece.iter().map(|p| p - centroid).collect(),
            normals: sides(piece).map(|[a, b]| outward(a, b)).collect(),
        };
        let pieces: Vec<Convex> = pieces.iter().map(about).collect();
        let radius = pieces.iter().flat_map(|p| &p.corners).map(Vec2::norm);
        Self {
            radius: radius.fold(0.0, f64::max),
            centroid,
            area,
            inertia: sum(3) / area - centroid.norm_squared(),
            pieces,
            angles,
        }
    }

    /// In the place of a panel.
    pub fn placed(&self, placement: &Placement) -> Posed {
        let centre = placement.apply(&[self.centroid])[0];
        self.posed(centre, placement.rotation)
    }

    /// Turned by an angle, its centroid at a point.
    pub fn posed(&self, centre: Vec2, angle: f64) -> Posed {
        let mut posed = Posed {
            centre,
            angle,
            pieces: self.pieces.clone(),
        };
        self.pose(&mut posed, centre, angle);
        posed
    }

    /// Moves it elsewhere.
    pub fn pose(&self, posed: &mut Posed, centre: Vec2, angle: f64) {
        let (s, c) = angle.sin_cos();
        let turn = |p: &Vec2| Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y);
        for (to, from) in posed.pieces.iter_mut().zip(&self.pieces) {
            for (q, p) in to.corners.iter_mut().zip(&from.corners) {
                *q = turn(p) + centre;
            }
            for (m, n) in to.normals.iter_mut().zip(&from.normals) {
                *m = turn(n);
            }
        }
        (posed.centre, posed.angle) = (centre, angle);
    }

    /// The place of the panel.
    pub fn placement(&self, plate: usize, posed: &Posed) -> Placement {
        let (s, c) = posed.angle.sin_cos();
        let p = self.centroid;
        Placement {
            plate,
            rotation: posed.angle,
            translation: posed.centre - Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y),
        }
    }

    /// How far a push at a point of the body shifts and turns it: the body's share of a joint
    /// motion, and its turn per unit of push.
    pub fn mobility(&self, posed: &Posed, point: Vec2, normal: Vec2) -> [f64; 2] {
        let lever = (point - posed.centre).perp(&normal);
        let turn = if self.angles.is_none() {
            lever / (self.area * self.inertia)
        } else {
            0.0
        };
        [1.0 / self.area + lever * turn, turn]
    }
}

impl Posed {
    /// The corners of all pieces.
    pub fn corners(&self) -> impl Iterator<Item = &Vec2> {
        self.pieces.iter().flat_map(|p| &p.corners)
    }

    /// The deepest contact of each pair of pieces.
    pub fn contacts<'a>(&'a self, other: &'a Posed) -> impl Iterator<Item = Contact> + 'a {
        let pairs = move |a| other.pieces.iter().filter_map(move |b| contact(a, b));
        self.pieces.iter().flat_map(pairs)
    }
}

/// Area, first moments and polar moment of the triangles from the origin to the sides of a polygon.
fn moments(polygon: &[Vec2]) -> impl Iterator<Item = [f64; 4]> + '_ {
    sides(polygon).map(|[a, b]| {
        let area = 0.5 * a.perp(&b);
        let middle = (a + b) / 3.0;
        let polar = (a.norm_squared() + a.dot(&b) + b.norm_squared()) / 6.0;
        [area, area * middle.x, area * middle.y, area * polar]
    })
}

/// The side of either polygon along which they come apart soonest (separating axes); `None` if they
/// are apart.
fn contact(a: &Convex, b: &Convex) -> Option<Contact> {
    let (from_a, normal, point) = gap(a, b)?;
    let (from_b, back, other) = gap(b, a)?;
    Some(if from_a >= from_b {
        Contact {
            depth: -from_a,
            normal,
            point,
        }
    } else {
        Contact {
            depth: -from_b,
            normal: -back,
            point: other,
        }
    })
}

/// Largest gap between a side of one polygon and the other polygon; negative if they overlap,
/// `None` if they do not.
fn gap(a: &Convex, b: &Convex) -> Option<(f64, Vec2, Vec2)> {
    let mut best: Option<(f64, Vec2, Vec2)> = None;
    for (corner, normal) in a.corners.iter().zip(&a.normals) {
        let (mut low, mut at) = (f64::INFINITY, *corner);
        for p in &b.corners {
            let height = normal.dot(&(p - corner));
            if height < low {
                (low, at) = (height, *p);
            }
        }
        if low >= 0.0 {
            return None;
        }
        if best.is_none_or(|(most, ..)| low > most) {
            best = Some((low, *normal, at));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side: f64) -> Body {
        let corner = |x: f64, y: f64| Vec2::new(x, y) * side;
        let piece = vec![
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ];
        Body::new(&[piece], None)
    }

    #[test]
    fn moments_of_a_square() {
        let body = square(2.0);
        assert!((body.area - 4.0).abs() < 1e-14);
        assert!((body.centroid - Vec2::repeat(1.0)).norm() < 1e-14);
        assert!(
            (body.inertia - 4.0 / 6.0).abs() < 1e-14,
            "(a² + b²) / 12 for sides a, b"
        );
    }

    #[test]
    fn depth_is_the_shortest_way_out() {
        let body = square(1.0);
        let a = body.posed(Vec2::zeros(), 0.0);
        let b = body.posed(Vec2::new(0.9, 0.3), 0.0);
        let contact = a.contacts(&b).next().unwrap();
        assert!((contact.depth - 0.1).abs() < 1e-14 && (contact.normal - Vec2::x()).norm() < 1e-14);
        let turned = body.posed(
            Vec2::new(0.5 + 0.5f64.sqrt() - 0.05, 0.0),
            0.25 * std::f64::consts::PI,
        );
        let contact = a.contacts(&turned).next().unwrap();
        assert!((contact.depth - 0.05).abs() < 1e-14);
        let apart = body.posed(Vec2::new(1.001, 0.0), 0.0);
        assert_eq!(a.contacts(&apart).count(), 0);
    }

    #[test]
    fn a_place_goes_there_and_back() {
        let body = square(3.0);
        let placement = Placement {
            plate: 7,
            rotation: 0.7,
            translation: Vec2::new(5.0, -2.0),
        };
        let back = body.placement(7, &body.placed(&placement));
        assert!((back.translation - placement.translation).norm() < 1e-14 && back.rotation == 0.7);
    }
}
