//! Why a mesh file can't be read or written.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a mesh can't be read: the file, the place in it, and the cause.
#[derive(Debug, Error)]
#[error("{}{place}{cause}", prefix(.path))]
pub struct ReadError {
    /// The file, where one was read.
    pub path: Option<PathBuf>,
    /// The line or element.
    pub place: FilePlace,
    /// What is wrong there.
    pub cause: ReadCause,
}

/// A place in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// The file as a whole.
    File,
    /// A line, counted from 1.
    Line(usize),
    /// A vertex, counted from 0.
    Vertex(usize),
    /// A face, counted from 0.
    Face(usize),
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Vertex(vertex) => write!(f, "vertex {vertex}: "),
            Self::Face(face) => write!(f, "face {face}: "),
        }
    }
}

/// What is wrong with a mesh file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadCause {
    /// The operating system refuses.
    #[error("can't be read: {0}")]
    Io(#[from] io::Error),
    /// The extension stands for no format.
    #[error("{}{}", .0, way_out(&.0.extension))]
    UnknownExtension(UnknownExtension),
    /// Nothing but white space.
    #[error("the file is empty")]
    Empty,
    /// The file does not start as its format must.
    #[error("this is no {format} file: it starts with `{found}`")]
    WrongStart {
        /// Name of the format.
        format: &'static str,
        /// How the file starts.
        found: String,
    },
    /// A variant of the format that is not read.
    #[error("{0} is not supported")]
    Unsupported(String),
    /// A format that is written, but not read.
    #[error(
        "`.{extension}` files are written, not read (read are .obj, .ply, .stl and .off): export the surface in one of \
         these from the program that holds it"
    )]
    WrittenOnly {
        /// The format's extension.
        extension: &'static str,
    },
    /// A header line that can't be understood.
    #[error("{0}")]
    Malformed(String),
    /// There is no vertex.
    #[error("the file holds no vertices")]
    NoVertices,
    /// There is no face.
    #[error(
        "the file holds no faces: make a surface of a point cloud first (Poisson reconstruction, in MeshLab or \
         CloudCompare), and mesh curves and NURBS in the program that made them"
    )]
    NoFaces,
    /// More vertices than vertex numbers can address.
    #[error("the file holds more than 4294967294 vertices")]
    TooManyVertices,
    /// The file ends too early.
    #[error("{announced} {what} are announced, but the file holds at most {found}")]
    Truncated {
        /// The kind of element.
        what: String,
        /// How many the header announces.
        announced: u64,
        /// How many there are, or are room for in the bytes that remain.
        found: u64,
    },
    /// There are more elements than the header announces: which of both is wrong can't be told.
    #[error("{announced} {what} are announced, but the file holds {found}: export it again")]
    Surplus {
        /// The kind of element.
        what: String,
        /// How many the header announces.
        announced: u64,
        /// How many there are.
        found: u64,
    },
    /// A number can't be understood.
    #[error("`{token}` is not a number")]
    NotANumber {
        /// What stands there.
        token: String,
    },
    /// A coordinate is not finite, or too large for 64 bits.
    #[error("the coordinate `{token}` is not finite")]
    NonFinite {
        /// What stands there.
        token: String,
    },
    /// A coordinate is larger than can be computed with.
    #[error("the coordinate {coordinate:e} is larger than 1e50, which is not computed with")]
    TooLarge {
        /// Its absolute value.
        coordinate: f64,
    },
    /// A vertex with fewer than three coordinates.
    #[error("a vertex has {found} coordinates, 3 are needed")]
    TooFewCoordinates {
        /// Their number.
        found: usize,
    },
    /// A face with fewer than three corners.
    #[error("a face has {corners} corners, at least 3 are needed")]
    TooFewCorners {
        /// Their number.
        corners: usize,
    },
    /// Vertex number 0 in a format that counts from 1.
    #[error("a face names vertex 0, but OBJ numbers vertices from 1")]
    IndexZero,
    /// A vertex number that does not exist.
    #[error(
        "a face names vertex {index}, but there are {vertices} vertices (numbered from {first})"
    )]
    IndexOutOfRange {
        /// The number as it stands in the file.
        index: String,
        /// Number of vertices (for a negative number: so far).
        vertices: usize,
        /// Number of the first vertex in this format.
        first: u32,
    },
}

/// A path whose extension stands for no mesh format.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{} (supported are .obj, .ply, .stl and .off, for writing also .json, .glb, .dxf and .3mf)",
    called(extension)
)]
pub struct UnknownExtension {
    /// The extension, empty where there is none.
    pub extension: String,
}

