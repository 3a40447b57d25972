//! The order of meshes.

use super::findings::Findings;
use serde::Serialize;
use std::cmp::Ordering;

/// What meshes are compared by, smaller is better; the first difference counts.
///
/// | part | what it is |
/// |---|---|
/// | `invalid` | violations that make a mesh no planar panelling; what is not planar counts by how much |
/// | `outside` | excesses over limits, in limits, summed over faces |
/// | `cost` | what is allowed and not liked: irregular, small, tight, uneven panels, sharp corners, long edges, and the distances to the surface and its boundary |
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Merit {
    /// Violations.
    pub invalid: f64,
    /// Excesses over limits.
    pub outside: f64,
    /// What is not liked.
    pub cost: f64,
    /// Largest distance between mesh and surface, in limits: no change may make the worst place
    /// worse.
    pub off: f64,
}

/// Share of an amount by which it must differ to count: less is rounding, or chance.
const GAIN: f64 = 0.02;
/// The same for sums over a whole mesh, of which most has not changed.
const ROUNDING: f64 = 1e-9;
/// By how much the worst place may become worse, over what is gained in all.
const WORTH: f64 = 0.02;
/// Costs of a mesh in which every panel is irregular, and in which every area is off by a factor of
/// e.
const IRREGULAR: f64 = 10.0;
const UNEVEN: f64 = 4.0;
/// Cost of a lattice that is more distorted by a whole edge than it may be: between 1.1 and 2.2
/// towers and fans keep the dislocations that make their panels less long, and shallow vaults do
/// without.
const STRETCHED: f64 = 1.5;
/// Cost of a distance to the surface that is just allowed.
const OFF: f64 = 0.5;
/// Cost of a symmetry in which each panel has fewer images by a factor of e: twice as many weigh as
/// much as one irregular panel in twenty-five.
const IMAGES: f64 = 0.6;

