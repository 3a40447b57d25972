//! What is the same: equal lengths, equal angles, congruent panels. Their numbers are those of
//! distinct lengths and moulds.

use crate::Vec2;
use crate::polygon::signed_area;
use std::collections::BTreeMap;

/// Share of a panel's size by which rounding may change a distance.
const ROUNDING: f64 = 1e-9;

/// Things that are the same within a tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Middle of the least and the largest value; for panels the area of the first one's first
    /// ring.
    pub value: f64,
    /// Difference of the largest and the least value; for panels the largest distance of corners
    /// from the first panel's.
    pub spread: f64,
    /// Numbers of the members, growing.
    pub members: Vec<usize>,
}

/// Groups values such that no group spreads over more than `tolerance`: the least number of groups,
/// by growing value.
///
/// ```
/// let lengths = [1.0, 1.004, 1.2];
/// assert_eq!(phex_mesh::cluster::by_value(&lengths, 0.005).len(), 2);
/// ```
pub fn by_value(values: &[f64], tolerance: f64) -> Vec<Cluster> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let together = |group: &[usize], k: usize| values[k] - values[group[0]] <= tolerance;
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for k in order {
        match groups.last_mut() {
            Some(group) if together(group, k) => group.push(k),
            _ => groups.push(vec![k]),
        }
    }
    groups
        .into_iter()
        .map(|group| cluster_of(values, group))
        .collect()
}

fn cluster_of(values: &[f64], mut members: Vec<usize>) -> Cluster {
    let ends = [members[0], members[members.len() - 1]].map(|k| values[k]);
    members.sort_unstable();
    Cluster {
        value: 0.5 * (ends[0] + ends[1]),
        spread: ends[1] - ends[0],
        members,
    }
}

/// What counts as congruent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Congruence {
    /// Panels that can be turned and moved onto each other in their plane.
    Turned,
    /// Panels that may be turned over besides.
    Mirrored,
}

/// A panel in its plane: the corners of one ring or more, each with the same number of corners in
/// the same order (a plate has a top and a bottom ring).
pub type Rings = Vec<Vec<Vec2>>;

/// Groups panels whose corners coincide up to `tolerance` after moving them in their plane. Every
/// member is compared with the first of its group, so the number depends a little on the order.
pub fn congruent(panels: &[Rings], tolerance: f64, congruence: Congruence) -> Vec<Cluster> {
    let mut clusters: Vec<Cluster> = Vec::new();
    let radii: Vec<Vec<f64>> = panels.iter().map(sorted_radii).collect();
    let mut by_radius: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (k, panel) in panels.iter().enumerate() {
        let largest = radii[k].first().copied().unwrap_or(0.0);
        let slack = tolerance.max(0.0) + ROUNDING * largest;
        let alike = |c: &usize| {
            let pairs = radii[clusters[*c].members[0]].iter().zip(&radii[k]);
            pairs.into_iter().all(|(a, b)| (a - b).abs() <= slack)
        };
        let near = (largest - slack).max(0.0).to_bits()..=(largest + slack).to_bits();
        let near = by_radius.range(near).flat_map(|(_, found)| found);
        let mut near: Vec<usize> = near.copied().filter(alike).collect();
        near.sort_unstable();
        let home = near.into_iter().find_map(|c| {
            let distance = distance(&panels[clusters[c].members[0]], panel, congruence)?;
            (distance <= tolerance).then_some((c, distance))
        });
        match home {
            Some((c, distance)) => {
                clusters[c].spread = clusters[c].spread.max(distance);
                clusters[c].members.push(k);
            }
            None => {
                let same = by_radius.entry(largest.to_bits()).or_default();
                same.push(clusters.len());
                clusters.push(Cluster {
                    value: panel.first().map_or(0.0, |ring| signed_area(ring)),
                    spread: 0.0,
                    members: vec![k],
                });
            }
        }
    }
    clusters
}

/// Distances of all corners from their middle, the largest first. Those of panels whose corners
/// coincide up to a distance differ by no more.
fn sorted_radii(panel: &Rings) -> Vec<f64> {
    let mut radii: Vec<f64> = centred(panel).iter().flatten().map(|p| p.norm()).collect();
    radii.sort_by(|a, b| b.total_cmp(a));
    radii
}

fn corners(panel: &Rings) -> usize {
    panel.first().map_or(0, Vec::len)
}

