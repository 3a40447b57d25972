//! What patches are laid on, kept close to, and judged by.

use super::patch::{Built, Patch};
use crate::layout::{Layout, PanelWish, VertexKind};
use crate::optimise::{
    BoundaryHold, FaceLimits, LocalPart, OptimiseOptions, PUT_THERE, ShapeWish, SurfaceTarget,
    Target,
};
use crate::progress::{Progress, Quiet};
use crate::quality::{Judge, Judgement, Scope, Shapes, Yardstick};
use phex_mesh::measure::{LEAST_RIM_AREA, wanted_clearance};
use phex_mesh::{FaceId, FlatFace, HexMesh, PerFace, PerVertex, TriangleSurface, Vec3, VertexId};
use std::collections::BTreeSet;

/// Area that small panels at the boundary are to have, over what does not count as small, and
/// angle of sharp corners, over what does not count as sharp.
const SAFE: f64 = 1.02;

/// Share of the largest distance beyond which points of the surface are drawn to panels.
const FAR: f64 = 0.7;

/// Areas that panels are to have, at the vertices of a surface.
pub struct AreaField<'a> {
    /// The surface.
    pub surface: &'a TriangleSurface,
    /// The areas.
    pub wish: &'a PerVertex<PanelWish>,
}

impl AreaField<'_> {
    /// Areas that panels with their middles at points are to have.
    fn at(&self, points: &[Vec3]) -> Vec<PanelWish> {
        let topology = self.surface.topology();
        let feet = self.surface.closest_points(points).into_iter();
        feet.map(|foot| self.wish[topology.face_vertices(foot.triangle)[0]])
            .collect()
    }

    /// Areas that the panels of a mesh are to have, in any unit.
    pub fn wished(&self, mesh: &HexMesh) -> PerFace<f64> {
        let wishes = self.at(mesh.centres().as_slice()).into_iter();
        let areas = wishes.map(|wish| wish.area);
        PerFace::from_vec(areas.collect())
    }
}

/// What a mesh is searched with.
pub struct Site<'a> {
    /// The judge.
    pub judge: &'a Judge<'a>,
    /// The surface that panels are kept close to.
    pub close_to: &'a SurfaceTarget<'a>,
    /// The boundary that panels end at; `None` where they rest.
    pub hold: Option<BoundaryHold>,
    /// Unit normals of mirror planes through the origin: panels that lie across one rest.
    pub mirrors: &'a [Vec3],
    /// Areas; `None` for any.
    pub areas: Option<AreaField<'a>>,
    /// The optimiser's options.
    pub options: &'a OptimiseOptions,
}

/// Distance beyond a mirror plane, mean edges, from which on a panel lies across it.
const ACROSS: f64 = 1e-3;

