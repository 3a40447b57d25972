//! Folds as a penalty: `w/2 max(0, t - t_0)^2` for edges at which faces turn by an angle `t`.
//!
//! `cos t = n . n'` with the unit vectors along the vector areas `A = 1/2 sum x_i x x_(i+1)` of
//! both faces, so that `dA/dx_i d = 1/2 d x (x_(i+1) - x_(i-1))`.

use super::guard::Guard;
use crate::optimise::panels::{FaceShapes, Panels, add_at, add_outer, point};
use crate::optimise::simple::area;
use phex_mesh::Vec3;
use phex_numeric::Assembly;

/// Least sine that is divided by: at half a turn the angle has no gradient.
const LEAST_SINE: f64 = 0.1;

/// Two faces with a common edge, and all their vertices.
struct Hinge {
    faces: [usize; 2],
    vertices: Vec<u32>,
    /// Mean area of the faces, which makes the energy a square of lengths.
    area: f64,
}

/// The penalty of all inner edges of a mesh.
pub(in crate::optimise) struct FoldTerm {
    pub weight: f64,
    free: f64,
    hinges: Vec<Hinge>,
}

impl FoldTerm {
    /// For the inner edges of `guard`, without weight; turns up to `free`, radians, are free.
    pub fn new(panels: &Panels, guard: &Guard, x: &[f64], free: f64) -> Self {
        let shape = FaceShapes::at(panels, x);
        let hinge = |faces: &[u32; 2]| {
            let faces = faces.map(|f| f as usize);
            let of_faces = faces.iter().flat_map(|&f| panels.vertices(f));
            let mut vertices: Vec<u32> = of_faces.copied().collect();
            vertices.sort_unstable();
            vertices.dedup();
            let areas = faces.map(|f| area(shape.face(panels, f)).abs());
            Hinge {
                faces,
                vertices,
                area: 0.5 * (areas[0] + areas[1]),
            }
        };
        Self {
            weight: 0.0,
            free,
            hinges: guard.hinges().iter().map(hinge).collect(),
        }
    }

    /// Vertices of each edge's faces: the blocks of the Hessian.
    pub fn vertices(&self) -> impl Iterator<Item = Vec<u32>> + '_ {
        self.hinges.iter().map(|h| h.vertices.clone())
    }

    pub fn energy(&self, panels: &Panels, x: &[f64]) -> f64 {
        let energy = |hinge: &Hinge| {
            let excess = FoldTurn::of(panels, hinge, x, self.free).map_or(0.0, |t| t.excess);
            0.5 * self.weight * hinge.area * excess * excess
        };
        self.hinges.iter().map(energy).sum()
    }

    /// Adds gradient and Gauss-Newton blocks: a block for each edge, from `first` on.
    pub fn add(
        &self,
        panels: &Panels,
        x: &[f64],
        gradient: &mut [f64],
        assembly: &Assembly,
        first: usize,
        blocks: &mut [f64],
    ) {
        for (k, hinge) in self.hinges.iter().enumerate() {
            let block = &mut blocks[assembly.block(first + k)];
            block.fill(0.0);
            let Some(turn) = FoldTurn::of(panels, hinge, x, self.free) else {
                continue;
            };
            let weight = self.weight * hinge.area;
            let rows = turn.rows(panels, hinge, x);
            for (row, &v) in rows.iter().zip(&hinge.vertices) {
                add_at(gradient, v as usize, &(row * (weight * turn.excess)));
            }
            add_outer(block, &rows, weight);
        }
    }
}

/// An edge at which faces turn by more than is free.
struct FoldTurn {
    normals: [Vec3; 2],
    /// Lengths of the vector areas.
    areas: [f64; 2],
    cosine: f64,
    excess: f64,
}

impl FoldTurn {
    /// `None` where nothing is to pay.
    fn of(panels: &Panels, hinge: &Hinge, x: &[f64], free: f64) -> Option<Self> {
        let vectors = hinge.faces.map(|f| vector_area(panels, f, x));
        let areas = vectors.map(|a| a.norm());
        let normals = [vectors[0] / areas[0], vectors[1] / areas[1]];
        let cosine = normals[0].dot(&normals[1]).clamp(-1.0, 1.0);
        let excess = cosine.acos() - free;
        (excess > 0.0).then_some(Self {
            normals,
            areas,
            cosine,
            excess,
        })
    }

    /// Derivatives of the angle by the vertices of the hinge.
    fn rows(&self, panels: &Panels, hinge: &Hinge, x: &[f64]) -> Vec<Vec3> {
        let sine = (1.0 - self.cosine * self.cosine).sqrt().max(LEAST_SINE);
        let mut rows = vec![Vec3::zeros(); hinge.vertices.len()];
        for (side, &f) in hinge.faces.iter().enumerate() {
            let across = self.normals[1 - side] - self.normals[side] * self.cosine;
            let by_area = across * (-0.5 / (self.areas[side] * sine));
            let vertices = panels.vertices(f);
            let k = vertices.len();
            for i in 0..k {
                let next = point(x, vertices[(i + 1) % k] as usize);
                let before = point(x, vertices[(i + k - 1) % k] as usize);
                if let Ok(row) = hinge.vertices.binary_search(&vertices[i]) {
                    rows[row] += (next - before).cross(&by_area);
                }
            }
        }
        rows
    }
}

fn vector_area(panels: &Panels, face: usize, x: &[f64]) -> Vec3 {
    let vertices = panels.vertices(face);
    let origin = point(x, vertices[0] as usize);
    let arm = |v: u32| point(x, v as usize) - origin;
    let turns = vertices.windows(2).map(|w| arm(w[0]).cross(&arm(w[1])));
    turns.sum::<Vec3>() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::panels::unknowns;
    use crate::optimise::solver::solvers::energy_assembly_with;
    use phex_mesh::HexMesh;

    /// Two pentagons that turn by more than a right angle at their edge, a little bent.
    fn knife() -> HexMesh {
        let positions = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [-0.9, 0.4, 1.1],
            [-1.3, 0.65, 0.5],
            [-1.0, 0.45, -0.1],
            [-1.0, -0.4, 1.0],
            [-1.4, -0.5, 0.4],
            [-0.9, -0.38, 0.1],
        ];
        let faces = [[0, 4, 3, 2, 1], [1, 5, 6, 7, 0]];
        HexMesh::new(positions.map(Vec3::from).to_vec(), &faces).unwrap()
    }

    #[test]
    fn gradient_is_that_of_differences() {
        let mesh = knife();
        let panels = Panels::new(mesh.topology());
        let guard = Guard::new(mesh.topology(), None, 0.0);
        let x = unknowns(&mesh);
        let mut term = FoldTerm::new(&panels, &guard, &x, 1.5);
        term.weight = 2.0;
        let assembly = energy_assembly_with(&panels, term.vertices());
        let mut blocks = vec![0.0; assembly.n_block_entries()];
        let mut gradient = vec![0.0; x.len()];
        let first = panels.n_faces() + panels.n_vertices();
        term.add(&panels, &x, &mut gradient, &assembly, first, &mut blocks);
        let h = 1e-6;
        for i in 0..x.len() {
            let at = |step: f64| {
                let mut moved = x.clone();
                moved[i] += step;
                term.energy(&panels, &moved)
            };
            let slope = (at(h) - at(-h)) / (2.0 * h);
            assert!((slope - gradient[i]).abs() < 1e-8, "{i}: {slope}");
        }
        assert!(gradient.iter().any(|g| g.abs() > 0.1));
        assert!(blocks.iter().any(|b| b.abs() > 0.1));
    }
}
