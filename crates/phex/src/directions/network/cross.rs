//! A cross field without singularities, combed into one direction per vertex.
//!
//! `z = exp(4 i theta)` minimises `sum w |z_j - exp(4 i tau) z_i|^2 + sum c m |z - z_0|^2` with the
//! transport `tau` of a flat connection; `z_0` are the wished directions and `c` their weights.
//! Where the minimiser has singular triangles the weights are lowered, most of all in growing
//! neighbourhoods of them, until it has none: in a flat connection the smoothest field is parallel,
//! so that ends. Weights are lowered too while the field turns round a hole or a handle.

use super::super::intrinsic::IntrinsicMesh;
use super::super::rosy::connection_laplacian;
use super::NetworkError;
use super::flat::flat_transport;
use nalgebra::Complex;
use phex_mesh::{
    EdgeId, FaceId, PerEdge, PerVertex, Topology, TriangleSurface, Vec3, VertexId, spanning_forest,
};
use phex_numeric::{Cholesky, NumericError};
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, PI};

/// Symmetry of a cross.
const N: f64 = 4.0;
/// Factor of all weights from one attempt to the next.
const WEAKER: f64 = 0.5;
/// The same in the neighbourhoods of singular triangles.
const WEAKER_NEAR: f64 = 0.1;
/// Radius of the first neighbourhoods, in edges, and its growth.
const FIRST_RADIUS: f64 = 4.0;
const RADIUS_GROWTH: f64 = 1.5;
/// Attempts at the most.
const ATTEMPTS: usize = 16;
/// Weight of the parallel field that decides where nothing else does.
const TIE_BREAK: f64 = 1e-6;

/// A wished direction (modulo a quarter turn) and its weight, per square of the unit of length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionWish {
    /// Tangent, of any length but 0.
    pub direction: Vec3,
    /// Weight, at least 0.
    pub weight: f64,
}

/// A combed field and how much the wishes were weakened for it.
#[derive(Clone, Debug)]
pub(crate) struct Combed {
    /// Unit tangent at each vertex.
    pub direction: PerVertex<Vec3>,
    /// Share of the weights that was left.
    pub kept: f64,
}

/// The combed cross field that follows `wishes` as far as it can without singularities.
///
/// # Errors
/// If singularities remain, or the field turns round a hole or a handle.
pub(crate) fn combed_cross_field(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    wishes: &PerVertex<DirectionWish>,
) -> Result<Combed, NetworkError> {
    let topology = surface.topology();
    let transport = flat_transport(topology, mesh)?;
    let frames = PerVertex::from_fn(topology.n_vertices(), |v| {
        TangentFrame::new(surface, mesh, v)
    });
    let mut weights = wishes.map(|w| w.weight);
    let mut failure = NetworkError::Turning { quarter_turns: 0 };
    let mut radius = FIRST_RADIUS;
    for _ in 0..ATTEMPTS {
        let problem = CrossSmoothing {
            surface,
            mesh,
            transport: &transport,
            frames: &frames,
        };
        let angle = problem.angles(wishes, &weights)?;
        let field = CrossField {
            topology,
            transport: &transport,
            angle,
        };
        let singular = field.singular_faces();
        if singular.is_empty() {
            match field.combed() {
                Ok(angle) => return Ok(combed(&frames, &angle, kept(wishes, &weights))),
                Err(turning) => failure = turning,
            }
        } else {
            failure = NetworkError::Singular {
                count: singular.len(),
                near: surface.centroid(singular[0]),
            };
        }
        weaken(topology, &mut weights, &singular, radius as usize);
        radius *= RADIUS_GROWTH;
    }
    Err(failure)
}

fn combed(frames: &PerVertex<TangentFrame>, angle: &PerVertex<f64>, kept: f64) -> Combed {
    Combed {
        direction: PerVertex::from_fn(angle.len(), |v| frames[v].direction(angle[v])),
        kept,
    }
}

