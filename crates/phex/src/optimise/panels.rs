//! Panels as the optimiser sees them: corners in one flat array, and where every face lies just
//! now.

use nalgebra::Matrix3;
use phex_mesh::{FacePlane, HexMesh, Topology, Vec2, Vec3, VertexId};
use std::collections::BTreeMap;

/// The vertex that another one is the image of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Image {
    /// That vertex, no image itself.
    pub source: u32,
    /// The orthogonal map, about the origin.
    pub map: Matrix3<f64>,
}

/// Faces that one task handles; fewer are not worth another thread.
const GRAIN: usize = 256;

/// Which vertices the corners of each face are, and which corners each vertex has.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    corner_start: Vec<usize>,
    corner_vertex: Vec<u32>,
    corner_face: Vec<u32>,
    vertex_start: Vec<usize>,
    vertex_corner: Vec<u32>,
    edges: Vec<[u32; 2]>,
    /// At a corner, whose edge runs to the next one: the corner of that edge in the face beyond.
    twin: Vec<Option<u32>>,
    /// The vertex that each is an image of, itself for most.
    source: Vec<u32>,
    /// Whether each face rests: none of its vertices can move.
    rests: Vec<bool>,
}

impl Panels {
    pub fn new(topology: &Topology) -> Self {
        let number = |v: &VertexId| v.index() as u32;
        let faces = topology
            .faces()
            .map(|f| topology.face_vertices(f).iter().map(number));
        let ends = |e| topology.edge_vertices(e).map(|v| number(&v));
        let edges = topology.edges().map(ends).collect();
        Self::of_faces(faces, edges, topology.n_vertices())
    }

    /// Some of the faces, all of whose vertices get other numbers.
    pub fn part(&self, faces: &[u32], vertices: &[u32]) -> Self {
        let local = |v: &u32| vertices.binary_search(v).ok().map(|v| v as u32);
        let corners = |&f: &u32| self.vertices(f as usize).iter().filter_map(local);
        let ends = |[a, b]: &[u32; 2]| Some([local(a)?, local(b)?]);
        let edges = self.edges.iter().filter_map(ends).collect();
        let mut part = Self::of_faces(faces.iter().map(corners), edges, vertices.len());
        for (source, v) in part.source.iter_mut().zip(vertices) {
            *source = local(&self.source[*v as usize]).unwrap_or(*source);
        }
        part
    }

    /// Faces by the numbers of their vertices.
    fn of_faces(
        faces: impl Iterator<Item = impl Iterator<Item = u32>>,
        edges: Vec<[u32; 2]>,
        n_vertices: usize,
    ) -> Self {
        let mut corner_start = vec![0];
        let (mut corner_vertex, mut corner_face) = (Vec::new(), Vec::new());
        for (f, corners) in faces.enumerate() {
            corner_vertex.extend(corners);
            corner_start.push(corner_vertex.len());
            corner_face.resize(corner_vertex.len(), f as u32);
        }
        let (vertex_start, vertex_corner) = invert(&corner_vertex, n_vertices);
        let faces = corner_start.len() - 1;
        let mut panels = Self {
            corner_start,
            corner_vertex,
            corner_face,
            vertex_start,
            vertex_corner,
            edges,
            twin: Vec::new(),
            source: (0..n_vertices as u32).collect(),
            rests: vec![false; faces],
        };
        let twin = |c: usize| {
            let [a, b] = panels.ends(c);
            let there = panels.corners_at(b as usize).iter();
            let mut there = there.copied();
            there.find(|d| panels.ends(*d as usize)[1] == a)
        };
        panels.twin = (0..panels.n_corners()).map(twin).collect();
        panels
    }

    /// The same with vertices that are images of others.
    pub fn with_images(mut self, images: &BTreeMap<u32, Image>) -> Self {
        for (v, image) in images {
            self.source[*v as usize] = image.source;
        }
        self
    }

    /// The same where some vertices can't move. Faces that rest have no energy, no equations and no
    /// place in the matrices; they are there for what is demanded between faces.
    pub fn with_rest(mut self, fixed: impl Fn(u32) -> bool) -> Self {
        let rests = |f| self.vertices(f).iter().all(|v| fixed(*v));
        self.rests = (0..self.n_faces()).map(rests).collect();
        self
    }

