//! The built-in shapes by name, their parameters and defaults.

use super::ShapeError;
use super::b_spline::BSplineHeights;
use super::domain::{Interval, ParameterDomain};
use super::ellipsoid::EllipsoidSurface;
use super::graph::{Graph, HeightField, MonkeySaddle, Paraboloid, Scherk, Wave};
use super::minimal::{Enneper, Helicoid};
use super::parametric::{ParametricSurface, PrincipalCurvatures, SurfaceJet};
use super::revolution::{Profile, Revolution};
use super::roof::Roof;
use crate::Vec3;
use std::f64::consts::{PI, TAU};
use std::fmt;
use std::sync::Arc;

/// A number that a shape is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeParameter {
    /// Name, kebab-case.
    pub name: &'static str,
    /// Value where nothing else is asked.
    pub default: f64,
    /// Smallest value allowed.
    pub min: f64,
    /// Largest value allowed.
    pub max: f64,
    /// Whether only whole numbers are allowed.
    pub integer: bool,
    /// What it is. Lengths are in the model's unit.
    pub meaning: &'static str,
}

/// What can be made under one name.
#[derive(Clone, Copy, Debug)]
pub struct ShapeInfo {
    /// Name, kebab-case.
    pub name: &'static str,
    /// One sentence.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [ShapeParameter],
    build: Build,
}

type Build = fn(&[f64]) -> Result<Arc<dyn ParametricSurface>, OutOfRange>;

/// A parameter whose limits follow from the others.
#[derive(Debug)]
struct OutOfRange {
    parameter: usize,
    min: f64,
    max: f64,
}

/// A built-in surface with its parameters filled in; cheap to clone.
#[derive(Clone)]
pub struct Shape {
    info: &'static ShapeInfo,
    values: Vec<f64>,
    surface: Arc<dyn ParametricSurface>,
}

impl Shape {
    /// Every shape there is.
    pub fn all() -> &'static [ShapeInfo] {
        &SHAPES
    }

    /// The shape called `name`, with `overrides` in place of the defaults of its parameters.
    ///
    /// # Errors
    /// An unknown name of a shape or parameter, a parameter given twice, or a value out of its
    /// range; the message lists what is allowed.
    pub fn from_name(name: &str, overrides: &[(&str, f64)]) -> Result<Self, ShapeError> {
        let info = SHAPES
            .iter()
            .find(|info| info.name == name)
            .ok_or_else(|| ShapeError::UnknownShape {
                name: name.to_owned(),
                known: join(SHAPES.iter().map(|info| info.name)),
            })?;
        let values = info.values(overrides)?;
        let surface = (info.build)(&values).map_err(|e| info.out_of_range(e, &values))?;
        Ok(Self {
            info,
            values,
            surface,
        })
    }

    /// Name, summary and parameters.
    pub fn info(&self) -> &'static ShapeInfo {
        self.info
    }

    /// The parameters' names and values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.info
            .parameters
            .iter()
            .zip(&self.values)
            .map(|(parameter, &value)| (parameter.name, value))
    }
}

impl fmt::Debug for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ", self.info.name)?;
        f.debug_map().entries(self.parameters()).finish()
    }
}

impl ShapeInfo {
    fn values(&self, overrides: &[(&str, f64)]) -> Result<Vec<f64>, ShapeError> {
        let mut values: Vec<f64> = self.parameters.iter().map(|p| p.default).collect();
        let mut given = vec![false; values.len()];
        for &(name, value) in overrides {
            let index = self.index_of(name)?;
            if std::mem::replace(&mut given[index], true) {
                return Err(ShapeError::RepeatedParameter {
                    shape: self.name,
                    parameter: self.parameters[index].name,
                });
            }
            self.check(index, value)?;
            values[index] = value;
        }
        Ok(values)
    }

