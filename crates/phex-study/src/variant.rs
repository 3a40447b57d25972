//! One job of a study, and the name of its folder.

use crate::workshop::Workshop;
use phex_job::{JobError, MeshSettings, sha256};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Characters of the checksum that name a folder.
const KEY_LENGTH: usize = 16;

/// One job of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// The file of its surface.
    pub surface: PathBuf,
    /// What a table calls the surface; else the file's name. The folder's name does not depend on
    /// it.
    #[serde(default)]
    pub surface_name: Option<String>,
    /// Its settings, as in a job file.
    #[serde(default)]
    pub settings: MeshSettings,
    /// What its panels are cut from, if that is to be known.
    #[serde(default)]
    pub workshop: Option<Workshop>,
}

impl Variant {
    /// The name of its folder: a checksum of the surface's and other files' bytes, of the settings
    /// that are not at their defaults, and of the version of phex. The number of threads is no part
    /// of it, since the result does not depend on that.
    ///
    /// # Errors
    /// If a file can't be read, or the settings exclude one another.
    pub fn key(&self) -> Result<String, JobError> {
        self.key_with(&mut HashMap::new())
    }

    fn key_with(&self, sums: &mut HashMap<PathBuf, String>) -> Result<String, JobError> {
        self.settings.check_job()?;
        let surface = checksum(&self.surface, sums)?;
        let mut settings = self.typed();
        for file in self.files() {
            let sum = checksum(file, sums)?;
            replace(&mut settings, &file.display().to_string(), &sum);
        }
        let whole = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "surface": surface,
            "settings": settings,
            "workshop": self.workshop,
        });
        Ok(sha256(whole.to_string())[..KEY_LENGTH].to_owned())
    }

    /// The settings that are not at their defaults, as in a job file.
    pub(crate) fn typed(&self) -> Value {
        let settings = MeshSettings {
            threads: None,
            ..self.settings.clone()
        };
        let [given, usual] = [&settings, &MeshSettings::default()].map(|s| json!(s));
        unlike(&given, &usual).unwrap_or_else(|| json!({}))
    }

    /// What varies, in the columns of a table: the surface, and every setting that is not at its
    /// default, by the names of a job file. Files have their names alone, unless the surface is
    /// called otherwise.
    pub(crate) fn inputs(&self) -> Map<String, Value> {
        let mut settings = self.typed();
        for file in self.files() {
            replace(&mut settings, &file.display().to_string(), &name(file));
        }
        let mut columns = Map::new();
        let surface = self.surface_name.clone();
        let surface = surface.unwrap_or_else(|| name(&self.surface));
        columns.insert("in:surface".to_owned(), json!(surface));
        flatten("in:", settings, &mut columns);
        if let Some(workshop) = &self.workshop {
            flatten("in:workshop.", json!(workshop), &mut columns);
        }
        columns
    }

    /// The files that the settings name.
    fn files(&self) -> impl Iterator<Item = &Path> {
        let settings = &self.settings;
        (settings.steering.inputs())
            .chain(settings.guides.inputs())
            .chain(settings.size_field.as_deref())
    }
}

/// The names of the folders of many variants; every file is read once.
///
/// # Errors
/// As [`Variant::key`], with the number of the variant, from 0.
pub fn keys(variants: &[Variant]) -> Result<Vec<String>, JobError> {
    let mut sums = HashMap::new();
    let key = |(k, variant): (usize, &Variant)| {
        let key = variant.key_with(&mut sums);
        key.map_err(|e| JobError::input(format!("variant {k} (counted from 0): {e}")))
    };
    variants.iter().enumerate().map(key).collect()
}

/// A file's name without its folders, which other machines have elsewhere.
pub(crate) fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

fn checksum(path: &Path, sums: &mut HashMap<PathBuf, String>) -> Result<String, JobError> {
    if let Some(sum) = sums.get(path) {
        return Ok(sum.clone());
    }
    let bytes = std::fs::read(path);
    let bytes = bytes.map_err(|e| JobError::input(format!("{}: {e}", path.display())))?;
    let sum = sha256(bytes);
    sums.insert(path.to_path_buf(), sum.clone());
    Ok(sum)
}

