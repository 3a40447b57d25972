//! What a workshop can make, as it is typed.

use crate::error::JobError;
use crate::hexagon::hexagon_area;
use crate::units::{Area, Quantity, Rectangle, Unit, four_digits};
use phex::quality::{Check, Reading};
use phex::ranges::{self, BadOption};
use phex_mesh::PanelLimits;
use serde::{Deserialize, Serialize};

/// Limits of panels, edges, corners and joints; in a job file, the table `[limits]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct LimitSettings {
    /// Sheet that each panel is cut from, however it lies on it: `1.5x3.0m`
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "AxB",
            help_heading = "Limits of a workshop"
        )
    )]
    pub max_panel: Option<Rectangle>,
    /// Shortest edge
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "LENGTH",
            help_heading = "Limits of a workshop"
        )
    )]
    pub min_edge: Option<Quantity>,
    /// Longest edge
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "LENGTH",
            help_heading = "Limits of a workshop"
        )
    )]
    pub max_edge: Option<Quantity>,
    /// Sharpest corner of a panel, degrees
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "DEG", value_parser = crate::steering::positive, help_heading = "Limits of a workshop"))]
    pub min_angle: Option<f64>,
    /// Largest panel: `2.5m2`, or a number of squared model units
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            allow_hyphen_values = true,
            value_name = "AREA",
            help_heading = "Limits of a workshop"
        )
    )]
    pub max_area: Option<Area>,
    /// Largest length over width of a panel, at least 1
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "X", value_parser = crate::steering::positive, help_heading = "Limits of a workshop"))]
    pub max_aspect: Option<f64>,
    /// Sharpest joint: least angle between neighbouring panels, degrees; 180 is flat
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "DEG", value_parser = crate::steering::positive, help_heading = "Limits of a workshop"))]
    pub min_dihedral: Option<f64>,
    /// Flattest joint: largest angle between neighbouring panels, degrees
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "DEG", value_parser = crate::steering::positive, help_heading = "Limits of a workshop"))]
    pub max_dihedral: Option<f64>,
}

/// Longest edge, area of a panel, and sides of its rectangle, over those of the mean panel, that a
/// lattice has room for.
const EDGES: f64 = 2.2;
const AREAS: f64 = 1.4;
const RECTANGLE: f64 = 2.5;
const WIDTH: f64 = 1.25;

impl LimitSettings {
    /// These settings, and those of `file` where these say nothing.
    pub fn over(self, file: Self) -> Self {
        Self {
            max_panel: self.max_panel.or(file.max_panel),
            min_edge: self.min_edge.or(file.min_edge),
            max_edge: self.max_edge.or(file.max_edge),
            min_angle: self.min_angle.or(file.min_angle),
            max_area: self.max_area.or(file.max_area),
            max_aspect: self.max_aspect.or(file.max_aspect),
            min_dihedral: self.min_dihedral.or(file.min_dihedral),
            max_dihedral: self.max_dihedral.or(file.max_dihedral),
        }
    }

    /// The limits in model units; percentages refer to `whole`.
    pub fn in_units(&self, unit: Unit, whole: f64) -> PanelLimits {
        let length = |q: Quantity| q.length(unit, whole);
        PanelLimits {
            max_panel: self.max_panel.map(|r| r.sides(unit, whole)),
            min_edge: self.min_edge.map(length),
            max_edge: self.max_edge.map(length),
            min_angle: self.min_angle,
            max_area: self.max_area.map(|a| a.area(unit)),
            max_aspect: self.max_aspect,
            min_dihedral: self.min_dihedral,
            max_dihedral: self.max_dihedral,
        }
    }

    /// Refuses a figure that nothing can meet, and a least one above the largest one, in the words
    /// in which they were typed.
    ///
    /// # Errors
    /// If there are such figures.
    pub(crate) fn check(&self, unit: Unit) -> Result<(), JobError> {
        // A percentage and a length are compared where the model is known.
        let is_share = |q: &Quantity| q.length(unit, f64::NAN).is_nan();
        let exceeds = |a: &Quantity, b: &Quantity| {
            is_share(a) == is_share(b) && a.length(unit, 1.0) > b.length(unit, 1.0)
        };
        let edges = self
            .min_edge
            .zip(self.max_edge)
            .filter(|(a, b)| exceeds(a, b));
        let joints = self
            .min_dihedral
            .zip(self.max_dihedral)
            .filter(|(a, b)| a > b);
        self.check_ranges().map_err(JobError::input)?;
        let edges = edges.map(|(a, b)| format!("min-edge {a} is more than max-edge {b}"));
        let joints = joints.map(|(a, b)| format!("min-dihedral {a} is more than max-dihedral {b}"));
        edges
            .or(joints)
            .map_or(Ok(()), |told| Err(JobError::input(told)))
    }

