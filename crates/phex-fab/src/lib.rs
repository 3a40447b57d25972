//! Workshop files of a planar hexagonal mesh: from a [`ValidHexMesh`](phex_mesh::ValidHexMesh) to a
//! folder that panels are cut, marked, sorted and put together from.
//!
//! | module | what it makes |
//! |---|---|
//! | [`options`] | what is asked for |
//! | [`ids`], [`rows`](mod@rows) | names of panels, edges and nodes |
//! | [`plate`] | thick panels, and each of them flat, with its mitre angles |
//! | [`labels`] | where text goes on a panel |
//! | [`groups`] | congruent panels, equal lengths and angles |
//! | [`nest`] | panels on sheets |
//! | [`layer`] | lines of drawings, and their layers |
//! | [`drawing`] | sheets as DXF and SVG |
//! | [`schedule`] | tables as CSV and XLSX |
//! | [`folder`] | all files, by name |
//! | [`error`] | why not |
//!
//! Units: lengths of a [`ValidHexMesh`](phex_mesh::ValidHexMesh), its thickness and gap are model
//! units; everything flat, every table and every drawing is in millimetres and degrees, as
//! workshops work. Angles of the library are radians.
//!
//! *Guaranteed*: flat panels are the faces of the solids up to rounding; every panel is on exactly
//! one sheet, and keeps its distance from the others and from the border (checked with every run,
//! on both faces); equal inputs give equal bytes.

pub mod drawing;
pub mod error;
mod fabricate;
pub mod folder;
pub mod groups;
pub mod ids;
pub mod labels;
pub mod layer;
pub mod nest;
pub mod options;
mod outline;
pub mod plate;
pub mod rows;
pub mod schedule;
#[cfg(test)]
mod test_meshes;

pub use error::FabError;
pub use fabricate::{Fabrication, SheetUse, fabricate, valid_mesh};
pub use ids::PanelIds;
pub use options::{FabOptions, Rotations, Side};
