//! Regular hexagons: from an edge to an area and back.

/// Area of a regular hexagon.
pub fn hexagon_area(edge: f64) -> f64 {
    1.5 * 3.0_f64.sqrt() * edge * edge
}

/// Edge of a regular hexagon of an area.
pub fn edge_length(area: f64) -> f64 {
    (area / hexagon_area(1.0)).sqrt()
}
