//! From values to colours, ticks and histograms.

use serde::Serialize;

/// Red, green and blue, sRGB.
pub type Rgb = [u8; 3];

/// Bins of a histogram of a continuous map.
const BINS: usize = 28;
/// Colour of elements without a value.
const NO_VALUE: Rgb = [0xC8, 0xC8, 0xCA];

/// A class of elements that share a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Class {
    /// Name in the legend.
    pub label: &'static str,
    /// Colour.
    pub colour: Rgb,
}

/// A range of values with colours along it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Continuous {
    /// Value of the first colour.
    pub low: f64,
    /// Value of the last colour.
    pub high: f64,
    /// Whether colours follow the logarithm of the value.
    pub logarithmic: bool,
    /// Colours at equal distances.
    pub ramp: &'static [Rgb],
    /// The largest value that is accepted, if there is such a limit.
    pub limit: Option<f64>,
    /// Values closer to 0 than the first number have the colour that follows.
    pub band: Option<(f64, Rgb)>,
    /// The value of the colour in the middle, where that says something by itself.
    #[serde(skip)]
    pub middle: Option<f64>,
}

/// From which value to which colours go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Range {
    /// Over the mesh's own values, with round ends; a ratio that lies between -1 and 1 by its
    /// nature keeps to that.
    #[default]
    Automatic,
    /// The same for every mesh.
    Fixed,
    /// From the first number to the second, which is larger, in the unit of the values.
    Given([f64; 2]),
}

impl Continuous {
    /// The same colours over another range of `values`.
    pub(super) fn over(self, range: Range, values: &[f64]) -> Self {
        let ends = match range {
            Range::Fixed => None,
            Range::Given(ends) => Some(ends),
            Range::Automatic => self.ends_of(values),
        };
        let [low, high] = ends.unwrap_or([self.low, self.high]);
        Self { low, high, ..self }
    }

    /// Round ends of the range of values; nothing if the fixed range is that already, or no value
    /// has a place.
    fn ends_of(&self, values: &[f64]) -> Option<[f64; 2]> {
        let placed = |v: &f64| v.is_finite() && (!self.logarithmic || *v > 0.0);
        let values = || values.iter().copied().filter(placed);
        let (least, most) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
        match (self.middle, self.logarithmic) {
            _ if self.band.is_some() => None,
            (Some(middle), true) => {
                let factor = (most / middle).max(middle / least).max(LEAST_FACTOR);
                // A factor near 1 is read by what it is over 1.
                let times = 1.0 + rounded_up(factor - 1.0);
                Some([middle / times, middle * times])
            }
            (Some(middle), false) => {
                let off = rounded_up((most - middle).max(middle - least).max(LEAST_OFF));
                Some([middle - off, middle + off])
            }
            (None, true) => {
                let first = least.log10().floor() as i32;
                let last = (most.log10().ceil() as i32).max(first + 1);
                Some([first, last].map(|n| 10_f64.powi(n)))
            }
            (None, false) => {
                let low = self.low;
                (most > low).then(|| [low, low + rounded_up(most - low)])
            }
        }
    }

