//! A [`TriangleSurface`] from faces as they stand in a file.
//!
//! The order of the checks: coordinates, corners, edges, orientation, vertices, polygons, areas.
//! Vertices and faces are named by their numbers in the soup, from 0.
//!
//! - *Orientation* is made consistent over each connected component, by turning the smaller number
//!   of faces (at equal numbers the first face stays). A closed component that is inside out as a
//!   whole stays so: normals may point either way for what phex does, and the input's choice is the
//!   user's.
//! - *Polygons* are ear-clipped in their least-squares plane.
//! - *Zero area* means: the triangle's least height is at most four units in the last place of the
//!   largest coordinate, `4 eps max |x|`, that is, no height beyond the rounding of its own
//!   corners; needles above that are kept.

use crate::disjoint_sets::DisjointSets;
use crate::ear_clip::ear_clip_corners;
use crate::extent;
use crate::mend::{self, least_height};
use crate::topology::{TopologyError, check_corners};
use crate::{ElementId, FaceId, PolygonSoup, TriangleSurface, Vec3, VertexId};
use std::collections::HashMap;
use thiserror::Error;

/// Messages list at most this many elements.
const LISTED: usize = 10;

/// Why faces are no triangle surface. Vertices and faces are those of the input, from 0.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A coordinate is not finite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NonFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// The model has no extent, or one beyond what can be computed with.
    #[error("the model's extent {extent:e} is outside 1e-50 to 1e50")]
    Extent {
        /// Longest side of the bounding box, or largest coordinate.
        extent: f64,
    },
    /// Faces, edges or vertices that no manifold has.
    #[error(transparent)]
    Topology(#[from] TopologyError),
    /// The surface has one side only, like a Moebius strip.
    #[error(
        "the surface can't be oriented (it is one-sided like a Moebius strip): faces {first} and {second} disagree at \
         the edge between vertices {from} and {to} once all others agree"
    )]
    NotOrientable {
        /// One end of the edge.
        from: VertexId,
        /// The other end.
        to: VertexId,
        /// One face at the edge.
        first: FaceId,
        /// The other face.
        second: FaceId,
    },
    /// Polygons that can't be cut into triangles.
    #[error("{} not simple in their planes (they touch or cross themselves): {}", are(.faces), list(.faces))]
    NotSimple {
        /// The faces.
        faces: Vec<FaceId>,
    },
    /// Triangles, or parts of polygons, without area.
    #[error("{} without area: {}", are(.faces), list(.faces))]
    ZeroArea {
        /// The faces.
        faces: Vec<FaceId>,
    },
}

/// What was changed to make a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceNotes {
    /// Vertices that belong to no face and were dropped.
    pub unused_vertices: usize,
    /// Faces that were turned round.
    pub turned_faces: usize,
    /// Faces with more than three corners, cut into triangles.
    pub cut_polygons: usize,
    /// Faces with their corners in the places of another one's that were left out.
    pub repeated_faces: usize,
    /// Faces without area that were left out.
    pub dropped_faces: usize,
    /// Edges of boundaries that lay on one another and were joined.
    pub sewn_edges: usize,
    /// Largest distance over which they were joined, in the unit of the coordinates; zero for one
    /// below 1e-9 diagonals.
    pub widest_gap: f64,
    /// Closed components whose normals point inwards.
    pub inward_bodies: usize,
    /// What the file holds beside faces, for a reader of files to say.
    pub others: crate::OtherElements,
}

/// A connected surface and where its elements come from.
#[derive(Clone)]
pub struct SurfaceComponent {
    /// The surface; its vertices and triangles keep the order of the input.
    pub surface: TriangleSurface,
    /// Number in the input of each vertex.
    pub original_vertices: Vec<u32>,
    /// Number in the input of the face that each triangle is a part of.
    pub original_faces: Vec<u32>,
}

/// The connected surfaces of a soup; see [`TriangleSurface::from_soup`].
#[derive(Clone)]
pub struct SurfaceParts {
    /// At least one, in the order of their first faces.
    pub components: Vec<SurfaceComponent>,
    /// What was changed, over all components.
    pub notes: SurfaceNotes,
}

