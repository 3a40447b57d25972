//! The conjugate curves that a report draws.

use crate::CurveFamily;
use phex::directions::Curve;
use phex::pipeline::network_curves;
use phex::{MeshOptions, PanelSize, Progress};
use phex_mesh::{TriangleSurface, Vec3};

/// Number of panels that a brick wall on the drawn curves would have: more curves are hard to tell
/// apart.
const CURVES: usize = 300;

/// The conjugate curves of a surface, rows and columns.
///
/// # Errors
/// Why there are none, as a sentence for the report.
pub fn conjugate_curves(
    surface: &TriangleSurface,
    progress: &dyn Progress,
) -> Result<Vec<CurveFamily>, String> {
    let options = MeshOptions {
        size: PanelSize::Panels(CURVES),
        ..Default::default()
    };
    let network = network_curves(surface, &options, progress).map_err(|e| e.to_string())?;
    let family = |name: &str, curves: &[Curve]| CurveFamily {
        name: name.to_owned(),
        curves: curves.iter().map(closed_polyline).collect(),
    };
    Ok(vec![
        family("Conjugate curves: rows", &network.rows),
        family("columns", &network.columns),
    ])
}

fn closed_polyline(curve: &Curve) -> Vec<Vec3> {
    let first = curve.points.first().filter(|_| curve.closed);
    curve.points.iter().chain(first).copied().collect()
}