    fn check_ranges(&self) -> Result<(), BadOption> {
        let joints = [
            ("min-dihedral", self.min_dihedral.unwrap_or(180.0)),
            ("max-dihedral", self.max_dihedral.unwrap_or(180.0)),
        ];
        let edges = [
            ("min-edge", self.min_edge.map_or(1.0, Quantity::value)),
            ("max-edge", self.max_edge.map_or(1.0, Quantity::value)),
        ];
        let aspect = ("max-aspect", self.max_aspect.unwrap_or(1.0));
        ranges::positive(&joints)?;
        ranges::positive(&edges)?;
        ranges::within(0.0..=180.0, &joints)?;
        ranges::within(1.0..=ranges::LARGEST_WEIGHT, &[aspect])?;
        ranges::below(180.0, &[("min-angle", self.min_angle.unwrap_or(1.0))])
    }

    /// Refuses edges that are to be longer than the surface is across: no panel has them.
    ///
    /// # Errors
    /// If they are.
    pub(crate) fn check_edges(&self, unit: Unit, diagonal: f64) -> Result<(), JobError> {
        let too_long = (self.min_edge).filter(|edge| edge.length(unit, diagonal) > diagonal);
        too_long.map_or(Ok(()), |edge| {
            Err(JobError::input(format!(
                "min-edge {edge} is longer than the surface, which is {} {unit} across: is the unit right, of the model and of min-edge?",
                four_digits(diagonal)
            )))
        })
    }

    /// What is said of largest sizes that exceed the whole surface.
    pub(crate) fn doubted(&self, unit: Unit, diagonal: f64) -> Option<String> {
        let limits = self.in_units(unit, diagonal);
        let sides = limits.max_panel.map(|[a, b]| a.min(b));
        let exceed = [
            ("max-panel", sides),
            ("max-edge", limits.max_edge),
            ("max-area", limits.max_area.map(f64::sqrt)),
        ];
        let exceed = exceed
            .into_iter()
            .filter(|l| l.1.is_some_and(|x| x > diagonal));
        let names: Vec<&str> = exceed.map(|limit| limit.0).collect();
        (!names.is_empty()).then(|| {
            format!(
                "the surface is {} {unit} across, less than a single panel may be by {}: is the unit right, of the model and of the limit?",
                four_digits(diagonal),
                names.join(" and ")
            )
        })
    }

