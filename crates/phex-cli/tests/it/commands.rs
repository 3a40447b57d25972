//! The commands on good input.
use crate::common::{Workshop, honeycomb};

#[test]
fn help_of_every_command_lists_the_exit_codes() {
    let shop = Workshop::new();
    for command in [
        "",
        "mesh",
        "network",
        "planarize",
        "check",
        "info",
        "convert",
        "shape",
        "report",
        "render",
        "koebe",
        "parallel",
    ] {
        let help = shop.succeed(&format!("{command} --help")).stdout;
        for code in ["0 ", "1 ", "2 ", "3 ", "4 ", "5 ", "130 "] {
            assert!(
                help.lines().any(|line| line.trim_start().starts_with(code)),
                "{command}: {code}"
            );
        }
    }
    assert!(shop.succeed("--version").stdout.starts_with("phex "));
}

#[test]
fn the_version_says_whether_reports_have_the_interactive_view() {
    let shop = Workshop::new();
    assert_eq!(shop.succeed("-V").stdout.lines().count(), 1);
    let version = shop.succeed("--version").stdout;
    let view = version.lines().nth(1).unwrap_or_default();
    let inside = view == "interactive view of HTML reports: inside";
    assert!(
        inside || view.starts_with("interactive view of HTML reports: not inside: "),
        "{version}"
    );
    shop.write("flat.obj", honeycomb(4, 5, |_, p| p));
    let said = shop.succeed("report flat.obj --html flat.html").stdout;
    assert_eq!(inside, !said.contains("no interactive view"), "{said}");
}

#[test]
fn check_passes_a_flat_honeycomb_and_names_a_lifted_corner() {
    let shop = Workshop::new();
    shop.write("flat.obj", honeycomb(4, 5, |_, p| p));
    let run = shop.succeed("check flat.obj --report flat.json");
    assert!(
        run.stdout.contains("PASS") && run.stdout.contains("20 hexagons"),
        "{}",
        run.stdout
    );
    assert_eq!(shop.json("flat.json")["verdict"], "pass");

    shop.write(
        "bent.obj",
        honeycomb(4, 5, |i, [x, y, z]| {
            [x, y, if i == 0 { z + 0.1 } else { z }]
        }),
    );
    let run = shop.phex("check bent.obj --report bent.json --png bent.png");
    assert_eq!(run.code, Some(3));
    assert!(
        run.stdout.contains("FAILED       planarity") && run.stdout.contains("faces 0\n"),
        "{}",
        run.stdout
    );
    let report = shop.json("bent.json");
    let checks = report["checks"].as_array().unwrap();
    let planarity = checks.iter().find(|c| c["name"] == "planarity").unwrap();
    assert_eq!(
        (&planarity["pass"], &planarity["ids"]),
        (&false.into(), &serde_json::json!([0]))
    );
    assert_eq!(&shop.read("bent.png")[..8], b"\x89PNG\r\n\x1a\n");

    assert_eq!(
        shop.phex("check bent.obj --planarity 0.1").code,
        Some(0),
        "in mean edges"
    );
    assert_eq!(
        shop.phex("check bent.obj --planarity 10%").code,
        Some(0),
        "of the mean edge"
    );
    assert_eq!(
        shop.phex("check bent.obj --planarity 1mm --unit m").code,
        Some(3)
    );
    assert_eq!(
        shop.phex("check bent.obj --planarity 1mm --unit mm").code,
        Some(0)
    );
}

