//! What is wanted of a mesh: one list of settings for the command line and the job file.

use crate::error::JobError;
use crate::guides::GuideSettings;
use crate::input::read_text;
use crate::panel_limits::LimitSettings;
use crate::steering::SteeringSettings;
use crate::toml_text::{from_json, from_toml, table, with_meant};
use crate::units::{Quantity, Unit};
use phex::Boundary;
use phex::MeshOptions;
use phex::pipeline::{Effort, Method};
use phex::ranges::{self, BadOption};
use phex::smooth_surface::TargetKind;
use phex::symmetry::Symmetry;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Panels where neither a number nor a size is asked for.
const DEFAULT_PANELS: u64 = 500;
/// Largest deviation where nothing else is asked for.
pub const DEFAULT_DEVIATION: Quantity = Quantity::percent(0.5);

/// Settings of `phex mesh`; the names in a job file are those of the options.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct MeshSettings {
    /// Number of panels, about [default: 500, or as many as the largest sheet, edge or area asks
    /// for]
    #[cfg_attr(
        feature = "clap",
        arg(
            short = 'n',
            long,
            allow_negative_numbers = true,
            value_name = "N",
            conflicts_with = "edge_length"
        )
    )]
    pub panels: Option<u64>,
    /// Length of the edges between panels, about: `1.2`, `1.2m`, or `2%` of the bounding-box
    /// diagonal
    #[cfg_attr(
        feature = "clap",
        arg(long, allow_hyphen_values = true, value_name = "LENGTH")
    )]
    pub edge_length: Option<Quantity>,
    /// How panels are laid out [default: lattice]
    #[cfg_attr(feature = "clap", arg(long, value_enum))]
    pub method: Option<LayoutMethod>,
    /// How much is tried [default: normal]
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "LEVEL"))]
    pub effort: Option<TypedEffort>,
    /// Use the method where it is not made for the surface, to see what becomes of it
    #[cfg_attr(feature = "clap", arg(long))]
    pub any_domain: bool,
    /// Quadric of `projective-dual`: the ten numbers of the upper triangle of its symmetric matrix
    /// Q, row by row [default: the unit sphere about a centre away from all tangent planes]
    #[cfg_attr(feature = "clap", arg(long, value_name = "Q", value_parser = crate::number_lists::ten, allow_hyphen_values = true))]
    pub quadric: Option<[f64; 10]>,
    /// Hold back vertices where tangent planes meet badly (0.05 to 0.5), and leave planarity to the
    /// optimiser; for `tangent-planes`
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "X", value_parser = crate::steering::positive))]
    pub regularise: Option<f64>,
    /// Give all panels the mean curvature 0, for minimal surfaces; for `koebe`
    #[cfg_attr(feature = "clap", arg(long))]
    pub minimal: bool,
    /// Hexagons alone, as far as the surface allows: panels differ in size where pairs of a
    /// pentagon and a heptagon would even them out
    #[cfg_attr(feature = "clap", arg(long))]
    pub regular: bool,
    /// Turn the pattern by an angle in degrees from the one that curvature suggests
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "DEG", allow_negative_numbers = true)
    )]
    pub rotate: Option<f64>,
    /// Smaller panels where the surface is strongly curved (panel length times curvature stays
    /// below this, 0.4 without a number) or has two sheets near each other
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "C", num_args = 0..=1, default_missing_value = "0.4", value_parser = crate::steering::positive))]
    pub adaptive: Option<f64>,
    /// Lengths of the panels' edges from a text file: a number on each line for each vertex of the
    /// input, in its order; with --panels or --edge-length only their ratios count
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIZES.TXT"))]
    pub size_field: Option<PathBuf>,
    /// What happens at the boundary [default: snap; with `koebe`: whole]
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "HOW"))]
    pub boundary: Option<AtBoundary>,
    /// Symmetries of the surface that the panels have, too: `auto` for all mirror planes that are
    /// found, one `mirror` plane, or N for rotations by a turn over N about an axis in mirror
    /// planes [default: none]
    #[cfg_attr(feature = "clap", arg(long, value_name = "auto|none|mirror|N"))]
    pub symmetry: Option<Symmetry>,
    /// Make as many edges equal as can be within a length: `5mm`, or `0.02%` of the bounding-box
    /// diagonal; vertices move along the surface, and within all limits
    #[cfg_attr(
        feature = "clap",
        arg(long, allow_hyphen_values = true, value_name = "LENGTH")
    )]
    pub repeat: Option<Quantity>,
    /// Surface that the panels are kept close to [default: smooth]
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "KIND"))]
    pub target: Option<CloseTo>,
    /// Largest distance to the surface: `20mm`, or `0.5%` of the bounding-box diagonal [default:
    /// 0.5%]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "LENGTH",
            help_heading = "Tolerances"
        )
    )]
    pub max_deviation: Option<Quantity>,
    /// Largest distance of a corner to its panel's plane: a number is mean edges, `0.1mm` a length
    /// [default: 1e-12, or rounding]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "X",
            help_heading = "Tolerances"
        )
    )]
    pub planarity: Option<Quantity>,
    /// Unit of the model's coordinates [default: m]
    #[cfg_attr(feature = "clap", arg(long, value_enum))]
    pub unit: Option<Unit>,
    /// Mesh every connected part of a surface that has several, even crumbs with less than a
    /// thousandth of the area of the largest one, which are left out otherwise
    #[cfg_attr(feature = "clap", arg(long))]
    pub all_components: bool,
    /// Seed of every random choice [default: 0]
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true))]
    pub seed: Option<u64>,
    /// Number of threads; the result does not depend on it [default: all cores]
    #[cfg_attr(feature = "clap", arg(short, long, value_parser = clap::value_parser!(u16).range(1..)))]
    pub threads: Option<u16>,
    /// What is held, and the dials; in a job file the table `[steering]`.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(deserialize_with = "table")]
    pub steering: SteeringSettings,
    /// Lines that rows run along, and cones; in a job file the table `[guides]`.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(deserialize_with = "table")]
    pub guides: GuideSettings,
    /// What a workshop can make; in a job file the table `[limits]`.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(deserialize_with = "table")]
    pub limits: LimitSettings,
    /// Options of every stage; in a job file only, as the table `[stages]` with a table for each of
    /// them.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(deserialize_with = "table")]
    pub stages: MeshOptions,
}

