//! Meshes that were made, and the files that they become.

use crate::frames::frame;
use crate::surfaces::listed;
use crate::upload::RefusedRequest;
use crate::wish::GrantedWish;
use axum::body::Bytes;
use phex::Progress;
use phex::quality::{Check, Verdict};
use phex_fab::folder::files;
use phex_fab::{FabError, FabOptions, PanelIds, Side, fabricate, valid_mesh};
use phex_html::{
    CurveFamily, PackedArray, Report, Viewer, ViewerData, conjugate_curves, page, viewer_data,
};
use phex_job::{JobResult, Quantity, SheetSize, Unit, in_file};
use phex_mesh::io::{Format, write_soup_to};
use phex_picture::maps::{ColourMap, Map, Range, Subject};
use phex_picture::{PictureOptions, draw_map, draw_svg};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Results that are kept; the oldest goes first.
const KEPT: usize = 4;

/// The results of the last runs.
#[derive(Default)]
pub struct Results(VecDeque<Arc<RunResult>>);

impl Results {
    /// Number of results.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The result of a run.
    pub fn find(&self, number: u64) -> Option<Arc<RunResult>> {
        self.0.iter().find(|r| r.number == number).cloned()
    }

    /// Keeps a result.
    pub fn add(&mut self, result: RunResult) {
        self.0.push_back(Arc::new(result));
        if self.0.len() > KEPT {
            self.0.pop_front();
        }
    }
}

/// What a run has made.
pub struct RunResult {
    number: u64,
    made: JobResult,
    names: Vec<String>,
    wish: GrantedWish,
}

/// What the page is told of a result.
#[derive(Serialize)]
struct ToldResult<'a> {
    kind: &'static str,
    run: u64,
    seconds: f64,
    verdict: Verdict,
    checks: Vec<ToldCheck<'a>>,
    figures: HeadFigures,
    notes: &'a [String],
    unit: &'a str,
    /// Extensions of the files that the mesh can become.
    formats: Vec<&'static str>,
    job: &'a str,
    command: &'a str,
    view: ViewerData<'a>,
}

/// A check, in the words of the program; offenders are in an array.
#[derive(Serialize)]
struct ToldCheck<'a> {
    name: &'a str,
    pass: bool,
    decisive: bool,
    value: f64,
    limit: f64,
    scale: phex::quality::Scale,
    value_length: Option<f64>,
    limit_length: Option<f64>,
    reading: &'a Option<phex::quality::Reading>,
    advice: &'a Option<String>,
    faces: PackedArray,
}

impl<'a> From<&'a Check> for ToldCheck<'a> {
    fn from(check: &'a Check) -> Self {
        Self {
            name: check.name,
            pass: check.pass,
            decisive: check.decisive,
            value: check.value,
            limit: check.limit,
            scale: check.scale,
            value_length: check.value_length,
            limit_length: check.limit_length,
            reading: &check.reading,
            advice: &check.advice,
            faces: listed(&check.faces),
        }
    }
}

/// The figures that are looked for first; lengths in model units.
#[derive(Serialize)]
struct HeadFigures {
    panels: usize,
    hexagons: Option<f64>,
    concave: usize,
    planarity: f64,
    mean_edge: f64,
    deviation: Option<f64>,
    area: f64,
}

/// What is asked of the workshop, in the words of `phex fab`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkshopWish {
    thickness: Option<String>,
    gap: Option<String>,
    side: Option<Side>,
    /// Width and length of a sheet, as they are typed.
    sheet: Option<String>,
}

/// A file that is handed out.
pub struct Handout {
    /// Its name.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl RunResult {
    /// What a run has made of a wish.
    pub fn new(number: u64, made: JobResult, wish: GrantedWish) -> Self {
        Self {
            names: PanelIds::new(&made.mesh).into_names(),
            number,
            made,
            wish,
        }
    }

    /// What the page is told of it.
    pub fn told(&self, seconds: f64) -> Bytes {
        let run = &self.made.report;
        let all = Format::READ.into_iter().chain(Format::WRITTEN_ONLY);
        frame(&ToldResult {
            kind: "result",
            run: self.number,
            seconds,
            verdict: run.assessment.verdict,
            checks: run.assessment.checks.iter().map(ToldCheck::from).collect(),
            figures: self.figures(),
            notes: &run.notes,
            unit: &run.unit,
            formats: all.map(Format::extension).collect(),
            job: &self.wish.text,
            command: &self.wish.command,
            view: viewer_data(&self.report("", Ok(&[])), self.wish.origin),
        })
    }

    fn figures(&self) -> HeadFigures {
        let run = &self.made.report;
        let m = &run.assessment.measures;
        HeadFigures {
            panels: m.faces,
            hexagons: m.hex,
            concave: m.faces_concave,
            planarity: m.planarity_length.max,
            mean_edge: m.mean_edge,
            deviation: run
                .assessment
                .judged_deviation()
                .map(|d| d.deviation_max * d.diagonal),
            area: m.per_element.area.iter().sum(),
        }
    }