    /// Whether none of a face's vertices can move.
    pub fn rests(&self, face: usize) -> bool {
        self.rests[face]
    }

    /// The vertex that a vertex is the image of, itself for most.
    pub(crate) fn source(&self, vertex: u32) -> u32 {
        self.source[vertex as usize]
    }

    /// Whether a vertex is the image of another one.
    pub(crate) fn is_image(&self, vertex: u32) -> bool {
        self.source(vertex) != vertex
    }

    /// Whether a face that moves has a corner that is the image of another one.
    pub(crate) fn has_image(&self, face: usize) -> bool {
        !self.rests(face) && self.vertices(face).iter().any(|v| self.is_image(*v))
    }

    pub fn n_faces(&self) -> usize {
        self.corner_start.len() - 1
    }

    pub fn n_vertices(&self) -> usize {
        self.vertex_start.len() - 1
    }

    pub(crate) fn n_corners(&self) -> usize {
        self.corner_vertex.len()
    }

    pub fn valence(&self, face: usize) -> usize {
        self.corner_start[face + 1] - self.corner_start[face]
    }

    /// The face that a corner belongs to.
    pub(crate) fn face_of(&self, corner: u32) -> usize {
        self.corner_face[corner as usize] as usize
    }

    /// The corner after another one of its face.
    pub(crate) fn next(&self, corner: usize) -> usize {
        let corners = self.corners(self.face_of(corner as u32));
        match corner + 1 == corners.end {
            true => corners.start,
            false => corner + 1,
        }
    }

    /// The corner before another one of its face.
    pub(crate) fn previous(&self, corner: usize) -> usize {
        let corners = self.corners(self.face_of(corner as u32));
        match corner == corners.start {
            true => corners.end - 1,
            false => corner - 1,
        }
    }

    /// Vertices of the edge from a corner to the next one.
    pub(crate) fn ends(&self, corner: usize) -> [u32; 2] {
        [corner, self.next(corner)].map(|c| self.corner_vertex[c])
    }

    /// The corner from which the edge from a corner to the next one runs in the face beyond it;
    /// `None` at the boundary.
    pub(crate) fn twin(&self, corner: usize) -> Option<usize> {
        self.twin[corner].map(|c| c as usize)
    }

    /// Corners of a face.
    pub fn corners(&self, face: usize) -> std::ops::Range<usize> {
        self.corner_start[face]..self.corner_start[face + 1]
    }

    /// Vertices of a face, counter-clockwise.
    pub fn vertices(&self, face: usize) -> &[u32] {
        &self.corner_vertex[self.corners(face)]
    }

    /// Corners that lie at a vertex.
    pub(crate) fn corners_at(&self, vertex: usize) -> &[u32] {
        &self.vertex_corner[self.vertex_start[vertex]..self.vertex_start[vertex + 1]]
    }

    /// Mean length of the edges.
    pub fn mean_edge(&self, x: &[f64]) -> f64 {
        let length = |[a, b]: &[u32; 2]| (point(x, *a as usize) - point(x, *b as usize)).norm();
        self.edges.iter().map(length).sum::<f64>() / self.edges.len() as f64
    }

    /// Calls `work(face, per_face, per_corner, block)` for every face, each with its own slices, on
    /// all threads. Block `f` is `blocks[block_end(f - 1)..block_end(f)]`.
    pub(crate) fn for_each_face<A: Send, B: Send>(
        &self,
        per_face: &mut [A],
        per_corner: &mut [B],
        blocks: &mut [f64],
        block_end: &(impl Fn(usize) -> usize + Sync),
        work: &(impl Fn(usize, &mut A, &mut [B], &mut [f64]) + Sync),
    ) {
        let slices = Slices {
            first: 0,
            per_face,
            per_corner,
            blocks,
        };
        self.split(slices, block_end, work);
    }

    fn split<A: Send, B: Send>(
        &self,
        slices: Slices<'_, A, B>,
        block_end: &(impl Fn(usize) -> usize + Sync),
        work: &(impl Fn(usize, &mut A, &mut [B], &mut [f64]) + Sync),
    ) {
        let count = slices.per_face.len();
        if count > GRAIN {
            let (low, high) = self.halves(slices, count / 2, block_end);
            rayon::join(
                || self.split(low, block_end, work),
                || self.split(high, block_end, work),
            );
            return;
        }
        let mut rest = slices;
        while !rest.per_face.is_empty() {
            let (one, others) = self.halves(rest, 1, block_end);
            work(one.first, &mut one.per_face[0], one.per_corner, one.blocks);
            rest = others;
        }
    }

