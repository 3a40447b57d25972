//! Lengths as they are typed: a number with a unit, a percentage, or a plain number.

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;
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
    /// All of them, `m` last: it also ends `mm` and `cm`.
    const ALL: [Self; 5] = [Self::Mm, Self::Cm, Self::In, Self::Ft, Self::M];

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

/// Largest and least diagonal of what panels are made for, in metres.
const MODELS: [f64; 2] = [0.01, 2000.0];
/// The same of what is usual.
const USUAL: [f64; 2] = [1.0, 500.0];
/// Squared and cubic metres from which areas and volumes of small units are told in them.
const IN_METRES: f64 = 1e-3;

impl Unit {
    /// An area in this unit as it is told: four digits, in square metres where that reads better.
    pub fn told_area(self, area: f64) -> String {
        self.told(area, 2)
    }

    /// The same of a volume.
    pub fn told_volume(self, volume: f64) -> String {
        self.told(volume, 3)
    }

    fn told(self, value: f64, power: i32) -> String {
        let metres = value * self.metres().powi(power);
        let is_small = matches!(self, Self::Mm | Self::Cm);
        match is_small && metres >= IN_METRES {
            true => format!("{} m{power}", four_digits(metres)),
            false => format!("{} {self}{power}", four_digits(value)),
        }
    }

    /// What is said of a model whose size in this unit is no building's: most often the unit is
    /// another one.
    pub fn doubted(self, diagonal: f64) -> Option<String> {
        let within = |[low, high]: [f64; 2], length: f64| length >= low && length <= high;
        let metres = diagonal * self.metres();
        if metres == 0.0 || within(MODELS, metres) {
            return None;
        }
        let mut others = [Self::Mm, Self::M].into_iter();
        let other = others.find(|unit| within(USUAL, diagonal * unit.metres()));
        let instead = other.map_or(String::new(), |unit| {
            let metres = four_digits(diagonal * unit.metres());
            format!(" (with --unit {unit} it is {metres} m)")
        });
        Some(format!(
            "the model is {} m across: is its unit right?{instead}",
            four_digits(metres)
        ))
    }
}

/// A number with four digits that mean something.
pub fn four_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e12).contains(&size) {
        return format!("{value:.3e}");
    }
    let power = size.log10().floor() as i32 - 3;
    if power >= 0 {
        let step = 10f64.powi(power);
        return format!("{}", (value / step).round() * step);
    }
    let text = format!("{value:.*}", -power as usize);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
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
    /// A plain number.
    pub(crate) const fn plain(value: f64) -> Self {
        Self {
            value,
            suffix: Suffix::Plain,
        }
    }

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
        let endings = Unit::ALL.map(|u| (u.name(), Suffix::Unit(u)));
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

/// Sides of a rectangle: two lengths with an `x` between them, `1.5x3.0m`; a unit after the second
/// alone is that of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle([Quantity; 2]);

/// Why a text is no [`Rectangle`] or [`Area`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{text}` is no {what}")]
pub struct NoSize {
    text: String,
    what: &'static str,
}

impl Rectangle {
    /// Both sides as they are typed.
    pub(crate) fn typed(self) -> [Quantity; 2] {
        self.0
    }

    /// Both sides in model units.
    pub fn sides(self, model_unit: Unit, whole: f64) -> [f64; 2] {
        self.0.map(|q| q.length(model_unit, whole))
    }
}

impl FromStr for Rectangle {
    type Err = NoSize;

    fn from_str(text: &str) -> Result<Self, NoSize> {
        let none = || NoSize {
            text: text.to_owned(),
            what: "rectangle: give its sides as 1.5x3.0m",
        };
        let (a, b) = text.split_once(['x', 'X', '×']).ok_or_else(none)?;
        let side = |text: &str| text.parse::<Quantity>().map_err(|_| none());
        let (a, b) = (side(a)?, side(b)?);
        let suffix = if a.is_plain() { b.suffix } else { a.suffix };
        let sides = [Quantity { suffix, ..a }, b];
        match sides.iter().all(|q| q.value > 0.0) {
            true => Ok(Self(sides)),
            false => Err(none()),
        }
    }
}

impl fmt::Display for Rectangle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.0;
        match a.suffix == b.suffix {
            true => write!(
                f,
                "{}x{b}",
                Quantity {
                    suffix: Suffix::Plain,
                    ..a
                }
            ),
            false => write!(f, "{a}x{b}"),
        }
    }
}

/// A positive area: `2.5m2`, or a number of squared model units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    value: f64,
    unit: Option<Unit>,
}

impl Area {
    /// The area in squared model units.
    pub fn area(self, model_unit: Unit) -> f64 {
        self.value * self.side(model_unit).1.powi(2)
    }

    /// The unit of length that it was typed in, and its length in model units.
    pub fn side(self, model_unit: Unit) -> (&'static str, f64) {
        let unit = self.unit.unwrap_or(model_unit);
        (unit.name(), unit.metres() / model_unit.metres())
    }
}

impl FromStr for Area {
    type Err = NoSize;

