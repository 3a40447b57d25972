//! What the commands that judge a mesh judge it by.

use crate::exit::Failure;
use crate::promise::Promise;
use crate::shared_arguments::CriteriaArguments;
use crate::verdict::or_promised;
use phex::quality::{Assessment, Omitted, Reason};
use phex::report::{InputFile, RunReport};
use phex_job::{MeshFile, TypedLimits, without_crumbs};
use phex_mesh::{HexMesh, TriangleSurface};
use serde_json::json;

/// Limits, and the surfaces that a mesh stands for.
pub(super) struct Criteria {
    pub limits: TypedLimits,
    pub facets: Option<TriangleSurface>,
    /// What is said of crumbs of the facets that the mesh does not stand for.
    left_out: Option<String>,
    smooth: Option<TriangleSurface>,
    /// Whether the run that made the mesh knew a smooth surface.
    had_smooth: bool,
    /// The files of the surfaces.
    pub records: Vec<InputFile>,
}

impl Criteria {
    /// What is typed, and where nothing is what a job or an earlier run promised; of the facets
    /// what the mesh stands for.
    pub fn read(arguments: &CriteriaArguments, mesh: &HexMesh) -> Result<Self, Failure> {
        let promise = arguments.report_of.as_deref().map(Promise::read);
        let promise = promise.transpose()?;
        let promised = match &arguments.limits {
            Some(job) => Some(TypedLimits::of_job(job)?),
            None => promise.as_ref().map(Promise::limits).transpose()?,
        };
        let boundary = arguments.boundary.map(Into::into);
        let (facets, smooth) = match (&arguments.surface, &promise) {
            (Some(path), _) => (Some(MeshFile::read(path)?), None),
            (None, Some(promise)) => (promise.surface()?, promise.smooth()?),
            (None, None) => (None, None),
        };
        let surface = |file: &Option<MeshFile>| -> Result<Option<TriangleSurface>, Failure> {
            let file = file.as_ref();
            Ok(file.map(|f| f.surface()).transpose()?)
        };
        let covered = surface(&facets)?.map(|all| without_crumbs(all, mesh));
        let (covered, left_out) = covered.unzip();
        Ok(Self {
            limits: or_promised(&arguments.tolerances, boundary, promised),
            facets: covered,
            left_out: left_out.flatten(),
            smooth: surface(&smooth)?,
            had_smooth: promise.is_some_and(|p| p.has_smooth()),
            records: [facets, smooth]
                .into_iter()
                .flatten()
                .map(|f| f.record)
                .collect(),
        })
    }

    pub fn judge(&self, mesh: &HexMesh) -> Assessment {
        let surfaces = [self.smooth.as_ref(), self.facets.as_ref()];
        let mut assessment = self.limits.judge_finished(mesh, surfaces, None);
        if self.had_smooth && self.smooth.is_none() {
            assessment.not_checked.push(Omitted {
                name: "deviation_smooth",
                reason: Reason::NoSmoothSurface,
            });
        }
        assessment
    }

    /// A report of a command that judges a mesh.
    pub fn report(&self, assessment: Assessment, command: &'static str) -> RunReport {
        let limits = &self.limits;
        let mut report = limits.report(command, assessment);
        report.settings = json!({
            "planarity": limits.planarity,
            "max-deviation": limits.max_deviation,
            "unit": limits.unit,
            "limits": limits.panels,
        });
        report.notes.extend(self.left_out.clone());
        report
    }
}
