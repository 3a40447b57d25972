//! The HTML report: everything that is to be known about a panelling, in one file that opens from a
//! disk without a network.
//!
//! [`page`] makes the file's text. It holds tables (checks, figures, settings, inputs, the command
//! that repeats the run), a picture of every colour map, and, where the interactive viewer was
//! built (by the build itself where npm is installed, or `cargo xtask viewer`) and the browser can
//! draw in three dimensions, the model itself: maps, layers, panels that answer a click.
//!
//! Guaranteed: no address outside of the file is ever loaded (a content security policy in the file
//! forbids it); texts from the user are escaped; the same input gives the same bytes.

mod arrays;
mod bundle;
mod contact;
mod curves;
mod escape;
mod layers;
mod mesh_data;
mod page;
mod pictures;
mod tables;
mod thin;
mod viewer_data;

pub use arrays::{PackedArray, numbers, points, with_arrays};
pub use bundle::{Viewer, studio_script};
pub use contact::{SheetKind, contact_file, contact_page};
pub use curves::conjugate_curves;
pub use escape::escaped;
pub use layers::PackedSurface;
pub use mesh_data::MeshData;
pub use page::{VIEW_STYLE, page, viewer_data};
pub use viewer_data::ViewerData;

use phex::report::RunReport;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface, Vec3};

/// Everything that a report shows; lengths in model units.
#[derive(Clone, Copy)]
pub struct Report<'a> {
    /// Name of the report, usually that of the mesh's file.
    pub title: &'a str,
    /// The command that makes the mesh again.
    pub command: &'a str,
    /// Settings, figures, checks.
    pub run: &'a RunReport,
    /// The panels.
    pub mesh: &'a HexMesh,
    /// Names of the panels, as in the workshop files; without them they have their numbers.
    pub names: Option<&'a [String]>,
    /// The surface that they stand for.
    pub surface: Option<&'a TriangleSurface>,
    /// The mesh before the last step, for comparison.
    pub start: Option<&'a PolygonSoup>,
    /// Curves on the surface, by family, or why there are none.
    pub curves: Result<&'a [CurveFamily], &'a str>,
}

impl Report<'_> {
    /// Name of a panel.
    fn panel(&self, face: usize) -> String {
        self.names
            .map_or_else(|| face.to_string(), |names| names[face].clone())
    }
}

/// Curves that belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveFamily {
    /// Name in the list of layers.
    pub name: String,
    /// The points of each curve; a closed one ends with its first point.
    pub curves: Vec<Vec<Vec3>>,
}
