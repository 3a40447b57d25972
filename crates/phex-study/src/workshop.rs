//! What a variant's panels mean to a workshop.

use phex_fab::{FabOptions, PanelIds, fabricate, folder, valid_mesh};
use phex_job::{JobResult, Quantity, SheetSize, Unit, chain};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// What panels are cut from; plain numbers of sheets are millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Workshop {
    /// Thickness of the panels, in model units or with a unit.
    pub thickness: Quantity,
    /// The sides of a sheet.
    #[serde(default)]
    pub sheet: SheetSize,
    /// Rounds of exchanges that make sheets fuller; 0 is fast, 60 what `phex fab` does.
    #[serde(default, alias = "nest_effort")]
    pub nest_effort: u32,
}

/// Adds what sheets and parts a valid mesh needs to a row, or why it can't be made.
pub(crate) fn add_workshop(
    columns: &mut Map<String, Value>,
    workshop: &Workshop,
    job: &JobResult,
    progress: &dyn phex::Progress,
) {
    match made(workshop, job, progress) {
        Ok(figures) => columns.extend(figures),
        Err(told) => {
            columns.insert("out:workshop".to_owned(), json!(told));
        }
    }
}

fn made(
    workshop: &Workshop,
    job: &JobResult,
    progress: &dyn phex::Progress,
) -> Result<Map<String, Value>, String> {
    let (mesh, unit) = (&job.mesh, job.limits.unit);
    let mut options = FabOptions {
        thickness: workshop.thickness.length(unit, mesh.diagonal()),
        unit_mm: unit.metres() / Unit::Mm.metres(),
        sheet_mm: workshop.sheet.millimetres(),
        nest_effort: workshop.nest_effort,
        ..FabOptions::default()
    };
    let planarity = job.limits.planarity;
    options.validity.planarity = planarity.map(|q| q.fraction(unit, mesh.mean_edge()));
    let ids = PanelIds::new(mesh);
    let valid = valid_mesh(mesh.clone(), &ids, &options.validity);
    let made = valid.and_then(|valid| fabricate(valid, ids, options, progress));
    let summary = folder::summary(&made.map_err(|e| chain(&e))?);
    let columns = [
        ("out:sheets", "sheets"),
        ("out:sheet-use", "use_without_last_offcut_percent"),
        ("out:distinct-panels", "distinct_panels"),
        ("out:distinct-angles", "distinct_dihedral_angles"),
    ];
    let column = |(name, figure): (&str, &str)| (name.to_owned(), summary[figure].clone());
    Ok(columns.into_iter().map(column).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_hyphenated_and_older_files_are_read() {
        let effort = |key: &str| {
            let text = format!("{{ \"thickness\": \"20mm\", \"{key}\": 7 }}");
            serde_json::from_str::<Workshop>(&text).map(|w| w.nest_effort)
        };
        assert_eq!(effort("nest-effort").unwrap(), 7);
        assert_eq!(effort("nest_effort").unwrap(), 7);
        let written = serde_json::to_string(&Workshop {
            thickness: "20mm".parse().unwrap(),
            sheet: SheetSize::default(),
            nest_effort: 7,
        });
        assert!(written.unwrap().contains("\"nest-effort\":7"));
    }
}
