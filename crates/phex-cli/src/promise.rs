//! What an earlier run promised, as its report tells it: limits and surfaces, so that its mesh can
//! be judged again in the same way.

use crate::exit::{Exit, Failure, OrExit};
use anyhow::Context;
use phex_job::MeshFile;
use phex_job::TypedLimits;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The part of a run report that says what its mesh was judged by.
#[derive(Debug, Deserialize)]
pub struct Promise {
    command: String,
    limits: Option<TypedLimits>,
    inputs: Vec<PromisedFile>,
    outputs: Vec<PromisedOutput>,
    /// Where the report lies.
    #[serde(skip)]
    folder: PathBuf,
}

#[derive(Debug, Deserialize)]
struct PromisedFile {
    path: PathBuf,
    /// Reports of earlier versions do not tell that of what was written.
    sha256: Option<String>,
}

#[derive(Debug, Deserialize)]
struct PromisedOutput {
    content: String,
    #[serde(flatten)]
    file: PromisedFile,
}

impl Promise {
    /// Reads a run report.
    ///
    /// # Errors
    /// If the file can't be read or is no run report.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let name = || path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(name);
        let text = text.or_exit(Exit::InputUnusable)?;
        let promise = serde_json::from_str::<Self>(&text);
        let promise = promise.with_context(|| format!("{} is no run report", name()));
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(Self {
            folder,
            ..promise.or_exit(Exit::InputUnusable)?
        })
    }

    /// What the mesh was judged by.
    ///
    /// # Errors
    /// If the report does not say it.
    pub fn limits(&self) -> Result<TypedLimits, Failure> {
        self.limits.ok_or_else(|| {
            Failure::input("the report does not say what its mesh was judged by: it is of another command, or of an earlier version")
        })
    }

    /// The surface that the run was given; nothing if there was none.
    ///
    /// # Errors
    /// If the file is not there any more, or is another one.
    pub fn surface(&self) -> Result<Option<MeshFile>, Failure> {
        // `mesh` reads the surface first, the others the mesh.
        let place = usize::from(self.command != "mesh");
        let Some(read) = self.inputs.get(place) else {
            return Ok(None);
        };
        let file = self.found(read)?.ok_or_else(|| {
            let path = read.path.display();
            Failure::input(format!(
                "{path}: the surface of the report is not there; give it with --surface"
            ))
        })?;
        Ok(Some(file))
    }

    /// The smooth surface that the run wrote; nothing if it wrote none, or that is not there any
    /// more.
    ///
    /// # Errors
    /// If the file can't be used, or is another one.
    pub fn smooth(&self) -> Result<Option<MeshFile>, Failure> {
        let smooth = self.outputs.iter().find(|o| o.content == "smooth_target");
        Ok(smooth.map(|o| self.found(&o.file)).transpose()?.flatten())
    }

    /// Whether the run judged its mesh by a smooth surface.
    pub fn has_smooth(&self) -> bool {
        self.command == "mesh"
    }

    /// A file of the report, from where the report lies or from here: the first that has not
    /// changed.
    fn found(&self, wanted: &PromisedFile) -> Result<Option<MeshFile>, Failure> {
        let places = [self.folder.join(&wanted.path), wanted.path.clone()];
        let mut changed = None;
        for place in places.into_iter().filter(|p| p.is_file()) {
            let file = MeshFile::read(&place)?;
            let same = wanted.sha256.as_ref() == Some(&file.record.sha256);
            if same || wanted.sha256.is_none() {
                return Ok(Some(file));
            }
            changed.get_or_insert(place);
        }
        changed.map_or(Ok(None), |place| {
            let path = place.display();
            Err(Failure::input(format!(
                "{path}: has changed since the report was written; give the surface with --surface"
            )))
        })
    }
}
