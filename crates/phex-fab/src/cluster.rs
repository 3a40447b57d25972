//! What is the same: congruent panels, equal lengths, equal angles. Their numbers are those of
//! distinct moulds and lengths.

use crate::plate::Plate;
use phex_mesh::Vec2;

/// Things that are the same within a tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Middle of the least and the largest value; for panels the area in mm².
    pub value: f64,
    /// Difference of the largest and the least value; for panels the largest distance of corners
    /// from the first panel's.
    pub spread: f64,
    /// Numbers of the members, growing.
    pub members: Vec<usize>,
}

/// Groups values such that no group spreads over more than `tolerance`: the least number of groups,
/// by growing value.
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

/// Groups panels whose both faces coincide, corner by corner, up to `tolerance` (mm) after turning
/// and moving them in their plane; mirrored ones are different. Every member is compared with the
/// first of its group.
pub fn congruent(plates: &[Plate], tolerance: f64) -> Vec<Cluster> {
    let mut clusters: Vec<Cluster> = Vec::new();
    let perimeters: Vec<f64> = plates.iter().map(|p| p.lengths().iter().sum()).collect();
    for (k, plate) in plates.iter().enumerate() {
        let slack = 2.0 * tolerance * plate.top.len() as f64;
        let home = clusters.iter_mut().find_map(|cluster| {
            let first = cluster.members[0];
            let alike = (perimeters[first] - perimeters[k]).abs() <= slack;
            let distance = alike.then(|| distance(&plates[first], plate)).flatten()?;
            (distance <= tolerance).then_some((cluster, distance))
        });
        match home {
            Some((cluster, distance)) => {
                cluster.spread = cluster.spread.max(distance);
                cluster.members.push(k);
            }
            None => clusters.push(Cluster {
                value: plate.area(),
                spread: 0.0,
                members: vec![k],
            }),
        }
    }
    clusters
}

/// Largest distance of corners of two panels when they are laid on each other as well as least
/// squares can; `None` if they have different numbers of corners.
fn distance(a: &Plate, b: &Plate) -> Option<f64> {
    let n = a.top.len();
    if n != b.top.len() {
        return None;
    }
    let (p, q) = (centred(a), centred(b));
    let shifted = |shift: usize| -> Vec<Vec2> {
        (0..2 * n).map(|i| q[i / n * n + (i + shift) % n]).collect()
    };
    (0..n)
        .map(|shift| after_turning(&p, &shifted(shift)))
        .min_by(f64::total_cmp)
}

/// Corners of both faces, from the mean of all.
fn centred(plate: &Plate) -> Vec<Vec2> {
    let all: Vec<Vec2> = plate.top.iter().chain(&plate.bottom).copied().collect();
    let centre = all.iter().sum::<Vec2>() / all.len() as f64;
    all.iter().map(|p| p - centre).collect()
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
    use phex_mesh::FaceId;

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

    fn plate(top: &[[f64; 2]], turn: f64, shift: usize, mirror: bool) -> Plate {
        let (s, c) = turn.sin_cos();
        let mut top: Vec<Vec2> = top
            .iter()
            .map(|&[x, y]| if mirror { [-x, y] } else { [x, y] })
            .map(|[x, y]| Vec2::new(c * x - s * y + 7.0, s * x + c * y))
            .collect();
        if mirror {
            top.reverse();
        }
        top.rotate_left(shift);
        Plate {
            face: FaceId::new(0),
            bottom: top.clone(),
            outline: top.clone(),
            top,
            sides: vec![],
            thickness: 1.0,
        }
    }

    #[test]
    fn turned_panels_are_congruent_and_mirrored_ones_are_not() {
        let shape = [[0.0, 0.0], [40.0, 0.0], [50.0, 20.0], [10.0, 35.0]];
        let near = [[0.0, 0.0], [40.0, 0.0], [50.0, 20.4], [10.0, 35.0]];
        let plates = [
            plate(&shape, 0.0, 0, false),
            plate(&shape, 2.0, 3, false),
            plate(&near, -1.0, 1, false),
            plate(&shape, 0.5, 0, true),
            plate(&shape[..3], 0.0, 0, false),
        ];
        let members = |tolerance| -> Vec<Vec<usize>> {
            congruent(&plates, tolerance)
                .into_iter()
                .map(|c| c.members)
                .collect()
        };
        assert_eq!(members(0.5), [vec![0, 1, 2], vec![3], vec![4]]);
        assert_eq!(members(0.01), [vec![0, 1], vec![2], vec![3], vec![4]]);
    }
}
