//! What panels are laid out on, and how they come back to the boundary.

use super::options::{MeshOptions, Method};
use super::sized::{KnownCurvature, mean_length};
use crate::layout::lattice::eisenstein::CELL;
use crate::quality::USUAL_DEVIATION;
use crate::smooth_surface::extend::{self, Extension};
use crate::smooth_surface::teeth::{Calmed, LARGEST_TOOTH, without_teeth};
use crate::smooth_surface::{
    self, Coarsened, CutShort, Normalised, SmoothTarget, TargetKind, boundary_corners,
};
use crate::trim::{self, Boundary, Domain, TrimError, Trimmed};
use phex_mesh::{HexMesh, PerVertex, TriangleSurface, Vec3};
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

/// What panels are laid out on: the surface, or with its boundary trimmed later the surface and a
/// strip beyond it; with fewer vertices where the input is finer than panels need.
#[derive(Clone)]
pub(crate) struct Ground {
    /// Its smooth levels.
    pub smooth: Arc<SmoothTarget>,
    /// The surface as it was given, normalised; and the same, perhaps extended.
    given: TriangleSurface,
    facets: TriangleSurface,
    /// What panels are kept close to where they are laid out on fewer vertices.
    finer: Option<TriangleSurface>,
    /// How the level of the fewest vertices came from the input.
    source: Arc<Reduced>,
    trimming: Option<Arc<Trimming>>,
    /// Panels on the surface.
    pub asked: usize,
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
    /// Both surfaces.
    pub(crate) fn surfaces(&self) -> [&TriangleSurface; 2] {
        [&self.smooth, &self.facets]
    }

    /// The same in model coordinates.
    pub(crate) fn restored(&self, model: &Normalised) -> Self {
        Self {
            smooth: model.restored(&self.smooth),
            facets: model.restored(&self.facets),
        }
    }
}

/// An input on its way to the vertices that panels are laid out on.
struct Reduced {
    /// The input without the teeth of its boundary.
    calm: Option<Calmed>,
    /// That with long triangles cut short.
    cut: Option<CutShort>,
    /// That with fewer vertices.
    coarse: Option<Coarsened>,
}

impl Reduced {
    fn of(input: &TriangleSurface, panels: usize, options: &MeshOptions) -> Self {
        let most = LARGEST_TOOTH * options.optimise.max_deviation.unwrap_or(USUAL_DEVIATION);
        // Methods by planes name vertices of the input: they get all of them.
        let is_laid_out = options.method.lays_out();
        let calm = is_laid_out.then(|| without_teeth(input, most)).flatten();
        let near = calm.as_ref().map_or(input, |c| &c.part.surface);
        let cut = without_long_triangles(near, panels, options);
        let near = cut.as_ref().map_or(near, |c| &c.surface);
        let coarse = with_fewer_vertices(near, cut.is_some(), panels, options);
        Self { calm, cut, coarse }
    }

    /// The last surface that has all the vertices of the input but teeth.
    fn near<'a>(&'a self, input: &'a TriangleSurface) -> &'a TriangleSurface {
        let calm = self.calm.as_ref().map(|c| &c.part.surface);
        let cut = self.cut.as_ref().map(|c| &c.surface);
        cut.or(calm).unwrap_or(input)
    }

    /// Values at the vertices that panels are laid out on, from those at the input's.
    fn carried(&self, values: &[f64]) -> Vec<f64> {
        let mut values = PerVertex::from_vec(values.to_vec());
        if let Some(calm) = &self.calm {
            values = calm.part.source.map(|v| values[*v]);
        }
        if let Some(cut) = &self.cut {
            values = cut.carried(values);
        }
        if let Some(coarse) = &self.coarse {
            values = coarse.source.map(|v| values[*v]);
        }
        values.into_vec()
    }
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
        given: &TriangleSurface,
        panels: usize,
        options: &MeshOptions,
        width: f64,
    ) -> Self {
        let source = Reduced::of(given, panels, options);
        let near = source.near(given);
        let facets = source.coarse.as_ref().map_or(near, |c| &c.surface);
        let is_coarse = source.coarse.is_some();
        let smooth = |surface: &TriangleSurface, panels: usize| {
            let needed = options.cell_vertices(panels) as usize;
            // One step brings a surface with fewer vertices there, but for a few at its boundary.
            let vertices = match is_coarse {
                true => needed.min(surface.positions().len() + 1),
                false => needed,
            };
            smooth_surface::smooth_target(surface, vertices, &options.target)
        };
        let length = mean_length(given, panels);
        let extended = |s: &TriangleSurface| extend::extend(s, width, WHOLE_STRIP * length);
        let with_strip = |s: &TriangleSurface| extended(s).map_or_else(|| s.clone(), |e| e.surface);
        let extension = extended(facets);
        let all = extension.as_ref().map_or(facets, |e| &e.surface);
        let share = all.area() / facets.area();
        let panels_in_all = (share * panels as f64).round() as usize;
        let all_facets = match is_coarse || source.calm.is_some() {
            true => with_strip(given),
            false => all.clone(),
        };
        let finer = is_coarse.then(|| match near.is_clone_of(given) {
            true => all_facets.clone(),
            false => with_strip(near),
        });
        Self {
            smooth: Arc::new(smooth(all, panels_in_all)),
            given: given.clone(),
            facets: all_facets,
            finer,
            asked: panels,
            panels: panels_in_all,
            known: KnownCurvature::default(),
            options: options.clone(),
            trimming: extension.map(|extension| {
                Arc::new(Trimming {
                    smooth: smooth(facets, panels),
                    extension,
                })
            }),
            source: Arc::new(source),
        }
        .with_options(options)
    }

    /// How far teeth of its boundary stand out of what panels are laid out on, where it has some.
    pub(crate) fn calmed(&self) -> Option<f64> {
        self.source.calm.as_ref().map(|calm| calm.moved)
    }

    /// Whether panels are laid out on more than the surface; triangles of its levels are then known
    /// by their numbers.
    pub(crate) fn is_extended(&self) -> bool {
        self.trimming.is_some()
    }

    /// The ground of the same surface for other options.
    pub(super) fn again(&self, options: &MeshOptions) -> Self {
        Self::new(&self.given, self.asked, options)
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
        if let Some(values) = &mut options.size_field {
            *values = self.source.carried(values);
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
            (_, Some(finer)) => finer,
            _ => fine,
        }
    }

    /// The same without the strip.
    pub fn reported<'a>(&'a self, fine: &'a TriangleSurface) -> &'a TriangleSurface {
        match (self.options.target.kind, &self.finer, &self.trimming) {
            (TargetKind::Facets, _, _) => &self.given,
            (_, Some(_), _) => self.source.near(&self.given),
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
            return Ok(Trimmed::whole(mesh.clone()));
        };
        let domain = Domain {
            extended: fine,
            extension: &trimming.extension,
            levels: self.smooth.refinements.len(),
            original: trimming.smooth.finest(),
            corner_angle: self.options.target.corner_angle.to_radians(),
            limit: self.options.boundary_limit(),
        };
        trim::trim(mesh, &domain, self.options.boundary)
    }
}

