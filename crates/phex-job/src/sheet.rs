//! Lengths of a workshop: plain numbers are millimetres.

use crate::units::{Quantity, Rectangle, Unit};
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use thiserror::Error;

/// Longest length of a workshop, millimetres: a kilometre, which nobody makes.
const LONGEST: f64 = 1e6;
/// Parts of a millimetre that are kept.
const DIGITS: f64 = 1e6;

/// A length of a workshop, such as the spacing of panels on a sheet: no percentage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkshopLength(Quantity);

impl WorkshopLength {
    /// The length in millimetres, without the digits that a change of units ends in.
    pub fn millimetres(self) -> f64 {
        (self.0.length(Unit::Mm, f64::NAN) * DIGITS).round() / DIGITS
    }
}

/// Why a length is none of a workshop.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NoWorkshopLength {
    /// It is a percentage, of which nobody could say of what.
    #[error("`{0}` is a percentage: give a length, 5 or 5mm, say")]
    Percentage(String),
    /// It is too long.
    #[error("`{0}` is no length of at most {LONGEST} mm")]
    TooLong(String),
    /// It is no length at all.
    #[error(transparent)]
    NoLength(#[from] crate::units::NoQuantity),
}

impl TryFrom<Quantity> for WorkshopLength {
    type Error = NoWorkshopLength;

    fn try_from(quantity: Quantity) -> Result<Self, NoWorkshopLength> {
        let length = Self(quantity);
        match length.millimetres() {
            mm if mm.is_nan() => Err(NoWorkshopLength::Percentage(quantity.to_string())),
            mm if mm > LONGEST => Err(NoWorkshopLength::TooLong(quantity.to_string())),
            _ => Ok(length),
        }
    }
}

impl FromStr for WorkshopLength {
    type Err = NoWorkshopLength;

    fn from_str(text: &str) -> Result<Self, NoWorkshopLength> {
        text.parse::<Quantity>()?.try_into()
    }
}

/// The sides of a sheet: `1250x2500`, `4x8ft`; in files also a list of two lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TypedSheet", into = "TypedSheet")]
pub struct SheetSize([Quantity; 2]);

/// A sheet as it is typed.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged, expecting = "a sheet such as `1250x2500` is expected")]
enum TypedSheet {
    Text(String),
    Sides([Quantity; 2]),
}

/// Why a text is no [`SheetSize`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NoSheet {
    /// It has no two sides.
    #[error("`{0}` is no sheet: give its sides, 1250x2500 in millimetres or 4x8ft")]
    NoSides(String),
    /// A side is no length of a workshop.
    #[error("side of a sheet: {0}")]
    Side(#[from] NoWorkshopLength),
}

impl SheetSize {
    /// The two lengths in millimetres, the longer first.
    pub fn millimetres(self) -> [f64; 2] {
        let [a, b] = self.0.map(|side| WorkshopLength(side).millimetres());
        [a.max(b), a.min(b)]
    }
}

impl Default for SheetSize {
    fn default() -> Self {
        Self([2500.0, 1250.0].map(Quantity::plain))
    }
}

impl TryFrom<[Quantity; 2]> for SheetSize {
    type Error = NoSheet;

    fn try_from(sides: [Quantity; 2]) -> Result<Self, NoSheet> {
        for side in sides {
            WorkshopLength::try_from(side)?;
        }
        match sides.iter().all(|side| side.value() > 0.0) {
            true => Ok(Self(sides)),
            false => Err(NoSheet::NoSides(sides.map(|s| s.to_string()).join("x"))),
        }
    }
}

impl FromStr for SheetSize {
    type Err = NoSheet;

    fn from_str(text: &str) -> Result<Self, NoSheet> {
        let sides = text.parse::<Rectangle>();
        let sides = sides.map_err(|_| NoSheet::NoSides(text.to_owned()))?;
        sides.typed().try_into()
    }
}

impl TryFrom<TypedSheet> for SheetSize {
    type Error = NoSheet;

    fn try_from(typed: TypedSheet) -> Result<Self, NoSheet> {
        match typed {
            TypedSheet::Text(text) => text.parse(),
            TypedSheet::Sides(sides) => sides.try_into(),
        }
    }
}

impl From<SheetSize> for TypedSheet {
    fn from(sheet: SheetSize) -> Self {
        Self::Sides(sheet.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_in_any_unit_and_order() {
        let size = |text: &str| text.parse::<SheetSize>().map(SheetSize::millimetres);
        assert_eq!(size("1250x2500").unwrap(), [2500.0, 1250.0]);
        assert_eq!(size("2.5mx1250mm").unwrap(), [2500.0, 1250.0]);
        assert_eq!(size("4000x8000mm").unwrap(), [8000.0, 4000.0]);
        assert_eq!(size("72inx144in").unwrap(), [3657.6, 1828.8]);
        for text in ["4ftx8ft", "4x8ft"] {
            assert_eq!(size(text).unwrap(), [2438.4, 1219.2], "{text}");
        }
        for text in ["1250", "ax2", "-1x2", "0x2", "nanx8000"] {
            let told = size(text).unwrap_err().to_string();
            assert!(told.contains("no sheet"), "{told}");
        }
        assert!(
            size("10%x2")
                .unwrap_err()
                .to_string()
                .contains("percentage")
        );
        assert!(
            size("1e300x1e300")
                .unwrap_err()
                .to_string()
                .contains("at most")
        );
        assert_eq!(SheetSize::default(), "2500x1250".parse().unwrap());
    }

    #[test]
    fn sheets_in_files_are_texts_or_two_lengths() {
        let read = |text: &str| serde_json::from_str::<SheetSize>(text);
        for text in ["\"4x8m\"", "[\"4m\", 8000]"] {
            assert_eq!(
                read(text).unwrap().millimetres(),
                [8000.0, 4000.0],
                "{text}"
            );
        }
        assert_eq!(
            serde_json::to_string(&read("\"4x8m\"").unwrap()).unwrap(),
            r#"["4m","8m"]"#
        );
        let told = |text: &str| read(text).unwrap_err().to_string();
        assert!(told("[\"10%\", \"8000\"]").contains("`10%` is a percentage"));
        assert!(told("[0, 8000]").contains("`0x8000` is no sheet"));
        assert!(told("[1, 2, 3]").contains("`1250x2500` is expected"));
    }

    #[test]
    fn lengths_of_a_workshop_are_no_percentages() {
        let length = |text: &str| {
            text.parse::<WorkshopLength>()
                .map(WorkshopLength::millimetres)
        };
        assert_eq!((length("5"), length("2cm")), (Ok(5.0), Ok(20.0)));
        let told = |text: &str| length(text).unwrap_err().to_string();
        assert!(told("10%").contains("`10%` is a percentage"));
        assert!(told("2000m").contains("at most 1000000 mm") && told("x").contains("no length"));
    }
}
