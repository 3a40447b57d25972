//! `phex mesh` and `phex planarize` from file to file.
use crate::common::{Run, Workshop, honeycomb};
use phex_mesh::HexMesh;
use phex_mesh::io::read_soup;

/// A shallow dome of 200 panels at the most, in an own folder.
fn dome() -> Workshop {
    let shop = Workshop::new();
    shop.succeed("shape elliptic-paraboloid -o dome.obj --triangles 1500");
    shop
}

#[test]
fn surface_becomes_a_mesh_that_check_passes() {
    let shop = dome();
    let run = shop.succeed(
        "mesh dome.obj -o out/dome.obj -n 80 --report run.json --png dome.png --html dome.html --write-target smooth.ply --progress json",
    );
    assert!(run.stdout.contains("PASS"), "{}", run.stdout);
    let events: Vec<serde_json::Value> = run
        .stderr
        .lines()
        .map(|line| serde_json::from_str(line).expect("a JSON object a line"))
        .collect();
    assert!(
        events
            .iter()
            .any(|e| e["event"] == "stage_finished" && e["stage"] == "optimise")
    );

    let report = shop.json("run.json");
    assert_eq!(report["verdict"], "pass");
    assert_eq!(report["inputs"][0]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(report["settings"]["panels"], 80);
    assert_eq!(report["outputs"].as_array().unwrap().len(), 5);
    assert!(report["measures"]["planarity"]["max"].as_f64().unwrap() <= 1e-12);
    assert!(
        report["deviation_smooth"]["deviation_max"]
            .as_f64()
            .unwrap()
            <= 0.005
    );
    let panels = report["measures"]["faces"].as_f64().unwrap();
    assert!((panels / 80.0 - 1.0).abs() <= 0.15, "{panels} panels");

    shop.succeed("check out/dome.obj --surface smooth.ply");
    shop.succeed("check out/dome.obj --surface dome.obj --max-deviation 1%");
}

/// Rows of triangles of which every second one is moved by half of one: two sides are zigzags.
fn toothed() -> String {
    let n = 24;
    let corner = |k: usize| {
        let (row, x) = (k / n, (k % n) as f64 + 0.5 * (k / n % 2) as f64);
        let y = row as f64 * 0.75_f64.sqrt();
        let z = ((x - 12.0).powi(2) + (y - 10.0).powi(2)) / 120.0;
        format!("v {x} {y} {z}\n")
    };
    let faces = (0..n * n).filter(|k| k % n < n - 1 && k / n < n - 1);
    let halves = |k: usize| {
        let [a, b, c, d] = [k + 1, k + 2, k + n + 1, k + n + 2];
        match k / n % 2 {
            0 => format!("f {a} {b} {c}\nf {b} {d} {c}\n"),
            _ => format!("f {a} {b} {d}\nf {a} {d} {c}\n"),
        }
    };
    (0..n * n).map(corner).chain(faces.map(halves)).collect()
}

/// What is noted on the way stands in the report, too.
#[test]
fn the_report_has_the_notes_of_the_run() {
    let shop = Workshop::new();
    shop.write("teeth.obj", toothed());
    let run = shop.phex("mesh teeth.obj -n 60 --effort draft -o out.obj --report run.json");
    assert!(
        run.stderr.contains("the boundary has teeth"),
        "{}",
        run.stderr
    );
    let notes = shop.json("run.json")["notes"].to_string();
    assert!(notes.contains("the boundary has teeth"), "{notes}");
}

#[test]
fn an_edge_length_is_met() {
    let shop = dome();
    for edge in [0.12, 0.2] {
        shop.succeed(&format!(
            "mesh dome.obj -o out.obj --edge-length {edge} --max-deviation 2% -q"
        ));
        let soup = read_soup(&shop.path("out.obj")).unwrap();
        let mesh = HexMesh::new(soup.positions, &soup.faces).unwrap();
        let ratio = mesh.mean_inner_edge() / edge;
        assert!((ratio - 1.0).abs() < 0.05, "{edge}: {ratio}");
    }
}

/// What the stages were asked for is in the report, and what was typed is never farther off than
/// what is usual.
#[test]
fn a_tighter_deviation_is_aimed_at_and_reported() {
    let shop = dome();
    let run = |limit: &str| {
        shop.phex(&format!(
            "mesh dome.obj -o out.obj -n 40 --report run.json -q {limit}"
        ));
        let report = shop.json("run.json");
        let aim = report["settings"]["stages"]["optimise"]["max_deviation"].as_f64();
        let deviation = report["deviation_smooth"].clone();
        let reached =
            ["deviation_max", "coverage_inner_max"].map(|k| deviation[k].as_f64().unwrap());
        (
            aim.expect("the limit of the stages"),
            reached[0].max(reached[1]),
        )
    };
    let (usual, reached) = run("");
    assert!((usual - 0.005).abs() < 1e-9, "{usual}");
    let (tight, nearer) = run("--max-deviation 0.05%");
    assert!((tight - 0.0005).abs() < 1e-9, "{tight}");
    assert!(nearer <= reached * (1.0 + 1e-9), "{nearer} {reached}");
}

#[test]
fn progress_is_of_the_whole_run_and_never_goes_back() {
    let shop = dome();
    let run = shop.succeed("mesh dome.obj -o out.obj -n 80 --progress json");
    let lines = run.stderr.lines();
    let events: Vec<serde_json::Value> =
        lines.filter_map(|l| serde_json::from_str(l).ok()).collect();
    let of_run = events.iter().filter(|e| e["event"] == "progress");
    let done: Vec<f64> = of_run
        .clone()
        .map(|e| e["done"].as_f64().unwrap())
        .collect();
    assert!(done.len() > 5 && done.is_sorted(), "{done:?}");
    assert_eq!(done.last(), Some(&1.0));
    assert!(
        of_run
            .clone()
            .all(|e| e["left_seconds"].as_f64().unwrap() >= 0.0)
    );
}

#[test]
fn a_time_limit_without_a_mesh_says_so() {
    let shop = dome();
    shop.phex("mesh dome.obj -o out.obj -n 80 --time-limit 0.0001s")
        .refuses(5, &["no mesh was reached within 0.0001 s"]);
    assert!(!shop.path("out.obj").exists());
    shop.phex("mesh dome.obj -o out.obj --time-limit soon")
        .refuses(2, &["is no time"]);
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let shop = dome();
    shop.succeed("mesh dome.obj -o one.obj -n 60 -t 1");
    shop.succeed("mesh dome.obj -o two.obj -n 60 -t 2");
    assert_eq!(shop.read("one.obj"), shop.read("two.obj"));
}

#[test]
fn job_file_and_command_line_give_the_same_mesh() {
    let shop = dome();
    shop.write(
        "job.toml",
        "panels = 60\nrotate = 30\nmax-deviation = '2%'\n[stages.optimise]\nfairness = 0.002\n",
    );
    shop.succeed("mesh dome.obj -o file.obj --config job.toml --report file.json");
    let settings = &shop.json("file.json")["settings"];
    assert_eq!(settings["max-deviation"], "2%");
    assert_eq!(settings["stages"]["optimise"]["fairness"], 0.002);
    shop.write(
        "stages.toml",
        "panels = 9\n[stages.optimise]\nfairness = 0.002\n",
    );
    shop.succeed(
        "mesh dome.obj -o line.obj --config stages.toml -n 60 --rotate 30 --max-deviation 2%",
    );
    assert_eq!(shop.read("file.obj"), shop.read("line.obj"));
}

#[test]
fn unreachable_tolerance_is_written_with_exit_code_3_and_offenders() {
    let shop = dome();
    let run = shop.phex("mesh dome.obj -o out.obj -n 60 --max-deviation 0.0001% --report run.json");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("FAILED       deviation"),
        "{}",
        run.stdout
    );
    let report = shop.json("run.json");
    let check = report["checks"]
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["name"] == "deviation")
        .unwrap();
    assert!(!check["ids"].as_array().unwrap().is_empty());
    assert!(shop.files().contains(&"out.obj".to_owned()));
}

