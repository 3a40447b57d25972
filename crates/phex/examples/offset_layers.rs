//! Two layers of panels with a constant gap between them, as far apart as they may be.

use phex::Mesher;
use phex::offset::{
    OffsetKind, OffsetOptions, distance_error, face_gauss_image, layer, safe_distances,
};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["torus", "catenoid", "roof"] {
        let shape = Shape::from_name(name, &[])?;
        let surface = triangulate(&shape, &TriangulationOptions::default())?;
        let made = Mesher::new().panels(300).run(&surface)?;
        let (mesh, options) = (made.mesh(), OffsetOptions::default());
        let image = face_gauss_image(mesh, &options)?;
        let safe = safe_distances(mesh, &image, &options);
        let gap = 0.5 * safe.outward.distance.min(0.1 * surface.diagonal());
        let outer = layer(mesh, &image, gap, &options)?;
        let error = distance_error(mesh, &outer, OffsetKind::Face, gap)?;
        println!(
            "{name}: safe outward {:.4}, inward {:.4}; a layer at {gap:.4}, off by {error:.1e}",
            safe.outward.distance, safe.inward.distance
        );
    }
    Ok(())
}
