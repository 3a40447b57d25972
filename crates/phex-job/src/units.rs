//! Lengths as they are typed: a number with a unit, a percentage, or a plain number.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    #[default]
    M,
    /// Inch.
    In,
    /// Foot.
    Ft,
}

impl Unit {
    /// Length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Mm => 1e-3,
            Self::Cm => 1e-2,
            Self::M => 1.0,
            Self::In => 0.0254,
            Self::Ft => 0.3048,
        }
    }

    /// Name as it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::In => "in",
            Self::Ft => "ft",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What follows the number of a [`Quantity`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Suffix {
    Plain,
    Unit(Unit),
    Percent,
}

/// A non-negative number with a unit (`20mm`), a percent sign (`0.5%`) or neither.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    value: f64,
    suffix: Suffix,
}

/// Why a text is no [`Quantity`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "`{text}` is no length: give a number that is not negative, with mm, cm, m, in, ft, % or nothing after it"
)]
pub struct NoQuantity {
    text: String,
}

impl Quantity {
    /// A percentage.
    pub const fn percent(value: f64) -> Self {
        Self {
            value,
            suffix: Suffix::Percent,
        }
    }

    /// The length in model units: a plain number is one already, a percentage refers to `whole`.
    pub fn length(self, model_unit: Unit, whole: f64) -> f64 {
        match self.suffix {
            Suffix::Plain => self.value,
            Suffix::Unit(unit) => self.value * unit.metres() / model_unit.metres(),
            Suffix::Percent => self.value / 100.0 * whole,
        }
    }

    /// The unit it was typed in, and the length of that unit in model units: a plain number has the
    /// model's, and 100 % is `whole`.
    pub fn unit(self, model_unit: Unit, whole: f64) -> (&'static str, f64) {
        match self.suffix {
            Suffix::Plain => (model_unit.name(), 1.0),
            Suffix::Unit(unit) => (unit.name(), unit.metres() / model_unit.metres()),
            Suffix::Percent => ("%", 0.01 * whole),
        }
    }

    /// Whether it was typed without a unit.
    pub fn is_plain(self) -> bool {
        self.suffix == Suffix::Plain
    }

    /// The number that was typed.
    pub fn value(self) -> f64 {
        self.value
    }

    /// The length over `whole`: a plain number is one already.
    pub fn fraction(self, model_unit: Unit, whole: f64) -> f64 {
        match self.suffix {
            Suffix::Plain => self.value,
            Suffix::Unit(_) => self.length(model_unit, whole) / whole,
            Suffix::Percent => self.value / 100.0,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Zeros without end tell nobody anything.
        match self.value {
            0.0 | 1e-9..1e12 => write!(f, "{}", self.value)?,
            value => write!(f, "{value:e}")?,
        }
        match self.suffix {
            Suffix::Plain => Ok(()),
            Suffix::Unit(unit) => write!(f, "{unit}"),
            Suffix::Percent => f.write_str("%"),
        }
    }
}

impl FromStr for Quantity {
    type Err = NoQuantity;

    fn from_str(text: &str) -> Result<Self, NoQuantity> {
        let text = text.trim();
        // `m` last: it also ends `mm` and `cm`.
        let endings =
            [Unit::Mm, Unit::Cm, Unit::In, Unit::Ft, Unit::M].map(|u| (u.name(), Suffix::Unit(u)));
        let (number, suffix) = endings
            .into_iter()
            .chain([("%", Suffix::Percent)])
            .find_map(|(ending, suffix)| Some((text.strip_suffix(ending)?, suffix)))
            .unwrap_or((text, Suffix::Plain));
        match number.trim_end().parse::<f64>() {
            Ok(value) if value.is_finite() && value >= 0.0 => Ok(Self { value, suffix }),
            _ => Err(NoQuantity {
                text: text.to_owned(),
            }),
        }
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Integer(i64),
            Number(f64),
            Text(String),
        }
        let text = match Written::deserialize(deserializer)? {
            Written::Integer(number) => number.to_string(),
            Written::Number(number) => number.to_string(),
            Written::Text(text) => text,
        };
        text.parse().map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(text: &str) -> Quantity {
        text.parse().unwrap()
    }

    #[test]
    fn units_are_converted_to_the_model_s() {
        assert_eq!(quantity("20mm").length(Unit::M, 50.0), 0.02);
        assert_eq!(quantity("1.2 m").length(Unit::Mm, 1.0), 1200.0);
        assert!((quantity("1ft").length(Unit::In, 1.0) - 12.0).abs() < 1e-12);
        assert_eq!(quantity("3cm").length(Unit::M, 1.0), 0.03);
        assert_eq!(quantity("7").length(Unit::Mm, 1.0), 7.0);
        assert_eq!(quantity("0.5%").length(Unit::Mm, 200.0), 1.0);
    }

    #[test]
    fn fractions_keep_plain_numbers() {
        assert_eq!(quantity("1e-9").fraction(Unit::M, 3.0), 1e-9);
        assert_eq!(quantity("1%").fraction(Unit::M, 3.0), 0.01);
        assert_eq!(quantity("1mm").fraction(Unit::M, 0.5), 0.002);
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "m", "-1mm", "nan", "inf", "1 km", "1e400", "1mm2", "%"] {
            assert!(text.parse::<Quantity>().is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        for text in ["20mm", "0.5%", "1.25", "3ft", "1e-12", "1e300m", "0"] {
            assert_eq!(quantity(text).to_string(), text);
        }
    }
}
