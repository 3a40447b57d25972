//! What faces of other programs need before they are a surface: faces that are there twice, and
//! faces without area, are taken out, and parts that lie side by side are sewn together.
//!
//! Coordinates never change. A face gets a vertex more, another vertex at the same place, or goes.

mod degenerate;
mod repeats;
mod seams;

use crate::disjoint_sets::DisjointSets;
use crate::{PolygonSoup, polygon};

pub(crate) use degenerate::{least_height, without_degenerate_faces};
pub(crate) use repeats::without_repeated_faces;
pub(crate) use seams::sewn;

/// Faces that were mended.
#[derive(Clone)]
pub(crate) struct Mended {
    /// The mended faces, on the vertices of the input.
    pub(crate) soup: PolygonSoup,
    /// Number in the input of each face.
    pub(crate) original_faces: Vec<u32>,
    /// Faces that were there twice, and taken out.
    pub(crate) repeated_faces: usize,
    /// Faces without area that were taken out.
    pub(crate) dropped_faces: usize,
    /// Edges of boundaries that were joined to others.
    pub(crate) sewn_edges: usize,
    /// Largest distance over which they were joined.
    pub(crate) widest_gap: f64,
}

impl Mended {
    fn unchanged(soup: &PolygonSoup) -> Self {
        Self {
            soup: soup.clone(),
            original_faces: (0..soup.faces.len() as u32).collect(),
            repeated_faces: 0,
            dropped_faces: 0,
            sewn_edges: 0,
            widest_gap: 0.0,
        }
    }

    /// The same, with what was done to the faces before.
    pub(crate) fn after(mut self, before: &Self) -> Self {
        let original = |f: &mut u32| *f = before.original_faces[*f as usize];
        self.original_faces.iter_mut().for_each(original);
        self.repeated_faces += before.repeated_faces;
        self.dropped_faces += before.dropped_faces;
        self
    }

    /// Gives the vertices of a set one number, and takes out what is repeated then: corners that
    /// follow one another, and faces with fewer than three corners.
    fn join_vertices(&mut self, sets: &mut DisjointSets) {
        for face in &mut self.soup.faces {
            face.iter_mut().for_each(|v| *v = sets.root(*v));
            face.dedup();
            if face.len() > 1 && face.first() == face.last() {
                face.pop();
            }
        }
        let keep: Vec<bool> = self.soup.faces.iter().map(|f| f.len() > 2).collect();
        self.keep_faces(&keep);
    }

    fn keep_faces(&mut self, keep: &[bool]) {
        let faces = std::mem::take(&mut self.soup.faces).into_iter();
        let originals = std::mem::take(&mut self.original_faces);
        let kept = faces.zip(originals).zip(keep).filter(|(_, keep)| **keep);
        (self.soup.faces, self.original_faces) = kept.map(|(face, _)| face).unzip();
        self.dropped_faces += keep.len() - self.soup.faces.len();
    }
}

/// A side of a face: its ends, lower vertex first, the face, and the corner where it starts.
#[derive(Clone, Copy)]
struct FaceSide {
    ends: [u32; 2],
    face: u32,
    corner: u32,
}

/// The sides of all faces, those with the same ends one after another.
fn sides(faces: &[Vec<u32>]) -> Vec<FaceSide> {
    let mut sides = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        let side = |(i, [a, b]): (usize, [u32; 2])| FaceSide {
            ends: [a.min(b), a.max(b)],
            face: f as u32,
            corner: i as u32,
        };
        sides.extend(polygon::sides(face).enumerate().map(side));
    }
    sides.sort_unstable_by_key(|s| (s.ends, s.face, s.corner));
    sides
}
