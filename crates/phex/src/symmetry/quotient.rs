//! Panels of the fundamental domain made whole: those that a mirror plane cuts are joined with
//! their images, and one at an axis with all of them.
//!
//! A cell at a mirror plane is half a panel, or a whole one with an edge in the plane; its area
//! tells which. Where two halves meet in the plane, the edge between them runs straight across it,
//! and the corner there is none; where a half and a whole panel meet, it is a corner of three
//! panels in the plane. Two whole panels would meet their images in a corner of four, so one of
//! them is taken as a half. Where the area leaves it in doubt it is what makes panels regular.

use super::group::{Group, bits_of, folded, in_walls, named, number_of, reflection};
use crate::directions::MirrorPlane;
use crate::layout::lattice::eisenstein::CELL;
use crate::layout::{Layout, VertexKind};
use crate::optimise::{Image, PUT_THERE, Quotient};
use nalgebra::Matrix3;
use phex_mesh::polygon::sides;
use phex_mesh::{FaceId, HexMesh, PerFace, PerVertex, Topology, Vec3, VertexId};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// Distance from a mirror plane, panel lengths, within which a vertex of the boundary is put in it.
const NEAR_PLANE: f64 = 0.05;
/// Area of a cell over that of a panel up to which it is half a panel, and a quarter of one.
const HALF: f64 = 0.72;
const QUARTER: f64 = 0.36;
/// Factor of [`HALF`] up to which the area leaves in doubt what a cell is, and rounds of choices in
/// doubt.
const DOUBT: f64 = 1.35;
const ROUNDS: usize = 4;
/// Sine of the angle between boundary and mirror plane, less than a right one, beyond which the
/// boundary has a corner there.
const SQUARE: f64 = 0.3;

/// Irregular panels that a cell counts for that can't be made a panel.
const NO_PANEL: usize = 1000;

/// A panelling of a fundamental domain with the panels at its mirror planes whole.
pub(crate) struct WholePanels {
    pub layout: Layout,
    pub quotient: Quotient,
}

/// The panels of a domain's layout made whole.
///
/// # Errors
/// A sentence that says what is in the way.
pub(crate) fn completed(layout: &Layout, group: Group) -> Result<WholePanels, String> {
    let walls = group.walls();
    let cells = WallCells::new(layout, &walls);
    let merged = cells.merged();
    let mut parts = WholeParts {
        cells: &cells,
        elements: group.elements(),
        images: Vec::new(),
        of_source: BTreeMap::new(),
    };
    let rings: Result<Vec<Vec<u32>>, String> = (layout.mesh.topology().faces())
        .map(|f| match merged[f] {
            0 => Ok(cells.corners_of_whole(f)),
            _ => parts.whole(f, &merged),
        })
        .collect();
    parts.finished(rings?, &merged)
}

/// Panels of a domain's layout, with those at its mirror planes whole, that are no hexagons; at the
/// open boundary any panel will do.
pub(crate) fn irregular_panels(layout: &Layout, mirrors: &[MirrorPlane]) -> usize {
    let walls: Vec<Vec3> = mirrors.iter().map(|m| m.normal.into()).collect();
    let cells = WallCells::new(layout, &walls);
    let merged = cells.merged();
    let cost = |f: FaceId| match cells.corners(f, &merged) {
        Some(0..3) => NO_PANEL,
        Some(n) => usize::from(n != 6),
        None => 0,
    };
    cells.topology.faces().map(cost).sum()
}

struct WallCells<'a> {
    layout: &'a Layout,
    topology: &'a Topology,
    walls: &'a [Vec3],
    /// Walls that hold each vertex, by their bits.
    on: PerVertex<u32>,
}