#[test]
fn invalid_mesh_is_reported_and_written_only_on_request() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 1000");
    let run = shop.phex("mesh torus.obj -o out.obj -n 4 --report run.json");
    assert_eq!(run.code, Some(5), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("INVALID") && run.stdout.contains("NOT WRITTEN"),
        "{}",
        run.stdout
    );
    assert!(!shop.files().contains(&"out.obj".to_owned()));
    let report = shop.json("run.json");
    assert_ne!(report["verdict"], "pass");
    assert!(!report["violations"].as_array().unwrap().is_empty());
    assert_eq!(
        shop.phex("mesh torus.obj -o out.obj -n 4 --keep-invalid")
            .code,
        Some(5)
    );
    assert!(shop.files().contains(&"out.obj".to_owned()));
}

#[test]
fn components_are_meshed_together_on_request() {
    let shop = dome();
    let text = String::from_utf8(shop.read("dome.obj")).unwrap();
    let vertices = text.lines().filter(|l| l.starts_with("v ")).count();
    let mut twice = text.clone();
    for line in text.lines() {
        let numbers: Vec<&str> = line.split_whitespace().skip(1).collect();
        if line.starts_with("v ") {
            let x: f64 = numbers[0].parse().unwrap();
            twice += &format!("v {} {} {}\n", x + 9.0, numbers[1], numbers[2]);
        } else if line.starts_with("f ") {
            let shifted = numbers
                .iter()
                .map(|n| format!(" {}", n.parse::<usize>().unwrap() + vertices));
            twice += &format!("f{}\n", shifted.collect::<String>());
        }
    }
    shop.write("two.obj", twice);
    shop.phex("mesh two.obj -o out.obj -n 120")
        .refuses(4, &["2 connected parts"]);
    shop.succeed("mesh two.obj -o out.obj -n 120 --all-components --report run.json");
    let report = shop.json("run.json");
    assert_eq!(report["measures"]["components"], 2);
    let panels = report["measures"]["faces"].as_f64().unwrap();
    assert!((panels / 120.0 - 1.0).abs() <= 0.15, "{panels} panels");
}