/// Largest distance of corners of two panels when they are laid on each other as well as least
/// squares can; `None` if they have different numbers of corners.
fn distance(a: &Rings, b: &Rings, congruence: Congruence) -> Option<f64> {
    let n = corners(a);
    if n != corners(b) || a.len() != b.len() {
        return None;
    }
    let p: Vec<Vec2> = centred(a).concat();
    let least = |b: &Rings| {
        let q = centred(b);
        let shifted = |shift: usize| -> Vec<Vec2> {
            let turned = |ring: &Vec<Vec2>| [&ring[shift..], &ring[..shift]].concat();
            q.iter().flat_map(turned).collect()
        };
        let distances = (0..n).map(|shift| after_turning(&p, &shifted(shift)));
        distances.min_by(f64::total_cmp)
    };
    let turned = least(b)?;
    match congruence {
        Congruence::Turned => Some(turned),
        Congruence::Mirrored => Some(turned.min(least(&mirrored(b))?)),
    }
}

fn mirrored(panel: &Rings) -> Rings {
    let over = |ring: &Vec<Vec2>| ring.iter().rev().map(|p| Vec2::new(-p.x, p.y)).collect();
    panel.iter().map(over).collect()
}

/// Corners of all rings, from the mean of all.
fn centred(panel: &Rings) -> Rings {
    let count = panel.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let centre = panel.iter().flatten().sum::<Vec2>() / count;
    let moved = |ring: &Vec<Vec2>| ring.iter().map(|p| p - centre).collect();
    panel.iter().map(moved).collect()
}

/// Largest distance after the least-squares rotation of `q` on `p`.
fn after_turning(p: &[Vec2], q: &[Vec2]) -> f64 {
    let pairs = || p.iter().zip(q);
    let sine: f64 = pairs().map(|(a, b)| b.perp(a)).sum();
    let cosine: f64 = pairs().map(|(a, b)| b.dot(a)).sum();
    let (s, c) = sine.atan2(cosine).sin_cos();
    let gap = |(a, b): (&Vec2, &Vec2)| (Vec2::new(c * b.x - s * b.y, s * b.x + c * b.y) - a).norm();
    pairs().map(gap).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_spread_no_wider_than_the_tolerance() {
        let values = [3.0, 1.0, 1.05, 1.1, 3.02, 7.0];
        let clusters = by_value(&values, 0.1 + 1e-12);
        let members: Vec<&[usize]> = clusters.iter().map(|c| &c.members[..]).collect();
        assert_eq!(members, [&[1, 2, 3][..], &[0, 4], &[5]]);
        assert!(
            (clusters[0].value - 1.05).abs() < 1e-15 && (clusters[0].spread - 0.1).abs() < 1e-15
        );
        assert_eq!(by_value(&values, 0.09).len(), 4);
        assert!(by_value(&[], 1.0).is_empty());
    }

    fn panel(ring: &[[f64; 2]], turn: f64, shift: usize, mirror: bool) -> Rings {
        let (s, c) = turn.sin_cos();
        let mut ring: Vec<Vec2> = ring
            .iter()
            .map(|&[x, y]| if mirror { [-x, y] } else { [x, y] })
            .map(|[x, y]| Vec2::new(c * x - s * y + 7.0, s * x + c * y))
            .collect();
        if mirror {
            ring.reverse();
        }
        ring.rotate_left(shift);
        vec![ring.clone(), ring]
    }

    #[test]
    fn turned_panels_are_congruent_and_mirrored_ones_only_where_they_count() {
        let shape = [[0.0, 0.0], [40.0, 0.0], [50.0, 20.0], [10.0, 35.0]];
        let near = [[0.0, 0.0], [40.0, 0.0], [50.0, 20.4], [10.0, 35.0]];
        let panels = [
            panel(&shape, 0.0, 0, false),
            panel(&shape, 2.0, 3, false),
            panel(&near, -1.0, 1, false),
            panel(&shape, 0.5, 0, true),
            panel(&shape[..3], 0.0, 0, false),
        ];
        let members = |tolerance, congruence| -> Vec<Vec<usize>> {
            congruent(&panels, tolerance, congruence)
                .into_iter()
                .map(|c| c.members)
                .collect()
        };
        let turned = |tolerance| members(tolerance, Congruence::Turned);
        assert_eq!(turned(0.5), [vec![0, 1, 2], vec![3], vec![4]]);
        assert_eq!(turned(0.01), [vec![0, 1], vec![2], vec![3], vec![4]]);
        let mirrored = members(0.01, Congruence::Mirrored);
        assert_eq!(mirrored, [vec![0, 1, 3], vec![2], vec![4]]);
    }
}