/// Share of the weights that is left.
fn kept(wishes: &PerVertex<DirectionWish>, weights: &PerVertex<f64>) -> f64 {
    let wished: f64 = wishes.iter().map(|w| w.weight).sum();
    if wished > 0.0 {
        weights.iter().sum::<f64>() / wished
    } else {
        1.0
    }
}

/// Lowers all weights, and more so those within `radius` edges of the given triangles.
fn weaken(topology: &Topology, weights: &mut PerVertex<f64>, near: &[FaceId], radius: usize) {
    let mut seen = PerVertex::filled(topology.n_vertices(), false);
    let corners = near.iter().flat_map(|&f| topology.face_vertices(f));
    let mut front: Vec<VertexId> = corners.copied().collect();
    for _ in 0..=radius {
        front.retain(|&v| !std::mem::replace(&mut seen[v], true));
        front = front.iter().flat_map(|&v| topology.neighbours(v)).collect();
    }
    for (weight, near) in weights.iter_mut().zip(&seen) {
        *weight *= if *near { WEAKER_NEAR } else { WEAKER };
    }
}

/// Number and place of the singular triangles of the field in the surface's own connection.
///
/// # Errors
/// If the linear system can't be solved.
pub(crate) fn singular_triangles(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    wishes: &PerVertex<DirectionWish>,
) -> Result<(usize, Vec3), NumericError> {
    let topology = surface.topology();
    let transport = PerEdge::from_fn(topology.n_edges(), |e| mesh.transport(e));
    let frames = PerVertex::from_fn(topology.n_vertices(), |v| {
        TangentFrame::new(surface, mesh, v)
    });
    let problem = CrossSmoothing {
        surface,
        mesh,
        transport: &transport,
        frames: &frames,
    };
    let field = CrossField {
        topology,
        transport: &transport,
        angle: problem.angles(wishes, &wishes.map(|w| w.weight))?,
    };
    let singular = field.singular_faces();
    let first = singular.first().copied().unwrap_or(FaceId::new(0));
    Ok((singular.len(), surface.centroid(first)))
}

/// Two unit tangents and the polar angle of the first.
struct TangentFrame {
    axes: [Vec3; 2],
    offset: f64,
}

impl TangentFrame {
    fn new(surface: &TriangleSurface, mesh: &IntrinsicMesh, v: VertexId) -> Self {
        let axes = crate::curvature::tangent_frame(surface.normals()[v]);
        let mut mean = Complex::new(0.0, 0.0);
        for h in surface.topology().outgoing(v) {
            let e = surface.positions()[surface.topology().target(h)] - surface.positions()[v];
            let angle = e.dot(&axes[1]).atan2(e.dot(&axes[0]));
            mean += Complex::from_polar(1.0, mesh.polar(surface.topology(), h) - angle);
        }
        Self {
            axes,
            offset: mean.arg(),
        }
    }

    fn polar(&self, d: Vec3) -> f64 {
        d.dot(&self.axes[1]).atan2(d.dot(&self.axes[0])) + self.offset
    }

    fn direction(&self, polar: f64) -> Vec3 {
        let (sin, cos) = (polar - self.offset).sin_cos();
        self.axes[0] * cos + self.axes[1] * sin
    }
}

/// What the smoothing problem is about.
struct CrossSmoothing<'a> {
    surface: &'a TriangleSurface,
    mesh: &'a IntrinsicMesh,
    transport: &'a PerEdge<f64>,
    frames: &'a PerVertex<TangentFrame>,
}

