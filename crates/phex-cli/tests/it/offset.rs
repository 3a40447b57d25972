//! `phex offset`: layers, solids, and refusals that leave nothing behind.
use crate::common::Workshop;

/// A cuboid of 1 x 2 x 3, normals pointing out.
const CUBOID: &str = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A cube of side 1.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn with_cuboid() -> Workshop {
    let shop = Workshop::new();
    shop.write("m.obj", CUBOID);
    shop
}

/// Runs and expects a refusal that leaves the folder as it was.
fn refused(shop: &Workshop, arguments: &str, code: i32, texts: &[&str]) {
    let before = shop.files();
    let run = shop.phex(arguments);
    run.refuses(code, texts);
    assert_eq!(shop.files(), before, "no file comes or goes");
}

fn coordinates(shop: &Workshop, name: &str) -> Vec<f64> {
    let text = String::from_utf8(shop.read(name)).unwrap();
    let lines = text.lines().filter_map(|l| l.strip_prefix("v "));
    lines
        .flat_map(|l| l.split_whitespace())
        .map(|x| x.parse().unwrap())
        .collect()
}

#[test]
fn layers_solids_beams_and_the_gauss_image() {
    let shop = with_cuboid();
    shop.succeed(
        "offset m.obj --kind face --distance 0.2,5cm -o layers --solids --beams --gauss-image --report run.json",
    );
    let low = |name: &str| {
        coordinates(&shop, name)
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    assert!((low("layers/layer_+0.05.obj") + 0.05).abs() < 1e-15);
    assert!((low("layers/layer_+0.2.obj") + 0.2).abs() < 1e-15);
    let gauss = coordinates(&shop, "layers/gauss_image.obj");
    assert!(gauss.iter().all(|x| (x.abs() - 1.0).abs() < 1e-15));
    let report = shop.json("run.json");
    let outputs = report["outputs"].as_array().unwrap();
    let solids = outputs.iter().find(|o| o["content"] == "solids").unwrap();
    let shell = 1.4 * 2.4 * 3.4 - 1.1 * 2.1 * 3.1;
    assert!((solids["volume"].as_f64().unwrap() - shell).abs() < 1e-12);
    assert_eq!(solids["path"], "layers/solids_+0.05_+0.2.obj");
    // Six panels of eight corners each.
    assert_eq!(
        coordinates(&shop, "layers/solids_+0.05_+0.2.obj").len(),
        6 * 8 * 3
    );
    let beams = String::from_utf8(shop.read("layers/beams_+0.05_+0.2.csv")).unwrap();
    assert_eq!(beams.lines().count(), 1 + 12);
}

#[test]
fn a_distance_past_the_safe_one_writes_nothing() {
    let shop = with_cuboid();
    refused(
        &shop,
        "offset m.obj --distance=0.1,-0.6 -o layers",
        5,
        &["-0.6", "edge", "largest safe distance", "-0.47368"],
    );
    let run = shop.succeed("offset m.obj --max-distance");
    assert!(
        run.stdout.contains("any distance outward"),
        "{}",
        run.stdout
    );
    assert!(
        run.stdout.contains("up to 0.47368 m inward"),
        "{}",
        run.stdout
    );
    shop.succeed("offset m.obj --distance=-0.47 -o layers");
}

#[test]
fn a_distance_that_is_given_twice_is_told_as_such() {
    let shop = with_cuboid();
    let twice = "offset m.obj --distance 0.1,0.1 -o out";
    refused(&shop, twice, 2, &["0.1", "is given twice"]);
}

#[test]
fn a_layer_that_is_one_point_is_told_without_a_figure() {
    let shop = Workshop::new();
    shop.write("m.obj", CUBE);
    let run = shop.succeed("offset m.obj --max-distance");
    assert!(
        run.stdout.contains("all lie in one point"),
        "{}",
        run.stdout
    );
    assert!(!run.stdout.contains("NaN"), "{}", run.stdout);
}

#[test]
fn a_distance_for_each_face() {
    let shop = with_cuboid();
    shop.write("d.txt", "# the lid\n0.1\n0\n0\n0\n0\n0\n");
    shop.succeed("offset m.obj --face-distances d.txt -o layers");
    let moved = coordinates(&shop, "layers/layer_faces.obj");
    let before = coordinates(&shop, "m.obj");
    let changed = moved.iter().zip(&before).filter(|(a, b)| a != b).count();
    assert_eq!(changed, 4, "four corners go down");
    shop.write("few.txt", "0.1\n0.2");
    refused(
        &shop,
        "offset m.obj --face-distances few.txt -o other",
        4,
        &["2 distances", "6 faces"],
    );
    shop.write("two.txt", "0.1 0\n0 0\n0 0\n");
    refused(
        &shop,
        "offset m.obj --face-distances two.txt -o other",
        4,
        &["two.txt:1", "one number is wanted on each line"],
    );
    shop.write("word.txt", "0.1\nzero");
    refused(
        &shop,
        "offset m.obj --face-distances word.txt -o other",
        4,
        &["word.txt:2", "zero"],
    );
}

/// The edges of a tetrahedron fold, and so do those of its offsets: they are written, and the exit
/// code says so.
#[test]
fn what_the_mesh_has_its_layers_keep() {
    let shop = Workshop::new();
    let tetrahedron =
        "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    shop.write("m.obj", tetrahedron);
    let run = shop.phex("offset m.obj --distance 0.1 -o layers --report run.json");
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert!(run.stdout.contains("INHERITED"), "{}", run.stdout);
    let report = shop.json("run.json");
    assert_eq!(report["inherited"].as_array().unwrap().len(), 10);
    assert!(report["layers"][0]["distance_error"].as_f64().unwrap() < 1e-15);
    assert!(report["gauss_image"]["error_estimate"].as_f64().unwrap() < 1e-13);
}

/// A cuboid is inscribed in a sphere, so its vertices can keep their distance too.
#[test]
fn vertices_at_a_distance() {
    let shop = with_cuboid();
    shop.succeed("offset m.obj --kind vertex --distance 0.1 -o layers");
    let moved = coordinates(&shop, "layers/layer_+0.1.obj");
    let before = coordinates(&shop, "m.obj");
    for (a, b) in moved.chunks(3).zip(before.chunks(3)) {
        let d: f64 = a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum();
        assert!((d.sqrt() - 0.1).abs() < 1e-12);
    }
}

/// A quadrilateral whose corners must move far to have a circle; it stays in its plane.
#[test]
fn how_far_vertices_move_is_measured_from_where_they_were() {
    let shop = Workshop::new();
    shop.write("m.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 2 0\nf 1 2 3 4\n");
    shop.write(
        "s.obj",
        "v 0 0 .1\nv 2 0 0\nv 2 1 0\nv 0 2 0\nf 1 2 3\nf 1 3 4\n",
    );
    let offset = "offset m.obj --kind vertex --optimise --distance 0.1 --report run.json";
    let run = shop.succeed(&format!("{offset} -o free"));
    let made = |shop: &Workshop| shop.json("run.json")["angle_condition"].clone();
    let (before, after) = (
        coordinates(&shop, "m.obj"),
        coordinates(&shop, "free/mesh.obj"),
    );
    let steps = before.chunks(3).zip(after.chunks(3));
    let step =
        |(p, q): (&[f64], &[f64])| p.iter().zip(q).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let moved = steps.map(step).fold(0.0, f64::max).sqrt();
    let told = made(&shop);
    assert!(moved > 0.01, "{moved}");
    assert!(
        (told["moved"].as_f64().unwrap() - moved).abs() < 1e-12,
        "{told} {moved}"
    );
    assert!(
        run.stdout
            .contains(&format!("moved by up to {moved:.3e} m")),
        "{}",
        run.stdout
    );
    assert!(told["deviation"].as_f64().unwrap() < 1e-9, "{told}");

    let close = |limit: &str| {
        shop.phex(&format!(
            "{offset} -o bound --surface s.obj --max-deviation {limit}"
        ))
    };
    let run = close("0.05%");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains("OUTSIDE"), "{}", run.stdout);
    let told = made(&shop);
    assert_eq!(told["within_deviation"], false);
    let deviation = told["deviation"].as_f64().unwrap();
    // What `phex check` measures for the same two files.
    shop.phex("check bound/mesh.obj --surface s.obj --report check.json");
    let check = shop.json("check.json");
    let figures = &check["deviation_facets"];
    let length = |name: &str| figures[name].as_f64().unwrap();
    let judged = length("deviation_max") * length("diagonal");
    assert!((deviation - judged).abs() < 1e-9, "{deviation} {judged}");
    assert_eq!(close("1%").code, Some(0));
}

