//! What a caller hears of stages that work in normalised coordinates.

use crate::progress::{Event, Progress};
use crate::smooth_surface::Affinity;
use phex_mesh::PolygonSoup;

/// The caller's progress, for stages in normalised coordinates.
pub(super) struct InModel<'a> {
    pub progress: &'a dyn Progress,
    pub affinity: &'a Affinity,
}

impl Progress for InModel<'_> {
    fn report(&self, event: &Event) {
        self.progress.report(event);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }

    fn wants_best(&self) -> bool {
        self.progress.wants_best()
    }

    fn preview(&self, stage: &'static str, mesh: &dyn Fn() -> PolygonSoup) {
        let restored = || {
            let mut soup = mesh();
            for p in &mut soup.positions {
                *p = self.affinity.restore(*p);
            }
            soup
        };
        self.progress.preview(stage, &restored);
    }
}