    fn halves<'a, A, B>(
        &self,
        slices: Slices<'a, A, B>,
        count: usize,
        block_end: &impl Fn(usize) -> usize,
    ) -> (Slices<'a, A, B>, Slices<'a, A, B>) {
        let (first, middle) = (slices.first, slices.first + count);
        let start = if first == 0 { 0 } else { block_end(first - 1) };
        let corners = self.corner_start[middle] - self.corner_start[first];
        let (face_low, face_high) = slices.per_face.split_at_mut(count);
        let (corner_low, corner_high) = slices.per_corner.split_at_mut(corners);
        let (block_low, block_high) = slices.blocks.split_at_mut(block_end(middle - 1) - start);
        let half = |first, per_face, per_corner, blocks| Slices {
            first,
            per_face,
            per_corner,
            blocks,
        };
        (
            half(first, face_low, corner_low, block_low),
            half(middle, face_high, corner_high, block_high),
        )
    }
}

struct Slices<'a, A, B> {
    first: usize,
    per_face: &'a mut [A],
    per_corner: &'a mut [B],
    blocks: &'a mut [f64],
}

/// Corners of each vertex, in ascending order, as start indices and one flat list.
fn invert(corner_vertex: &[u32], n_vertices: usize) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; n_vertices + 1];
    for &v in corner_vertex {
        start[v as usize + 1] += 1;
    }
    for v in 0..n_vertices {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut corners = vec![0; corner_vertex.len()];
    for (corner, &v) in corner_vertex.iter().enumerate() {
        corners[next[v as usize]] = corner as u32;
        next[v as usize] += 1;
    }
    (start, corners)
}

/// Position of a vertex in the vector of unknowns.
pub(super) fn point(x: &[f64], vertex: usize) -> Vec3 {
    Vec3::new(x[3 * vertex], x[3 * vertex + 1], x[3 * vertex + 2])
}

/// Puts a vertex into the vector of unknowns, or what there is of it into another such vector.
pub(super) fn put(x: &mut [f64], vertex: usize, place: &Vec3) {
    x[3 * vertex..3 * vertex + 3].copy_from_slice(place.as_slice());
}

/// Adds to what there is of a vertex in such a vector.
pub(super) fn add_at(x: &mut [f64], vertex: usize, by: &Vec3) {
    for (x, d) in x[3 * vertex..3 * vertex + 3].iter_mut().zip(by) {
        *x += d;
    }
}

/// The values of those that have some numbers.
pub(super) fn picked<T: Clone>(values: &[T], numbers: &[u32]) -> Vec<T> {
    let value = |&k: &u32| values[k as usize].clone();
    numbers.iter().map(value).collect()
}

/// Diagonal of the bounding box of all vertices.
pub(super) fn extent(x: &[f64]) -> f64 {
    let first = point(x, 0);
    let box_of =
        |(low, high): (Vec3, Vec3), v: usize| (low.inf(&point(x, v)), high.sup(&point(x, v)));
    let (low, high) = (0..x.len() / 3).fold((first, first), box_of);
    (high - low).norm()
}

/// Positions of a mesh as one vector of unknowns.
pub(super) fn unknowns(mesh: &HexMesh) -> Vec<f64> {
    flatten(mesh.positions.as_slice())
}

/// Points as one vector of unknowns.
pub(super) fn flatten(points: &[Vec3]) -> Vec<f64> {
    points.iter().flat_map(|p| [p.x, p.y, p.z]).collect()
}

/// Unknowns as points.
pub(super) fn points(x: &[f64]) -> Vec<Vec3> {
    x.chunks_exact(3).map(Vec3::from_column_slice).collect()
}

/// A corner in the frame of its face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub position: Vec3,
    /// In-plane coordinates.
    pub flat: Vec2,
    /// Height above the face's plane.
    pub height: f64,
}

/// Where a face lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceFrame {
    pub plane: FacePlane,
    /// In-plane second moments `sum xi^2`, `sum eta^2` along the axes, and `sum h^2`.
    pub moments: [f64; 3],
}

