//! The HTML report of a run.

use crate::exit::Failure;
use crate::output::write_text;
use crate::progress::{check_interruption, is_interrupted};
use anyhow::Context;
use phex::report::RunReport;
use phex::{Event, Progress};
use phex_fab::PanelIds;
use phex_html::{Report, Viewer, conjugate_curves, page};
use phex_job::quoted;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface};
use std::path::Path;
use std::sync::LazyLock;

/// What is shown of a run; all in model coordinates.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// The panels.
    pub mesh: &'a HexMesh,
    /// The surface that they stand for.
    pub surface: Option<&'a TriangleSurface>,
    /// The surface as it was given, where that is another one; conjugate curves are computed on it.
    pub given: Option<&'a TriangleSurface>,
    /// The panels before the last step.
    pub start: Option<&'a PolygonSoup>,
}

impl<'a> Shown<'a> {
    /// A mesh alone.
    pub fn of(mesh: &'a HexMesh) -> Self {
        Self {
            mesh,
            surface: None,
            given: None,
            start: None,
        }
    }
}

/// Writes the report.
///
/// # Errors
/// If the user interrupts, or writing fails.
pub fn write(path: &Path, shown: &Shown<'_>, report: &RunReport) -> Result<(), Failure> {
    let curves = match shown.given.or(shown.surface) {
        Some(surface) => conjugate_curves(surface, &Silently),
        None => Err("no surface was given".to_owned()),
    };
    check_interruption()?;
    let mesh = report
        .outputs
        .iter()
        .find(|output| output.content == "mesh");
    let named = mesh.map(|output| output.path.as_str());
    let named = named.or(report.inputs.first().map(|input| input.path.as_str()));
    let title = Path::new(named.unwrap_or("mesh")).file_name();
    let title = title.map_or_else(|| "mesh".into(), |name| name.to_string_lossy());
    let names = PanelIds::new(shown.mesh).into_names();
    let content = Report {
        title: &title,
        command: &typed_command(),
        run: report,
        mesh: shown.mesh,
        names: Some(&names),
        surface: shown.surface,
        start: shown.start,
        curves: curves.as_deref().map_err(String::as_str),
    };
    let html = page(&content, Viewer::embedded()).context("the HTML report")?;
    write_text(path, &html)
}

/// A line for the table where the report has no interactive view; else nothing.
pub fn without_view() -> Option<String> {
    Viewer::absent().map(|why| format!("pictures and tables only, no interactive view: {why}"))
}

/// The version, and whether reports have an interactive view.
pub fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let view = Viewer::absent()
            .map_or_else(|| "inside".to_owned(), |why| format!("not inside: {why}"));
        let version = env!("CARGO_PKG_VERSION");
        format!("{version}\ninteractive view of HTML reports: {view}")
    });
    &TEXT
}

/// Says nothing, and ends when the user interrupts.
pub struct Silently;

impl Progress for Silently {
    fn report(&self, _: &Event) {}

    fn is_cancelled(&self) -> bool {
        is_interrupted()
    }
}

/// The command line as it can be typed again.
pub fn typed_command() -> String {
    // A name that is no UTF-8 can be typed, and is shown as well as it can be.
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| quoted(&word.to_string_lossy()));
    std::iter::once("phex".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
