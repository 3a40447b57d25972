//! A check in words: its figures in the unit in which they are read, and its place.

use super::check::{Check, Reading, Scale};

/// Digits of the largest coordinate of a place, and decimals that each has at the least.
const PLACE_DIGITS: i32 = 6;
const PLACE_DECIMALS: i32 = 2;

impl Check {
    /// Limit and figure as they are read: as the limit was typed, or in the unit of their scale.
    pub fn shown(&self) -> Reading {
        let whole = self.scale.unit();
        if let Some(reading) = &self.reading {
            let unit = match (reading.unit.as_str(), self.scale) {
                ("%", Scale::MeanEdges) => "% of the mean edge".to_owned(),
                ("%", _) => format!("% {whole}").trim_end().to_owned(),
                (unit, _) => unit.to_owned(),
            };
            return Reading {
                unit,
                ..reading.clone()
            };
        }
        let (factor, unit) = match self.scale {
            Scale::Diagonals | Scale::Area => (100.0, format!("% {whole}")),
            _ => (1.0, whole.to_owned()),
        };
        Reading {
            unit,
            limit: factor * self.limit,
            value: factor * self.value,
            across: None,
        }
    }
}

/// A place as `(x, y, z)`, with as many decimals as it needs to be found.
pub fn told_place(place: [f64; 3]) -> String {
    let [x, y, z] = coordinates(place);
    format!("({x}, {y}, {z})")
}

impl Reading {
    /// Figure and limit in words, with `figure` for each number: those of a sheet have two sides.
    pub fn in_words(&self, figure: impl Fn(f64) -> String) -> [String; 2] {
        let [value, limit] = [self.value, self.limit].map(&figure);
        match self.across.map(|sides| sides.map(&figure)) {
            Some([limit_across, value_across]) => [
                format!("{value} x {value_across}"),
                format!("{limit} x {limit_across}"),
            ],
            None => [value, limit],
        }
    }
}

impl Scale {
    /// The unit in words; empty for numbers without one.
    fn unit(self) -> &'static str {
        match self {
            Self::Count | Self::Ratio => "",
            Self::MeanEdges => "mean edges",
            Self::Diagonals => "of the diagonal",
            Self::Area => "of the area",
            Self::Length | Self::SquareLength => "in model units",
            Self::Degrees => "degrees",
        }
    }
}

/// The coordinates of a place, all to the same decimals, so that it can be found on any model.
fn coordinates(place: [f64; 3]) -> [String; 3] {
    let largest = place.iter().fold(f64::MIN_POSITIVE, |l, x| x.abs().max(l));
    let decimals = (PLACE_DIGITS - 1 - largest.log10().floor() as i32).max(PLACE_DECIMALS);
    place.map(|x| {
        let text = format!("{x:.*}", decimals as usize);
        let text = text.trim_end_matches('0').trim_end_matches('.');
        text.strip_prefix('-')
            .filter(|t| *t == "0")
            .unwrap_or(text)
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_can_be_found_at_every_size() {
        let cases = [
            (
                [456_859.129, 5_400_123.75, 518.0],
                ["456859.13", "5400123.75", "518"],
            ),
            ([0.070_287_3, -2.5, -4.5e-9], ["0.07029", "-2.5", "0"]),
            ([3e-7, 0.0, 0.0], ["0.0000003", "0", "0"]),
        ];
        for (place, expected) in cases {
            assert_eq!(coordinates(place), expected);
        }
    }

    #[test]
    fn figures_are_shown_as_the_limit_was_typed() {
        let check = Check::new("deviation", [0.005, 0.01], Scale::Diagonals, false);
        let shown = check.shown();
        assert_eq!(
            (shown.unit.as_str(), shown.limit, shown.value),
            ("% of the diagonal", 0.5, 1.0)
        );
        let reading = Some(Reading {
            unit: "m".to_owned(),
            limit: 2.0,
            value: 3.0,
            across: Some([4.0, 6.0]),
        });
        let shown = Check { reading, ..check }.shown();
        assert_eq!(shown.in_words(|x| x.to_string()), ["3 x 6", "2 x 4"]);
        assert_eq!(shown.unit, "m");
    }
}