#[test]
fn a_typed_planarity_is_held_far_from_the_origin_and_only_the_default_follows_rounding() {
    let shop = Workshop::new();
    // Coordinates of 1e10 are rounded to 2e-6, so that panels of edge 1 are planar to about that.
    let far = |_, [x, y, _]: [f64; 3]| [x + 1e10, y, 0.3 * (x + 1e10) + 0.7 * y];
    shop.write("far.obj", honeycomb(4, 5, far));
    let planarity = |run: &str| {
        let report: serde_json::Value = serde_json::from_str(run).unwrap();
        let checks = report["checks"].as_array().unwrap().clone();
        let check = checks.into_iter().find(|c| c["name"] == "planarity");
        check.unwrap()
    };
    let by_default = planarity(&shop.succeed("check far.obj --json").stdout);
    assert!(by_default["limit"].as_f64().unwrap() > 1e-6);

    let typed = shop.phex("check far.obj --planarity 1e-9 --json");
    assert_eq!(typed.code, Some(3), "{}{}", typed.stdout, typed.stderr);
    let typed = planarity(&typed.stdout);
    assert_eq!(
        (&typed["limit"], &typed["pass"]),
        (&1e-9.into(), &false.into())
    );
    assert!(!typed["ids"].as_array().unwrap().is_empty());
    let told = shop.phex("check far.obj --planarity 1e-9").stdout;
    assert!(told.contains("limit 1e-9"), "{told}");
}

#[test]
fn check_tells_a_self_intersecting_face_from_a_concave_one() {
    let shop = Workshop::new();
    // The corner that only the first panel holds.
    let moved = |d: f64| {
        honeycomb(4, 5, move |i, [x, y, z]| {
            [x, if i == 0 { y + d } else { y }, z]
        })
    };
    shop.write("concave.obj", moved(0.8));
    let run = shop.succeed("check concave.obj");
    assert!(run.stdout.contains("1 concave"), "{}", run.stdout);
    shop.write("crossed.obj", moved(2.5));
    let run = shop.phex("check crossed.obj --json");
    assert_eq!(run.code, Some(3));
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["verdict"], "invalid");
    let violations = report["violations"].as_array().unwrap();
    assert!(
        violations
            .iter()
            .any(|v| v["kind"] == "not_simple" && v["face"] == 0),
        "{violations:?}"
    );
}

#[test]
fn check_measures_the_distance_to_a_surface() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(4, 5, |_, p| p));
    shop.write(
        "plane.obj",
        "v -9 -9 0.1\nv 19 -9 0.1\nv 19 19 0.1\nv -9 19 0.1\nf 1 2 3 4\n",
    );
    assert_eq!(
        shop.phex("check mesh.obj --surface plane.obj --max-deviation 9cm")
            .code,
        Some(3)
    );
    let run = shop.phex("check mesh.obj --surface plane.obj --max-deviation 11cm --json");
    let report: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let check = report["checks"]
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["name"] == "deviation")
        .unwrap();
    assert_eq!(check["pass"], true);
    assert_eq!(report["inputs"].as_array().unwrap().len(), 2);
}

#[test]
fn check_leaves_out_unused_vertices_and_says_so() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(2, 2, |_, p| p) + "v 9 9 9\n");
    let run = shop.succeed("check mesh.obj");
    assert!(
        run.stderr.contains("1 vertex belongs to no face"),
        "{}",
        run.stderr
    );
    assert_eq!(shop.succeed("check mesh.obj --quiet").stderr, "");
}

/// A name that is no UTF-8 is one, on systems that allow it.
#[cfg(target_os = "linux")]
#[test]
fn reports_have_names_that_are_no_text() {
    use std::os::unix::ffi::OsStrExt;
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(2, 2, |_, p| p));
    let name = std::ffi::OsStr::from_bytes(b"bad\xff.html");
    let mut command = shop.command("check mesh.obj --html");
    assert!(command.arg(name).output().unwrap().status.success());
    let page = std::fs::read_to_string(shop.path("mesh.obj").with_file_name(name)).unwrap();
    assert!(page.contains("bad\u{fffd}.html"));
}

#[test]
fn figures_that_are_not_defined_are_said_in_words() {
    let shop = Workshop::new();
    shop.write("bow.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2 4\n");
    let run = shop.phex("check bow.obj");
    assert!(run.stdout.contains("cross themselves"), "{}", run.stdout);
    assert!(!run.stdout.contains("NaN"), "{}", run.stdout);
}

