//! What the user asks for.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Largest order of rotation that can be asked for.
const MOST_TURNS: u32 = 1000;

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "Typed")]
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

/// What a file may say: a word, or a number without quotes.
#[derive(Deserialize)]
#[serde(untagged)]
enum Typed {
    Number(u32),
    Word(String),
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
        number.map(Self::Turns).ok_or_else(|| {
            format!(
                "symmetry is `auto`, `none`, `mirror` or the order of a rotation from 2 to {MOST_TURNS}"
            )
        })
    }
}

impl TryFrom<Typed> for Symmetry {
    type Error = String;

    fn try_from(typed: Typed) -> Result<Self, String> {
        match typed {
            Typed::Number(n) => n.to_string().parse(),
            Typed::Word(word) => word.parse(),
        }
    }
}
