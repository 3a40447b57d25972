//! The brick wall as a pattern of the plane: rows of height 1, bricks of length 1, alternate rows
//! shifted by half.
//!
//! Brick `(row, half)` fills `[half / 2, half / 2 + 1] x [row, row + 1]`, `half + row` even. Its
//! corners are junctions `(half / 2, line)` of three bricks, whose third wall goes up if `half +
//! line` is even and down otherwise. The translations of the pattern are the pairs `(half, row)` of
//! half bricks and rows with an even sum.

/// A brick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Brick {
    /// Its row.
    pub row: i64,
    /// Its left end, in half bricks.
    pub half: i64,
}

/// A translation: half bricks along the rows, and rows.
pub(crate) type Translation = [i64; 2];

impl Brick {
    /// The brick that holds a point.
    pub(crate) fn containing([u, v]: [f64; 2]) -> Self {
        let row = v.floor() as i64;
        let odd = row.rem_euclid(2);
        let number = (u - 0.5 * odd as f64).floor() as i64;
        Self {
            row,
            half: 2 * number + odd,
        }
    }

    /// The brick translated.
    pub fn moved(self, [half, row]: Translation) -> Self {
        Self {
            row: self.row + row,
            half: self.half + half,
        }
    }

    /// Its middle.
    pub fn centre(self) -> [f64; 2] {
        [0.5 * self.half as f64 + 0.5, self.row as f64 + 0.5]
    }
}

/// Where three bricks meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Junction {
    /// In half bricks.
    pub half: i64,
    /// The line between the rows `line - 1` and `line`.
    pub line: i64,
}

impl Junction {
    /// The common corner of three bricks.
    pub fn of(bricks: [Brick; 3]) -> Option<Self> {
        let largest = |of: fn(&Brick) -> i64| bricks.iter().map(of).max();
        let least = |of: fn(&Brick) -> i64| bricks.iter().map(of).min();
        let (left, right) = (largest(|b| b.half)?, least(|b| b.half)? + 2);
        let (below, above) = (largest(|b| b.row)?, least(|b| b.row)? + 1);
        let distinct = bricks[0] != bricks[1] && bricks[1] != bricks[2] && bricks[0] != bricks[2];
        (distinct && left == right && below == above).then_some(Self {
            half: left,
            line: below,
        })
    }

    /// Its place with a kink: the share of half a row by which its line is bent towards the third
    /// wall.
    pub fn place(self, kink: f64) -> [f64; 2] {
        let up = if (self.half + self.line).rem_euclid(2) == 0 {
            1.0
        } else {
            -1.0
        };
        [0.5 * self.half as f64, self.line as f64 + up * 0.5 * kink]
    }
}

/// Share of the way from `a` to `b`, in two neighbouring bricks, at which the wall between them is
/// met.
pub(crate) fn wall_crossing([a, b]: [[f64; 2]; 2], [of_a, of_b]: [Brick; 2]) -> f64 {
    let t = if of_a.row == of_b.row {
        (0.5 * of_a.half.max(of_b.half) as f64 - a[0]) / (b[0] - a[0])
    } else {
        (of_a.row.max(of_b.row) as f64 - a[1]) / (b[1] - a[1])
    };
    // Walls of neighbouring edges must not fall together.
    if t.is_finite() {
        t.clamp(0.05, 0.95)
    } else {
        0.5
    }
}

/// How much a shear by one brick counts against a misfit of one row when periods are rounded:
/// closed rows are wanted.
const SHEAR: f64 = 3.0;

/// The translation of the pattern nearest to a vector.
pub(crate) fn nearest_translation([u, v]: [f64; 2]) -> Translation {
    let row = v.floor() as i64;
    let candidates = (row - 1..=row + 2).map(|row| {
        let odd = row.rem_euclid(2);
        let half = 2 * (u - 0.5 * odd as f64).round() as i64 + odd;
        let misfit = (SHEAR * (u - 0.5 * half as f64)).hypot(v - row as f64);
        (misfit, [half, row])
    });
    candidates
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or([0, 0], |c| c.1)
}

