//! A study file: lists and ranges of settings, and every variant of them.

use crate::limits::{VariantLimits, memory_limit};
use crate::solve::SolveOptions;
use crate::variant::Variant;
use crate::workshop::Workshop;
use phex_job::{JobError, MeshSettings, from_toml, read_text, time_limit};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Variants at the most: a list as long as this was hardly meant.
const MOST: usize = 10_000_000;

/// A study, as its file has it.
///
/// ```
/// use phex_study::StudyFile;
///
/// let text = "surfaces = ['roof.obj']\n[settings]\nboundary = 'snap'\n[space]\npanels = [40, 60]\n\
///             rotate = { from = 0, to = 60, count = 3 }";
/// let study = StudyFile::from_toml(text)?;
/// assert_eq!(study.variants()?.len(), 6);
/// # Ok::<(), phex_job::JobError>(())
/// ```
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Files of surfaces; each is tried with everything.
    pub surfaces: Vec<PathBuf>,
    /// Settings of all variants, as in a job file.
    #[serde(default)]
    settings: Map<String, Value>,
    /// Lists of values, or `{ from, to, count }`, by the names of a job file: every combination.
    #[serde(default)]
    space: Map<String, Value>,
    /// Single variants instead: settings of each.
    #[serde(default)]
    variants: Vec<Map<String, Value>>,
    /// What panels are cut from.
    #[serde(default)]
    workshop: Option<Workshop>,
    /// What each variant may take.
    #[serde(default)]
    limits: TypedVariantLimits,
    /// Whether each variant gets its HTML report.
    #[serde(default)]
    html: bool,
}

/// Limits as they are typed.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct TypedVariantLimits {
    time: Option<String>,
    memory: Option<String>,
}

impl StudyFile {
    /// Reads a study file; paths in it begin where the program was started.
    ///
    /// # Errors
    /// If it can't be read, is no TOML, or sets something unknown.
    pub fn read(path: &Path) -> Result<Self, JobError> {
        let study = Self::from_toml(&read_text(path)?);
        study.map_err(|e| JobError::input(format!("{}: {e}", path.display())))
    }

    /// The study of a file's text.
    ///
    /// # Errors
    /// As [`StudyFile::read`].
    pub fn from_toml(text: &str) -> Result<Self, JobError> {
        let study: Self = from_toml(text)?;
        if study.surfaces.is_empty() {
            return Err(JobError::input("`surfaces` names no file"));
        }
        if !study.space.is_empty() && !study.variants.is_empty() {
            return Err(JobError::input("`space` and `variants` exclude each other"));
        }
        study.solve_options().map(|_| study)
    }

    /// How its variants are solved.
    ///
    /// # Errors
    /// If a limit is no time or no amount of memory.
    pub fn solve_options(&self) -> Result<SolveOptions, JobError> {
        let seconds = self.limits.time.as_deref().map(time_limit).transpose();
        let memory = self.limits.memory.as_deref().map(memory_limit).transpose();
        let wrong = |e: String| JobError::Input(format!("limits: {e}"));
        let limits = VariantLimits {
            seconds: seconds.map_err(wrong)?.map(|s| s.as_secs_f64()),
            megabytes: memory.map_err(wrong)?,
        };
        limits.check()?;
        Ok(SolveOptions {
            limits,
            html: self.html,
        })
    }

    /// Every variant, in the order of the file: the last list changes the fastest.
    ///
    /// # Errors
    /// If a list is empty, a setting unknown, or there are too many.
    pub fn variants(&self) -> Result<Vec<Variant>, JobError> {
        let changes = match self.variants.is_empty() {
            true => combinations(&leaves(&self.space, &[])?, self.surfaces.len())?,
            false => self.variants.clone(),
        };
        let variant = |surface: &PathBuf, change: &Map<String, Value>| {
            let mut settings = self.settings.clone();
            merge(&mut settings, change);
            let told = |e: serde_json::Error| JobError::input(format!("settings: {e}"));
            let settings: MeshSettings = serde_json::from_value(json!(settings)).map_err(told)?;
            settings.check_job()?;
            Ok(Variant {
                surface: surface.clone(),
                settings,
                workshop: self.workshop,
            })
        };
        let all = self.surfaces.iter();
        all.flat_map(|s| changes.iter().map(move |c| variant(s, c)))
            .collect()
    }
}

/// A setting and its values: names of tables and the setting, each value.
type Axis = (Vec<String>, Vec<Value>);

fn leaves(space: &Map<String, Value>, above: &[String]) -> Result<Vec<Axis>, JobError> {
    let mut axes = Vec::new();
    for (name, value) in space {
        let path = [above, std::slice::from_ref(name)].concat();
        let told = || path.join(".");
        match value {
            Value::Object(range) if range.contains_key("from") => {
                axes.push((path.clone(), steps(&told(), range)?));
            }
            Value::Object(table) => axes.extend(leaves(table, &path)?),
            Value::Array(list) if list.is_empty() => {
                return Err(JobError::input(format!("space: `{}` is empty", told())));
            }
            Value::Array(list) => axes.push((path, list.clone())),
            single => axes.push((path, vec![single.clone()])),
        }
    }
    Ok(axes)
}

