//! Guides as they are typed: lines that rows run along, creases, and prescribed cones.

use crate::error::JobError;
use crate::input::{read_polylines, read_some_numbers};
use phex::directions::{Cone, Guides};
use phex_mesh::Vec3;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Lines, creases and cones; in a job file, the table `[guides]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct GuideSettings {
    /// Let rows of panels run along the polylines of an OBJ file
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "LINES.OBJ", help_heading = "Rows")
    )]
    pub guide: Option<PathBuf>,
    /// Let rows run along edges of the input whose two triangles meet at more than an angle in
    /// degrees (30 without a number)
    #[cfg_attr(feature = "clap", arg(long, allow_negative_numbers = true, value_name = "DEG", num_args = 0..=1, default_missing_value = "30", value_parser = angle, help_heading = "Rows"))]
    pub crease: Option<f64>,
    /// Put the irregular panels of the field where a text file says: `x y z index` on a line, 1 for
    /// a pentagon, -1 for a heptagon; on a closed surface the indices must add up to six times the
    /// Euler characteristic
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "CONES.TXT", help_heading = "Rows")
    )]
    pub cones: Option<PathBuf>,
}

#[cfg(feature = "clap")]
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

    /// Adds what is asked for, `given` among it.
    pub fn apply(&self, given: Guides, guides: &mut Guides) {
        guides.lines.extend(given.lines);
        guides.cones.extend(given.cones);
        guides.crease = self.crease.or(guides.crease);
    }

    /// What the files hold.
    ///
    /// # Errors
    /// If one can't be read, holds nothing, or a line of it is wrong.
    pub fn read(&self) -> Result<Guides, JobError> {
        let mut guides = Guides::default();
        if let Some(path) = &self.guide {
            let lines = read_polylines(path)?;
            let is_point = |line: &Vec<Vec3>| line.windows(2).all(|ends| ends[0] == ends[1]);
            if lines.iter().all(is_point) {
                let name = path.display();
                return Err(JobError::input(format!(
                    "{name}: it holds no polyline (a line `l 1 2 3`)"
                )));
            }
            let arrays = lines
                .iter()
                .map(|l| l.iter().map(|p| [p.x, p.y, p.z]).collect());
            guides.lines.extend(arrays);
        }
        if let Some(path) = &self.cones {
            for line in read_some_numbers(path)? {
                add_cone(&mut guides, &line.numbers).map_err(|wanted| line.wrong(wanted))?;
            }
        }
        Ok(guides)
    }
}

/// Prescribes a cone.
///
/// # Errors
/// What is wanted instead.
pub(crate) fn add_cone(guides: &mut Guides, numbers: &[f64]) -> Result<(), &'static str> {
    match *numbers {
        [x, y, z, index] if is_index(index) => guides.cones.push(Cone {
            position: [x, y, z],
            index: index as i32,
        }),
        _ => return Err("`x y z index` with an index from -6 to 5 that is not 0"),
    }
    Ok(())
}

fn is_index(x: f64) -> bool {
    x.fract() == 0.0 && (-6.0..=5.0).contains(&x) && x != 0.0
}