/// How panels are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum LayoutMethod {
    /// A hexagonal lattice, on any surface
    Lattice,
    /// As `lattice` with `--effort best`
    #[cfg_attr(feature = "clap", value(hide = true))]
    Best,
    /// A brick wall on the lines of curvature, where the surface has a network of them without
    /// singular points
    BrickWall,
    /// A Goldberg polyhedron; for spheres, ellipsoids and pieces of them
    PowerDiagram,
    /// A regular triangulation of the dual surface, mapped back; for Gauss curvature of one sign
    ProjectiveDual,
    /// A coarse mesh refined by the butterfly rule through its dual; for Gauss curvature of one
    /// sign
    DualSubdivision,
    /// Tangent planes over a regular triangulation of the Gauss sphere; for Gauss curvature of one
    /// sign
    SupportFunction,
    /// Tangent planes of the lattice's panels, intersected
    TangentPlanes,
    /// A mesh parallel to one that tangent planes give, fitted; for Gauss curvature of one sign
    Parallel,
    /// Panels with offsets at constant edge distance: a lattice on the Gauss sphere, its Koebe
    /// mesh, and the mesh parallel to it, fitted; for Gauss curvature of one sign and a Gauss map
    /// that is one to one
    Koebe,
}

impl LayoutMethod {
    /// All methods.
    pub const ALL: [Self; 10] = [
        Self::Lattice,
        Self::Best,
        Self::BrickWall,
        Self::PowerDiagram,
        Self::ProjectiveDual,
        Self::DualSubdivision,
        Self::SupportFunction,
        Self::TangentPlanes,
        Self::Parallel,
        Self::Koebe,
    ];
}

impl From<LayoutMethod> for Method {
    fn from(layout: LayoutMethod) -> Self {
        match layout {
            LayoutMethod::Lattice | LayoutMethod::Best => Self::Lattice,
            LayoutMethod::BrickWall => Self::BrickWall,
            LayoutMethod::ProjectiveDual => Self::ProjectiveDual,
            LayoutMethod::SupportFunction => Self::SupportFunction,
            LayoutMethod::TangentPlanes => Self::TangentPlanes,
            LayoutMethod::PowerDiagram => Self::PowerDiagram,
            LayoutMethod::DualSubdivision => Self::DualSubdivision,
            LayoutMethod::Parallel => Self::Parallel,
            LayoutMethod::Koebe => Self::Koebe,
        }
    }
}