/// A part that can't be covered is named, with its size and its share of the panels.
#[test]
fn an_error_says_of_which_part_it_is() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj");
    shop.succeed("shape torus -o torus.obj --triangles 1000");
    let text = |name: &str| String::from_utf8(shop.read(name)).unwrap();
    let vertices = text("wave.obj")
        .lines()
        .filter(|l| l.starts_with("v "))
        .count();
    let moved = text("torus.obj")
        .lines()
        .map(|line| {
            let mut words = line.split(' ');
            let kind = words.next().unwrap();
            let words = words.map(|word| match kind {
                "v" => (9.0 + 0.01 * word.parse::<f64>().unwrap()).to_string(),
                "f" => (vertices + word.parse::<usize>().unwrap()).to_string(),
                _ => String::new(),
            });
            format!("{kind} {}\n", words.collect::<Vec<_>>().join(" "))
        })
        .filter(|line| line.starts_with(['v', 'f']))
        .collect::<String>();
    shop.write("two.obj", format!("{}{moved}", text("wave.obj")));
    shop.phex("mesh two.obj -o out.obj -n 60 --effort draft --all-components")
        .refuses(5, &["part 2 of 2 (0.0403 m across, 1 of the panels): "]);
}

/// A scan leaves crumbs behind: they are no part of what is to be covered.
#[test]
fn crumbs_beside_a_surface_are_left_out_and_told() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj");
    let text = |name: &str| String::from_utf8(shop.read(name)).unwrap();
    let wave = text("wave.obj");
    let vertices = wave.lines().filter(|l| l.starts_with("v ")).count();
    let [a, b, c] = [1, 2, 3].map(|k| vertices + k);
    let crumb = format!("v 9 0 0\nv 9.01 0 0\nv 9 0.01 0\nf {a} {b} {c}\n");
    shop.write("scan.obj", format!("{wave}{crumb}"));
    let told =
        shop.succeed("mesh scan.obj -o scan-phex.obj -n 60 --effort draft --report run.json");
    shop.succeed("mesh wave.obj -o wave-phex.obj -n 60 --effort draft");
    assert!(
        told.stderr.contains("(parts: 1, their triangles: 1)"),
        "{}",
        told.stderr
    );
    assert_eq!(shop.json("run.json")["measures"]["components"], 1);
    let panels = ["scan-phex.obj", "wave-phex.obj"].map(|name| {
        let lines = text(name);
        let lines = lines.lines().filter(|l| !l.starts_with('#'));
        lines.map(str::to_owned).collect::<Vec<String>>()
    });
    assert_eq!(panels[0], panels[1]);
}

/// A honeycomb on an egg-crate, whose panels have to slide.
fn egg_crate() -> String {
    let height = |x: f64, y: f64| 0.9 * (x / 2.4).sin() + 0.6 * (y / 2.4).sin();
    honeycomb(10, 9, |_, [x, y, _]| [x, y, height(x, y)])
}

#[test]
fn a_bound_on_the_deviation_is_kept_to_or_missed_and_said() {
    let shop = Workshop::new();
    shop.write("bent.obj", egg_crate());
    let deviation = |report: &str| {
        let deviation = &shop.json(report)["deviation_facets"]["deviation_max"];
        deviation.as_f64().unwrap()
    };
    shop.succeed("planarize bent.obj -o flat.obj --max-deviation 5% --report free.json");
    let free = deviation("free.json");
    let bound = |share: f64| {
        let percent = 100.0 * share * free;
        shop.phex(&format!(
            "planarize bent.obj -o near.obj --max-deviation {percent}% --report near.json"
        ))
    };
    // What the surface has between vertices is judged besides, by the same limit.
    let held = bound(0.75);
    let misses = |told: &str| told.contains("FAILED       deviation");
    assert!(!misses(&held.stdout), "{}{}", held.stdout, held.stderr);
    assert!(deviation("near.json") <= 0.75 * free);
    shop.succeed("check near.obj");
    let missed = bound(0.02);
    assert_eq!(missed.code, Some(3), "{}{}", missed.stdout, missed.stderr);
    let told = &missed.stdout;
    assert!(misses(told) && told.contains("faces "), "{told}");
    assert!(deviation("near.json") < free);
}

