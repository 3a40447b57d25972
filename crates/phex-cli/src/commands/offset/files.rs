//! The files of `phex offset`: their names, and what stands in them.

use super::between::{beam_table, node_table, solids};
use super::{Base, OffsetJob, OffsetLayer};
use crate::exit::{Exit, Failure, OrExit};
use crate::offset_arguments::OffsetCommand;
use crate::output_folder::{Extent, NamedFile, OutputFolder};
use phex::offset::successive;
use phex_job::Content;
use phex_mesh::PolygonSoup;
use phex_mesh::io::{Format, write_soup_to};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Names of all files.
pub(super) struct Files {
    folder: Option<PathBuf>,
    extension: &'static str,
    report: Option<PathBuf>,
    names: Vec<String>,
    tables: Vec<String>,
}

/// One file with what it holds.
pub(super) struct OffsetFile {
    path: PathBuf,
    what: &'static str,
    file: NamedFile,
    volume: Option<f64>,
}

enum FileBody {
    Mesh(PolygonSoup),
    Text(String),
}

impl FileBody {
    fn bytes(self, name: &str) -> Result<Vec<u8>, Failure> {
        let soup = match self {
            Self::Text(text) => return Ok(text.into_bytes()),
            Self::Mesh(soup) => soup,
        };
        let mut bytes = Vec::new();
        let format = Format::from_path(Path::new(name)).or_exit(Exit::Internal)?;
        write_soup_to(&mut bytes, &soup, format).or_exit(Exit::InputUnusable)?;
        Ok(bytes)
    }
}

impl OffsetFile {
    /// The file, to be written into the folder.
    pub fn file(&self) -> NamedFile {
        self.file.clone()
    }

    pub fn record(&self) -> Value {
        json!({ "content": self.what, "path": self.path.display().to_string(), "volume": self.volume })
    }

