//! Requests for what shows a mesh: values by panel, pictures, pages, triangles.

use crate::answer::{Answer, AnswerPart};
use crate::inputs::Inputs;
use crate::kept::Kept;
use phex::Progress;
use phex::quality::References;
use phex_fab::PanelIds;
use phex_html::{Report, Viewer, conjugate_curves, page};
use phex_job::{JobError, TypedLimits};
use phex_mesh::ear_clip::ear_clip_corners;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface, Vec3};
use phex_picture::maps::{ColourMap, Map, Subject};
use phex_picture::{PictureOptions, draw_map, draw_svg};
use serde::Deserialize;

/// A map by its name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValuesRequest {
    name: String,
}

/// A value for each face: that of a colour map, or `area` or `clearance`.
///
/// # Errors
/// If there is no such value, or it needs a surface.
pub fn values(
    request: ValuesRequest,
    inputs: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let (mesh, facets) = (inputs.panels()?, inputs.surface()?);
    let measures = phex_mesh::measure(&mesh).per_element;
    let values = match request.name.as_str() {
        "area" => measures.area.iter().copied().collect(),
        "clearance" => {
            let edge = mesh.mean_edge();
            measures.clearance.iter().map(|c| c / edge).collect()
        }
        name => {
            colours(
                of_faces(name)?,
                &mesh,
                facets.as_ref(),
                inputs.kept.as_ref(),
            )?
            .values
        }
    };
    Ok(vec![("values", AnswerPart::Numbers(values))])
}

/// A map for pictures.
fn named(name: &str) -> Result<Map, JobError> {
    let map = Map::ALL.into_iter().find(|m| m.name() == name);
    map.ok_or_else(|| {
        let names = Map::ALL.map(Map::name).join(", ");
        JobError::Input(format!("color: `{name}` is none of {names}"))
    })
}

/// A map with a value for each face.
fn of_faces(name: &str) -> Result<Map, JobError> {
    let is_of_edges = |m: &Map| matches!(m, Map::EdgeLength | Map::Dihedral);
    let map = Map::ALL.into_iter().find(|m| m.name() == name);
    map.ok_or_else(|| {
        let maps = Map::ALL.into_iter().filter(|m| !is_of_edges(m));
        let names: Vec<&str> = maps.map(Map::name).collect();
        let names = names.join(", ");
        JobError::Input(format!(
            "name: `{name}` is none of area, clearance, corners, {names}"
        ))
    })
}

/// A map, by what a run has judged its mesh by, where that is kept, or else by the usual limits.
fn colours(
    map: Map,
    mesh: &HexMesh,
    facets: Option<&TriangleSurface>,
    kept: Option<&Kept>,
) -> Result<ColourMap, JobError> {
    let usual = || TypedLimits::default().judge(mesh, References::of_facets(facets));
    let subject = Subject {
        mesh,
        assessment: &kept.map_or_else(usual, |kept| kept.result.report.assessment.clone()),
        surface: facets,
    };
    let name = map.name();
    let colours = ColourMap::new(map, &subject);
    colours.ok_or_else(|| JobError::Input(format!("`{name}` needs a surface, and there is none")))
}

/// What a picture shows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureRequest {
    color: String,
    svg: bool,
    options: PictureOptions,
}

/// A picture of a mesh as PNG or SVG.
///
/// # Errors
/// If the map is unknown or needs a surface.
pub fn picture(
    request: PictureRequest,
    inputs: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let (mesh, facets) = (inputs.panels()?, inputs.surface()?);
    let map = colours(
        named(&request.color)?,
        &mesh,
        facets.as_ref(),
        inputs.kept.as_ref(),
    )?;
    let bytes = match request.svg {
        true => draw_svg(&mesh, &map, &request.options).into_bytes(),
        false => draw_map(&mesh, &map, &request.options).to_png(),
    };
    Ok(vec![("picture", AnswerPart::Bytes(bytes))])
}

/// What a page says of itself.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PageRequest {
    title: String,
    command: String,
    curves: bool,
}

/// The HTML report of a result.
///
/// # Errors
/// If there is no result.
pub fn html(
    request: PageRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let kept = inputs.kept.as_ref();
    let none = || JobError::Internal("a page needs a result".to_owned());
    let kept = &kept.ok_or_else(none)?.result;
    let names = PanelIds::new(&kept.mesh).into_names();
    let surface = kept.facets.as_ref().filter(|_| request.curves);
    let curves = surface.map_or_else(
        || Err("no surface was given".to_owned()),
        |surface| conjugate_curves(surface, progress),
    );
    let report = Report {
        title: &request.title,
        command: &request.command,
        run: &kept.report,
        mesh: &kept.mesh,
        names: Some(&names),
        surface: kept.smooth.as_ref().or(kept.facets.as_ref()),
        start: kept.start.as_ref(),
        curves: curves.as_deref().map_err(String::as_str),
    };
    let html = page(&report, Viewer::embedded());
    let html = html.map_err(|e| JobError::Internal(e.to_string()))?;
    Ok(vec![("page", AnswerPart::Text(html))])
}

/// No options.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EarsRequest {}

/// The faces cut into triangles, which is right for concave ones too; each triangle with the number
/// of its face.
///
/// # Errors
/// If a face crosses itself.
pub fn ears(_: EarsRequest, inputs: Inputs, _: &dyn Progress) -> Result<Answer, JobError> {
    let soup = &inputs.first()?.soup;
    let (mut triangles, mut face_of) = (Vec::new(), Vec::new());
    for (k, face) in soup.faces.iter().enumerate() {
        let corner = |v: &u32| soup.positions.get(*v as usize).copied();
        let corners: Option<Vec<Vec3>> = face.iter().map(corner).collect();
        let missing = || JobError::Input(format!("face {k} has a vertex that does not exist"));
        let cut = ear_clip_corners(&corners.ok_or_else(missing)?);
        let cut = cut.map_err(|e| JobError::Input(format!("face {k}: {e}")))?;
        let in_mesh = |t: [u32; 3]| t.map(|c| face[c as usize]).to_vec();
        face_of.extend(cut.iter().map(|_| k as f64));
        triangles.extend(cut.into_iter().map(in_mesh));
    }
    let soup = PolygonSoup {
        positions: soup.positions.clone(),
        faces: triangles,
    };
    Ok(vec![
        ("mesh", AnswerPart::Mesh(Some(soup))),
        ("face", AnswerPart::Numbers(face_of)),
    ])
}
