//! `phex koebe` and `phex parallel`.
use crate::common::Workshop;

const CUBE: &str = "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n";

#[test]
fn koebe_cube_fits_a_sphere_and_carries_edge_offsets() {
    let shop = Workshop::new();
    shop.write("cube.off", CUBE);
    let run = shop.succeed("koebe cube.off -o koebe.obj --report koebe.json --png koebe.png");
    assert!(run.stdout.contains("tangency"), "{}", run.stdout);
    let report = shop.json("koebe.json");
    let tangency = report["statistics"]["defects"]["tangency"].as_f64();
    assert!(tangency.is_some_and(|t| t < 1e-14), "{tangency:?}");
    assert_eq!(report["command"], "koebe");

    shop.succeed("shape sphere -o sphere.obj --triangles 2000");
    let fit = "parallel koebe.obj --surface sphere.obj -o fitted.obj";
    let run = shop.phex(fit);
    assert!(run.stdout.contains("Converged"), "{}", run.stderr);
    let run = shop.succeed(
        "offset fitted.obj --kind edge --distance 0.1,-0.05 -o layers --solids --gauss-image --report offset.json",
    );
    assert!(run.stdout.contains("edges keep their distance"));
    let report = shop.json("offset.json");
    assert_eq!(report["kind"], "edge");
    for layer in report["layers"].as_array().unwrap() {
        assert!(layer["distance_error"].as_f64().unwrap() < 1e-12);
    }
}

#[test]
fn what_has_no_koebe_mesh_is_refused_and_nothing_written() {
    let shop = Workshop::new();
    shop.write(
        "pillow.off",
        "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 1\n",
    );
    let run = shop.phex("koebe pillow.off -o out.obj");
    assert_eq!(run.code, Some(4));
    assert!(
        run.stderr.contains("vertex 0 has 2 edges"),
        "{}",
        run.stderr
    );
    shop.succeed("shape torus -o torus.obj");
    let run = shop.phex("koebe torus.obj -o out.obj");
    assert_eq!(run.code, Some(4));
    assert!(run.stderr.contains("genus 1"), "{}", run.stderr);
    assert!(!shop.files().contains(&"out.obj".to_owned()));
}

#[test]
fn a_graph_that_two_vertices_separate_is_refused_with_both() {
    let shop = Workshop::new();
    // Two blocks of four triangles between the poles 0 and 1: without these they fall apart.
    shop.write(
        "blocks.off",
        "OFF\n8 10 0\n0 0 1\n0 0 -1\n1 -1 0\n1.2 0 0\n1 1 0\n-1 1 0\n-1.2 0 0\n-1 -1 0\n\
         3 0 2 3\n3 0 3 4\n3 2 1 3\n3 3 1 4\n3 0 5 6\n3 0 6 7\n3 5 1 6\n3 6 1 7\n4 0 4 1 5\n4 0 7 1 2\n",
    );
    let run = shop.phex("koebe blocks.off -o out.obj");
    run.refuses(4, &["not 3-connected", "vertices 0 and 1", "faces 8 and 9"]);
    assert_eq!(shop.files(), ["blocks.off"]);
}

#[test]
fn edge_offsets_of_other_meshes_are_refused_by_edge() {
    let shop = Workshop::new();
    // A cube with one corner cut off: the three edges there leave the sphere.
    let chipped = "OFF\n10 7 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 .7\n1 .8 1\n.6 1 1\n\
        4 0 3 2 1\n5 4 5 8 9 6\n4 0 1 5 4\n5 1 2 7 8 5\n5 2 3 6 9 7\n4 3 0 4 6\n3 7 9 8\n";
    shop.write("chipped.off", chipped);
    let run = shop.phex("offset chipped.off --kind edge --distance 0.1 -o layers");
    run.refuses(4, &["edge", "between vertices", "touching the unit sphere"]);
    assert_eq!(shop.files(), ["chipped.off"]);
    shop.write("cube.off", CUBE);
    shop.succeed("shape sphere -o sphere.obj --triangles 2000");
    let run = shop.phex("parallel cube.off --surface sphere.obj -o out.obj --least-edge 2");
    assert_eq!(run.code, Some(4));
    assert!(run.stderr.contains("least_edge"), "{}", run.stderr);
}

