//! Limits as they are typed: what a mesh is judged by, and what its report says of that.

use crate::error::JobError;
use crate::panel_limits::LimitSettings;
use crate::settings::{DEFAULT_DEVIATION, MeshSettings};
use crate::units::{Quantity, Unit};
use phex::optimise::OptimiseOptions;
use phex::quality::{Assessment, Check, Reading, References, Scale};
use phex::report::RunReport;
use phex::{Boundary, continued};
use phex_mesh::{HexMesh, LARGEST_COORDINATE, TriangleSurface};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// Planarity that the optimiser reaches in double precision, in diagonals over mean edges. What is
/// asked for below is judged as it is, but nothing else is given up for it.
const REACHED: f64 = 16.0 * f64::EPSILON;

/// Limits as they were typed: what every command judges a mesh by, and what its report says of
/// that.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TypedLimits {
    /// Of planarity.
    pub planarity: Option<Quantity>,
    /// Of the distance to the surface.
    pub max_deviation: Quantity,
    /// The model's unit.
    pub unit: Unit,
    /// What panels were to do at the boundary, where neither curve nor ground plane leads it
    /// elsewhere.
    pub boundary: Option<Boundary>,
    /// Of panels, edges, corners and joints.
    #[serde(default)]
    pub panels: LimitSettings,
}

impl Default for TypedLimits {
    fn default() -> Self {
        Self {
            planarity: None,
            max_deviation: DEFAULT_DEVIATION,
            unit: Unit::default(),
            boundary: None,
            panels: LimitSettings::default(),
        }
    }
}

impl From<&MeshSettings> for TypedLimits {
    fn from(settings: &MeshSettings) -> Self {
        let stages = &settings.stages;
        Self {
            planarity: settings.planarity,
            max_deviation: settings.max_deviation(),
            unit: settings.unit(),
            boundary: Some(stages.boundary),
            panels: settings.limits,
        }
    }
}

impl TypedLimits {
    /// Those of a job file, by which any mesh is judged; those of the boundary where it names one.
    ///
    /// # Errors
    /// As [`MeshSettings::from_file`] and [`MeshSettings::check`].
    pub fn of_job(path: &Path) -> Result<Self, JobError> {
        let settings = MeshSettings::from_file(path)?;
        settings.check()?;
        Ok(Self {
            boundary: settings.boundary.map(Into::into),
            ..Self::from(&settings)
        })
    }

    /// Tells the optimiser what is demanded of a mesh with edges of length `edge` and diagonal
    /// `extent`, model units; percentages of the deviation refer to the diagonal `whole`.
    pub fn demand(&self, options: &mut OptimiseOptions, edge: f64, extent: f64, whole: f64) {
        if let Some(planarity) = self.planarity {
            let rounding = REACHED * extent / edge;
            options.planarity_tolerance = planarity.fraction(self.unit, edge).max(rounding);
        }
        let most = self.max_deviation.length(self.unit, whole) / extent;
        options.max_deviation = (most > 0.0).then_some(most);
        options.panels = self.panels.in_units(self.unit, whole);
    }

    /// What is typed, and where nothing is these.
    pub fn under(
        self,
        (planarity, max_deviation): (Option<Quantity>, Option<Quantity>),
        unit: Option<Unit>,
        boundary: Option<Boundary>,
    ) -> Self {
        Self {
            planarity: planarity.or(self.planarity),
            max_deviation: max_deviation.unwrap_or(self.max_deviation),
            unit: unit.unwrap_or(self.unit),
            boundary: boundary.or(self.boundary),
            ..self
        }
    }

    fn limits(&self, mesh: &HexMesh, surface: Option<&TriangleSurface>) -> phex::quality::Limits {
        let planarity = self.planarity;
        let relative = |surface: &TriangleSurface| {
            let diagonal = surface.diagonal();
            self.max_deviation.length(self.unit, diagonal) / diagonal
        };
        let mut limits = phex::quality::Limits::new(surface.map(relative), self.boundary);
        let whole = surface.map_or_else(|| mesh.diagonal(), TriangleSurface::diagonal);
        limits.panels = self.panels.in_units(self.unit, whole);
        limits.validity.planarity = planarity.map(|q| q.fraction(self.unit, mesh.mean_edge()));
        limits
    }

