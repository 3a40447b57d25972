//! Curvature at the scale of the panels, and how long panels are.

use super::MeshOptions;
use crate::curvature::{self, Curvature, CurvatureOptions};
use crate::directions::size::{self, Demands, SizeOptions};
use crate::directions::thickness::thickness;
use crate::layout::lattice::eisenstein::CELL;
use crate::smooth_surface::SmoothTarget;
use phex_mesh::{PerVertex, TriangleSurface};
use std::sync::{Arc, Mutex, PoisonError};

/// Panels that a boundary adds, per panel length of it: cells that it cuts are kept when half is
/// left, more or less.
const RIM_PANELS: f64 = 0.12;

/// Rounds in which curvature is looked at from nearer where panels are smaller.
const NEARER: usize = 2;

/// Curvature at the scale of the panels, and their length at each vertex of a level.
#[derive(Clone)]
pub(super) struct SizedCurvature {
    pub curvature: Curvature,
    pub length: PerVertex<f64>,
}

/// What curvature and lengths on one target depend on.
#[derive(Clone, PartialEq)]
struct CurvatureKey {
    level: usize,
    panels: usize,
    curvature: CurvatureOptions,
    sizes: SizeOptions,
    field: Option<Vec<f64>>,
}

/// Curvature and lengths on one target that have been computed before: other members of a
/// portfolio, and later runs of a session, find them here.
#[derive(Clone, Default)]
pub(super) struct KnownCurvature(Arc<Mutex<Vec<(CurvatureKey, SizedCurvature)>>>);

impl KnownCurvature {
    /// The same that was computed before, or what is computed now.
    pub fn at(
        &self,
        smooth: &SmoothTarget,
        level: usize,
        panels: usize,
        options: &MeshOptions,
    ) -> SizedCurvature {
        let key = CurvatureKey {
            level,
            panels,
            curvature: options.curvature.clone(),
            sizes: options.sizes.clone(),
            field: options.size_field.clone(),
        };
        // What panicked has put nothing half-done here.
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().iter().find(|(k, _)| *k == key).map(|f| f.1.clone());
        if let Some(found) = found {
            return found;
        }
        let made = SizedCurvature::new(smooth, level, panels, options);
        let mut known = known();
        if known.len() == KEPT {
            known.remove(0);
        }
        known.push((key, made.clone()));
        made
    }
}

/// What a session keeps at most, the last ones: a run needs a few of them.
const KEPT: usize = 16;

impl SizedCurvature {
    /// Where curvature makes panels smaller, it is estimated again at their scale: at that of large
    /// panels the tip of a horn is smoothed away.
    fn new(smooth: &SmoothTarget, level: usize, panels: usize, options: &MeshOptions) -> Self {
        let sizes = Sizes::new(smooth, level, panels, options);
        let (surface, uniform) = (sizes.surface, sizes.uniform);
        let mut curvature = curvature::curvature(surface, uniform, &options.curvature);
        let mut length = sizes.with(&curvature);
        let rounds = options.sizes.adaptive.map_or(0, |_| NEARER);
        for _ in 0..rounds {
            curvature = curvature::curvature_sized(surface, &length, &options.curvature);
            length = sizes.with(&curvature);
        }
        Self { curvature, length }
    }
}

/// Distance of sheets from each other, in lengths of uniform panels, from which on it does not
/// matter: no panel becomes that long.
const THICK: f64 = 4.0;

/// What panel lengths on a level depend on besides its curvature.
pub(super) struct Sizes<'a> {
    surface: &'a TriangleSurface,
    panels: usize,
    /// Length of the panels if all are alike.
    uniform: f64,
    options: &'a SizeOptions,
    thickness: Option<PerVertex<f64>>,
    field: Option<PerVertex<f64>>,
}

impl<'a> Sizes<'a> {
    pub fn new(
        smooth: &'a SmoothTarget,
        level: usize,
        panels: usize,
        options: &'a MeshOptions,
    ) -> Self {
        let surface = &smooth.levels[level];
        let uniform = panel_length(surface, panels);
        let adaptive = options.sizes.adaptive;
        let field = options.size_field.as_deref();
        Self {
            thickness: adaptive.map(|_| thickness(surface, THICK * uniform)),
            field: field.map(|values| refined_sizes(smooth, level, values)),
            options: &options.sizes,
            surface,
            panels,
            uniform,
        }
    }

    /// Panel length at each vertex.
    pub fn with(&self, curvature: &Curvature) -> PerVertex<f64> {
        let principal = curvature.principal();
        let demands = Demands {
            principal: &principal,
            thickness: self.thickness.as_ref(),
            field: self.field.as_ref(),
        };
        let relative = |base| size::relative_sizes(self.surface, &demands, base, self.options);
        let mut base = self.uniform;
        // The largest length depends on how much of the surface is finer, and that on the largest
        // length.
        for _ in 0..8 {
            let Some(relative) = relative(base) else {
                break;
            };
            let next = size::base_length(self.surface, &relative, CELL, self.panels);
            if (next / base).ln().abs() < 1e-3 {
                return relative.map(|r| r * next);
            }
            base = next;
        }
        let uniform = || PerVertex::filled(self.surface.positions().len(), self.uniform);
        relative(base).map_or_else(uniform, |r| r.map(|r| r * base))
    }
}

fn refined_sizes(smooth: &SmoothTarget, level: usize, values: &[f64]) -> PerVertex<f64> {
    let start = PerVertex::from_vec(values.iter().map(|v| v.ln()).collect());
    let steps = smooth.refinements[..level].iter();
    steps
        .fold(start, |field, step| step.apply(&field))
        .map(|l| l.exp())
}

/// Distance of neighbouring panel centres for a number of panels, of which the boundary cuts some.
pub(super) fn panel_length(surface: &TriangleSurface, panels: usize) -> f64 {
    let rim = boundary_length(surface);
    // area / (CELL L^2) + RIM_PANELS rim / L = panels
    let (a, b, n) = (surface.area() / CELL, RIM_PANELS * rim, panels as f64);
    (b + (b * b + 4.0 * n * a).sqrt()) / (2.0 * n)
}

/// Length of a surface's boundary.
pub(super) fn boundary_length(surface: &TriangleSurface) -> f64 {
    let edges = surface.topology().boundary_edges();
    edges.map(|e| surface.edge_length(e)).sum()
}

/// Distance of the centres of regular panels that share a surface's area.
pub(super) fn mean_length(surface: &TriangleSurface, panels: usize) -> f64 {
    (surface.area() / (CELL * panels as f64)).sqrt()
}
