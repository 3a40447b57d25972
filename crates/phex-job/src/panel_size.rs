//! Whether panels of the size that is asked for make sense on a surface.

use crate::error::JobError;
use crate::hexagon::{edge_length, hexagon_area};
use crate::settings::TypedPanelSize;
use crate::units::{Unit, four_digits};
use phex::layout::MAX_PANELS;
use phex_mesh::TriangleSurface;

/// Smallest edge, in units of the rounding of the largest coordinate: below, a panel's shape is
/// noise.
const LEAST_EDGE_ULPS: f64 = 1e4;

/// The number of panels that a size means on a surface.
///
/// # Errors
/// If it is none, more than [`MAX_PANELS`], or so many that double precision can't hold their
/// shapes.
pub fn panels(
    size: TypedPanelSize,
    surface: &TriangleSurface,
    unit: Unit,
) -> Result<u64, JobError> {
    let panels = match size {
        TypedPanelSize::Panels(0) => {
            return Err(JobError::input("--panels 0: at least one panel is needed"));
        }
        TypedPanelSize::Panels(panels) => panels,
        TypedPanelSize::EdgeLength(length) => {
            let edge = length.length(unit, surface.diagonal());
            of_edge(edge, surface.area()).map_err(|cause| {
                let doubt = unit.doubted(surface.diagonal());
                let doubt = doubt.map_or_else(String::new, |told| format!("; {told}"));
                JobError::input(format!("--edge-length {length}: {cause}{doubt}"))
            })?
        }
    };
    checked(panels, surface)
}

/// The number of panels with edges of a length that cover an area, or what is wrong with it.
fn of_edge(edge: f64, area: f64) -> Result<u64, String> {
    if edge == 0.0 {
        return Err("the length must be positive".to_owned());
    }
    let panels = (area / hexagon_area(edge)).round();
    if panels < 1.0 {
        return Err("less than one panel fits on the surface".to_owned());
    }
    if panels > MAX_PANELS as f64 {
        let needed = match panels {
            0.0..1e15 => panels.to_string(),
            _ => "more than 1e15".to_owned(),
        };
        return Err(format!(
            "{needed} panels would be needed, and at most {MAX_PANELS} make sense"
        ));
    }
    Ok(panels as u64)
}

/// The number of panels of a mean area that a limit asks for.
///
/// # Errors
/// As [`panels`].
pub fn of_limit(
    (area, limit): (f64, &str),
    surface: &TriangleSurface,
    unit: Unit,
) -> Result<u64, JobError> {
    let panels = (surface.area() / area).ceil();
    if panels > MAX_PANELS as f64 {
        let across = four_digits(surface.diagonal());
        return Err(JobError::input(format!(
            "{limit} asks for {} panels on a surface that is {across} {unit} across, and at most {MAX_PANELS} make sense: \
             is the unit right, of the model and of {limit}?",
            four_digits(panels)
        )));
    }
    checked(panels as u64, surface)
}

/// A number of panels, if it makes sense on a surface.
///
/// # Errors
/// As [`panels`].
pub fn checked(panels: u64, surface: &TriangleSurface) -> Result<u64, JobError> {
    check_count(panels)?;
    check_precision(panels, surface.area(), surface)?;
    Ok(panels)
}

fn check_count(panels: u64) -> Result<(), JobError> {
    if panels <= MAX_PANELS as u64 {
        return Ok(());
    }
    Err(JobError::input(format!(
        "{panels} panels are asked for, at most {MAX_PANELS} make sense"
    )))
}

fn check_precision(panels: u64, area: f64, surface: &TriangleSurface) -> Result<(), JobError> {
    let largest = surface
        .positions()
        .iter()
        .map(|p| p.amax())
        .fold(0.0, f64::max);
    let least = LEAST_EDGE_ULPS * f64::EPSILON * largest;
    let edge = edge_length(area / panels as f64);
    if edge >= least {
        return Ok(());
    }
    Err(JobError::input(format!(
        "{panels} panels would have edges of {edge:.1e}, but coordinates as large as {largest:.1e} hold shapes only \
         down to {least:.1e}: ask for fewer panels, or move the model to the origin"
    )))
}

/// Shares of `panels` in proportion to areas, each at least one.
pub fn shares(panels: u64, areas: &[f64]) -> Vec<u64> {
    let total: f64 = areas.iter().sum();
    areas
        .iter()
        .map(|area| ((panels as f64 * area / total).round() as u64).max(1))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// A square of side 10 whose corner lies at a distance from the origin.
    fn square(offset: f64) -> TriangleSurface {
        let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
        let positions = corners
            .iter()
            .map(|&(x, y)| Vec3::new(x + offset, y, 0.0))
            .collect();
        TriangleSurface::new(positions, &[[0, 1, 2], [0, 2, 3]]).unwrap()
    }

    fn message(size: TypedPanelSize, offset: f64) -> String {
        panels(size, &square(offset), Unit::M)
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn edge_length_becomes_a_number_of_panels() {
        let count = |text: &str| {
            panels(
                TypedPanelSize::EdgeLength(text.parse().unwrap()),
                &square(0.0),
                Unit::M,
            )
            .unwrap()
        };
        assert_eq!(count("1m"), 38);
        assert_eq!(count("100cm"), 38);
        assert_eq!(count("7.0710678118654755%"), 38);
    }

    #[test]
    fn senseless_sizes_are_refused() {
        assert!(message(TypedPanelSize::Panels(0), 0.0).contains("--panels 0"));
        assert!(message(TypedPanelSize::Panels(MAX_PANELS as u64 + 1), 0.0).contains("at most"));
        assert!(message(TypedPanelSize::Panels(1000), 1e12).contains("move the model"));
    }

    #[test]
    fn a_limit_that_asks_for_too_many_panels_is_named() {
        let told = of_limit((1e-6, "max-area"), &square(0.0), Unit::Mm);
        let told = told.unwrap_err().to_string();
        assert!(
            told.starts_with("max-area asks for 100000000 panels"),
            "{told}"
        );
        assert!(told.contains("14.14 mm across"), "{told}");
        assert_eq!(of_limit((1.0, "max-area"), &square(0.0), Unit::M), Ok(100));
    }

    #[test]
    fn senseless_lengths_are_refused_by_what_they_would_take() {
        for (typed, told) in [
            ("0", "the length must be positive"),
            ("30m", "less than one panel fits"),
            ("1mm", "38490018 panels would be needed, and at most"),
            ("1e-200", "more than 1e15 panels would be needed"),
        ] {
            let size = TypedPanelSize::EdgeLength(typed.parse().unwrap());
            let message = message(size, 0.0);
            assert!(
                message.starts_with(&format!("--edge-length {typed}: ")) && message.contains(told),
                "{message}"
            );
        }
    }

    #[test]
    fn shares_follow_the_areas() {
        assert_eq!(shares(100, &[1.0, 3.0, 0.001]), [25, 75, 1]);
    }
}
