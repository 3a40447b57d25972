//! The parts of a surface, and what was made of each, as one.

use crate::engine::Computed;
use crate::error::JobError;
use phex_mesh::{HexMesh, PerFace, PolygonSoup, SurfaceComponent, TriangleSurface};

/// The meshes of all parts.
pub(crate) fn joined_mesh(runs: &[Computed]) -> Result<HexMesh, JobError> {
    joined_meshes(runs.iter().map(|run| &run.mesh))
}

/// The meshes of all parts before their edges were made equal; nothing if none were.
pub(crate) fn joined_unrepeated(runs: &[Computed]) -> Result<Option<HexMesh>, JobError> {
    let before: Option<Vec<&HexMesh>> = runs.iter().map(|run| run.unrepeated.as_ref()).collect();
    before
        .map(|meshes| joined_meshes(meshes.into_iter()))
        .transpose()
}

fn joined_meshes<'a>(meshes: impl Iterator<Item = &'a HexMesh>) -> Result<HexMesh, JobError> {
    let soup = joined_polygons(meshes.map(HexMesh::to_soup))?;
    let mesh = HexMesh::new(soup.positions, &soup.faces);
    mesh.map_err(|e| JobError::internal("joining the parts of a mesh", &e))
}

/// The layouts that the optimiser started from; nothing if one has none.
pub(crate) fn joined_start(runs: &[Computed]) -> Option<PolygonSoup> {
    let starts: Option<Vec<PolygonSoup>> = runs.iter().map(|run| run.start.clone()).collect();
    joined_polygons(starts?.into_iter()).ok()
}

fn joined_polygons(parts: impl Iterator<Item = PolygonSoup>) -> Result<PolygonSoup, JobError> {
    let mut soup = PolygonSoup::default();
    for part in parts {
        let first = u32::try_from(soup.positions.len());
        let first = first.map_err(|e| JobError::internal("too many vertices", &e))?;
        soup.positions.extend(part.positions);
        soup.faces.extend(
            part.faces
                .into_iter()
                .map(|face| face.into_iter().map(|v| v + first).collect()),
        );
    }
    Ok(soup)
}

/// Areas that the panels of all parts are to have.
pub(crate) fn joined_wished(runs: &[Computed]) -> PerFace<f64> {
    PerFace::from_vec(
        runs.iter()
            .flat_map(|run| run.wished.iter())
            .copied()
            .collect(),
    )
}

pub(crate) fn joined_target(runs: &[Computed]) -> Result<Option<TriangleSurface>, JobError> {
    let targets: Option<Vec<&TriangleSurface>> =
        runs.iter().map(|run| run.smooth.as_ref()).collect();
    targets.map(joined).transpose()
}

/// The smooth surfaces and the facets, continued beyond their boundaries where panels were kept
/// whole; nothing if they were nowhere.
pub(crate) fn joined_beyond<'a>(
    runs: &'a [Computed],
    components: impl Iterator<Item = &'a SurfaceComponent>,
) -> Result<Option<[TriangleSurface; 2]>, JobError> {
    if runs.iter().all(|run| run.beyond.is_none()) {
        return Ok(None);
    }
    let smooth = runs.iter().filter_map(|run| match &run.beyond {
        Some(beyond) => Some(&beyond.smooth),
        None => run.smooth.as_ref(),
    });
    let facets = runs.iter().zip(components);
    let facets = facets.map(|(run, part)| match &run.beyond {
        Some(beyond) => &beyond.facets,
        None => &part.surface,
    });
    Ok(Some([joined(smooth)?, joined(facets)?]))
}

/// Parts as one surface.
pub(crate) fn joined<'a>(
    parts: impl IntoIterator<Item = &'a TriangleSurface>,
) -> Result<TriangleSurface, JobError> {
    let joined = TriangleSurface::joined(parts);
    joined.map_err(|e| JobError::internal("joining the parts of a surface", &e))
}
