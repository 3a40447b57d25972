//! Polygon mesh files, one file per format.
//!
//! Reading returns a [`PolygonSoup`]: faces of any valence, vertex numbers checked, coordinates
//! finite, nothing else promised. Every file is input from outside: a wrong one gives a
//! [`ReadError`] that names the line or element, and no size that a file announces is believed
//! before the bytes are there.
//!
//! | format | reads | writes |
//! |---|---|---|
//! | OBJ | `v`, `f` (`v`, `v/t`, `v//n`, `v/t/n`, negative), line continuation | n-gons, 64-bit text |
//! | PLY | ascii, binary of both byte orders, any numeric type | n-gons, binary little endian, 64 bit |
//! | STL | ascii, binary; corners welded (see `stl`) | binary, ear-clipped triangles, 32 bit |
//! | OFF | `OFF` with or without normals and colours | n-gons, 64-bit text |
//! | COMPAS JSON | | n-gons with attributes, 64-bit text |
//! | glTF (`.glb`) | | ear-clipped triangles, real edges as lines, colours; 32 bit |
//! | DXF | | a closed 3D polyline a face, 64-bit text |
//! | 3MF | | ear-clipped triangles, 64-bit text |
//!
//! OBJ, PLY and OFF return every coordinate bit by bit.

mod atomic;
mod compas;
mod dxf;
mod error;
mod glb;
mod hex_mesh;
mod obj;
mod off;
mod ply;
mod stl;
mod surface;
mod text;
mod three_mf;
mod triangles;
mod weld;

pub use atomic::{atomic_write, link_target};
pub use compas::{FaceAttributes, compas_json};
pub use dxf::DxfDrawing;
pub use error::{FilePlace, ReadCause, ReadError, UnknownExtension, WriteCause, WriteError};
pub use hex_mesh::{HexMeshError, HexMeshReadError};
pub use obj::{logical_lines, obj_of_objects};
pub use stl::fits_stl;
pub use surface::SurfaceReadError;
pub use text::shown;

use crate::{OtherElements, PolygonSoup};
use std::io::Write;
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Stereolithography STL: triangles only, single precision.
    Stl,
    /// Geomview OFF.
    Off,
    /// COMPAS JSON; only written.
    Compas,
    /// Binary glTF: triangles and lines, single precision; only written.
    Glb,
    /// DXF R12: 3D polylines; only written.
    Dxf,
    /// 3MF: triangles only; only written.
    ThreeMf,
}

impl Format {
    /// The formats that are read, all of which are written too.
    pub const READ: [Self; 4] = [Self::Obj, Self::Ply, Self::Stl, Self::Off];
    /// The formats that are only written.
    pub const WRITTEN_ONLY: [Self; 4] = [Self::Compas, Self::Glb, Self::Dxf, Self::ThreeMf];

    /// Whether coordinates in it are metres.
    pub const fn is_in_metres(self) -> bool {
        matches!(self, Self::Glb | Self::ThreeMf)
    }

    /// The format's file extension, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Off => "off",
            Self::Compas => "json",
            Self::Glb => "glb",
            Self::Dxf => "dxf",
            Self::ThreeMf => "3mf",
        }
    }

    /// The format that a path's extension (in any case) stands for.
    ///
    /// # Errors
    /// If there is no extension or an unknown one.
    pub fn from_path(path: &Path) -> Result<Self, UnknownExtension> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Self::READ
            .into_iter()
            .chain(Self::WRITTEN_ONLY)
            .find(|format| format.extension().eq_ignore_ascii_case(&extension))
            .ok_or_else(|| UnknownExtension {
                extension: extension.into_owned(),
            })
    }
}

/// What the bytes of a file hold beside faces; OBJ alone has such elements that are looked at.
pub fn other_elements(bytes: &[u8], format: Format) -> OtherElements {
    match format {
        Format::Obj => obj::other_elements(bytes),
        _ => OtherElements::default(),
    }
}

