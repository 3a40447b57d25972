//! Corners at which three runs meet: cut off before strips are laid, so that these have something
//! to end in, and a vertex in which they meet afterwards.

use super::super::draft::Draft;
use super::REACH;
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use std::collections::BTreeMap;

/// The triangle in place of a vertex, and the middles of its sides.
pub(super) struct CutCorner {
    face: usize,
    middles: [Vec3; 3],
}

impl Draft {
    /// The panels with corners cut off at which three folds meet between panels that may change.
    pub(super) fn without_corners(
        &self,
        counts: &dyn Fn(usize) -> bool,
        deepest: f64,
    ) -> (Self, Vec<CutCorner>) {
        let mut met: BTreeMap<u32, usize> = BTreeMap::new();
        let folds = self.folds();
        let counting = folds
            .iter()
            .filter(|fold| fold.faces.iter().any(|f| counts(*f)));
        for v in counting.flat_map(|fold| fold.side) {
            *met.entry(v).or_default() += 1;
        }
        let incidence = self.incidence();
        let (mut next, mut corners) = (self.clone(), Vec::new());
        for (v, _) in met.into_iter().filter(|(_, count)| *count == 3) {
            let around: Vec<usize> = incidence.faces_at(v).collect();
            if around.len() == 3 && !self.on_boundary[v as usize] {
                corners.extend(next.cut_corner(v, &around, deepest));
            }
        }
        (next, corners)
    }

    /// Cuts off a vertex between three panels by a triangle, as deep as may be; `None` where two of
    /// its edges lie in one.
    fn cut_corner(&mut self, v: u32, around: &[usize], deepest: f64) -> Option<CutCorner> {
        let apex = self.place(v);
        // The neighbours before and after the vertex in each panel, and then all three of them in
        // the order in which the triangle's corners go round.
        let beside = around.iter().filter_map(|f| {
            let (face, n) = (&self.faces[*f], self.faces[*f].len());
            let k = face.iter().position(|x| *x == v)?;
            Some([face[(k + n - 1) % n], face[(k + 1) % n]])
        });
        let beside: Vec<[u32; 2]> = beside.collect();
        let before = |u: u32| beside.iter().find(|pair| pair[1] == u).map(|pair| pair[0]);
        let first = beside.first()?[1];
        let ring = [first, before(first)?, before(before(first)?)?];
        let ways = ring.map(|u| self.place(u) - apex);
        let shortest = ways.iter().map(Vec3::norm).fold(f64::INFINITY, f64::min);
        let units = ways.map(|way| way / way.norm());
        // How far the plane through the points at distance 1 on the edges lies from the vertex.
        let normal = (units[1] - units[0]).cross(&(units[2] - units[0]));
        let height = normal.try_normalize(0.0)?.dot(&units[0]).abs();
        let distance = (deepest / height).min(REACH * shortest);
        let triangle = units.map(|unit| apex + unit * distance);
        let new = [0, 1, 2].map(|i| self.places.len() as u32 + i);
        self.places.extend(triangle);
        self.on_boundary.extend([false; 3]);
        for (f, pair) in around.iter().zip(&beside) {
            let cut = pair.map(|u| new[usize::from(u != ring[0]) + usize::from(u == ring[2])]);
            let face = &mut self.faces[*f];
            let k = face.iter().position(|x| *x == v)?;
            face.splice(k..=k, cut);
        }
        self.faces.push(new.to_vec());
        self.open.push(true);
        self.origin.push(self.origin[around[0]]);
        Some(CutCorner {
            face: self.faces.len() - 1,
            middles: [0, 1, 2].map(|i| (triangle[i] + triangle[(i + 1) % 3]) * 0.5),
        })
    }

    /// Takes out the panel in place of a corner at which three strips end, panels from `strips` on:
    /// they meet in a vertex, and each side that it has with another panel becomes a point.
    pub(super) fn join_strips(&mut self, corner: &CutCorner, strips: usize) {
        let Ok(mut ring) = <[u32; 6]>::try_from(self.faces[corner.face].clone()) else {
            return;
        };
        let incidence = self.incidence();
        let beyond = |ring: &[u32; 6], i: usize| {
            let faces = incidence.beside([ring[i % 6], ring[(i + 1) % 6]]);
            faces.map_or(0, |faces| faces[1])
        };
        // Sides of strips and of other panels by turns, those of others first.
        if beyond(&ring, 0) >= strips {
            ring.rotate_left(1);
        }
        if (0..6).any(|i| (beyond(&ring, i) >= strips) != (i % 2 == 1)) {
            return;
        }
        let ends = [0, 2, 4].map(|i| [ring[i], beyond(&ring, i + 1) as u32, ring[(i + 2) % 6]]);
        for i in [0, 2, 4] {
            let [p, q] = [ring[i], ring[i + 1]];
            let middle = (self.place(p) + self.place(q)) * 0.5;
            let away = |m: &Vec3| (m - middle).norm();
            let nearest = corner
                .middles
                .into_iter()
                .min_by(|a, b| away(a).total_cmp(&away(b)));
            self.places[p as usize] = nearest.unwrap_or(middle);
            for f in incidence.faces_at(q) {
                let face = &mut self.faces[f];
                if face.contains(&p) {
                    face.retain(|v| *v != q);
                } else {
                    face.iter_mut().filter(|v| **v == q).for_each(|v| *v = p);
                }
            }
        }
        let vertex = self.places.len() as u32;
        let centre = ends.iter().map(|[p, ..]| self.place(*p)).sum::<Vec3>() / 3.0;
        // The planes of the strips, each through its end and its middle.
        let planes = ends.map(|[p, strip, q]| {
            let [p, q] = [p, q].map(|v| self.place(v));
            let face = &self.faces[strip as usize];
            let middle = face.iter().map(|v| self.place(*v)).sum::<Vec3>() / face.len() as f64;
            let normal = (q - p).cross(&(middle - p));
            (normal, normal.dot(&p))
        });
        let normals = Matrix3::from_fn(|r, c| planes[r].0[c]).try_inverse();
        let offsets = Vec3::from_fn(|r, _| planes[r].1);
        self.places
            .push(normals.map_or(centre, |inverse| inverse * offsets));
        self.on_boundary.push(false);
        for [_, strip, q] in ends {
            let strip = &mut self.faces[strip as usize];
            if let Some(k) = strip.iter().position(|v| *v == q) {
                strip.insert(k + 1, vertex);
            }
        }
        self.faces[corner.face].clear();
    }
}