#[test]
fn a_mesh_that_is_nowhere_near_its_surface_is_told_so() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(4, 4, |_, p| p));
    let far = |_: usize, [x, y, z]: [f64; 3]| [x + 1e6, y, z];
    shop.write("far.obj", honeycomb(4, 4, far));
    let run = shop.phex("check mesh.obj --surface far.obj");
    assert!(
        run.stdout.contains("what helps: no number of panels"),
        "{}",
        run.stdout
    );
    assert!(
        !run.stdout.contains("if all shrink alike"),
        "{}",
        run.stdout
    );
}

#[test]
fn check_refuses_faces_that_are_no_manifold() {
    let shop = Workshop::new();
    shop.write(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n",
    );
    shop.phex("check a.obj")
        .refuses(4, &["a.obj", "0 and 1", "more than two faces: 0, 1 and 2"]);
}

#[test]
fn shape_is_written_described_and_converted_back_and_forth() {
    let shop = Workshop::new();
    assert!(shop.succeed("shape --list").stdout.contains("torus"));
    shop.succeed("shape torus -o torus.obj --triangles 2000 --set minor=0.3 --jitter 0.2 --seed 5");
    let info = shop.succeed("info torus.obj");
    assert!(info.stdout.contains("closed, genus 1"), "{}", info.stdout);
    let json: serde_json::Value =
        serde_json::from_str(&shop.succeed("info torus.obj --json").stdout).unwrap();
    assert_eq!(json["components"][0]["euler_characteristic"], 0);
    let area = 4.0 * std::f64::consts::PI.powi(2) * 0.3;
    assert!((json["area"].as_f64().unwrap() / area - 1.0).abs() < 0.03);

    shop.succeed("convert torus.obj a.ply");
    shop.succeed("convert a.ply b.off");
    shop.succeed("convert b.off c.obj");
    assert_eq!(
        shop.read("c.obj"),
        shop.read("torus.obj"),
        "nothing is lost on the way"
    );
}

#[test]
fn shape_is_the_same_for_the_same_seed() {
    let shop = Workshop::new();
    for (name, seed) in [("a.obj", 1), ("b.obj", 1), ("c.obj", 2)] {
        shop.succeed(&format!(
            "shape wave -o {name} --triangles 500 --jitter 0.3 --seed {seed}"
        ));
    }
    assert_eq!(shop.read("a.obj"), shop.read("b.obj"));
    assert_ne!(shop.read("a.obj"), shop.read("c.obj"));
    shop.phex("shape torus -o t.obj --set minor=7")
        .refuses(4, &["minor", "torus"]);
    shop.phex("shape torus -o t.obj --set colour=7")
        .refuses(4, &["colour", "major"]);
    shop.phex("shape torus -o t.obj --triangles 1")
        .refuses(4, &["1"]);
    assert!(!shop.files().contains(&"t.obj".to_owned()));
}

#[test]
fn info_says_what_is_wrong() {
    let shop = Workshop::new();
    shop.write(
        "two.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 7 7 7\nf 1 2 3\nf 4 5 6\n",
    );
    let run = shop.succeed("info two.obj");
    assert!(
        run.stdout.contains("components   2") && run.stdout.contains("1 vertex belongs to no face")
    );
    shop.write(
        "bad.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n",
    );
    let run = shop.phex("info bad.obj");
    assert_eq!(run.code, Some(4));
    assert!(
        run.stdout.contains("PROBLEM") && run.stdout.contains("more than two faces"),
        "{}",
        run.stdout
    );
    let place = "at (0, 0, 0), (1, 0, 0); vertices and faces are counted from 0";
    assert!(run.stdout.contains(place), "{}", run.stdout);
}

#[test]
fn output_goes_into_folders_that_do_not_exist_yet() {
    let shop = Workshop::new();
    shop.succeed("shape plane -o new/folder/plane.obj --triangles 200");
    assert!(crate::common::exists(&shop.path("new/folder/plane.obj")));
}