impl SurfaceNotes {
    /// What was changed, as sentences.
    pub fn sentences(&self) -> Vec<String> {
        let counted = [
            (
                self.unused_vertices,
                [
                    "vertex belongs to no face and was",
                    "vertices belong to no face and were",
                ],
                "left out",
            ),
            (
                self.turned_faces,
                ["face was", "faces were"],
                "turned round to agree with neighbours",
            ),
            (
                self.cut_polygons,
                ["polygon was", "polygons were"],
                "cut into triangles",
            ),
            (
                self.repeated_faces,
                [
                    "face is there twice and was",
                    "faces are there twice and were",
                ],
                "left out",
            ),
            (
                self.dropped_faces,
                ["face without area was", "faces without area were"],
                "left out",
            ),
            (
                self.inward_bodies,
                ["closed part has", "closed parts have"],
                "normals that point inwards, by which offsets and `fab --side` go",
            ),
        ];
        let counted = counted.into_iter().filter(|&(count, ..)| count > 0);
        let seams = (self.sewn_edges > 0).then(|| {
            let (edges, gap) = (self.sewn_edges, self.widest_gap);
            let gap = if gap > 0.0 {
                format!(", over gaps of at most {gap:.1e}")
            } else {
                String::new()
            };
            format!("edges of boundaries that lay on one another were joined: {edges}{gap}")
        });
        counted
            .map(|(count, [one, many], what)| match count {
                1 => format!("1 {one} {what}"),
                _ => format!("{count} {many} {what}"),
            })
            .chain(seams)
            .chain(self.others.told())
            .collect()
    }
}

impl SurfaceParts {
    /// All connected surfaces as one.
    pub fn whole(&self) -> TriangleSurface {
        let parts = self.components.iter().map(|c| &c.surface);
        TriangleSurface::joined(parts).expect("the parts of a file are surfaces that it can number")
    }
}

/// A step of mending; `None` where there is nothing to do.
type MendingStep<'a> = &'a dyn Fn(&PolygonSoup) -> Option<mend::Mended>;

impl TriangleSurface {
    /// The triangles as plain lists.
    pub fn to_soup(&self) -> PolygonSoup {
        PolygonSoup {
            positions: self.positions().as_slice().to_vec(),
            faces: self.topology().face_lists(),
        }
    }

    /// One surface of several parts.
    ///
    /// # Errors
    /// If there is no part, or they together have more elements than can be addressed.
    pub fn joined<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Result<Self, TopologyError> {
        let parts: Vec<&Self> = parts.into_iter().collect();
        if let [whole] = parts[..] {
            return Ok(whole.clone());
        }
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for part in parts {
            let first = positions.len() as u32;
            positions.extend_from_slice(part.positions().as_slice());
            let topology = part.topology();
            let corners = 3 * (triangles.len() + topology.n_faces());
            if corners >= u32::MAX as usize {
                return Err(TopologyError::TooLarge { corners });
            }
            triangles.extend(topology.faces().map(|f| {
                let corners = topology.face_vertices(f);
                [corners[0], corners[1], corners[2]].map(|v| v.index() as u32 + first)
            }));
        }
        Self::new(positions, &triangles)
    }

