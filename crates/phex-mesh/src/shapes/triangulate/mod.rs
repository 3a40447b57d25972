//! Triangle surfaces whose vertices lie on a parametric surface exactly.
//!
//! | region of the domain | lattice | file |
//! |---|---|---|
//! | rectangle, also periodic | rows of equilateral triangles, spaced by the mean length of the parameter lines | `strip` |
//! | superellipse | concentric rings of 6, 12, 18, ... vertices | `disc` |
//! | pole to pole | a subdivided icosahedron, projected along rays | `icosphere` |
//!
//! Jitter moves interior vertices in the plane (or sphere) of the lattice before it is mapped to
//! the surface. With altitudes of `sqrt(3) / 2` edges, no lattice triangle can fold over while the
//! jitter is below `sqrt(3) / 4 = 0.433`.

mod disc;
mod icosphere;
mod jitter;
mod rows;
mod strip;

use super::ShapeError;
use super::domain::Region;
use super::parametric::ParametricSurface;
use crate::{PolygonSoup, TriangleSurface, Vec3};
use serde::{Deserialize, Serialize};

/// Fewest triangles that hold the topology of every shape.
const MIN_TRIANGLES: usize = 100;
/// Most triangles: memory stays in the gigabytes.
const MAX_TRIANGLES: usize = 20_000_000;
/// Largest jitter; see the module's text for the limit behind it.
const MAX_JITTER: f64 = 0.4;

/// How a shape is triangulated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TriangulationOptions {
    /// Number of triangles, about: the lattices come in steps. From 100 to 20 million. The default
    /// resolves every built-in shape well enough that curvature is read off to a percent.
    pub triangles: usize,
    /// How far vertices are moved at random, at most, in units of an edge of the lattice. From 0
    /// (regular) to 0.4.
    pub jitter: f64,
    /// Seed of the random moves.
    pub seed: u64,
}

impl Default for TriangulationOptions {
    fn default() -> Self {
        Self {
            triangles: 8000,
            jitter: 0.0,
            seed: 0,
        }
    }
}

impl TriangulationOptions {
    fn check(&self) -> Result<(), ShapeError> {
        if !(MIN_TRIANGLES..=MAX_TRIANGLES).contains(&self.triangles) {
            return Err(ShapeError::TriangleCount {
                triangles: self.triangles,
                min: MIN_TRIANGLES,
                max: MAX_TRIANGLES,
            });
        }
        if !(0.0..=MAX_JITTER).contains(&self.jitter) {
            return Err(ShapeError::Jitter {
                jitter: self.jitter,
                max: MAX_JITTER,
            });
        }
        Ok(())
    }
}

/// Triangles on a surface, with the surface parameters of every vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulation {
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// Parameters `(u, v)` of the vertices.
    pub parameters: Vec<[f64; 2]>,
    /// Vertex numbers of the triangles, counter-clockwise seen from the tip of the surface's
    /// normal.
    pub triangles: Vec<[u32; 3]>,
}

impl Triangulation {
    /// Positions and triangles as for a file.
    pub fn to_soup(&self) -> PolygonSoup {
        PolygonSoup {
            positions: self.positions.clone(),
            faces: self.triangles.iter().map(|t| t.to_vec()).collect(),
        }
    }
}

/// Triangles in the parameter plane.
struct ParameterMesh {
    parameters: Vec<[f64; 2]>,
    triangles: Vec<[u32; 3]>,
}

/// Triangulates a surface; see [`TriangulationOptions`].
///
/// ```
/// use phex_mesh::Vec3;
/// use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
///
/// let sphere = Shape::from_name("sphere", &[("radius", 2.0)])?;
/// let options = TriangulationOptions { triangles: 2000, ..Default::default() };
/// let surface = triangulate(&sphere, &options)?;
/// let nearest = surface.closest_point(Vec3::new(3.0, 0.0, 0.0));
/// assert!((nearest.position - Vec3::new(2.0, 0.0, 0.0)).norm() < 0.1);
/// # Ok::<(), phex_mesh::shapes::ShapeError>(())
/// ```
///
/// # Errors
/// If an option is out of its range.
pub fn triangulate<S>(
    surface: &S,
    options: &TriangulationOptions,
) -> Result<TriangleSurface, ShapeError>
where
    S: ParametricSurface + ?Sized,
{
    let mesh = triangulate_with_parameters(surface, options)?;
    Ok(TriangleSurface::new(mesh.positions, &mesh.triangles)?)
}

/// As [`triangulate`], but keeps the parameters of the vertices.
///
/// # Errors
/// If an option is out of its range.
pub fn triangulate_with_parameters<S>(
    surface: &S,
    options: &TriangulationOptions,
) -> Result<Triangulation, ShapeError>
where
    S: ParametricSurface + ?Sized,
{
    options.check()?;
    let mesh = match surface.domain().region {
        Region::Rectangle => strip::mesh(surface, options),
        Region::Superellipse { .. } => disc::mesh(surface, options),
        Region::PoleToPole => icosphere::mesh(surface, options),
    };
    let positions = mesh
        .parameters
        .iter()
        .map(|&[u, v]| surface.point(u, v))
        .collect();
    Ok(Triangulation {
        positions,
        parameters: mesh.parameters,
        triangles: mesh.triangles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::Shape;

    fn refused(options: TriangulationOptions) -> bool {
        let shape = Shape::from_name("plane", &[]).unwrap();
        triangulate(&shape, &options).is_err()
    }

    #[test]
    fn options_out_of_range_are_refused() {
        let with_triangles = |triangles| TriangulationOptions {
            triangles,
            ..Default::default()
        };
        assert!(refused(with_triangles(0)) && refused(with_triangles(usize::MAX)));
        assert!(!refused(with_triangles(MIN_TRIANGLES)));
        for jitter in [-0.1, 0.41, f64::NAN] {
            assert!(refused(TriangulationOptions {
                jitter,
                ..Default::default()
            }));
        }
    }
}