#[test]
fn render_draws_pixels_and_vectors() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 600");
    shop.succeed("render torus.obj -o a.png --color edge-length --view top --size 200x150");
    assert_eq!(&shop.read("a.png")[..8], b"\x89PNG\r\n\x1a\n");
    shop.succeed("render torus.obj -o a.svg --color curvature --surface torus.obj --size 200x150");
    let svg = String::from_utf8(shop.read("a.svg")).unwrap();
    assert!(
        svg.contains(" id=\"p") && svg.contains("<path d=\"M") && svg.contains("parabolic band")
    );
    shop.succeed("render torus.obj -o b.svg --color curvature --surface torus.obj --size 200x150");
    assert_eq!(shop.read("a.svg"), shop.read("b.svg"));
}

#[test]
fn render_refuses_what_it_can_not_draw() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 600");
    for (arguments, said) in [
        ("torus.obj -o a.png --color deviation", "--surface"),
        ("torus.obj -o a.gif", ".png or .svg"),
    ] {
        shop.phex(&format!("render {arguments}"))
            .refuses(4, &[said]);
    }
    assert_eq!(shop.files(), ["torus.obj"]);
}

#[test]
fn report_is_one_file_that_names_the_command() {
    let shop = Workshop::new();
    shop.write("flat.obj", honeycomb(4, 4, |_, p| p));
    let bent = |i: usize, [x, y, _]: [f64; 3]| [x, y, 0.1 * (i % 2) as f64];
    shop.write("bent.obj", honeycomb(4, 4, bent));
    let command = "report flat.obj --html flat.html --before bent.obj --unit mm";
    shop.succeed(command);
    let html = String::from_utf8(shop.read("flat.html")).unwrap();
    assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
    assert!(html.contains(&format!("<code>phex {command}</code>")));
    shop.phex("report flat.obj --html flat.obj")
        .refuses(4, &["flat.obj"]);
    shop.phex("report bent.obj --html bent.html")
        .refuses(3, &[]);
    // The limits of a job hold for the page as they do for a check.
    shop.succeed("report flat.obj --html flat.html -q");
    shop.write("job.toml", "[limits]\nmax-edge = 0.5\n");
    let judged = shop.phex("report flat.obj --html flat.html --limits job.toml");
    assert_eq!(judged.code, Some(3), "{}", judged.stderr);
    let html = String::from_utf8(shop.read("flat.html")).unwrap();
    assert!(html.contains("Outside tolerance") && html.contains("Longest edge"));
    std::fs::remove_file(shop.path("job.toml")).unwrap();
    assert_eq!(
        shop.files(),
        ["bent.html", "bent.obj", "flat.html", "flat.obj"]
    );
}

/// Sizes are told with the digits that mean something, and a unit that can't be right is doubted.
#[test]
fn info_tells_sizes_in_their_unit() {
    let shop = Workshop::new();
    shop.write("roof.obj", honeycomb(4, 4, |_, p| p.map(|x| 6000.0 * x)));
    let said = shop.succeed("info roof.obj --unit mm").stdout;
    assert!(said.contains("area         1496 m2"), "{said}");
    assert!(!said.contains("unit right"), "{said}");
    let said = shop.succeed("info roof.obj").stdout;
    assert!(
        said.contains("m across: is its unit right? (with --unit mm it is "),
        "{said}"
    );
    let run = shop.phex("mesh roof.obj -o out.obj --max-area 2 --unit mm");
    let told = ["max-area asks for", "mm across", "is the unit right"];
    run.refuses(4, &told);
    let said = shop.phex("mesh roof.obj -o out.obj --edge-length 1.2m");
    said.refuses(4, &["panels would be needed", "with --unit mm it is"]);
    for (command, doubts) in [
        ("mesh roof.obj -n 20 --effort draft -o out.obj", true),
        (
            "mesh roof.obj -n 20 --effort draft -o out.obj --unit mm",
            false,
        ),
        ("check roof.obj", true),
        ("check roof.obj --unit mm", false),
        ("offset roof.obj --distance 1mm -o layers", true),
        ("convert roof.obj out.glb", true),
        ("convert roof.obj out.ply", false),
    ] {
        let told = shop.phex(command).stderr;
        assert_eq!(
            told.contains("is its unit right"),
            doubts,
            "{command}: {told}"
        );
    }
    let run = shop.phex("offset roof.obj --distance 0 --solids -o layers");
    run.refuses(2, &["--distance 0 is the mesh itself", "--solids"]);
}

