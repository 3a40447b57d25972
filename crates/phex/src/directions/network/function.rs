//! Functions on a surface that follow directions.
//!
//! The function `f` minimises `sum A (W (level . grad f)^2 + (across . grad f - rate)^2)` over the
//! triangles: its level lines run along `level`, strictly so for large `W`, and it grows at `rate`
//! along `across`. Along edges that are held it is constant, nearly. With periods `p_k` on the
//! cochains `omega_k` its change along an edge is `x_j - x_i + sum p_k omega_k`; the values `x`
//! depend on `rate` and on the periods linearly, `x = base + sum p_k response_k`, with one
//! factorisation for all.

use super::super::intrinsic::row;
use nalgebra::{DMatrix, DVector, Matrix3};
use phex_mesh::{FaceId, HalfEdgeId, PerEdge, PerFace, PerVertex, Topology, TriangleSurface, Vec3};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};

/// What a function should follow in a triangle: unit tangents.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Guide {
    /// Direction of the level line.
    pub level: Vec3,
    /// Direction in which the function grows, by 1 per length.
    pub across: Vec3,
}

/// A family of functions: all scales and all periods of the solution.
#[derive(Clone, Debug)]
pub(crate) struct FunctionFamily {
    base: PerVertex<f64>,
    response: Vec<PerVertex<f64>>,
    /// Periods of the best function, one per cochain of the basis.
    pub periods: Vec<f64>,
}

/// A function with given periods.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    /// Value at each vertex.
    pub value: PerVertex<f64>,
    /// Change along the half-edge of each edge; differs from the difference of the values by
    /// periods.
    pub change: PerEdge<f64>,
}

impl FunctionFamily {
    /// The function of `scale` times the rate with the given periods.
    pub fn function(
        &self,
        topology: &Topology,
        basis: &[PerEdge<i32>],
        scale: f64,
        periods: &[f64],
    ) -> Function {
        let value = PerVertex::from_fn(self.base.len(), |v| {
            let responses = self.response.iter().zip(periods);
            scale * self.base[v] + responses.map(|(r, p)| r[v] * p).sum::<f64>()
        });
        let change = PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            let jumps = basis.iter().zip(periods);
            value[j] - value[i] + jumps.map(|(c, p)| f64::from(c[e]) * p).sum::<f64>()
        });
        Function { value, change }
    }
}

impl Function {
    /// Change along a half-edge.
    pub fn along(&self, topology: &Topology, h: HalfEdgeId) -> f64 {
        topology.along(h, self.change[topology.edge(h)])
    }

    /// Values at the corners of a triangle, continued from its first corner.
    pub fn corners(&self, topology: &Topology, f: FaceId) -> [f64; 3] {
        let first = self.value[topology.face_vertices(f)[0]];
        continued(first, topology, f, |h| self.along(topology, h))
    }

    /// Gradient in a triangle.
    pub fn gradient(&self, surface: &TriangleSurface, f: FaceId) -> Vec3 {
        let values = self.corners(surface.topology(), f);
        let hats = hat_gradients(surface, f);
        hats[0] * values[0] + hats[1] * values[1] + hats[2] * values[2]
    }
}

fn continued(
    first: f64,
    topology: &Topology,
    f: FaceId,
    along: impl Fn(HalfEdgeId) -> f64,
) -> [f64; 3] {
    let mut value = first;
    let mut corners = [first; 3];
    for (corner, h) in corners[1..].iter_mut().zip(topology.face_half_edges(f)) {
        value += along(h);
        *corner = value;
    }
    corners
}

/// Gradients of the three hat functions of a triangle.
pub(crate) fn hat_gradients(surface: &TriangleSurface, f: FaceId) -> [Vec3; 3] {
    let corner = surface.corners(f);
    let normal = surface.area_vector(f);
    let scale = 1.0 / normal.norm_squared();
    std::array::from_fn(|k| normal.cross(&(corner[(k + 2) % 3] - corner[(k + 1) % 3])) * scale)
}