    /// Builds the connected surfaces of faces of any valence: drops unused vertices, makes the
    /// orientation consistent, cuts polygons into triangles, takes out faces that are there twice
    /// and faces without area, and sews boundaries together that lie on one another (module
    /// `mend`). Mending that leads to no surface is not done. Whether more than one component is
    /// welcome is for the caller to say.
    ///
    /// # Errors
    /// A [`SurfaceError`] that names the elements: a coordinate that is not finite, a face with
    /// fewer than three corners, a missing or repeated vertex, an edge with three faces, a bow-tie
    /// vertex, a one-sided surface, a polygon that is not simple, a triangle without area that
    /// can't be taken out.
    pub fn from_soup(soup: &PolygonSoup) -> Result<SurfaceParts, SurfaceError> {
        check_size(soup)?;
        check_vertices(soup)?;
        let (largest, unused_vertices) = check_positions(soup)?;
        let without_area = |soup: &_| mend::without_degenerate_faces(soup, rounding(largest));
        let mut mended = Vec::new();
        let steps: [MendingStep<'_>; 3] =
            [&mend::without_repeated_faces, &without_area, &mend::sewn];
        for step in steps {
            let before: Option<&mend::Mended> = mended.last();
            let found = step(before.map_or(soup, |before| &before.soup));
            mended.extend(found.map(|next| match before {
                Some(before) => next.after(before),
                None => next,
            }));
        }
        for mended in mended.into_iter().rev() {
            if let Ok(mut parts) = Self::from_sound_soup(&mended.soup) {
                parts.notes.unused_vertices = unused_vertices;
                parts.notes.repeated_faces = mended.repeated_faces;
                parts.notes.dropped_faces = mended.dropped_faces;
                parts.notes.sewn_edges = mended.sewn_edges;
                parts.notes.widest_gap = mended.widest_gap;
                let original = |f: &mut u32| *f = mended.original_faces[*f as usize];
                let components = parts.components.iter_mut();
                components.for_each(|c| c.original_faces.iter_mut().for_each(original));
                return Ok(parts);
            }
        }
        Self::from_sound_soup(soup)
    }

    /// As [`from_soup`](Self::from_soup), without mending.
    fn from_sound_soup(soup: &PolygonSoup) -> Result<SurfaceParts, SurfaceError> {
        check_corners(soup.positions.len(), &soup.faces)?;
        let (largest, unused_vertices) = check_positions(soup)?;
        let corners = Corners::new(&soup.faces);
        let joints = corners.joints()?;
        corners.check_fans(&joints, soup.positions.len())?;
        let sides = corners.sides(&joints)?;
        let triangles = cut_polygons(soup, &sides.turned)?;
        check_areas(&soup.positions, &triangles, largest)?;
        let components = split(soup, &triangles, &sides)?;
        let looks_inwards = |c: &&SurfaceComponent| {
            let topology = c.surface.topology();
            let triangles = c.surface.topology().faces().map(|f| c.surface.corners(f));
            topology.is_closed() && volume(triangles) < 0.0
        };
        let notes = SurfaceNotes {
            unused_vertices,
            inward_bodies: components.iter().filter(looks_inwards).count(),
            turned_faces: sides.turned.iter().filter(|&&turned| turned).count(),
            cut_polygons: soup.faces.iter().filter(|f| f.len() > 3).count(),
            ..SurfaceNotes::default()
        };
        Ok(SurfaceParts { components, notes })
    }
}

impl PolygonSoup {
    /// The same faces with boundaries sewn together that lie on one another (as
    /// [`TriangleSurface::from_soup`] does), on the vertices that they use, and what was done.
    /// `None` where there are none, or no faces that could be sewn.
    ///
    /// ```
    /// use phex_mesh::{PolygonSoup, Vec3};
    /// let corners = [0.0, 1.0, 1.0, 2.0].map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]);
    /// let soup = PolygonSoup {
    ///     positions: corners.concat(),
    ///     faces: vec![vec![0, 2, 3, 1], vec![4, 6, 7, 5]],
    /// };
    /// let (sewn, notes) = soup.sewn().expect("two squares that share a side");
    /// assert_eq!((sewn.positions.len(), notes.sewn_edges), (6, 2));
    /// ```
    pub fn sewn(&self) -> Option<(Self, SurfaceNotes)> {
        check_corners(self.positions.len(), &self.faces).ok()?;
        check_positions(self).ok()?;
        let sewn = mend::sewn(self)?;
        let notes = SurfaceNotes {
            sewn_edges: sewn.sewn_edges,
            widest_gap: sewn.widest_gap,
            ..SurfaceNotes::default()
        };
        Some((sewn.soup.without_unused_vertices(), notes))
    }

    /// Volume inside closed faces, which are planar, in cubic units of the coordinates: positive if
    /// their normals point out.
    ///
    /// ```
    /// use phex_mesh::{PolygonSoup, Vec3};
    /// let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(Vec3::from).to_vec();
    /// let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|f| f.to_vec()).to_vec();
    /// assert!((PolygonSoup { positions, faces }.volume() - 1.0 / 6.0).abs() < 1e-15);
    /// ```
    pub fn volume(&self) -> f64 {
        let at = |k: u32| self.positions[k as usize];
        let fan = |face: &Vec<u32>| {
            let sides = 2..face.len();
            let triangle = |k: usize| [face[0], face[k - 1], face[k]].map(at);
            sides.map(triangle).collect::<Vec<_>>()
        };
        volume(self.faces.iter().flat_map(fan))
    }

