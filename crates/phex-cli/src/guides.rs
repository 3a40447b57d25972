//! Guides as they are typed: lines that rows run along, creases, and prescribed cones.

use crate::exit::Failure;
use crate::input::{read_numbers, read_polylines};
use clap::Args;
use phex::directions::{Cone, Guides};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Lines, creases and cones; in a job file, the table `[guides]`.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct GuideSettings {
    /// Let rows of panels run along the polylines of an OBJ file
    #[arg(long, value_name = "LINES.OBJ", help_heading = "Rows")]
    pub guide: Option<PathBuf>,
    /// Let rows run along edges of the input whose two triangles meet at more than an angle in
    /// degrees (30 without a number)
    #[arg(long, value_name = "DEG", num_args = 0..=1, default_missing_value = "30", value_parser = angle, help_heading = "Rows")]
    pub crease: Option<f64>,
    /// Put the irregular panels of the field where a text file says: `x y z index` on a line, 1 for
    /// a pentagon, -1 for a heptagon; on a closed surface the indices must add up to six times the
    /// Euler characteristic
    #[arg(long, value_name = "CONES.TXT", help_heading = "Rows")]
    pub cones: Option<PathBuf>,
}

fn angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x < 180.0 => Ok(x),
        _ => Err(format!("`{text}` is no angle between 0 and 180 degrees")),
    }
}

impl GuideSettings {
    /// These settings, and those of `file` where these say nothing.
    pub fn over(self, file: Self) -> Self {
        Self {
            guide: self.guide.or(file.guide),
            crease: self.crease.or(file.crease),
            cones: self.cones.or(file.cones),
        }
    }

    /// The files that are read.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        let files = [&self.guide, &self.cones];
        files.into_iter().flatten().map(PathBuf::as_path)
    }

    /// Adds what is asked for.
    ///
    /// # Errors
    /// If a file can't be read, holds nothing, or a line of it is wrong.
    pub fn apply(&self, guides: &mut Guides) -> Result<(), Failure> {
        if let Some(path) = &self.guide {
            let lines = read_polylines(path)?;
            if lines.is_empty() {
                let name = path.display();
                return Err(Failure::input(format!(
                    "{name}: it holds no polyline (a line `l 1 2 3`)"
                )));
            }
            let arrays = lines
                .iter()
                .map(|l| l.iter().map(|p| [p.x, p.y, p.z]).collect());
            guides.lines.extend(arrays);
        }
        if self.crease.is_some() {
            guides.crease = self.crease;
        }
        if let Some(path) = &self.cones {
            for line in read_numbers(path)? {
                match line.numbers[..] {
                    [x, y, z, index] if is_index(index) => guides.cones.push(Cone {
                        position: [x, y, z],
                        index: index as i32,
                    }),
                    _ => {
                        return Err(
                            line.wrong("`x y z index` with an index from -6 to 5 that is not 0")
                        );
                    }
                }
            }
        }
        Ok(())
    }
}

fn is_index(x: f64) -> bool {
    x.fract() == 0.0 && (-6.0..=5.0).contains(&x) && x != 0.0
}