impl From<Method> for LayoutMethod {
    fn from(method: Method) -> Self {
        match method {
            Method::Lattice => Self::Lattice,
            Method::BrickWall => Self::BrickWall,
            Method::ProjectiveDual => Self::ProjectiveDual,
            Method::SupportFunction => Self::SupportFunction,
            Method::TangentPlanes => Self::TangentPlanes,
            Method::PowerDiagram => Self::PowerDiagram,
            Method::DualSubdivision => Self::DualSubdivision,
            Method::Parallel => Self::Parallel,
            Method::Koebe => Self::Koebe,
        }
    }
}

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum TypedEffort {
    /// One lattice and one pass, judged and not searched: a first picture
    Draft,
    /// The most regular of a few lattices, another where it may be better, and a search where
    /// something is wrong
    Normal,
    /// All ways of the portfolio side by side, lattices and a brick wall; the best is searched, and
    /// the next one while something is outside limits
    Best,
}

impl From<TypedEffort> for Effort {
    fn from(effort: TypedEffort) -> Self {
        match effort {
            TypedEffort::Draft => Self::Draft,
            TypedEffort::Normal => Self::Normal,
            TypedEffort::Best => Self::Best,
        }
    }
}

impl From<Effort> for TypedEffort {
    fn from(effort: Effort) -> Self {
        match effort {
            Effort::Draft => Self::Draft,
            Effort::Normal => Self::Normal,
            Effort::Best => Self::Best,
        }
    }
}

/// What happens at the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum AtBoundary {
    /// Whole panels of a lattice that goes on beyond the boundary
    Whole,
    /// Such panels, clipped by the boundary curve
    Clip,
    /// A row of panels along the boundary, with vertices on it
    Snap,
}

impl From<AtBoundary> for Boundary {
    fn from(how: AtBoundary) -> Self {
        match how {
            AtBoundary::Whole => Self::Whole,
            AtBoundary::Clip => Self::Clip,
            AtBoundary::Snap => Self::Snap,
        }
    }
}

/// Which surface the panels are kept close to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum CloseTo {
    /// The smooth surface through the input's vertices
    Smooth,
    /// Between the smooth surface and the facets
    HalfWay,
    /// The input's facets
    Facets,
}

impl From<CloseTo> for TargetKind {
    fn from(kind: CloseTo) -> Self {
        match kind {
            CloseTo::Smooth => Self::Smooth,
            CloseTo::HalfWay => Self::HalfWay,
            CloseTo::Facets => Self::Facets,
        }
    }
}

/// How fine the panelling is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TypedPanelSize {
    /// Number of panels.
    Panels(u64),
    /// Length of their edges.
    EdgeLength(Quantity),
}

/// An error of reading settings, with what is meant by an unknown key.
fn with_meant_key(error: JobError) -> JobError {
    let all = serde_json::to_value(MeshSettings::default());
    with_meant(error, &all.unwrap_or_default())
}

impl MeshSettings {
    /// Settings of a job file.
    ///
    /// # Errors
    /// If the file can't be read, is no TOML, or sets something unknown.
    pub fn from_file(path: &Path) -> Result<Self, JobError> {
        let settings = Self::from_toml(&read_text(path)?);
        settings.map_err(|e| JobError::input(format!("{}: {e}", path.display())))
    }

    /// Settings of the text of a job file.
    ///
    /// # Errors
    /// As [`from_toml`], or if two settings exclude each other.
    pub fn from_toml(text: &str) -> Result<Self, JobError> {
        let settings: Self = from_toml(text).map_err(with_meant_key)?;
        settings.check_job().map(|()| settings)
    }

    /// Settings of a value, as those of a table of a study file.
    ///
    /// # Errors
    /// As [`from_json`].
    pub fn from_json(value: serde_json::Value) -> Result<Self, JobError> {
        from_json(value).map_err(with_meant_key)
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        (self.steering.inputs())
            .chain(self.guides.inputs())
            .chain(self.size_field.as_deref())
    }

