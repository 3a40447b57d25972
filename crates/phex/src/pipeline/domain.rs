//! What panels are laid out on, and how they come back to the boundary.

use super::options::{MeshOptions, Method};
use super::sized::{KnownCurvature, mean_length};
use crate::layout::lattice::eisenstein::CELL;
use crate::quality::USUAL_DEVIATION;
use crate::smooth_surface::extend::{self, Extension};
use crate::smooth_surface::teeth::without_teeth;
use crate::smooth_surface::{
    self, Coarsened, Normalised, SmoothTarget, TargetKind, boundary_corners,
};
use crate::trim::{self, Boundary, Domain, TrimError, Trimmed};
use phex_mesh::{HexMesh, PerFace, PerVertex, TriangleSurface, VertexId};
use std::sync::Arc;

/// Width of the strip beyond the boundary for whole panels, in panel lengths: two rows, so that
/// where rows run along the strip's edge they run along the boundary, too.
pub(crate) const WHOLE_STRIP: f64 = 2.0 * CELL;
/// The same for clipped panels: as much as is cut off a row that runs along the boundary.
const CLIP_STRIP: f64 = 0.2;

/// Vertices of an input over those that panels need from which on panels are laid out on fewer of
/// them.
const FINE: f64 = 1.3;
/// Vertices that are left then, over those that directions and lattice need.
const ENOUGH: f64 = 1.1;

/// Share of the largest distance between panels and surface by which teeth of its boundary are
/// moved to make that calm.
const LARGEST_TOOTH: f64 = 0.8;

/// What panels are laid out on: the surface, or with its boundary trimmed later the surface and a
/// strip beyond it; with fewer vertices where the input is finer than panels need.
#[derive(Clone)]
pub(crate) struct Ground {
    /// Its smooth levels.
    pub smooth: Arc<SmoothTarget>,
    /// The surface as it was given, normalised; and the same, perhaps extended.
    given: TriangleSurface,
    facets: TriangleSurface,
    /// What panels are compared with where they are laid out on fewer vertices.
    finer: Option<Finer>,
    /// The vertex of the input that each vertex of the level of the fewest vertices is, where there
    /// are others.
    source: Option<Arc<PerVertex<VertexId>>>,
    /// How far teeth of its boundary stand out of what panels are laid out on, where it has some.
    pub calmed: Option<f64>,
    trimming: Option<Arc<Trimming>>,
    /// Panels on all of it.
    pub panels: usize,
    /// Curvature and panel lengths that have been computed on it.
    pub(super) known: KnownCurvature,
    /// Options as they apply to it.
    pub options: MeshOptions,
}

/// A surface continued beyond its boundary.
#[derive(Clone)]
pub struct Beyond {
    /// The smooth surface that panels were kept close to.
    pub smooth: TriangleSurface,
    /// The input's facets and the strip that was added to them.
    pub facets: TriangleSurface,
}

/// A surface continued beyond its boundary as far as whole panels may stick out, where there are so
/// many; `None` if it is closed.
pub fn continued(surface: &TriangleSurface, panels: usize) -> Option<TriangleSurface> {
    let length = mean_length(surface, panels.max(1));
    let extension = extend::extend(surface, WHOLE_STRIP * length, WHOLE_STRIP * length);
    extension.map(|e| e.surface)
}

impl Beyond {
    /// The same in model coordinates.
    pub(crate) fn restored(&self, model: &Normalised) -> Self {
        Self {
            smooth: model.restored(&self.smooth),
            facets: model.restored(&self.facets),
        }
    }
}

/// An input that is finer than panels need, without its teeth; and the same, perhaps extended.
#[derive(Clone)]
struct Finer {
    reported: TriangleSurface,
    close: TriangleSurface,
}

/// What panels are trimmed to.
struct Trimming {
    extension: Extension,
    smooth: SmoothTarget,
}

impl Ground {
    pub fn new(facets: &TriangleSurface, panels: usize, options: &MeshOptions) -> Self {
        let length = mean_length(facets, panels);
        let width = match options.boundary {
            Boundary::Snap => 0.0,
            Boundary::Whole => WHOLE_STRIP * length,
            Boundary::Clip => CLIP_STRIP * length,
        };
        Self::with_strip(facets, panels, options, width)
    }

