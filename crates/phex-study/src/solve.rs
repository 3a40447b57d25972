//! One variant into its folder.

use crate::limits::{VariantLimits, Watch};
use crate::row::{Ending, Row, add_figures, row};
use crate::thumbnail::thumbnail;
use crate::variant::{Variant, name};
use crate::workshop::add_workshop;
use phex::Progress;
use phex::quality::Verdict;
use phex_fab::PanelIds;
use phex_html::{Report, Viewer};
use phex_job::{Given, JobError, JobResult, MeshFile, MeshJob, chain, sha256};
use phex_mesh::io::{atomic_write, write_soup};
use phex_picture::{PictureOptions, draw};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::path::Path;

/// The file that is written last: a folder that has it is finished.
pub const RUN_FILE: &str = "run.json";
/// The other files of a folder.
const MESH: &str = "mesh.obj";
const REPORT: &str = "report.json";
const PICTURE: &str = "picture.png";
const THUMBNAIL: &str = "thumbnail.png";
const PAGE: &str = "report.html";

/// How variants are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SolveOptions {
    /// What each may take.
    pub limits: VariantLimits,
    /// Whether each gets its HTML report, about a megabyte.
    pub html: bool,
}

/// Solves a variant in its folder below `out`, or reads what was found there before. Ends without
/// a valid mesh are rows, too: `out:status` is `pass`, `outside-tolerance`, `invalid`, `no-result`,
/// `unusable-input`, `time-limit`, `memory-limit`, `not-written` (its files could not be; it will
/// be computed again) or `internal-error`.
///
/// # Errors
/// If the variant has no name (see [`Variant::key`]), a limit is no number, or the caller stops it.
pub fn solve(
    variant: &Variant,
    out: &Path,
    options: &SolveOptions,
    progress: &dyn Progress,
) -> Result<Row, JobError> {
    options.limits.check()?;
    let key = variant.key()?;
    if let Some(row) = finished(out, &key, options) {
        return Ok(row);
    }
    let watch = Watch::new(progress, options.limits);
    let place = VariantFolder { out, key: &key };
    let solved = run(variant, &watch).and_then(|made| {
        let told = row_of(&made, variant, &key, &watch)?;
        Ok((told, Some(made)))
    });
    let (mut told, made) = match solved {
        Ok(solved) => solved,
        Err(error) => (row(variant, &key, &ending_of(error, &watch)?), None),
    };
    let written = match &made {
        Some(made) => place.write_mesh(made, variant, options, &mut told),
        None => Ok(()),
    };
    let written = written.and_then(|()| place.write_run(variant, options, &watch, &told));
    match written {
        Ok(()) => Ok(told),
        Err(error) => {
            let ending = Ending {
                status: "not-written",
                exit: 1,
                reason: error.to_string(),
            };
            Ok(row(variant, &key, &ending))
        }
    }
}

/// How an error ended a variant.
///
/// # Errors
/// If the caller has stopped it.
fn ending_of(error: JobError, watch: &Watch<'_>) -> Result<Ending, JobError> {
    if error != JobError::Cancelled {
        return Ok(Ending::of_error(&error));
    }
    let (status, reason) = watch.ended().ok_or(error)?;
    Ok(Ending {
        status,
        exit: 5,
        reason,
    })
}

/// The row of a variant with a mesh, but for the files.
///
/// # Errors
/// If the workshop's part is cancelled.
fn row_of(
    made: &JobResult,
    variant: &Variant,
    key: &str,
    watch: &Watch<'_>,
) -> Result<Row, JobError> {
    let mut told = row(variant, key, &Ending::of_report(&made.report));
    add_figures(&mut told, made);
    let is_cut = made.report.assessment.verdict != Verdict::Invalid;
    if let Some(workshop) = variant.workshop.as_ref().filter(|_| is_cut) {
        add_workshop(&mut told, workshop, made, watch);
        if watch.is_cancelled() {
            return Err(JobError::Cancelled);
        }
    }
    Ok(told)
}

