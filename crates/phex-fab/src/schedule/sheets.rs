//! The cut list: what comes out of each sheet.

use super::{Cell, Table, list};
use crate::fabricate::Fabrication;

pub(super) fn table(fabrication: &Fabrication) -> Table {
    let head = vec![
        "sheet",
        "file",
        "length_mm",
        "width_mm",
        "panel_count",
        "panel_area_m2",
        "use_percent",
        "cut_off_at_mm",
        "use_to_cut_off_percent",
        "panels",
    ];
    let rows = (0..fabrication.sheets.len())
        .map(|k| row(fabrication, k))
        .collect();
    Table {
        name: "cut_list",
        head,
        rows,
    }
}

fn row(fabrication: &Fabrication, number: usize) -> Vec<Cell> {
    let [length, width] = fabrication.options.sheet_mm;
    let sheet = &fabrication.sheets[number];
    let id = |p: &crate::nest::Placement| fabrication.ids.panel(fabrication.plates[p.plate].face);
    let area = fabrication.sheet_use(number) * length * width;
    let reach = fabrication.reach(number);
    vec![
        (number + 1).into(),
        crate::drawing::sheet_name(fabrication, number).into(),
        length.into(),
        width.into(),
        sheet.len().into(),
        (area * 1e-6).into(),
        (100.0 * area / (length * width)).into(),
        reach.into(),
        (100.0 * area / (reach * width)).into(),
        list(sheet.iter().map(id)),
    ]
}
