//! A study file: lists and ranges of settings, and every variant of them.

use crate::limits::{VariantLimits, memory_limit};
use crate::solve::SolveOptions;
use crate::variant::Variant;
use crate::workshop::Workshop;
use phex_job::{JobError, MeshSettings, from_toml, read_text, time_limit};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::collections::{HashMap, HashSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Variants at the most: a list as long as this was hardly meant.
const MOST: usize = 10_000_000;
/// What a range says.
const RANGE_KEYS: [&str; 3] = ["from", "to", "count"];
/// Rounding of the values of a range, over the larger of its ends.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Whole numbers below this have no fraction that rounding took, 2^53.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

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

    /// The number of variants, which is known long before they are made.
    ///
    /// # Errors
    /// If a list is empty, or there are too many.
    pub fn count(&self) -> Result<usize, JobError> {
        let each = match self.variants.is_empty() {
            true => combination_count(&leaves(&self.space, &[])?, self.surfaces.len())?,
            false => self.variants.len(),
        };
        Ok(self.surfaces.len() * each)
    }

    /// Every variant, in the order of the file: the last list changes the fastest.
    ///
    /// # Errors
    /// If a list is empty, a setting unknown, or there are too many.
    pub fn variants(&self) -> Result<Vec<Variant>, JobError> {
        settings_of("settings", &self.settings)?;
        let (table, changes) = match self.variants.is_empty() {
            true => {
                let axes = leaves(&self.space, &[])?;
                combination_count(&axes, self.surfaces.len())?;
                ("space", combinations(&axes))
            }
            false => ("variants", self.variants.clone()),
        };
        let files: HashSet<&PathBuf> = self.surfaces.iter().collect();
        let mut of_name: HashMap<Option<&OsStr>, usize> = HashMap::new();
        for file in files {
            *of_name.entry(file.file_name()).or_default() += 1;
        }
        let variant = |surface: &PathBuf, change: &Map<String, Value>| {
            let mut settings = self.settings.clone();
            merge(&mut settings, change);
            // What [settings] says was read above, so that only the change can be wrong.
            let settings = settings_of(table, &settings)?;
            settings.check_job()?;
            let is_shared = of_name[&surface.file_name()] > 1;
            Ok(Variant {
                surface: surface.clone(),
                // The path as it is typed, where another file has the same name.
                surface_name: is_shared.then(|| surface.display().to_string()),
                settings,
                workshop: self.workshop,
            })
        };
        let all = self.surfaces.iter();
        all.flat_map(|s| changes.iter().map(move |c| variant(s, c)))
            .collect()
    }
}

