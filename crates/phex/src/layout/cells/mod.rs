//! From lattice points to panels: a seed for each, the geodesic cells that grow from seeds, and the
//! outlines of these, also along the boundary.

pub(super) mod boundary_nodes;
pub(super) mod clusters;
pub(super) mod complex;
pub(super) mod rim;
pub(super) mod voronoi;
