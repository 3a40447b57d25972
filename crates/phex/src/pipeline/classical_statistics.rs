//! What a method by planes and poles met with, for the report.

use crate::classical::domain::{CurvatureSign, DomainError};
use crate::classical::duality::{Flipped, OrientedPlane, without_broken_rim};
use crate::classical::projective_dual::DualDefects;
use crate::layout::Layout;
use crate::layout::forecast::forecast;
use crate::pipeline::Method;
use phex_mesh::{ElementId, FaceId, FlatFace, HexMesh, PerFace, polygon::is_simple};
use serde::Serialize;

/// What a method by planes and poles met with.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ClassicalStatistics {
    /// The method.
    pub method: Method,
    /// Signs of the Gauss curvature on the surface.
    pub curvature: CurvatureSign,
    /// The assumption of the method that does not hold, if the run went on regardless.
    pub outside_domain: Option<String>,
    /// The same as it was found, in normalised coordinates.
    #[serde(skip)]
    pub(super) outside: Option<DomainError>,
    /// Centre of the polarity, model coordinates.
    pub centre: Option<[f64; 3]>,
    /// Least distance of the centre to a tangent plane over the largest.
    pub clearness: Option<f64>,
    /// Singular points and duplicates of the dual surface.
    pub defects: Option<DualDefects>,
    /// Flips that joined the panels as their planes want it: as the convex hull where `K > 0`, by
    /// the sign rule where `K < 0`.
    pub flips: Option<usize>,
    /// Panels that were taken out on the way, because their planes cut nothing off.
    pub taken_out: usize,
    /// Class `(m, n)` of the Goldberg polyhedron.
    pub goldberg: Option<(u32, u32)>,
    /// Edges of a parallel mesh that are as short as is allowed.
    pub edges_at_bound: Option<usize>,
    /// Edges of a parallel mesh that run against those of its Gauss image.
    pub reversed_edges: Option<usize>,
    /// Mean curvature of a mesh with a Koebe mesh as Gauss image, by Steiner's formula, times the
    /// diagonal of the surface: that of the whole, and the root mean square of the panels'. (A
    /// sphere has 3.46.)
    pub mean_curvature_rel: Option<[f64; 2]>,
    /// Panels that the sign rule says will cross themselves; nothing where there is no layout to
    /// ask, or panels are those of a convex hull.
    pub forecast: Option<usize>,
    /// How many of these were taken out on the way or by the boundary.
    pub forecast_taken_out: Option<usize>,
    /// How many of these are in the mesh and cross themselves.
    pub forecast_came_true: Option<usize>,
    /// The foreseen panels that are still there, by their numbers now.
    #[serde(skip)]
    pub(super) foreseen: Vec<FaceId>,
    /// Panels of which it says they will not, but where terms of third order may decide otherwise.
    pub in_doubt: Option<usize>,
}

impl ClassicalStatistics {
    /// Adds what flips did to a mesh with so many panels.
    pub(super) fn count(&mut self, flipped: &Flipped, panels: usize) {
        let taken_out = panels - flipped.faces.len();
        self.flips = Some(self.flips.unwrap_or(0) + flipped.steps - taken_out);
        self.taken_out += taken_out;
    }

    /// The mesh without panels at the boundary for which there is no room; outside a method's
    /// domain it stays as it is.
    pub(super) fn with_sound_rim(
        &mut self,
        mesh: HexMesh,
        planes: &PerFace<OrientedPlane>,
    ) -> HexMesh {
        if self.curvature == CurvatureSign::Mixed {
            return mesh;
        }
        let (left, kept) = without_broken_rim(&mesh, planes);
        self.taken_out += planes.len() - kept.len();
        self.follow(&kept);
        left
    }

    /// Goes on with the foreseen panels among those that are left; `left` says which panel each of
    /// them was.
    pub(super) fn follow(&mut self, left: &[FaceId]) {
        let numbers = left.iter().enumerate();
        let foreseen = numbers.filter(|(_, was)| self.foreseen.contains(was));
        self.foreseen = foreseen.map(|(now, _)| FaceId::from_index(now)).collect();
    }

    /// Counts what became of the foreseen panels in the finished mesh.
    pub(super) fn compare(&mut self, mesh: &HexMesh) {
        let flat = FlatFace::all(mesh);
        let crossed = |f: &&FaceId| !is_simple(&flat[**f].polygon);
        self.forecast_taken_out = self.forecast.map(|n| n.saturating_sub(self.foreseen.len()));
        self.forecast_came_true =
            (self.forecast).map(|_| self.foreseen.iter().filter(crossed).count());
    }

    pub(super) fn foresee(&mut self, layout: &Layout) {
        let told = forecast(layout);
        self.forecast = Some(told.crossing.len());
        self.foreseen.clone_from(&told.crossing);
        self.in_doubt = Some(told.in_doubt.len());
    }
}
