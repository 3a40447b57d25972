//! `phex koebe` and `phex parallel`.

mod common;
use common::Workshop;

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
    let run = shop.phex(
        "parallel koebe.obj --surface sphere.obj -o fitted.obj --edge-offset 0.1 --write-offset layer.obj",
    );
    assert!(
        run.stdout.contains("edge distances constant to"),
        "{}{}",
        run.stdout,
        run.stderr
    );
    assert!(shop.files().contains(&"layer.obj".to_owned()));
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
fn edge_offsets_of_other_meshes_are_refused_by_edge() {
    let shop = Workshop::new();
    shop.write("cube.off", CUBE);
    shop.succeed("shape sphere -o sphere.obj --triangles 2000");
    let run = shop.phex(
        "parallel cube.off --surface sphere.obj -o out.obj --edge-offset 0.1 --write-offset layer.obj",
    );
    assert_eq!(run.code, Some(4));
    assert!(
        run.stderr.contains("misses the unit sphere"),
        "{}",
        run.stderr
    );
    assert_eq!(
        shop.phex("parallel cube.off --surface sphere.obj -o out.obj --edge-offset 1")
            .code,
        Some(2)
    );
    let run = shop.phex("parallel cube.off --surface sphere.obj -o out.obj --least-edge 2");
    assert_eq!(run.code, Some(4));
    assert!(run.stderr.contains("least_edge"), "{}", run.stderr);
}
