//! Offsets of meshes that the pipeline makes.

use phex::parallel_mesh::face_offset::face_normals;
use phex::parallel_mesh::{
    PanelSolid, face_gauss_image, face_offset, layer, panel_solids, safe_distances,
};
use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::measure::diagonal;
use phex_mesh::shapes::{Shape, TriangulateOptions};
use phex_mesh::{FlatFace, HexMesh, PerFace, ValidateOptions};
