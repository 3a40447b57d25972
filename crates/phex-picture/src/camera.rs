//! The eye: a perspective view with z up that fits the model into the picture.

use super::PictureOptions;
use phex_mesh::{FacePlane, HexMesh, Vec2, Vec3, bounds};

/// Distance of the eye in radii of the model: a long lens, so that parallels stay nearly parallel.
const EYE_DISTANCE: f64 = 6.0;
/// Free border, as a fraction of the picture's smaller side.
const MARGIN: f64 = 0.07;
/// Directions that are tried when the view is chosen: between the axes, along which models are
/// often seen edge-on.
const AZIMUTHS: [f64; 12] = [
    -60.0, -45.0, -30.0, 30.0, 45.0, 60.0, 120.0, 135.0, 150.0, 210.0, 225.0, 240.0,
];

/// A perspective camera. Lengths are in radii of the model, which is centred at the origin.
#[derive(Clone, Debug)]
pub struct Camera {
    right: Vec3,
    up: Vec3,
    /// Unit vector from the model to the eye.
    pub backward: Vec3,
    centre: Vec3,
    inverse_radius: f64,
    /// Pixels per unit of the image plane at distance 1.
    pub focal: f64,
    principal: Vec2,
    /// Height of the ground below the model.
    pub ground: f64,
}

/// A point as the camera sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Column in pixels, from the left.
    pub x: f64,
    /// Row in pixels, from the top.
    pub y: f64,
    /// One over the distance along the view direction: linear in the picture along every straight
    /// line and plane.
    pub nearness: f64,
}

impl Camera {
    /// The view that `options` ask for; without an azimuth the one in which the panels fill most of
    /// the picture.
    pub fn facing(mesh: &HexMesh, options: &PictureOptions) -> Self {
        let azimuth = Self::azimuth(mesh, options);
        Self::from_direction(mesh, azimuth.to_radians(), options)
    }

    /// The direction of that view, degrees.
    pub fn azimuth(mesh: &HexMesh, options: &PictureOptions) -> f64 {
        if let Some(azimuth) = options.azimuth.filter(|a| a.is_finite()) {
            return azimuth;
        }
        let at = |azimuth: f64| Self::from_direction(mesh, azimuth.to_radians(), options);
        let areas = area_vectors(mesh);
        let scored = AZIMUTHS.map(|a| (at(a).projected_area(&areas), a));
        // A view must be better by more than rounding, so that symmetric models are seen from the
        // front.
        let better =
            |best: (f64, f64), s: (f64, f64)| if s.0 > best.0 * (1.0 + 1e-6) { s } else { best };
        scored.into_iter().fold((0.0, AZIMUTHS[0]), better).1
    }

    fn from_direction(mesh: &HexMesh, azimuth: f64, options: &PictureOptions) -> Self {
        let elevation = options.elevation.to_radians();
        let (sin, cos) = azimuth.sin_cos();
        let backward = Vec3::new(
            elevation.cos() * cos,
            elevation.cos() * sin,
            elevation.sin(),
        );
        let right = Vec3::new(-sin, cos, 0.0);
        let (centre, radius) = bounding_sphere(mesh);
        let mut camera = Self {
            right,
            up: backward.cross(&right),
            backward,
            centre,
            inverse_radius: if radius > 0.0 && radius.is_finite() {
                1.0 / radius
            } else {
                0.0
            },
            focal: 1.0,
            principal: Vec2::zeros(),
            ground: 0.0,
        };
        let size = Vec2::new(options.width as f64, options.height as f64);
        camera.fit(mesh, [Vec2::zeros(), size]);
        camera
    }

    /// Chooses focal length and principal point so that the projected model fills a part of the
    /// picture (upper left and lower right corner, in pixels) up to the margin.
    pub fn fit(&mut self, mesh: &HexMesh, frame: [Vec2; 2]) {
        (self.focal, self.principal) = (1.0, Vec2::zeros());
        let (mut low, mut high, mut ground) =
            (Vec2::repeat(f64::MAX), Vec2::repeat(f64::MIN), f64::MAX);
        for &p in &mesh.positions {
            let q = self.see(self.normalised(p));
            (low, high) = (
                low.inf(&Vec2::new(q.x, q.y)),
                high.sup(&Vec2::new(q.x, q.y)),
            );
            ground = ground.min(self.normalised(p).z);
        }
        let size = frame[1] - frame[0];
        let free = size - Vec2::repeat(2.0 * MARGIN * size.min());
        let extent = (high - low).map(|x| x.max(1e-9));
        self.focal = (free.x / extent.x)
            .min(free.y / extent.y)
            .min(size.max() * EYE_DISTANCE);
        self.principal = frame[0] + size / 2.0 - (low + high) / 2.0 * self.focal;
        self.ground = ground;
    }