/// A cube has the bricks for its parallel meshes: three dimensions, and longer edges take their
/// whole bundle with them.
#[test]
fn the_space_of_parallel_meshes_and_wishes_in_it() {
    let shop = Workshop::new();
    shop.write("cube.off", CUBE);
    let run = shop.succeed("parallel cube.off --basis basis.csv");
    assert!(run.stdout.contains("3 dimensions"), "{}", run.stdout);
    let basis = String::from_utf8(shop.read("basis.csv")).unwrap();
    // Three bundles of four parallel edges.
    assert_eq!(basis.lines().count(), 1 + 12, "{basis}");

    shop.write("lengths.txt", "# one bundle\n0 1 3\n3 2 3\n4 5 3\n7 6 3\n");
    shop.succeed("parallel cube.off --lengths lengths.txt -o brick.obj");
    let brick = String::from_utf8(shop.read("brick.obj")).unwrap();
    let x = brick.lines().filter_map(|l| l.strip_prefix("v "));
    let x = x.map(|l| l.split(' ').next().unwrap().parse::<f64>().unwrap());
    let (low, high) = x.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    assert!((high - low - 3.0).abs() < 1e-12, "{brick}");

    shop.write("diagonal.txt", "0 6 3\n");
    let run = shop.phex("parallel cube.off --lengths diagonal.txt -o other.obj");
    run.refuses(4, &["diagonal.txt:1", "an edge between two vertices"]);
    let run = shop.phex("parallel cube.off --lengths lengths.txt");
    run.refuses(2, &["--output"]);
}

/// The last line of a run's table.
fn last_line(run: &crate::common::Run) -> &str {
    run.stdout.lines().last().unwrap_or_default()
}

/// Where there is no panelling, commands that make a mesh end with 5 and write none.
#[test]
fn meshes_that_are_no_panelling_are_not_written_unless_asked_for() {
    let shop = Workshop::new();
    // Four panels meet at each vertex.
    shop.write(
        "octahedron.off",
        "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n\
         3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n",
    );
    let run = shop.phex("koebe octahedron.off -o koebe.obj");
    assert_eq!(run.code, Some(5), "{}", run.stdout);
    assert!(run.stdout.contains("FAILED       wrong_degree"));
    assert!(
        run.stdout.contains("NOT WRITTEN") && run.stdout.contains("--keep-invalid"),
        "{}",
        run.stdout
    );
    assert_eq!(last_line(&run), "verdict      INVALID");
    assert_eq!(shop.files(), ["octahedron.off"]);
    let run = shop.phex("koebe octahedron.off -o koebe.obj --keep-invalid");
    assert_eq!(run.code, Some(5), "{}", run.stdout);
    assert!(shop.files().contains(&"koebe.obj".to_owned()));
}