/// Every figure of the certificate names its worst element.
#[test]
fn check_certifies_each_figure_with_its_worst_element() {
    let shop = Workshop::new();
    // The corner that only the first panel holds is lifted, and pulled towards its neighbour.
    let bent = honeycomb(4, 5, |i, [x, y, z]| {
        if i == 0 {
            [x, y + 0.3, z + 0.1]
        } else {
            [x, y, z]
        }
    });
    shop.write("bent.obj", bent);
    let run = shop.phex("check bent.obj");
    assert_eq!(run.code, Some(3));
    let line = |label: &str| {
        let found = run.stdout.lines().find(|l| l.starts_with(label));
        found
            .unwrap_or_else(|| panic!("{label}: {}", run.stdout))
            .to_owned()
    };
    assert!(line("planarity").contains("(face 0)"), "{}", run.stdout);
    assert!(
        run.stdout
            .contains("mean diagonals, by their distance (face 0)"),
        "{}",
        run.stdout
    );
    assert!(
        line("clearance").contains("degrees (face"),
        "{}",
        run.stdout
    );
    assert!(line("edges").contains("(edge "), "{}", run.stdout);
    assert!(line("sound").contains("no flips"), "{}", run.stdout);
    // Turned over, the first panel is named among what is not sound.
    let crossed = honeycomb(
        4,
        5,
        |i, [x, y, z]| if i == 0 { [x, y + 2.5, z] } else { [x, y, z] },
    );
    shop.write("crossed.obj", crossed);
    let run = shop.phex("check crossed.obj");
    assert!(
        run.stdout.contains("simple       face 0 is NOT"),
        "{}",
        run.stdout
    );
}

#[test]
fn pictures_are_seen_from_a_side_and_over_a_range_of_one_s_choice() {
    let shop = Workshop::new();
    // Corners off their planes by thousandths of an edge: blank over the range that does for every
    // mesh.
    let bent = honeycomb(4, 5, |i, [x, y, z]| [x, y, z + 1e-3 * ((i * i) % 7) as f64]);
    shop.write("bent.obj", bent);
    let render = |name: &str, options: &str| {
        let line = format!("render bent.obj -o {name}.png --size 64x48 --no-legend {options}");
        shop.succeed(&line);
        shop.read(&format!("{name}.png"))
    };
    let front = render("front", "--azimuth -60 --elevation 20");
    assert_ne!(front, render("side", "--azimuth 30 --elevation 20"));
    assert_ne!(front, render("above", "--azimuth -60 --elevation 80"));
    let colours = |options: &str| render("colours", &format!("--color dihedral {options}"));
    assert_ne!(colours(""), colours("--range fixed"));
    assert_eq!(colours("--range fixed"), colours("--range 160,200"));
    shop.write("marks.txt", "0 1\n3 2 # a neighbour\n");
    assert_ne!(render("plain", ""), render("marked", "--mark marks.txt"));

    let refuse = |options: &str, code: i32, text: &str| {
        let run = shop.phex(&format!("render bent.obj -o no.png {options}"));
        run.refuses(code, &[text]);
    };
    refuse("--color dihedral --range 2,1", 2, "LOW below HIGH");
    refuse("--range 0,1", 4, "classes");
    refuse("--color planarity --range 0,1", 4, "logarithmic");
    shop.write("wrong.txt", "0 1\n99 1\n");
    refuse("--mark wrong.txt", 4, "wrong.txt:2");
    assert!(!shop.files().contains(&"no.png".to_owned()));
}