    /// The same faces without vertices that none of them names; indices that do not exist are left
    /// for others to find.
    pub fn without_unused_vertices(&self) -> Self {
        let exists = |v: &u32| (*v as usize) < self.positions.len();
        if !self.faces.iter().flatten().all(exists) {
            return self.clone();
        }
        let is_used = used_vertices(self);
        let count = |kept: &mut u32, &used: &bool| {
            let number = *kept;
            *kept += u32::from(used);
            Some(number)
        };
        let number: Vec<u32> = is_used.iter().scan(0, count).collect();
        let used = self
            .positions
            .iter()
            .zip(&is_used)
            .filter(|(_, used)| **used);
        let renumber = |face: &Vec<u32>| face.iter().map(|&v| number[v as usize]).collect();
        Self {
            positions: used.map(|(p, _)| *p).collect(),
            faces: self.faces.iter().map(renumber).collect(),
        }
    }
}

/// Volume inside triangles, measured from a corner of the first of them: far from the origin, it
/// would be the difference of large numbers.
fn volume(triangles: impl Iterator<Item = [Vec3; 3]>) -> f64 {
    let mut triangles = triangles.peekable();
    let origin = triangles.peek().map_or(Vec3::zeros(), |t| t[0]);
    let tetrahedra = triangles.map(|t| {
        let [a, b, c] = t.map(|p| p - origin);
        a.dot(&b.cross(&c))
    });
    tetrahedra.sum::<f64>() / 6.0
}

fn check_size(soup: &PolygonSoup) -> Result<(), TopologyError> {
    let corners = soup.faces.iter().map(Vec::len).sum();
    // Cutting a polygon of n corners makes 3 (n - 2) corners.
    if corners >= u32::MAX as usize / 3 || soup.positions.len() >= u32::MAX as usize {
        return Err(TopologyError::TooLarge { corners });
    }
    if soup.faces.is_empty() {
        return Err(TopologyError::Empty);
    }
    Ok(())
}

fn check_vertices(soup: &PolygonSoup) -> Result<(), TopologyError> {
    let vertices = soup.positions.len();
    let missing = |&v: &u32| v as usize >= vertices;
    let first = |face: &Vec<u32>| face.iter().copied().find(missing);
    let mut found = soup.faces.iter().map(first).enumerate();
    match found.find_map(|(f, v)| Some((FaceId::from_index(f), v?))) {
        Some((face, vertex)) => Err(TopologyError::IndexOutOfRange {
            face,
            vertex,
            vertices,
        }),
        None => Ok(()),
    }
}

/// The largest coordinate of the vertices that are used, and the number of those that are not.
fn check_positions(soup: &PolygonSoup) -> Result<(f64, usize), SurfaceError> {
    let finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
    if let Some(i) = soup.positions.iter().position(|p| !finite(p)) {
        let vertex = VertexId::from_index(i);
        return Err(SurfaceError::NonFinite { vertex });
    }
    let is_used = used_vertices(soup);
    let used = soup
        .positions
        .iter()
        .zip(&is_used)
        .filter(|(_, used)| **used);
    let largest = extent::largest_coordinate(used.map(|(p, _)| p))
        .map_err(|extent| SurfaceError::Extent { extent })?;
    Ok((largest, is_used.iter().filter(|used| !**used).count()))
}

fn used_vertices(soup: &PolygonSoup) -> Vec<bool> {
    let mut is_used = vec![false; soup.positions.len()];
    let corners = soup.faces.iter().flatten();
    corners.for_each(|&v| is_used[v as usize] = true);
    is_used
}

/// Face corners in one list. Corner `c` also stands for the side from it to the next corner.
struct Corners {
    vertex: Vec<u32>,
    face: Vec<u32>,
    next: Vec<u32>,
}

/// An edge with two faces, as their sides along it.
#[derive(Clone, Copy)]
struct Joint {
    sides: [u32; 2],
    /// Whether both faces run through it in the same direction.
    same_direction: bool,
}

/// What orienting all faces gives.
struct OrientedFaces {
    /// Component of each face, numbered by first faces.
    component: Vec<u32>,
    /// Whether each face is to be turned.
    turned: Vec<bool>,
}

impl Corners {
    fn new(faces: &[Vec<u32>]) -> Self {
        let mut corners = Self {
            vertex: Vec::new(),
            face: Vec::new(),
            next: Vec::new(),
        };
        for (f, face) in faces.iter().enumerate() {
            let start = corners.vertex.len() as u32;
            let n = face.len() as u32;
            corners.vertex.extend(face);
            corners
                .face
                .extend(std::iter::repeat_n(f as u32, face.len()));
            corners.next.extend((1..=n).map(|i| start + i % n));
        }
        corners
    }