impl<'a> WallCells<'a> {
    fn new(layout: &'a Layout, walls: &'a [Vec3]) -> Self {
        let topology = layout.mesh.topology();
        let on = PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
            if !topology.is_boundary_vertex(v) {
                return 0;
            }
            let face = topology.faces_at(v).next();
            let near = face.map_or(0.0, |f| NEAR_PLANE * layout.face_length[f]);
            bits_of(walls, |n| n.dot(&layout.mesh.position(v)).abs() < near)
        });
        Self {
            layout,
            topology,
            walls,
            on,
        }
    }

    /// The walls in which a cell has a side.
    fn sides(&self, f: FaceId) -> u32 {
        let sides = sides(self.topology.face_vertices(f));
        sides.fold(0, |bits, [a, b]| bits | self.on[a] & self.on[b])
    }

    /// The walls across which each cell is joined with its image.
    fn merged(&self) -> PerFace<u32> {
        let share = |f| self.share(f);
        let mut merged = PerFace::from_fn(self.topology.n_faces(), |f| {
            let walls = self.sides(f);
            match walls.count_ones() {
                2.. if self.is_at_axis(f, walls) => match self.is_square(walls) {
                    true if share(f) >= QUARTER => self.longer(f, walls),
                    _ => walls,
                },
                _ if share(f) >= HALF => 0,
                2.. => self.longer(f, walls),
                _ => walls,
            }
        });
        // No two whole panels side by side.
        for v in self.topology.vertices().filter(|v| self.on[*v] != 0) {
            let faces = self.topology.faces_at(v);
            let whole = faces.filter(|f| self.sides(*f) & !merged[*f] & self.on[v] != 0);
            let whole: Vec<FaceId> = whole.collect();
            if whole.len() > 1 {
                let joined = |f: FaceId| merged[f] | (self.sides(f) & self.on[v]);
                let reaches = |f: FaceId| {
                    let walls = joined(f);
                    walls.count_ones() > 1 && !self.is_at_axis(f, walls)
                };
                let order = |a: &&FaceId, b: &&FaceId| {
                    let [a, b] = [a, b].map(|f| (reaches(**f), share(**f)));
                    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
                };
                if let Some(least) = whole.iter().min_by(order) {
                    merged[*least] = joined(*least);
                }
            }
        }
        self.choose(&mut merged);
        merged
    }

    /// Area of a cell over that of a panel.
    fn share(&self, f: FaceId) -> f64 {
        let full = CELL * self.layout.face_length[f].powi(2);
        let at = |v: &VertexId| self.layout.mesh.position(*v);
        let ring: Vec<Vec3> = self.topology.face_vertices(f).iter().map(at).collect();
        let fan = ring
            .windows(2)
            .map(|p| (p[0] - ring[0]).cross(&(p[1] - ring[0])));
        0.5 * fan.sum::<Vec3>().norm() / full
    }

    /// Joins cells of doubtful size, or parts them, where that makes the panels there more regular.
    fn choose(&self, merged: &mut PerFace<u32>) {
        let in_doubt = |f: &FaceId| {
            let over = self.share(*f) / HALF;
            self.sides(*f) != 0 && over.max(1.0 / over) < DOUBT
        };
        let doubtful: Vec<FaceId> = self.topology.faces().filter(in_doubt).collect();
        for _ in 0..ROUNDS {
            let before = merged.clone();
            for f in &doubtful {
                let now = merged[*f];
                let mut cost = |choice: u32| {
                    merged[*f] = choice;
                    self.irregularity(*f, merged)
                };
                let best = (self.choices(*f)).min_by_key(|c| (cost(*c), *c != now));
                merged[*f] = best.unwrap_or(now);
            }
            if merged.as_slice() == before.as_slice() {
                break;
            }
        }
    }

    /// Walls across which a cell may be joined with its image: one at an axis across all of them,
    /// but for a cell in a right angle, whose panel may have an edge in one of the walls.
    fn choices(&self, f: FaceId) -> impl Iterator<Item = u32> {
        let sides = self.sides(f);
        let is_axis = sides.count_ones() > 1 && self.is_at_axis(f, sides);
        let all = is_axis && !self.is_square(sides);
        (0..=sides).filter(move |choice| choice & sides == *choice && (!all || *choice == sides))
    }

    /// How irregular a cell and those beside it in a wall are as panels; the most where two whole
    /// ones lie side by side there, or one is no panel.
    fn irregularity(&self, f: FaceId, merged: &PerFace<u32>) -> usize {
        let held = self
            .topology
            .face_vertices(f)
            .iter()
            .filter(|v| self.on[**v] != 0);
        let mut beside = BTreeSet::from([f]);
        let mut cost = 0;
        for v in held {
            let around = self.topology.faces_at(*v);
            let whole = around.filter(|g| {
                beside.insert(*g);
                self.sides(*g) & !merged[*g] & self.on[*v] != 0
            });
            cost += NO_PANEL * whole.count().saturating_sub(1);
        }
        let of = |g: &FaceId| match self.corners(*g, merged) {
            Some(0..3) => NO_PANEL,
            Some(n) => n.abs_diff(6).pow(2),
            None => 0,
        };
        cost + beside.iter().map(of).sum::<usize>()
    }

    /// Corners of the panel that a cell is, or is a part of: 0 if it can't be one, and nothing at
    /// the open boundary, where any number will do.
    fn corners(&self, f: FaceId, merged: &PerFace<u32>) -> Option<usize> {
        let is_open = |[a, b]: [VertexId; 2]| {
            let on_boundary = [a, b].iter().all(|v| self.topology.is_boundary_vertex(*v));
            on_boundary && self.on[a] & self.on[b] == 0
        };
        let corners = match merged[f] {
            0 => self.corners_of_whole(f).len(),
            _ => self.half(f, merged).map_or(0, |h| h.corners()),
        };
        let mut sides = sides(self.topology.face_vertices(f));
        (corners < 3 || !sides.any(is_open)).then_some(corners)
    }

    /// Whether a cell has a corner on the axis in which walls meet. One that has not, and a side in
    /// each of them, reaches across the domain: it can be joined across one of them alone.
    fn is_at_axis(&self, f: FaceId, walls: u32) -> bool {
        let ring = self.topology.face_vertices(f);
        ring.iter().any(|v| self.on[*v] & walls == walls)
    }

    /// Whether two walls meet at a right angle.
    fn is_square(&self, bits: u32) -> bool {
        matches!(named(self.walls, bits)[..], [a, b] if a.dot(&b).abs() < 1e-9)
    }

    /// Of the walls of a cell in a corner the one in which its side is longest: an edge of the
    /// panel lies in the other one, and its middle in the corner.
    fn longer(&self, f: FaceId, bits: u32) -> u32 {
        let length = |wall: u32| -> f64 {
            let sides = sides(self.topology.face_vertices(f));
            let held = sides.filter(|[a, b]| self.on[*a] & self.on[*b] & wall != 0);
            let ends = held.map(|e| e.map(|v| self.layout.mesh.position(v)));
            ends.map(|[a, b]| (a - b).norm()).sum()
        };
        let walls = (0..u32::BITS).map(|k| 1 << k).filter(|w| bits & w != 0);
        let longest = walls.max_by(|a, b| length(*a).total_cmp(&length(*b)));
        longest.unwrap_or(bits)
    }

    /// The corners of a whole panel: between two corners in one wall there are none.
    fn corners_of_whole(&self, f: FaceId) -> Vec<u32> {
        let ring = self.topology.face_vertices(f);
        let n = ring.len();
        let between = |i: usize| {
            let [a, b, c] = [i + n - 1, i, i + 1].map(|k| self.on[ring[k % n]]);
            a & b & c != 0
        };
        let kept = (0..n).filter(|i| !between(*i));
        kept.map(|i| ring[i].index() as u32).collect()
    }

    /// A cell that is a part of a panel.
    fn half(&self, f: FaceId, merged: &PerFace<u32>) -> Result<Half, String> {
        let ring = self.topology.face_vertices(f);
        let n = ring.len();
        let side = |i: usize| self.on[ring[i % n]] & self.on[ring[(i + 1) % n]];
        let in_wall = |i: usize| side(i) & merged[f];
        let begins = |i: &usize| in_wall(*i) != 0 && in_wall(i + n - 1) == 0;
        let starts: Vec<usize> = (0..n).filter(begins).collect();
        let [first] = starts[..] else {
            return Err("a panel would reach from one mirror plane to another".into());
        };
        let last = (first..first + n).find(|i| in_wall(*i) == 0);
        let last = last.ok_or("a panel has no edge inside")?;
        let single = |bits: u32| match bits.count_ones() {
            1 => Ok(bits.trailing_zeros() as usize),
            _ => Err("a panel has an edge on an axis".to_owned()),
        };
        let walls = [single(in_wall(first))?, single(in_wall(last + n - 1))?];
        let copies = match walls[0] == walls[1] {
            true => 2,
            false => {
                let [a, b] = walls.map(|k| self.walls[k]);
                (2.0 * PI / (PI - a.angle(&b))).round() as usize
            }
        };
        // An edge in the other wall of a corner has no corner between its ends.
        let free = (last + 1..first + n).filter(|i| side(*i) & side(i + n - 1) == 0);
        let ends = [first, last].map(|i| ring[i % n]);
        Ok(Half {
            free: free.map(|i| ring[i % n].index() as u32).collect(),
            ends: ends.map(|v| self.is_corner(v, f, merged).then_some(v.index() as u32)),
            walls,
            copies,
        })
    }

    /// Whether the end of a cell's side in a wall is a corner of the panel.
    fn is_corner(&self, v: VertexId, f: FaceId, merged: &PerFace<u32>) -> bool {
        let mut around = self.topology.faces_at(v);
        if let Some(g) = around.find(|g| *g != f) {
            return merged[g] & self.on[v] == 0;
        }
        // The end of the wall: a corner where the boundary has one.
        let ring = self.topology.face_vertices(f);
        let n = ring.len();
        let i = ring.iter().position(|w| *w == v).unwrap_or(0);
        let beside = [ring[(i + 1) % n], ring[(i + n - 1) % n]];
        let open = beside.iter().find(|w| self.on[**w] & self.on[v] == 0);
        let normal = self.walls[self.on[v].trailing_zeros() as usize];
        open.is_some_and(|w| {
            let along = self.layout.mesh.position(*w) - self.layout.mesh.position(v);
            (along - normal * normal.dot(&along)).norm() > SQUARE * along.norm()
        })
    }
}

