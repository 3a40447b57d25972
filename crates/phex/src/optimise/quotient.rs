//! The part of a symmetric mesh that generates it, as the optimiser takes it.

use super::holds::{Hold, Holds};
use super::panels::Image;
use phex_mesh::Vec3;
use std::collections::BTreeMap;

/// The vertices of the generating part of a symmetric mesh that are no variables of their own.
#[derive(Clone, Default)]
pub(crate) struct Quotient {
    /// Images of other vertices.
    pub images: BTreeMap<u32, Image>,
    /// Vertices in mirror planes through the origin, with the unit normals of these.
    pub mirrored: BTreeMap<u32, Vec3>,
}

impl Quotient {
    /// Whether a vertex is free as far as symmetry is concerned.
    pub fn is_free(&self, v: u32) -> bool {
        !self.images.contains_key(&v) && !self.mirrored.contains_key(&v)
    }

    /// What holds these vertices.
    pub(super) fn holds(&self) -> Holds {
        let in_plane = |normal: &Vec3| Hold::InPlane {
            point: Vec3::zeros(),
            normal: *normal,
        };
        Holds {
            held: (self.mirrored.iter())
                .map(|(v, n)| (*v, in_plane(n)))
                .collect(),
            images: self.images.clone(),
            ..Holds::default()
        }
    }
}
