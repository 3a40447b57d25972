//! Subdivision of a P-Hex mesh in space: finer connectivity, then the optimiser, level by level.

use super::PipelineError;
use crate::classical::dual_subdivision::chamfer;
use crate::layout::{Layout, LayoutError, MAX_PANELS, VertexKind};
use crate::optimise::{self, OptimiseOptions, Optimised, SurfaceTarget};
use crate::progress::Progress;
use crate::smooth_surface::{self, Normalised, TargetOptions};
use phex_mesh::{HexMesh, PerFace, PerVertex, TriangleSurface};

/// Vertices of the smooth target per panel.
const TARGET_DENSITY: usize = 25;

/// One level of a subdivision, in model coordinates.
#[derive(Clone, Debug)]
pub struct Level {
    /// The mesh.
    pub mesh: HexMesh,
    /// What the optimiser says of it.
    pub optimised: Optimised,
}

/// Refines a mesh: every edge becomes a panel, then the optimiser makes the panels planar and
/// simple and brings them to the surface through `surface`'s vertices. This is the robust
/// counterpart of dual subdivision: it needs no dual, so curvature may change its sign.
///
/// # Errors
/// If the mesh or an option can't be used. A level that did not become valid is returned with its
/// offenders.
pub fn subdivide(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    levels: usize,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Vec<Level>, PipelineError> {
    let model = Normalised::of(surface);
    let affinity = &model.affinity;
    let panels = mesh.topology().n_faces() as f64 * 4f64.powi(levels as i32);
    if panels > MAX_PANELS as f64 {
        let told = format!("{levels} levels make {panels:.0} panels, more than {MAX_PANELS}");
        return Err(PipelineError::Size(told));
    }
    let panels = panels as usize;
    let smooth = smooth_surface::smooth_target(
        &model.surface,
        TARGET_DENSITY * panels,
        &TargetOptions::default(),
    );
    let smooth = smooth.finest();
    let target = SurfaceTarget::new(smooth);
    let mut current = mesh.mapped(|p| affinity.normalise(*p));
    let mut made = Vec::with_capacity(levels);
    for _ in 0..levels {
        let finer = chamfer(&current).map_err(LayoutError::topology)?;
        let layout = as_layout(&finer, smooth);
        let optimised = optimise::optimise(&layout, &target, options, progress)?;
        current = optimised.mesh.clone();
        made.push(Level {
            mesh: current.mapped(|p| affinity.restore(*p)),
            optimised,
        });
        if progress.is_cancelled() {
            return Err(PipelineError::Cancelled);
        }
    }
    Ok(made)
}

/// A layout on a surface, from a mesh near it: vertices move to the surface, corners of the
/// boundary with one panel stay corners.
fn as_layout(mesh: &HexMesh, surface: &TriangleSurface) -> Layout {
    let topology = mesh.topology();
    let centres = mesh.centres();
    let feet = surface.closest_points(centres.as_slice()).into_iter();
    let on_surface = surface.closest_points(mesh.positions.as_slice());
    let length = |f| {
        let neighbours = topology.adjacent_faces(f);
        let distances = neighbours.map(|g| (centres[g] - centres[f]).norm());
        let (sum, count) = distances.fold((0.0, 0), |(s, n), d| (s + d, n + 1));
        sum / f64::from(count.max(1))
    };
    let positions = PerVertex::from_vec(on_surface.iter().map(|p| p.position).collect());
    Layout::new(
        mesh.with_positions(positions),
        VertexKind::of_mesh(mesh),
        feet.map(|p| (p.position, p.normal)),
        PerFace::from_fn(topology.n_faces(), length),
    )
}