#[test]
fn a_tolerance_of_planarity_is_held_and_nothing_else_is_given_up_for_less_than_rounding() {
    let shop = Workshop::new();
    shop.write("bent.obj", egg_crate());
    let run = |planarity: &str, code: i32| {
        let run = shop.phex(&format!("planarize bent.obj -o {planarity}.obj --planarity {planarity} --max-deviation 5% --report {planarity}.json"));
        assert_eq!(run.code, Some(code), "{}{}", run.stdout, run.stderr);
        let report = shop.json(&format!("{planarity}.json"));
        (
            report["measures"]["planarity"]["max"].as_f64().unwrap(),
            report["deviation_facets"]["deviation_max"]
                .as_f64()
                .unwrap(),
        )
    };
    let (loose, near) = run("1e-4", 0);
    let (tight, as_near) = run("1e-19", 3);
    assert!(loose <= 1e-4 && tight <= 1e-13, "{loose:e} {tight:e}");
    assert!(as_near <= 1.01 * near, "{as_near} {near}");
    // What is not planar enough is refused.
    let run = shop.phex("check bent.obj --planarity 1mm --unit m");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(
        run.stdout.contains("FAILED       planarity"),
        "{}",
        run.stdout
    );
}

#[test]
fn planarize_flattens_a_bent_honeycomb() {
    let shop = Workshop::new();
    shop.write(
        "bent.obj",
        honeycomb(6, 6, |_, [x, y, _]| [x, y, 0.02 * (x * x + 0.7 * y * y)]),
    );
    assert_eq!(shop.phex("check bent.obj").code, Some(3));
    shop.succeed("planarize bent.obj -o flat.obj --max-deviation 1% --report run.json");
    assert_eq!(shop.json("run.json")["verdict"], "pass");
    shop.succeed("check flat.obj --surface bent.obj --max-deviation 1%");
}

#[test]
fn check_judges_by_what_the_run_promised() {
    let shop = dome();
    shop.succeed("mesh dome.obj -o whole.obj -n 60 --boundary whole --report whole.json --write-target smooth.ply");
    let by_facets = shop.phex("check whole.obj --surface dome.obj");
    assert_eq!(
        by_facets.code,
        Some(3),
        "panels stick out: {}",
        by_facets.stdout
    );
    let again = shop.succeed("check whole.obj --report-of whole.json --report again.json");
    let left_out = again.stdout.split("not checked  ").skip(1);
    let left_out: Vec<&str> = left_out.filter_map(|text| text.lines().next()).collect();
    let expected = "boundary: panels are left whole at the boundary and may stick out";
    assert_eq!(left_out, [expected], "{}", again.stdout);
    let figure = |report: &str, name: &str| {
        let report = shop.json(report);
        let checks = report["checks"].as_array().unwrap();
        let check = checks.iter().find(|c| c["name"] == name).unwrap();
        check["value"].as_f64().unwrap()
    };
    for name in ["covered_area", "coverage_inner"] {
        let [first, second] = ["whole.json", "again.json"].map(|r| figure(r, name));
        assert!(
            (first / second - 1.0).abs() < 1e-6,
            "{name}: {first} {second}"
        );
    }
    shop.succeed("check whole.obj --surface dome.obj --boundary whole --max-deviation 1%");

    // A limit that the run missed is missed again, without being typed.
    let run =
        shop.phex("mesh dome.obj -o near.obj -n 60 --max-deviation 0.0001% --report near.json");
    assert_eq!(run.code, Some(3));
    let again = shop.phex("check near.obj --report-of near.json");
    assert_eq!(again.code, Some(3), "{}{}", again.stdout, again.stderr);
    assert!(
        again.stdout.contains("limit 1e-4 %") && again.stdout.contains("deviation_smooth"),
        "{}",
        again.stdout
    );
    shop.write("no.json", "{}");
    shop.phex("check near.obj --report-of no.json")
        .refuses(4, &["no.json", "no run report"]);
    shop.write("dome.obj", honeycomb(2, 2, |_, p| p));
    shop.phex("check near.obj --report-of near.json")
        .refuses(4, &["dome.obj", "changed", "--surface"]);
}