/// The values of `{ from, to, count }`, both ends among them.
fn steps(name: &str, range: &Map<String, Value>) -> Result<Vec<Value>, JobError> {
    let wanted = || JobError::input(format!("space: `{name}` is no {{ from, to, count }}"));
    let number = |key: &str| range.get(key).and_then(Value::as_f64).ok_or_else(wanted);
    let count = range.get("count").and_then(Value::as_u64);
    let count = count.filter(|c| (2..=MOST as u64).contains(c) && range.len() == 3);
    let (from, to, count) = (number("from")?, number("to")?, count.ok_or_else(wanted)?);
    let last = (count - 1) as f64;
    let at = |k: u64| json!(from + (to - from) * (k as f64 / last));
    Ok((0..count).map(at).collect())
}

fn combinations(axes: &[Axis], surfaces: usize) -> Result<Vec<Map<String, Value>>, JobError> {
    let lengths = axes.iter().map(|(_, values)| values.len());
    let count = lengths.fold(surfaces as f64, |n, k| n * k as f64);
    if count > MOST as f64 {
        let told = format!("space: there are {count:e} variants, at most {MOST:e}");
        return Err(JobError::Input(told));
    }
    let mut all = vec![Map::new()];
    for (path, values) in axes {
        let with = |change: &Map<String, Value>, value: &Value| {
            let mut change = change.clone();
            put(&mut change, path, value.clone());
            change
        };
        all = all
            .iter()
            .flat_map(|change| values.iter().map(move |value| with(change, value)))
            .collect();
    }
    Ok(all)
}

fn put(table: &mut Map<String, Value>, path: &[String], value: Value) {
    match path {
        [name] => {
            table.insert(name.clone(), value);
        }
        [name, below @ ..] => {
            let inner = table.entry(name.clone()).or_insert_with(|| json!({}));
            if let Value::Object(inner) = inner {
                put(inner, below, value);
            }
        }
        [] => {}
    }
}

fn merge(into: &mut Map<String, Value>, from: &Map<String, Value>) {
    for (name, value) in from {
        match (into.get_mut(name), value) {
            (Some(Value::Object(inner)), Value::Object(value)) => merge(inner, value),
            _ => {
                into.insert(name.clone(), value.clone());
            }
        }
    }
}

/// A share of a study: the variants whose number, from 1, leaves `number` when it is divided by
/// `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: usize,
    count: usize,
}

impl Default for Shard {
    fn default() -> Self {
        Self {
            number: 1,
            count: 1,
        }
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        numbers
            .filter(|(i, n): &(usize, usize)| (1..=*n).contains(i))
            .map(|(number, count)| Self { number, count })
            .ok_or_else(|| format!("`{text}` is no share I/N with I from 1 to N"))
    }
}

impl Shard {
    /// Its part of a list.
    pub fn of<T>(self, all: Vec<T>) -> Vec<T> {
        let first = all.into_iter().skip(self.number - 1);
        first.step_by(self.count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STUDY: &str = "surfaces = ['a.obj', 'b.obj']\n[settings]\nboundary = 'snap'\n\
                         [settings.steering]\nfairness = 0.5\n[space]\npanels = [40, 60]\n\
                         rotate = { from = 0, to = 60, count = 3 }\n[space.steering]\ncloseness = [1, 2]";

    #[test]
    fn every_combination_is_a_variant() {
        let all = StudyFile::from_toml(STUDY).unwrap().variants().unwrap();
        assert_eq!(all.len(), 2 * 2 * 3 * 2);
        for (k, variant) in all.iter().enumerate() {
            assert!(!all[..k].contains(variant), "twice: {variant:?}");
            assert!(variant.typed()["boundary"] == json!("snap"));
            assert!(variant.typed()["steering"]["fairness"] == json!(0.5));
        }
        let rotations: Vec<f64> = all.iter().filter_map(|v| v.settings.rotate).collect();
        assert!(rotations.iter().all(|r| [0.0, 30.0, 60.0].contains(r)));
    }

    #[test]
    fn shards_share_a_study_out() {
        let all: Vec<usize> = (0..10).collect();
        let mut together: Vec<usize> = Vec::new();
        for i in 1..=3 {
            let shard: Shard = format!("{i}/3").parse().unwrap();
            together.extend(shard.of(all.clone()));
        }
        together.sort_unstable();
        assert_eq!(together, all);
        for wrong in ["", "0/3", "4/3", "1", "a/b", "1/0", "-1/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_a_study_can_t_mean_is_refused() {
        let wrong = [
            ("surfaces = []", "no file"),
            ("surfaces = ['a']\n[space]\npanels = []", "empty"),
            ("surfaces = ['a']\n[space]\npannels = [3]", "pannels"),
            (
                "surfaces = ['a']\n[space]\nrotate = { from = 0, to = 1 }",
                "count",
            ),
            ("surfaces = ['a']\n[limits]\ntime = 'soon'", "soon"),
            (
                "surfaces = ['a']\n[space]\npanels = [1]\n[[variants]]\npanels = 2",
                "exclude",
            ),
            (
                "surfaces = ['a']\n[space]\nseed = { from = 0, to = 1, count = 1e9 }",
                "count",
            ),
        ];
        for (text, word) in wrong {
            let told = StudyFile::from_toml(text).and_then(|s| s.variants());
            let told = told.unwrap_err().to_string();
            assert!(told.contains(word), "{text}: {told}");
        }
        let axis = "{ from = 0, to = 1, count = 4000 }";
        let huge = format!("surfaces = ['a']\n[space]\nrotate = {axis}\nadaptive = {axis}");
        let told = StudyFile::from_toml(&huge).unwrap().variants().unwrap_err();
        assert!(told.to_string().contains("variants"), "{told}");
    }
}