    fn index_of(&self, name: &str) -> Result<usize, ShapeError> {
        let position = self.parameters.iter().position(|p| p.name == name);
        position.ok_or_else(|| ShapeError::UnknownParameter {
            shape: self.name,
            parameter: name.to_owned(),
            known: join(self.parameters.iter().map(|p| p.name)),
        })
    }

    fn check(&self, index: usize, value: f64) -> Result<(), ShapeError> {
        let parameter = &self.parameters[index];
        let (shape, name) = (self.name, parameter.name);
        if !(parameter.min..=parameter.max).contains(&value) {
            return Err(ShapeError::ParameterOutOfRange {
                shape,
                parameter: name,
                value,
                min: parameter.min,
                max: parameter.max,
            });
        }
        if parameter.integer && value.fract() != 0.0 {
            return Err(ShapeError::NotAWholeNumber {
                shape,
                parameter: name,
                value,
            });
        }
        Ok(())
    }

    fn out_of_range(&self, error: OutOfRange, values: &[f64]) -> ShapeError {
        ShapeError::ParameterOutOfRange {
            shape: self.name,
            parameter: self.parameters[error.parameter].name,
            value: values[error.parameter],
            min: error.min,
            max: error.max,
        }
    }
}

fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

impl ParametricSurface for Shape {
    fn domain(&self) -> ParameterDomain {
        self.surface.domain()
    }
    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        self.surface.jet(u, v)
    }
    fn normal(&self, u: f64, v: f64) -> Vec3 {
        self.surface.normal(u, v)
    }
    fn principal_curvatures(&self, u: f64, v: f64) -> PrincipalCurvatures {
        self.surface.principal_curvatures(u, v)
    }
    fn parameters_toward(&self, direction: Vec3) -> [f64; 2] {
        self.surface.parameters_toward(direction)
    }
}

/// A length that must be positive.
const fn length(name: &'static str, default: f64, meaning: &'static str) -> ShapeParameter {
    number(name, default, [1e-6, 1e6], meaning)
}

const fn number(
    name: &'static str,
    default: f64,
    [min, max]: [f64; 2],
    meaning: &'static str,
) -> ShapeParameter {
    ShapeParameter {
        name,
        default,
        min,
        max,
        integer: false,
        meaning,
    }
}

const fn integer(
    name: &'static str,
    default: f64,
    range: [f64; 2],
    meaning: &'static str,
) -> ShapeParameter {
    let mut parameter = number(name, default, range, meaning);
    parameter.integer = true;
    parameter
}

const EXPONENT: [f64; 2] = [2.0, 10.0];
/// Largest whole number below which every whole number is exact.
const MAX_SEED: f64 = 9_007_199_254_740_991.0;
/// Longest over shortest axis of an ellipsoid: beyond it, its triangles degenerate.
const MAX_AXIS_RATIO: f64 = 20.0;

