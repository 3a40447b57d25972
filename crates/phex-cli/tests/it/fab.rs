//! `phex fab`: a whole folder, and refusals by the panel's name that leave nothing behind.
use crate::common::{Workshop, honeycomb};

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
            .contains("12, 1 distinct (named by rows, A to C), "),
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
    shop.write("panels.csv", shop.read("out/panels.csv"));
    let again = shop.succeed(
        "fab m.obj --thickness 10mm --planarity 1e-9 -o out -t 1 --keep-ids panels.csv --progress json",
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
    refused(
        &shop,
        &fab("--gap 1"),
        4,
        &["panel A1", "gap of 1 m", "room for is 0."],
    );
    for option in ["--spacing", "--text", "--tolerance"] {
        let told = [option, "`10%` is a percentage"];
        refused(&shop, &fab(&format!("{option} 10%")), 2, &told);
    }
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

#[test]
fn files_of_the_user_stay_in_the_folder() {
    let shop = with_honeycomb();
    let fab = "fab m.obj --thickness 10mm --planarity 1e-9 --nest-effort 0 -o out";
    shop.succeed(&format!("{fab} --sheet 300x300"));
    assert!(shop.path("out/sheets/sheet-04.dxf").exists());
    shop.write("out/offer.txt", "an offer");
    shop.write("out/sheets/notes.txt", "notes");
    shop.succeed(fab);
    assert!(!shop.path("out/sheets/sheet-02.dxf").exists());
    assert_eq!(shop.read("out/offer.txt"), b"an offer");
    assert_eq!(shop.read("out/sheets/notes.txt"), b"notes");
    assert!(!shop.path("out/.phex-new").exists());

    let table = shop.read("out/panels.csv");
    shop.write("out/panels.csv", "with a column of mine");
    refused(&shop, fab, 4, &["out", "panels.csv", "changed since"]);
    assert_eq!(shop.read("out/panels.csv"), b"with a column of mine");
    shop.write("out/panels.csv", table);
    shop.succeed(fab);
}

#[test]
fn inputs_in_the_folder_that_is_written_are_refused() {
    let shop = with_honeycomb();
    let more = "--thickness 10mm --planarity 1e-9 --nest-effort 0";
    shop.succeed(&format!("fab m.obj {more} -o out"));
    shop.write("out/mine.obj", shop.read("m.obj"));
    let table = shop.read("out/panels.csv");
    for arguments in [
        "fab out/mine.obj -o out",
        "fab out/../out/mine.obj -o ./out",
        "fab m.obj -o out --keep-ids out/panels.csv",
    ] {
        refused(
            &shop,
            &format!("{arguments} {more}"),
            4,
            &["out/", "is read"],
        );
    }
    refused(&shop, &format!("fab m.obj {more} -o ."), 4, &["m.obj"]);
    refused(
        &shop,
        &format!("fab m.obj {more} -o m.obj"),
        4,
        &["no folder"],
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("out", shop.path("link")).unwrap();
        refused(
            &shop,
            &format!("fab out/mine.obj {more} -o link"),
            4,
            &["is read"],
        );
        shop.succeed(&format!("fab m.obj {more} -o link"));
        assert!(shop.path("link").is_symlink());
    }
    assert_eq!(shop.read("out/mine.obj"), shop.read("m.obj"));
    assert_eq!(shop.read("out/panels.csv"), table);
}

#[test]
fn names_that_can_t_be_kept_are_refused_with_their_line() {
    let shop = with_honeycomb();
    shop.succeed("fab m.obj --thickness 10mm --planarity 1e-9 --nest-effort 0 -o out");
    let table = String::from_utf8(shop.read("out/panels.csv")).unwrap();
    for (name, line) in [
        ("B2", "line 2"),
        ("", "line 2"),
        ("=1+1", "=1+1"),
        ("A\0", "line 2"),
    ] {
        shop.write("old.csv", table.replacen("\nA1,", &format!("\n{name},"), 1));
        refused(
            &shop,
            "fab m.obj --thickness 10mm --planarity 1e-9 -o other --keep-ids old.csv",
            4,
            &["old.csv", line],
        );
    }
    shop.write("old.csv", table.replacen("\nA1,", "\nNORTH-1,", 1));
    let run = shop.succeed(
        "fab m.obj --thickness 10mm --planarity 1e-9 --nest-effort 0 -o out --keep-ids old.csv",
    );
    assert!(
        run.stdout.contains("(12 of their names kept)"),
        "{}",
        run.stdout
    );
    // The same table for a model elsewhere.
    let elsewhere = honeycomb(3, 4, |_, [x, y, z]| [0.1 * x + 50.0, 0.1 * y, 0.1 * z]);
    shop.write("far.obj", elsewhere);
    let run = shop.succeed(
        "fab far.obj --thickness 10mm --planarity 1e-9 --nest-effort 0 -o far --keep-ids old.csv",
    );
    let told = "names        of old.csv fit no panel";
    assert!(run.stdout.contains(told), "{}", run.stdout);
    assert!(
        shop.read("out/panels.csv")
            .windows(9)
            .any(|w| w == b"\nNORTH-1,")
    );
}

/// All drawings of the folder have one unit, whatever that of the model.
#[test]
fn drawings_are_in_millimetres() {
    let shop = with_honeycomb();
    for unit in ["m", "cm"] {
        shop.succeed(&format!(
            "fab m.obj --thickness 0.01 --planarity 1e-9 --nest-effort 0 --sheet 20mx20m --unit {unit} -o {unit}"
        ));
        let drawing = String::from_utf8(shop.read(&format!("{unit}/plates.dxf"))).unwrap();
        let lines: Vec<&str> = drawing.lines().collect();
        let values = |name: &str, code: &str| -> Vec<f64> {
            let is_top = |w: &[&str]| *w == ["0", name, "8", "TOP"];
            let vertices = lines.windows(4).enumerate().filter(|(_, w)| is_top(w));
            let after = vertices.map(|(i, _)| &lines[i..]);
            let value = |l: &[&str]| {
                l.chunks(2)
                    .find(|pair| pair[0] == code)
                    .map(|p| p[1].parse().unwrap())
            };
            after.filter_map(value).collect()
        };
        let columns = [("10", 2), ("20", 3), ("30", 4)];
        let nodes = table(&shop, &format!("{unit}/nodes.csv"));
        for (code, column) in columns {
            let largest = |v: Vec<f64>| v.into_iter().fold(f64::MIN, f64::max);
            let nodes = nodes[1..].iter().map(|row| row[column].parse().unwrap());
            let (drawn, wanted) = (largest(values("VERTEX", code)), largest(nodes.collect()));
            assert!(
                (drawn - wanted).abs() < 1e-9 * wanted.abs(),
                "{unit}: {drawn} for {wanted}"
            );
        }
    }
}

/// The panels are 173 mm wide and 200 mm high; upright they need a sheet that is no shorter.
#[test]
fn a_sheet_that_is_too_small_is_told_what_would_do() {
    let shop = with_honeycomb();
    let fab = "fab m.obj --thickness 10mm --planarity 1e-9 --nest-effort 0 -o out";
    let others = "A2, A3, A4, B1, B2, B3, B4, C1, C2, C3";
    let run = shop.phex(&format!("{fab} --sheet 180x500"));
    run.refuses(
        4,
        &[
            "panel A1 ",
            &format!("nor do 11 more: {others} and 1 more;"),
            "smallest sheet",
        ],
    );
    assert!(!run.stderr.contains("turned"), "{}", run.stderr);
    for rotations in ["free", "90"] {
        let run = shop.phex(&format!("{fab} --sheet 180x500 --rotations {rotations}"));
        run.refuses(4, &["the smallest sheet for all panels is "]);
        let (_, rest) = run.stderr.split_once("all panels is ").unwrap();
        let sides: Vec<f64> = rest
            .split(' ')
            .step_by(2)
            .take(2)
            .map(|w| w.parse().unwrap())
            .collect();
        let sheet = |less: f64| {
            format!(
                "{fab} --sheet {}x{} --rotations {rotations}",
                sides[0] - less,
                sides[1]
            )
        };
        shop.succeed(&sheet(0.0));
        shop.phex(&sheet(2.0)).refuses(4, &["does not fit"]);
    }
    let run = shop.phex(&format!("{fab} --sheet 180x500 --rotations 0,180"));
    run.refuses(
        4,
        &[
            "may be turned by 0, 180 degrees only",
            "if they may be turned freely",
        ],
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
        4,
        &[
            "panels P000",
            "largest safe thickness on this side is 0.47",
            " m",
        ],
    );
    shop.succeed("fab m.obj --thickness 0.1 --sheet 5000x5000 -o out");
    let panels = table(&shop, "out/panels.csv");
    assert!(panels[1..].iter().all(|row| {
        row[12]
            .split(';')
            .all(|m| (m.parse::<f64>().unwrap() - 45.0).abs() < 1e-9)
    }));
}

/// Short edges are outside a tolerance: plates are cut all the same, and layers say it alike.
#[test]
fn what_is_outside_a_tolerance_is_cut() {
    let shop = Workshop::new();
    // The first corner comes close to the second, in the plane of all panels.
    let second = std::cell::Cell::new([0.0; 3]);
    honeycomb(3, 4, |k, p| {
        if k == 1 {
            second.set(p);
        }
        p
    });
    let near = |k: usize, p: [f64; 3]| match k {
        0 => [0, 1, 2].map(|i| second.get()[i] + 0.03 * (p[i] - second.get()[i])),
        _ => p,
    };
    shop.write("m.obj", honeycomb(3, 4, near));
    let check = shop.phex("check m.obj");
    assert_eq!(check.code, Some(3), "{}", check.stdout);
    assert!(
        check.stdout.contains("OUTSIDE TOLERANCE"),
        "{}",
        check.stdout
    );
    let layers = shop.phex("offset m.obj --distance 0.01 -o layers");
    assert_eq!(layers.code, Some(3), "{}", layers.stderr);
    let told = "INHERITED    the mesh itself is outside a tolerance, and so are its layers: ";
    assert!(layers.stdout.contains(told), "{}", layers.stdout);
    shop.succeed("fab m.obj --thickness 1mm --sheet 9x9m --nest-effort 0 -o out");
    shop.write(
        "bent.obj",
        honeycomb(3, 4, |k, [x, y, _]| [x, y, 0.1 * (k % 2) as f64]),
    );
    let told = ["panel C1", "not planar", "make the panels planar first"];
    refused(&shop, "fab bent.obj --thickness 1mm -o other", 4, &told);
}

/// Limits judge what is cut: a joint makes the upper face smaller, but for sides at the boundary.
#[test]
fn limits_judge_the_plates() {
    let shop = with_honeycomb();
    shop.write("job.toml", "[limits]\nmax-edge = '95mm'\nmin-angle = 20\n");
    let fab = "fab m.obj --thickness 1mm --planarity 1e-9 --nest-effort 0 -o out --limits job.toml";
    let run = shop.succeed(fab);
    let told =
        "limits       12 panels are beyond them: 12 --max-edge (columns ..._used of panels.csv)";
    assert!(run.stdout.contains(told), "{}", run.stdout);
    let counts = &shop.json("out/fab.json")["beyond_limits"];
    let expected = serde_json::json!({ "panels": 12, "max_edge": 12, "min_angle": 0 });
    assert_eq!(counts, &expected);
    let run = shop.succeed(&format!("{fab} --gap 10mm"));
    let told = "limits       10 panels are beyond them: 10 --max-edge";
    assert!(run.stdout.contains(told), "{}", run.stdout);
    let rows = table(&shop, "out/panels.csv");
    let column = |name: &str| rows[0].iter().position(|h| h == name).unwrap();
    let (used, lengths) = (column("max_edge_used"), column("lengths_mm"));
    for row in &rows[1..] {
        let longest = row[lengths].split(';').map(|l| l.parse::<f64>().unwrap());
        let longest = longest.fold(0.0, f64::max);
        let used: f64 = row[used].parse().unwrap();
        assert!((used - longest / 95.0).abs() < 1e-3, "{row:?}");
    }
}