/// A file of the same name in the folder where `check` runs is not the one that the report means.
#[test]
fn the_files_of_a_report_are_looked_for_where_it_lies() {
    let shop = dome();
    shop.succeed("mesh dome.obj -o a.obj -n 60 --report run.json --write-target smooth.obj");
    shop.write("b/dome.obj", honeycomb(2, 2, |_, p| p));
    shop.write("b/smooth.obj", honeycomb(2, 2, |_, p| p));
    let check = |arguments: &str, folder: &str| -> Run {
        let mut command = shop.command(arguments);
        command.current_dir(shop.path(folder));
        command.output().unwrap().into()
    };
    let there = check("check ../a.obj --report-of ../run.json", "b");
    assert_eq!(there.code, Some(0), "{}{}", there.stdout, there.stderr);
    let here = check("check a.obj --report-of run.json", ".").stdout;
    let deviation = |told: &str| {
        let line = told.lines().find(|line| line.starts_with("deviation"));
        line.unwrap().to_owned()
    };
    assert_eq!(deviation(&there.stdout), deviation(&here));
    // The report lies below the folder of the run, and another surface beside it.
    shop.write("b/run.json", shop.read("run.json"));
    shop.succeed("check a.obj --report-of b/run.json");
    shop.write("smooth.obj", honeycomb(2, 2, |_, p| p));
    let changed = check("check a.obj --report-of run.json", ".");
    changed.refuses(4, &["smooth.obj", "changed", "--surface"]);
}

/// A draft is judged as any mesh is, and the report says how much was tried.
#[test]
fn effort_says_how_much_is_tried() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj --triangles 2000");
    shop.succeed("mesh wave.obj -o a.obj -n 60 --effort draft --report draft.json");
    let draft = shop.json("draft.json");
    assert_eq!(draft["settings"]["effort"], "draft");
    assert!(draft["statistics"][0]["search"].is_null());
    assert_eq!(draft["verdict"], "pass");
    shop.succeed("mesh wave.obj -o b.obj -n 60 --effort best --report best.json");
    shop.succeed("mesh wave.obj -o c.obj -n 60 --method best");
    assert_eq!(shop.read("b.obj"), shop.read("c.obj"));
    let tried = &shop.json("best.json")["statistics"][0]["tried"];
    assert!(tried.as_array().unwrap().len() > 3);
    shop.phex("mesh wave.obj -o d.obj --effort draft --method brick-wall")
        .refuses(4, &["`effort` has no effect with `brick-wall`"]);
    shop.phex("mesh wave.obj -o d.obj --effort draft --method best")
        .refuses(4, &["`effort` has no effect with `best`"]);
}

/// The layout alone is written, and called neither planar nor valid.
#[test]
fn a_run_may_end_after_the_layout() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj --triangles 2000");
    let told = shop.succeed("mesh wave.obj -o flat.obj -n 60 --until layout --report run.json");
    let row = format!("{:<12} ", "layout");
    assert!(told.stdout.contains(&row), "{}", told.stdout);
    assert!(
        told.stdout.contains("neither planar nor checked"),
        "{}",
        told.stdout
    );
    assert!(!told.stdout.contains("PASS"), "{}", told.stdout);
    let report = shop.json("run.json");
    assert_ne!(report["verdict"], "pass");
    shop.phex("check flat.obj").refuses(3, &[]);
    shop.succeed("mesh wave.obj -o wall.obj -n 60 --until layout --method brick-wall");
    shop.phex("mesh wave.obj -o no.obj -n 60 --until layout --method best")
        .refuses(4, &["`method best` has no effect with `until layout`"]);
    shop.phex("mesh wave.obj -o no.obj --until layout --method tangent-planes")
        .refuses(4, &["only `lattice` and `brick-wall`"]);
    shop.phex(
        "mesh wave.obj -o no.obj -n 60 --until layout --repeat 5mm --max-edge 2 --min-angle 30",
    )
    .refuses(
        4,
        &["`repeat`, `max-edge`, `min-angle` have no effect with `until layout`"],
    );
    shop.phex("mesh wave.obj -o no.obj -n 60 --until layout --symmetry 4 --ground --fairness 2 --time-limit 5s")
        .refuses(
            4,
            &["`symmetry`, `ground`, `fairness`, `time-limit` have no effect with `until layout`"],
        );
    shop.phex("mesh wave.obj -o no.obj --until layout --keep-invalid")
        .refuses(2, &["--keep-invalid"]);
}
