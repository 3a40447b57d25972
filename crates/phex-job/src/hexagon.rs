//! Regular hexagons: from an edge to an area and back.

use phex_mesh::polygon::HEXAGON;

/// Area of a regular hexagon.
pub fn hexagon_area(edge: f64) -> f64 {
    HEXAGON * edge * edge
}

/// Edge of a regular hexagon of an area.
pub fn edge_length(area: f64) -> f64 {
    (area / HEXAGON).sqrt()
}
