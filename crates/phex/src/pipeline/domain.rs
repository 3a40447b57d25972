//! What panels are laid out on, and how they come back to the boundary.

use super::options::MeshOptions;
use crate::layout::lattice::CELL;
use crate::smooth_surface::extend::{self, Extension};
use crate::smooth_surface::{self, SmoothTarget, TargetKind};
use crate::trim::{self, Boundary, Domain, TrimError, Trimmed};
use phex_mesh::{HexMesh, PerFace, TriangleSurface, Vec3};

/// Width of the strip beyond the boundary for whole panels, in panel lengths: two rows, so that
/// where rows run along the strip's edge they run along the boundary, too.
pub(crate) const WHOLE_STRIP: f64 = 2.0 * CELL;
/// The same for clipped panels: as much as is cut off a row that runs along the boundary.
const CLIP_STRIP: f64 = 0.2;

/// Holes no longer round than this many panel lengths are closed while panels are laid out, and cut
/// out of them afterwards: rows can't go round a hole of a panel or two without slivers.
const SMALL_HOLE: f64 = 7.0;

/// What panels are laid out on: the surface, or with its boundary trimmed later the surface and a
/// strip beyond it.
#[derive(Clone)]
pub(crate) struct Ground {
    /// Its smooth levels.
    pub smooth: SmoothTarget,
    /// The surface as it was given, normalised and perhaps extended.
    facets: TriangleSurface,
    trimming: Option<Trimming>,
    /// Panels on all of it.
    pub panels: usize,
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
    let length = (surface.area() / (CELL * panels.max(1) as f64)).sqrt();
    let extension = extend::extend(surface, WHOLE_STRIP * length, SMALL_HOLE * length);
    extension.map(|e| e.surface)
}

impl Beyond {
    /// The same with all points mapped by a similarity.
    pub(crate) fn moved(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        Self {
            smooth: moved(&self.smooth, &map),
            facets: moved(&self.facets, &map),
        }
    }
}

/// What panels are trimmed to.
#[derive(Clone)]
struct Trimming {
    extension: Extension,
    smooth: SmoothTarget,
    facets: TriangleSurface,
}

impl Ground {
    pub fn new(facets: &TriangleSurface, panels: usize, options: &MeshOptions) -> Self {
        let length = (facets.area() / (CELL * panels as f64)).sqrt();
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
        let density = options.cell_density.max(options.field_density);
        let smooth = |surface: &TriangleSurface, panels: usize| {
            smooth_surface::smooth_target(
                surface,
                (density * panels as f64) as usize,
                &options.target,
            )
        };
        let length = (facets.area() / (CELL * panels as f64)).sqrt();
        let extension = extend::extend(facets, width, SMALL_HOLE * length);
        let Some(extension) = extension else {
            return Self {
                smooth: smooth(facets, panels),
                facets: facets.clone(),
                trimming: None,
                panels,
                options: options.clone(),
            };
        };
        let share = extension.surface.area() / facets.area();
        let panels_in_all = (share * panels as f64).round() as usize;
        Self {
            smooth: smooth(&extension.surface, panels_in_all),
            facets: extension.surface.clone(),
            panels: panels_in_all,
            options: extended_options(options, &extension),
            trimming: Some(Trimming {
                smooth: smooth(facets, panels),
                facets: facets.clone(),
                extension,
            }),
        }
    }

    /// Whether panels are laid out on more than the surface; triangles of its levels are then known
    /// by their numbers.
    pub(crate) fn is_extended(&self) -> bool {
        self.trimming.is_some()
    }

    /// The same with other levels of its surface.
    pub(crate) fn with_smooth(&self, smooth: SmoothTarget) -> Self {
        Self {
            smooth,
            facets: self.facets.clone(),
            trimming: self.trimming.clone(),
            panels: self.panels,
            options: self.options.clone(),
        }
    }

    /// The level on which directions and lattice are computed.
    pub(crate) fn field_level(&self, options: &MeshOptions) -> usize {
        let vertices = options.field_density * self.panels as f64;
        self.smooth.level_with(vertices)
    }

    /// The smooth surface without the strip.
    pub fn given(&self) -> &SmoothTarget {
        self.trimming.as_ref().map_or(&self.smooth, |t| &t.smooth)
    }

    /// The surface that panels are kept close to.
    pub fn close_to<'a>(&'a self, fine: &'a TriangleSurface) -> &'a TriangleSurface {
        match self.options.target.kind {
            TargetKind::Facets => &self.facets,
            _ => fine,
        }
    }

    /// The same without the strip.
    pub fn reported<'a>(&'a self, fine: &'a TriangleSurface) -> &'a TriangleSurface {
        match (&self.trimming, self.options.target.kind) {
            (None, _) => self.close_to(fine),
            (Some(trimming), TargetKind::Facets) => &trimming.facets,
            (Some(trimming), _) => trimming.smooth.finest(),
        }
    }

    /// The facets that were given, without the strip.
    pub(crate) fn given_facets(&self) -> &TriangleSurface {
        let trimming = self.trimming.as_ref();
        trimming.map_or(&self.facets, |trimming| &trimming.facets)
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

/// A surface with its points mapped by a similarity.
pub(crate) fn moved(surface: &TriangleSurface, f: impl Fn(Vec3) -> Vec3) -> TriangleSurface {
    let positions = surface.positions().map(|p| f(*p)).into_vec();
    let triangles: Vec<[u32; 3]> = surface
        .topology()
        .face_lists()
        .into_iter()
        .map(|f| [f[0], f[1], f[2]])
        .collect();
    TriangleSurface::new(positions, &triangles)
        .expect("a similarity keeps a manifold a manifold")
        .with_normals(surface.normals().clone())
}

/// Options for the extended surface: sizes go on from the boundary.
fn extended_options(options: &MeshOptions, extension: &Extension) -> MeshOptions {
    let mut options = options.clone();
    if let Some(values) = &mut options.size_field {
        let beyond = extension.origin.iter().skip(values.len());
        let beyond: Vec<f64> = beyond
            .filter_map(|v| values.get(v.index()).copied())
            .collect();
        values.extend(beyond);
    }
    options
}