/// A cell that is a part of a panel.
struct Half {
    /// Its corners in no wall, counter-clockwise.
    free: Vec<u32>,
    /// Corners of the panel in the wall where the walls begin, and where they end.
    ends: [Option<u32>; 2],
    /// Those walls.
    walls: [usize; 2],
    /// How many copies make up the panel.
    copies: usize,
}

impl Half {
    /// Corners of the panel.
    fn corners(&self) -> usize {
        let joints = self.ends.iter().flatten().count();
        self.copies * self.free.len() + self.copies / 2 * joints
    }
}

/// An image of a vertex in the making.
struct NewImage {
    source: u32,
    element: usize,
    place: Vec3,
}

struct WholeParts<'a> {
    cells: &'a WallCells<'a>,
    elements: Vec<Matrix3<f64>>,
    images: Vec<NewImage>,
    of_source: BTreeMap<u32, Vec<u32>>,
}

impl WholeParts<'_> {
    /// The number of a vertex's image under an element of the group: its own where it stays.
    fn image(&mut self, v: u32, map: &Matrix3<f64>) -> Result<u32, String> {
        let at = self.place(v);
        let place = map * at;
        let near = 1e-6 * self.cells.layout.mesh.mean_edge();
        if (place - at).norm() < near {
            return Ok(v);
        }
        let known = self.of_source.entry(v).or_default();
        let same = known
            .iter()
            .find(|k| (self.images[**k as usize].place - place).norm() < near);
        let number = match same {
            Some(k) => *k,
            None => {
                let element = number_of(&self.elements, map);
                let element = element.ok_or("a panel's image is none of the group")?;
                let next = self.images.len() as u32;
                known.push(next);
                self.images.push(NewImage {
                    source: v,
                    element,
                    place,
                });
                next
            }
        };
        Ok(self.cells.topology.n_vertices() as u32 + number)
    }

    /// A vertex, exactly in the walls that hold it.
    fn place(&self, v: u32) -> Vec3 {
        let v = VertexId::new(v);
        let p = self.cells.layout.mesh.position(v);
        in_walls(self.cells.walls, self.cells.on[v], p)
    }

    /// The corners of the panel of which a cell is a part.
    fn whole(&mut self, f: FaceId, merged: &PerFace<u32>) -> Result<Vec<u32>, String> {
        let half = self.cells.half(f, merged)?;
        let maps = half.walls.map(|k| reflection(self.cells.walls[k]));
        let mut corners = Vec::new();
        let mut map = Matrix3::identity();
        for copy in 0..half.copies {
            let forward = copy % 2 == 0;
            let order: Vec<u32> = match forward {
                true => half.free.clone(),
                false => half.free.iter().rev().copied().collect(),
            };
            // Where one copy ends the next begins, in the wall of the cell's first or last side.
            let joint = half.ends[usize::from(!forward)];
            for v in order.into_iter().chain(joint) {
                corners.push(self.image(v, &map)?);
            }
            map *= maps[usize::from(!forward)];
        }
        match corners.len() {
            0..3 => Err("a panel at a mirror plane has fewer than three corners".into()),
            _ => Ok(corners),
        }
    }

    fn finished(self, rings: Vec<Vec<u32>>, merged: &PerFace<u32>) -> Result<WholePanels, String> {
        let (cells, layout) = (self.cells, self.cells.layout);
        let count = cells.topology.n_vertices() as u32;
        let mut number: BTreeMap<u32, u32> = BTreeMap::new();
        // Sources of images are corners themselves.
        for v in rings.iter().flatten() {
            let next = number.len() as u32;
            number.entry(*v).or_insert(next);
        }
        let mut old = vec![0; number.len()];
        number.iter().for_each(|(v, k)| old[*k as usize] = *v);
        let source = |v: u32| match v < count {
            true => VertexId::new(v),
            false => VertexId::new(self.images[(v - count) as usize].source),
        };
        let place = |v: &u32| match *v < count {
            true => self.place(*v),
            false => self.images[(*v - count) as usize].place,
        };
        let faces: Vec<Vec<u32>> = (rings.iter())
            .map(|r| r.iter().map(|v| number[v]).collect())
            .collect();
        let mesh = HexMesh::new(old.iter().map(place).collect(), &faces)
            .map_err(|e| format!("panels at mirror planes do not meet: {e}"))?;
        let kind = |v: &u32| match layout.vertex_kind[source(*v)] {
            kind if cells.on[source(*v)] == 0 || kind == VertexKind::BoundaryCorner => kind,
            _ => VertexKind::Interior,
        };
        let on_walls = |f: FaceId, x: Vec3| in_walls(cells.walls, merged[f], x);
        let each = |of: &PerFace<Vec3>| {
            PerFace::from_vec(of.enumerate().map(|(f, p)| on_walls(f, *p)).collect())
        };
        Ok(WholePanels {
            layout: Layout {
                mesh,
                vertex_kind: PerVertex::from_vec(old.iter().map(kind).collect()),
                face_point: each(&layout.face_point),
                face_normal: each(&layout.face_normal).map(|n| n.normalize()),
                ..layout.clone()
            },
            quotient: self.quotient(&number),
        })
    }

    /// What is no unknown, with the numbers that corners of panels have.
    fn quotient(&self, number: &BTreeMap<u32, u32>) -> Quotient {
        let cells = self.cells;
        let count = cells.topology.n_vertices() as u32;
        let mut quotient = Quotient::default();
        for (v, k) in number {
            if let Some(image) = v.checked_sub(count).map(|i| &self.images[i as usize]) {
                let image = Image {
                    source: number[&image.source],
                    map: self.elements[image.element],
                };
                quotient.images.insert(*k, image);
            } else if let bits @ 1.. = cells.on[VertexId::new(*v)] {
                let wall = cells.walls[bits.trailing_zeros() as usize];
                quotient.mirrored.insert(*k, wall);
            }
        }
        quotient
    }
}