#[test]
fn words_of_the_tables_are_explained() {
    let shop = Workshop::new();
    for line in ["terms", "help terms"] {
        let said = shop.succeed(line).stdout;
        for word in ["anisotropy", "without need", "clearance", "back", "verdict"] {
            let explained = said.lines().any(|l| l.starts_with(word));
            assert!(explained, "{line}: {word}");
        }
    }
}

/// A plane of unit squares over the honeycomb and `margin` beyond it, with `lift` at the vertex in
/// its middle.
fn plane(margin: i32, lift: f64) -> String {
    let (low, high) = (-margin, 8 + margin);
    let side = high - low + 1;
    let places = (0..side * side).map(|v| (low + v % side, low + v / side));
    let vertex = |(x, y): (i32, i32)| {
        let z = if (x, y) == (4, 4) { lift } else { 0.0 };
        format!("v {x} {y} {z}\n")
    };
    let vertices: String = places.map(vertex).collect();
    let cells = (0..side * side).filter(|v| v % side + 1 < side && v / side + 1 < side);
    let face = |v: i32| {
        let (a, b) = (v + 1, v + 1 + side);
        format!("f {a} {} {b}\nf {} {} {b}\n", a + 1, a + 1, b + 1)
    };
    vertices + &cells.map(face).collect::<String>()
}

/// The check of a name in a report.
fn check_of(report: &serde_json::Value, name: &str) -> serde_json::Value {
    let checks = report["checks"].as_array().unwrap();
    let check = checks.iter().find(|c| c["name"] == name);
    check.unwrap_or_else(|| panic!("no {name}")).clone()
}

#[test]
fn failures_at_the_boundary_and_of_the_coverage_name_panels_and_a_place() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(6, 5, |_, p| p));
    shop.write("plane.obj", plane(3, 5.0));
    let run = shop.phex("check mesh.obj --surface plane.obj --boundary snap --report run.json");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    let report = shop.json("run.json");
    for name in ["coverage_inner", "boundary", "covered_area"] {
        let check = check_of(&report, name);
        assert_eq!(check["pass"], false, "{check}");
        assert!(!check["ids"].as_array().unwrap().is_empty(), "{check}");
        assert_eq!(check["element"], "face", "{check}");
        assert_eq!(check["place"].as_array().unwrap().len(), 3, "{check}");
        assert!(check["advice"].is_string(), "{check}");
    }
    assert_eq!(
        check_of(&report, "coverage_inner")["place"],
        serde_json::json!([4.0, 4.0, 5.0])
    );
    let far = check_of(&report, "boundary")["place"][0].as_f64().unwrap();
    assert!(
        far == -3.0 || far == 11.0,
        "a corner of the plane, not {far}"
    );
    assert!(
        run.stdout.contains("FAILED       covered_area") && run.stdout.contains("worst at ("),
        "{}",
        run.stdout
    );
}

#[test]
fn check_says_what_it_could_not_check() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(6, 5, |_, p| p));
    shop.write("plane.obj", plane(0, 0.0));
    let run = shop.succeed("check mesh.obj");
    let all = "same_topology, deviation, coverage_inner, boundary, covered_area";
    assert!(
        run.stdout
            .contains(&format!("not checked  {all}: there is no surface")),
        "{}",
        run.stdout
    );
    let run = shop.phex("check mesh.obj --surface plane.obj --boundary whole");
    assert!(
        run.stdout
            .contains("not checked  boundary: panels are left whole"),
        "{}",
        run.stdout
    );
    let run = shop.phex("check mesh.obj --surface plane.obj --report run.json");
    assert!(
        run.stdout.contains("not checked  boundary, covered_area")
            && run.stdout.contains("--report-of"),
        "{}",
        run.stdout
    );
    let left_out = &shop.json("run.json")["not_checked"];
    assert_eq!(left_out[0]["name"], "boundary");
    assert_eq!(left_out[0]["reason"], "no_limit");
    let run = shop.phex("check mesh.obj --surface plane.obj --boundary clip");
    assert!(!run.stdout.contains("not checked"), "{}", run.stdout);
}

