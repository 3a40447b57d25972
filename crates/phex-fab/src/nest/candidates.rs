//! Where a panel touches two others, or one and the border.

use super::Border;
use super::convex::no_fit;
use phex_mesh::polygon::{point_segment_distance, sides};
use phex_mesh::{Vec2, bounds};

/// Weight of the height of a place, over that of how far it reaches along the sheet.
const HEIGHT: f64 = 0.05;
/// Weight of snugness, in sizes of the panel.
const SNUG: f64 = 2.0;
/// Distance that counts as touching, in sizes of the panel.
const CLOSE: f64 = 0.03;
/// Where sides are sampled.
const SAMPLES: [f64; 2] = [0.25, 0.75];
/// How far behind the front places are looked for, in diameters of the panel.
const BACK: f64 = 1.6;

/// A convex polygon with its bounding box.
pub struct Zone {
    corners: Vec<Vec2>,
    low: Vec2,
    high: Vec2,
}

/// The cheapest translation that `is_free` allows, with its cost. `pieces` are the convex pieces of
/// the panel, already turned.
pub fn cheapest(
    border: &Border,
    placed: &[Zone],
    pieces: &[Vec<Vec2>],
    mut is_free: impl FnMut(Vec2) -> bool,
) -> Option<(f64, Vec2, f64)> {
    let [low, high] = bounds(&pieces.concat());
    let room = Border {
        low: border.low - low,
        high: border.high - high,
    };
    if room.low.x > room.high.x || room.low.y > room.high.y {
        return None;
    }
    let front = placed.iter().map(|p| p.high.x).fold(border.low.x, f64::max);
    let back = front - BACK * (high - low).norm();
    let late: Vec<&Zone> = placed.iter().filter(|p| p.high.x >= back).collect();
    let zones: Vec<Zone> = late
        .iter()
        .flat_map(|fixed| {
            pieces
                .iter()
                .map(|moving| Zone::new(no_fit(&fixed.corners, moving)))
        })
        .filter(|z| meet([z.low, z.high], [room.low, room.high]))
        .collect();
    let reach = |p: Vec2| (p.x + high.x + HEIGHT * (p.y + high.y), p);
    let points = contacts(&exposed_sides(&zones), &zones, &room);
    let mut places: Vec<(f64, Vec2)> = points.into_iter().map(reach).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.y.total_cmp(&b.1.y)));
    let size = (high - low).product().sqrt();
    let held = |p: &Vec2| zones.iter().any(|z| z.holds(p));
    let mut best: Option<(f64, Vec2, f64)> = None;
    for (reach, p) in places {
        if best.is_some_and(|(cost, ..)| reach - SNUG * size >= cost) {
            break;
        }
        if !held(&p) && is_free(p) {
            let cost = reach - SNUG * size * snugness(border, &late, pieces, p, CLOSE * size);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, p, p.x + high.x));
            }
        }
    }
    best
}

/// The share of the samples along the sides of some pieces, moved by `p`, that are close to the
/// border or to other pieces.
fn snugness(border: &Border, placed: &[&Zone], pieces: &[Vec<Vec2>], p: Vec2, close: f64) -> f64 {
    let [low, high] = bounds(&pieces.concat());
    let around = [
        low + p - Vec2::repeat(close),
        high + p + Vec2::repeat(close),
    ];
    let near: Vec<&Zone> = placed
        .iter()
        .copied()
        .filter(|z| meet([z.low, z.high], around))
        .collect();
    let at_border = |q: &Vec2| (q - border.low).min() < close || (border.high - q).min() < close;
    let touches = |q: &Vec2| at_border(q) || near.iter().any(|z| z.is_within(q, close));
    let samples = pieces
        .iter()
        .flat_map(|piece| sides(piece))
        .flat_map(|[a, b]| {
            let length = (b - a).norm();
            SAMPLES.iter().map(move |t| (a + (b - a) * *t + p, length))
        });
    let (mut all, mut touching) = (0.0, 0.0);
    for (q, length) in samples {
        all += length;
        touching += if touches(&q) { length } else { 0.0 };
    }
    touching / all
}