    /// Place of a value along the colours, 0 to 1; values outside of the range are moved to its
    /// ends.
    pub fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.low, self.high);
        let t = if self.logarithmic {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        };
        // The logarithm of 0 is minus infinity; that of a negative number has no place and counts
        // as the lowest.
        if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }
    }

    /// The value at a place from 0 to 1.
    pub fn at(&self, place: f64) -> f64 {
        if self.logarithmic {
            self.low * (self.high / self.low).powf(place)
        } else {
            self.low + (self.high - self.low) * place
        }
    }

    fn colour(&self, value: f64) -> Rgb {
        if let Some((width, colour)) = self.band
            && value.abs() < width
        {
            return colour;
        }
        self.colour_at(self.place(value))
    }

    /// Colour at a place from 0 to 1.
    pub fn colour_at(&self, place: f64) -> Rgb {
        let x = place * (self.ramp.len() - 1) as f64;
        let first = (x as usize).min(self.ramp.len() - 2);
        let (a, b, t) = (self.ramp[first], self.ramp[first + 1], x - first as f64);
        let mix = |k: usize| f64::from(a[k]) + (f64::from(b[k]) - f64::from(a[k])) * t;
        [0, 1, 2].map(|k| mix(k).round() as u8)
    }

    /// Marks along the legend: places and labels.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let places = match self.decades() {
            Some(n) => {
                let step = n.div_ceil(4);
                let inner = (0..n).step_by(step).map(|k| k as f64 / n as f64);
                inner.chain([1.0]).collect()
            }
            None => vec![0.0, 0.25, 0.5, 0.75, 1.0],
        };
        let mark = |t| (t, label(self.at(t)));
        places.into_iter().map(mark).collect()
    }

    /// The number of powers of ten that the range spans, if it is a whole one.
    fn decades(&self) -> Option<usize> {
        let n = (self.high / self.low).log10();
        let whole = self.logarithmic && n > 0.5 && (n - n.round()).abs() < 1e-6;
        whole.then(|| n.round() as usize)
    }
}

/// The factor about the mean edge, and the degrees about a straight angle, below which colours
/// would show rounding alone.
const LEAST_FACTOR: f64 = 1.05;
const LEAST_OFF: f64 = 0.1;

/// A positive number rounded up to one that is read easily: one of 1, 1.2, 1.5, 2, 3, 4, 5, 6 and 8
/// times a power of ten.
fn rounded_up(x: f64) -> f64 {
    const ROUND: [f64; 10] = [1.0, 1.2, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let power = 10_f64.powf(x.log10().floor());
    // What is round already must not be rounded up for its last bit.
    let fits = |m: &&f64| **m * power >= x * (1.0 - 1e-9);
    ROUND.iter().find(fits).unwrap_or(&10.0) * power
}

/// A value of the legend: few digits, powers of ten for very small ones.
pub fn label(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else if value.abs() < 1e-3 {
        format!("{value:.0e}")
    } else {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

/// How values become colours.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ColourScale {
    /// Along a range.
    Continuous(Continuous),
    /// By class; values are the classes' numbers from 0.
    Classes(Vec<Class>),
}

/// Number of elements by value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ValueCounts {
    /// Elements in each class, or in bins of equal width along the legend; the first and last bin
    /// hold what is outside.
    pub counts: Vec<usize>,
    /// Elements below the range.
    pub below: usize,
    /// Elements above the range.
    pub above: usize,
}

impl ColourScale {
    /// Colour of a value.
    pub fn colour(&self, value: f64) -> Rgb {
        match self {
            _ if value.is_nan() => NO_VALUE,
            Self::Continuous(c) => c.colour(value),
            Self::Classes(classes) => {
                let class = classes.get(value as usize);
                class.map_or(NO_VALUE, |c| c.colour)
            }
        }
    }

    /// Counts values; those that are NaN are left out.
    pub fn histogram(&self, values: &[f64]) -> ValueCounts {
        let values = || values.iter().copied().filter(|v| !v.is_nan());
        let bins = match self {
            Self::Continuous(_) => BINS,
            Self::Classes(classes) => classes.len(),
        };
        let mut counts = vec![0; bins];
        for value in values() {
            counts[self.bin(value).min(bins - 1)] += 1;
        }
        let outside = |is: fn(f64, &Continuous) -> bool| match self {
            Self::Continuous(c) => values().filter(|&v| is(v, c)).count(),
            Self::Classes(_) => 0,
        };
        ValueCounts {
            counts,
            below: outside(|v, c| v < c.low),
            above: outside(|v, c| v > c.high),
        }
    }

    fn bin(&self, value: f64) -> usize {
        match self {
            Self::Continuous(c) => (c.place(value) * BINS as f64) as usize,
            Self::Classes(_) => value as usize,
        }
    }
}