static SHAPES: [ShapeInfo; 17] = [
    ShapeInfo {
        name: "plane",
        summary: "A flat rectangle.",
        parameters: &[
            length("width", 2.0, "side along x"),
            length("depth", 2.0, "side along y"),
        ],
        build: |p| graph(flat(), half_sizes(p[0], p[1])),
    },
    ShapeInfo {
        name: "sphere",
        summary: "A sphere.",
        parameters: &[length("radius", 1.0, "radius")],
        build: |p| ellipsoid([p[0]; 3]),
    },
    ShapeInfo {
        name: "ellipsoid",
        summary: "An ellipsoid with three different axes.",
        parameters: &[
            length("a", 1.5, "semi-axis along x"),
            length("b", 1.0, "semi-axis along y"),
            length("c", 0.7, "semi-axis along z"),
        ],
        build: |p| ellipsoid([p[0], p[1], p[2]]),
    },
    ShapeInfo {
        name: "cylinder",
        summary: "An open circular cylinder.",
        parameters: &[
            length("radius", 1.0, "radius"),
            length("height", 2.0, "height"),
        ],
        build: |p| line(p[0], p[0], p[1]),
    },
    ShapeInfo {
        name: "cone",
        summary: "An open frustum of a circular cone.",
        parameters: &[
            length("lower", 1.0, "radius at the bottom"),
            length("upper", 0.4, "radius at the top"),
            length("height", 1.5, "height"),
        ],
        build: |p| line(p[0], p[1], p[2]),
    },
    ShapeInfo {
        name: "torus",
        summary: "A torus of revolution: curvature of both signs, genus 1.",
        parameters: &[
            length("major", 1.0, "distance of the tube's centre from the axis"),
            length("minor", 0.4, "radius of the tube, at most 0.95 of major"),
        ],
        build: |p| torus(p[0], p[1]),
    },
    ShapeInfo {
        name: "catenoid",
        summary: "A catenoid: a minimal surface of revolution, open at both ends.",
        parameters: &[
            length("waist", 0.6, "smallest radius"),
            length("height", 1.6, "height, at most 6 of waist"),
        ],
        build: |p| catenoid(p[0], p[1]),
    },
    ShapeInfo {
        name: "hyperboloid",
        summary: "A one-sheet hyperboloid of revolution: a cooling tower, doubly ruled.",
        parameters: &[
            length("waist", 0.7, "smallest radius"),
            length("rim", 1.1, "radius at both ends, more than waist"),
            length("height", 2.0, "height"),
        ],
        build: |p| hyperboloid(p[0], p[1], p[2]),
    },
    ShapeInfo {
        name: "helicoid",
        summary: "A helicoid: a ruled minimal surface, a spiral ramp on both sides of its axis.",
        parameters: &[
            length("radius", 1.0, "distance of the rims from the axis"),
            length("pitch", 4.0, "height gained in one turn"),
            number("turns", 1.0, [0.05, 20.0], "number of turns"),
        ],
        build: |p| {
            Ok(Arc::new(Helicoid {
                radius: p[0],
                rise: p[1] / TAU,
                half_angle: PI * p[2],
            }))
        },
    },
    ShapeInfo {
        name: "enneper",
        summary: "Enneper's minimal surface over a disc small enough that it does not cut itself.",
        parameters: &[
            number(
                "radius",
                1.2,
                [0.05, 1.7],
                "radius of the disc of parameters (the surface cuts itself from 1.73 on)",
            ),
            length("scale", 1.0, "size factor"),
        ],
        build: |p| {
            Ok(Arc::new(Enneper {
                radius: p[0],
                scale: p[1],
            }))
        },
    },
    ShapeInfo {
        name: "scherk",
        summary: "Scherk's doubly periodic minimal surface over a part of one of its squares.",
        parameters: &[
            length("side", 1.8, "side of the part, at most 0.9 pi of scale"),
            length(
                "scale",
                1.0,
                "size factor: the surface repeats after pi times it",
            ),
        ],
        build: |p| {
            at_most(0, p[0], 0.9 * PI * p[1])?;
            graph(Scherk { scale: p[1] }, half_sizes(p[0], p[0]))
        },
    },
    ShapeInfo {
        name: "hyperbolic-paraboloid",
        summary: "A saddle z = (x^2 / a - y^2 / b) / 2 over a square.",
        parameters: &[
            length("a", 1.0, "radius of curvature at the centre along x"),
            length("b", 1.0, "radius of curvature at the centre along y"),
            length("side", 2.0, "side of the square"),
        ],
        build: |p| graph(paraboloid(1.0 / p[0], -1.0 / p[1]), half_sizes(p[2], p[2])),
    },
    ShapeInfo {
        name: "elliptic-paraboloid",
        summary: "A dome z = -(x^2 / a + y^2 / b) / 2 over a disc.",
        parameters: &[
            length("a", 1.2, "radius of curvature at the top along x"),
            length("b", 1.8, "radius of curvature at the top along y"),
            length("radius", 1.0, "radius of the disc"),
        ],
        build: |p| {
            graph(
                paraboloid(-1.0 / p[0], -1.0 / p[1]),
                ParameterDomain::superellipse(p[2], p[2], 2.0),
            )
        },
    },
    ShapeInfo {
        name: "monkey-saddle",
        summary: "A monkey saddle z ~ x^3 - 3 x y^2 over a disc: K < 0 but for one flat point.",
        parameters: &[
            length("radius", 1.0, "radius of the disc"),
            length("height", 0.3, "largest height above the centre"),
        ],
        build: |p| {
            let scale = p[1] / p[0].powi(3);
            graph(
                MonkeySaddle { scale },
                ParameterDomain::superellipse(p[0], p[0], 2.0),
            )
        },
    },
    ShapeInfo {
        name: "wave",
        summary: "An egg-crate z = 0.3 sin x + 0.2 sin y: hills, hollows, saddles and the parabolic curves between them.",
        parameters: &[
            length(
                "amplitude-x",
                0.3,
                "height of the wave along x, whose length is 2 pi",
            ),
            length(
                "amplitude-y",
                0.2,
                "height of the wave along y, whose length is 2 pi",
            ),
            number(
                "half-width",
                PI,
                [0.01, 1000.0],
                "half the side of the square",
            ),
        ],
        build: |p| {
            let wave = Wave {
                amplitude_x: p[0],
                amplitude_y: p[1],
            };
            graph(wave, half_sizes(2.0 * p[2], 2.0 * p[2]))
        },
    },
    ShapeInfo {
        name: "b-spline",
        summary: "A free-form patch: a bicubic B-spline with random control heights over a square.",
        parameters: &[
            length("side", 4.0, "side of the square"),
            integer("spans", 3.0, [1.0, 200.0], "polynomial pieces along a side"),
            number(
                "amplitude",
                0.8,
                [0.0, 1e6],
                "largest height of a control point above or below 0",
            ),
            integer("seed", 1.0, [0.0, MAX_SEED], "seed of the random heights"),
        ],
        build: |p| {
            let heights = BSplineHeights::random(p[0], p[1] as usize, p[2], p[3] as u64);
            graph(heights, half_sizes(p[0], p[0]))
        },
    },
    ShapeInfo {
        name: "roof",
        summary: "A free-form roof in metres: two halls with a saddle between them over a rounded plan.",
        parameters: &[
            length("length", 40.0, "extent along x"),
            length("width", 28.0, "extent along y"),
            length("height", 11.0, "height of the larger hall above z = 0"),
            number(
                "exponent",
                2.5,
                EXPONENT,
                "roundness of the plan: 2 is an ellipse, large ones approach a rectangle",
            ),
        ],
        build: |p| {
            let (half_length, half_width) = (0.5 * p[0], 0.5 * p[1]);
            let roof = Roof {
                half_length,
                half_width,
                height: p[2],
            };
            graph(
                roof,
                ParameterDomain::superellipse(half_length, half_width, p[3]),
            )
        },
    },
];