    /// Judges a mesh by these limits.
    pub fn judge(&self, mesh: &HexMesh, references: References<'_>) -> Assessment {
        let limits = self.limits(mesh, references.smooth.or(references.facets));
        let mut assessment = Assessment::new(mesh, references, &limits);
        let edge = assessment.measures.mean_edge;
        let diagonal = assessment.judged_deviation().map(|d| d.diagonal);
        let whole = diagonal.unwrap_or_else(|| mesh.diagonal());
        for check in &mut assessment.checks {
            let of_panels = self.panels.reading(check, self.unit, whole);
            check.reading = of_panels.or_else(|| self.reading(check, edge, diagonal));
        }
        assessment
    }

    /// Judges a finished mesh against the surfaces that it stands for, smooth and facets; where
    /// whole panels may stick out of these, they go on beyond their boundary. `asked` is the number
    /// of panels that was asked for, where that is known.
    pub fn judge_finished(
        &self,
        mesh: &HexMesh,
        [smooth, facets]: [Option<&TriangleSurface>; 2],
        asked: Option<usize>,
    ) -> Assessment {
        let panels = mesh.topology().n_faces();
        let longer = |s: &TriangleSurface| continued(s, panels).unwrap_or_else(|| s.clone());
        let sticks_out = self.boundary == Some(Boundary::Whole);
        let beyond = facets.filter(|_| sticks_out);
        let beyond = beyond.map(|facets| [longer(smooth.unwrap_or(facets)), longer(facets)]);
        let references = References {
            smooth,
            facets,
            beyond: beyond.as_ref().map(|[smooth, facets]| [smooth, facets]),
            asked,
            ..References::default()
        };
        self.judge(mesh, references)
    }

    /// A check's figures in the unit in which its limit was typed.
    fn reading(&self, check: &Check, edge: f64, diagonal: Option<f64>) -> Option<Reading> {
        let planarity = self.planarity.filter(|q| !q.is_plain());
        let (typed, whole) = match (check.name, check.scale) {
            ("planarity", _) => (planarity?, edge),
            (_, Scale::Diagonals) => (self.max_deviation, diagonal?),
            _ => return None,
        };
        let (unit, length) = typed.unit(self.unit, whole);
        Some(Reading {
            unit: unit.to_owned(),
            limit: typed.value(),
            value: check.value_length? / length,
            across: None,
        })
    }

    /// The unit in which distances are told: that of the limit, where it was typed with one.
    pub fn shown(&self) -> (&'static str, f64) {
        match self.max_deviation.unit(self.unit, 1.0) {
            ("%", _) => (self.unit.name(), 1.0),
            unit => unit,
        }
    }

    /// A report of a command around what came of judging by these limits.
    pub fn report(&self, command: &'static str, assessment: Assessment) -> RunReport {
        RunReport {
            unit: self.unit.to_string(),
            // Text and numbers always become JSON.
            limits: serde_json::to_value(self).unwrap_or(Value::Null),
            ..RunReport::new(command, assessment)
        }
    }
}

/// Refuses distances of layers that the coordinates of a mesh can't hold: the layer would be the
/// mesh itself, or nowhere. `name` is that of the option.
///
/// # Errors
/// The first of them.
pub fn check_distances(name: &str, distances: &[f64], mesh: &HexMesh) -> Result<(), JobError> {
    let largest = mesh.positions.iter().map(|p| p.amax()).fold(0.0, f64::max);
    let range = 4.0 * f64::EPSILON * largest..=LARGEST_COORDINATE;
    let is_held = |d: &&f64| **d == 0.0 || range.contains(&d.abs());
    match distances.iter().find(|d| !is_held(d)) {
        None => Ok(()),
        Some(d) => Err(JobError::Input(format!(
            "{name} {d:e}: coordinates as large as {largest:.1e} hold distances from {:.1e} to {:e} (model units)",
            range.start(),
            range.end()
        ))),
    }
}
