//! Triangles of closed surfaces `f = 0`, by the cells of a grid: a vertex in every cell that the
//! surface crosses, moved onto it, and two triangles across every edge of the grid whose ends lie
//! on different sides ("surface nets").

use crate::figures::Obj;
use std::collections::HashMap;

/// A point of space.
pub type Point = [f64; 3];

/// Steps of Newton's method that bring a vertex onto the surface.
const STEPS: usize = 12;

/// The surface of `f < 0` within the cube of half-width `half` about the origin, on `n` cells a
/// side. The surface must keep away from the cube's sides and be smooth at the size of a cell.
pub fn mesh(f: impl Fn(Point) -> f64, half: f64, n: usize) -> Obj {
    let step = 2.0 * half / n as f64;
    // Half a cell of shift would put symmetric surfaces through grid points: an irrational one does
    // not.
    let shift = std::f64::consts::FRAC_1_PI * step;
    let node = |i: [usize; 3]| i.map(|k| k as f64 * step - half + shift);
    let index = |i: [usize; 3]| (i[0] * (n + 1) + i[1]) * (n + 1) + i[2];
    let mut values = vec![0.0; (n + 1).pow(3)];
    for i in cells(n + 1) {
        values[index(i)] = f(node(i));
    }
    let mut net = Net {
        mesh: Obj::default(),
        vertex: HashMap::new(),
    };
    for i in cells(n) {
        let corners: Vec<[usize; 3]> = cells(2).map(|c| add(i, c)).collect();
        let inside = corners.iter().filter(|c| values[index(**c)] < 0.0).count();
        if !(1..8).contains(&inside) {
            continue;
        }
        let centre = node(i).map(|x| x + 0.5 * step);
        net.vertex.insert(i, net.mesh.points.len());
        net.mesh.points.push(onto(&f, centre, step));
    }
    for i in cells(n) {
        for axis in 0..3 {
            let mut next = i;
            next[axis] += 1;
            let (here, there) = (values[index(i)] < 0.0, values[index(next)] < 0.0);
            if here != there {
                net.across(i, axis, here);
            }
        }
    }
    net.mesh
}

fn cells(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..n * n * n).map(move |k| [k / (n * n), k / n % n, k % n])
}

fn add(a: [usize; 3], b: [usize; 3]) -> [usize; 3] {
    std::array::from_fn(|k| a[k] + b[k])
}

struct Net {
    mesh: Obj,
    vertex: HashMap<[usize; 3], usize>,
}

impl Net {
    /// Two triangles through the four cells around the grid's edge from node `i` along an axis,
    /// seen from outside.
    fn across(&mut self, i: [usize; 3], axis: usize, starts_inside: bool) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let cell = |du: usize, dv: usize| {
            let mut cell = i;
            cell[u] = cell[u].checked_sub(du)?;
            cell[v] = cell[v].checked_sub(dv)?;
            self.vertex.get(&cell).copied()
        };
        let around = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
        let Some(mut quad) = around.into_iter().collect::<Option<Vec<usize>>>() else {
            return;
        };
        if !starts_inside {
            quad.reverse();
        }
        let length = |a: usize, b: usize| {
            let (a, b) = (self.mesh.points[a], self.mesh.points[b]);
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>()
        };
        let [a, b, c, d] = [quad[0], quad[1], quad[2], quad[3]];
        let faces = match length(a, c) <= length(b, d) {
            true => [vec![a, b, c], vec![a, c, d]],
            false => [vec![a, b, d], vec![b, c, d]],
        };
        self.mesh.faces.extend(faces);
    }
}

/// A point of the surface near `p`, found along gradients; no step is longer than half a cell.
fn onto(f: &impl Fn(Point) -> f64, mut p: Point, cell: f64) -> Point {
    let h = 1e-4 * cell;
    for _ in 0..STEPS {
        let slope: Point = std::array::from_fn(|k| {
            let (mut low, mut high) = (p, p);
            low[k] -= h;
            high[k] += h;
            (f(high) - f(low)) / (2.0 * h)
        });
        let square: f64 = slope.iter().map(|s| s * s).sum();
        if square == 0.0 {
            break;
        }
        let reach = 0.5 * cell / square.sqrt();
        let step = (f(p) / square).clamp(-reach, reach);
        p = std::array::from_fn(|k| p[k] - step * slope[k]);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_on_the_sphere_and_seen_from_outside() {
        let sphere = mesh(|p| p.iter().map(|x| x * x).sum::<f64>() - 1.0, 1.3, 16);
        let edges: std::collections::HashSet<(usize, usize)> = sphere
            .faces
            .iter()
            .flat_map(|f| (0..3).map(move |k| (f[k], f[(k + 1) % 3])))
            .collect();
        assert_eq!(
            edges.len(),
            3 * sphere.faces.len(),
            "no edge twice the same way"
        );
        assert!(
            edges.iter().all(|&(a, b)| edges.contains(&(b, a))),
            "closed"
        );
        let off = |p: &Point| (p.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs();
        assert!(sphere.points.iter().map(off).fold(0.0, f64::max) < 1e-9);
        let euler = sphere.points.len() as i64 - edges.len() as i64 / 2 + sphere.faces.len() as i64;
        assert_eq!(euler, 2);
        let volume: f64 = sphere
            .faces
            .iter()
            .map(|f| sixfold(&sphere, f))
            .sum::<f64>()
            / 6.0;
        assert!(
            (volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.03,
            "{volume}"
        );
    }

    fn sixfold(mesh: &Obj, face: &[usize]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points[face[k]]);
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    }
}
