//! What can be typed about pictures.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::{CriteriaArguments, Talk, ToleranceArguments};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use phex_picture::PictureOptions;
use phex_picture::maps::{Map, Range};
use std::path::PathBuf;

/// Arguments of `phex render`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct RenderCommand {
    /// Polygon mesh: OBJ, PLY, STL or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Picture to write: PNG (pixels) or SVG (vectors)
    #[arg(short, long, value_name = "PICTURE")]
    pub output: PathBuf,
    /// What the colours show
    #[arg(long, value_name = "MAP", default_value = "valence", value_parser = map_parser())]
    pub color: Map,
    /// Values of the first and the last colour: `LOW,HIGH` in the unit of the legend, `fixed` for
    /// the same range in every picture, or `auto`, the mesh's own
    #[arg(long, value_name = "RANGE", default_value = "auto", value_parser = range, allow_hyphen_values = true)]
    pub range: Range,
    /// Colour panels instead: a text file with lines of `panel colour`, panels counted from 0,
    /// colours from 1 to 6; the others stay plain
    #[arg(long, value_name = "MARKS.TXT", conflicts_with_all = ["color", "range"])]
    pub mark: Option<PathBuf>,
    /// From where the mesh is seen
    #[arg(long, value_enum, default_value_t)]
    pub view: ViewFrom,
    /// Direction from which it is seen instead, degrees counter-clockwise from +x (-60 for `iso`:
    /// from the front, a little from the right)
    #[arg(long, value_name = "DEG", value_parser = degrees::<360>, allow_hyphen_values = true)]
    pub azimuth: Option<f64>,
    /// Height of the eye above the horizon instead, degrees (-90 to 90)
    #[arg(long, value_name = "DEG", value_parser = degrees::<90>, allow_hyphen_values = true)]
    pub elevation: Option<f64>,
    /// Surface that the mesh stands for, for deviation and curvature
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Curves to draw over the panels: an OBJ file with polylines, as `network` and `dupin` write
    /// them; for PNG
    #[arg(long, value_name = "CURVES.OBJ")]
    pub curves: Option<PathBuf>,
    /// Leave out the panels' edges: a fine triangle mesh then looks like the surface that it stands
    /// for
    #[arg(long)]
    pub no_edges: bool,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1600x1200", value_parser = size)]
    pub size: (usize, usize),
    /// Leave out the legend
    #[arg(long)]
    pub no_legend: bool,
    /// Limits.
    #[command(flatten)]
    pub limits: ToleranceArguments,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex report`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct ReportCommand {
    /// Polygon mesh: OBJ, PLY, STL or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// HTML file to write
    #[arg(long, value_name = "REPORT.HTML")]
    pub html: PathBuf,
    /// Surface and limits.
    #[command(flatten)]
    pub judged_by: CriteriaArguments,
    /// Mesh to compare with, as it was before
    #[arg(long, value_name = "MESH")]
    pub before: Option<PathBuf>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Directions from which a model is seen; z is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ViewFrom {
    /// From above, from the side that shows most
    #[default]
    Iso,
    /// Straight down, x to the right
    Top,
    /// Along y, x to the right
    Front,
    /// Against y
    Back,
    /// Along x, from the left of the front view
    Left,
    /// Against x, from the right of the front view
    Right,
}

impl RenderCommand {
    /// The options of the picture.
    pub fn options(&self) -> PictureOptions {
        let iso = PictureOptions::default().elevation;
        let (azimuth, elevation) = match self.view {
            ViewFrom::Iso => (None, iso),
            ViewFrom::Top => (Some(-90.0), 90.0),
            ViewFrom::Front => (Some(-90.0), 0.0),
            ViewFrom::Back => (Some(90.0), 0.0),
            ViewFrom::Left => (Some(180.0), 0.0),
            ViewFrom::Right => (Some(0.0), 0.0),
        };
        PictureOptions {
            width: self.size.0,
            height: self.size.1,
            azimuth: self.azimuth.or(azimuth),
            elevation: self.elevation.unwrap_or(elevation),
            edges: !self.no_edges,
            legend: !self.no_legend,
            ..Default::default()
        }
    }
}

/// A range of colours as it is typed.
fn range(text: &str) -> Result<Range, String> {
    let ends = || {
        let (low, high) = text.split_once(',')?;
        let [low, high] = [low, high].map(|end| end.trim().parse::<f64>().ok());
        Some([low?, high?]).filter(|[a, b]| a.is_finite() && b.is_finite() && a < b)
    };
    match text {
        "auto" => Ok(Range::Automatic),
        "fixed" => Ok(Range::Fixed),
        _ => {
            let ends = ends().map(Range::Given);
            ends.ok_or_else(|| "write LOW,HIGH with LOW below HIGH, `fixed` or `auto`".to_owned())
        }
    }
}

fn degrees<const MOST: u16>(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse().ok();
    let angle = angle.filter(|a: &f64| a.abs() <= f64::from(MOST));
    angle.ok_or_else(|| format!("write an angle in degrees, from -{MOST} to {MOST}"))
}

fn map_parser() -> impl TypedValueParser<Value = Map> {
    let named = |name: String| Map::ALL.into_iter().find(|map| map.name() == name);
    PossibleValuesParser::new(Map::ALL.map(Map::name))
        .map(move |name| named(name).unwrap_or_default())
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let number = |word: &str| {
        word.trim()
            .parse()
            .ok()
            .filter(|n| (16..=16384).contains(n))
    };
    let sides = text.split_once(['x', 'X']);
    let sides = sides.and_then(|(w, h)| Some((number(w)?, number(h)?)));
    sides.ok_or_else(|| "write WIDTHxHEIGHT, each from 16 to 16384, e.g. 1600x1200".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_two_ends_in_order() {
        assert_eq!(range("-1,2.5"), Ok(Range::Given([-1.0, 2.5])));
        assert_eq!(range("auto"), Ok(Range::Automatic));
        for wrong in ["1", "2,1", "1,1", "nan,2", "0,inf", "a,b"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
        let angle = degrees::<360>;
        assert!(angle("-60").is_ok() && angle("nan").is_err() && angle("400").is_err());
        let height = degrees::<90>;
        assert!(
            height("-90").is_ok() && height("90.5").is_err(),
            "no eye is as high"
        );
    }

    #[test]
    fn sizes_are_two_numbers_within_range() {
        assert_eq!(size("800x600"), Ok((800, 600)));
        for wrong in ["800", "800x", "8x600", "1e3x600", "-800x600", "99999x600"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
