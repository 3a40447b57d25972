//! Panels that overlap are pushed apart until they do not: every contact moves its two bodies along
//! the normal and turns them about their centroids, by what their masses and moments of inertia
//! tell (Müller, Heidelberger, Hennix and Ratcliff, "Position based dynamics", 2007, with bodies
//! for particles). Where that gets stuck the panel that overlaps most is taken out and put back
//! where it overlaps least, among random places.
//!
//! Only bodies that have been moved, or have a neighbour that was, are looked at again, and only
//! neighbours ([`Neighbours`]): a change of a few panels costs what they touch, not the sheet.
//!
//! *Guaranteed*: `true` means that no overlap is deeper than the tolerance. *Fails* where the
//! panels have no place, and now and then where they have one.

use super::Border;
use super::body::{Body, Posed};
use super::neighbours::Neighbours;
use phex_mesh::Vec2;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Sweeps after which the overlap must have shrunk.
const PATIENCE: usize = 25;
/// By this factor.
const PROGRESS: f64 = 0.8;
/// Sweeps over all contacts between two replacements.
const SWEEPS: usize = 600;
/// Random places for a panel.
const PLACES: usize = 96;
/// For so many panels one more of them is put elsewhere.
const PANELS_PER_MOVE: usize = 20;

/// Panels on a sheet that may overlap.
#[derive(Clone)]
pub struct Crowd<'a> {
    bodies: Vec<&'a Body>,
    /// Where they are.
    pub posed: Vec<Posed>,
    low: Vec2,
    high: Vec2,
    tolerance: f64,
    /// Who may touch whom.
    neighbours: Neighbours,
    /// Bodies whose contacts may have changed since they were last looked at.
    stirred: Vec<bool>,
}

impl<'a> Crowd<'a> {
    /// An empty sheet; overlap that is not deeper than the tolerance (in mm) does not matter.
    pub fn new(border: &Border, tolerance: f64) -> Self {
        Self {
            bodies: Vec::new(),
            posed: Vec::new(),
            low: border.low,
            high: border.high,
            tolerance,
            neighbours: Neighbours::default(),
            stirred: Vec::new(),
        }
    }

    /// Adds a body in its place.
    pub fn push(&mut self, body: &'a Body, posed: Posed) {
        self.bodies.push(body);
        self.posed.push(posed);
    }

    /// Makes the sheet shorter.
    pub fn shorten(&mut self, length: f64) {
        self.high.x = self.low.x + length;
    }

    /// Adds a body where it overlaps least among random places.
    pub fn add(&mut self, body: &'a Body, random: &mut ChaCha8Rng) {
        let posed = self.least_overlap(body, None, random);
        self.push(body, posed);
    }

    /// Pushes all apart; whether that succeeded.
    pub fn separate(&mut self, random: &mut ChaCha8Rng) -> bool {
        self.stirred = vec![true; self.bodies.len()];
        self.find_neighbours();
        let moves = 1 + self.bodies.len() / PANELS_PER_MOVE;
        for again in 0..=moves {
            if self.relax() {
                return true;
            }
            if again < moves {
                self.replace_worst(random);
            }
        }
        false
    }

    fn relax(&mut self) -> bool {
        let mut before = f64::INFINITY;
        for sweep in 0..SWEEPS {
            let (deepest, all) = self.sweep();
            if deepest <= self.tolerance {
                return true;
            }
            if sweep % PATIENCE == 0 {
                if all > PROGRESS * before {
                    return false;
                }
                before = all;
            }
        }
        false
    }

    /// Resolves every contact once; the deepest and the sum of all, as they were met.
    fn sweep(&mut self) -> (f64, f64) {
        let (mut deepest, mut all) = (0.0, 0.0);
        let mut met = |depth: f64| {
            deepest = f64::max(deepest, depth);
            all += depth;
        };
        for i in 0..self.bodies.len() {
            if !std::mem::replace(&mut self.stirred[i], false) {
                continue;
            }
            if self.neighbours.are_stale() {
                self.find_neighbours();
            }
            self.keep_inside(i, &mut met);
            for k in 0..self.neighbours.before(i).len() {
                let j = self.neighbours.before(i)[k];
                if self.are_near(i, j) {
                    self.push_apart(i, j, &mut met);
                }
            }
        }
        (deepest, all)
    }

    fn find_neighbours(&mut self) {
        let centres = self.posed.iter().map(|p| p.centre).collect();
        let radii: Vec<f64> = self.bodies.iter().map(|b| b.radius).collect();
        self.neighbours = Neighbours::new(centres, &radii);
    }

    fn are_near(&self, i: usize, j: usize) -> bool {
        let reach = self.bodies[i].radius + self.bodies[j].radius;
        (self.posed[i].centre - self.posed[j].centre).norm_squared() < reach * reach
    }