impl Site<'_> {
    /// The faces that lie across a mirror plane.
    pub(super) fn resting(&self, mesh: &HexMesh) -> BTreeSet<FaceId> {
        if self.mirrors.is_empty() {
            return BTreeSet::new();
        }
        let least = -ACROSS * mesh.mean_edge();
        let beyond = |p: Vec3| self.mirrors.iter().any(|n| n.dot(&p) < least);
        let faces = mesh.topology().faces();
        faces.filter(|f| mesh.corners(*f).any(beyond)).collect()
    }

    /// Areas that panels with their middles at points are to have.
    fn wished(&self, points: &[Vec3]) -> Vec<PanelWish> {
        (self.areas.as_ref()).map_or_else(
            || vec![PanelWish::ANY; points.len()],
            |field| field.at(points),
        )
    }

    /// Areas that panels of a mesh are to have, as much in all as they have; 0 for any.
    pub(super) fn wished_areas(&self, mesh: &HexMesh) -> Vec<f64> {
        self.areas_wished(mesh, None).0
    }

    /// Areas that panels are to have, times a scale, and the scale; that with which they are as
    /// much in all as they have if none is given. 0 for any.
    fn areas_wished(&self, mesh: &HexMesh, scale: Option<f64>) -> (Vec<f64>, f64) {
        let topology = mesh.topology();
        let wishes = self.wished(mesh.centres().as_slice());
        let inner = |f: &FaceId| !topology.is_boundary_face(*f) && wishes[f.index()].share > 0.0;
        let in_all = || {
            let areas = FlatFace::all(mesh).map(FlatFace::area);
            let has: f64 = topology.faces().filter(inner).map(|f| areas[f]).sum();
            let wants: f64 = (topology.faces().filter(inner))
                .map(|f| wishes[f.index()].area)
                .sum();
            if wants > 0.0 { has / wants } else { 1.0 }
        };
        let scale = scale.unwrap_or_else(in_all);
        let area = |f: FaceId| match inner(&f) {
            true => wishes[f.index()].area * scale,
            false => 0.0,
        };
        (topology.faces().map(area).collect(), scale)
    }

    /// Looks at a mesh.
    pub fn judged(&self, mesh: &HexMesh) -> Judgement {
        (self.judge).whole(mesh, &self.wished_areas(mesh))
    }

    /// Looks at a part.
    pub(super) fn judged_part(
        &self,
        part: &HexMesh,
        counts: &[bool],
        whole: &Whole,
        points: &[VertexId],
    ) -> Judgement {
        let scope = Scope {
            mesh: part,
            counts,
            points,
            wished: &self.areas_wished(part, Some(whole.wish_scale)).0,
        };
        self.judge.judge(&scope, &whole.yardstick)
    }

    /// What the optimiser needs to know of a part.
    fn layout(&self, part: &HexMesh) -> Layout {
        let topology = part.topology();
        let centres = part.centres();
        let feet = self.close_to.closest_points(centres.as_slice(), &[]);
        let lengths = topology.faces().map(|f| {
            let sides = topology
                .face_half_edges(f)
                .map(|h| part.edge_length(topology.edge(h)));
            sides.sum::<f64>() / topology.valence(f) as f64 * 3.0_f64.sqrt()
        });
        Layout {
            face_wish: PerFace::from_vec(self.wished(centres.as_slice())),
            ..Layout::new(
                part.clone(),
                PerVertex::filled(topology.n_vertices(), VertexKind::Interior),
                feet.iter().map(|foot| (foot.position, foot.normal)),
                PerFace::from_vec(lengths.collect()),
            )
        }
    }

    /// What the panels of a part are to have, and the points of the surface that draw them.
    fn limits(&self, part: &HexMesh, whole: &Whole, cover: Vec<Vec<Vec3>>) -> FaceLimits {
        let (topology, yardstick) = (part.topology(), &whole.yardstick);
        let (wished, _) = self.areas_wished(part, Some(whole.wish_scale));
        let areas = FlatFace::all(part).map(FlatFace::area);
        let unit = self.options.wished_clearance * yardstick.mean_edge;
        let clearance = |a: &f64| unit * wanted_clearance(a / yardstick.mean_area);
        let least = |f: FaceId| match topology.is_boundary_face(f) {
            true => SAFE * LEAST_RIM_AREA * yardstick.mean_area,
            false => 0.0,
        };
        let panels = |f: FaceId| {
            let mut limits = self.options.panel_limits(yardstick.mean_area);
            if yardstick.shapes >= Shapes::Corners {
                let wanted = yardstick.wanted_size(topology.is_boundary_face(f), wished[f.index()]);
                let least =
                    |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
                limits.min_angle = limits.min_angle.map(|angle| SAFE * angle);
                limits.max_edge = least(limits.max_edge, wanted.edge.map(|l| l / SAFE));
                let slender = wanted.aspect.map(|a| a / SAFE);
                limits.max_aspect = least(limits.max_aspect, slender);
                limits.max_area = least(limits.max_area, wanted.area.map(|a| a / SAFE));
            }
            limits
        };
        FaceLimits {
            panels: topology.faces().map(panels).collect(),
            clearance: areas.iter().map(clearance).collect(),
            shape: vec![ShapeWish::ANY; topology.n_faces()],
            area: topology.faces().map(least).collect(),
            distance: self.judge.largest_distance(),
            cover,
        }
    }

    /// The panels of a draft, made planar, and then perhaps better; `None` if that can't be done.
    pub(super) fn settled(
        &self,
        built: &Built,
        (whole, points): (&Whole, &[VertexId]),
        step: LocalStep<'_>,
        progress: &dyn Progress,
    ) -> Option<HexMesh> {
        let closest = match step {
            LocalStep::Settle | LocalStep::Cut(_) => &self.judge.closest_faces(&built.mesh, points),
            LocalStep::Improve(_, judgement) => &judgement.closest,
        };
        let (n_faces, edge) = (built.mesh.topology().n_faces(), whole.yardstick.mean_edge);
        let cover = (self.judge).far_points(n_faces, (points, closest), (edge, FAR));
        // What lies in a mirror plane and moves along the boundary would leave its image.
        let near = PUT_THERE * whole.diagonal;
        let in_plane = |p: &Vec3| self.mirrors.iter().any(|n| n.dot(p).abs() <= near);
        let places = built.mesh.positions.iter();
        let free: Vec<bool> = (places.zip(&built.free))
            .map(|(p, free)| *free && !in_plane(p))
            .collect();
        let part = LocalPart {
            layout: &self.layout(&built.mesh),
            free: &free,
            hold: self.hold.as_ref(),
            limits: &self.limits(&built.mesh, whole, cover),
        };
        let quiet = Quiet::new(progress);
        let made = match step {
            LocalStep::Settle => part.settled(self.close_to, self.options, &quiet),
            LocalStep::Improve(round, _) | LocalStep::Cut(round) => {
                part.emphasised(round, self.close_to, self.options, &quiet)
            }
        };
        Some(made.ok()?.mesh)
    }
}

