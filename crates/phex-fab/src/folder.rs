//! The files of the workshop folder.
//!
//! | file | what it holds |
//! |---|---|
//! | `sheets/sheet-01.dxf`, `.svg` | panels to cut, one sheet a file ([`drawing`](crate::drawing)) |
//! | `panels.csv`, `edges.csv`, `nodes.csv`, `cut_list.csv`, `groups.csv` | tables ([`schedule`]) |
//! | `schedules.xlsx` | the same tables |
//! | `solids.obj`, `solids.stl` | thick panels in place, model units; an object for each panel in OBJ |
//! | `plates.dxf` | the same in mm, as all DXF here: closed 3D polylines on the layers `TOP` and `BOTTOM`, with the same number of points |
//! | `mesh.json` | the mesh for COMPAS, panels with their names and measures |
//! | `fab.json` | options, counts, use of sheets |

use crate::drawing::{dxf, sheet, sheet_name, svg};
use crate::error::FabError;
use crate::fabricate::Fabrication;
use crate::plate::Plate;
use crate::schedule::{self, csv, tables, xlsx};
use phex::offset::joined;
use phex_mesh::io::{
    DxfDrawing, FaceAttributes, Format, compas_json, fits_stl, obj_of_objects, write_soup_to,
};
use phex_mesh::{FlatFace, PolygonSoup, Vec3};
use serde_json::{Value, json};

/// One file: its path in the folder, with `/` between its parts, and its bytes.
pub type File = (String, Vec<u8>);

/// All files.
///
/// # Errors
/// If a table or a solid has no place in its format.
pub fn files(fabrication: &Fabrication) -> Result<Vec<File>, FabError> {
    let mut files: Vec<File> = Vec::new();
    for number in 0..fabrication.sheets.len() {
        let lines = sheet(fabrication, number, &fabrication.texts);
        let name = sheet_name(fabrication, number);
        files.push((format!("{name}.dxf"), dxf(&lines).into_bytes()));
        files.push((format!("{name}.svg"), svg(&lines).into_bytes()));
    }
    let tables = tables(fabrication);
    for table in &tables {
        files.push((format!("{}.csv", table.name), csv(table)?));
    }
    files.push(("schedules.xlsx".into(), xlsx(&tables)?));
    files.extend(solids(fabrication)?);
    files.push(("mesh.json".into(), mesh_json(fabrication)));
    let summary = format!("{:#}\n", summary(fabrication));
    files.push(("fab.json".into(), summary.into_bytes()));
    Ok(files)
}

/// Why a file is left out: its name and the cause; the others hold the same solids.
pub fn left_out(fabrication: &Fabrication) -> Option<String> {
    let solids = joined(&fabrication.solids);
    let refused = fits_stl(&solids.positions).err();
    refused.map(|cause| format!("{STL}: {cause}"))
}

const STL: &str = "solids.stl";

fn solids(fabrication: &Fabrication) -> Result<Vec<File>, FabError> {
    let mut made = Vec::new();
    if left_out(fabrication).is_none() {
        let mut stl = Vec::new();
        write_soup_to(&mut stl, &joined(&fabrication.solids), Format::Stl).map_err(|e| {
            FabError::Content {
                name: STL.into(),
                cause: e.to_string(),
            }
        })?;
        made.push((STL.into(), stl));
    }
    let name = |face| fabrication.ids.panel(face).to_owned();
    let objects: Vec<(String, PolygonSoup)> = fabrication
        .solids
        .iter()
        .map(|s| (name(s.face), s.surface()))
        .collect();
    let mut plates = DxfDrawing::new(&[("TOP", 1), ("BOTTOM", 5)]);
    let unit = fabrication.options.unit_mm;
    let in_mm = |points: &[Vec3]| points.iter().map(|p| p * unit).collect::<Vec<_>>();
    for solid in &fabrication.solids {
        plates.polyline_3d("TOP", &in_mm(&solid.top), true);
        plates.polyline_3d("BOTTOM", &in_mm(&solid.bottom), true);
    }
    made.push(("solids.obj".into(), obj_of_objects(&objects)));
    made.push(("plates.dxf".into(), plates.to_text().into_bytes()));
    Ok(made)
}

fn mesh_json(fabrication: &Fabrication) -> Vec<u8> {
    let mesh = &fabrication.mesh;
    let placed = fabrication.plates.iter().zip(fabrication.placements());
    let attributes = placed.enumerate().map(|(k, (plate, (sheet, _)))| {
        let flat = FlatFace::of(mesh, plate.face);
        let value = json!({
            "id": fabrication.ids.panel(plate.face),
            "type": fabrication.groups.panel_type(k),
            "sheet": sheet + 1,
            "area": flat.area(),
            "planarity": flat.planarity_length,
        });
        value.as_object().cloned().unwrap_or_default()
    });
    compas_json(
        &mesh.to_soup(),
        &attributes.collect::<Vec<FaceAttributes>>(),
    )
}

/// Numbers of panels beyond any limit and beyond each; nothing where none is set.
fn beyond_limits(fabrication: &Fabrication) -> Option<Value> {
    let (panels, of) = schedule::beyond_limits(fabrication);
    let mut counts = json!({ "panels": panels });
    for (kind, count) in &of {
        counts[kind.name()] = json!(count);
    }
    (!of.is_empty()).then_some(counts)
}

/// What was done, in numbers.
pub fn summary(fabrication: &Fabrication) -> Value {
    let groups = &fabrication.groups;
    let topology = fabrication.mesh.topology();
    let labels_left_out = fabrication
        .texts
        .iter()
        .map(|t| t.left_out.len())
        .sum::<usize>();
    let total = fabrication.total_use();
    json!({
        "schema_version": 1,
        "tool": phex::report::Tool::default(),
        "options": fabrication.options,
        "rows": fabrication.ids.has_rows(),
        "panels": topology.n_faces(),
        "area_m2": 1e-6 * fabrication.plates.iter().map(Plate::area).sum::<f64>(),
        "edges": topology.n_edges(),
        "nodes": topology.n_vertices(),
        "sheets": fabrication.sheets.len(),
        "use_percent": 100.0 * total.whole_sheets,
        "use_without_last_offcut_percent": 100.0 * total.without_last_offcut,
        "distinct_panels": groups.panels.len(),
        "distinct_lengths": groups.lengths.len(),
        "distinct_dihedral_angles": groups.dihedrals.len(),
        "distinct_corner_angles": groups.corners.len(),
        "labels_left_out": labels_left_out,
        "left_out": left_out(fabrication),
        "beyond_limits": beyond_limits(fabrication),
    })
}
