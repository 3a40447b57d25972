//! Light: panel colours, background with contact shadow.

use super::camera::{Camera, panel_plane};
use super::paint::Paint;
use super::scan::scan_polygon;
use crate::srgb::linear;
use phex_mesh::{FaceId, HexMesh, PerFace, Vec2, Vec3};

/// Cells per side of the shadow map.
const SHADOW_CELLS: usize = 256;
/// Half the side of the shadow map, in radii of the model.
const SHADOW_REACH: f64 = 1.8;
/// Radius of one box blur of the shadow, in cells.
const SHADOW_BLUR: usize = 9;
/// Share of the ground's light that a deep shadow takes away.
const SHADOW_DEPTH: f64 = 0.42;
/// Colours (linear light) of everything that is drawn.
#[derive(Clone, Debug)]
pub struct Shading {
    /// Light that each panel sends to the eye.
    pub panels: PerFace<Vec3>,
    /// Unit normal of each panel, towards the eye.
    pub normals: PerFace<Vec3>,
    /// `None` is plain white.
    background: Option<Background>,
}

impl Shading {
    /// Lights the panels of a mesh.
    pub fn new(mesh: &HexMesh, camera: &Camera, paint: &Paint, ground: bool) -> Self {
        let faces = mesh.topology().n_faces();
        let planes: PerFace<_> = PerFace::from_fn(faces, |f| panel_plane(mesh, camera, f));
        let towards_eye = |f: FaceId| {
            let plane = &planes[f];
            let outside = plane.normal.dot(&(camera.eye() - plane.centre)) >= 0.0;
            if outside { plane.normal } else { -plane.normal }
        };
        let normals = PerFace::from_fn(faces, towards_eye);
        let shade = |f: FaceId| 1.0 + paint.relief * (diffuse(normals[f], camera) - 1.0);
        let lit = |f: FaceId| paint.panels[f] * shade(f);
        Self {
            panels: PerFace::from_fn(faces, lit),
            background: ground.then(|| Background::new(mesh, camera)),
            normals,
        }
    }

    /// Light of the background at a pixel of a picture `height` pixels high.
    pub fn background(&self, x: f64, y: f64, height: usize) -> Vec3 {
        let background = self.background.as_ref();
        background.map_or(Vec3::repeat(1.0), |b| b.light(x, y, height))
    }
}

/// Key light from the upper left behind the eye, weak light from the right, sky from above.
fn diffuse(normal: Vec3, camera: &Camera) -> f64 {
    let seen = camera.in_view(normal);
    let key = seen.dot(&Vec3::new(-0.45, 0.60, 0.66)).max(0.0);
    let fill = seen.dot(&Vec3::new(0.75, -0.05, 0.66)).max(0.0);
    let sky = 0.5 + 0.5 * normal.z;
    0.20 + 0.58 * key + 0.12 * fill + 0.16 * sky
}

/// A plain wall and floor with the soft shadow that the model throws straight down.
#[derive(Clone, Debug)]
struct Background {
    shadow: Vec<f32>,
    camera: Camera,
}

impl Background {
    fn new(mesh: &HexMesh, camera: &Camera) -> Self {
        let mut shadow = vec![0.0; SHADOW_CELLS * SHADOW_CELLS];
        for f in mesh.topology().faces() {
            throw_shadow(mesh, camera, f, &mut shadow);
        }
        for _ in 0..3 {
            shadow = blurred_and_transposed(&blurred_and_transposed(&shadow));
        }
        Self {
            shadow,
            camera: camera.clone(),
        }
    }

    fn light(&self, x: f64, y: f64, height: usize) -> Vec3 {
        let down = (y / height as f64).clamp(0.0, 1.0);
        let wall =
            linear([0.975, 0.975, 0.98]) * (1.0 - down) + linear([0.90, 0.905, 0.915]) * down;
        wall * (1.0 - SHADOW_DEPTH * self.shadow_at(x, y))
    }

    fn shadow_at(&self, x: f64, y: f64) -> f64 {
        let (eye, ray) = (self.camera.eye(), self.camera.ray(x, y));
        let distance = (self.camera.ground - eye.z) / ray.z;
        if !(distance.is_finite() && distance > 0.0) {
            return 0.0;
        }
        let p = map_cell(eye + ray * distance);
        let (i, j) = (p.x.floor(), p.y.floor());
        let (u, v) = (p.x - i, p.y - j);
        let cell = |di: f64, dj: f64| self.cell(i + di, j + dj);
        (cell(0.0, 0.0) * (1.0 - u) + cell(1.0, 0.0) * u) * (1.0 - v)
            + (cell(0.0, 1.0) * (1.0 - u) + cell(1.0, 1.0) * u) * v
    }

    fn cell(&self, i: f64, j: f64) -> f64 {
        let limit = SHADOW_CELLS as f64;
        let inside = (0.0..limit).contains(&i) && (0.0..limit).contains(&j);
        if inside {
            f64::from(self.shadow[j as usize * SHADOW_CELLS + i as usize])
        } else {
            0.0
        }
    }
}

/// Position on the shadow map, in cells.
fn map_cell(p: Vec3) -> Vec2 {
    p.xy()
        .map(|c| (c / SHADOW_REACH + 1.0) * 0.5 * SHADOW_CELLS as f64)
}

/// Marks the cells under a panel: darker the nearer the panel is to the ground.
fn throw_shadow(mesh: &HexMesh, camera: &Camera, f: FaceId, shadow: &mut [f32]) {
    let corners: Vec<Vec3> = mesh.corners(f).map(|p| camera.normalised(p)).collect();
    let height = corners.iter().map(|p| p.z).sum::<f64>() / corners.len() as f64 - camera.ground;
    let strength = (1.0 / (1.0 + (2.0 * height).powi(2))) as f32;
    let outline: Vec<Vec2> = corners.iter().map(|&p| map_cell(p)).collect();
    scan_polygon(&outline, 0..SHADOW_CELLS, SHADOW_CELLS, |row, columns| {
        for cell in
            &mut shadow[row * SHADOW_CELLS + columns.start..row * SHADOW_CELLS + columns.end]
        {
            *cell = cell.max(strength);
        }
    });
}

/// Box blur along the rows; rows become columns, so that two calls blur both directions.
fn blurred_and_transposed(map: &[f32]) -> Vec<f32> {
    let n = SHADOW_CELLS;
    let mut out = vec![0.0; n * n];
    for (y, row) in map.chunks_exact(n).enumerate() {
        for x in 0..n {
            let (first, last) = (x.saturating_sub(SHADOW_BLUR), (x + SHADOW_BLUR).min(n - 1));
            let sum: f32 = row[first..=last].iter().sum();
            out[x * n + y] = sum / (2 * SHADOW_BLUR + 1) as f32;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_the_amount_of_shadow_and_its_place() {
        let mut map = vec![0.0; SHADOW_CELLS * SHADOW_CELLS];
        map[100 * SHADOW_CELLS + 60] = 1.0;
        let soft = blurred_and_transposed(&blurred_and_transposed(&map));
        assert!((soft.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let weighted = |along: fn(usize) -> usize| -> f32 {
            soft.iter()
                .enumerate()
                .map(|(i, s)| s * along(i) as f32)
                .sum()
        };
        assert!((weighted(|i| i % SHADOW_CELLS) - 60.0).abs() < 1e-3);
        assert!((weighted(|i| i / SHADOW_CELLS) - 100.0).abs() < 1e-3);
    }
}
