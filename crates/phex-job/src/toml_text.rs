//! The text of a job file, or of a study file.

use crate::error::JobError;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use std::fmt;
use std::marker::PhantomData;

/// Bytes of such a text at the most. The library takes up to 101 bytes of memory for each, where
/// every token is one byte long, so no text takes more than about 110 MB.
pub const LONGEST_TOML: usize = 1 << 20;
/// Characters of the parser's message that are shown: it quotes names and values of any length.
const SHOWN: usize = 1000;

/// What the text of a job file or a study file says.
///
/// ```
/// use phex_job::{MeshSettings, from_toml};
///
/// let settings: MeshSettings = from_toml("panels = 300\nboundary = 'clip'")?;
/// assert_eq!(settings.panels, Some(300));
/// let told = from_toml::<MeshSettings>("panels = 300\nedge = 2").unwrap_err();
/// assert!(told.to_string().contains("line 2"));
/// # Ok::<(), phex_job::JobError>(())
/// ```
///
/// # Errors
/// If it is longer than [`LONGEST_TOML`], is no TOML, or says something that `T` does not know; the
/// message begins with the line, and names the key.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, JobError> {
    if text.len() > LONGEST_TOML {
        let found = text.len();
        return Err(JobError::input(format!(
            "the file has {found} bytes, and a file of settings has at most {LONGEST_TOML}: lists of points, cones and sizes \
             stand in files of their own, and `space` names combinations instead of each variant"
        )));
    }
    let parsed = toml::Deserializer::parse(text).map_err(|e| located(&e, "", text))?;
    serde_path_to_error::deserialize(parsed)
        .map_err(|e| located(e.inner(), &e.path().to_string(), text))
}

/// The same of a value that such a text holds; the message names the key alone.
///
/// # Errors
/// If it says something that `T` does not know.
pub fn from_json<T: DeserializeOwned>(value: serde_json::Value) -> Result<T, JobError> {
    serde_path_to_error::deserialize(value)
        .map_err(|e| JobError::Input(of_key(&e.inner().to_string(), &e.path().to_string())))
}

/// The parser's message about a key in one line.
fn of_key(message: &str, key: &str) -> String {
    let message = plain(message);
    let of_key = match message.contains(key.trim_end_matches('.')) {
        true => String::new(),
        false => format!("{key}: "),
    };
    let message = (of_key + &message).replace('\n', ", ");
    message.chars().take(SHOWN).collect()
}

/// The same, with the line of the file.
fn located(error: &toml::de::Error, key: &str, text: &str) -> JobError {
    let message = of_key(error.message(), key);
    JobError::input(match error.span() {
        Some(span) => {
            let line = 1 + text[..span.start].matches('\n').count();
            format!("line {line}: {message}")
        }
        None => message,
    })
}

/// Likeness, by Jaro, from which on an unknown key is taken for a known one that is spelt wrong.
const ALIKE: f64 = 0.8;

/// The same error, which says what is meant where a key is unknown: a known one that is spelt
/// alike, or one of another table. `all` has every key of the file, with tables as objects.
pub(crate) fn with_meant(error: JobError, all: &Value) -> JobError {
    let JobError::Input(message) = error else {
        return error;
    };
    let meant = |message: &str| {
        let (before, rest) = message.split_once("unknown field `")?;
        let (found, expected) = rest.split_once("`, expected ")?;
        let known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        let meant = meant(found, &known, all)?;
        Some(format!("{before}unknown field `{found}`: {meant}"))
    };
    JobError::Input(meant(&message).unwrap_or(message))
}

/// What is meant by a key where others are known.
fn meant(found: &str, known: &[&str], all: &Value) -> Option<String> {
    let spelt = found.replace('_', "-");
    if known.contains(&spelt.as_str()) {
        return Some(format!("did you mean `{spelt}`?"));
    }
    let all = all.as_object()?;
    let mut tables = all
        .iter()
        .filter_map(|(name, v)| Some((name, v.as_object()?)));
    if let Some((table, _)) = tables.find(|(_, keys)| keys.contains_key(&spelt)) {
        return Some(format!("`{spelt}` belongs in the table [{table}]"));
    }
    if all.contains_key(&spelt) {
        return Some(format!("`{spelt}` belongs above all tables"));
    }
    let likeness = |key: &&str| strsim::jaro(&spelt, key);
    let nearest = known.iter().copied();
    let nearest = nearest.max_by(|a, b| likeness(a).total_cmp(&likeness(b)))?;
    (likeness(&nearest) >= ALIKE).then(|| format!("did you mean `{nearest}`?"))
}

/// Names of types in the parser's messages, and in plain words.
const WORDS: [(&str, &str); 12] = [
    ("u16", "a whole number that is not negative"),
    ("u32", "a whole number that is not negative"),
    ("u64", "a whole number that is not negative"),
    ("usize", "a whole number that is not negative"),
    ("f64", "a number"),
    ("a string", "a text"),
    ("floating point", "the number"),
    ("integer", "the number"),
    ("string", "the text"),
    ("boolean", "the boolean"),
    ("sequence", "a list"),
    ("map", "a table"),
];