    /// Volume of all solids in it.
    pub fn volume(&self) -> Option<f64> {
        self.volume
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Files {
    /// The names that a command leads to.
    ///
    /// # Errors
    /// If there are layers but no folder for them.
    pub fn plan(command: &OffsetCommand, distances: &[f64]) -> Result<Self, Failure> {
        let own = command.face_distances.is_some();
        let layers = layer_tags(own, distances);
        let any = !layers.is_empty() || command.gauss_image;
        if any && command.output.is_none() {
            return Err(Failure::new(
                Exit::Usage,
                "give a folder with -o to write layers",
            ));
        }
        let mut names: Vec<String> = layers.iter().map(|t| format!("layer_{t}")).collect();
        let pairs = pair_tags(&layers);
        let mut tables = Vec::new();
        if command.solids {
            names.extend(pairs.iter().map(|t| format!("solids_{t}")));
        }
        if command.beams {
            tables.extend(pairs.iter().map(|t| format!("beams_{t}")));
            tables.extend(pairs.iter().map(|t| format!("nodes_{t}")));
        }
        names.extend(command.gauss_image.then(|| "gauss_image".to_owned()));
        names.extend((command.optimise && any).then(|| "mesh".to_owned()));
        Ok(Self {
            folder: command.output.clone(),
            extension: command.format.extension(),
            report: command.report.clone(),
            names,
            tables,
        })
    }

    /// All paths, for checking that they can be written.
    pub fn outputs(&self) -> Vec<(PathBuf, Content)> {
        let meshes = self.meshes().map(|n| (self.path(&n), Content::Mesh));
        let tables = self.tables().map(|n| self.path(&n));
        let others = tables.chain(self.report.clone());
        meshes
            .chain(others.map(|path| (path, Content::Other)))
            .collect()
    }

    /// The folder, if anything is written into it.
    pub fn folder(&self) -> Option<OutputFolder<'_>> {
        let path = self.folder.as_deref().filter(|_| !self.names.is_empty())?;
        Some(OutputFolder::new(path, "offset", Extent::Added))
    }

    /// Names of all files in the folder.
    pub fn in_folder(&self) -> Vec<String> {
        self.meshes().chain(self.tables()).collect()
    }

    fn meshes(&self) -> impl Iterator<Item = String> {
        self.names.iter().map(|n| format!("{n}.{}", self.extension))
    }

    fn tables(&self) -> impl Iterator<Item = String> {
        self.tables.iter().map(|n| format!("{n}.csv"))
    }

    fn path(&self, name: &str) -> PathBuf {
        let folder = self.folder.as_deref().unwrap_or(Path::new("."));
        folder.join(name)
    }

    /// What is to be written.
    ///
    /// # Errors
    /// If a gap is too wide or layers do not enclose solids.
    pub fn contents(
        &self,
        command: &OffsetCommand,
        job: &OffsetJob<'_>,
        base: &Base,
        layers: &[OffsetLayer],
    ) -> Result<Vec<OffsetFile>, Failure> {
        let mut bodies: Vec<(&'static str, FileBody, Option<f64>)> = Vec::new();
        for layer in layers {
            bodies.push(("layer", FileBody::Mesh(layer.mesh.to_soup()), None));
        }
        let pairs = successive(&base.mesh, layers.iter().map(|l| (l.distance, &l.mesh)));
        if command.solids {
            for &pair in &pairs {
                let (soup, volume) = solids(pair, job.gap, command.unit)?;
                bodies.push(("solids", FileBody::Mesh(soup), Some(volume)));
            }
        }
        if command.gauss_image {
            let image = base.motion.image().mesh(&base.mesh).to_soup();
            bodies.push(("gauss image", FileBody::Mesh(image), None));
        }
        if base.optimised.is_some() && !self.names.is_empty() {
            bodies.push(("mesh", FileBody::Mesh(base.mesh.to_soup()), None));
        }
        if command.beams {
            for &pair in &pairs {
                bodies.push(("beams", FileBody::Text(beam_table(pair)?), None));
            }
            for &pair in &pairs {
                bodies.push(("nodes", FileBody::Text(node_table(pair)?), None));
            }
        }
        let content = |(name, (what, body, volume)): (String, (&'static str, FileBody, _))| {
            Ok(OffsetFile {
                path: self.path(&name),
                what,
                file: (name.clone(), body.bytes(&name)?),
                volume,
            })
        };
        self.in_folder()
            .into_iter()
            .zip(bodies)
            .map(content)
            .collect()
    }
}

/// Parts of file names that tell the layers.
fn layer_tags(own: bool, distances: &[f64]) -> Vec<String> {
    if own {
        return vec!["faces".to_owned()];
    }
    let tags = |digits| -> Vec<String> { distances.iter().map(|&d| rounded(d, digits)).collect() };
    let distinct = |tags: &Vec<String>| tags.windows(2).all(|w| w[0] != w[1]);
    let rough = (DIGITS..EXACT).map(tags).find(distinct);
    rough.unwrap_or_else(|| tags(EXACT))
}

/// Digits of a distance in a file name, or as many more as tell layers apart; and all that a number
/// has.
const DIGITS: usize = 5;
const EXACT: usize = 17;

/// A distance with some digits, as short as it can be written.
fn rounded(distance: f64, digits: usize) -> String {
    let text = format!("{distance:.*e}", digits - 1);
    format!("{:+}", text.parse().unwrap_or(distance))
}

/// Parts of file names that tell what lies between successive layers.
fn pair_tags(layers: &[String]) -> Vec<String> {
    match layers {
        [only] => vec![format!("0_{only}")],
        _ => layers
            .windows(2)
            .map(|w| format!("{}_{}", w[0], w[1]))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::layer_tags;

    #[test]
    fn names_are_short_and_distinct() {
        let tags = |d: &[f64]| layer_tags(false, d).join(" ");
        assert_eq!(tags(&[-0.02, 0.05, 0.123_456_789]), "-0.02 +0.05 +0.12346");
        assert_eq!(tags(&[1.0, 1.000_000_1]), "+1 +1.0000001");
        assert_eq!(tags(&[0.1 + 0.2]), "+0.3");
        assert_eq!(tags(&[1_234.567_89]), "+1234.6");
    }
}
