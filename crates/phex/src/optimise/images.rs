//! Vertices that are images of others: a mesh with symmetries is known by one vertex of each orbit.
//!
//! What is optimised is the part of a symmetric mesh that generates it, with those panels whole
//! that lie across a mirror plane or round an axis. Corners of these outside of the part are images
//! `x_g = R x_s` of their sources, `R` orthogonal, so `x = P y` with the sources `y`: gradients
//! become `P^T g`, Hessians `P^T H P`. All sources of a panel's images are corners of that panel,
//! which therefore keeps its block. A panel that is its own image has a normal that is, so in `J P`
//! the entries of images are added to those of their sources (see `planarity`).

use super::panels::{Image, Panels, add_at, add_block, point, put};
use nalgebra::{DMatrix, Matrix3};
use phex_mesh::Vec3;
use phex_numeric::Assembly;
use phex_numeric::assembly::packed;
use std::collections::BTreeMap;

/// Puts images where their sources have them.
pub(super) fn retract(images: &BTreeMap<u32, Image>, x: &mut [f64]) {
    for (&v, image) in images {
        let place = image.map * point(x, image.source as usize);
        put(x, v as usize, &place);
    }
}

/// Gradient and Hessian blocks, one for every face and then one for every vertex, by the sources
/// alone; `weight` stands where images had theirs.
pub(super) fn fold(
    images: &BTreeMap<u32, Image>,
    panels: &Panels,
    assembly: &Assembly,
    weight: f64,
    gradient: &mut [f64],
    blocks: &mut [f64],
) {
    for (&v, image) in images {
        let pulled = image.map.transpose() * point(gradient, v as usize);
        add_at(gradient, image.source as usize, &pulled);
        put(gradient, v as usize, &Vec3::zeros());
        let [of_source, of_image] =
            [image.source, v].map(|w| assembly.block(panels.n_faces() + w as usize));
        let own = Matrix3::from_fn(|r, c| blocks[of_image.start + packed(r.max(c), r.min(c))]);
        let pulled = image.map.transpose() * own * image.map;
        add_block(&mut blocks[of_source], 0, 0, &pulled);
        let block = &mut blocks[of_image];
        block.fill(0.0);
        add_block(block, 0, 0, &Matrix3::from_diagonal_element(weight));
    }
    for f in (0..panels.n_faces()).filter(|f| panels.has_image(*f)) {
        fold_face(images, panels.vertices(f), &mut blocks[assembly.block(f)]);
    }
}

/// `P^T B P` of a face's packed block.
fn fold_face(images: &BTreeMap<u32, Image>, vertices: &[u32], block: &mut [f64]) {
    let n = 3 * vertices.len();
    let full = DMatrix::from_fn(n, n, |r, c| block[packed(r.max(c), r.min(c))]);
    let mut spread = DMatrix::zeros(n, n);
    for (i, v) in vertices.iter().enumerate() {
        let (source, map) = images
            .get(v)
            .map_or((*v, Matrix3::identity()), |g| (g.source, g.map));
        let at = vertices.iter().position(|w| *w == source).unwrap_or(i);
        spread.view_mut((3 * i, 3 * at), (3, 3)).copy_from(&map);
    }
    let folded = spread.transpose() * full * &spread;
    for r in 0..n {
        for c in 0..=r {
            block[packed(r, c)] = folded[(r, c)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// The quadratic form of a folded block at `y` is that of the block at `P y`.
    #[test]
    fn a_folded_block_is_the_block_at_the_images() {
        let map = Matrix3::from_diagonal(&Vec3::new(1.0, -1.0, 1.0));
        let images = BTreeMap::from([(7, Image { source: 4, map }), (9, Image { source: 2, map })]);
        let vertices = [2, 4, 7, 9, 5];
        let n = 3 * vertices.len();
        let full = DMatrix::from_fn(n, n, |r, c| ((r * c + r + c) as f64).sin());
        let mut block = vec![0.0; n * (n + 1) / 2];
        for r in 0..n {
            for c in 0..=r {
                block[packed(r, c)] = full[(r, c)];
            }
        }
        fold_face(&images, &vertices, &mut block);
        let free: Vec<f64> = (0..n).map(|i| (1.7 * i as f64).cos()).collect();
        let mut x = nalgebra::DVector::from_vec(free.clone());
        for (i, v) in vertices.iter().enumerate() {
            if let Some(image) = images.get(v) {
                let at = vertices.iter().position(|w| *w == image.source).unwrap();
                let place = map * Vec3::from_column_slice(&free[3 * at..3 * at + 3]);
                x.rows_mut(3 * i, 3).copy_from(&place);
            }
        }
        let of_block = |y: &[f64]| -> f64 {
            let entry = |r: usize, c: usize| block[packed(r.max(c), r.min(c))];
            let products = (0..n).flat_map(|r| (0..n).map(move |c| (r, c)));
            products.map(|(r, c)| y[r] * entry(r, c) * y[c]).sum()
        };
        let symmetric = DMatrix::from_fn(n, n, |r, c| full[(r.max(c), r.min(c))]);
        let expected = x.dot(&(symmetric * &x));
        assert!((of_block(&free) - expected).abs() < 1e-12 * n as f64);
    }

    #[test]
    fn images_go_where_their_sources_are() {
        let map = Matrix3::from_diagonal(&Vec3::new(-1.0, 1.0, 1.0));
        let images = BTreeMap::from([(1, Image { source: 0, map })]);
        let mut x = [0.1, 0.2, 0.3, 9.0, 9.0, 9.0];
        retract(&images, &mut x);
        assert_eq!(x, [0.1, 0.2, 0.3, -0.1, 0.2, 0.3]);
    }
}