type ShapeResult = Result<Arc<dyn ParametricSurface>, OutOfRange>;

fn graph(height: impl HeightField + 'static, domain: ParameterDomain) -> ShapeResult {
    Ok(Arc::new(Graph { height, domain }))
}

fn paraboloid(curvature_x: f64, curvature_y: f64) -> Paraboloid {
    Paraboloid {
        curvature_x,
        curvature_y,
    }
}

fn flat() -> Paraboloid {
    paraboloid(0.0, 0.0)
}

fn half_sizes(width: f64, depth: f64) -> ParameterDomain {
    ParameterDomain::rectangle(
        Interval::symmetric(0.5 * width),
        Interval::symmetric(0.5 * depth),
    )
}

fn ellipsoid(semi_axes: [f64; 3]) -> ShapeResult {
    let semi_axes = Vec3::from(semi_axes);
    let (shortest, longest) = (semi_axes.min(), semi_axes.max());
    if longest > MAX_AXIS_RATIO * shortest {
        return Err(OutOfRange {
            parameter: semi_axes.imax(),
            min: shortest,
            max: MAX_AXIS_RATIO * shortest,
        });
    }
    Ok(Arc::new(EllipsoidSurface { semi_axes }))
}

fn revolution(profile: Profile) -> ShapeResult {
    Ok(Arc::new(Revolution(profile)))
}