/// The row of a variant that is finished, unless limits ended it that are wider now, or its mesh
/// has no HTML report and is to have one.
pub fn finished(out: &Path, key: &str, options: &SolveOptions) -> Option<Row> {
    let folder = out.join(key);
    let text = std::fs::read_to_string(folder.join(RUN_FILE)).ok()?;
    let run: RunRecord = serde_json::from_str(&text).ok()?;
    let status = run.row.get("out:status").and_then(Value::as_str);
    let is_ended = matches!(status, Some("time-limit" | "memory-limit"));
    let goes_on = is_ended && run.limits.is_widened_by(&options.limits);
    let lacks_page = options.html && run.row.contains_key("threeD") && !folder.join(PAGE).exists();
    (!(goes_on || lacks_page)).then_some(run.row)
}

/// What `run.json` holds.
#[derive(Serialize, Deserialize)]
pub(crate) struct RunRecord {
    /// Version of phex.
    pub version: String,
    /// What the folder's name was made of.
    pub variant: Value,
    /// What it might have taken.
    pub limits: VariantLimits,
    /// What it took; other runs take something else.
    pub cost: VariantCost,
    /// The row of the table.
    pub row: Row,
}

/// What a variant took.
#[derive(Serialize, Deserialize)]
pub(crate) struct VariantCost {
    /// Seconds, reading and writing included.
    pub seconds: f64,
    /// Largest memory of the process, megabytes.
    pub megabytes: f64,
    /// Threads.
    pub threads: usize,
}

fn run(variant: &Variant, watch: &Watch<'_>) -> Result<JobResult, JobError> {
    let settings = variant.settings.clone();
    settings.check()?;
    let file = MeshFile::read(&variant.surface)?;
    let given = Given::read(&settings)?;
    let parts = file.surfaces()?;
    let mut input = file.record;
    input.path = name(&variant.surface);
    let job = MeshJob {
        given,
        ..MeshJob::new(parts, input, settings)
    };
    phex_job::run(&job, watch)
}

/// A variant's folder.
struct VariantFolder<'a> {
    out: &'a Path,
    key: &'a str,
}

impl VariantFolder<'_> {
    fn write(&self, file: &str, bytes: &[u8]) -> Result<(), JobError> {
        let path = self.out.join(self.key).join(file);
        let written = atomic_write(&path, |to| to.write_all(bytes));
        written.map_err(|e| JobError::Internal(chain(&e)))
    }

    /// A column that names a file of the folder.
    fn named(&self, file: &str) -> Value {
        json!(format!("{}/{file}", self.key))
    }

    /// The files of a mesh, and their columns.
    fn write_mesh(
        &self,
        made: &JobResult,
        variant: &Variant,
        options: &SolveOptions,
        told: &mut Row,
    ) -> Result<(), JobError> {
        let path = self.out.join(self.key).join(MESH);
        std::fs::create_dir_all(self.out.join(self.key))
            .map_err(|e| JobError::Internal(format!("{}: {e}", path.display())))?;
        let written = write_soup(&path, &made.mesh.to_soup());
        written.map_err(|e| JobError::Internal(chain(&e)))?;
        let bytes = std::fs::read(&path);
        let bytes = bytes.map_err(|e| JobError::Internal(format!("{}: {e}", path.display())))?;
        told.insert("out:mesh".to_owned(), json!(sha256(bytes)[..16]));
        told.insert("threeD".to_owned(), self.named(MESH));
        let report = made.report.to_json();
        let report = report.map_err(|e| JobError::Internal(e.to_string()))?;
        self.write(REPORT, report.as_bytes())?;
        let picture = PictureOptions {
            width: 480,
            height: 360,
            supersampling: 2,
            ..PictureOptions::default()
        };
        self.write(PICTURE, &draw(&made.mesh, &picture).to_png())?;
        self.write(THUMBNAIL, &thumbnail(&made.mesh)?)?;
        told.insert("img".to_owned(), self.named(PICTURE));
        match options.html {
            true => self.write(PAGE, page(made, variant)?.as_bytes()),
            false => Ok(()),
        }
    }

    fn write_run(
        &self,
        variant: &Variant,
        options: &SolveOptions,
        watch: &Watch<'_>,
        told: &Row,
    ) -> Result<(), JobError> {
        let record = RunRecord {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            variant: json!({
                "surface": name(&variant.surface),
                "settings": variant.typed(),
                "workshop": variant.workshop,
            }),
            limits: options.limits,
            cost: VariantCost {
                seconds: watch.seconds(),
                megabytes: watch.megabytes(),
                threads: rayon::current_num_threads(),
            },
            row: told.clone(),
        };
        let text = serde_json::to_string_pretty(&record);
        let text = text.map_err(|e| JobError::Internal(e.to_string()))?;
        self.write(RUN_FILE, text.as_bytes())
    }
}

