//! Pictures inside of the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use phex_mesh::HexMesh;
use phex_picture::maps::ColourMap;
use phex_picture::{Picture, PictureOptions, draw_map};

/// A picture of a map as an address that holds the picture itself.
pub fn data_address(mesh: &HexMesh, map: &ColourMap) -> String {
    let options = PictureOptions {
        width: 800,
        height: 560,
        supersampling: 2,
        ground: false,
        ..Default::default()
    };
    address(&draw_map(mesh, map, &options))
}

/// A picture as an address that holds it.
pub fn address(picture: &Picture) -> String {
    format!(
        "data:image/png;base64,{}",
        STANDARD.encode(picture.to_png())
    )
}
