//! The folder of workshop files: made whole beside its place, then moved there.
//!
//! | file | what it holds |
//! |---|---|
//! | `sheets/sheet-01.dxf`, `.svg` | panels to cut, one sheet a file ([`drawing`](crate::drawing)) |
//! | `panels.csv`, `edges.csv`, `nodes.csv`, `cut_list.csv`, `groups.csv` | tables ([`schedule`](crate::schedule)) |
//! | `schedules.xlsx` | the same tables |
//! | `solids.obj`, `solids.stl` | thick panels in place, model units; an object for each panel in OBJ |
//! | `plates.dxf` | the same as closed 3D polylines, on the layers `TOP` and `BOTTOM`, with the same number of points |
//! | `mesh.json` | the mesh for COMPAS, panels with their names and measures |
//! | `fab.json` | options, counts, use of sheets |

use crate::drawing::{dxf, sheet, svg};
use crate::error::FabError;
use crate::fabricate::Fabrication;
use crate::plate::Plate;
use crate::schedule::{csv, tables, xlsx};
use phex::parallel_mesh::joined;
use phex_mesh::io::{
    DxfDrawing, FaceAttributes, Format, compas_json, obj_of_objects, write_soup_to,
};
use phex_mesh::{FlatFace, PolygonSoup};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// A file that a folder holds if and only if it was made here.
const MARK: &str = "fab.json";

/// One file: its path in the folder, and its bytes.
pub type File = (String, Vec<u8>);

/// Path of a sheet's drawing, without extension.
pub fn sheet_name(fabrication: &Fabrication, number: usize) -> String {
    let width = fabrication.sheets.len().to_string().len().max(2);
    format!("sheets/sheet-{:0width$}", number + 1)
}

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
    files.push((MARK.into(), summary.into_bytes()));
    Ok(files)
}

fn solids(fabrication: &Fabrication) -> Result<[File; 3], FabError> {
    let mut stl = Vec::new();
    write_soup_to(&mut stl, &joined(&fabrication.solids), Format::Stl).map_err(|e| {
        FabError::Content {
            name: "solids.stl".into(),
            cause: e.to_string(),
        }
    })?;
    let name = |face| fabrication.ids.panel(face).to_owned();
    let objects: Vec<(String, PolygonSoup)> = fabrication
        .solids
        .iter()
        .map(|s| (name(s.face), s.surface()))
        .collect();
    let mut plates = DxfDrawing::new(&[("TOP", 1), ("BOTTOM", 5)]);
    for solid in &fabrication.solids {
        plates.polyline_3d("TOP", &solid.top, true);
        plates.polyline_3d("BOTTOM", &solid.bottom, true);
    }
    Ok([
        ("solids.obj".into(), obj_of_objects(&objects)),
        ("solids.stl".into(), stl),
        ("plates.dxf".into(), plates.to_text().into_bytes()),
    ])
}

fn mesh_json(fabrication: &Fabrication) -> Vec<u8> {
    let mesh = &fabrication.mesh;
    let attributes = fabrication.plates.iter().enumerate().map(|(k, plate)| {
        let flat = FlatFace::of(mesh, plate.face);
        let value = json!({
            "id": fabrication.ids.panel(plate.face),
            "type": fabrication.groups.panel_type(k),
            "sheet": fabrication.placement(k).0 + 1,
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

/// What was done, in numbers.
pub fn summary(fabrication: &Fabrication) -> Value {
    let groups = &fabrication.groups;
    let topology = fabrication.mesh.topology();
    let left_out = fabrication
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
        "labels_left_out": left_out,
    })
}

/// Checks that a folder can be written to: it does not exist, is empty, or was made here before.
///
/// # Errors
/// If it holds other things, or its parent is no folder.
pub fn check_place(folder: &Path) -> Result<(), FabError> {
    let refused = |cause: String| {
        Err(FabError::Folder {
            path: folder.to_path_buf(),
            cause,
        })
    };
    match fs::read_dir(folder) {
        Ok(mut entries) => {
            if entries.next().is_some() && !folder.join(MARK).is_file() {
                return refused(format!(
                    "the folder holds other files (and no `{MARK}` of an earlier run)"
                ));
            }
            Ok(())
        }
        Err(_) if folder.exists() => refused("it is no folder".into()),
        Err(_) => match existing_ancestor(folder) {
            Some(parent) if parent.is_dir() => Ok(()),
            _ => refused("there is no folder to make it in".into()),
        },
    }
}

fn existing_ancestor(folder: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(folder).ok()?;
    absolute
        .ancestors()
        .skip(1)
        .find(|p| p.exists())
        .map(Path::to_path_buf)
}

/// Writes all files into a temporary folder beside `folder`, and gives it that name when it is whole. A folder of an
/// earlier run is replaced.
///
/// # Errors
/// If the folder holds other things, or the system refuses; what was there stays.
pub fn write(folder: &Path, files: &[File]) -> Result<(), FabError> {
    check_place(folder)?;
    replace(folder, files).map_err(|e| FabError::Folder {
        path: folder.to_path_buf(),
        cause: e.to_string(),
    })
}

fn replace(folder: &Path, files: &[File]) -> std::io::Result<()> {
    let place = std::path::absolute(folder)?;
    let parent = place.parent().unwrap_or(Path::new("/"));
    fs::create_dir_all(parent)?;
    let temporary = tempfile::Builder::new()
        .prefix(".phex-")
        .suffix(".tmp")
        .tempdir_in(parent)?;
    let made = temporary.path().join("new");
    for (name, bytes) in files {
        let path = made.join(name);
        fs::create_dir_all(path.parent().unwrap_or(&made))?;
        let mut file = fs::File::create(&path)?;
        std::io::Write::write_all(&mut file, bytes)?;
        file.sync_all()?;
    }
    let old = temporary.path().join("old");
    let existed = place.exists();
    if existed {
        fs::rename(&place, &old)?;
    }
    fs::rename(&made, &place).inspect_err(|_| {
        if existed {
            // The one that was there comes back; if even that fails it is in the temporary folder's error.
            let _ = fs::rename(&old, &place);
        }
    })
}