impl Merit {
    /// The merit of faces of a mesh that has so many `panels`.
    pub(super) fn of<'a>(faces: impl Iterator<Item = &'a Findings>, panels: usize) -> Self {
        let (mut merit, mut irregular) = (Self::default(), 0);
        let share = 1.0 / panels.max(1) as f64;
        for face in faces {
            merit.invalid += face.invalid;
            merit.outside += face.outside();
            merit.cost += face.disliked() + UNEVEN * share * face.uneven;
            irregular += usize::from(face.irregular);
            merit.off = merit.off.max(face.off);
        }
        merit.cost += IRREGULAR * share * irregular as f64 + OFF * merit.off;
        merit
    }

    /// The cost that can be told of panels that are laid out and not planar yet: a `share` of them
    /// is irregular without need, `uneven` is the mean of the squared logarithms of their areas
    /// over the wished ones, and `stretch` the part by which the lattice is more distorted than a
    /// lattice may be.
    pub(crate) fn cost_of_layout(share: f64, uneven: f64, stretch: f64) -> f64 {
        IRREGULAR * share + UNEVEN * uneven + STRETCHED * stretch
    }

    /// The same for panels that no areas were wished for, which then count as uneven: `uneven` is
    /// the mean of the squared logarithms of their areas over the mean one.
    pub(crate) fn counting_uneven(self, uneven: f64) -> Self {
        Self {
            cost: self.cost + UNEVEN * uneven,
            ..self
        }
    }

    /// The same for a symmetry in which each panel has `fewer` images, as a factor, than in the one
    /// it is compared with.
    pub(crate) fn counting_fewer_images(self, fewer: f64) -> Self {
        Self {
            cost: self.cost + IMAGES * fewer.ln(),
            ..self
        }
    }

    /// What is compared, the first difference deciding.
    fn parts(&self) -> [f64; 3] {
        [self.invalid, self.outside, self.cost]
    }

    /// The first parts that differ by more than a share of the larger one.
    fn first_difference(&self, other: &Self, share: f64) -> Option<(f64, f64)> {
        let mut pairs = self.parts().into_iter().zip(other.parts());
        pairs.find(|(a, b)| (a - b).abs() > share * a.max(*b))
    }

    /// Whether nothing is invalid or outside a limit.
    pub fn is_within(&self) -> bool {
        self.invalid == 0.0 && self.outside == 0.0
    }

    /// The order; amounts that differ by chance are the same.
    pub fn compare(&self, other: &Self) -> Ordering {
        let first = self.first_difference(other, GAIN);
        first.map_or(Ordering::Equal, |(a, b)| a.total_cmp(&b))
    }

    /// The exact order, in which to look for the best of many.
    pub fn total_cmp(&self, other: &Self) -> Ordering {
        let pairs = self.parts().into_iter().zip(other.parts());
        let orders = pairs.map(|(a, b)| a.total_cmp(&b));
        orders.fold(Ordering::Equal, Ordering::then)
    }

    /// Whether it is less, by however little, and the worst place no worse beyond its limit, or by
    /// little against what is gained elsewhere.
    pub fn is_less(&self, other: &Self) -> bool {
        let worth = WORTH * (other.outside - self.outside).max(0.0);
        let farther = self.off > other.off.max(1.0) * (1.0 + ROUNDING) + worth;
        if farther && self.invalid >= other.invalid {
            return false;
        }
        let first = self.first_difference(other, ROUNDING);
        first.is_some_and(|(a, b)| a < b)
    }

    /// Whether no more is invalid or outside limits than of another one, up to rounding, whatever
    /// it costs.
    pub(crate) fn is_no_worse(&self, other: &Self) -> bool {
        let no_more = |a: f64, b: f64| a <= b * (1.0 + ROUNDING);
        no_more(self.invalid, other.invalid) && no_more(self.outside, other.outside)
    }

    /// The same before a search, which cures what is broken like what is outside limits, and not
    /// what is `uneven`.
    pub(crate) fn before_search(self, uneven: f64) -> Self {
        if self.is_within() {
            return self;
        }
        Self {
            invalid: 0.0,
            outside: self.invalid + self.outside + uneven,
            ..self
        }
    }

    /// Whether it is better by more than chance.
    pub fn is_better(&self, other: &Self) -> bool {
        self.compare(other) == Ordering::Less
    }

    /// The same where the other one has missed a tight limit: of two that miss it the nearer one is
    /// better.
    pub(crate) fn is_nearer(&self, other: &Self) -> bool {
        match self.invalid == other.invalid && self.off.max(other.off) > 1.0 {
            true => self.off < other.off,
            false => self.is_better(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_worse_is_no_more_invalid_or_outside_whatever_it_costs() {
        let now = merit(1.0, 2.0, 0.0);
        assert!(merit(1.0, 2.0, 9.0).is_no_worse(&now));
        assert!(merit(0.0, 1.0, 9.0).is_no_worse(&now));
        assert!(!merit(1.0, 2.1, 0.0).is_no_worse(&now));
        assert!(!merit(1.1, 0.0, 0.0).is_no_worse(&now));
    }

    fn merit(invalid: f64, outside: f64, cost: f64) -> Merit {
        Merit {
            invalid,
            outside,
            cost,
            ..Merit::default()
        }
    }

    #[test]
    fn no_change_makes_the_worst_place_worse() {
        let off = |merit: Merit, off: f64| Merit { off, ..merit };
        let (before, after) = (merit(0.0, 3.0, 0.0), merit(0.0, 2.0, 0.0));
        assert!(off(after, 1.5).is_less(&off(before, 1.5)));
        assert!(!off(after, 1.6).is_less(&off(before, 1.5)));
        let many = merit(0.0, 40.0, 0.0);
        assert!(off(after, 1.6).is_less(&off(many, 1.5)), "worth it");
        assert!(
            off(after, 0.9).is_less(&off(before, 0.5)),
            "within the limit"
        );
    }

    #[test]
    fn before_a_search_what_is_broken_counts_like_what_is_outside() {
        let [broken, outside] = [merit(2.0, 1.0, 0.0), merit(0.0, 9.0, 0.0)];
        assert!(outside.is_better(&broken));
        assert!(
            broken
                .before_search(0.0)
                .is_better(&outside.before_search(0.0))
        );
        assert!(
            outside
                .before_search(0.0)
                .is_better(&broken.before_search(9.0))
        );
    }

    #[test]
    fn what_is_valid_comes_first_then_what_is_within_limits() {
        assert!(merit(0.0, 9.0, 9.0).is_better(&merit(1.0, 0.0, 0.0)));
        assert!(merit(0.0, 0.1, 9.0).is_better(&merit(0.0, 0.2, 0.0)));
        assert!(merit(0.0, 0.0, 1.0).is_better(&merit(0.0, 0.0, 1.1)));
        assert!(!merit(0.0, 0.0, 1.0).is_better(&merit(0.0, 0.0, 1.01)));
        assert!(merit(0.0, 0.199, 1.0).is_better(&merit(0.0, 0.2, 2.0)));
        assert!(merit(0.0, 0.0, 9.0).is_within() && !merit(0.0, 1e-9, 0.0).is_within());
    }
}