/// What is no unknown in a mesh that symmetry has made whole, by where its vertices lie: after a
/// search they have other numbers.
///
/// # Errors
/// If an image has no source.
pub(crate) fn quotient_of(mesh: &HexMesh, group: Group) -> Result<Quotient, String> {
    let (walls, elements) = (group.walls(), group.elements());
    let near = PUT_THERE * mesh.diagonal();
    let inside = |p: &Vec3| walls.iter().all(|n| n.dot(p) > -near);
    let mut order: Vec<(f64, u32)> = (mesh.positions.enumerate())
        .filter(|(_, p)| inside(p))
        .map(|(v, p)| (p.x, v.index() as u32))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |p: Vec3| {
        let first = order.partition_point(|o| o.0 < p.x - near);
        let close = order[first..].iter().take_while(|o| o.0 <= p.x + near);
        let same = |v: &u32| (mesh.position(VertexId::new(*v)) - p).norm() <= 2.0 * near;
        close.map(|o| o.1).find(same)
    };
    let mut quotient = Quotient::default();
    for (v, p) in mesh.positions.enumerate() {
        let number = v.index() as u32;
        if inside(p) {
            let wall = walls.iter().find(|n| n.dot(p).abs() <= near);
            quotient.mirrored.extend(wall.map(|n| (number, *n)));
            continue;
        }
        let (folded, back) = folded(&walls, *p);
        let source = at(folded).ok_or("a panel at a mirror plane has lost its image")?;
        let element = number_of(&elements, &back).ok_or("a map is none of the group")?;
        let map = elements[element];
        quotient.images.insert(number, Image { source, map });
    }
    Ok(quotient)
}
