//! Solid panels between two layers, with mitred sides and joint gaps.
//!
//! The panel of a face is bounded by its polygon in either layer, in the same order, and by one
//! side for each edge. At interior edges the edges of the two layers are parallel, so the side is
//! planar: the mitre that both neighbours share. At boundary edges that are not parallel the side
//! is two triangles.
//!
//! A gap `g` moves every interior edge of both polygons inwards by `g / 2`, in the plane of the
//! face; boundary edges stay. Both polygons of a face have the same angles, so their corners move
//! alike and the sides stay planar.

use super::OffsetError;
use super::face_offset::face_normals;
use super::layers::rounded_down;
use phex_mesh::polygon::is_simple;
use phex_mesh::{FaceId, FlatFace, HalfEdgeId, HexMesh, PolygonSoup, Topology, Vec3};

/// Sine of a corner's turn below which its two edges count as one line.
const STRAIGHT: f64 = 1e-6;
/// Distance of a side's corners to a plane, over its size, up to which it is one polygon.
const FLAT_SIDE: f64 = 1e-10;

/// The closed solid of one panel.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelSolid {
    /// The face.
    pub face: FaceId,
    /// Corners in the lower layer, counter-clockwise seen from outside the upper one.
    pub bottom: Vec<Vec3>,
    /// Corners in the upper layer, in the same order.
    pub top: Vec<Vec3>,
}

impl PanelSolid {
    /// The closed surface, normals pointing out: bottom, top, sides.
    pub fn surface(&self) -> PolygonSoup {
        let n = self.bottom.len() as u32;
        let mut faces = vec![(0..n).rev().collect(), (n..2 * n).collect()];
        for i in 0..n {
            faces.extend(self.side(i, (i + 1) % n, n));
        }
        PolygonSoup {
            positions: self.bottom.iter().chain(&self.top).copied().collect(),
            faces,
        }
    }

    fn side(&self, i: u32, j: u32, n: u32) -> Vec<Vec<u32>> {
        let corner = |k: u32| (self.bottom[k as usize], self.top[k as usize]);
        let ((a, d), (b, c)) = (corner(i), corner(j));
        let quad = FlatFace::new(&[a, b, c, d]);
        let size = (c - a).norm().max((d - b).norm());
        if quad.planarity_length <= FLAT_SIDE * size {
            vec![vec![i, j, n + j, n + i]]
        } else {
            vec![vec![i, j, n + j], vec![i, n + j, n + i]]
        }
    }

    /// Volume, positive if the normals of [`surface`](Self::surface) point out.
    pub fn volume(&self) -> f64 {
        self.surface().volume()
    }
}

/// All solids as one soup; each is a component of its own, in their order.
pub fn joined(solids: &[PanelSolid]) -> PolygonSoup {
    let mut all = PolygonSoup::default();
    for solid in solids {
        let first = all.positions.len() as u32;
        let surface = solid.surface();
        all.positions.extend(surface.positions);
        let moved = |face: Vec<u32>| face.into_iter().map(|k| k + first).collect();
        all.faces.extend(surface.faces.into_iter().map(moved));
    }
    all
}