/// Vertices on which panels are laid out where the input has more: one refinement brings them to
/// what cells need.
fn wanted(panels: usize, options: &MeshOptions) -> usize {
    let before = (0.25 * options.cell_vertices(panels)).max(options.field_vertices(panels));
    (ENOUGH * before) as usize
}

/// The input with long triangles cut short, where it has many.
pub(super) fn without_long_triangles(
    input: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
) -> Option<CutShort> {
    let mirrors = options.directions.mirrors.iter();
    let mirrors: Vec<[Vec3; 2]> = mirrors.map(|m| [m.point.into(), m.normal.into()]).collect();
    let is_laid_out =
        options.method == Method::Lattice && options.target.kind != TargetKind::HalfWay;
    let evenly = !options.varies_sizes();
    is_laid_out
        .then(|| smooth_surface::cut_short(input, (wanted(panels, options), evenly), &mirrors))
        .flatten()
}

/// The input with fewer vertices, where it has many more than cells need, or long triangles were
/// cut.
fn with_fewer_vertices(
    input: &TriangleSurface,
    was_cut: bool,
    panels: usize,
    options: &MeshOptions,
) -> Option<Coarsened> {
    let many = FINE * options.cell_vertices(panels);
    let is_fine = was_cut || input.positions().len() as f64 > many;
    (is_fine && options.method.lays_out()).then(|| {
        let corners = boundary_corners(input, options.target.corner_angle.to_radians());
        smooth_surface::coarsened(input, &corners, wanted(panels, options))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips of a vault, half a turn of a cylinder of radius 1 and length 3.
    fn strips() -> TriangleSurface {
        let ends = |j: u32| {
            let angle = std::f64::consts::PI * f64::from(j) / 40.0;
            [0.0, 3.0].map(|x| Vec3::new(x, angle.cos(), angle.sin()))
        };
        let triangles = (0..40).flat_map(|j| {
            let [a, b, c, d] = [2 * j, 2 * j + 1, 2 * j + 3, 2 * j + 2];
            [[a, b, c], [a, c, d]]
        });
        let places = (0..=40).flat_map(ends).collect();
        TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn panels_on_long_strips_have_vertices_near_one_another() {
        let strips = strips();
        let size_field = strips.positions().iter().map(|p| 1.0 + p.x).collect();
        let options = MeshOptions {
            size_field: Some(size_field),
            ..MeshOptions::default()
        };
        let ground = Ground::new(&strips, 200, &options);
        let fine = ground.smooth.finest();
        let lengths = fine.topology().edges().map(|e| fine.edge_length(e));
        let longest = lengths.fold(0.0, f64::max);
        let panel = mean_length(&strips, 200);
        assert!(longest < 0.6 * panel, "{longest} of {panel}");
        let vertices = fine.positions().len() as f64 / options.cell_vertices(200);
        assert!((0.8..1.5).contains(&vertices), "{vertices}");
        // Sizes asked for at the two ends are those between them on the way.
        let sizes = ground.options.size_field.unwrap();
        let first = &ground.smooth.levels[0];
        assert_eq!(sizes.len(), first.positions().len());
        for (size, p) in sizes.iter().zip(first.positions().iter()) {
            assert!((size - 1.0 - p.x).abs() < 0.02, "{size} at {p}");
        }
    }
}
