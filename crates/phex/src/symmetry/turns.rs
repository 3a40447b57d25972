//! Panels at mirror planes and axes made more regular: edges turn together with all their images.
//!
//! The panels of a domain are made regular by themselves, up to its mirror planes. What is
//! irregular there shows once they are whole, and an edge beside a plane can turn only if its
//! images do.

use super::group::{Group, bits_of, in_walls};
use super::quotient::{WholePanels, quotient_of};
use super::unfold::{Unfolded, unfolded};
use crate::layout::moves::flips::turn_with_images;
use crate::layout::{Layout, VertexKind};
use nalgebra::Matrix3;
use phex_mesh::{FaceId, HexMesh, PerFace, PerVertex, Vec3, VertexId, numbered};

/// Distance from a mirror plane, mean edges, within which a vertex lies in it.
const IN_PLANE: f64 = 1e-6;

impl WholePanels {
    /// The same with edges turned while that makes panels more regular.
    pub fn calmed(self, group: Group) -> Self {
        self.turned(group).unwrap_or(self)
    }

    /// The same with edges turned; `None` where none can.
    fn turned(&self, group: Group) -> Option<Self> {
        let elements = group.elements();
        let all = unfolded(&self.quotient, &self.layout.mesh, &elements).ok()?;
        let images = all.panel_images(&elements);
        let turned = turn_with_images(&self.with_images(all, &elements), &images)?;
        self.restored(&turned, group)
    }

    /// The layout of the panels and all their images.
    fn with_images(&self, all: Unfolded, elements: &[Matrix3<f64>]) -> Layout {
        let part = &self.layout;
        let mut kind = vec![VertexKind::Interior; all.vertices.len()];
        for f in part.mesh.topology().faces() {
            let [own, image] = [&part.mesh, &all.mesh].map(|m| m.topology().face_vertices(f));
            for (v, w) in own.iter().zip(image) {
                kind[w.index()] = part.vertex_kind[*v];
            }
        }
        let kinds = all.vertices.iter().map(|(first, _)| kind[*first as usize]);
        let mapped = |of: &PerFace<Vec3>| {
            let image = |(f, g): &(u32, u32)| elements[*g as usize] * of[FaceId::new(*f)];
            PerFace::from_vec(all.panels.iter().map(image).collect())
        };
        Layout {
            vertex_kind: PerVertex::from_vec(kinds.collect()),
            face_point: mapped(&part.face_point),
            face_normal: mapped(&part.face_normal),
            face_length: all.repeated(&part.face_length),
            face_wish: all.repeated(&part.face_wish),
            face_seed: all.repeated(&part.face_seed),
            mesh: all.mesh,
        }
    }

    /// The panels of the part among those of all images, which come first.
    fn restored(&self, all: &Layout, group: Group) -> Option<Self> {
        let topology = all.mesh.topology();
        let part = self.layout.mesh.topology().faces();
        let (old, faces) = numbered(part.map(|f| topology.face_vertices(f).iter().copied()));
        let (walls, near) = (group.walls(), IN_PLANE * self.layout.mesh.mean_edge());
        let place = |v: &VertexId| {
            let p = all.mesh.position(*v);
            in_walls(&walls, bits_of(&walls, |n| n.dot(&p).abs() < near), p)
        };
        let mesh = HexMesh::new(old.iter().map(place).collect(), &faces).ok()?;
        let kinds = old.iter().map(|v| all.vertex_kind[*v]);
        Some(Self {
            quotient: quotient_of(&mesh, group).ok()?,
            layout: Layout {
                vertex_kind: PerVertex::from_vec(kinds.collect()),
                mesh,
                ..self.layout.clone()
            },
        })
    }
}
