//! Quality: what a mesh must keep to, what is wrong with it and where, and which of two meshes is
//! better.
//!
//! [`Limits`] is what is asked for. [`Judge`] looks at a mesh, or at a part of one, and says for
//! each face by how much it is outside ([`Findings`]); the sum over faces is the [`Merit`] by which
//! lattices are compared and local changes are kept, and faces that hang together are a [`Defect`].
//! [`Assessment`] puts the same figures in the words of the report: each [`Check`] is a figure, a
//! limit, the elements that exceed it, and the worst place; all of them together give the
//! [`Verdict`]. What could not be checked is told ([`Omitted`]).
//!
//! | verdict | when |
//! |---|---|
//! | pass | every check holds |
//! | outside tolerance | a figure is outside a limit: planarity, deviation, edge length, clearance, folds, topology, boundary, covered area, what a workshop can make |
//! | invalid | the mesh is no panelling: a face not simple, folded back or flipped, a vertex covered twice or of wrong degree, an edge through a face |
//!
//! Guaranteed: pure functions of their arguments. A mesh of which the judge finds nothing invalid
//! and nothing outside passes every located check of the report, and the other way round. Crossings
//! that the surface has itself are an exception: the report fails them, and the judge, whose search
//! could not mend them, does not count them.

mod advice;
mod assessment;
mod check;
mod defect;
mod findings;
mod judge;
mod limits;
mod merit;
mod panel_checks;
mod told;

pub use advice::contradiction;
pub use assessment::{Assessment, Omitted, Reason, References, Verdict};
pub use check::{Check, ElementKind, Reading, Scale};
pub use defect::{Defect, defects};
pub use findings::Findings;
pub use judge::{Judge, Judgement, Scope, Shapes, WantedSize, Yardstick};
pub use limits::{Limits, USUAL_DEVIATION};
pub use merit::Merit;
pub use told::told_place;
