//! Meshes as files hold them.

use crate::units::Unit;
use phex_mesh::PolygonSoup;
use phex_mesh::io::Format;
use std::borrow::Cow;
use std::path::Path;

/// A mesh with coordinates in a unit as a file of this name is to hold it: in metres where the
/// format demands them.
pub fn in_file<'a>(path: &Path, soup: &'a PolygonSoup, unit: Unit) -> Cow<'a, PolygonSoup> {
    if !Format::from_path(path).is_ok_and(Format::is_in_metres) {
        return Cow::Borrowed(soup);
    }
    Cow::Owned(PolygonSoup {
        positions: soup.positions.iter().map(|p| p * unit.metres()).collect(),
        faces: soup.faces.clone(),
    })
}
