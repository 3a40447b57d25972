//! The last steps of a pass, before it is judged: the boundary, folds, and room for tight panels.
//! Each is kept unless the judge finds more that is invalid or outside limits.

use super::domain::Ground;
use super::rim::{Rim, follow_rim, on_curve};
use super::{Clock, PipelineError};
use crate::optimise::OptimiseError;
use crate::quality::{Judgement, Merit};
use crate::search::Site;
use crate::trim::{Trimmed, folds};
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

    /// Takes another mesh in its place unless more of it is invalid, or it leaves the limits.
    fn offer(&mut self, mesh: Option<HexMesh>) {
        self.offer_if(mesh, |next, now| {
            next.invalid <= now.invalid && (next.is_within() || !now.is_within())
        });
    }

    /// Takes another mesh in its place if its merit is good enough beside that of this one.
    fn offer_if(&mut self, mesh: Option<HexMesh>, is_good: impl Fn(&Merit, &Merit) -> bool) {
        let Some(mesh) = mesh else { return };
        let judgement = self.site.judged(&mesh);
        if is_good(&judgement.merit, &self.judgement.merit) {
            (self.mesh, self.judgement) = (mesh, judgement);
        }
    }

    fn is_valid(&self) -> bool {
        self.judgement.merit.invalid == 0.0
    }
}

/// A trimmed mesh brought to the boundary.
pub(super) fn finished(
    trimmed: Trimmed,
    site: &Site<'_>,
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<(HexMesh, Judgement), PipelineError> {
    let (options, progress) = (&ground.options, clock.progress);
    let surface = site.judge.surface();
    let mut now = clock.timed("validate", || JudgedMesh::new(trimmed.mesh.clone(), site));
    if now.judgement.of_face.iter().any(|f| f.folded > 0.0) {
        let unfolded = clock.timed("trim", || folds::without_folds(&trimmed, Some(surface)));
        now.offer(unfolded.map(|t| t.mesh));
    }
    let rim = Rim::kept(surface, options);
    if now.is_valid() && !progress.is_cancelled() {
        clock.timed("optimise", || -> Result<(), OptimiseError> {
            if let Some(rim) = &rim {
                let next = on_curve(&now.mesh, site, rim, progress)?;
                now.offer(next.map(|n| n.mesh));
                now.offer(follow_rim(&now.mesh, surface, options));
            }
            Ok(())
        })?;
    }
    Ok((now.mesh, now.judgement))
}