    fn report<'a>(
        &'a self,
        title: &'a str,
        curves: Result<&'a [CurveFamily], &'a str>,
    ) -> Report<'a> {
        Report {
            title,
            command: &self.wish.command,
            run: &self.made.report,
            mesh: &self.made.mesh,
            names: Some(&self.names),
            surface: self.made.smooth.as_ref().or(Some(&self.made.facets)),
            start: self.made.start.as_ref(),
            curves,
        }
    }

    /// A file, by what it is: `mesh.EXTENSION`, `report.html`, `report.json`, `picture.png`,
    /// `picture.svg`, `workshop.zip` or `job.toml`.
    ///
    /// # Errors
    /// If there is no such file, or the result can't become one.
    pub fn file(
        &self,
        what: &str,
        workshop: &WorkshopWish,
        progress: &dyn Progress,
    ) -> Result<Handout, RefusedRequest> {
        let (part, extension) = what.rsplit_once('.').unwrap_or((what, ""));
        let bytes = match (part, extension) {
            ("mesh", _) => self.mesh(what)?,
            ("report", "html") => self.html(progress)?,
            ("report", "json") => {
                let json = self.made.report.to_json();
                json.map_err(RefusedRequest::internal)?.into_bytes()
            }
            ("picture", "png") => {
                self.painted(|map, options| draw_map(&self.made.mesh, map, options).to_png())
            }
            ("picture", "svg") => {
                self.painted(|map, options| draw_svg(&self.made.mesh, map, options).into_bytes())
            }
            ("workshop", "zip") => self.workshop(workshop, progress)?,
            ("job", "toml") => self.wish.text.clone().into_bytes(),
            _ => return Err(RefusedRequest::gone("there is no such file")),
        };
        let made = match (part, self.made.report.assessment.verdict) {
            ("mesh", Verdict::Invalid) => "invalid",
            ("mesh", _) => "phex",
            (part, _) => part,
        };
        let name = format!("{}-{made}.{extension}", self.wish.stem);
        Ok(Handout { name, bytes })
    }

    fn mesh(&self, what: &str) -> Result<Vec<u8>, RefusedRequest> {
        let path = Path::new(what);
        let format = Format::from_path(path).map_err(RefusedRequest::unusable)?;
        let soup = self.made.mesh.to_soup();
        let written = in_file(path, &soup, self.made.limits.unit);
        let mut bytes = Vec::new();
        write_soup_to(&mut bytes, &written, format).map_err(RefusedRequest::unusable)?;
        Ok(bytes)
    }

    fn html(&self, progress: &dyn Progress) -> Result<Vec<u8>, RefusedRequest> {
        let curves = conjugate_curves(&self.made.facets, progress);
        let title = format!("{}-phex.obj", self.wish.stem);
        let report = self.report(&title, curves.as_deref().map_err(String::as_str));
        let html = page(&report, Viewer::embedded()).map_err(RefusedRequest::internal)?;
        Ok(html.into_bytes())
    }

    /// A picture of the kinds of panels.
    fn painted(&self, draw: impl FnOnce(&ColourMap, &PictureOptions) -> Vec<u8>) -> Vec<u8> {
        let subject = Subject {
            mesh: &self.made.mesh,
            assessment: &self.made.report.assessment,
            surface: Some(&self.made.facets),
        };
        let map = ColourMap::over(Map::Valence, &subject, Range::Automatic);
        map.map_or_else(Vec::new, |map| draw(&map, &PictureOptions::default()))
    }

    fn workshop(
        &self,
        wish: &WorkshopWish,
        progress: &dyn Progress,
    ) -> Result<Vec<u8>, RefusedRequest> {
        let mesh = self.made.mesh.clone();
        let options = self.fab_options(wish)?;
        let ids = PanelIds::new(&mesh);
        let valid = valid_mesh(mesh, &ids, &options.validity).map_err(unfit)?;
        let fabrication = fabricate(valid, ids, options, progress).map_err(unfit)?;
        let files = files(&fabrication).map_err(unfit)?;
        zipped(&self.wish.stem, &files).map_err(RefusedRequest::internal)
    }

    fn fab_options(&self, wish: &WorkshopWish) -> Result<FabOptions, RefusedRequest> {
        let (unit, size) = (self.made.limits.unit, self.made.mesh.diagonal());
        let quantity = |name: &str, text: &Option<String>| {
            let parsed = text.as_deref().map(str::parse::<Quantity>).transpose();
            let parsed = parsed.map_err(|e| RefusedRequest::unusable(format!("{name}: {e}")))?;
            Ok(parsed.map(|q| q.length(unit, size)))
        };
        let mut options = FabOptions {
            unit_mm: unit.metres() / Unit::Mm.metres(),
            side: wish.side.unwrap_or_default(),
            limits: self.made.limits.panels.in_units(unit, size),
            ..FabOptions::default()
        };
        let missing = || RefusedRequest::unusable("thickness: a length is needed, 50mm, say");
        options.thickness = quantity("thickness", &wish.thickness)?.ok_or_else(missing)?;
        options.gap = quantity("gap", &wish.gap)?.unwrap_or(0.0);
        if let Some(sheet) = &wish.sheet {
            let sheet = sheet.parse::<SheetSize>();
            let sheet = sheet.map_err(|e| RefusedRequest::unusable(format!("sheet: {e}")))?;
            options.sheet_mm = sheet.millimetres();
        }
        let planarity = self.made.limits.planarity;
        options.validity.planarity =
            planarity.map(|q| q.fraction(unit, self.made.mesh.mean_edge()));
        Ok(options)
    }
}

/// What the workshop refuses, with the panels' names.
fn unfit(error: FabError) -> RefusedRequest {
    RefusedRequest::unusable(phex_job::chain(&error))
}

/// A folder as one file.
fn zipped(folder: &str, files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, bytes) in files {
        archive.start_file(format!("{folder}-workshop/{name}"), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}