/// The parts of a value that differ from another one.
fn unlike(given: &Value, usual: &Value) -> Option<Value> {
    match (given, usual) {
        (Value::Object(given), Value::Object(usual)) => {
            let part = |(name, value): (&String, &Value)| {
                let differs = unlike(value, usual.get(name).unwrap_or(&Value::Null))?;
                Some((name.clone(), differs))
            };
            let parts: Map<String, Value> = given.iter().filter_map(part).collect();
            (!parts.is_empty()).then_some(Value::Object(parts))
        }
        _ => (given != usual).then(|| given.clone()),
    }
}

/// Puts another text in the place of one, wherever it is.
fn replace(value: &mut Value, old: &str, new: &str) {
    match value {
        Value::String(text) if text == old => *text = new.to_owned(),
        Value::Array(list) => list.iter_mut().for_each(|v| replace(v, old, new)),
        Value::Object(map) => map.values_mut().for_each(|v| replace(v, old, new)),
        _ => {}
    }
}

fn flatten(prefix: &str, value: Value, columns: &mut Map<String, Value>) {
    match value {
        Value::Object(map) => {
            for (name, value) in map {
                match value {
                    Value::Object(_) => flatten(&format!("{prefix}{name}."), value, columns),
                    Value::Null => {}
                    Value::Array(_) => {
                        columns.insert(format!("{prefix}{name}"), json!(value.to_string()));
                    }
                    _ => {
                        columns.insert(format!("{prefix}{name}"), value);
                    }
                }
            }
        }
        _ => {
            columns.insert(prefix.to_owned(), value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variant(folder: &Path, settings: &str) -> Variant {
        let surface = folder.join("s.obj");
        std::fs::write(&surface, "v 0 0 0\n").unwrap();
        Variant {
            surface,
            surface_name: None,
            settings: MeshSettings::from_toml(settings).unwrap(),
            workshop: None,
        }
    }

    #[test]
    fn a_folder_is_named_by_what_the_result_depends_on() {
        let folder = tempfile::tempdir().unwrap();
        let key = |settings: &str| variant(folder.path(), settings).key().unwrap();
        let first = key("panels = 40");
        assert_eq!(first.len(), KEY_LENGTH);
        assert_eq!(first, key("panels = 40\nthreads = 2"));
        assert_eq!(key("rotate = 0"), key("rotate = 0.0"));
        for other in [
            "panels = 41",
            "panels = 40\nseed = 1",
            "panels = 40\n[stages.layout]\nsweeps = 3",
        ] {
            assert_ne!(first, key(other), "{other}");
        }
        std::fs::write(folder.path().join("sizes.txt"), "1\n").unwrap();
        let field = format!(
            "size-field = '{}'",
            folder.path().join("sizes.txt").display()
        );
        let before = key(&field);
        std::fs::write(folder.path().join("sizes.txt"), "2\n").unwrap();
        assert_ne!(
            before,
            key(&field),
            "the bytes of a file that a setting names count"
        );
    }

    #[test]
    fn columns_have_the_names_of_job_files() {
        let folder = tempfile::tempdir().unwrap();
        let made = variant(
            folder.path(),
            "panels = 40\nboundary = 'snap'\n[steering]\nfairness = 0.5",
        );
        let columns = made.inputs();
        let names: Vec<&str> = columns.keys().map(String::as_str).collect();
        let expected = [
            "in:boundary",
            "in:panels",
            "in:steering.fairness",
            "in:surface",
        ];
        assert_eq!(names, expected);
        assert_eq!(columns["in:surface"], json!("s.obj"));
    }

    #[test]
    fn the_variant_that_can_t_be_named_is_told() {
        let missing = Variant {
            surface: "/no/such.obj".into(),
            surface_name: None,
            settings: MeshSettings::default(),
            workshop: None,
        };
        let told = keys(&[missing]).unwrap_err().to_string();
        assert!(
            told.contains("variant 0") && told.contains("such.obj"),
            "{told}"
        );
    }
}
