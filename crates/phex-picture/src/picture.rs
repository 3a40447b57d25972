//! Pictures as files.

use crate::{PictureOptions, draw};
use phex_mesh::HexMesh;
use phex_mesh::io::{WriteError, atomic_write};
use std::path::Path;

/// An opaque picture: rows from the top, four bytes (red, green, blue, alpha; sRGB) a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// The pixels.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// The picture as a PNG file.
    ///
    /// # Panics
    /// If it has not as many pixels as its sides say, or none; those that are drawn here do.
    pub fn to_png(&self) -> Vec<u8> {
        let pixels = self.rgba.chunks_exact(4);
        let rgb: Vec<u8> = pixels.flat_map(|p| [p[0], p[1], p[2]]).collect();
        let encoded = self.encoded(&rgb);
        encoded.expect("memory takes what is written, and a drawn picture has all its pixels")
    }

    fn encoded(&self, rgb: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
        let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width), side(self.height));
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.write_header()?.write_image_data(rgb)?;
        Ok(bytes)
    }
}

/// Draws a mesh as it is drawn by default and writes the picture as a PNG file, whole or not at
/// all.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let surface = phex::Surface::read("roof.obj")?;
/// let made = phex::Mesher::new().panels(600).run(&surface)?;
/// phex_picture::write_png(made.mesh(), "roof.png")?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// If the file can't be written.
pub fn write_png(mesh: &HexMesh, path: impl AsRef<Path>) -> Result<(), WriteError> {
    let picture = draw(mesh, &PictureOptions::default()).to_png();
    atomic_write(path.as_ref(), |out| out.write_all(&picture))
}
