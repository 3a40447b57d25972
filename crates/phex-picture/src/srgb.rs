//! Colours as bytes, and as the light that they stand for.

use crate::maps::Rgb;
use phex_mesh::Vec3;

/// Linear light of an sRGB colour.
pub fn linear(srgb: [f64; 3]) -> Vec3 {
    Vec3::from(srgb).map(|c| {
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}

/// Linear light of an sRGB colour in bytes.
pub fn linear_bytes(srgb: Rgb) -> Vec3 {
    linear(srgb.map(|c| f64::from(c) / 255.0))
}

/// sRGB byte of linear light; `round_up` (0 to 1, 0.5 for the nearest byte) tells from which
/// fraction on it is rounded up.
pub fn srgb_byte(light: f64, round_up: f64) -> u8 {
    let c = light.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    };
    (s * 255.0 + 1.0 - round_up).floor().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_the_way_to_bytes() {
        for byte in [0u8, 1, 10, 128, 254, 255] {
            assert_eq!(srgb_byte(linear([f64::from(byte) / 255.0; 3]).x, 0.5), byte);
        }
    }
}
