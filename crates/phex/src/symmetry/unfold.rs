//! A panelling and all its images as one mesh.

use super::group::number_of;
use crate::optimise::{PUT_THERE, Quotient};
use crate::smooth_surface::Affinity;
use nalgebra::Matrix3;
use phex_mesh::{FaceId, HexMesh, PerFace, PerVertex, TopologyError, Vec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// An isometry `x -> M x + t`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Isometry {
    /// Rows of `M`.
    pub rows: [[f64; 3]; 3],
    /// `t`, model units.
    pub shift: [f64; 3],
}

impl Isometry {
    pub(crate) fn new(map: &Matrix3<f64>, shift: Vec3) -> Self {
        let row = |r: usize| [0, 1, 2].map(|c| map[(r, c)]);
        Self {
            rows: [0, 1, 2].map(row),
            shift: shift.into(),
        }
    }

    /// The image of a point: `((m_k0 x + m_k1 y) + m_k2 z) + t_k`, rounded after each operation.
    ///
    /// ```
    /// # use phex_mesh::Vec3;
    /// use phex::symmetry::Isometry;
    ///
    /// let mirror = Isometry { rows: [[-1., 0., 0.], [0., 1., 0.], [0., 0., 1.]], shift: [0.; 3] };
    /// assert_eq!(mirror.image(Vec3::new(0.1, 0.2, 0.3)), Vec3::new(-0.1, 0.2, 0.3));
    /// ```
    pub fn image(&self, p: Vec3) -> Vec3 {
        let row = |k: usize| {
            let [a, b, c] = self.rows[k];
            ((a * p.x + b * p.y) + c * p.z) + self.shift[k]
        };
        Vec3::new(row(0), row(1), row(2))
    }

    fn map(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|r, c| self.rows[r][c])
    }

    /// The same on points that an affinity has brought back to the model.
    fn restored(&self, affinity: &Affinity) -> Self {
        let map = self.map();
        let centre = affinity.centre;
        let shift = affinity.restore_vector(self.shift.into()) + (centre - map * centre);
        Self::new(&map, shift)
    }
}

/// How a mesh with symmetries comes from a part of it: every vertex is the image of one of that
/// part, to the last bit, and so is every panel whose corners are all of that part.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbits {
    /// The group's elements, the identity first.
    pub operations: Vec<Isometry>,
    /// For each vertex the one that it is the image of, itself for those of the part, and the
    /// number of the operation.
    pub vertices: Vec<(u32, u32)>,
    /// The same for each panel.
    pub panels: Vec<(u32, u32)>,
}

impl Orbits {
    /// The same in model coordinates.
    pub(crate) fn restored(mut self, affinity: &Affinity) -> Self {
        self.operations = (self.operations.iter())
            .map(|o| o.restored(affinity))
            .collect();
        self
    }

    /// Whether images in normalised coordinates are images in the model, too.
    pub(crate) fn are_kept(&self, affinity: &Affinity) -> bool {
        self.operations.iter().all(|o| affinity.keeps(&o.map()))
    }

    /// Puts images exactly where the operations have them.
    pub(crate) fn put_exactly(&self, positions: &mut PerVertex<Vec3>) {
        let all = positions.as_slice().to_vec();
        let images = self.vertices.iter().zip(positions.iter_mut());
        for ((source, operation), p) in images.filter(|((_, operation), _)| *operation > 0) {
            *p = self.operations[*operation as usize].image(all[*source as usize]);
        }
    }
}

/// A mesh and where its elements come from.
pub(crate) struct Unfolded {
    pub mesh: HexMesh,
    pub vertices: Vec<(u32, u32)>,
    pub panels: Vec<(u32, u32)>,
    /// The number of the image of each panel of the part under each element.
    of_part: Vec<Vec<u32>>,
}

impl Unfolded {
    /// What is known of each panel of the part, for all its images.
    pub fn repeated<T: Copy>(&self, of_part: &PerFace<T>) -> PerFace<T> {
        let of = |(source, _): &(u32, u32)| of_part[FaceId::new(*source)];
        PerFace::from_vec(self.panels.iter().map(of).collect())
    }

    /// The image of each panel under each element but the identity, which comes first.
    pub fn panel_images(&self, elements: &[Matrix3<f64>]) -> Vec<PerFace<FaceId>> {
        let image = |map: &Matrix3<f64>| {
            let under = |(source, g): &(u32, u32)| {
                let product = number_of(elements, &(map * elements[*g as usize])).unwrap_or(0);
                FaceId::new(self.of_part[product][*source as usize])
            };
            PerFace::from_vec(self.panels.iter().map(under).collect())
        };
        elements[1..].iter().map(image).collect()
    }
}