    /// Ends of a side, lower vertex first, and whether it runs from the lower to the higher.
    fn ends(&self, side: u32) -> (u32, u32, bool) {
        let from = self.vertex[side as usize];
        let to = self.vertex[self.next[side as usize] as usize];
        (from.min(to), from.max(to), from < to)
    }

    /// All edges with two faces, in the order of their ends.
    fn joints(&self) -> Result<Vec<Joint>, TopologyError> {
        let mut sides: Vec<(u32, u32, u32)> = (0..self.vertex.len() as u32)
            .map(|side| (self.ends(side).0, self.ends(side).1, side))
            .collect();
        sides.sort_unstable();
        let edges = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        edges
            .filter(|edge| edge.len() > 1)
            .map(|edge| self.joint(edge))
            .collect()
    }

    fn joint(&self, edge: &[(u32, u32, u32)]) -> Result<Joint, TopologyError> {
        match *edge {
            [(_, _, a), (_, _, b)] => Ok(Joint {
                sides: [a, b],
                same_direction: self.ends(a).2 == self.ends(b).2,
            }),
            _ => Err(TopologyError::NonManifoldEdge {
                from: VertexId::new(edge[0].0),
                to: VertexId::new(edge[0].1),
                faces: edge
                    .iter()
                    .map(|&(_, _, side)| self.face_id(side))
                    .collect(),
            }),
        }
    }

    fn face_id(&self, side: u32) -> FaceId {
        FaceId::new(self.face[side as usize])
    }

    /// Joins the corners at a vertex across edges: every vertex must end with one fan.
    fn check_fans(&self, joints: &[Joint], vertices: usize) -> Result<(), TopologyError> {
        let mut fans = DisjointSets::new(self.vertex.len());
        for joint in joints {
            let [a, b] = joint.sides;
            let [a_end, b_end] = joint.sides.map(|side| self.next[side as usize]);
            let (at_a, at_a_end) = if joint.same_direction {
                (b, b_end)
            } else {
                (b_end, b)
            };
            fans.join(a, at_a);
            fans.join(a_end, at_a_end);
        }
        let mut fan_of = vec![None; vertices];
        for corner in 0..self.vertex.len() as u32 {
            let fan = fans.root(corner);
            let v = self.vertex[corner as usize];
            if *fan_of[v as usize].get_or_insert(fan) != fan {
                return Err(TopologyError::BowTieVertex {
                    vertex: VertexId::new(v),
                });
            }
        }
        Ok(())
    }

    /// Walks over each component from its first face and turns the faces that disagree, or the
    /// others if they are fewer.
    fn sides(&self, joints: &[Joint]) -> Result<OrientedFaces, SurfaceError> {
        let n_faces = self.face.last().map_or(0, |&f| f as usize + 1);
        let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); n_faces];
        for joint in joints {
            let [f, g] = joint.sides.map(|side| self.face[side as usize]);
            neighbours[f as usize].push((g, joint.same_direction));
            neighbours[g as usize].push((f, joint.same_direction));
        }
        let mut sides = OrientedFaces {
            component: vec![u32::MAX; n_faces],
            turned: vec![false; n_faces],
        };
        let mut count = 0;
        for seed in 0..n_faces {
            if sides.component[seed] == u32::MAX {
                sides.spread(seed as u32, count, &neighbours);
                count += 1;
            }
        }
        self.check_sides(joints, &sides)?;
        Ok(sides)
    }

    fn check_sides(&self, joints: &[Joint], sides: &OrientedFaces) -> Result<(), SurfaceError> {
        let turned = |side: u32| sides.turned[self.face[side as usize] as usize];
        let agree = |j: &&Joint| (turned(j.sides[0]) != turned(j.sides[1])) == j.same_direction;
        let Some(joint) = joints.iter().find(|joint| !agree(joint)) else {
            return Ok(());
        };
        let (from, to, _) = self.ends(joint.sides[0]);
        Err(SurfaceError::NotOrientable {
            from: VertexId::new(from),
            to: VertexId::new(to),
            first: self.face_id(joint.sides[0]),
            second: self.face_id(joint.sides[1]),
        })
    }
}