/// Reads a mesh file; the extension decides the format.
///
/// # Errors
/// If the extension is unknown, the file can't be read, or it holds no well-formed mesh with at
/// least one face.
pub fn read_soup(path: &Path) -> Result<PolygonSoup, ReadError> {
    let read = || {
        let format = Format::from_path(path).map_err(ReadCause::from)?;
        let bytes = std::fs::read(path).map_err(ReadCause::from)?;
        parse_soup(&bytes, format)
    };
    read().map_err(|error: ReadError| error.in_file(path))
}

/// Reads a mesh from the bytes of a file.
///
/// ```
/// use phex_mesh::TriangleSurface;
/// use phex_mesh::io::{Format, parse_soup};
///
/// let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
/// let soup = parse_soup(square, Format::Obj)?;
/// let parts = TriangleSurface::from_soup(&soup)?;
/// assert_eq!(parts.notes.cut_polygons, 1);
/// assert_eq!(parts.components[0].surface.area(), 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the bytes hold no well-formed mesh with at least one face.
pub fn parse_soup(bytes: &[u8], format: Format) -> Result<PolygonSoup, ReadError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ReadCause::Empty.into());
    }
    let soup = match format {
        Format::Obj => obj::parse(bytes),
        Format::Ply => ply::parse(bytes),
        Format::Stl => stl::parse(bytes),
        Format::Off => off::parse(bytes),
        Format::Compas | Format::Glb | Format::Dxf | Format::ThreeMf => {
            Err(ReadCause::WrittenOnly {
                extension: format.extension(),
            }
            .into())
        }
    }?;
    if soup.positions.is_empty() {
        return Err(ReadCause::NoVertices.into());
    }
    if soup.faces.is_empty() {
        return Err(ReadCause::NoFaces.into());
    }
    Ok(soup)
}

/// Writes a mesh file; the extension decides the format. The file appears whole or not at all (see
/// [`atomic_write`]), and missing folders are made.
///
/// # Errors
/// As [`write_soup_to`], or if the extension is unknown.
pub fn write_soup(path: &Path, soup: &PolygonSoup) -> Result<(), WriteError> {
    let write = || {
        let format = Format::from_path(path).map_err(WriteCause::from)?;
        let bytes = encode(soup, format)?;
        atomic_write(path, |out| out.write_all(&bytes))
    };
    write().map_err(|error| error.in_file(path))
}

/// Writes a mesh in a given format.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex_mesh::io::{Format, write_soup_to};
///
/// let mut file = Vec::new();
/// write_soup_to(&mut file, &cube.to_soup(), Format::Off)?;
/// assert!(file.starts_with(b"OFF"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a coordinate is not finite (for STL and glTF: not finite in single precision), a face has
/// fewer than three corners or names a missing vertex, triangles are asked for of a face that is
/// not simple, or `out` fails. Nothing is written but in the last case.
pub fn write_soup_to(
    out: &mut impl Write,
    soup: &PolygonSoup,
    format: Format,
) -> Result<(), WriteError> {
    let bytes = encode(soup, format)?;
    out.write_all(&bytes)
        .map_err(|error| WriteCause::from(error).into())
}

fn encode(soup: &PolygonSoup, format: Format) -> Result<Vec<u8>, WriteCause> {
    check_writable(soup)?;
    match format {
        Format::Obj => Ok(obj::encode(soup)),
        Format::Ply => Ok(ply::encode(soup)),
        Format::Stl => stl::encode(soup),
        Format::Off => Ok(off::encode(soup)),
        Format::Compas => Ok(compas::encode(soup)),
        Format::Glb => glb::encode(soup),
        Format::Dxf => Ok(dxf::encode(soup)),
        Format::ThreeMf => three_mf::encode(soup),
    }
}

fn check_writable(soup: &PolygonSoup) -> Result<(), WriteCause> {
    let finite = |p: &crate::Vec3| p.iter().all(|x| x.is_finite());
    if let Some(vertex) = soup.positions.iter().position(|p| !finite(p)) {
        return Err(WriteCause::NonFinite { vertex });
    }
    let vertices = soup.positions.len();
    for (face, corners) in soup.faces.iter().enumerate() {
        if corners.len() < 3 {
            let corners = corners.len();
            return Err(WriteCause::TooFewCorners { face, corners });
        }
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(WriteCause::IndexOutOfRange {
                face,
                vertex,
                vertices,
            });
        }
    }
    Ok(())
}