    /// Area of a mean panel that leaves room below the limits of size, and the limit that asks for
    /// it; `None` where there is none.
    pub fn mean_area(&self, unit: Unit, whole: f64) -> Option<(f64, &'static str)> {
        let limits = self.in_units(unit, whole);
        let of_sheet = limits.max_panel.map(|[a, b]| {
            let width = a.min(b) / WIDTH;
            (a * b / RECTANGLE).min(hexagon_area(width / 3.0_f64.sqrt()))
        });
        let of_edge = limits.max_edge.map(|edge| hexagon_area(edge / EDGES));
        let of_area = limits.max_area.map(|area| area / AREAS);
        let all = [
            of_sheet.zip(Some("max-panel")),
            of_edge.zip(Some("max-edge")),
            of_area.zip(Some("max-area")),
        ];
        all.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Figure and limit of a check as the limit was typed; `None` where it was not typed as a
    /// length, an area or a sheet.
    pub(crate) fn reading(&self, check: &Check, unit: Unit, whole: f64) -> Option<Reading> {
        if check.name == "max_panel" {
            let sheet = self.max_panel?;
            let (name, size) = sheet.typed()[0].unit(unit, whole);
            return Some(sheet_reading(
                sheet.sides(unit, whole).map(|side| side / size),
                check.value,
                name.to_owned(),
            ));
        }
        let (unit, size) = self.typed_unit(check.name, unit, whole)?;
        Some(Reading {
            unit,
            limit: check.limit / size,
            value: check.value / size,
            across: None,
        })
    }

    /// The unit in which a limit was typed, by the name of its check, and the value of 1 of it in
    /// model units.
    fn typed_unit(&self, check: &str, unit: Unit, whole: f64) -> Option<(String, f64)> {
        let of = |q: Quantity| {
            let (name, length) = q.unit(unit, whole);
            (name.to_owned(), length)
        };
        match check {
            "min_edge" => self.min_edge.map(of),
            "max_edge" => self.max_edge.map(of),
            "max_area" => self.max_area.map(|a| {
                let (name, length) = a.side(unit);
                (format!("{name}2"), length * length)
            }),
            _ => None,
        }
    }
}

/// A sheet beside the least one of its proportions that holds every panel.
fn sheet_reading([a, b]: [f64; 2], factor: f64, unit: String) -> Reading {
    let (short, long) = (a.min(b), a.max(b));
    Reading {
        unit,
        limit: short,
        value: factor * short,
        across: Some([long, factor * long]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_the_unit_of_the_model() {
        let typed: LimitSettings = toml::from_str(
            "max-panel = '1.5x3m'\nmin-edge = '20cm'\nmax-area = '2.5m2'\nmin-angle = 25\nmax-edge = '10%'",
        )
        .unwrap();
        let limits = typed.in_units(Unit::Mm, 30_000.0);
        assert_eq!(limits.max_panel, Some([1500.0, 3000.0]));
        assert_eq!(limits.min_edge, Some(200.0));
        assert_eq!(
            (limits.max_edge, limits.min_angle),
            (Some(3000.0), Some(25.0))
        );
        assert!((limits.max_area.unwrap() - 2.5e6).abs() < 1e-6);
        assert_eq!(
            typed.typed_unit("min_edge", Unit::Mm, 1.0),
            Some(("cm".to_owned(), 10.0))
        );
        let area = typed.typed_unit("max_area", Unit::M, 1.0).unwrap();
        assert_eq!((area.0.as_str(), area.1), ("m2", 1.0));
    }

    #[test]
    fn limits_that_exceed_the_whole_surface_are_doubted() {
        let limits = |text: &str| -> LimitSettings { toml::from_str(text).unwrap() };
        let refused = |text| limits(text).check_edges(Unit::Mm, 12.0).is_err();
        assert!(refused("min-edge = '0.1m'") && refused("min-edge = '110%'"));
        assert!(!refused("min-edge = '1mm'") && !refused("max-edge = '5m'"));
        let doubted = |text| limits(text).doubted(Unit::Mm, 140.0);
        assert_eq!(
            doubted("max-panel = '0.1x10m'\nmax-edge = '10%'\nmin-edge = '5m'"),
            None
        );
        let told = doubted("max-panel = '5x10m'\nmax-area = '2m2'").unwrap();
        assert!(told.contains("140 mm across"), "{told}");
        assert!(told.contains("may be by max-panel and max-area:"), "{told}");
    }

    #[test]
    fn the_tightest_limit_of_size_gives_the_mean_panel() {
        let limits = |text: &str| -> LimitSettings { toml::from_str(text).unwrap() };
        let area = |text| limits(text).mean_area(Unit::M, 1.0).map(|(area, _)| area);
        assert_eq!(area("min-edge = 1"), None);
        assert!((area("max-area = 1.4").unwrap() - 1.0).abs() < 1e-12);
        let sheet = area("max-panel = '2x4'").unwrap();
        assert!(sheet < area("max-panel = '4x4'").unwrap());
        assert_eq!(area("max-panel = '2x4'\nmax-edge = 100"), Some(sheet));
        assert!(area("max-panel = '2x4'\nmax-edge = 0.5").unwrap() < sheet);
    }

    #[test]
    fn a_sheet_is_read_beside_the_one_that_would_do() {
        let read = sheet_reading([4.0, 2.0], 1.5, "m".to_owned());
        assert_eq!((read.limit, read.value), (2.0, 3.0));
        assert_eq!(read.across, Some([4.0, 6.0]));
    }

    #[test]
    fn what_nothing_can_meet_is_refused_by_its_option() {
        let told = |text: &str| {
            let limits: LimitSettings = toml::from_str(text).unwrap();
            limits.check(Unit::M).map_err(|e| e.to_string())
        };
        for (option, value) in [
            ("min-angle", "300"),
            ("max-dihedral", "181"),
            ("max-aspect", "0.5"),
            ("min-edge", "0"),
        ] {
            let refused = told(&format!("{option} = {value}")).unwrap_err();
            assert!(refused.starts_with(option), "{refused}");
        }
        let crossed = |edges: [&str; 2]| {
            let [least, most] = edges;
            told(&format!(
                "min-edge = '{least}'
max-edge = '{most}'"
            ))
        };
        let named = "min-edge 5% is more than max-edge 1%".to_owned();
        assert_eq!(crossed(["5%", "1%"]), Err(named));
        assert!(crossed(["1m", "5cm"]).is_err());
        assert_eq!(crossed(["5%", "1m"]), Ok(()), "the model is not known");
        assert_eq!(told("min-angle = 179\nmin-dihedral = 180"), Ok(()));
    }

    #[test]
    fn what_is_typed_comes_before_the_file() {
        let typed: LimitSettings = toml::from_str("min-edge = 1").unwrap();
        let file: LimitSettings = toml::from_str("min-edge = 2\nmax-aspect = 3").unwrap();
        let both = typed.over(file);
        assert_eq!(
            (both.min_edge, both.max_aspect),
            (typed.min_edge, Some(3.0))
        );
    }
}
