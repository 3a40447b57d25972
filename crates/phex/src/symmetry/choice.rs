//! What the user asks for.

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::str::FromStr;

/// Largest order of rotation that can be asked for.
pub(super) const MOST_TURNS: u32 = 1000;

/// Which symmetries of a surface its panels have: `auto`, `none`, `mirror` or the order of a
/// rotation, in text as in job files.
///
/// ```
/// use phex::symmetry::Symmetry;
///
/// assert_eq!("6".parse(), Ok(Symmetry::Turns(6)));
/// assert_eq!(Symmetry::Mirror.to_string(), "mirror");
/// assert!("1".parse::<Symmetry>().is_err());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum Symmetry {
    /// All that are found and can be used.
    Auto,
    /// None.
    #[default]
    None,
    /// One mirror plane.
    Mirror,
    /// Rotations by a turn over this number, at least 2, with the mirror planes through their axis.
    Turns(u32),
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::None => f.write_str("none"),
            Self::Mirror => f.write_str("mirror"),
            Self::Turns(n) => write!(f, "{n}"),
        }
    }
}

impl From<Symmetry> for String {
    fn from(symmetry: Symmetry) -> Self {
        symmetry.to_string()
    }
}

impl FromStr for Symmetry {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(Self::Auto),
            "none" => return Ok(Self::None),
            "mirror" => return Ok(Self::Mirror),
            _ => {}
        }
        let number = text.parse().ok().filter(|n| (2..=MOST_TURNS).contains(n));
        number
            .map(Self::Turns)
            .ok_or_else(|| format!("symmetry is {}", choices()))
    }
}

fn choices() -> String {
    format!("`auto`, `none`, `mirror` or the order of a rotation from 2 to {MOST_TURNS}")
}

impl<'de> Deserialize<'de> for Symmetry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SymmetryVisitor)
    }
}

/// Reads what a file may say: a word, or a number without quotes.
struct SymmetryVisitor;

impl Visitor<'_> for SymmetryVisitor {
    type Value = Symmetry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&choices())
    }

    fn visit_i64<E: de::Error>(self, order: i64) -> Result<Symmetry, E> {
        self.visit_str(&order.to_string())
    }

    fn visit_u64<E: de::Error>(self, order: u64) -> Result<Symmetry, E> {
        self.visit_str(&order.to_string())
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Symmetry, E> {
        text.parse().map_err(E::custom)
    }
}