/// The sides of each zone that no other holds: on the rest the panel would overlap what is there.
fn exposed_sides(zones: &[Zone]) -> Vec<Vec<[Vec2; 2]>> {
    let exposed = |zone: &Zone| {
        let near = |z: &&Zone| meet([z.low, z.high], [zone.low, zone.high]);
        let near: Vec<&Zone> = zones.iter().filter(near).collect();
        let mut last = 0;
        let mut is_exposed = |side: &[Vec2; 2]| {
            let holds = |k: &usize| side.iter().all(|p| near[*k].holds(p));
            // What holds a side often holds the next.
            let found = (last..near.len()).chain(0..last).find(holds);
            last = found.unwrap_or(last);
            found.is_none()
        };
        sides(&zone.corners).filter(|s| is_exposed(s)).collect()
    };
    zones.iter().map(exposed).collect()
}

/// Corners of the room, and where exposed sides of zones cross the room's or one another.
fn contacts(exposed: &[Vec<[Vec2; 2]>], zones: &[Zone], room: &Border) -> Vec<Vec2> {
    let mut points = room.corners().to_vec();
    let corners = room.corners();
    for side in exposed.iter().flatten() {
        points.extend(sides(&corners).filter_map(|t| crossing(*side, t)));
    }
    for (i, a) in zones.iter().enumerate() {
        for (j, b) in zones[..i].iter().enumerate() {
            if meet([a.low, a.high], [b.low, b.high]) {
                crossings(&exposed[i], (b, &exposed[j]), &mut points);
            }
        }
    }
    let inside = |p: &Vec2| {
        p.x >= room.low.x && p.x <= room.high.x && p.y >= room.low.y && p.y <= room.high.y
    };
    points.retain(inside);
    points
}

impl Zone {
    /// A polygon that is convex and counter-clockwise.
    pub fn new(corners: Vec<Vec2>) -> Self {
        let [low, high] = bounds(&corners);
        Self { corners, low, high }
    }

    /// Whether a point is closer to a side than a distance.
    fn is_within(&self, p: &Vec2, close: f64) -> bool {
        let beyond = (self.low - p).sup(&(p - self.high)).max();
        beyond < close
            && sides(&self.corners).any(|[a, b]| point_segment_distance(*p, a, b) < close)
    }

    /// Whether a point is inside by more than rounding.
    fn holds(&self, p: &Vec2) -> bool {
        let deep = 1e-9 * (self.high - self.low).norm();
        let beyond = |[a, b]: [Vec2; 2]| (b - a).perp(&(p - a)) > deep * (b - a).norm();
        p.x > self.low.x
            && p.x < self.high.x
            && p.y > self.low.y
            && p.y < self.high.y
            && sides(&self.corners).all(beyond)
    }
}

fn meet([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> bool {
    a.x <= d.x && c.x <= b.x && a.y <= d.y && c.y <= b.y
}

/// Where some sides cross exposed ones of a zone.
fn crossings(a: &[[Vec2; 2]], (b, exposed): (&Zone, &[[Vec2; 2]]), points: &mut Vec<Vec2>) {
    for s in a {
        let box_of = [s[0].inf(&s[1]), s[0].sup(&s[1])];
        if meet(box_of, [b.low, b.high]) {
            points.extend(exposed.iter().filter_map(|t| crossing(*s, *t)));
        }
    }
}

/// The common point of two segments that are not parallel.
fn crossing([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> Option<Vec2> {
    let (u, v, w) = (b - a, d - c, c - a);
    let sine = u.perp(&v);
    let (s, t) = (w.perp(&v) / sine, w.perp(&u) / sine);
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t)).then(|| a + u * s)
}
