//! What is wanted of a run, and how it is repeated without the studio.

use crate::surfaces::DroppedSurface;
use phex_job::{JobError, LastStage, MeshJob, MeshSettings, options_of, quoted};
use serde::Deserialize;
use serde_json::Value;

/// What the page asks for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wish {
    /// The surface, by its id.
    pub surface: String,
    /// What is set of a job file, and no more.
    pub job: Value,
    /// Where the run ends.
    pub until: Option<LastStage>,
    /// Its place among what the page asks for, if the page counts.
    pub asked: Option<PlaceInLine>,
}

/// Which page asks, and for the how-manyth time: two requests can overtake each other.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceInLine {
    /// A name of the page that no other has.
    pub page: String,
    /// How many requests it had sent before.
    pub before: u64,
}

impl PlaceInLine {
    /// Whether the same page has asked for something else since.
    pub fn is_older_than(&self, other: &Self) -> bool {
        self.page == other.page && self.before < other.before
    }
}

/// A job that can be done, and its texts.
pub struct GrantedWish {
    /// The job.
    pub job: MeshJob,
    /// Where the arrays that are told have their origin.
    pub origin: phex_mesh::Vec3,
    /// Name of the surface's file, without its extension.
    pub stem: String,
    /// The job file.
    pub text: String,
    /// The command line that repeats the run.
    pub command: String,
    /// Its place among what the page asks for.
    pub asked: Option<PlaceInLine>,
}

impl Wish {
    /// The job on a surface.
    ///
    /// # Errors
    /// If the surface is none, or a setting is unknown, makes no sense, or names a file: the studio
    /// reads none.
    pub fn grant(self, surface: &DroppedSurface) -> Result<GrantedWish, JobError> {
        let job = surface.job.as_ref().map_err(JobError::input)?;
        let table = table(self.job)?;
        let text = toml::to_string_pretty(&table).map_err(JobError::input)?;
        let settings = settings(&text)?;
        let stem = surface.name.rsplit_once('.').map_or("", |(stem, _)| stem);
        Ok(GrantedWish {
            job: MeshJob {
                settings,
                until: self.until,
                ..job.clone()
            },
            origin: surface.origin,
            command: command(&surface.name, stem, &table),
            stem: stem.to_owned(),
            text,
            asked: self.asked,
        })
    }
}

/// The settings of a job file, none of which is a file.
///
/// # Errors
/// As [`Wish::grant`].
pub fn settings(text: &str) -> Result<MeshSettings, JobError> {
    let settings = MeshSettings::from_toml(text)?;
    let files = (settings.steering.inputs()).chain(settings.guides.inputs());
    let file = files.chain(settings.size_field.as_deref()).next();
    if let Some(file) = file {
        return Err(JobError::input(format!(
            "the job names the file {}, and the studio reads none: set lines, points and cones on the surface, or run `phex mesh`",
            file.display()
        )));
    }
    settings.check()?;
    Ok(settings)
}

/// A job file's table from JSON; what is `null` is not set.
fn table(job: Value) -> Result<toml::Table, JobError> {
    toml::Table::try_from(without_null(job)).map_err(|e| JobError::input(format!("the job: {e}")))
}

fn without_null(value: Value) -> Value {
    match value {
        Value::Object(entries) => {
            let set = entries.into_iter().filter(|(_, value)| !value.is_null());
            set.map(|(name, value)| (name, without_null(value)))
                .collect()
        }
        Value::Array(items) => items.into_iter().map(without_null).collect(),
        plain => plain,
    }
}

fn command(name: &str, stem: &str, job: &toml::Table) -> String {
    let options = options_of(job, &format!("{stem}-job.toml"));
    let output = quoted(&format!("{stem}-phex.obj"));
    let words = ["phex mesh", &quoted(name), &options, "-o", &output];
    let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn granted(job: Value) -> Result<GrantedWish, String> {
        let surface = DroppedSurface::sample("roof").unwrap();
        let wish = Wish {
            surface: surface.id.clone(),
            job,
            until: None,
            asked: None,
        };
        wish.grant(&surface).map_err(|e| e.to_string())
    }

    #[test]
    fn a_job_is_repeated_by_its_command_line_and_by_its_file() {
        let wish =
            granted(json!({ "panels": 60, "rotate": -7.5, "boundary": null, "any-domain": true }))
                .unwrap();
        assert_eq!(
            wish.command,
            "phex mesh roof.obj --any-domain --panels=60 --rotate=-7.5 -o roof-phex.obj"
        );
        assert_eq!(
            MeshSettings::from_toml(&wish.text).unwrap(),
            wish.job.settings
        );
        let line = json!({ "directions": { "guides": { "lines": [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]] } } });
        let wish = granted(json!({ "panels": 60, "stages": line })).unwrap();
        assert!(
            wish.command.contains("--config=roof-job.toml"),
            "{}",
            wish.command
        );
        assert_eq!(
            MeshSettings::from_toml(&wish.text).unwrap(),
            wish.job.settings
        );
    }

    #[test]
    fn what_a_job_can_not_say_is_refused_by_name() {
        let refused = |job| granted(job).err().unwrap_or_default();
        assert!(refused(json!({ "pannels": 3 })).contains("pannels"));
        assert!(refused(json!({ "panels": -1 })).contains("panels: a whole number"));
        assert!(refused(json!({ "rotate": 1e9 })).contains("rotate"));
        assert!(refused(json!(3)).contains("job"));
        for job in [
            json!({ "size-field": "/etc/passwd" }),
            json!({ "steering": { "fix": "/etc/passwd" } }),
            json!({ "guides": { "guide": "/etc/passwd" } }),
        ] {
            assert!(refused(job).contains("reads none"));
        }
    }
}