/// The solids between two layers of the same connectivity, in the order of the faces. `upper` lies
/// on the side of the normals; `gap` is the width of the joints, in model units.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, face_gauss_image, layer, panel_solids};
///
/// let options = OffsetOptions::default();
/// let image = face_gauss_image(&cube, &options)?;
/// let outer = layer(&cube, &image, 0.1, &options)?;
/// let solids = panel_solids(&cube, &outer, 0.0)?;
/// let volume: f64 = solids.iter().map(|solid| solid.volume()).sum();
/// assert!((volume - (1.2_f64.powi(3) - 1.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the connectivity differs, if the gap is negative or eats up a panel, or if a panel has no
/// volume.
pub fn panel_solids(
    lower: &HexMesh,
    upper: &HexMesh,
    gap: f64,
) -> Result<Vec<PanelSolid>, OffsetError> {
    if lower.topology() != upper.topology() {
        return Err(OffsetError::Connectivity);
    }
    if !(gap >= 0.0 && gap.is_finite()) {
        return Err(OffsetError::BadGap { gap });
    }
    let normals = [face_normals(lower)?, face_normals(upper)?];
    let sides = |face: FaceId, gap: f64| {
        let bottom = inset(lower, face, &normals[0][face], gap)?;
        Some((bottom, inset(upper, face, &normals[1][face], gap)?))
    };
    let fits = |gap: f64| lower.topology().faces().all(|f| sides(f, gap).is_some());
    let solid = |face| {
        let (bottom, top) = sides(face, gap).ok_or_else(|| OffsetError::Gap {
            face,
            gap,
            most: rounded_down(largest_gap(gap, fits)),
        })?;
        let solid = PanelSolid { face, bottom, top };
        let volume = solid.volume();
        if volume > 0.0 {
            Ok(solid)
        } else {
            Err(OffsetError::Volume { face, volume })
        }
    };
    lower.topology().faces().map(solid).collect()
}

/// Share of itself that the largest gap is found to, and steps after which it is left at 0.
const GAP_SHARE: f64 = 1e-4;
const GAP_STEPS: usize = 60;

/// The largest gap below one that is too wide, by bisection; one that fits.
fn largest_gap(too_wide: f64, fits: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, too_wide);
    for _ in 0..GAP_STEPS {
        if high - low <= GAP_SHARE * low {
            break;
        }
        let middle = 0.5 * (low + high);
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Corners of a face after its interior edges have moved inwards by half the gap; `None` if that
/// leaves nothing of it, or makes it touch itself.
fn inset(mesh: &HexMesh, face: FaceId, normal: &Vec3, gap: f64) -> Option<Vec<Vec3>> {
    if gap == 0.0 {
        return Some(mesh.corners(face).collect());
    }
    let topology = mesh.topology();
    let half_edges: Vec<HalfEdgeId> = topology.face_half_edges(face).collect();
    let side = |h: HalfEdgeId| moved_edge(mesh, topology, h, normal, 0.5 * gap);
    let corner = |&h: &HalfEdgeId| {
        let at = mesh.position(topology.origin(h));
        at + corner_motion(side(topology.prev(h)), side(h))
    };
    let corners: Vec<Vec3> = half_edges.iter().map(corner).collect();
    let forward = half_edges.iter().enumerate().all(|(k, &h)| {
        let new = corners[(k + 1) % corners.len()] - corners[k];
        new.dot(&direction(mesh, topology, h)) > 0.0
    });
    (forward && is_simple(&FlatFace::new(&corners).polygon)).then_some(corners)
}

/// Inward unit normal of an edge in the plane of its face, and how far the edge moves along it.
fn moved_edge(
    mesh: &HexMesh,
    topology: &Topology,
    h: HalfEdgeId,
    normal: &Vec3,
    width: f64,
) -> (Vec3, f64) {
    let inward = normal.cross(&direction(mesh, topology, h)).normalize();
    let moves = topology.twin(h).is_some();
    (inward, if moves { width } else { 0.0 })
}

fn direction(mesh: &HexMesh, topology: &Topology, h: HalfEdgeId) -> Vec3 {
    mesh.position(topology.target(h)) - mesh.position(topology.origin(h))
}

/// The in-plane vector with given components along the inward normals of the two edges of a corner;
/// where they are one line, the larger component along it.
fn corner_motion((t, s): (Vec3, f64), (u, r): (Vec3, f64)) -> Vec3 {
    let cosine = t.dot(&u);
    let sine2 = t.cross(&u).norm_squared();
    if sine2 < STRAIGHT * STRAIGHT {
        return (t + u).try_normalize(0.0).unwrap_or(t) * s.max(r);
    }
    t * ((s - r * cosine) / sine2) + u * ((r - s * cosine) / sine2)
}