/// The HTML report.
fn page(made: &JobResult, variant: &Variant) -> Result<String, JobError> {
    let names = PanelIds::new(&made.mesh).into_names();
    let report = Report {
        title: &name(&variant.surface),
        command: "phex sweep",
        run: &made.report,
        mesh: &made.mesh,
        names: Some(&names),
        surface: made.smooth.as_ref().or(Some(&made.facets)),
        start: made.start.as_ref(),
        curves: Err("a study draws none"),
    };
    let html = phex_html::page(&report, Viewer::embedded());
    html.map_err(|e| JobError::Internal(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex::{Event, Silent};
    use phex_job::MeshSettings;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    use std::time::Duration;

    /// A ball of a few panels, in a file of the folder.
    fn ball(folder: &Path) -> Variant {
        let shape = Shape::from_name("sphere", &[]).unwrap();
        let options = TriangulationOptions {
            triangles: 500,
            ..TriangulationOptions::default()
        };
        let surface = folder.join("ball.obj");
        write_soup(&surface, &triangulate(&shape, &options).unwrap().to_soup()).unwrap();
        let settings = "panels = 32\neffort = 'draft'\nmax-deviation = '5%'";
        Variant {
            surface,
            surface_name: None,
            settings: MeshSettings::from_toml(settings).unwrap(),
            workshop: None,
        }
    }

    /// Waits at the first sheet, so that the limit of time is reached there.
    struct SlowWorkshop(Duration);

    impl Progress for SlowWorkshop {
        fn report(&self, event: &Event) {
            if matches!(event, Event::Counted { stage, .. } if *stage == "panels on sheets") {
                std::thread::sleep(self.0);
            }
        }

        fn is_cancelled(&self) -> bool {
            false
        }
    }

    #[test]
    fn a_limit_that_is_reached_in_the_workshop_is_a_row_and_wider_ones_try_again() {
        let folder = tempfile::tempdir().unwrap();
        let workshop = serde_json::from_value(json!({ "thickness": "20mm" })).unwrap();
        let variant = Variant {
            workshop: Some(workshop),
            ..ball(folder.path())
        };
        let limits = VariantLimits {
            seconds: Some(5.0),
            megabytes: None,
        };
        let short = SolveOptions {
            limits,
            html: false,
        };
        let slow = SlowWorkshop(Duration::from_secs(5));
        let row = solve(&variant, folder.path(), &short, &slow).unwrap();
        assert_eq!(row["out:status"], json!("time-limit"));
        assert_eq!(row["out:reason"], json!("it took more than 5 s"));
        let free = SolveOptions::default();
        let row = solve(&variant, folder.path(), &free, &Silent).unwrap();
        assert_eq!(row["out:status"], json!("pass"), "{row:?}");
        assert!(row.contains_key("out:sheets"), "{row:?}");
    }

    #[test]
    fn the_workshop_takes_what_is_as_planar_as_the_settings_say() {
        let folder = tempfile::tempdir().unwrap();
        let mut variant = ball(folder.path());
        variant.workshop = serde_json::from_value(json!({ "thickness": "20mm" })).unwrap();
        variant.settings.planarity = Some("1e-20".parse().unwrap());
        let options = SolveOptions::default();
        let row = solve(&variant, folder.path(), &options, &Silent).unwrap();
        assert_eq!(row["out:reason"], json!("planarity"));
        let told = row["out:workshop"].as_str().unwrap();
        assert!(told.contains("planar"), "{told}");
    }

    #[test]
    fn a_page_that_is_wanted_later_is_made() {
        let folder = tempfile::tempdir().unwrap();
        let variant = ball(folder.path());
        let page = folder.path().join(variant.key().unwrap()).join(PAGE);
        let mut options = SolveOptions::default();
        let first = solve(&variant, folder.path(), &options, &Silent).unwrap();
        assert!(!page.exists());
        options.html = true;
        let again = solve(&variant, folder.path(), &options, &Silent).unwrap();
        assert!(page.exists() && first == again);
        assert!(finished(folder.path(), &variant.key().unwrap(), &options).is_some());
    }
}