    /// The same with a strip of another width beyond the boundary, 0 for none.
    pub(crate) fn with_strip(
        facets: &TriangleSurface,
        panels: usize,
        options: &MeshOptions,
        width: f64,
    ) -> Self {
        let given = facets;
        let most = LARGEST_TOOTH * options.optimise.max_deviation.unwrap_or(USUAL_DEVIATION);
        // Methods by planes name vertices of the input: they get all of them.
        let is_laid_out = matches!(options.method, Method::Lattice | Method::BrickWall);
        let calm = is_laid_out.then(|| without_teeth(given, most)).flatten();
        let part = calm.as_ref().map(|c| &c.part);
        let near = part.map_or(given, |c| &c.surface);
        let coarse = with_fewer_vertices(near, panels, options);
        let facets = coarse.as_ref().map_or(near, |c| &c.surface);
        let parts = part.into_iter().chain(&coarse).map(|c| &c.source);
        let source = parts.cloned().reduce(|of, part| part.map(|v| of[*v]));

        let density = options.cell_density.max(options.field_density);
        let smooth = |surface: &TriangleSurface, panels: usize| {
            let needed = (density * panels as f64) as usize;
            // One step brings a surface with fewer vertices there, but for a few at its boundary.
            let next = (coarse.as_ref()).map(|_| surface.positions().len() + 1);
            let vertices = next.map_or(needed, |next| next.min(needed));
            smooth_surface::smooth_target(surface, vertices, &options.target)
        };
        let length = mean_length(given, panels);
        let extended = |s: &TriangleSurface| extend::extend(s, width, WHOLE_STRIP * length);
        let with_strip = |s: &TriangleSurface| extended(s).map_or_else(|| s.clone(), |e| e.surface);
        let finer = (coarse.as_ref()).map(|_| Finer {
            reported: near.clone(),
            close: with_strip(near),
        });
        let extension = extended(facets);
        let share = (extension.as_ref()).map_or(1.0, |e| e.surface.area() / facets.area());
        let panels_in_all = (share * panels as f64).round() as usize;
        let all = extension.as_ref().map_or(facets, |e| &e.surface);
        Self {
            smooth: Arc::new(smooth(all, panels_in_all)),
            given: given.clone(),
            facets: match source {
                Some(_) => with_strip(given),
                None => all.clone(),
            },
            finer,
            source: source.map(Arc::new),
            calmed: calm.as_ref().map(|c| c.moved),
            panels: panels_in_all,
            known: KnownCurvature::default(),
            options: options.clone(),
            trimming: extension.map(|extension| {
                Arc::new(Trimming {
                    smooth: smooth(facets, panels),
                    extension,
                })
            }),
        }
        .with_options(options)
    }

    /// Whether panels are laid out on more than the surface; triangles of its levels are then known
    /// by their numbers.
    pub(crate) fn is_extended(&self) -> bool {
        self.trimming.is_some()
    }

    /// The same with other levels of its surface.
    pub(crate) fn with_smooth(&self, smooth: SmoothTarget) -> Self {
        Self {
            smooth: Arc::new(smooth),
            known: KnownCurvature::default(),
            ..self.clone()
        }
    }

    /// The same with other options, of which none changes the ground.
    pub(super) fn with_options(&self, options: &MeshOptions) -> Self {
        let mut options = options.clone();
        if let (Some(values), Some(source)) = (&mut options.size_field, &self.source) {
            *values = source.iter().map(|v| values[v.index()]).collect();
        }
        if let (Some(values), Some(trimming)) = (&mut options.size_field, &self.trimming) {
            let origin = trimming.extension.origin.iter().skip(values.len());
            let beyond: Vec<f64> =
                (origin.filter_map(|v| values.get(v.index()).copied())).collect();
            values.extend(beyond);
        }
        Self {
            options,
            ..self.clone()
        }
    }

    /// The level on which directions and lattice are computed.
    pub(crate) fn field_level(&self, options: &MeshOptions) -> usize {
        self.smooth.level_with(options.field_vertices(self.panels))
    }

    /// The smooth surface without the strip.
    pub fn given(&self) -> &SmoothTarget {
        self.trimming.as_ref().map_or(&self.smooth, |t| &t.smooth)
    }

    /// The surface that panels are kept close to.
    pub fn close_to<'a>(&'a self, fine: &'a TriangleSurface) -> &'a TriangleSurface {
        match (self.options.target.kind, &self.finer) {
            (TargetKind::Facets, _) => &self.facets,
            (_, Some(finer)) => &finer.close,
            _ => fine,
        }
    }

    /// The same without the strip.
    pub fn reported<'a>(&'a self, fine: &'a TriangleSurface) -> &'a TriangleSurface {
        match (self.options.target.kind, &self.finer, &self.trimming) {
            (TargetKind::Facets, _, _) => &self.given,
            (_, Some(finer), _) => &finer.reported,
            (_, _, Some(trimming)) => trimming.smooth.finest(),
            _ => fine,
        }
    }

    /// The facets that were given, without the strip.
    pub(crate) fn given_facets(&self) -> &TriangleSurface {
        &self.given
    }

    /// The surface beyond the boundary, where panels that stay whole may stick out.
    pub fn beyond(&self, fine: &TriangleSurface) -> Option<Beyond> {
        let whole = self.options.boundary == Boundary::Whole;
        (whole && self.trimming.is_some()).then(|| Beyond {
            smooth: self.close_to(fine).clone(),
            facets: self.facets.clone(),
        })
    }

    /// Panels brought back to the boundary.
    pub fn trimmed(&self, mesh: &HexMesh, fine: &TriangleSurface) -> Result<Trimmed, TrimError> {
        let Some(trimming) = &self.trimming else {
            return Ok(Trimmed {
                mesh: mesh.clone(),
                parent: PerFace::from_vec(mesh.topology().faces().collect()),
            });
        };
        let domain = Domain {
            extended: fine,
            extension: &trimming.extension,
            levels: self.smooth.refinements.len(),
            original: trimming.smooth.finest(),
            corner_angle: self.options.target.corner_angle.to_radians(),
        };
        trim::trim(mesh, &domain, self.options.boundary)
    }
}

/// The input with fewer vertices, where it has many more than are `needed`.
fn with_fewer_vertices(
    input: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
) -> Option<Coarsened> {
    let needed = options.cell_density.max(options.field_density) * panels as f64;
    let is_lattice = options.method == Method::Lattice;
    let is_fine = is_lattice && input.positions().len() as f64 > FINE * needed;
    is_fine.then(|| {
        let corners = boundary_corners(input, options.target.corner_angle.to_radians());
        let wanted = (0.25 * needed).max(options.field_vertices(panels));
        smooth_surface::coarsened(input, &corners, (ENOUGH * wanted) as usize)
    })
}