impl CrossSmoothing<'_> {
    /// Angles of the smoothest cross field that follows the wishes with the given weights.
    fn angles(
        &self,
        wishes: &PerVertex<DirectionWish>,
        weights: &PerVertex<f64>,
    ) -> Result<PerVertex<f64>, NumericError> {
        let topology = self.surface.topology();
        let mass = &self.mesh.mass;
        let parallel = self.parallel();
        let unit = |angle: f64| Complex::from_polar(1.0, N * angle);
        let source: Vec<Complex<f64>> = topology
            .vertices()
            .map(|v| {
                let wish = unit(self.frames[v].polar(wishes[v].direction)) * weights[v];
                (wish + unit(parallel[v]) * TIE_BREAK) * mass[v]
            })
            .collect();
        let diagonal = |v: VertexId| mass[v] * (weights[v] + TIE_BREAK);
        let transport = |e| N * self.transport[e];
        let matrix = connection_laplacian(topology, self.mesh, transport, 1.0, diagonal)?;
        let mut z = source;
        Cholesky::new(&matrix)?.solve(&mut z);
        Ok(PerVertex::from_vec(z.iter().map(|z| z.arg() / N).collect()))
    }

    /// Angles transported from the first vertex along a spanning tree.
    fn parallel(&self) -> PerVertex<f64> {
        let topology = self.surface.topology();
        let first = VertexId::new(0);
        let mut angle = PerVertex::filled(topology.n_vertices(), self.frames[first].offset);
        for step in spanning_forest(topology, [first], |_| true) {
            let turn = topology.away_from(step.from, step.edge, self.transport[step.edge]);
            angle[step.to] = angle[step.from] + turn;
        }
        angle
    }
}

struct CrossField<'a> {
    topology: &'a Topology,
    transport: &'a PerEdge<f64>,
    /// Polar angle of one arm of the cross at each vertex.
    angle: PerVertex<f64>,
}

impl CrossField<'_> {
    /// Quarter turns from the arm at the origin of an edge, transported, to the nearest arm at its
    /// target, and the rest.
    fn matching(&self, e: EdgeId) -> (i32, f64) {
        let [i, j] = self.topology.edge_vertices(e);
        let difference = self.angle[j] - self.angle[i] - self.transport[e];
        let turns = (difference / FRAC_PI_2).round();
        (turns as i32, difference - turns * FRAC_PI_2)
    }

    fn singular_faces(&self) -> Vec<FaceId> {
        let index = |f: FaceId| {
            let (mut rest, mut holonomy) = (0.0, 0.0);
            for h in self.topology.face_half_edges(f) {
                let e = self.topology.edge(h);
                rest += self.topology.along(h, self.matching(e).1);
                holonomy += self.topology.along(h, self.transport[e]);
            }
            let holonomy = (holonomy + PI).rem_euclid(2.0 * PI) - PI;
            ((rest + holonomy) / FRAC_PI_2).round() as i32
        };
        self.topology.faces().filter(|&f| index(f) != 0).collect()
    }

    /// Angles of the arms that follow each other along every edge.
    fn combed(&self) -> Result<PerVertex<f64>, NetworkError> {
        let n = self.topology.n_vertices();
        let mut turns: PerVertex<Option<i32>> = PerVertex::filled(n, None);
        let first = VertexId::new(0);
        turns[first] = Some(0);
        let mut queue = VecDeque::from([first]);
        while let Some(v) = queue.pop_front() {
            let here = turns[v].unwrap_or(0);
            for (e, w) in self.topology.spokes(v) {
                let turn = self.topology.away_from(v, e, self.matching(e).0);
                // The arm of `w` that continues the chosen arm of `v`.
                let wanted = (here - turn).rem_euclid(4);
                match turns[w] {
                    None => {
                        turns[w] = Some(wanted);
                        queue.push_back(w);
                    }
                    Some(found) if found != wanted => {
                        return Err(NetworkError::Turning {
                            quarter_turns: (found - wanted).rem_euclid(4),
                        });
                    }
                    Some(_) => {}
                }
            }
        }
        Ok(PerVertex::from_fn(n, |v| {
            self.angle[v] + f64::from(turns[v].unwrap_or(0)) * FRAC_PI_2
        }))
    }
}