#[test]
fn a_limit_in_millimetres_is_told_in_millimetres() {
    let shop = Workshop::new();
    shop.write("mesh.obj", honeycomb(6, 5, |_, p| p));
    shop.write("plane.obj", plane(3, 0.0).replace(" 0\n", " 0.1\n"));
    let run =
        shop.phex("check mesh.obj --surface plane.obj --max-deviation 90mm --report run.json");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("deviation: 100 mm, limit 90 mm") && run.stdout.contains("max 100 mm"),
        "{}",
        run.stdout
    );
    let check = check_of(&shop.json("run.json"), "deviation");
    let reading = &check["reading"];
    assert_eq!(
        (&reading["unit"], &reading["limit"]),
        (&"mm".into(), &90.0.into())
    );
    assert!((reading["value"].as_f64().unwrap() - 100.0).abs() < 1e-9);
    assert!(
        (check["limit_length"].as_f64().unwrap() - 0.09).abs() < 1e-12,
        "metres"
    );
}

#[test]
fn tiny_and_large_inner_panels_are_listed() {
    let shop = Workshop::new();
    let grid = |places: [f64; 4]| {
        let row = |y: &f64| places.map(|x| format!("v {x} {y} 0\n"));
        let faces = [1, 2, 3, 5, 6, 7, 9, 10, 11];
        let faces = faces.map(|a| format!("f {a} {} {} {}\n", a + 1, a + 5, a + 4));
        shop.write(
            "mesh.obj",
            places.iter().flat_map(row).collect::<String>() + &faces.concat(),
        );
    };
    grid([0.0, 0.5, 2.5, 3.0]);
    let told = shop.phex("check mesh.obj").stdout;
    assert!(told.contains("above 3: 1 (faces 4)"), "{told}");
    grid([0.0, 1.4, 1.6, 3.0]);
    let run = shop.phex("check mesh.obj --report run.json");
    assert!(
        run.stdout.contains("below 0.25: 1 (faces 4)") && !run.stdout.contains("above"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("from 0.04 (face 4)"), "{}", run.stdout);
    let small = &shop.json("run.json")["measures"]["small_faces"];
    assert_eq!(small, &serde_json::json!([4]));
}

/// Formats that demand metres have them, whatever the unit of the model.
#[test]
fn glb_and_3mf_are_in_metres() {
    let shop = Workshop::new();
    shop.write("h.obj", honeycomb(3, 4, |_, p| p.map(|x| 1000.0 * x)));
    let largest = |unit: &str| {
        shop.succeed(&format!("convert h.obj h.glb --unit {unit}"));
        let file = shop.read("h.glb");
        let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        let text: serde_json::Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
        let largest = text["accessors"].as_array().unwrap().iter();
        let largest = largest.filter_map(|a| a["max"][0].as_f64());
        largest.fold(0.0, f64::max)
    };
    let [metres, millimetres] = ["m", "mm"].map(largest);
    assert!(
        (metres / millimetres - 1000.0).abs() < 0.01,
        "{metres} {millimetres}"
    );
}

/// A symmetry that a surface does not have is no fault of the program.
#[test]
fn a_symmetry_that_is_not_there_is_refused_by_name() {
    let shop = Workshop::new();
    shop.succeed("shape b-spline -o s.obj --triangles 1000");
    shop.phex("mesh s.obj -n 40 --symmetry mirror -o m.obj")
        .refuses(4, &["symmetry `mirror`", "no mirror plane"]);
    assert_eq!(shop.files(), ["s.obj"]);
}
