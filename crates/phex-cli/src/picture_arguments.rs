//! What can be typed about pictures.

use crate::args::{Limits, Talk};
use crate::exit::EXIT_CODES;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use phex::report::maps::Map;
use phex::report::picture::PictureOptions;
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
    /// What the colours show; the ranges are fixed, so that pictures can be compared
    #[arg(long, value_name = "MAP", default_value = "valence", value_parser = map_parser())]
    pub color: Map,
    /// From where the mesh is seen
    #[arg(long, value_enum, default_value_t)]
    pub view: View,
    /// Surface that the mesh stands for, for deviation and curvature
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Curves to draw over the panels: an OBJ file with polylines, as `network` and `dupin` write them; for PNG
    #[arg(long, value_name = "CURVES.OBJ")]
    pub curves: Option<PathBuf>,
    /// Leave out the panels' edges: a fine triangle mesh then looks like the surface that it stands for
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
    pub limits: Limits,
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
    /// Surface that the mesh stands for
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Mesh to compare with, as it was before
    #[arg(long, value_name = "MESH")]
    pub before: Option<PathBuf>,
    /// Limits.
    #[command(flatten)]
    pub limits: Limits,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Directions from which a model is seen; z is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum View {
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
            View::Iso => (None, iso),
            View::Top => (Some(-90.0), 90.0),
            View::Front => (Some(-90.0), 0.0),
            View::Back => (Some(90.0), 0.0),
            View::Left => (Some(180.0), 0.0),
            View::Right => (Some(0.0), 0.0),
        };
        PictureOptions {
            width: self.size.0,
            height: self.size.1,
            azimuth,
            elevation,
            edges: !self.no_edges,
            legend: !self.no_legend,
            ..Default::default()
        }
    }
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
    fn sizes_are_two_numbers_within_range() {
        assert_eq!(size("800x600"), Ok((800, 600)));
        for wrong in ["800", "800x", "8x600", "1e3x600", "-800x600", "99999x600"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