    fn push_apart(&mut self, i: usize, j: usize, met: &mut impl FnMut(f64)) {
        let deepest = self.posed[i]
            .contacts(&self.posed[j])
            .reduce(|a, b| if b.depth > a.depth { b } else { a });
        let Some(contact) = deepest else { return };
        met(contact.depth);
        let share =
            |k: usize| self.bodies[k].mobility(&self.posed[k], contact.point, contact.normal);
        let ([a, turn_a], [b, turn_b]) = (share(i), share(j));
        let push = (contact.depth + self.tolerance) / (a + b);
        self.shift(
            i,
            contact.normal * (-push / self.bodies[i].area),
            -push * turn_a,
        );
        self.shift(
            j,
            contact.normal * (push / self.bodies[j].area),
            push * turn_b,
        );
    }

    fn keep_inside(&mut self, i: usize, met: &mut impl FnMut(f64)) {
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let limit = if sign > 0.0 {
                self.low[axis]
            } else {
                self.high[axis]
            };
            let depth = |p: &Vec2| sign * (limit - p[axis]);
            let (mut deepest, mut point) = (0.0, Vec2::zeros());
            for p in self.posed[i].corners() {
                if depth(p) > deepest {
                    (deepest, point) = (depth(p), *p);
                }
            }
            if deepest > 0.0 {
                met(deepest);
                let mut normal = Vec2::zeros();
                normal[axis] = sign;
                let [share, turn] = self.bodies[i].mobility(&self.posed[i], point, normal);
                let push = (deepest + self.tolerance) / share;
                self.shift(i, normal * (push / self.bodies[i].area), push * turn);
            }
        }
    }

    fn shift(&mut self, i: usize, by: Vec2, turn: f64) {
        let posed = &mut self.posed[i];
        let (centre, angle) = (posed.centre + by, posed.angle + turn);
        self.bodies[i].pose(posed, centre, angle);
        self.stir(i);
    }

    /// A body has moved: it, and those whose contacts with it are counted as theirs, are looked at
    /// again.
    fn stir(&mut self, i: usize) {
        self.neighbours.moved(i, self.posed[i].centre);
        self.stirred[i] = true;
        for &k in self.neighbours.after(i) {
            self.stirred[k] = true;
        }
    }

    /// Takes out the body that overlaps most and puts it where it overlaps least.
    fn replace_worst(&mut self, random: &mut ChaCha8Rng) {
        self.find_neighbours();
        let overlap = |i: usize| {
            let (posed, radius) = (&self.posed[i], self.bodies[i].radius);
            let others = self.neighbours.of(i).iter().copied();
            self.overlap(posed, radius, others, f64::INFINITY)
        };
        let worst = (0..self.bodies.len()).map(|i| (overlap(i), i));
        let worst = worst.reduce(|a, b| if b.0 > a.0 { b } else { a });
        if let Some((_, i)) = worst {
            self.posed[i] = self.least_overlap(self.bodies[i], Some(i), random);
            self.find_neighbours();
            self.stir(i);
        }
    }

    fn least_overlap(&self, body: &Body, own: Option<usize>, random: &mut ChaCha8Rng) -> Posed {
        let mut scratch = body.posed(Vec2::zeros(), 0.0);
        let mut best = (f64::INFINITY, Vec2::zeros(), 0.0);
        for _ in 0..PLACES {
            let (u, v): (f64, f64) = (random.random(), random.random());
            let inset = 0.5 * body.radius;
            let size = (self.high - self.low).map(|s| (s - 2.0 * inset).max(0.0));
            let centre = self.low + Vec2::repeat(inset) + Vec2::new(u * size.x, v * size.y);
            let angle = match &body.angles {
                Some(angles) => angles[random.random_range(0..angles.len())],
                None => TAU * random.random::<f64>(),
            };
            body.pose(&mut scratch, centre, angle);
            let others = (0..self.bodies.len()).filter(|&k| own != Some(k));
            let overlap = self.overlap(&scratch, body.radius, others, best.0);
            if overlap < best.0 {
                best = (overlap, centre, angle);
            }
        }
        body.posed(best.1, best.2)
    }

    /// Sum of the depths of a body in some others and beyond the border; stops where that is more
    /// than `most`.
    fn overlap(
        &self,
        posed: &Posed,
        radius: f64,
        others: impl Iterator<Item = usize>,
        most: f64,
    ) -> f64 {
        let beyond = |p: &Vec2| (self.low - p).sup(&(p - self.high)).max();
        let mut sum = posed.corners().map(beyond).fold(0.0, f64::max);
        for k in others {
            if sum > most {
                break;
            }
            let (body, other) = (self.bodies[k], &self.posed[k]);
            let reach = radius + body.radius;
            if (posed.centre - other.centre).norm_squared() < reach * reach {
                sum += posed.contacts(other).map(|c| c.depth).sum::<f64>();
            }
        }
        sum
    }
}
