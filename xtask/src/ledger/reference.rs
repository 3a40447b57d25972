//! The computation that CPU times are measured against: conjugate gradients on a grid, about as
//! much memory traffic per operation as the program has. It never changes, so that ratios of
//! different days can be compared.

/// Side of the grid, points.
const SIDE: usize = 400;
/// Steps of conjugate gradients.
const STEPS: usize = 400;

/// Runs it, and returns a number that depends on all of it.
pub fn run() -> f64 {
    let mut x = vec![0.0; SIDE * SIDE];
    let mut r: Vec<f64> = (0..SIDE * SIDE).map(|i| (i as f64).sin()).collect();
    let mut p = r.clone();
    let mut square = dot(&r, &r);
    for _ in 0..STEPS {
        let q = laplacian(&p);
        let step = square / dot(&p, &q);
        for i in 0..x.len() {
            x[i] += step * p[i];
            r[i] -= step * q[i];
        }
        let next = dot(&r, &r);
        for i in 0..p.len() {
            p[i] = r[i] + next / square * p[i];
        }
        square = next;
    }
    x.iter().sum()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The five-point Laplacian with a unit of mass, positive definite.
fn laplacian(p: &[f64]) -> Vec<f64> {
    let at = |i: usize, j: usize| match i < SIDE && j < SIDE {
        true => p[i * SIDE + j],
        false => 0.0,
    };
    let one = |k: usize| {
        let (i, j) = (k / SIDE, k % SIDE);
        let around =
            at(i.wrapping_sub(1), j) + at(i + 1, j) + at(i, j.wrapping_sub(1)) + at(i, j + 1);
        4.001 * p[k] - around
    };
    (0..p.len()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laplacian_is_symmetric_and_the_run_always_the_same() {
        let wave = |k: f64| {
            (0..SIDE * SIDE)
                .map(|i| (k * i as f64).sin())
                .collect::<Vec<_>>()
        };
        let (a, b) = (wave(0.3), wave(1.7));
        let (left, right) = (dot(&a, &laplacian(&b)), dot(&laplacian(&a), &b));
        assert!((left - right).abs() < 1e-8 * dot(&a, &a));
        assert_eq!(run().to_bits(), run().to_bits());
    }
}
