//! Summary of one figure over all elements.

use serde::Serialize;

/// How many of the worst elements a [`Metric`] names.
pub const WORST: usize = 10;
/// Number of bins of a [`Histogram`].
pub const BINS: usize = 20;

/// Summary of one value per element. Where there is no element, all figures are NaN (`null` in
/// JSON).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric<I> {
    /// Number of elements.
    pub count: usize,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Mean value.
    pub mean: f64,
    /// 5 % quantile, linear between neighbouring values.
    pub p05: f64,
    /// 95 % quantile, linear between neighbouring values.
    pub p95: f64,
    /// Number of elements by value.
    pub histogram: Histogram,
    /// The worst elements, the worst first, at most [`WORST`]; numbered from 0.
    pub worst: Vec<I>,
}

/// Counts of values in [`BINS`] bins of equal width.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Lower end of the first bin.
    pub low: f64,
    /// Upper end of the last bin.
    pub high: f64,
    /// Number of values in each bin; a value on a bin's upper end counts in the next, except in the
    /// last bin.
    pub counts: Vec<usize>,
}

impl<I: Copy> Metric<I> {
    /// Summary in which large values are bad.
    pub fn large_is_bad(values: impl IntoIterator<Item = (I, f64)>) -> Self {
        Self::new(values, |x| x)
    }

    /// Summary in which small values are bad.
    pub fn small_is_bad(values: impl IntoIterator<Item = (I, f64)>) -> Self {
        Self::new(values, |x| -x)
    }

    /// Summary in which the elements with the largest `badness(value)` are the worst; equal ones in
    /// the given order.
    pub fn new(values: impl IntoIterator<Item = (I, f64)>, badness: impl Fn(f64) -> f64) -> Self {
        let mut pairs: Vec<(I, f64)> = values.into_iter().collect();
        let mut sorted: Vec<f64> = pairs.iter().map(|p| p.1).collect();
        // Summed before sorting, and never in parallel: the same bits for any number of threads.
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        sorted.sort_by(f64::total_cmp);
        pairs.sort_by(|a, b| badness(b.1).total_cmp(&badness(a.1)));
        Self {
            count: sorted.len(),
            min: sorted.first().copied().unwrap_or(f64::NAN),
            max: sorted.last().copied().unwrap_or(f64::NAN),
            mean,
            p05: quantile(&sorted, 0.05),
            p95: quantile(&sorted, 0.95),
            histogram: Histogram::new(&sorted),
            worst: pairs.iter().take(WORST).map(|p| p.0).collect(),
        }
    }
}

impl Histogram {
    fn new(sorted: &[f64]) -> Self {
        let low = sorted.first().copied().unwrap_or(f64::NAN);
        let high = sorted.last().copied().unwrap_or(f64::NAN);
        let mut counts = vec![0; BINS];
        for x in sorted.iter().filter(|x| x.is_finite()) {
            // A cast from NaN (all values equal) gives bin 0.
            let bin = ((x - low) / (high - low) * BINS as f64) as usize;
            counts[bin.min(BINS - 1)] += 1;
        }
        Self { low, high, counts }
    }
}

/// Quantile `q` in [0, 1] of ascending values, linear between neighbours; NaN if there are none.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = q * last as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    sorted[low] + (sorted[high] - sorted[low]) * (place - low as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_of_known_values() {
        let metric = Metric::large_is_bad((0..=100).map(|i| (i, f64::from(100 - i))));
        assert_eq!(
            (metric.count, metric.min, metric.max, metric.mean),
            (101, 0.0, 100.0, 50.0)
        );
        assert_eq!((metric.p05, metric.p95), (5.0, 95.0));
        assert_eq!(metric.worst, (0..10).collect::<Vec<_>>());
        assert_eq!(metric.histogram.counts[..19], [5; 19]);
        assert_eq!(metric.histogram.counts[19], 6);
    }

    #[test]
    fn small_values_first_and_ties_in_order() {
        let metric = Metric::small_is_bad([(7, 2.0), (3, 1.0), (9, 1.0)]);
        assert_eq!(metric.worst, [3, 9, 7]);
    }

    #[test]
    fn quantiles_are_linear_between_values() {
        assert_eq!(quantile(&[1.0, 3.0], 0.25), 1.5);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn nothing_and_equal_values() {
        let nothing = Metric::<u32>::large_is_bad([]);
        assert!(nothing.count == 0 && nothing.mean.is_nan() && nothing.max.is_nan());
        assert_eq!(
            Metric::large_is_bad([(0, 2.0), (1, 2.0)]).histogram.counts[0],
            2
        );
    }
}