    /// Refuses what a job file can't say.
    ///
    /// # Errors
    /// If two settings exclude each other, or one stands where it has no effect.
    pub fn check_job(&self) -> Result<(), JobError> {
        if self.panels.is_some() && self.edge_length.is_some() {
            return Err(JobError::input(
                "`panels` and `edge-length` exclude each other",
            ));
        }
        if self.stages.size != MeshOptions::default().size {
            return Err(JobError::input(
                "`size` has no effect in `[stages]`: write `panels` or `edge-length` before all tables",
            ));
        }
        if self.stages.optimise.max_deviation.is_some() {
            return Err(JobError::input(
                "`max_deviation` has no effect in `[stages.optimise]`: write `max-deviation` before all tables",
            ));
        }
        let tolerance = MeshOptions::default().optimise.planarity_tolerance;
        if self.stages.optimise.planarity_tolerance != tolerance {
            return Err(JobError::input(
                "`planarity_tolerance` has no effect in `[stages.optimise]`: write `planarity` before all tables",
            ));
        }
        if self.stages.repeat_rel.is_some() {
            return Err(JobError::input(
                "`repeat_rel` has no effect in `[stages]`: write `repeat` before all tables",
            ));
        }
        if !self.stages.optimise.panels.is_empty() {
            return Err(JobError::input(
                "`panels` has no effect in `[stages.optimise]`: write a table `[limits]`",
            ));
        }
        Ok(())
    }

    /// Refuses numbers that are not finite or out of their ranges, wherever they were set.
    ///
    /// # Errors
    /// The first of them, by its name.
    pub fn check(&self) -> Result<(), JobError> {
        self.limits.check(self.unit())?;
        let own = || -> Result<(), BadOption> {
            ranges::within(-360.0..=360.0, &[("rotate", self.rotate.unwrap_or(0.0))])?;
            ranges::positive(&[
                ("adaptive", self.adaptive.unwrap_or(1.0)),
                ("regularise", self.regularise.unwrap_or(1.0)),
                ("repeat", self.repeat.map_or(1.0, Quantity::value)),
            ])?;
            ranges::below(180.0, &[("crease", self.guides.crease.unwrap_or(90.0))])?;
            self.steering.check()?;
            self.options(1).check().map_err(|e| e.in_table("stages"))
        };
        own().map_err(JobError::input)
    }

    /// These settings, and those of `file` where these say nothing.
    pub fn over(self, file: Self) -> Self {
        let sized = self.is_sized();
        Self {
            panels: if sized { self.panels } else { file.panels },
            edge_length: if sized {
                self.edge_length
            } else {
                file.edge_length
            },
            method: self.method.or(file.method),
            effort: self.effort.or(file.effort),
            any_domain: self.any_domain || file.any_domain,
            quadric: self.quadric.or(file.quadric),
            regularise: self.regularise.or(file.regularise),
            minimal: self.minimal || file.minimal,
            regular: self.regular || file.regular,
            rotate: self.rotate.or(file.rotate),
            adaptive: self.adaptive.or(file.adaptive),
            size_field: self.size_field.or(file.size_field),
            boundary: self.boundary.or(file.boundary),
            symmetry: self.symmetry.or(file.symmetry),
            repeat: self.repeat.or(file.repeat),
            target: self.target.or(file.target),
            max_deviation: self.max_deviation.or(file.max_deviation),
            planarity: self.planarity.or(file.planarity),
            unit: self.unit.or(file.unit),
            all_components: self.all_components || file.all_components,
            seed: self.seed.or(file.seed),
            threads: self.threads.or(file.threads),
            steering: self.steering.over(file.steering),
            guides: self.guides.over(file.guides),
            limits: self.limits.over(file.limits),
            stages: file.stages,
        }
    }

    /// Whether a number or a length says how fine the panelling is to be.
    pub fn is_sized(&self) -> bool {
        self.panels.is_some() || self.edge_length.is_some()
    }

    /// How fine the panelling is to be.
    pub fn size(&self) -> TypedPanelSize {
        match self.edge_length {
            Some(length) => TypedPanelSize::EdgeLength(length),
            None => TypedPanelSize::Panels(self.panels.unwrap_or(DEFAULT_PANELS)),
        }
    }

