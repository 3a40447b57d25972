//! Steering as it is typed: which vertices are held, and the dials of the optimiser.

use crate::error::JobError;
use crate::input::{number, read_polylines, read_some_numbers};
use phex::optimise::{Anchor, Dials, GroundPlane, OptimiseOptions, Solver, Steering};
use phex::ranges::{self, BadOption};
use phex_mesh::LARGEST_COORDINATE;
use phex_mesh::io::shown;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What is held, and the dials; in a job file, the table `[steering]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct SteeringSettings {
    /// Fix vertices: a text file with `x y z` on a line (the nearest vertex is moved there) or a
    /// vertex number, from 0 (it stays)
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "POINTS.TXT", help_heading = "Steering")
    )]
    pub fix: Option<PathBuf>,
    /// Let vertices of the boundary slide on the polylines of an OBJ file that are within half an
    /// edge
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "CURVE.OBJ", help_heading = "Steering")
    )]
    pub curve: Option<PathBuf>,
    /// Keep vertices of the boundary in a plane: level at the lowest one, level at `Z`, or through
    /// `X,Y,Z` with normal `NX,NY,NZ`
    #[cfg_attr(feature = "clap", arg(
        long,
        value_name = "Z|X,Y,Z,NX,NY,NZ",
        num_args = 0..=1,
        default_missing_value = "lowest",
        allow_negative_numbers = true,
        help_heading = "Steering"
    ))]
    pub ground: Option<TypedPlane>,
    /// How far from the ground plane vertices of the boundary may lie to be put in it, mean edges
    /// [default: 0.5, or less: no farther than the largest deviation]
    #[cfg_attr(feature = "clap", arg(long, value_name = "X", value_parser = not_negative, help_heading = "Steering"))]
    pub ground_reach: Option<f64>,
    /// Pull the nearest vertices towards points: a text file with `x y z`, or `x y z weight`, on a
    /// line (weight 1 is that of the surface)
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "POINTS.TXT", help_heading = "Steering")
    )]
    pub anchors: Option<PathBuf>,
    /// More than 1: panels more like their neighbours, less than 1: freer ones
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "X", value_parser = positive, help_heading = "Steering"))]
    pub fairness: Option<f64>,
    /// More than 1: nearer to surface and boundary
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "X", value_parser = positive, help_heading = "Steering"))]
    pub closeness: Option<f64>,
    /// More than 1: more room between the corners and edges of a panel
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "X", value_parser = positive, help_heading = "Steering"))]
    pub clearance: Option<f64>,
    /// Less than 1: corners nearer to the surface, centres of panels farther; 0: the corners lie on
    /// it
    #[cfg_attr(feature = "clap", arg(long, value_name = "X", value_parser = not_negative, help_heading = "Steering"))]
    pub centres: Option<f64>,
    /// How panels are made planar [default: barrier]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_enum, value_name = "METHOD", help_heading = "Steering")
    )]
    pub solver: Option<TypedSolver>,
}

/// How panels are made planar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum TypedSolver {
    /// Distances to the panels' planes, with a barrier that keeps panels simple
    Barrier,
    /// The paper's: volumes of all four corners of a panel, penalised; nothing keeps panels simple;
    /// for comparison
    Tetrahedra,
}

/// A ground plane as it is typed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub enum TypedPlane {
    /// Level, at the lowest vertex of the boundary.
    Lowest,
    /// Level, at a height.
    Level(f64),
    /// Through a point with a normal.
    Through([f64; 6]),
}

impl FromStr for TypedPlane {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "lowest" {
            return Ok(Self::Lowest);
        }
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| number(n.trim())).collect();
        match numbers.unwrap_or_default()[..] {
            [z] => Ok(Self::Level(z)),
            [x, y, z, a, b, c] => Ok(Self::Through([x, y, z, a, b, c])),
            _ => Err(format!(
                "`{}` is no plane: give `lowest`, Z or X,Y,Z,NX,NY,NZ, each number up to {LARGEST_COORDINATE:e}",
                shown(text)
            )),
        }
    }
}

impl TryFrom<String> for TypedPlane {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<TypedPlane> for String {
    fn from(plane: TypedPlane) -> Self {
        match plane {
            TypedPlane::Lowest => "lowest".to_owned(),
            TypedPlane::Level(z) => z.to_string(),
            TypedPlane::Through(n) => n.map(|x| x.to_string()).join(","),
        }
    }
}

/// A number above 0 as it is typed.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is not a positive number")),
    }
}

#[cfg(feature = "clap")]
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is negative or no number")),
    }
}

/// Holds a vertex, by its number, or the one nearest to a point.
///
/// # Errors
/// What is wanted instead.
pub(crate) fn add_fixed(steering: &mut Steering, numbers: &[f64]) -> Result<(), &'static str> {
    match *numbers {
        [x, y, z] => steering.fixed_points.push([x, y, z]),
        [v] if v >= 0.0 && v.fract() == 0.0 && v <= f64::from(u32::MAX) => {
            steering.fixed_vertices.push(v as u32);
        }
        _ => return Err("a vertex number or x y z"),
    }
    Ok(())
}

/// Pulls the nearest vertex to a point.
///
/// # Errors
/// What is wanted instead.
pub(crate) fn add_anchor(steering: &mut Steering, numbers: &[f64]) -> Result<(), &'static str> {
    let (point, weight) = match *numbers {
        [x, y, z] => ([x, y, z], 1.0),
        [x, y, z, weight] if weight > 0.0 => ([x, y, z], weight),
        _ => return Err("x y z, or x y z weight with a weight above 0,"),
    };
    steering.anchors.push(Anchor { point, weight });
    Ok(())
}

impl SteeringSettings {
    /// These settings, and those of `file` where these say nothing.
    pub fn over(self, file: Self) -> Self {
        Self {
            fix: self.fix.or(file.fix),
            curve: self.curve.or(file.curve),
            ground: self.ground.or(file.ground),
            ground_reach: self.ground_reach.or(file.ground_reach),
            anchors: self.anchors.or(file.anchors),
            fairness: self.fairness.or(file.fairness),
            closeness: self.closeness.or(file.closeness),
            clearance: self.clearance.or(file.clearance),
            centres: self.centres.or(file.centres),
            solver: self.solver.or(file.solver),
        }
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let files = [&self.fix, &self.curve, &self.anchors];
        files.into_iter().flatten().map(PathBuf::as_path)
    }

    /// Adds what is held, `given` among it, and turns the dials; once for each set of options.
    pub fn apply(&self, given: Steering, steering: &mut Steering, options: &mut OptimiseOptions) {
        steering.fixed_points.extend(given.fixed_points);
        steering.fixed_vertices.extend(given.fixed_vertices);
        steering.curves.extend(given.curves);
        steering.anchors.extend(given.anchors);
        steering.grounds.extend(given.grounds);
        steering.grounds.extend(self.ground.map(|g| self.plane(g)));
        self.dials().turn(options);
        match self.solver {
            Some(TypedSolver::Barrier) => options.solver = Solver::Barrier,
            Some(TypedSolver::Tetrahedra) => options.solver = Solver::Tetrahedra,
            None => {}
        }
    }

    /// Whether a dial stands at a number.
    pub fn has_dials(&self) -> bool {
        let dials = [self.fairness, self.closeness, self.clearance, self.centres];
        dials.iter().any(Option::is_some)
    }

    /// Refuses numbers out of their ranges.
    ///
    /// # Errors
    /// The first of them, by its name.
    pub fn check(&self) -> Result<(), BadOption> {
        ranges::not_negative(&[("ground-reach", self.ground_reach.unwrap_or(0.0))])?;
        self.dials().check()
    }

    fn dials(&self) -> Dials {
        Dials {
            fairness: self.fairness.unwrap_or(1.0),
            closeness: self.closeness.unwrap_or(1.0),
            clearance: self.clearance.unwrap_or(1.0),
            centres: self.centres.unwrap_or(1.0),
        }
    }

    /// What the files hold.
    ///
    /// # Errors
    /// If one can't be read or a line of it is wrong.
    pub fn read(&self) -> Result<Steering, JobError> {
        let mut steering = Steering::default();
        if let Some(path) = &self.fix {
            for line in read_some_numbers(path)? {
                add_fixed(&mut steering, &line.numbers).map_err(|wanted| line.wrong(wanted))?;
            }
        }
        if let Some(path) = &self.curve {
            let curves = read_polylines(path)?;
            if curves.is_empty() {
                let name = path.display();
                return Err(JobError::input(format!(
                    "{name}: it holds no polyline (a line `l 1 2 3`)"
                )));
            }
            let line = |curve: Vec<_>| curve.into_iter().map(Into::into).collect();
            steering.curves.extend(curves.into_iter().map(line));
        }
        if let Some(path) = &self.anchors {
            for line in read_some_numbers(path)? {
                add_anchor(&mut steering, &line.numbers).map_err(|wanted| line.wrong(wanted))?;
            }
        }
        Ok(steering)
    }

    fn plane(&self, typed: TypedPlane) -> GroundPlane {
        let mut ground = GroundPlane::default();
        match typed {
            TypedPlane::Lowest => {}
            TypedPlane::Level(z) => ground.point = Some([0.0, 0.0, z]),
            TypedPlane::Through([x, y, z, a, b, c]) => {
                (ground.point, ground.normal) = (Some([x, y, z]), [a, b, c]);
            }
        }
        ground.reach = self.ground_reach;
        ground
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_typed_in_three_ways() {
        assert_eq!("lowest".parse(), Ok(TypedPlane::Lowest));
        assert_eq!("-2.5".parse(), Ok(TypedPlane::Level(-2.5)));
        let through = TypedPlane::Through([1.0, 2.0, 3.0, 0.0, 1.0, 0.0]);
        assert_eq!("1, 2,3,0,1,0".parse(), Ok(through));
        assert_eq!(String::from(through).parse(), Ok(through));
        for wrong in ["", "1,2", "up", "nan", "1,2,3,4,5,inf"] {
            assert!(wrong.parse::<TypedPlane>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_job_file_holds_the_same_names() {
        let settings: SteeringSettings = toml::from_str(
            "fix = 'a.txt'\nground = '0'\nground-reach = 1\ncloseness = 3\ncentres = 0",
        )
        .unwrap();
        assert_eq!(settings.ground, Some(TypedPlane::Level(0.0)));
        let mut options = OptimiseOptions::default();
        settings.dials().turn(&mut options);
        assert_eq!(options.vertex_closeness, 3.0);
        assert_eq!(options.centre_closeness, 0.0);
        let default = OptimiseOptions::default();
        let barrier = options.barrier * options.vertex_closeness;
        assert!(
            (barrier - default.barrier).abs() < 1e-15,
            "the barrier itself stays"
        );
        for (clearance, reach) in [(1.0 / 256.0, 0.15), (256.0, 0.45)] {
            let mut options = OptimiseOptions::default();
            let settings = SteeringSettings {
                clearance: Some(clearance),
                ..SteeringSettings::default()
            };
            settings.dials().turn(&mut options);
            assert!((options.barrier_reach - reach).abs() < 1e-15);
        }
        assert!(toml::from_str::<SteeringSettings>("ground = 'up'").is_err());
        assert!(toml::from_str::<SteeringSettings>("fixed = 'a.txt'").is_err());
    }
}