    fn from_str(text: &str) -> Result<Self, NoSize> {
        let none = || NoSize {
            text: text.to_owned(),
            what: "area: give a positive number, with mm2, cm2, m2, in2, ft2 or nothing after it",
        };
        let squared = text.trim().strip_suffix(['2', '²']);
        let length: Quantity = match squared {
            // The 2 is part of a number where no unit stands before it, as in 1e2.
            Some(length) if Unit::ALL.iter().any(|u| length.ends_with(u.name())) => length,
            _ => text,
        }
        .parse()
        .map_err(|_| none())?;
        match (length.value > 0.0, length.suffix) {
            (true, Suffix::Plain) => Ok(Self {
                value: length.value,
                unit: None,
            }),
            (true, Suffix::Unit(unit)) if squared.is_some() => Ok(Self {
                value: length.value,
                unit: Some(unit),
            }),
            _ => Err(none()),
        }
    }
}

impl fmt::Display for Area {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let suffix = Suffix::Plain;
        let value = self.value;
        write!(f, "{}", Quantity { value, suffix })?;
        self.unit.map_or(Ok(()), |unit| write!(f, "{unit}2"))
    }
}

/// A value that is typed as a text, which in a file may be a number, too.
trait Typed: FromStr<Err: fmt::Display> {
    /// What is expected, for messages.
    const EXPECTED: &str;
}

impl Typed for Quantity {
    const EXPECTED: &str = "a length such as `5mm` or `0.2%`";
}

impl Typed for Rectangle {
    const EXPECTED: &str = "a rectangle such as `1.5x3.0m`";
}

impl Typed for Area {
    const EXPECTED: &str = "an area such as `2.5m2`";
}

/// Reads such a value.
struct TypedVisitor<T>(PhantomData<T>);

impl<T: Typed> Visitor<'_> for TypedVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(T::EXPECTED)
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<T, E> {
        self.visit_str(&number.to_string())
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<T, E> {
        text.parse().map_err(E::custom)
    }
}

/// Values that are written in files as they are typed.
macro_rules! written_as_typed {
    ($($name:ty),*) => {$(
        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(TypedVisitor(PhantomData))
            }
        }
    )*};
}

written_as_typed!(Quantity, Rectangle, Area);

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

    #[test]
    fn areas_and_volumes_are_told_with_four_digits() {
        assert_eq!(Unit::Mm.told_area(967_476_771.696_228_4), "967.5 m2");
        assert_eq!(Unit::Mm.told_area(12.345_6), "12.35 mm2");
        assert_eq!(Unit::M.told_area(0.123_456), "0.1235 m2");
        assert_eq!(Unit::M.told_area(967_476_771.696), "967500000 m2");
        assert_eq!(Unit::Ft.told_area(1234.56), "1235 ft2");
        assert_eq!(Unit::Mm.told_volume(193_680_212_570.943), "193.7 m3");
        assert_eq!(four_digits(-0.000_02), "-2.000e-5");
        assert_eq!(four_digits(10.0), "10");
    }

    #[test]
    fn a_unit_in_which_no_building_is_built_is_doubted() {
        let told = Unit::M.doubted(47_376.0).unwrap();
        assert!(told.contains("47380 m across"), "{told}");
        assert!(told.contains("--unit mm it is 47.38 m"), "{told}");
        assert!(
            Unit::Mm
                .doubted(5.0)
                .unwrap()
                .contains("--unit m it is 5 m")
        );
        for (unit, size) in [(Unit::M, 47.0), (Unit::Mm, 47_376.0), (Unit::M, 0.0)] {
            assert_eq!(unit.doubted(size), None);
        }
    }

    #[test]
    fn rectangles_and_areas_are_read_and_written() {
        let sides = |text: &str| text.parse::<Rectangle>().map(|r| r.sides(Unit::Mm, 200.0));
        assert_eq!(sides("1.5x3.0m"), Ok([1500.0, 3000.0]));
        assert_eq!(sides("50cm × 2m"), Ok([500.0, 2000.0]));
        assert_eq!(sides("1500x3000"), Ok([1500.0, 3000.0]));
        assert_eq!(sides("1x5%"), Ok([2.0, 10.0]));
        for text in ["1.5", "1x", "x", "0x3m", "1x-3m", "1xnanm", "1x2x3m"] {
            assert!(sides(text).is_err(), "{text}");
        }
        let area = |text: &str| text.parse::<Area>().map(|a| a.area(Unit::Mm));
        assert_eq!(area("2.5m2"), Ok(2.5e6));
        assert_eq!(area("2m²"), Ok(2e6));
        assert_eq!(area("12"), Ok(12.0));
        assert_eq!(area("1e2"), Ok(100.0));
        assert_eq!(area("10e2in2"), Ok(1000.0 * 25.4 * 25.4));
        for text in ["2m", "5%", "0", "-1m2", "m2", "nan", "2%2"] {
            assert!(area(text).is_err(), "{text}");
        }
        for text in ["1.5x3m", "50cmx2m", "1500x3000"] {
            assert_eq!(text.parse::<Rectangle>().unwrap().to_string(), text);
        }
        for text in ["2.5m2", "12", "3e300"] {
            assert_eq!(text.parse::<Area>().unwrap().to_string(), text);
        }
    }
}