impl FaceFrame {
    fn degenerate() -> Self {
        let plane = FacePlane {
            centre: Vec3::zeros(),
            normal: Vec3::z(),
            axes: [Vec3::x(), Vec3::y()],
        };
        Self {
            plane,
            moments: [0.0; 3],
        }
    }

    fn fit(corners: &mut [Corner]) -> Self {
        let plane = fit_plane(corners);
        let mut moments = [0.0; 3];
        for corner in corners {
            corner.flat = plane.project(corner.position);
            corner.height = plane.height(corner.position);
            moments[0] += corner.flat.x * corner.flat.x;
            moments[1] += corner.flat.y * corner.flat.y;
            moments[2] += corner.height * corner.height;
        }
        Self { plane, moments }
    }
}

/// Total least-squares plane of corners, oriented by their winding.
fn fit_plane(corners: &[Corner]) -> FacePlane {
    const MOST: usize = 12;
    if corners.len() <= MOST {
        let mut positions = [Vec3::zeros(); MOST];
        for (p, corner) in positions.iter_mut().zip(corners) {
            *p = corner.position;
        }
        return FacePlane::fit(&positions[..corners.len()]);
    }
    FacePlane::fit(&corners.iter().map(|c| c.position).collect::<Vec<_>>())
}

/// All faces at some positions.
#[derive(Clone, Debug)]
pub(super) struct FaceShapes {
    pub frames: Vec<FaceFrame>,
    pub corners: Vec<Corner>,
}

impl FaceShapes {
    pub fn new(panels: &Panels) -> Self {
        let corner = Corner {
            position: Vec3::zeros(),
            flat: Vec2::zeros(),
            height: 0.0,
        };
        Self {
            frames: vec![FaceFrame::degenerate(); panels.n_faces()],
            corners: vec![corner; panels.n_corners()],
        }
    }

    /// The shape of `panels` at `x`.
    pub fn at(panels: &Panels, x: &[f64]) -> Self {
        let mut shape = Self::new(panels);
        shape.update(panels, x);
        shape
    }

    pub(crate) fn update(&mut self, panels: &Panels, x: &[f64]) {
        let work = |f: usize, frame: &mut FaceFrame, corners: &mut [Corner], _: &mut [f64]| {
            let mut has_moved = false;
            for (corner, &v) in corners.iter_mut().zip(panels.vertices(f)) {
                let p = point(x, v as usize);
                has_moved |= corner.position != p;
                corner.position = p;
            }
            if has_moved {
                *frame = FaceFrame::fit(corners);
            }
        };
        let (frames, corners) = (&mut self.frames, &mut self.corners);
        panels.for_each_face(frames, corners, &mut [], &|_| 0, &work);
    }

    pub fn face<'a>(&'a self, panels: &Panels, face: usize) -> &'a [Corner] {
        &self.corners[panels.corners(face)]
    }

    pub fn normal(&self, face: usize) -> Vec3 {
        self.frames[face].plane.normal
    }

    /// Largest distance of a corner to the plane of its face.
    pub(crate) fn max_height(&self) -> f64 {
        phex_numeric::largest(self.corners.iter().map(|c| c.height.abs()))
    }
}

/// Adds a 3 x 3 block to corners `i >= j` of a packed lower triangle; on the diagonal only its
/// lower half.
pub(super) fn add_block(block: &mut [f64], i: usize, j: usize, value: &Matrix3<f64>) {
    for a in 0..3 {
        let row = 3 * i + a;
        let start = phex_numeric::assembly::packed(row, 3 * j);
        let width = if i == j { a + 1 } else { 3 };
        for b in 0..width {
            block[start + b] += value[(a, b)];
        }
    }
}

/// Adds `w r r^T` for derivatives `r` by the corners of a face.
pub(super) fn add_outer(block: &mut [f64], rows: &[Vec3], weight: f64) {
    for (i, row) in rows.iter().enumerate() {
        for (j, other) in rows[..=i].iter().enumerate() {
            add_block(block, i, j, &(row * other.transpose() * weight));
        }
    }
}

/// Adds the Hessian of what depends on the vector from a corner to another one, with that by the
/// vector.
pub(super) fn add_difference(block: &mut [f64], [i, j]: [usize; 2], value: &Matrix3<f64>) {
    add_block(block, i, i, value);
    add_block(block, j, j, value);
    add_block(block, i.max(j), i.min(j), &-value);
}
