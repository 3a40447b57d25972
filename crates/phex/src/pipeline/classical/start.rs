//! Where the methods start: the surface with its curvature, and a lattice that is regular in a
//! method's own metric.

use super::ClassicalStatistics;
use crate::classical::domain::{CurvatureSign, DomainError, SignedPlaces, resolved};
use crate::curvature::{self, Curvature};
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::{self, DirectionOptions, cones, saddle};
use crate::layout::lattice::eisenstein::CELL;
use crate::pipeline::domain::Ground;
use crate::pipeline::field::{Field, allow_sizes, counted_lattice, direction_options};
use crate::pipeline::sized::panel_length;
use crate::pipeline::{Clock, MeshOptions, Method, PipelineError};
use crate::smooth_surface::SmoothTarget;
use nalgebra::Matrix3;
use phex_mesh::{PerVertex, TriangleSurface};

/// The surface of the field's level with its curvature.
pub(super) struct CurvedGround<'a> {
    pub level: usize,
    pub surface: &'a TriangleSurface,
    pub curvature: Curvature,
}

impl<'a> CurvedGround<'a> {
    pub fn new(ground: &'a Ground, clock: &mut Clock<'_>) -> Result<Self, PipelineError> {
        Self::on(&ground.smooth, ground, clock)
    }

    /// On another surface than that of the ground.
    pub fn on(
        smooth: &'a SmoothTarget,
        ground: &Ground,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        // Of this surface, which may have other levels than that of the ground.
        let level = smooth.level_with(ground.options.field_vertices(ground.panels));
        let surface = &smooth.levels[level];
        let length = panel_length(surface, ground.panels);
        let curvature = clock.stage("curvature", || {
            curvature::curvature(surface, length, &ground.options.curvature)
        })?;
        Ok(Self {
            level,
            surface,
            curvature,
        })
    }

    /// The lattice that is laid out for any method, and where it starts.
    pub(crate) fn with_lattice(
        ground: &'a Ground,
        clock: &mut Clock<'_>,
    ) -> Result<(Self, Field), PipelineError> {
        let start = Self::new(ground, clock)?;
        let options = start.lattice_options(&ground.options);
        let level = ground.field_level(&options);
        let field = Field::new(ground, level, &options, clock)?;
        Ok((start, field))
    }

    fn sign(&self) -> CurvatureSign {
        SignedPlaces::find(self.surface, &self.curvature).sign()
    }

    /// Options for a lattice with few dislocations, at which planes cross. It keeps the sign rule
    /// with a margin where `K < 0`: its edges stay off the asymptotic directions, to which rows
    /// along the boundary may come too near, and it has no dislocations.
    fn lattice_options(&self, options: &MeshOptions) -> MeshOptions {
        let mut options = options.clone();
        if self.sign() == CurvatureSign::Hyperbolic {
            options.directions.saddle_alignment = SADDLE_ALIGNMENT;
            options.directions.boundary_alignment = 0.0;
            allow_sizes(&mut options);
        } else {
            options.directions.conformal_screening *= CLASSICAL_SCREENING;
        }
        options
    }

    /// Whether the given facets tell the sign of the curvature where it is negative.
    pub(crate) fn resolved(
        &self,
        ground: &Ground,
        method: &'static str,
    ) -> Result<(), DomainError> {
        match self.sign() {
            CurvatureSign::Hyperbolic => resolved(&ground.given().levels[0], method),
            _ => Ok(()),
        }
    }

    pub fn statistics(&self, method: Method) -> ClassicalStatistics {
        ClassicalStatistics {
            method,
            curvature: self.sign(),
            ..ClassicalStatistics::default()
        }
    }

    /// The lattice that is regular in a metric.
    pub fn field(
        &self,
        ground: &Ground,
        mut metric: PerVertex<Matrix3<f64>>,
        clock: &mut Clock<'_>,
    ) -> Result<Field, PipelineError> {
        let options = &self.lattice_options(&ground.options);
        let settings = DirectionOptions {
            anisotropy: 1.0,
            ..direction_options(options)
        };
        let progress = clock.progress;
        cones::prescribed_faces(self.surface, &settings.guides.cones)?;
        let (wished, weight) = saddle::wishes(
            self.surface,
            &self.curvature,
            &metric,
            options.directions.saddle_alignment,
        );
        let area: f64 = IntrinsicMesh::new(self.surface, &metric).area.iter().sum();
        let scale = CELL * ground.panels as f64 / area;
        metric.iter_mut().for_each(|m| *m *= scale);
        let mut directions = clock.stage("directions", || {
            directions::in_metric(self.surface, metric, &wished, &weight, &settings, progress)
        })??;
        let (topology, layout) = (self.surface.topology(), &options.layout);
        let (_, placed) = counted_lattice(topology, &mut directions, ground.panels, layout, clock)?;
        Ok(Field {
            level: self.level,
            curvature: self.curvature.clone(),
            directions,
            length: PerVertex::filled(
                self.surface.positions().len(),
                panel_length(self.surface, ground.panels),
            ),
            anisotropy: f64::INFINITY,
            placed,
            layout: options.layout.clone(),
        })
    }
}

/// Screening of the conformal factor, over that of lattices for the optimiser, which evens out
/// areas and mends dislocations.
const CLASSICAL_SCREENING: f64 = 0.5;
/// Weight of the alignment where `K < 0`.
const SADDLE_ALIGNMENT: f64 = 20.0;
