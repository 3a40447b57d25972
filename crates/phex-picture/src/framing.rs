//! Room for the legend: where it would hide panels in every corner of the picture, the model is
//! drawn smaller beside it.

use super::PictureOptions;
use super::camera::Camera;
use super::legend_layout::LegendLayout;
use super::paint::Paint;
use phex_mesh::{HexMesh, Vec2};

/// Largest share of the picture that is kept for a legend; in smaller pictures it lies over the
/// panels.
const MOST: f64 = 0.5;

/// The view of a mesh such that a corner of the picture is free for the legend, if there is to be
/// one.
pub fn camera(mesh: &HexMesh, paint: &Paint, options: &PictureOptions) -> Camera {
    let camera = Camera::facing(mesh, options);
    let picture = Vec2::new(options.width as f64, options.height as f64);
    let legend = LegendLayout::new(&paint.legend, picture.y);
    if !options.legend || is_room(mesh, &camera, &legend, picture) {
        return camera;
    }
    let room = legend.room();
    let beside = [
        [Vec2::new(room.x, 0.0), picture],
        [Vec2::zeros(), Vec2::new(picture.x, picture.y - room.y)],
    ];
    let wide = |[low, high]: &[Vec2; 2]| {
        let kept = (high - low).component_div(&picture);
        kept.min() > 1.0 - MOST
    };
    let smaller = beside.into_iter().filter(wide).map(|frame| {
        let mut smaller = camera.clone();
        smaller.fit(mesh, frame);
        smaller
    });
    // Of two views the larger one.
    let best = smaller.reduce(|a, b| if b.focal > a.focal { b } else { a });
    best.unwrap_or(camera)
}

/// Whether the legend hides no panel in one of the corners.
fn is_room(mesh: &HexMesh, camera: &Camera, legend: &LegendLayout, picture: Vec2) -> bool {
    let boxes: Vec<[Vec2; 2]> = panel_boxes(mesh, camera).collect();
    legend.places(picture).into_iter().any(|[low, high]| {
        boxes
            .iter()
            .all(|[l, h]| l.x > high.x || l.y > high.y || h.x < low.x || h.y < low.y)
    })
}

/// Upright rectangles round the panels in the picture.
fn panel_boxes<'a>(mesh: &'a HexMesh, camera: &'a Camera) -> impl Iterator<Item = [Vec2; 2]> + 'a {
    let around = |f| {
        let seen = mesh.corners(f).map(|p| camera.see(camera.normalised(p)));
        let start = [Vec2::repeat(f64::MAX), Vec2::repeat(f64::MIN)];
        seen.map(|s| Vec2::new(s.x, s.y))
            .fold(start, |[low, high], p| [low.inf(&p), high.sup(&p)])
    };
    mesh.topology().faces().map(around)
}

#[cfg(test)]
mod tests {
    use super::super::paint::Legend;
    use super::*;
    use phex_mesh::Vec3;

    /// A plate of squares seen from above, in a picture that it fills.
    fn seen(columns: u32, rows: u32) -> (HexMesh, Paint, PictureOptions) {
        let at = |k: u32| {
            Vec3::new(
                f64::from(k % (columns + 1)),
                f64::from(k / (columns + 1)),
                0.0,
            )
        };
        let positions = (0..(columns + 1) * (rows + 1)).map(at).collect();
        let corner = |c: u32, r: u32| r * (columns + 1) + c;
        let cells = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r)));
        let face = |(c, r)| {
            [
                corner(c, r),
                corner(c + 1, r),
                corner(c + 1, r + 1),
                corner(c, r + 1),
            ]
        };
        let mesh = HexMesh::new(positions, &cells.map(face).collect::<Vec<_>>()).unwrap();
        let mut paint = Paint::kinds(&mesh);
        paint.legend = Legend::Classes(vec![([0; 3], "48 quads".to_owned()); 5]);
        let options = PictureOptions {
            azimuth: Some(-90.0),
            elevation: 90.0,
            ..Default::default()
        };
        (mesh, paint, options)
    }

    #[test]
    fn a_model_that_fills_the_picture_makes_room_for_the_legend() {
        let (mesh, paint, options) = seen(8, 6);
        let picture = Vec2::new(1600.0, 1200.0);
        let legend = LegendLayout::new(&paint.legend, picture.y);
        let full = Camera::facing(&mesh, &options);
        assert!(!is_room(&mesh, &full, &legend, picture));
        let camera = camera(&mesh, &paint, &options);
        assert!(is_room(&mesh, &camera, &legend, picture));
        let inside = |[low, high]: [Vec2; 2]| low.min() > 0.0 && high.x < 1600.0 && high.y < 1200.0;
        assert!(panel_boxes(&mesh, &camera).all(inside));
        assert!(camera.focal > 0.8 * full.focal, "not smaller than need be");
    }

    #[test]
    fn a_model_that_leaves_a_corner_free_stays_as_large_as_it_was() {
        let (mesh, paint, options) = seen(8, 2);
        let full = Camera::facing(&mesh, &options);
        assert_eq!(camera(&mesh, &paint, &options).focal, full.focal);
    }
}
