//! Koebe.
#![allow(missing_docs)]
mod circles;
mod graph;
mod layout;
mod polish;
mod radii;
mod sphere;

use circles::Circles;
use layout::{PlaneLayout, lay_out};
use nalgebra::Matrix3;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerEdge, PerFace, PerVertex, Topology, Vec2, Vec3, VertexId};
use phex_numeric::{NumericError, Outcome, Status};
use polish::Poles;
use radii::{Radii, RadiiOptions};
use serde::{Deserialize, Serialize};
use sphere::SphereCircles;
use thiserror::Error;

#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum KoebeError {
    #[error("the mesh has {components} components, a Koebe mesh has one")]
    Components { components: usize },
    #[error("the mesh has {boundary_loops} boundary loops, a Koebe mesh has at most one")]
    BoundaryLoops { boundary_loops: usize },
    #[error("the mesh has genus {genus}: its graph is not planar")]
    Genus { genus: i64 },
    #[error("vertex {vertex} has {degree} edges, at least 3 are needed")]
    LowDegree { vertex: VertexId, degree: usize },
    #[error(
        "the graph is not 3-connected: vertices {} and {} separate it (faces {} and {} share both, but no edge between them)",
        vertices[0], vertices[1], faces[0], faces[1]
    )]
    SeparatingPair { vertices: [VertexId; 2], faces: [FaceId; 2] },
    #[error("the equations could not be solved: {0}")]
    Numeric(#[from] NumericError),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KoebeOptions {
    pub max_iterations: usize,
    pub angle_tolerance: f64,
    pub max_polish_iterations: usize,
}

impl Default for KoebeOptions {
    fn default() -> Self {
        Self { max_iterations: 50, angle_tolerance: 1e-10, max_polish_iterations: 6 }
    }
}

#[derive(Clone, Debug)]
pub struct Koebe {
    pub mesh: HexMesh,
    pub face_poles: PerFace<Vec3>,
    pub outcome: Outcome,
    pub imbalance: f64,
}

/// Koebe polyhedron of a closed mesh.
pub fn koebe(mesh: &HexMesh, options: &KoebeOptions) -> Result<Koebe, KoebeError> {
    let topology = mesh.topology();
    graph::check(topology)?;
    let circles = Circles::new(topology);
    let infinite = circles_at_infinity(&circles, EdgeId::new(0));
    let mut radii = Radii::new(&circles, |n| infinite.contains(&n).then_some(f64::INFINITY));
    radii.fix_scale();
    let solve = RadiiOptions {
        max_iterations: options.max_iterations,
        tolerance: options.angle_tolerance,
    };
    let mut outcome = radii.solve(&circles, &solve)?;
    let layout = lay_out(&circles, &radii).expect("connected");
    let (origin, scale) = middle(&layout);
    let mut sphere = SphereCircles::project(&layout, origin, scale);
    let imbalance = sphere.normalise();
    let n = topology.n_vertices();
    let mut poles = Poles {
        vertices: PerVertex::from_fn(n, |v| sphere.pole(circles.of_vertex(v))),
        faces: PerFace::from_fn(topology.n_faces(), |f| sphere.pole(circles.of_face(f))),
    };
    if outcome.status == Status::Converged {
        outcome.append(polish::polish(topology, &mut poles, options.max_polish_iterations)?);
    }
    Ok(Koebe {
        mesh: mesh.with_positions(poles.vertices),
        face_poles: poles.faces,
        outcome,
        imbalance,
    })
}

fn circles_at_infinity(circles: &Circles, e: EdgeId) -> Vec<usize> {
    let t = circles.topology;
    let h = t.edge_half_edge(e);
    let faces = [Some(h), t.twin(h)].into_iter().flatten().map(|h| circles.of_face(t.face(h)));
    faces.chain(t.edge_vertices(e).map(|v| circles.of_vertex(v))).collect()
}

fn middle(layout: &PlaneLayout) -> (Vec2, f64) {
    let points: Vec<Vec2> = layout.touching.iter().flatten().copied().collect();
    let origin = Vec2::new(median(points.iter().map(|p| p.x)), median(points.iter().map(|p| p.y)));
    (origin, 1.0 / median(points.iter().map(|p| (p - origin).norm())).max(f64::MIN_POSITIVE))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