/// All images of panels under the elements of a group, the panels themselves first.
///
/// # Errors
/// If that is no manifold.
pub(crate) fn unfolded(
    quotient: &Quotient,
    mesh: &HexMesh,
    elements: &[Matrix3<f64>],
) -> Result<Unfolded, TopologyError> {
    let topology = mesh.topology();
    let mut orbits = VertexOrbits::new(quotient, mesh, elements);
    let mut known: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
    let (mut faces, mut panels) = (Vec::new(), Vec::new());
    let mut of_part = vec![Vec::new(); elements.len()];
    for (g, map) in elements.iter().enumerate() {
        for f in topology.faces() {
            let ring = topology.face_vertices(f).iter();
            let mut ring: Vec<u32> = ring.map(|v| orbits.number(v.index(), g)).collect();
            let mut corners = ring.clone();
            corners.sort_unstable();
            let number = *known.entry(corners).or_insert(faces.len() as u32);
            of_part[g].push(number);
            if number as usize == faces.len() {
                if map.determinant() < 0.0 {
                    ring.reverse();
                }
                faces.push(ring);
                panels.push((f.index() as u32, g as u32));
            }
        }
    }
    let place = |(source, g): &(u32, u32)| elements[*g as usize] * orbits.place[*source as usize];
    let positions = orbits.vertices.iter().map(place).collect();
    let first = orbits.vertices.iter().map(|(source, g)| {
        let itself = orbits.numbers[*source as usize].iter().find(|n| n.0 == 0);
        (itself.map_or(0, |n| n.1), *g)
    });
    Ok(Unfolded {
        vertices: first.collect(),
        mesh: HexMesh::new(positions, &faces)?,
        panels,
        of_part,
    })
}

struct VertexOrbits<'a> {
    elements: &'a [Matrix3<f64>],
    /// The vertex of the part, and the element, that each is the image of and under.
    source: Vec<(u32, usize)>,
    /// Elements that leave each vertex where it is.
    fixing: Vec<Vec<usize>>,
    place: Vec<Vec3>,
    /// Numbers of the images of each vertex, with their elements.
    numbers: Vec<Vec<(usize, u32)>>,
    vertices: Vec<(u32, u32)>,
}

impl<'a> VertexOrbits<'a> {
    fn new(quotient: &Quotient, mesh: &HexMesh, elements: &'a [Matrix3<f64>]) -> Self {
        let count = mesh.positions.len();
        let images = &quotient.images;
        let near = PUT_THERE * mesh.diagonal();
        let source = (0..count as u32).map(|v| match images.get(&v) {
            Some(image) => (image.source, number_of(elements, &image.map).unwrap_or(0)),
            None => (v, 0),
        });
        let place = mesh.positions.as_slice().to_vec();
        let fixes = |v: usize, e: &Matrix3<f64>| (e * place[v] - place[v]).norm() < near;
        let fixing = (0..count).map(|v| {
            let all = 0..elements.len();
            match quotient.mirrored.contains_key(&(v as u32)) {
                true => all.filter(|g| fixes(v, &elements[*g])).collect(),
                false => vec![0],
            }
        });
        Self {
            elements,
            source: source.collect(),
            fixing: fixing.collect(),
            numbers: vec![Vec::new(); count],
            vertices: Vec::new(),
            place,
        }
    }

    /// The number of the product of two elements.
    fn product(&self, g: usize, h: usize) -> usize {
        number_of(self.elements, &(self.elements[g] * self.elements[h])).unwrap_or(0)
    }

    /// The number of the image of a vertex under element `g`.
    fn number(&mut self, v: usize, g: usize) -> u32 {
        let (source, first) = self.source[v];
        let element = self.product(g, first);
        // The least of the elements that do the same.
        let same = self.fixing[source as usize].iter();
        let element = same
            .map(|h| self.product(element, *h))
            .min()
            .unwrap_or(element);
        let known = &mut self.numbers[source as usize];
        if let Some((_, number)) = known.iter().find(|(e, _)| *e == element) {
            return *number;
        }
        let number = self.vertices.len() as u32;
        known.push((element, number));
        self.vertices.push((source, element as u32));
        number
    }
}
