use super::*;
use phex_mesh::measure;
use phex_mesh::shapes;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn tangency(mesh: &HexMesh) -> f64 {
    let distance = |e| {
        let [a, b] = mesh.topology().edge_vertices(e).map(|v| mesh.position(v));
        let d = (b - a).normalize();
        (a.cross(&d).norm() - 1.0).abs()
    };
    mesh.topology().edges().map(distance).fold(0.0, f64::max)
}

/// Dual of a triangulation: faces around vertices.
fn dual(faces: &[[u32; 3]], n: usize) -> HexMesh {
    let t = Topology::from_faces(n, faces).unwrap();
    let lists: Vec<Vec<u32>> = t
        .vertices()
        .map(|v| t.outgoing(v).map(|h| t.face(h).index() as u32).collect())
        .collect();
    HexMesh::new(vec![Vec3::zeros(); faces.len()], &lists).unwrap()
}

/// Random triangulation: repeatedly insert vertices in random triangles then flip random edges.
fn random_triangulation(n: usize, seed: u64) -> Vec<[u32; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut tri: Vec<[u32; 3]> = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    for v in 4..n as u32 {
        let i = rng.random_range(0..tri.len());
        let [a, b, c] = tri[i];
        tri[i] = [a, b, v];
        tri.push([b, c, v]);
        tri.push([c, a, v]);
    }
    flip(&mut tri, 10 * n, &mut rng);
    tri
}

fn flip(tri: &mut [[u32; 3]], count: usize, rng: &mut ChaCha8Rng) {
    use std::collections::HashMap;
    let mut edge: HashMap<(u32, u32), usize> = HashMap::new();
    for (i, t) in tri.iter().enumerate() {
        for k in 0..3 {
            edge.insert((t[k], t[(k + 1) % 3]), i);
        }
    }
    for _ in 0..count {
        let i = rng.random_range(0..tri.len());
        let k = rng.random_range(0..3);
        let (a, b, c) = (tri[i][k], tri[i][(k + 1) % 3], tri[i][(k + 2) % 3]);
        let j = edge[&(b, a)];
        let d = *tri[j].iter().find(|&&x| x != a && x != b).unwrap();
        if edge.contains_key(&(c, d)) || edge.contains_key(&(d, c)) {
            continue;
        }
        edge.remove(&(a, b));
        edge.remove(&(b, a));
        tri[i] = [c, a, d];
        tri[j] = [d, b, c];
        for (i, t) in [(i, tri[i]), (j, tri[j])] {
            for k in 0..3 {
                edge.insert((t[k], t[(k + 1) % 3]), i);
            }
        }
    }
}

#[test]
fn scratch() {
    for n in [4, 5, 12, 502, 2002, 5002] {
        let tri = random_triangulation(n, 1);
        let mesh = dual(&tri, n);
        let t0 = std::time::Instant::now();
        for (tol, it) in [(1e-10, 0), (1e-13, 0), (1e-10, 6)] {
        let k = koebe(&mesh, &KoebeOptions{angle_tolerance: tol, max_polish_iterations: it, ..Default::default()});
        let k = match k {
            Ok(k) => k,
            Err(e) => {
                println!("{n}: {e}");
                panic!();
            }
        };
        let m = measure(&k.mesh);
        println!(
            "V {} status {:?} fact {} imbalance {:.1e} tangency {:.1e} planarity {:.1e} min edge {:.1e} {:?} {:?}",
            mesh.topology().n_vertices(), k.outcome.status, k.outcome.factorisations, k.imbalance,
            tangency(&k.mesh), m.planarity_diagonals.max, m.edge_length.min * m.mean_edge, t0.elapsed(), m.face_sizes.keys().last(),
        );
        let h = m.planarity_length.max; println!("    height {h:.1e} not simple {} concave {} last {:?}", m.faces_not_simple, m.faces_concave, k.outcome.history.last());
        }
    }
}
