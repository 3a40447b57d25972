//! `phex fab`: a whole folder, and refusals by the panel's name that leave nothing behind.

mod common;
use common::{Workshop, honeycomb};

fn with_honeycomb() -> Workshop {
    let shop = Workshop::new();
    // A shallow dome of panels would not be planar; a flat one in a tilted plane is.
    shop.write(
        "m.obj",
        honeycomb(3, 4, |_, [x, y, z]| {
            [0.1 * x, 0.08 * y - 0.06 * z, 0.06 * y + 0.08 * z]
        }),
    );
    shop
}

fn refused(shop: &Workshop, arguments: &str, code: i32, texts: &[&str]) {
    let before = shop.files();
    shop.phex(arguments).refuses(code, texts);
    assert_eq!(shop.files(), before, "no file comes or goes");
}

fn table(shop: &Workshop, name: &str) -> Vec<Vec<String>> {
    let text = String::from_utf8(shop.read(name)).unwrap();
    text.lines()
        .map(|l| l.split(',').map(str::to_owned).collect())
        .collect()
}

#[test]
fn a_honeycomb_is_named_by_rows_and_is_one_panel_twelve_times() {
    let shop = with_honeycomb();
    let run = shop.succeed("fab m.obj --thickness 10mm --planarity 1e-9 -o out");
    assert!(
        run.stdout
            .contains("12, 1 distinct (named by rows, A1 to C4), "),
        "{}",
        run.stdout
    );
    let names: Vec<String> = table(&shop, "out/panels.csv")[1..]
        .iter()
        .map(|r| r[0].clone())
        .collect();
    assert_eq!(names[..5], ["A1", "A2", "A3", "A4", "B1"]);
    let summary = shop.json("out/fab.json");
    assert_eq!(
        (&summary["sheets"], &summary["distinct_dihedral_angles"]),
        (&1.into(), &1.into())
    );
    let drawing = String::from_utf8(shop.read("out/sheets/sheet-01.dxf")).unwrap();
    assert_eq!(drawing.matches("POLYLINE\n8\nCUT\n").count(), 12);
    let first = shop.read("out/schedules.xlsx");
    let again = shop.succeed(
        "fab m.obj --thickness 10mm --planarity 1e-9 -o out -t 1 --keep-ids out/panels.csv --progress json",
    );
    let counted = r#"{"event":"counted","stage":"panels on sheets","done":12,"total":12}"#;
    assert!(again.stderr.contains(counted), "{}", again.stderr);
    assert_eq!(
        shop.read("out/schedules.xlsx"),
        first,
        "the same bytes over the old folder"
    );
}

#[test]
fn what_can_t_be_built_is_refused_by_name() {
    let shop = with_honeycomb();
    let fab = |more: &str| format!("fab m.obj --thickness 10mm --planarity 1e-9 -o out {more}");
    refused(
        &shop,
        &fab("--sheet 150x150"),
        4,
        &["panel A1", "does not fit", "11 more"],
    );
    refused(&shop, &fab("--gap 1"), 5, &["panel A1", "gap"]);
    refused(&shop, &fab("--spacing 10%"), 4, &["spacing"]);
    refused(&shop, "fab m.obj --thickness 0 -o out", 4, &["thickness"]);
    shop.write(
        "m.obj",
        honeycomb(3, 4, |k, [x, y, z]| [x, y, if k == 0 { 0.01 } else { z }]),
    );
    refused(&shop, &fab(""), 4, &["panel A1", "not planar"]);
    std::fs::create_dir(shop.path("full")).unwrap();
    shop.write("full/precious", "x");
    refused(
        &shop,
        "fab m.obj --thickness 1mm -o full",
        4,
        &["full", "other files"],
    );
}

/// A box is thinner than it is wide: panels of more than half of its depth would meet.
#[test]
fn a_thickness_past_the_safe_offset_names_panels_and_the_safe_one() {
    let shop = Workshop::new();
    shop.write(
        "m.obj",
        "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n\
         f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
    );
    refused(
        &shop,
        "fab m.obj --thickness 0.6 --sheet 5000x5000 -o out",
        5,
        &["panels P000", "largest safe thickness", "0.47"],
    );
    shop.succeed("fab m.obj --thickness 0.1 --sheet 5000x5000 -o out");
    let panels = table(&shop, "out/panels.csv");
    assert!(panels[1..].iter().all(|row| {
        row[12]
            .split(';')
            .all(|m| (m.parse::<f64>().unwrap() - 45.0).abs() < 1e-9)
    }));
}