/// Rounds the periods of a surface's loops to translations, those of its shortest loops the most
/// exactly.
pub(crate) fn rounded_periods(periods: &[[f64; 2]]) -> Vec<Translation> {
    let mut short = periods.to_vec();
    let steps = shorten(&mut short);
    let mut rounded: Vec<Translation> = short.into_iter().map(nearest_translation).collect();
    for &(i, j, sign) in steps.iter().rev() {
        let other = rounded[j];
        rounded[i] = [
            rounded[i][0] - sign * other[0],
            rounded[i][1] - sign * other[1],
        ];
    }
    rounded
}

/// Adds vectors to each other while that shortens them; the steps `(i, j, sign)` mean `p_i += sign
/// p_j`.
fn shorten(vectors: &mut [[f64; 2]]) -> Vec<(usize, usize, i64)> {
    const MAX_STEPS: usize = 10_000;
    let square = |p: [f64; 2]| p[0] * p[0] + p[1] * p[1];
    let mut steps = Vec::new();
    while steps.len() < MAX_STEPS {
        let n = vectors.len();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let mut signed = pairs.flat_map(|(i, j)| [(i, j, 1), (i, j, -1)]);
        let sum = |i: usize, j: usize, sign: i64| {
            let s = sign as f64;
            [
                vectors[i][0] + s * vectors[j][0],
                vectors[i][1] + s * vectors[j][1],
            ]
        };
        let better = signed.find(|&(i, j, sign)| {
            i != j && square(sum(i, j, sign)) < (1.0 - 1e-6) * square(vectors[i])
        });
        let Some((i, j, sign)) = better else { break };
        vectors[i] = sum(i, j, sign);
        steps.push((i, j, sign));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn translations_map_bricks_to_bricks(
            u in -5.0..5.0f64, v in -5.0..5.0f64, n in -3i64..4, m in -3i64..4,
        ) {
            let translation = [n + 2 * m, n];
            let moved = Brick::containing([u + 0.5 * translation[0] as f64, v + n as f64]);
            let brick = Brick::containing([u, v]);
            // Points within rounding of a wall may fall to either side.
            let [x, y] = brick.centre();
            prop_assume!((u - x).abs() < 0.4999 && (v - y).abs() < 0.4999);
            prop_assert_eq!(moved, brick.moved(translation));
        }

        #[test]
        fn rounding_is_exact_on_translations_in_any_basis(
            a in -9i64..10, b in -9i64..10, c in 1i64..4, d in 1i64..30,
        ) {
            // Two loops whose periods are translations, the second wound round the first `c` times.
            let first = [2 * d + (b & 1), b];
            let second = [2 * a + c * first[0], 2 * d + c * first[1]];
            let periods = [first, second].map(|t| [0.5 * t[0] as f64, t[1] as f64]);
            prop_assert_eq!(rounded_periods(&periods), vec![first, second]);
        }
    }

    #[test]
    fn every_brick_has_six_junctions_and_walls_go_up_and_down() {
        let brick = Brick::containing([0.3, 0.2]);
        let right = Brick::containing([1.3, 0.2]);
        let above = Brick::containing([0.8, 1.2]);
        let junction = Junction::of([brick, right, above]).unwrap();
        assert_eq!(junction, Junction { half: 2, line: 1 });
        // Its third wall goes down, between the two lower bricks.
        assert_eq!(junction.place(0.5), [1.0, 0.75]);
        let left_above = Brick::containing([-0.2, 1.2]);
        let up = Junction::of([brick, above, left_above]).unwrap();
        assert_eq!(up.place(0.5), [0.5, 1.25]);
        assert_eq!(Junction::of([brick, brick, above]), None);
    }

    #[test]
    fn a_shear_costs_more_than_a_row() {
        assert_eq!(nearest_translation([0.05, 18.9]), [0, 18]);
        assert_eq!(nearest_translation([0.45, 18.9]), [1, 19]);
    }
}
