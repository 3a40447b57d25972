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
}

impl Continuous {
    /// Place of a value along the colours, 0 to 1; values outside of the range are moved to its ends.
    pub fn place(&self, value: f64) -> f64 {
        let (low, high) = (self.low, self.high);
        let t = if self.logarithmic {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        };
        // The logarithm of 0 is minus infinity; that of a negative number has no place and counts as the lowest.
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
        let places: &[f64] = if self.band.is_some() || !self.is_decades() {
            &[0.0, 0.25, 0.5, 0.75, 1.0]
        } else {
            &[0.0, 3.0 / 11.0, 6.0 / 11.0, 9.0 / 11.0, 1.0]
        };
        let places = places.iter();
        places.map(|&t| (t, label(self.at(t)))).collect()
    }

    fn is_decades(&self) -> bool {
        self.logarithmic && self.high / self.low > 1e3
    }
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
pub enum Scale {
    /// Along a range.
    Continuous(Continuous),
    /// By class; values are the classes' numbers from 0.
    Classes(Vec<Class>),
}

/// Number of elements by value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Histogram {
    /// Elements in each class, or in bins of equal width along the legend; the first and last bin hold what is outside.
    pub counts: Vec<usize>,
    /// Elements below the range.
    pub below: usize,
    /// Elements above the range.
    pub above: usize,
}

impl Scale {
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
    pub fn histogram(&self, values: &[f64]) -> Histogram {
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
        Histogram {
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