/// The settings that a table of the file gives.
fn settings_of(table: &str, settings: &Map<String, Value>) -> Result<MeshSettings, JobError> {
    let told = |e| JobError::Input(format!("[{table}]: {e}"));
    let made = MeshSettings::from_json(json!(settings)).map_err(told)?;
    match made.threads {
        None => Ok(made),
        Some(_) => Err(JobError::Input(format!(
            "[{table}]: `threads` has no effect in a study: leave it out, and give --threads"
        ))),
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
    let wrong = |cause: String| JobError::Input(format!("space: `{name}`: {cause}"));
    if let Some(key) = range.keys().find(|k| !RANGE_KEYS.contains(&k.as_str())) {
        return Err(wrong(format!("`{key}` is none of from, to and count")));
    }
    let given = |key: &str| {
        let value = range.get(key);
        value.ok_or_else(|| {
            wrong(format!(
                "`{key}` is missing: a range has from, to and count"
            ))
        })
    };
    let number = |key: &str| {
        let value = given(key)?;
        let number = value.as_f64();
        number.ok_or_else(|| wrong(format!("{key} = {value} is no number")))
    };
    let (from, to, count) = (number("from")?, number("to")?, given("count")?);
    let steps = count.as_u64().filter(|c| (2..=MOST as u64).contains(c));
    let steps = steps.ok_or_else(|| {
        wrong(format!(
            "count = {count}: it is a whole number from 2 to {MOST}, since both ends are among the values"
        ))
    })?;
    let at = |k: u64| from + (to - from) * (k as f64 / (steps - 1) as f64);
    let rounding = ROUNDING * from.abs().max(to.abs());
    Ok((0..steps).map(|k| as_typed(at(k), rounding)).collect())
}

/// A number as it would be typed: what is whole up to rounding is no decimal fraction, which
/// settings such as `panels` refuse. `linspace` of the Python package rounds as this does.
fn as_typed(x: f64, rounding: f64) -> Value {
    match (x - x.round()).abs() <= rounding && x.abs() < LARGEST_WHOLE {
        true => json!(x.round() as i64),
        false => json!(x),
    }
}

/// How many variants lists make with so many surfaces for each, at most as many as make sense: the
/// number for one surface.
fn combination_count(axes: &[Axis], surfaces: usize) -> Result<usize, JobError> {
    let lengths = axes.iter().map(|(_, values)| values.len() as f64);
    let each: f64 = lengths.product();
    let count = each * surfaces as f64;
    match count > MOST as f64 {
        true => Err(JobError::Input(format!(
            "space: there are {count:e} variants, at most {MOST:e}"
        ))),
        false => Ok(each as usize),
    }
}

fn combinations(axes: &[Axis]) -> Vec<Map<String, Value>> {
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
    all
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
        assert_eq!(StudyFile::from_toml(STUDY).unwrap().count().unwrap(), 24);
    }

    #[test]
    fn a_range_of_whole_numbers_is_one_of_panels() {
        let study = "surfaces = ['a.obj']\n[space]\npanels = { from = 1, to = 200, count = 200 }";
        let all = StudyFile::from_toml(study).unwrap().variants().unwrap();
        let panels: Vec<Option<u64>> = all.iter().map(|v| v.settings.panels).collect();
        assert_eq!(panels, (1..=200).map(Some).collect::<Vec<_>>());
    }

    #[test]
    fn surfaces_of_one_file_name_are_told_apart() {
        let study = "surfaces = ['a/roof.obj', 'b/roof.obj', 'c.obj']";
        let all = StudyFile::from_toml(study).unwrap().variants().unwrap();
        let names = all.iter().map(|v| v.inputs()["in:surface"].clone());
        let names: Vec<Value> = names.collect();
        assert_eq!(names, ["a/roof.obj", "b/roof.obj", "c.obj"]);
    }

    /// Where each variant looks at all surfaces, these take a minute.
    #[test]
    fn twice_as_many_surfaces_take_twice_the_time() {
        let names: Vec<String> = (0..20_000).map(|k| format!("'{k}.obj'")).collect();
        let study = StudyFile::from_toml(&format!("surfaces = [{}]", names.join(", "))).unwrap();
        let begun = std::time::Instant::now();
        assert_eq!(study.variants().unwrap().len(), names.len());
        assert!(begun.elapsed().as_secs() < 15, "{:?}", begun.elapsed());
    }

    #[test]
    fn errors_name_table_key_and_cause() {
        for (text, told) in [
            (
                "[settings]\nboundary = 'foo'",
                "[settings]: boundary: unknown variant `foo`",
            ),
            (
                "[space]\npanels = { from = 40, to = 61, count = 3 }",
                "[space]: panels: a whole number that is not negative is expected, not the number `50.5`",
            ),
            (
                "[settings]\nthreads = 7",
                "[settings]: `threads` has no effect in a study: leave it out, and give --threads",
            ),
            (
                "[space]\nthreads = [1, 2]",
                "[space]: `threads` has no effect",
            ),
            (
                "[space.limits]\nmax-edge = [true]",
                "[space]: limits.max-edge: a length",
            ),
            (
                "[[variants]]\npanels = -1",
                "[variants]: panels: a whole number",
            ),
            (
                "[space]\nrotate = { from = 0, to = 60, count = 1 }",
                "space: `rotate`: count = 1: it is a whole number from 2 to 10000000",
            ),
            (
                "[space]\nrotate = { from = 0, to = 60 }",
                "space: `rotate`: `count` is missing: a range has from, to and count",
            ),
            (
                "[space]\nrotate = { from = 'a', to = 60, count = 3 }",
                "space: `rotate`: from = \"a\" is no number",
            ),
            (
                "[space]\nrotate = { from = 0, to = 60, counts = 3 }",
                "space: `rotate`: `counts` is none of",
            ),
        ] {
            let study = StudyFile::from_toml(&format!("surfaces = ['a.obj']\n{text}"));
            let error = study.and_then(|s| s.variants()).unwrap_err().to_string();
            assert!(error.starts_with(told), "{error}");
        }
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
                "surfaces = ['a']\n[workshop]\nthickness = '1mm'\nsheet = ['10%', '8000']",
                "`10%` is a percentage",
            ),
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