impl OrientedFaces {
    fn spread(&mut self, seed: u32, component: u32, neighbours: &[Vec<(u32, bool)>]) {
        let mut faces = vec![seed];
        self.component[seed as usize] = component;
        let mut done = 0;
        while let Some(&f) = faces.get(done) {
            done += 1;
            for &(g, same_direction) in &neighbours[f as usize] {
                if self.component[g as usize] == u32::MAX {
                    self.component[g as usize] = component;
                    self.turned[g as usize] = self.turned[f as usize] != same_direction;
                    faces.push(g);
                }
            }
        }
        let n_turned = faces.iter().filter(|&&f| self.turned[f as usize]).count();
        if 2 * n_turned > faces.len() {
            faces.iter().for_each(|&f| self.turned[f as usize] ^= true);
        }
    }
}

/// A triangle of the result: vertices and face of the input.
struct Triangle {
    vertices: [u32; 3],
    face: u32,
}

/// Triangles of polygons. Quadrilaterals on both sides of a corner where only two faces meet, as at
/// the corners of a cushion, have three vertices in common, and are cut along different diagonals.
fn cut_polygons(soup: &PolygonSoup, turned: &[bool]) -> Result<Vec<Triangle>, SurfaceError> {
    let mut triangles = Vec::with_capacity(soup.faces.len());
    // The ends of each diagonal, and the other two corners.
    let mut diagonals = HashMap::new();
    let (mut not_simple, mut without_area) = (Vec::new(), Vec::new());
    for (f, face) in soup.faces.iter().enumerate() {
        let mut vertices = face.clone();
        if turned[f] {
            // The first corner stays the first.
            vertices[1..].reverse();
        }
        let points: Vec<Vec3> = vertices
            .iter()
            .map(|&v| soup.positions[v as usize])
            .collect();
        match ear_clip_corners(&points) {
            Ok(mut ears) => {
                if vertices.len() == 4 {
                    let pair = |corners: [usize; 2]| {
                        let [a, b] = corners.map(|i| vertices[i]);
                        [a.min(b), a.max(b)]
                    };
                    let cut = diagonal(&ears);
                    let across = pair([cut[0] ^ 1, cut[1] ^ 1]);
                    // Two that have all vertices in common enclose nothing.
                    match diagonals.insert(pair(cut), across) {
                        Some(other) if other != across => {
                            ears = other_half(&ears, &points).unwrap_or(ears);
                        }
                        _ => {}
                    }
                }
                triangles.extend(ears.iter().map(|ear| Triangle {
                    vertices: ear.map(|i| vertices[i as usize]),
                    face: f as u32,
                }));
            }
            Err(_) if is_straight(&points) => without_area.push(FaceId::from_index(f)),
            Err(_) => not_simple.push(FaceId::from_index(f)),
        }
    }
    if !without_area.is_empty() {
        return Err(SurfaceError::ZeroArea {
            faces: without_area,
        });
    }
    if !not_simple.is_empty() {
        return Err(SurfaceError::NotSimple { faces: not_simple });
    }
    Ok(triangles)
}

/// The corners of a quadrilateral that are in both of its triangles.
fn diagonal(ears: &[[u32; 3]]) -> [usize; 2] {
    let is_cut = |i: u32| ears.iter().all(|ear| ear.contains(&i));
    if is_cut(0) { [0, 2] } else { [1, 3] }
}

/// The two triangles of a convex quadrilateral along its other diagonal.
fn other_half(ears: &[[u32; 3]], points: &[Vec3]) -> Option<Vec<[u32; 3]>> {
    let others = match diagonal(ears) {
        [0, _] => [[1, 2, 3], [1, 3, 0]],
        _ => [[0, 1, 2], [0, 2, 3]],
    };
    let normal = |t: [u32; 3]| {
        let [a, b, c] = t.map(|i| points[i as usize]);
        (b - a).cross(&(c - a))
    };
    (normal(others[0]).dot(&normal(others[1])) > 0.0).then(|| others.to_vec())
}

/// Whether all points lie on a line, up to rounding.
fn is_straight(points: &[Vec3]) -> bool {
    let far = |from: Vec3| {
        points
            .iter()
            .map(|p| p - from)
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
    };
    let direction = far(points[0]).unwrap_or_default();
    let height = |p: &Vec3| (p - points[0]).cross(&direction).norm();
    let rounding = rounding(largest_coordinate(points)) * direction.norm();
    points.iter().all(|p| height(p) <= rounding)
}

