//! A picture so small that a page holds thousands.

use phex_job::JobError;
use phex_mesh::HexMesh;
use phex_picture::{PictureOptions, draw};

/// Its sides, pixels.
const SIDES: [usize; 2] = [104, 78];
/// Levels of each colour that are kept: a palette of few colours packs well.
const LEVELS: u16 = 6;

/// A thumbnail as a PNG file with a palette.
///
/// # Errors
/// If it can't be encoded, which is a bug.
pub(crate) fn thumbnail(mesh: &HexMesh) -> Result<Vec<u8>, JobError> {
    let [width, height] = SIDES;
    let options = PictureOptions {
        width,
        height,
        supersampling: 3,
        edges: true,
        legend: false,
        ground: false,
        ..PictureOptions::default()
    };
    let picture = draw(mesh, &options);
    let level = |c: u8| (u16::from(c) * (LEVELS - 1) + 127) / 255;
    let index = |p: &[u8]| {
        let [r, g, b] = [p[0], p[1], p[2]].map(level);
        u8::try_from((r * LEVELS + g) * LEVELS + b).unwrap_or(u8::MAX)
    };
    let pixels: Vec<u8> = picture.rgba.chunks_exact(4).map(index).collect();
    encoded(&pixels, picture.width, picture.height)
        .map_err(|e| JobError::Internal(format!("the thumbnail: {e}")))
}

fn encoded(pixels: &[u8], width: usize, height: usize) -> Result<Vec<u8>, png::EncodingError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let value = |level: u16| u8::try_from(level * 255 / (LEVELS - 1)).unwrap_or(u8::MAX);
    let colour = |k: u16| [k / LEVELS / LEVELS, k / LEVELS % LEVELS, k % LEVELS].map(value);
    let palette: Vec<u8> = (0..LEVELS.pow(3)).flat_map(colour).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(width), side(height));
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(bytes)
}