#[test]
fn an_invalid_parallel_mesh_is_not_written_and_a_space_has_no_verdict() {
    let shop = Workshop::new();
    // The first corner is drawn through its panel.
    let crossed = crate::common::honeycomb(4, 5, |i, [x, y, z]| {
        [x, if i == 0 { y + 2.5 } else { y }, z]
    });
    shop.write("crossed.obj", crossed);
    shop.write("lengths.txt", "2 3 1\n");
    let parallel = "parallel crossed.obj --lengths lengths.txt -o out.obj";
    let run = shop.phex(parallel);
    assert_eq!(run.code, Some(5), "{}{}", run.stdout, run.stderr);
    assert_eq!(last_line(&run), "verdict      INVALID");
    assert!(!shop.files().contains(&"out.obj".to_owned()));
    let run = shop.phex(&format!("{parallel} --keep-invalid"));
    assert_eq!(run.code, Some(5), "{}", run.stdout);
    assert!(shop.files().contains(&"out.obj".to_owned()));

    let run = shop.succeed("parallel crossed.obj --basis basis.csv");
    assert!(
        !run.stdout.contains("NOT WRITTEN") && !run.stdout.contains("verdict"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_saddle_gets_edge_offsets_in_one_command() {
    let shop = Workshop::new();
    shop.succeed("shape hyperbolic-paraboloid --set side=1.6 -o saddle.obj --triangles 3000");
    let mesh = "mesh saddle.obj --method koebe -n 80 -o panels.obj --report run.json";
    let run = shop.succeed(mesh);
    assert!(run.stdout.contains("run against"), "{}", run.stdout);
    let report = shop.json("run.json");
    let told = &report["statistics"][0]["classical"];
    assert!(
        told["reversed_edges"].as_u64().is_some_and(|n| n > 0),
        "{told}"
    );
    assert_eq!(report["settings"]["stages"]["boundary"], "whole");
    let offset = "offset panels.obj --kind edge --distance 0.02,-0.02 -o layers --solids --beams --gauss-image --report offset.json";
    let run = shop.succeed(offset);
    assert!(run.stdout.contains("edges keep their distance"));
    for layer in shop.json("offset.json")["layers"].as_array().unwrap() {
        assert!(layer["distance_error"].as_f64().unwrap() < 1e-12);
    }

    // The Gauss image is a Koebe mesh: the way back, with the signs that are found.
    let fit = "parallel layers/gauss_image.obj --surface saddle.obj --signs rule -o fitted.obj --report fit.json";
    let run = shop.phex(fit);
    assert!(
        run.stdout.contains("run against those of the given mesh"),
        "{}",
        run.stderr
    );
    let statistics = &shop.json("fit.json")["statistics"];
    assert!(statistics["reversed_edges"].as_u64().is_some_and(|n| n > 0));
    assert_eq!(
        statistics["crossed_faces"].as_array().map(Vec::len),
        Some(0)
    );

    shop.write("signs.txt", "0 99999\n");
    let run = shop
        .phex("parallel layers/gauss_image.obj --surface saddle.obj --signs signs.txt -o no.obj");
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(run.stderr.contains("signs.txt:1"), "{}", run.stderr);
}

/// Panels that were cut have offsets of their inner edges; the others are named.
#[test]
fn cut_panels_have_offsets_of_their_inner_edges() {
    let shop = Workshop::new();
    shop.succeed("shape scherk --set side=1.6 -o scherk.obj --triangles 3000");
    let mesh = "mesh scherk.obj --method koebe --boundary clip -n 80 -o panels.obj --keep-invalid";
    shop.phex(mesh);
    let offset = "offset panels.obj --kind edge --distance 0.02,-0.02 -o layers --solids --beams --report offset.json";
    let run = shop.phex(offset);
    assert!(
        run.stdout.contains("inner edges keep their distance")
            && run.stdout.contains("have no distance of their own"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    let report = shop.json("offset.json");
    let free = report["gauss_image"]["free_edges"].as_array().unwrap();
    assert!(!free.is_empty());
    for layer in report["layers"].as_array().unwrap() {
        assert!(layer["distance_error"].as_f64().unwrap() < 1e-12);
        assert!(layer["turned"]["edges"].as_u64().unwrap() <= free.len() as u64);
    }
}

#[test]
fn surfaces_without_edge_offsets_are_refused_by_vertex() {
    let shop = Workshop::new();
    for (shape, reason) in [
        ("plane", "bends in one direction at most"),
        ("cylinder", "bends in one direction at most"),
        ("torus", "positive at vertex"),
        ("catenoid", "without holes"),
        ("wave", "positive at vertex"),
    ] {
        shop.succeed(&format!("shape {shape} -o {shape}.obj --triangles 2000"));
        let run = shop.phex(&format!("mesh {shape}.obj --method koebe -n 60 -o out.obj"));
        assert_eq!(run.code, Some(4), "{shape}: {}", run.stderr);
        assert!(run.stderr.contains(reason), "{shape}: {}", run.stderr);
        assert!(run.stderr.contains("vertex"), "{shape}: {}", run.stderr);
    }
    let run = shop.phex("mesh plane.obj --method koebe --boundary snap -n 60 -o out.obj");
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    assert!(run.stderr.contains("boundary"), "{}", run.stderr);
    assert!(!shop.files().contains(&"out.obj".to_owned()));
}