    /// The unit of the model's coordinates.
    pub fn unit(&self) -> Unit {
        self.unit.unwrap_or_default()
    }

    /// The largest deviation.
    pub fn max_deviation(&self) -> Quantity {
        self.max_deviation.unwrap_or(DEFAULT_DEVIATION)
    }

    /// The options of the stages for a number of panels.
    pub fn options(&self, panels: u64) -> MeshOptions {
        let mut options = self.stages.clone();
        options.size = phex::PanelSize::Panels(usize::try_from(panels).unwrap_or(usize::MAX));
        if let Some(method) = self.method {
            options.method = method.into();
        }
        if self.method == Some(LayoutMethod::Best) {
            options.effort = Effort::Best;
        }
        if let Some(effort) = self.effort {
            options.effort = effort.into();
        }
        options.dual.any_domain |= self.any_domain;
        if self.quadric.is_some() {
            options.dual.quadric = self.quadric;
        }
        if let Some(x) = self.regularise {
            options.dual.regularisation = x;
        }
        options.dual.minimal |= self.minimal;
        options.regular |= self.regular;
        if let Some(degrees) = self.rotate {
            options.directions.rotate = degrees.to_radians();
        }
        if self.adaptive.is_some() {
            options.sizes.adaptive = self.adaptive;
        }
        match self.boundary {
            Some(how) => options.boundary = how.into(),
            // Where a job file names nothing else, either.
            None if options.method == Method::Koebe && options.boundary == Boundary::default() => {
                options.boundary = Boundary::Whole;
            }
            None => {}
        }
        if let Some(symmetry) = self.symmetry {
            options.symmetry = symmetry;
        }
        if let Some(kind) = self.target {
            options.target.kind = kind.into();
        }
        if let Some(seed) = self.seed {
            options.layout.seed = seed;
        }
        options
    }

    /// The settings with every default filled in, for the report; `panels` is the number that the
    /// size means.
    pub fn complete(&self, panels: u64) -> Self {
        let stages = self.options(panels);
        Self {
            panels: Some(panels),
            method: Some(stages.method.into()),
            effort: Some(stages.effort.into()),
            rotate: Some(stages.directions.rotate.to_degrees()),
            max_deviation: Some(self.max_deviation()),
            unit: Some(self.unit()),
            seed: Some(stages.layout.seed),
            stages,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_comes_before_the_file() {
        let file: MeshSettings = toml::from_str(
            "edge-length = '80cm'\nseed = 7\nrotate = 15\nmax-deviation = 0.02\nunit = 'mm'",
        )
        .unwrap();
        let typed = MeshSettings {
            panels: Some(300),
            seed: Some(1),
            ..Default::default()
        };
        let both = typed.over(file.clone());
        assert_eq!(
            both.size(),
            TypedPanelSize::Panels(300),
            "a size on the command line replaces either kind in the file"
        );
        assert_eq!(
            (both.seed, both.rotate, both.unit),
            (Some(1), Some(15.0), Some(Unit::Mm))
        );
        let size = MeshSettings::default().over(file).size();
        assert_eq!(size, TypedPanelSize::EdgeLength("80cm".parse().unwrap()));
    }

    #[test]
    fn options_of_a_stage_come_from_the_file_and_give_way_to_the_command_line() {
        let file: MeshSettings = toml::from_str("[stages.layout]\nseed = 4\nsweeps = 3").unwrap();
        let options = MeshSettings {
            rotate: Some(90.0),
            ..Default::default()
        }
        .over(file.clone())
        .options(77);
        assert_eq!((options.layout.seed, options.layout.sweeps), (4, 3));
        assert_eq!(options.size, phex::PanelSize::Panels(77));
        assert!((options.directions.rotate - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        let typed = MeshSettings {
            seed: Some(9),
            ..Default::default()
        }
        .over(file);
        assert_eq!(
            (typed.options(1).layout.seed, typed.complete(1).seed),
            (9, Some(9))
        );
    }

    #[test]
    fn unknown_names_in_a_file_are_refused() {
        assert!(toml::from_str::<MeshSettings>("pannels = 3").is_err());
    }
}
