//! A surface kept between jobs: what a change of settings does not touch is not computed again.

use phex::Session;
use phex_mesh::SurfaceParts;

/// The parts of a surface with what earlier jobs on it have computed, see [`Session`]. Results are
/// those of a job that begins anew, bit for bit.
///
/// ```
/// use phex_job::{MeshFile, MeshJob, MeshSettings, SurfaceSession, run};
/// use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// use std::sync::Arc;
///
/// let torus = triangulate(&Shape::from_name("torus", &[])?, &TriangulationOptions::default())?;
/// let file = MeshFile::in_memory("torus", torus.to_soup());
/// let parts = file.surfaces()?;
/// let session = Arc::new(SurfaceSession::new(&parts));
/// for rotate in ["0", "10"] {
///     let settings = MeshSettings::from_toml(&format!("panels = 60\nrotate = {rotate}"))?;
///     let mut job = MeshJob::new(parts.clone(), file.record.clone(), settings);
///     job.session = Some(session.clone());
///     assert!(run(&job, &phex::Silent)?.mesh.topology().n_faces() > 50);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SurfaceSession {
    /// One for each connected part.
    sessions: Vec<Session>,
}

impl SurfaceSession {
    /// A session with a surface; nothing is computed yet.
    pub fn new(parts: &SurfaceParts) -> Self {
        let session = |part: &phex_mesh::SurfaceComponent| Session::new(part.surface.clone());
        Self {
            sessions: parts.components.iter().map(session).collect(),
        }
    }

    /// The session of a part, if it is that of the same surface.
    pub(crate) fn of(&self, part: usize, surface: &phex_mesh::TriangleSurface) -> Option<&Session> {
        let session = self.sessions.get(part)?;
        let known = session.surface();
        let is_same = known.positions().as_slice() == surface.positions().as_slice()
            && known.topology().face_lists() == surface.topology().face_lists();
        is_same.then_some(session)
    }
}
