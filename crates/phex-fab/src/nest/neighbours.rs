//! Which bodies of a sheet may touch, kept while they move a little (Verlet, "Computer experiments
//! on classical fluids", Physical Review 159, 1967: lists that reach farther than contacts do).

use phex_mesh::Vec2;

/// How much farther than contacts the lists reach, in the largest radius of a body.
const SLACK: f64 = 0.5;

/// For each body those that it may touch, by growing number.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    lists: Vec<Vec<usize>>,
    /// Where the bodies were when the lists were made.
    centres: Vec<Vec2>,
    slack: f64,
    are_stale: bool,
}

impl Neighbours {
    /// Of bodies with a centre and a radius each.
    pub fn new(centres: Vec<Vec2>, radii: &[f64]) -> Self {
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let slack = SLACK * largest;
        let mut order: Vec<usize> = (0..centres.len()).collect();
        order.sort_by(|&a, &b| centres[a].x.total_cmp(&centres[b].x));
        let mut lists = vec![Vec::new(); centres.len()];
        for (at, &i) in order.iter().enumerate() {
            let within = radii[i] + largest + slack;
            let right = order[at + 1..].iter().copied();
            for j in right.take_while(|&j| centres[j].x - centres[i].x < within) {
                let reach = radii[i] + radii[j] + slack;
                if (centres[i] - centres[j]).norm_squared() < reach * reach {
                    lists[i].push(j);
                    lists[j].push(i);
                }
            }
        }
        for list in &mut lists {
            list.sort_unstable();
        }
        Self {
            lists,
            centres,
            slack,
            are_stale: false,
        }
    }

    /// Tells where a body is now.
    pub fn moved(&mut self, i: usize, centre: Vec2) {
        self.are_stale |= 2.0 * (centre - self.centres[i]).norm() > self.slack;
    }

    /// Whether a body has moved so far that one that it touches may be missing.
    pub fn are_stale(&self) -> bool {
        self.are_stale
    }

    /// All that a body may touch.
    pub fn of(&self, i: usize) -> &[usize] {
        &self.lists[i]
    }

    /// Those of them with a smaller number.
    pub fn before(&self, i: usize) -> &[usize] {
        self.split(i).0
    }

    /// Those of them with a larger number.
    pub fn after(&self, i: usize) -> &[usize] {
        self.split(i).1
    }

    fn split(&self, i: usize) -> (&[usize], &[usize]) {
        let list = &self.lists[i];
        list.split_at(list.partition_point(|&j| j < i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_is_within_reach_is_a_neighbour_until_somebody_has_moved_far() {
        let centres: Vec<Vec2> = (0..40)
            .map(|k| Vec2::new(f64::from(k * 37 % 40), f64::from(k * 11 % 7)))
            .collect();
        let radii: Vec<f64> = (0..40).map(|k| 0.4 + 0.1 * f64::from(k % 5)).collect();
        let mut near = Neighbours::new(centres.clone(), &radii);
        for i in 0..40 {
            let within = |&j: &usize| {
                let reach = radii[i] + radii[j] + SLACK * 0.8;
                i != j && (centres[i] - centres[j]).norm() < reach
            };
            let all: Vec<usize> = (0..40).filter(within).collect();
            assert_eq!(near.of(i), all);
            assert_eq!([near.before(i), near.after(i)].concat(), all);
        }
        near.moved(3, centres[3] + Vec2::new(0.1, 0.0));
        assert!(!near.are_stale());
        near.moved(3, centres[3] + Vec2::new(0.3, 0.0));
        assert!(near.are_stale());
    }
}
