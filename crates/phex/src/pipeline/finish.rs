//! The last steps of a pass, before it is searched: the boundary. Each is kept unless the judge
//! finds more that is invalid or outside limits.

use super::domain::Ground;
use super::rim::{Rim, follow_rim, on_curve};
use super::{Clock, PipelineError};
use crate::quality::Judgement;
use crate::search::Site;
use phex_mesh::HexMesh;

/// A mesh on its way, and what the judge says of it.
struct JudgedMesh<'a> {
    mesh: HexMesh,
    judgement: Judgement,
    site: &'a Site<'a>,
}

impl<'a> JudgedMesh<'a> {
    fn new(mesh: HexMesh, site: &'a Site<'a>) -> Self {
        Self {
            judgement: site.judged(&mesh),
            mesh,
            site,
        }
    }

    /// Takes another mesh in its place unless more of it is invalid or outside limits.
    fn offer(&mut self, mesh: Option<HexMesh>) {
        let Some(mesh) = mesh else { return };
        let judgement = self.site.judged(&mesh);
        if judgement.merit.is_no_worse(&self.judgement.merit) {
            (self.mesh, self.judgement) = (mesh, judgement);
        }
    }
}

/// A trimmed mesh brought to the boundary.
pub(super) fn finished(
    trimmed: HexMesh,
    site: &Site<'_>,
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<(HexMesh, Judgement), PipelineError> {
    let (options, progress) = (&ground.options, clock.progress);
    let surface = site.judge.surface();
    let mut now = clock.timed("validate", || JudgedMesh::new(trimmed, site));
    clock.unless_unwanted()?;
    let is_valid = now.judgement.merit.invalid == 0.0;
    if let Some(rim) = Rim::kept(surface, options).filter(|_| is_valid && !progress.is_cancelled())
    {
        let next = clock.timed("optimise", || on_curve(&now.mesh, site, &rim, progress))?;
        now.offer(next.map(|n| n.mesh));
        now.offer(follow_rim(&now.mesh, surface, options));
    }
    Ok((now.mesh, now.judgement))
}