/// A folded strip: only where it is open do edges turn, and that is said with the edge and the
/// angle.
#[test]
fn edges_that_turn_at_the_rim_are_told() {
    let shop = with_cuboid();
    let run = shop.succeed("offset m.obj --distance 0.1 -o closed --report run.json");
    assert!(
        !run.stdout.contains("boundary edges turn"),
        "{}",
        run.stdout
    );
    assert_eq!(shop.json("run.json")["layers"][0]["turned"]["edges"], 0);
    // Three faces of a cuboid with slanted outer edges.
    shop.write(
        "m.obj",
        "v 0 0 0\nv 2 0 0\nv 3 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 0 3 2\nf 1 2 3 4\nf 1 5 6 2\nf 1 4 7 5\n",
    );
    let run = shop.phex("offset m.obj --distance 0.1 -o open --report run.json --gauss-image");
    assert!(
        run.stdout.contains("boundary edges turn"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    let report = shop.json("run.json");
    let turned = &report["layers"][0]["turned"];
    let (before, after) = (
        coordinates(&shop, "m.obj"),
        coordinates(&shop, "open/layer_+0.1.obj"),
    );
    let edge = |x: &[f64], [a, b]: [usize; 2]| [0, 1, 2].map(|k| x[3 * b + k] - x[3 * a + k]);
    let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|k| p[k] * q[k]).sum::<f64>();
    let rim = [[1, 2], [2, 3], [3, 6], [6, 4], [4, 5], [5, 1]];
    let angles = rim.map(|ends| {
        let (p, q) = (edge(&before, ends), edge(&after, ends));
        (dot(p, q) / (dot(p, p) * dot(q, q)).sqrt()).min(1.0).acos()
    });
    let most = angles.into_iter().fold(0.0, f64::max);
    assert!(most > 1e-3, "{angles:?}");
    assert!(
        (turned["angle"].as_f64().unwrap() - most).abs() < 1e-7,
        "{turned} {angles:?}"
    );
    let count = angles.iter().filter(|a| **a > 1e-7).count();
    assert_eq!(turned["edges"], count);
    assert_eq!(
        report["gauss_image"]["turned_edges"]
            .as_array()
            .unwrap()
            .len(),
        count
    );
}

/// A folder is shared with the user, and with earlier runs.
#[test]
fn only_layers_of_earlier_runs_are_written_over() {
    let shop = with_cuboid();
    std::fs::create_dir(shop.path("layers")).unwrap();
    shop.write("layers/layer_+0.1.obj", "mine");
    shop.write("layers/notes.txt", "notes");
    let offset = "offset m.obj -o layers --distance";
    shop.phex(&format!("{offset} 0.1"))
        .refuses(4, &["layer_+0.1.obj is in the way"]);
    assert_eq!(shop.read("layers/layer_+0.1.obj"), b"mine");
    shop.succeed(&format!("{offset} 0.2"));
    shop.succeed(&format!("{offset} 0.3"));
    let solids = "offset m.obj -o layers --distance 0.2,0.4 --solids --format ply";
    shop.succeed(solids);
    shop.succeed(&format!("{offset} 0.2"));
    assert!(shop.path("layers/layer_+0.3.obj").exists());
    shop.write("layers/layer_+0.2.obj", "changed");
    shop.phex(&format!("{offset} 0.2"))
        .refuses(4, &["layer_+0.2.obj has been changed since"]);
    shop.succeed(&format!("{offset} 0.3"));
    assert_eq!(shop.read("layers/layer_+0.2.obj"), b"changed");
    assert_eq!(shop.read("layers/notes.txt"), b"notes");
}

#[test]
fn wrong_meshes_are_refused_with_the_element() {
    let shop = Workshop::new();
    shop.write("m.obj", CUBOID.replace("v 1 2 3", "v 1.1 2 3"));
    refused(
        &shop,
        "offset m.obj --distance 0.1 -o layers",
        4,
        &["face 3", "not planar"],
    );
    let pyramid = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .5 1\n\
        f 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    shop.write("m.obj", pyramid);
    refused(
        &shop,
        "offset m.obj --distance 0.1 -o layers",
        4,
        &["4 faces meet at vertex 4"],
    );
    let kite = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 2 0\nf 1 2 3 4\n";
    shop.write("m.obj", kite);
    refused(
        &shop,
        "offset m.obj --kind vertex --distance 0.1 -o layers",
        4,
        &["face 0", "angle condition"],
    );
    shop.succeed("offset m.obj --kind vertex --optimise --distance 0.1 -o layers");
}

#[test]
fn wrong_options_are_refused() {
    let shop = with_cuboid();
    let usage = |arguments: &str, texts: &[&str]| refused(&shop, arguments, 2, texts);
    usage("offset m.obj -o layers", &["--distance"]);
    usage("offset m.obj --distance 0.1", &["--output"]);
    usage("offset m.obj --distance wide -o layers", &["wide"]);
    usage(
        "offset m.obj --distance nan -o layers",
        &["`nan` is no distance: give a number, negative on the side"],
    );
    usage(
        "offset m.obj --distance 0.1 -o layers --optimise",
        &["--kind vertex"],
    );
    usage(
        "offset m.obj --distance 0.1 -o layers --gap 1mm",
        &["--solids"],
    );
    refused(
        &shop,
        "offset m.obj --distance 0.1 -o layers --solids --gap 1.5",
        4,
        &["gap of 1.5 m", "face", "room for is 0."],
    );
}
