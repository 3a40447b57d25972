//! Pictures inside of the page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use phex_mesh::HexMesh;
use phex_picture::maps::ColourMap;
use phex_picture::{Picture, PictureOptions, draw_map};

/// An opaque picture as PNG.
///
/// # Errors
/// If a side is 0 or longer than a PNG file can say.
pub fn encode_png(picture: &Picture) -> Result<Vec<u8>, png::EncodingError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(picture.width), side(picture.height));
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::Adaptive);
    let pixels = picture.rgba.chunks_exact(4);
    let rgb: Vec<u8> = pixels.flat_map(|p| [p[0], p[1], p[2]]).collect();
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(bytes)
}

/// A picture of a map as an address that holds the picture itself; `None` if it can't be encoded.
pub fn data_address(mesh: &HexMesh, map: &ColourMap) -> Option<String> {
    let options = PictureOptions {
        width: 800,
        height: 560,
        supersampling: 2,
        ground: false,
        ..Default::default()
    };
    let bytes = encode_png(&draw_map(mesh, map, &options)).ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}
