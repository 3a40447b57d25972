//! Layers: offsets that have been checked, and how far an offset may go.

use super::contact::first_contact;
use super::gauss_image::GaussImage;
use super::{OffsetError, OffsetOptions};
use phex_mesh::measure::diagonal;
use phex_mesh::{HexMesh, ValidHexMesh, Violation, violations};

/// Steps at which the way to the first contact is looked at, before the first invalid one is narrowed down.
const LOOKS: usize = 24;
/// Halvings of the last interval: its length ends 1e-7 of a step.
const HALVINGS: usize = 24;
/// Distances beyond this many diagonals of the mesh count as unlimited.
const FAR: f64 = 64.0;

/// Ratio of successive looks where there is no contact.
const GROWTH: f64 = 1.5;

/// How far an offset may go to one side.
#[derive(Clone, Debug, PartialEq)]
pub struct SafeDistance {
    /// The largest distance that gives a valid mesh without passing one that does not; at least 0, infinite if nothing
    /// ends it. See [`safe_distances`] for how densely the way is looked at.
    pub distance: f64,
    /// What is wrong just beyond; `None` if the distance is infinite.
    pub limit: Option<Violation>,
}

/// Safe distances to both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct SafeDistances {
    /// On the side of the normals.
    pub outward: SafeDistance,
    /// Against the normals; counted positively.
    pub inward: SafeDistance,
}

/// The offset by `distance`, checked.
///
/// # Errors
/// If it is not a valid mesh; the first violation is named.
pub fn layer(
    mesh: &HexMesh,
    image: &GaussImage,
    distance: f64,
    options: &OffsetOptions,
) -> Result<ValidHexMesh, OffsetError> {
    if !distance.is_finite() {
        return Err(OffsetError::Distance { distance });
    }
    checked(mesh, image.offset(mesh, distance), distance, options)
}

/// Checks a mesh that has been displaced by (at most) `distance`: it must be valid, and no edge may point backwards.
///
/// # Errors
/// If it is not; the first violation is named.
pub fn checked(
    mesh: &HexMesh,
    moved: HexMesh,
    distance: f64,
    options: &OffsetOptions,
) -> Result<ValidHexMesh, OffsetError> {
    let refused = |count: usize, first: Violation| OffsetError::NotValid {
        distance,
        first: Box::new(first),
        count,
    };
    let backward = backward_edges(mesh, &moved, options);
    if let Some(first) = backward.first() {
        return Err(refused(backward.len(), first.clone()));
    }
    phex_mesh::validate(moved, None, &options.validity).map_err(|invalid| {
        let count = invalid.violations.len();
        refused(count, invalid.violations[0].clone())
    })
}

/// Edges that have been flipped: they point against their direction in `mesh`.
fn backward_edges(mesh: &HexMesh, moved: &HexMesh, options: &OffsetOptions) -> Vec<Violation> {
    let topology = mesh.topology();
    let unit = moved.mean_edge();
    let along = |m: &HexMesh, [a, b]: [_; 2]| m.position(b) - m.position(a);
    let flipped = topology.edges().filter_map(|edge| {
        let vertices = topology.edge_vertices(edge);
        let length = along(moved, vertices).dot(&along(mesh, vertices).normalize());
        let forward = length > 0.0;
        (!forward).then_some(Violation::CollapsedEdge {
            edge,
            vertices,
            length_rel: length / unit,
            limit: options.validity.edge_length_rel,
        })
    });
    flipped.collect()
}

/// The largest distances to both sides for which the offset is valid.
///
/// Contacts of a face with itself and vanishing edges are computed from the straight motion of the vertices. On the way to
/// the first of them the mesh is validated at 24 places, since faces that are far apart along the mesh may
/// meet; the first place that fails is narrowed down.
pub fn safe_distances(
    mesh: &HexMesh,
    image: &GaussImage,
    options: &OffsetOptions,
) -> SafeDistances {
    SafeDistances {
        outward: safe_distance(mesh, image, 1.0, options),
        inward: safe_distance(mesh, image, -1.0, options),
    }
}

fn safe_distance(
    mesh: &HexMesh,
    image: &GaussImage,
    side: f64,
    options: &OffsetOptions,
) -> SafeDistance {
    let far = FAR * diagonal(mesh);
    let contact = first_contact(mesh, image, side).min(far);
    let fault = |d: f64| first_fault(mesh, image, side * d, options);
    let place = |k: usize| {
        let fraction = if contact < far {
            k as f64 / LOOKS as f64
        } else {
            GROWTH.powi(k as i32 - LOOKS as i32)
        };
        if k == 0 { 0.0 } else { contact * fraction }
    };
    let failed = (0..=LOOKS).find_map(|k| fault(place(k)).map(|f| (k, f)));
    let Some((k, limit)) = failed else {
        return SafeDistance {
            distance: if contact < far {
                contact
            } else {
                f64::INFINITY
            },
            limit: None,
        };
    };
    if k == 0 {
        return SafeDistance {
            distance: 0.0,
            limit: Some(limit),
        };
    }
    narrowed(place(k - 1), place(k), limit, fault)
}

/// Bisection between a valid distance and one that is not.
fn narrowed(
    mut valid: f64,
    mut invalid: f64,
    mut limit: Violation,
    fault: impl Fn(f64) -> Option<Violation>,
) -> SafeDistance {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (valid + invalid);
        match fault(middle) {
            Some(f) => (invalid, limit) = (middle, f),
            None => valid = middle,
        }
    }
    SafeDistance {
        distance: valid,
        limit: Some(limit),
    }
}

fn first_fault(
    mesh: &HexMesh,
    image: &GaussImage,
    distance: f64,
    options: &OffsetOptions,
) -> Option<Violation> {
    let moved = image.offset(mesh, distance);
    let backward = backward_edges(mesh, &moved, options);
    backward.into_iter().next().or_else(|| {
        violations(&moved, None, &options.validity)
            .into_iter()
            .next()
    })
}
