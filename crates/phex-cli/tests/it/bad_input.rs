//! Bad input ends with exit code 4, a message that names element and cause, and no output file
//! touched.
use crate::common::Workshop;

/// Runs `phex mesh` on a file and expects a refusal that leaves everything as it was.
fn refused(name: &str, content: impl AsRef<[u8]>, texts: &[&str]) {
    let shop = Workshop::new();
    shop.write(name, content);
    refused_as_is(
        &shop,
        &format!("mesh {name} -o out.obj --report run.json --png out.png"),
        texts,
    );
}

fn refused_as_is(shop: &Workshop, arguments: &str, texts: &[&str]) {
    shop.write("out.obj", "precious");
    let before = shop.files();
    let run = shop.phex(arguments);
    run.refuses(4, texts);
    assert_eq!(run.stdout, "", "results only on standard output");
    assert_eq!(shop.files(), before, "no file comes or goes");
    assert_eq!(shop.read("out.obj"), b"precious", "an existing file stays");
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

fn with_square(name: &str) -> Workshop {
    let shop = Workshop::new();
    shop.write(name, SQUARE);
    shop
}

#[test]
fn empty_file() {
    for name in ["a.obj", "a.ply", "a.stl", "a.off"] {
        refused(name, "", &[name, "empty"]);
    }
}

#[test]
fn text_that_is_no_mesh() {
    refused(
        "letter.obj",
        "Dear reader,\nthis is a letter.\n",
        &["letter.obj"],
    );
    refused(
        "letter.off",
        "Dear reader,\nthis is a letter.\n",
        &["letter.off", "Dear"],
    );
    refused(
        "letter.ply",
        "Dear reader,\nthis is a letter.\n",
        &["letter.ply", "Dear"],
    );
    refused(
        "letter.stl",
        "Dear reader,\nthis is a letter.\n",
        &["letter.stl"],
    );
}

#[test]
fn coordinates_that_are_not_finite() {
    for bad in ["nan", "inf", "-inf", "1e999"] {
        let content = SQUARE.replacen("v 1 1 0", &format!("v 1 {bad} 0"), 1);
        refused("a.obj", content, &["a.obj", "line 3", bad, "finite"]);
    }
}

#[test]
fn vertex_numbers_that_do_not_exist() {
    for (bad, texts) in [
        ("0", vec!["line 5", "vertex 0"]),
        ("-9", vec!["line 5", "-9"]),
        ("5", vec!["line 5", "vertex 5", "4 vertices"]),
        ("99999999999999999999", vec!["line 5", "4 vertices"]),
    ] {
        refused(
            "a.obj",
            SQUARE.replacen("f 1 2 3", &format!("f {bad} 2 3"), 1),
            &texts,
        );
    }
}

#[test]
fn face_with_a_repeated_vertex() {
    refused(
        "a.obj",
        format!("{SQUARE}v 2 1 0\nv 2 2 0\nf 3 5 6 3 2\n"),
        &["face 2", "vertex 2", "more than once"],
    );
}

/// The same triangles twice, with vertices of their own as a pasted object has, are there once.
#[test]
fn triangles_that_are_there_twice() {
    let shop = Workshop::new();
    let [once, again] = ["f 1 2 3\nf 1 3 4\n", "f 5 6 7\nf 5 7 8\n"];
    let corners = SQUARE.replace(once, "");
    shop.write("a.obj", format!("{corners}{corners}{once}{again}"));
    let run = shop.phex("mesh a.obj -n 20 -o out.obj");
    run.ends_well("a square that is there twice");
    let told = "2 faces are there twice and were left out";
    assert!(run.stderr.contains(told), "{}", run.stderr);
}

#[test]
fn triangles_without_area_on_one_another() {
    refused(
        "a.obj",
        format!("{SQUARE}v 2 0 0\nv 3 0 0\nv 2.4 0 0\nv 2.6 0 0\nf 5 6 7\nf 6 5 8\n"),
        &["without area", "2, 3"],
    );
}

#[test]
fn edge_with_three_faces() {
    refused(
        "a.obj",
        format!("{SQUARE}v 0 0 1\nf 1 3 5\n"),
        &["edge", "0 and 2", "more than two faces"],
    );
}

#[test]
fn bow_tie_vertex() {
    refused(
        "a.obj",
        format!("{SQUARE}v 2 1 0\nv 2 2 0\nf 3 5 6\n"),
        &["vertex 2", "bow-tie"],
    );
}

#[test]
fn moebius_strip() {
    let n = 12;
    let mut text = String::new();
    for i in 0..n {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        let (tilt_sin, tilt_cos) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
        for side in [-0.3, 0.3] {
            let r = 1.0 + side * tilt_cos;
            text += &format!("v {} {} {}\n", r * cos, r * sin, side * tilt_sin);
        }
    }
    for i in 0..n {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (2, 1) };
        text += &format!("f {a} {c} {d} {b}\n");
    }
    refused("a.obj", text, &["one-sided", "faces"]);
}