fn check_areas(
    positions: &[Vec3],
    triangles: &[Triangle],
    largest: f64,
) -> Result<(), SurfaceError> {
    let rounding = rounding(largest);
    let flat = |t: &&Triangle| least_height(t.vertices.map(|v| positions[v as usize])) <= rounding;
    let mut faces: Vec<FaceId> = triangles
        .iter()
        .filter(flat)
        .map(|t| FaceId::new(t.face))
        .collect();
    faces.dedup();
    if faces.is_empty() {
        Ok(())
    } else {
        Err(SurfaceError::ZeroArea { faces })
    }
}

/// Heights of triangles up to here are roundings of their corners.
fn rounding(largest: f64) -> f64 {
    4.0 * f64::EPSILON * largest
}

fn largest_coordinate(positions: &[Vec3]) -> f64 {
    positions.iter().map(|p| p.amax()).fold(0.0, f64::max)
}

fn split(
    soup: &PolygonSoup,
    triangles: &[Triangle],
    sides: &OrientedFaces,
) -> Result<Vec<SurfaceComponent>, SurfaceError> {
    let count = sides.component.iter().max().map_or(0, |&c| c as usize + 1);
    let mut parts: Vec<Vec<&Triangle>> = vec![Vec::new(); count];
    for triangle in triangles {
        parts[sides.component[triangle.face as usize] as usize].push(triangle);
    }
    let mut local = vec![u32::MAX; soup.positions.len()];
    parts
        .iter()
        .map(|part| component(soup, part, &mut local))
        .collect()
}

/// `local` is scratch: a vertex belongs to one component only, so that it need not be cleared.
fn component(
    soup: &PolygonSoup,
    triangles: &[&Triangle],
    local: &mut [u32],
) -> Result<SurfaceComponent, SurfaceError> {
    let mut original_vertices: Vec<u32> = triangles.iter().flat_map(|t| t.vertices).collect();
    original_vertices.sort_unstable();
    original_vertices.dedup();
    for (i, &v) in original_vertices.iter().enumerate() {
        local[v as usize] = i as u32;
    }
    let original_faces: Vec<u32> = triangles.iter().map(|t| t.face).collect();
    let positions = original_vertices
        .iter()
        .map(|&v| soup.positions[v as usize])
        .collect();
    let corners: Vec<[u32; 3]> = triangles
        .iter()
        .map(|t| t.vertices.map(|v| local[v as usize]))
        .collect();
    let surface = TriangleSurface::new(positions, &corners)
        .map_err(|error| in_input_numbers(error, &original_vertices, &original_faces))?;
    Ok(SurfaceComponent {
        surface,
        original_vertices,
        original_faces,
    })
}

/// Only the diagonals of cut polygons can still clash here: two that join the same vertices, or one
/// along an edge.
fn in_input_numbers(error: TopologyError, vertices: &[u32], faces: &[u32]) -> TopologyError {
    let vertex = |v: VertexId| VertexId::new(vertices[v.index()]);
    let face = |f: FaceId| FaceId::new(faces[f.index()]);
    match error {
        TopologyError::NonManifoldEdge { from, to, faces } => TopologyError::NonManifoldEdge {
            from: vertex(from),
            to: vertex(to),
            faces: faces.into_iter().map(face).collect(),
        },
        TopologyError::InconsistentOrientation {
            from,
            to,
            first,
            second,
        } => TopologyError::InconsistentOrientation {
            from: vertex(from),
            to: vertex(to),
            first: face(first),
            second: face(second),
        },
        TopologyError::BowTieVertex { vertex: v } => {
            TopologyError::BowTieVertex { vertex: vertex(v) }
        }
        other => other,
    }
}

fn are(faces: &[FaceId]) -> String {
    match faces.len() {
        1 => "one face is".to_owned(),
        n => format!("{n} faces are"),
    }
}

fn list(faces: &[FaceId]) -> String {
    let shown: Vec<String> = faces.iter().take(LISTED).map(ToString::to_string).collect();
    let more = if faces.len() > LISTED { ", ..." } else { "" };
    shown.join(", ") + more
}