/// What the optimiser does with a part.
#[derive(Clone, Copy)]
pub(super) enum LocalStep<'a> {
    /// From joined panels to planar ones.
    Settle,
    /// From panels with folds cut off, to planar ones that do not fold, in a round.
    Cut(usize),
    /// From planar panels, of which the judge says this, to better ones, in a round.
    Improve(usize, &'a Judgement),
}

/// What is known of a mesh as a whole.
pub(super) struct Whole {
    pub yardstick: Yardstick,
    pub diagonal: f64,
    /// Scale of the wished areas.
    wish_scale: f64,
    pub findings: Judgement,
    /// The vertices of the surface that each face is nearest to.
    pub covers: Vec<Vec<VertexId>>,
}

impl Whole {
    /// Looks at a mesh; what of shapes counts is given.
    pub fn of(mesh: &HexMesh, site: &Site<'_>, shapes: Shapes) -> Self {
        let mut yardstick = Yardstick::of(mesh, site.judge.limits());
        yardstick.shapes = shapes;
        let (wished, wish_scale) = site.areas_wished(mesh, None);
        let findings = site.judge.whole_by(&yardstick, mesh, &wished);
        let mut covers = vec![Vec::new(); mesh.topology().n_faces()];
        for (v, (f, _)) in site.judge.points().into_iter().zip(&findings.closest) {
            covers[f.index()].push(v);
        }
        Self {
            yardstick,
            diagonal: mesh.diagonal(),
            wish_scale,
            findings,
            covers,
        }
    }

    /// The vertices of the surface that a patch is to cover.
    pub fn points(&self, patch: &Patch) -> Vec<VertexId> {
        let faces = patch.faces.iter();
        faces
            .flat_map(|f| &self.covers[f.index()])
            .copied()
            .collect()
    }
}
