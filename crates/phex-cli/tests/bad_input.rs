//! Bad input ends with exit code 4, a message that names element and cause, and no output file touched.

mod common;
use common::Workshop;

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
        SQUARE.replacen("f 1 2 3", "f 1 2 2", 1),
        &["face 0", "vertex 1", "more than once"],
    );
}

#[test]
fn triangles_without_area() {
    refused(
        "a.obj",
        SQUARE.replacen("v 0 1 0", "v 0.5 0.5 0", 1),
        &["without area", "1"],
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
    refused_as_is(&shop, "mesh a.obj -o ./a.obj", &["a.obj", "also read"]);
    refused_as_is(
        &shop,
        "mesh a.obj -o out.obj --report out.obj",
        &["out.obj", "also read or written"],
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
    refused_as_is(&shop, "mesh a.obj -o out.obj --edge-length 0", &["at most"]);
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
        "",
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
