//! The last steps of a pass, before it is searched: the boundary. Each is kept unless the judge
//! finds more that is invalid or outside limits.

use super::domain::Ground;
use super::{Clock, PipelineError, rim};
use crate::optimise::{self, Quotient};
use crate::quality::Judgement;
use crate::search::Site;
use crate::trim::follow::followed;
use phex_mesh::HexMesh;

/// A mesh on its way, and what the judge says of it.
pub(super) struct JudgedMesh<'a> {
    pub mesh: HexMesh,
    judgement: Judgement,
    site: &'a Site<'a>,
}

impl<'a> JudgedMesh<'a> {
    pub fn new(mesh: HexMesh, site: &'a Site<'a>) -> Self {
        Self {
            judgement: site.judged(&mesh),
            mesh,
            site,
        }
    }

    /// Takes another mesh in its place unless more of it is invalid or outside limits.
    pub fn offer(&mut self, mesh: Option<HexMesh>) {
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
    let hold = rim::held(surface, options);
    if let Some(hold) = hold.filter(|_| is_valid && !progress.is_cancelled()) {
        // The ends of interior edges on the boundary, and vertices near its corners on these.
        let (quotient, settings) = (Quotient::default(), site.options);
        let next = clock.timed("optimise", || {
            optimise::onto_boundary(
                &now.mesh,
                site.close_to,
                &hold,
                &quotient,
                settings,
                progress,
            )
        })?;
        now.offer(next.map(|n| n.mesh));
        // Further corners where edges would cut the boundary short.
        let corner_angle = options.target.corner_angle.to_radians();
        let limit = options.boundary_limit();
        now.offer(followed(&now.mesh, surface, corner_angle, limit));
    }
    Ok((now.mesh, now.judgement))
}