fn called(extension: &str) -> String {
    match extension {
        "" => "unknown extension: the name has none".to_owned(),
        known => format!("unknown extension `{known}`"),
    }
}

/// What to do with a file of a kind that is not read, by its extension.
fn way_out(extension: &str) -> &'static str {
    const NURBS: &str = ": exact surfaces (NURBS) are not read. Mesh the surface in the program that made it \
        (Rhino: `Mesh`; FreeCAD: Mesh workbench) and save the mesh as OBJ";
    const POINTS: &str = ": a point cloud has no faces. Make a surface of it first (Poisson reconstruction, in \
        MeshLab or CloudCompare) and save it as PLY";
    const SCENE: &str =
        ": open the file in Blender, Rhino or MeshLab and export the surface as OBJ";
    const PACKED: &str = ": unpack the file first";
    const ANY: &str = ": export the surface as OBJ from the program that holds it";
    match extension.to_ascii_lowercase().as_str() {
        "3dm" | "step" | "stp" | "iges" | "igs" | "sat" | "x_t" | "x_b" | "brep" | "ifc" => NURBS,
        "xyz" | "pts" | "pcd" | "las" | "laz" | "e57" | "ptx" | "asc" => POINTS,
        "fbx" | "dae" | "gltf" | "blend" | "3ds" | "skp" | "dwg" | "usd" | "usdz" | "wrl"
        | "x3d" => SCENE,
        "zip" | "gz" | "7z" | "rar" | "tar" => PACKED,
        _ => ANY,
    }
}

impl ReadError {
    /// The same error with the file's name.
    pub fn in_file(self, path: &Path) -> Self {
        Self {
            path: Some(path.to_path_buf()),
            ..self
        }
    }
}

impl ReadCause {
    pub(super) fn at(self, place: FilePlace) -> ReadError {
        ReadError {
            path: None,
            place,
            cause: self,
        }
    }
}

impl From<UnknownExtension> for ReadCause {
    fn from(unknown: UnknownExtension) -> Self {
        Self::UnknownExtension(unknown)
    }
}

impl From<ReadCause> for ReadError {
    fn from(cause: ReadCause) -> Self {
        cause.at(FilePlace::File)
    }
}

/// Why a file can't be written: the file and the cause.
#[derive(Debug, Error)]
#[error("{}{cause}", prefix(.path))]
pub struct WriteError {
    /// The file, where one was to be written.
    pub path: Option<PathBuf>,
    /// What is wrong.
    pub cause: WriteCause,
}

/// What keeps a file from being written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteCause {
    /// The operating system refuses.
    #[error("can't be written: {0}")]
    Io(#[from] io::Error),
    /// The extension stands for no format.
    #[error(transparent)]
    UnknownExtension(#[from] UnknownExtension),
    /// A coordinate is not finite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NonFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A coordinate is too large for the format.
    #[error("vertex {vertex} has a coordinate that is too large for single precision")]
    TooLarge {
        /// The vertex.
        vertex: usize,
    },
    /// The model lies so far from the origin that the format's numbers would ruin it.
    #[error(
        "coordinates as large as {largest:.0} would be rounded by up to {rounding:.1e} in STL (single precision): move the model to the origin, or write OBJ or PLY"
    )]
    TooFar {
        /// The largest coordinate.
        largest: f64,
        /// The largest rounding.
        rounding: f64,
    },
    /// A face has fewer than three corners.
    #[error("face {face} has {corners} corners, at least 3 are needed")]
    TooFewCorners {
        /// The face.
        face: usize,
        /// Its corner count.
        corners: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// The face.
        face: usize,
        /// The vertex number.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A face that must be cut into triangles is not simple.
    #[error("face {face} can't be cut into triangles: it is not a simple polygon")]
    NotSimple {
        /// The face.
        face: usize,
    },
    /// More triangles than the format can count.
    #[error("STL holds at most 4294967295 triangles, there are {triangles}")]
    TooManyTriangles {
        /// Their number.
        triangles: usize,
    },
}

impl WriteError {
    /// The same error with the file's name.
    pub fn in_file(self, path: &Path) -> Self {
        Self {
            path: Some(path.to_path_buf()),
            ..self
        }
    }
}

impl From<WriteCause> for WriteError {
    fn from(cause: WriteCause) -> Self {
        Self { path: None, cause }
    }
}

fn prefix(path: &Option<PathBuf>) -> String {
    path.as_ref()
        .map_or_else(String::new, |path| format!("{}: ", path.display()))
}