    /// A point of the model, centred and in radii.
    pub fn normalised(&self, p: Vec3) -> Vec3 {
        let q = (p - self.centre) * self.inverse_radius;
        q.map(|x| if x.is_finite() { x } else { 0.0 })
    }

    /// Where a normalised point appears.
    pub fn see(&self, p: Vec3) -> Seen {
        let nearness = 1.0 / (EYE_DISTANCE - p.dot(&self.backward)).max(1e-3);
        let scale = self.focal * nearness;
        Seen {
            x: self.principal.x + p.dot(&self.right) * scale,
            y: self.principal.y - p.dot(&self.up) * scale,
            nearness,
        }
    }

    /// Direction from the eye through a pixel, with length 1 along the view.
    pub fn ray(&self, x: f64, y: f64) -> Vec3 {
        let (u, v) = (
            (x - self.principal.x) / self.focal,
            (self.principal.y - y) / self.focal,
        );
        self.right * u + self.up * v - self.backward
    }

    /// Position of the eye.
    pub fn eye(&self) -> Vec3 {
        self.backward * EYE_DISTANCE
    }

    /// The normalised point that appears at a pixel with a given nearness.
    pub fn unsee(&self, x: f64, y: f64, nearness: f64) -> Vec3 {
        self.eye() + self.ray(x, y) / nearness
    }

    /// A vector of space along the camera's right, up and backward axes.
    pub fn in_view(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(&self.right), v.dot(&self.up), v.dot(&self.backward))
    }

    /// Area of the panels in the picture, up to a factor that all views share.
    fn projected_area(&self, areas: &[Vec3]) -> f64 {
        areas
            .iter()
            .map(|a| a.dot(&self.backward).abs())
            .sum::<f64>()
            * self.focal.powi(2)
    }
}

fn bounding_sphere(mesh: &HexMesh) -> (Vec3, f64) {
    let [low, high] = bounds(&mesh.positions);
    let centre = low / 2.0 + high / 2.0;
    let radius = mesh
        .positions
        .iter()
        .map(|p| (p - centre).norm())
        .fold(0.0, f64::max);
    (centre, radius)
}

fn area_vectors(mesh: &HexMesh) -> Vec<Vec3> {
    let faces = mesh.topology().faces();
    faces.map(|f| mesh.area_vector(f) / 2.0).collect()
}

/// Plane of a panel in normalised coordinates.
pub fn panel_plane(mesh: &HexMesh, camera: &Camera, f: phex_mesh::FaceId) -> FacePlane {
    let corners: Vec<Vec3> = mesh.corners(f).map(|p| camera.normalised(p)).collect();
    FacePlane::fit(&corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(width: f64, depth: f64) -> HexMesh {
        let positions = [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)];
        let positions = positions
            .iter()
            .map(|&(x, y)| Vec3::new(x, y, 0.3))
            .collect();
        HexMesh::new(positions, &[[0, 1, 2, 3]]).unwrap()
    }

    #[test]
    fn model_is_centred_and_as_large_as_the_margins_allow() {
        let mesh = patch(7.0, 2.0);
        let camera = Camera::facing(&mesh, &PictureOptions::default());
        let seen: Vec<Seen> = mesh
            .positions
            .iter()
            .map(|&p| camera.see(camera.normalised(p)))
            .collect();
        let range = |values: Vec<f64>| {
            values
                .iter()
                .fold((f64::MAX, f64::MIN), |(lo, hi), &v| (lo.min(v), hi.max(v)))
        };
        let (left, right) = range(seen.iter().map(|s| s.x).collect());
        let (top, bottom) = range(seen.iter().map(|s| s.y).collect());
        assert!((left + right - 1600.0).abs() < 1e-6 && (top + bottom - 1200.0).abs() < 1e-6);
        assert!((left.min(top) - MARGIN * 1200.0).abs() < 1e-6);
    }

    #[test]
    fn unsee_inverts_see() {
        let camera = Camera::facing(&patch(1.0, 1.0), &PictureOptions::default());
        let p = Vec3::new(0.3, -0.2, 0.1);
        let s = camera.see(p);
        assert!((camera.unsee(s.x, s.y, s.nearness) - p).norm() < 1e-12);
    }

    #[test]
    fn a_wall_is_seen_from_the_front() {
        let positions = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)];
        let wall = positions
            .iter()
            .map(|&(x, z)| Vec3::new(x, 0.0, z))
            .collect();
        let mesh = HexMesh::new(wall, &[[0, 1, 2, 3]]).unwrap();
        let camera = Camera::facing(&mesh, &PictureOptions::default());
        assert!(camera.backward.y.abs() > 0.7 * camera.backward.xy().norm());
    }
}