fn line(lower: f64, upper: f64, height: f64) -> ShapeResult {
    revolution(Profile::Line {
        lower,
        upper,
        height,
    })
}

fn torus(major: f64, minor: f64) -> ShapeResult {
    at_most(1, minor, 0.95 * major)?;
    revolution(Profile::Circle { major, minor })
}

fn catenoid(waist: f64, height: f64) -> ShapeResult {
    at_most(1, height, 6.0 * waist)?;
    revolution(Profile::Catenary {
        waist,
        reach: 0.5 * height / waist,
    })
}

fn hyperboloid(waist: f64, rim: f64, height: f64) -> ShapeResult {
    at_most(0, waist, 0.99 * rim)?;
    let reach = (rim / waist).acosh();
    revolution(Profile::Hyperbola {
        waist,
        slope: 0.5 * height / reach.sinh(),
        reach,
    })
}

fn at_most(parameter: usize, value: f64, max: f64) -> Result<(), OutOfRange> {
    if value > max {
        return Err(OutOfRange {
            parameter,
            min: 1e-6,
            max,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(name: &str, overrides: &[(&str, f64)]) -> String {
        Shape::from_name(name, overrides).unwrap_err().to_string()
    }

    #[test]
    fn every_name_is_kebab_case_unique_and_builds_with_its_defaults() {
        for (i, info) in Shape::all().iter().enumerate() {
            assert!(
                info.name
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c == '-')
            );
            assert!(
                Shape::all()[..i]
                    .iter()
                    .all(|other| other.name != info.name)
            );
            assert!(info.summary.ends_with('.'));
            let shape = Shape::from_name(info.name, &[]).unwrap();
            for (parameter, (name, value)) in info.parameters.iter().zip(shape.parameters()) {
                assert_eq!((parameter.name, parameter.default), (name, value));
                assert!((parameter.min..=parameter.max).contains(&value));
            }
        }
    }

    #[test]
    fn overrides_change_the_surface() {
        let torus = Shape::from_name("torus", &[("minor", 0.25)]).unwrap();
        assert!((torus.point(0.0, 0.0).x - 1.25).abs() < 1e-15);
        assert_eq!(
            format!("{torus:?}"),
            r#"torus {"major": 1.0, "minor": 0.25}"#
        );
    }

    #[test]
    fn errors_name_what_is_wrong_and_what_is_allowed() {
        let unknown = message("tours", &[]);
        assert!(unknown.contains("tours") && unknown.contains("torus, catenoid"));
        let parameter = message("torus", &[("radius", 1.0)]);
        assert!(parameter.contains("radius") && parameter.contains("major, minor"));
        let range = message("enneper", &[("radius", 2.0)]);
        assert!(
            range.contains("radius")
                && range.contains('2')
                && range.contains("0.05")
                && range.contains("1.7")
        );
        let relative = message("torus", &[("minor", 1.5)]);
        assert!(
            relative.contains("minor") && relative.contains("1.5") && relative.contains("0.95")
        );
        assert!(message("b-spline", &[("spans", 2.5)]).contains("whole number"));
        assert!(message("torus", &[("minor", 0.3), ("minor", 0.2)]).contains("twice"));
    }

    #[test]
    fn values_that_are_no_length_are_refused() {
        for value in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            assert!(
                Shape::from_name("sphere", &[("radius", value)]).is_err(),
                "{value}"
            );
        }
        assert!(Shape::from_name("ellipsoid", &[("a", 100.0)]).is_err());
        assert!(Shape::from_name("hyperboloid", &[("rim", 0.5)]).is_err());
        assert!(Shape::from_name("catenoid", &[("height", 1e5)]).is_err());
    }
}
