//! Dense maps from element ids to values.

use crate::ids::{EdgeId, ElementId, FaceId, HalfEdgeId, VertexId};
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// One value per element, addressed by the element's typed id.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PerElement<I, T> {
    values: Vec<T>,
    #[serde(skip)]
    id: PhantomData<I>,
}

/// One value per vertex.
pub type PerVertex<T> = PerElement<VertexId, T>;
/// One value per half-edge.
pub type PerHalfEdge<T> = PerElement<HalfEdgeId, T>;
/// One value per edge.
pub type PerEdge<T> = PerElement<EdgeId, T>;
/// One value per face.
pub type PerFace<T> = PerElement<FaceId, T>;

impl<I: ElementId, T> PerElement<I, T> {
    /// Wraps values that are already in the order of the ids.
    pub fn from_vec(values: Vec<T>) -> Self {
        Self {
            values,
            id: PhantomData,
        }
    }

    /// `count` copies of `value`.
    pub fn filled(count: usize, value: T) -> Self
    where
        T: Clone,
    {
        Self::from_vec(vec![value; count])
    }

    /// The value of `make(id)` for each of `count` ids.
    pub fn from_fn(count: usize, mut make: impl FnMut(I) -> T) -> Self {
        Self::from_vec((0..count).map(|i| make(I::from_index(i))).collect())
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The ids, in order.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = I> + use<I, T> {
        (0..self.values.len()).map(I::from_index)
    }

    /// The values, in the order of the ids.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.values.iter()
    }

    /// The values, mutable, in the order of the ids.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.values.iter_mut()
    }

    /// Pairs of id and value.
    pub fn enumerate(&self) -> impl ExactSizeIterator<Item = (I, &T)> {
        self.values
            .iter()
            .enumerate()
            .map(|(i, v)| (I::from_index(i), v))
    }

    /// The values as a slice.
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }

    /// The values as a mutable slice.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The values.
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// A map with `f` applied to each value.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> PerElement<I, U> {
        PerElement::from_vec(self.values.iter().map(f).collect())
    }
}

impl<I: ElementId, T: Copy> PerElement<I, T> {
    /// The values of some elements, in the order in which they are named.
    pub fn picked<J: ElementId>(&self, ids: &[I]) -> PerElement<J, T> {
        PerElement::from_vec(ids.iter().map(|id| self[*id]).collect())
    }
}

impl<I: ElementId, T> Index<I> for PerElement<I, T> {
    type Output = T;
    fn index(&self, id: I) -> &T {
        &self.values[id.index()]
    }
}

impl<I: ElementId, T> IndexMut<I> for PerElement<I, T> {
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.values[id.index()]
    }
}

impl<'a, I, T> IntoIterator for &'a PerElement<I, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.values.iter()
    }
}