/// Solves for the functions that follow the guides with strictness `strictness` and are constant
/// along `held` half-edges of the boundary.
///
/// # Errors
/// If a linear system can't be solved.
pub(crate) fn following(
    surface: &TriangleSurface,
    basis: &[PerEdge<i32>],
    guides: &PerFace<Guide>,
    held: &[HalfEdgeId],
    strictness: f64,
) -> Result<FunctionFamily, NumericError> {
    let topology = surface.topology();
    let mut elements = PerFace::from_fn(guides.len(), |f| {
        Element::new(surface, f, &guides[f], strictness)
    });
    for &h in held {
        elements[topology.face(h)].hold(surface, h, strictness);
    }
    let cochain = |k: usize, f: FaceId| {
        continued(0.0, topology, f, |h| {
            f64::from(topology.along(h, basis[k][topology.edge(h)]))
        })
    };
    let mut columns = vec![load(topology, |f| elements[f].load)];
    columns.extend((0..basis.len()).map(|k| {
        load(topology, |f| {
            -(elements[f].stiffness * nalgebra::Vector3::from(cochain(k, f)))
        })
    }));
    factor(topology, &elements)?.solve_many(&mut columns);
    let mut solutions = columns.into_iter().map(PerVertex::from_vec);
    let base = solutions.next().expect("one column is the load's");
    let response: Vec<_> = solutions.collect();
    let periods = best_periods(topology, &elements, &base, &response, cochain);
    Ok(FunctionFamily {
        base,
        response,
        periods,
    })
}

struct Element {
    stiffness: Matrix3<f64>,
    load: Vec3,
}

impl Element {
    fn new(surface: &TriangleSurface, f: FaceId, guide: &Guide, strictness: f64) -> Self {
        let area = surface.face_area(f);
        let hats = hat_gradients(surface, f);
        let level = Vec3::from(hats.map(|g| g.dot(&guide.level)));
        let across = Vec3::from(hats.map(|g| g.dot(&guide.across)));
        Self {
            stiffness: (level * level.transpose() * strictness + across * across.transpose())
                * area,
            load: across * area,
        }
    }
}

/// How much more a held edge counts than the triangle at it.
const HOLD: f64 = 1e3;

impl Element {
    fn hold(&mut self, surface: &TriangleSurface, h: HalfEdgeId, strictness: f64) {
        let topology = surface.topology();
        let f = topology.face(h);
        let Some(k) = topology.face_half_edges(f).position(|x| x == h) else {
            return;
        };
        let corner = surface.corners(f);
        let edge = corner[(k + 1) % 3] - corner[k];
        let area = surface.face_area(f);
        let mut change = Vec3::zeros();
        (change[k], change[(k + 1) % 3]) = (-1.0, 1.0);
        let weight = HOLD * strictness * area / edge.norm_squared();
        self.stiffness += change * change.transpose() * weight;
    }
}

fn load(topology: &Topology, of_face: impl Fn(FaceId) -> Vec3) -> Vec<f64> {
    let mut sum = vec![0.0; topology.n_vertices()];
    for f in topology.faces() {
        let part = of_face(f);
        for (k, v) in topology.face_vertices(f).iter().enumerate() {
            sum[v.index()] += part[k];
        }
    }
    sum
}

fn factor(topology: &Topology, elements: &PerFace<Element>) -> Result<Cholesky, NumericError> {
    let mut entries = Vec::with_capacity(6 * topology.n_faces() + 1);
    let mut largest: f64 = 0.0;
    for f in topology.faces() {
        let v = topology.face_vertices(f);
        let k = &elements[f].stiffness;
        for i in 0..3 {
            for j in (0..3).filter(|&j| v[j] <= v[i]) {
                entries.push((row(v[i]), row(v[j]), k[(i, j)]));
                largest = largest.max(k[(i, i)]);
            }
        }
    }
    // Values count up to a constant: the first vertex is pinned.
    entries.push((0, 0, largest));
    Cholesky::new(&SymmetricMatrix::from_triplets(
        topology.n_vertices(),
        entries.into_iter(),
    )?)
}

/// The periods for which the energy is least.
fn best_periods(
    topology: &Topology,
    elements: &PerFace<Element>,
    base: &PerVertex<f64>,
    response: &[PerVertex<f64>],
    cochain: impl Fn(usize, FaceId) -> [f64; 3],
) -> Vec<f64> {
    let n = response.len();
    if n == 0 {
        return Vec::new();
    }
    let (mut matrix, mut rhs) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for f in topology.faces() {
        let v = topology.face_vertices(f);
        let at = |x: &PerVertex<f64>| Vec3::new(x[v[0]], x[v[1]], x[v[2]]);
        let Element { stiffness, load } = &elements[f];
        let cochains: Vec<Vec3> = (0..n).map(|k| Vec3::from(cochain(k, f))).collect();
        for i in 0..n {
            rhs[i] += cochains[i].dot(&(load - stiffness * at(base)));
            for j in 0..n {
                matrix[(i, j)] += cochains[i].dot(&(stiffness * (at(&response[j]) + cochains[j])));
            }
        }
    }
    let solution = matrix.lu().solve(&rhs);
    solution.map_or(vec![0.0; n], |p| p.as_slice().to_vec())
}
