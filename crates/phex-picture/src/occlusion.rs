//! Ambient occlusion: panels that stand close to one another darken one another.

use super::camera::Camera;
use super::light::Shading;
use super::raster::LinearImage;
use phex_mesh::{Vec2, Vec3};
use rayon::prelude::*;

/// Samples of the ambient occlusion, per pixel.
const OCCLUSION_SAMPLES: usize = 40;
/// Farthest distance at which panels darken one another, in radii of the model.
const OCCLUSION_REACH: f64 = 0.3;
/// Share of light that full occlusion takes away.
const OCCLUSION_DEPTH: f64 = 1.1;

/// Share of light that each pixel keeps where panels stand close to one another (1 where nothing is
/// near).
pub fn occlusion(shading: &Shading, sheet: &LinearImage, camera: &Camera) -> Vec<f32> {
    let offsets = spiral(OCCLUSION_REACH * camera.focal / camera.eye().norm());
    let row = |y: usize| {
        let offsets = &offsets;
        (0..sheet.width).map(move |x| openness(shading, sheet, camera, x, y, offsets))
    };
    (0..sheet.height)
        .into_par_iter()
        .flat_map_iter(row)
        .collect()
}

fn openness(
    shading: &Shading,
    sheet: &LinearImage,
    camera: &Camera,
    x: usize,
    y: usize,
    offsets: &[Vec2],
) -> f32 {
    let Some((face, nearness)) = sheet.panel_at(x as f64 + 0.5, y as f64 + 0.5) else {
        return 1.0;
    };
    let here = camera.unsee(x as f64 + 0.5, y as f64 + 0.5, nearness);
    let normal = shading.normals[face];
    let hidden: f64 = offsets
        .iter()
        .filter_map(|o| {
            let (u, v) = (x as f64 + 0.5 + o.x, y as f64 + 0.5 + o.y);
            let (_, nearness) = sheet.panel_at(u, v)?;
            Some(blocked(camera.unsee(u, v, nearness) - here, normal))
        })
        .sum();
    (1.0 - OCCLUSION_DEPTH * hidden / offsets.len() as f64).max(0.25) as f32
}

/// How much a point at `offset` blocks the light of a surface element: its height over the
/// element's plane, less with distance.
fn blocked(offset: Vec3, normal: Vec3) -> f64 {
    let distance = offset.norm().max(1e-9);
    let rise = (normal.dot(&offset) / distance - 0.1).max(0.0);
    rise * (1.0 - (distance / OCCLUSION_REACH).powi(2)).max(0.0)
}

/// Points that fill a disc evenly.
fn spiral(radius: f64) -> Vec<Vec2> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |k: usize| {
        let r = radius * ((k as f64 + 0.5) / OCCLUSION_SAMPLES as f64).sqrt();
        let (sin, cos) = (golden * k as f64).sin_cos();
        Vec2::new(r * cos, r * sin)
    };
    (0..OCCLUSION_SAMPLES).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_rises_above_the_plane_blocks() {
        assert_eq!(blocked(Vec3::new(0.1, 0.0, -0.05), Vec3::z()), 0.0);
        assert!(
            blocked(Vec3::new(0.1, 0.0, 0.1), Vec3::z())
                > blocked(Vec3::new(0.1, 0.0, 0.03), Vec3::z())
        );
        assert_eq!(
            blocked(Vec3::new(0.0, 0.0, 2.0 * OCCLUSION_REACH), Vec3::z()),
            0.0
        );
    }
}