#[test]
fn two_components_are_said_and_meshed_only_on_request() {
    let far = "v 5 0 0\nv 6 0 0\nv 6 1 0\nf 5 6 7\n";
    refused(
        "a.obj",
        format!("{SQUARE}{far}"),
        &["2 connected parts", "2, 1 triangles", "--all-components"],
    );
}

#[test]
fn paths_that_can_not_be_read() {
    let shop = with_square("a.obj");
    refused_as_is(
        &shop,
        "mesh missing.obj -o out.obj",
        &["missing.obj", "can't be read"],
    );
    std::fs::create_dir(shop.path("folder.obj")).unwrap();
    refused_as_is(
        &shop,
        "mesh folder.obj -o out.obj",
        &["folder.obj", "can't be read"],
    );
}

#[test]
fn paths_that_can_not_be_written_are_told_before_the_computation() {
    let shop = with_square("a.obj");
    shop.write("file", "no folder");
    std::fs::create_dir(shop.path("taken.obj")).unwrap();
    refused_as_is(
        &shop,
        "mesh a.obj -o file/x.obj",
        &["file/x.obj", "not a folder"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o taken.obj",
        &["taken.obj", "is a folder"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --png file/x.png",
        &["file/x.png", "not a folder"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --write-target file/x.obj",
        &["file/x.obj"],
    );
    refused_as_is(
        &shop,
        "check a.obj --report -",
        &["- can't be written", "standard output"],
    );
    refused_as_is(&shop, "mesh a.obj -o ./a.obj", &["a.obj", "also read"]);
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --report out.obj",
        &["out.obj", "also read, or written twice"],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn folder_that_refuses_files() {
    let shop = with_square("a.obj");
    refused_as_is(
        &shop,
        "mesh a.obj -o /proc/x.obj",
        &["/proc/x.obj", "refuses files"],
    );
}

#[test]
fn senseless_numbers_of_panels() {
    let shop = with_square("a.obj");
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --panels 0",
        &["--panels 0", "at least one"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --panels 2000001",
        &["2000001", "at most"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --edge-length 0",
        &["--edge-length 0", "positive"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --edge-length 1e-6",
        &["--edge-length 0.000001", "at most"],
    );
}

#[test]
fn unknown_extensions() {
    let shop = with_square("a.xyz");
    shop.write("a.obj", SQUARE);
    refused_as_is(
        &shop,
        "mesh a.xyz -o out.obj",
        &["a.xyz", "unknown extension", ".ply"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.xyz",
        &["out.xyz", "unknown extension"],
    );
    refused_as_is(&shop, "convert a.obj out", &["unknown extension"]);
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --png a.jpg",
        &["a.jpg", "pictures are written as .png"],
    );
    for command in [
        "mesh a.obj -o out.obj --html a.png",
        "report a.obj --html a.png",
        "check a.obj --html a.png",
    ] {
        refused_as_is(&shop, command, &["a.png", "pages are written as .html"]);
    }
    std::fs::create_dir(shop.path("folder")).unwrap();
    shop.phex("mesh a.obj -o folder")
        .refuses(4, &["folder can't be written: it is a folder"]);
}

#[test]
fn binary_files_that_announce_four_billion_faces() {
    let mut stl = vec![b' '; 80];
    stl.extend(u32::MAX.to_le_bytes());
    stl.extend([0; 50]);
    refused("a.stl", stl, &["a.stl", "4294967295"]);
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n";
    let mut ply = header.as_bytes().to_vec();
    ply.extend([0; 36]);
    refused("a.ply", ply, &["a.ply", "4000000000"]);
}

#[test]
fn job_file_that_can_not_be_used() {
    let shop = with_square("a.obj");
    shop.write("job.toml", "pannels = 300\n");
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --config job.toml",
        &["job.toml", "pannels"],
    );
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --config missing.toml",
        &["missing.toml"],
    );
}

#[test]
fn command_line_that_can_not_be_understood_ends_with_2() {
    let shop = with_square("a.obj");
    for arguments in [
        "mesh",
        "mesh a.obj",
        "mesh a.obj -o out.obj --panels many",
        "mesh a.obj -o out.obj --edge-length 7km",
        "mesh a.obj -o out.obj --panels 3 --edge-length 1m",
        "mesh a.obj -o out.obj --threads 0",
        "shape blob -o out.obj",
        "unheard-of",
    ] {
        let run = shop.phex(arguments);
        assert_eq!(run.code, Some(2), "phex {arguments}\n{}", run.stderr);
        assert_eq!(run.stdout, "");
    }
    assert_eq!(shop.files(), ["a.obj"]);
}

#[test]
fn errors_are_json_where_json_is_asked_for() {
    let shop = with_square("a.obj");
    let run = shop.phex("mesh a.obj -o out.obj --panels 0 --progress json");
    let last = run.stderr.lines().last().unwrap();
    let error: serde_json::Value = serde_json::from_str(last).unwrap();
    assert_eq!(
        (&error["event"], &error["exit_code"]),
        (&"error".into(), &4.into())
    );
}

/// Numbers of every file and option are finite, and no larger than what can be computed with.
#[test]
fn points_beyond_what_can_be_computed_with() {
    let shop = with_square("a.obj");
    let huge = ["1e51", "1e155", "-1e308", "inf", "nan"];
    for x in huge {
        shop.write("point.txt", format!("0.5 0.5 0\n{x} 0 0\n"));
        shop.write("cone.txt", format!("{x} 0 0 1\n"));
        shop.write("line.obj", format!("v 0 0 0\nv 0 {x} 0\nl 1 2\n"));
        for (option, place) in [
            ("--fix point.txt", "point.txt:2"),
            ("--anchors point.txt", "point.txt:2"),
            ("--cones cone.txt", "cone.txt:1"),
            ("--curve line.obj", "line.obj:2"),
            ("--guide line.obj", "line.obj:2"),
        ] {
            let arguments = format!("mesh a.obj -o out.obj -n 5 {option}");
            refused_as_is(&shop, &arguments, &[place, x]);
        }
        shop.write(
            "job.toml",
            format!("[[stages.steering.anchors]]\npoint = [{x}, 0, 0]\nweight = 1\n"),
        );
        let job = "mesh a.obj -o out.obj -n 5 --config job.toml";
        refused_as_is(&shop, job, &["stages.steering.anchors.point"]);
        shop.write("sites.txt", format!("0 0\n1 0\n0 {x}\n"));
        refused_as_is(
            &shop,
            "power-diagram --sites sites.txt -o out.obj",
            &["sites.txt:3"],
        );
    }
    for command in [
        "check big.obj",
        "planarize big.obj -o out.obj",
        "mesh big.obj -o out.obj",
    ] {
        shop.write("big.obj", SQUARE.replacen("v 1 1 0", "v 1 1e155 0", 1));
        refused_as_is(&shop, command, &["big.obj", "extent", "1e50"]);
    }
    let stl = "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e200 0\nendloop\nendfacet\nendsolid\n";
    refused("big.stl", stl, &["line 6", "1e200"]);
}

#[test]
fn settings_that_are_not_finite_or_out_of_range() {
    let shop = with_square("a.obj");
    for x in ["nan", "inf", "-inf", "361", "1e300"] {
        let arguments = format!("mesh a.obj -o out.obj -n 5 --rotate={x}");
        refused_as_is(&shop, &arguments, &["rotate", "from -360 to 360"]);
    }
    for (table, line) in [
        ("directions", "rotate = inf"),
        ("directions", "alignment = inf"),
        ("directions", "anisotropy = 0"),
        ("layout", "max_distortion = inf"),
        ("layout", "max_pull = nan"),
        ("layout", "sweeps = 1000000000000"),
        ("optimise", "fairness = -1"),
        ("optimise", "least_side = nan"),
        ("dual", "levels = 40"),
        ("target", "damping = nan"),
        ("curvature", "radius_rel = -1"),
        ("sizes", "adaptive = 0"),
        ("brick_wall", "ratio = 0"),
        ("brick_wall.network", "strictness = inf"),
    ] {
        shop.write("job.toml", format!("[stages.{table}]\n{line}\n"));
        let name = format!("stages.{table}.{}", line.split(' ').next().unwrap());
        let job = "mesh a.obj -o out.obj -n 5 --config job.toml";
        refused_as_is(&shop, job, &[&name, "must be"]);
    }
    for (option, name) in [
        ("--closeness 1e308", "closeness"),
        ("--fairness 1e7", "fairness"),
        ("--clearance 1e-300", "clearance"),
        ("--centres 1e300", "centres"),
        ("--ground --ground-reach 1e300", "ground-reach"),
        ("--threads 65535", "threads"),
    ] {
        refused_as_is(
            &shop,
            &format!("mesh a.obj -o out.obj -n 5 {option}"),
            &[name],
        );
        refused_as_is(
            &shop,
            &format!("planarize a.obj -o out.obj {option}"),
            &[name],
        );
    }
    shop.write("job.toml", "[steering]\ncentres = -1\n");
    let job = "planarize a.obj -o out.obj --config job.toml";
    refused_as_is(&shop, job, &["centres", "must be"]);
}

#[test]
fn negative_values_are_refused_by_what_they_may_be() {
    let shop = with_square("a.obj");
    for (option, value) in [
        ("-n", "-5"),
        ("--repeat", "-3mm"),
        ("--edge-length", "-1m"),
        ("--max-panel", "-1x2m"),
        ("--max-aspect", "-2"),
    ] {
        shop.phex(&format!("mesh a.obj -o out.obj {option} {value}"))
            .refuses(2, &[&format!("invalid value '{value}'")]);
    }
    shop.phex("fab a.obj -o out --thickness -5mm")
        .refuses(2, &["invalid value '-5mm'"]);
}

#[test]
fn names_that_a_job_file_does_not_know() {
    let shop = with_square("a.obj");
    for (text, name) in [
        ("[stages]\nbondary = 'clip'\n", "bondary"),
        ("[stages.directons]\nrotate = 1\n", "directons"),
        ("[stages.directions]\nrotat = 1\n", "rotat"),
        ("[stages.directions.guides]\ncreases = 1\n", "creases"),
        ("[stages.layout]\nsweep = 1\n", "sweep"),
        ("[stages.target]\nkinds = 1\n", "kinds"),
        ("[stages.curvature]\nradius = 1\n", "radius"),
        ("[stages.sizes]\nadaptiv = 1\n", "adaptiv"),
        ("[stages.brick_wall]\nratios = 1\n", "ratios"),
        ("[stages.brick_wall.network]\nalign = 1\n", "align"),
    ] {
        shop.write("job.toml", format!("# A comment.\n{text}"));
        let line = 1 + text.lines().count();
        let place = if text.starts_with("[stages.directons]") {
            2
        } else {
            line
        };
        let place = format!("job.toml: line {place}:");
        let job = "mesh a.obj -o out.obj -n 5 --config job.toml";
        refused_as_is(&shop, job, &[&place, "unknown field", name]);
    }
    for (text, instead) in [
        ("[stages]\nsize = { panels = 30 }\n", "`panels`"),
        (
            "[stages.optimise]\nmax_deviation = 0.1\n",
            "`max-deviation`",
        ),
    ] {
        shop.write("job.toml", text);
        let job = "mesh a.obj -o out.obj --config job.toml";
        refused_as_is(&shop, job, &["no effect", instead]);
    }
}

/// What a job file names is read, too.
#[test]
fn files_of_a_job_are_not_written_over() {
    let shop = with_square("a.obj");
    for table in ["steering]\nfix", "steering]\nanchors", "guides]\ncones"] {
        shop.write("job.toml", format!("[{table} = 'out.obj'\n"));
        refused_as_is(
            &shop,
            "mesh a.obj -o out.obj -n 5 --config job.toml",
            &["out.obj", "also read"],
        );
    }
}

/// Nothing of a file that steers a terminal gets there, nor more of a line than tells which one it
/// is.
#[test]
fn messages_are_short_and_harmless_whatever_a_file_holds() {
    let shop = with_square("a.obj");
    let long = "x".repeat(100_000);
    let evil = "\u{1b}]0;mine\u{7}\u{9b}31m";
    for bad in [long.as_str(), evil] {
        shop.write("bad.obj", format!("{SQUARE}v {bad} 0 0\n"));
        shop.write(
            "bad.off",
            format!("OFF\n3 1 0\n0 0 0\n1 0 0\n{bad} 1 0\n3 0 1 2\n"),
        );
        shop.write(
            "bad.ply",
            format!("ply\nformat ascii 1.0\nelement {bad} many\nend_header\n"),
        );
        shop.write("bad.stl", format!("solid\nfacet\n{bad}\n"));
        shop.write("bad.txt", format!("{bad} 0 0\n"));
        shop.write(
            "bad.toml",
            format!("'{bad}' = 1\n").replace(['\u{1b}', '\u{7}'], ""),
        );
        shop.write(
            "worse.toml",
            format!("edge-length = \"{bad}\"\n").replace(['\u{1b}', '\u{7}'], ""),
        );
        shop.write("line.obj", format!("v 0 0 0\nl 1 {bad}\n"));
        let mut all = vec![
            "mesh a.obj -o out.obj --fix bad.txt",
            "mesh a.obj -o out.obj --size-field bad.txt",
            "mesh a.obj -o out.obj --curve line.obj",
            "mesh a.obj -o out.obj --config bad.toml",
            "mesh a.obj -o out.obj --config worse.toml",
            "power-diagram --sites bad.txt -o out.obj",
            "offset a.obj -o out --face-distances bad.txt",
        ];
        all.extend([
            "info bad.obj",
            "info bad.off",
            "info bad.ply",
            "info bad.stl",
        ]);
        for arguments in all {
            for mode in ["", " --progress json"] {
                let run = shop.phex(&format!("{arguments}{mode}"));
                run.refuses(4, &[]);
                let said = run.stderr + &run.stdout;
                assert!(said.len() < 2000, "{arguments}: {} bytes", said.len());
                let steers = |c: char| c.is_control() && c != '\n';
                assert!(!said.contains(steers), "{arguments}: {said:?}");
            }
        }
    }
}

#[test]
fn names_that_are_too_long_are_told_before_the_computation() {
    let shop = with_square("a.obj");
    let long = "n".repeat(252);
    refused_as_is(
        &shop,
        &format!("mesh a.obj -o {long}.obj"),
        &["can't be written", "the name `nnn"],
    );
    refused_as_is(
        &shop,
        &format!("mesh a.obj -o new/{long}.folder/x.obj"),
        &["can't be written"],
    );
    refused_as_is(
        &shop,
        &format!("convert a.obj {long}.ply"),
        &["can't be written"],
    );
    let longest = format!("{}.obj", "n".repeat(251));
    shop.succeed(&format!("convert a.obj {longest}"));
}

#[cfg(unix)]
#[test]
fn a_link_to_a_file_that_is_not_there_is_followed() {
    let shop = with_square("a.obj");
    std::os::unix::fs::symlink("folder/real.obj", shop.path("link.obj")).unwrap();
    shop.succeed("convert a.obj link.obj");
    assert!(
        std::fs::symlink_metadata(shop.path("link.obj"))
            .unwrap()
            .is_symlink()
    );
    assert!(shop.path("folder/real.obj").is_file());
    std::os::unix::fs::symlink("a.ply", shop.path("same.ply")).unwrap();
    let both = "mesh a.obj -o same.ply --write-target a.ply -n 5";
    shop.phex(both).refuses(4, &["also read, or written twice"]);
}

/// What is typed is carried out or refused, by name.
#[test]
fn options_without_effect_are_refused() {
    let shop = with_square("a.obj");
    shop.write("points.txt", "0.5 0.5 0\n");
    let refused = |arguments: &str, texts: &[&str]| refused_as_is(&shop, arguments, texts);
    let mesh = "mesh a.obj -o out.obj -n 5 --method";
    for option in [
        "--rotate 10",
        "--adaptive",
        "--size-field points.txt",
        "--guide a.obj",
        "--cones points.txt",
    ] {
        let name = option.trim_start_matches('-').split(' ').next().unwrap();
        for method in ["brick-wall", "power-diagram"] {
            let said = format!("`{name}` has no effect with `{method}`");
            refused(&format!("{mesh} {method} {option}"), &[&said, "lattice"]);
        }
    }
    refused(
        &format!("{mesh} projective-dual --guide a.obj"),
        &["`guide`", "lattice"],
    );
    for option in [
        "--fairness 2",
        "--closeness 2",
        "--target facets",
        "--solver barrier",
    ] {
        refused(
            &format!("{mesh} support-function {option}"),
            &["no effect", "brick-wall"],
        );
    }
    refused(
        "mesh a.obj -o out.obj -n 5 --ground-reach 1",
        &["`ground-reach`", "`ground`"],
    );
    refused(
        "mesh a.obj -o out.obj -n 5 --rotate 9 --start a.obj",
        &["`panels`, `rotate`", "start"],
    );
    refused(
        "planarize a.obj -o out.obj --ground-reach 1",
        &["`ground-reach`", "`ground`"],
    );
    refused(
        "check a.obj --max-deviation 1mm",
        &["--max-deviation 1mm", "--surface"],
    );
    refused(
        "subdivide a.obj -o out.obj --any-domain",
        &["--any-domain", "robust"],
    );
    refused(
        "convert a.obj out.ply --unit mm",
        &["--unit mm", "out.ply", "leave it out"],
    );
    refused("offset a.obj -o out --distance 5e-324", &["5e-324"]);
    refused("offset a.obj -o out --distance 0.1,1e-30", &["1e-30"]);
    refused("offset a.obj -o out --distance 1e308", &["1e308"]);
    for arguments in [
        "parallel a.obj --basis b.csv --least-edge 0.1",
        "dupin a.obj -o c.obj --panels a.obj --size 0.3",
        "shape sphere -o s.obj --seed 3",
        "offset a.obj -o out --max-distance --solids",
        "offset a.obj -o out --max-distance",
        "render a.obj -o a.png --elevation 200",
    ] {
        assert_eq!(shop.phex(arguments).code, Some(2), "{arguments}");
    }
}

#[test]
fn points_that_are_nowhere_near_the_surface() {
    let shop = with_square("a.obj");
    shop.write("far.txt", "0.5 0.5 0\n500 0 0 1\n");
    shop.write("far.obj", "v 0 0 0\nv 0 1e49 0\nl 1 2\n");
    for (option, what) in [
        ("--anchors far.txt", "anchor 1"),
        ("--curve far.obj", "curve 0"),
        ("--guide far.obj", "guide line 0"),
    ] {
        let arguments = format!("mesh a.obj -o out.obj -n 5 {option}");
        refused_as_is(&shop, &arguments, &[what, "diagonals", "another unit"]);
    }
}
