//! Layers: offsets that have been checked, and how far an offset may go.

use super::contact::first_contact;
use super::gauss_image::GaussImage;
use super::inheritance::Inheritance;
use super::{OffsetError, OffsetOptions};
use phex_mesh::{HexMesh, Violation};

/// Steps at which the way to the first contact is looked at, before the first invalid one is
/// narrowed down.
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
    /// The largest distance that gives a valid mesh without passing one that does not; at least 0,
    /// infinite if nothing ends it. See [`safe_distances`] for how densely the way is looked at.
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

impl SafeDistances {
    /// Those of a mesh that is not valid itself.
    fn none(error: OffsetError) -> Self {
        let limit = match error {
            OffsetError::MeshNotValid { first, .. } => Some(*first),
            _ => None,
        };
        let side = SafeDistance {
            distance: 0.0,
            limit,
        };
        Self {
            outward: side.clone(),
            inward: side,
        }
    }
}

/// The offset by `distance`, checked; what is wrong with it is wrong with the mesh already
/// ([`Inheritance`]).
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, face_gauss_image, layer};
/// use phex_mesh::VertexId;
///
/// let options = OffsetOptions::default();
/// let image = face_gauss_image(&cube, &options)?;
/// let outer = layer(&cube, &image, 0.1, &options)?;
/// let corner = outer.position(VertexId::new(7));
/// assert!((corner - Vec3::repeat(1.1)).norm() < 1e-15);
/// // Inwards the faces meet at half the edge.
/// assert!(layer(&cube, &image, -0.6, &options).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If there is a new violation; the first one is named.
pub fn layer(
    mesh: &HexMesh,
    image: &GaussImage,
    distance: f64,
    options: &OffsetOptions,
) -> Result<HexMesh, OffsetError> {
    if !distance.is_finite() {
        return Err(OffsetError::Distance { distance });
    }
    let inheritance = Inheritance::of(mesh, options)?;
    let moved = image.offset(mesh, distance);
    inheritance.checked(mesh, moved, distance)
}

/// The largest distances to both sides for which the offset is valid.
///
/// Contacts of a face with itself and vanishing edges are computed from the straight motion of the
/// vertices. On the way to the first of them the mesh is validated at 24 places, since faces that
/// are far apart along the mesh may meet; the first place that fails is narrowed down.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, face_gauss_image, safe_distances};
///
/// let options = OffsetOptions::default();
/// let image = face_gauss_image(&cube, &options)?;
/// let safe = safe_distances(&cube, &image, &options);
/// assert!(safe.inward.distance > 0.4 && safe.inward.distance <= 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn safe_distances(
    mesh: &HexMesh,
    image: &GaussImage,
    options: &OffsetOptions,
) -> SafeDistances {
    safe_distances_up_to(f64::INFINITY, mesh, image, options)
}

/// The same looked at up to a largest distance, which the result may exceed by a look: it costs
/// less where only small distances matter.
pub fn safe_distances_up_to(
    largest: f64,
    mesh: &HexMesh,
    image: &GaussImage,
    options: &OffsetOptions,
) -> SafeDistances {
    let inheritance = match Inheritance::of(mesh, options) {
        Ok(inheritance) => inheritance,
        Err(error) => return SafeDistances::none(error),
    };
    let side = |side: f64| safe_distance(mesh, image, side, largest, &inheritance);
    SafeDistances {
        outward: side(1.0),
        inward: side(-1.0),
    }
}

fn safe_distance(
    mesh: &HexMesh,
    image: &GaussImage,
    side: f64,
    largest: f64,
    inheritance: &Inheritance,
) -> SafeDistance {
    let far = FAR * mesh.diagonal();
    let contact = first_contact(mesh, image, side).min(far);
    let fault = |d: f64| inheritance.first_fault(mesh, &image.offset(mesh, side * d));
    let place = |k: usize| {
        let fraction = if contact < far {
            k as f64 / LOOKS as f64
        } else {
            GROWTH.powi(k as i32 - LOOKS as i32)
        };
        contact * fraction
    };
    let last = (1..LOOKS).find(|k| place(*k) >= largest).unwrap_or(LOOKS);
    let failed = (1..=last).find_map(|k| fault(place(k)).map(|f| (k, f)));
    let Some((k, limit)) = failed else {
        let distance = match last < LOOKS {
            true => place(last),
            false if contact < far => contact,
            false => f64::INFINITY,
        };
        return SafeDistance {
            distance,
            limit: None,
        };
    };
    let valid = if k == 1 { 0.0 } else { place(k - 1) };
    narrowed(valid, place(k), limit, fault)
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

/// Pairs of layers that follow one another by their distances, the lower one first; a single layer
/// makes a pair with the mesh.
pub fn successive<'a>(
    mesh: &'a HexMesh,
    layers: impl IntoIterator<Item = (f64, &'a HexMesh)>,
) -> Vec<[&'a HexMesh; 2]> {
    let mut all: Vec<(f64, &HexMesh)> = layers.into_iter().collect();
    if all.len() == 1 {
        all.insert(0, (0.0, mesh));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.windows(2).map(|pair| [pair[0].1, pair[1].1]).collect()
}

/// A positive length with five digits, never more than it is.
pub fn rounded_down(length: f64) -> f64 {
    if length <= 0.0 || !length.is_finite() {
        return length;
    }
    let digits = 4 - length.log10().floor() as i32;
    let scale = 10f64.powi(digits.abs());
    if digits >= 0 {
        (length * scale).floor() / scale
    } else {
        (length / scale).floor() * scale
    }
}

#[cfg(test)]
mod tests {
    use super::{rounded_down, successive};
    use crate::classical::goldberg;
    use std::ptr::eq;

    #[test]
    fn layers_follow_one_another_by_distance() {
        let [mesh, inner, outer] = [(); 3].map(|()| goldberg(1, 0).unwrap().mesh);
        let is = |found: &[[&phex_mesh::HexMesh; 2]], lower, upper| {
            found.len() == 1 && eq(found[0][0], lower) && eq(found[0][1], upper)
        };
        assert!(is(&successive(&mesh, [(-0.1, &inner)]), &inner, &mesh));
        assert!(is(&successive(&mesh, [(0.1, &outer)]), &mesh, &outer));
        assert!(is(&successive(&mesh, [(0.0, &outer)]), &mesh, &outer));
        let both = successive(&mesh, [(0.1, &outer), (-0.1, &inner)]);
        assert!(is(&both, &inner, &outer), "the mesh itself is no layer");
    }

    #[test]
    fn five_digits_and_never_more() {
        assert_eq!(rounded_down(0.473_689_9), 0.47368);
        assert_eq!(rounded_down(1_234_567.0), 1_234_500.0);
        assert_eq!(rounded_down(0.001_299_999), 0.0012999);
        assert_eq!(rounded_down(f64::INFINITY), f64::INFINITY);
    }
}