/// The parser's message in plain words, where it is about a value of a wrong type.
fn plain(message: &str) -> String {
    let mut typed = ["invalid type: ", "invalid value: "].into_iter();
    let Some((found, expected)) = typed
        .find_map(|start| message.strip_prefix(start))
        .and_then(|rest| rest.rsplit_once(", expected "))
    else {
        return message.to_owned();
    };
    format!("{} is expected, not {}", worded(expected), worded(found))
}

fn worded(told: &str) -> String {
    if told.starts_with("struct ") {
        return "a table".to_owned();
    }
    let is_word = |rest: &&str| rest.is_empty() || rest.starts_with(' ');
    let of = |(name, word)| Some((word, told.strip_prefix(name).filter(is_word)?));
    let found = WORDS.into_iter().find_map(of);
    found.map_or_else(|| told.to_owned(), |(word, rest)| format!("{word}{rest}"))
}

/// Reads a table as one: without this a list of its values in their order would be taken for it.
///
/// # Errors
/// If it is something else.
pub(crate) fn table<'de, D, T>(deserializer: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    deserializer.deserialize_map(TableVisitor(PhantomData))
}

struct TableVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for TableVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshSettings;

    #[test]
    fn a_text_that_is_too_long_is_refused_before_it_is_parsed() {
        let comment = |bytes: usize| "#".repeat(bytes);
        assert!(from_toml::<MeshSettings>(&comment(LONGEST_TOML)).is_ok());
        let told = from_toml::<MeshSettings>(&comment(LONGEST_TOML + 1)).unwrap_err();
        assert!(told.to_string().contains("1048577 bytes"), "{told}");
    }

    #[test]
    fn an_unknown_key_is_told_with_what_is_meant() {
        for (text, told) in [
            (
                "max_deviation = 1",
                "line 1: unknown field `max_deviation`: did you mean `max-deviation`?",
            ),
            (
                "panles = 3",
                "line 1: unknown field `panles`: did you mean `panels`?",
            ),
            (
                "min-edge = 1",
                "line 1: unknown field `min-edge`: `min-edge` belongs in the table [limits]",
            ),
            (
                "[limits]\npanels = 1",
                "line 2: limits.panels: unknown field `panels`: `panels` belongs above all tables",
            ),
            (
                "[limits]\nmax-panle = '1x2m'",
                "line 2: limits.max-panle: unknown field `max-panle`: did you mean `max-panel`?",
            ),
        ] {
            let error = MeshSettings::from_toml(text).unwrap_err();
            assert_eq!(error.to_string(), told);
        }
        let far = MeshSettings::from_toml("xyz = 1").unwrap_err().to_string();
        assert!(
            far.contains("unknown field `xyz`, expected one of"),
            "{far}"
        );
    }

    #[test]
    fn a_value_of_a_wrong_type_is_refused_by_its_key() {
        let length = "a length such as `5mm` or `0.2%` is expected, not";
        let symmetry = "`auto`, `none`, `mirror` or the order of a rotation from 2 to 1000";
        for (text, told) in [
            (
                "panels = 3\nmax-deviation = true",
                format!("line 2: max-deviation: {length} the boolean `true`"),
            ),
            (
                "[limits]\nmax-edge = [1, 2]",
                format!("line 2: limits.max-edge: {length} a list"),
            ),
            (
                "[[limits]]\nmax-edge = 1",
                "line 1: limits: a table is expected, not a list".to_owned(),
            ),
            (
                "limits = 3",
                "line 1: limits: a table is expected, not the number `3`".to_owned(),
            ),
            (
                "symmetry = 2.5",
                format!("line 1: symmetry: {symmetry} is expected, not the number `2.5`"),
            ),
            ("symmetry = 1", format!("line 1: symmetry is {symmetry}")),
            (
                "panels = 'many'",
                "line 1: panels: a whole number that is not negative is expected, not the text \"many\"".to_owned(),
            ),
            (
                "seed = -1",
                "line 1: seed: a whole number that is not negative is expected, not the number `-1`".to_owned(),
            ),
            (
                "[stages]\nlayout = 1",
                "line 2: stages.layout: a table is expected, not the number `1`".to_owned(),
            ),
            (
                "[limits]\nmax-panel = 2\n",
                "line 2: limits.max-panel: `2` is no rectangle: give its sides as 1.5x3.0m"
                    .to_owned(),
            ),
        ] {
            let error = from_toml::<MeshSettings>(text).unwrap_err();
            assert_eq!(error.to_string(), told);
        }
        assert!(from_toml::<MeshSettings>("symmetry = 6\nplanarity = 1e-9").is_ok());
    }
}
