//! `phex network` and `phex mesh --method brick-wall`.
use crate::common::Workshop;

#[test]
fn a_torus_has_a_network_and_a_wall_of_hexagons() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 4000");
    let said = shop.succeed("network torus.obj -o net.obj -n 200").stdout;
    let conjugate = said.lines().find(|l| l.starts_with("conjugate"));
    let conjugate = conjugate.unwrap_or_else(|| panic!("{said}"));
    let figure = |before: &str| -> f64 {
        let rest = conjugate.split(before).nth(1).unwrap_or_default();
        let number = rest.split([' ', ',']).next().unwrap_or_default();
        number.parse().unwrap_or_else(|_| panic!("{conjugate}"))
    };
    let (median, p95, worst) = (figure("median "), figure("below "), figure("worst "));
    assert!(
        median < 0.05 && median <= p95 && p95 <= worst && worst <= 1.0,
        "{said}"
    );
    let text = String::from_utf8(shop.read("net.obj")).unwrap();
    let curves: Vec<Vec<&str>> = text
        .lines()
        .filter(|l| l.starts_with("l "))
        .map(|l| l.split(' ').skip(1).collect())
        .collect();
    assert!(curves.len() > 20);
    for curve in curves {
        assert_eq!(curve.first(), curve.last(), "every curve of a torus closes");
    }

    shop.succeed("mesh torus.obj -o wall.obj -n 200 --method brick-wall --report run.json");
    let report = shop.json("run.json");
    assert_eq!(report["settings"]["method"], "brick-wall");
    let info = shop.succeed("check wall.obj").stdout;
    assert!(
        info.contains("hexagons") && !info.contains("pentagons"),
        "{info}"
    );
}

#[test]
fn a_sphere_has_no_network() {
    let shop = Workshop::new();
    shop.succeed("shape sphere -o sphere.obj --triangles 2000");
    let texts = ["no global conjugate network", "Euler characteristic 2"];
    shop.phex("network sphere.obj -o net.obj")
        .refuses(5, &texts);
    shop.phex("mesh sphere.obj -o wall.obj --method brick-wall")
        .refuses(5, &texts);
    assert_eq!(shop.files(), ["sphere.obj"]);
}

#[test]
fn unusable_values_are_refused() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj --triangles 2000");
    shop.phex("network wave.obj -o net.ply")
        .refuses(4, &["OBJ"]);
    shop.phex("network wave.obj -o net.obj --columns-along 0,0,0")
        .refuses(4, &["axis"]);
    shop.succeed("network wave.obj -o net.obj --columns-along 1,0,0 -n 200");
}

/// The surface z = x^2 - y^2 over a square, whose boundary turns by 37 degrees at its corners.
fn saddle(shop: &Workshop) {
    let side = 31;
    let at = |k: usize| k as f64 / 15.0 - 1.0;
    let places = (0..side * side).map(|v| (at(v % side), at(v / side)));
    let vertices = places.map(|(x, y)| format!("v {x} {y} {}\n", x * x - y * y));
    let cells = (0..side * side).filter(|v| v % side + 1 < side && v / side + 1 < side);
    let faces = cells.map(|v| format!("f {} {} {} {}\n", v + 1, v + 2, v + side + 2, v + side + 1));
    shop.write("saddle.obj", vertices.chain(faces).collect::<String>());
}

/// A check of a report.
fn check_of(shop: &Workshop, report: &str, name: &str) -> serde_json::Value {
    let report = shop.json(report);
    let checks = report["checks"].as_array().unwrap();
    let check = checks.iter().find(|c| c["name"] == name);
    check.unwrap_or_else(|| panic!("no {name}")).clone()
}

#[test]
fn bricks_keep_blunt_corners_of_the_boundary_and_are_judged_by_it() {
    let shop = Workshop::new();
    saddle(&shop);
    shop.succeed("mesh saddle.obj -o wall.obj -n 300 --method brick-wall --report run.json");
    for name in ["boundary", "covered_area"] {
        assert_eq!(check_of(&shop, "run.json", name)["pass"], true);
    }
}

#[test]
fn the_area_that_panels_cover_is_judged_for_every_method_and_what_became_of_the_forecast_is_told() {
    let shop = Workshop::new();
    saddle(&shop);
    let run = shop.phex("mesh saddle.obj -o planes.obj -n 150 --method tangent-planes --report run.json --keep-invalid");
    assert_ne!(run.code, Some(0), "{}{}", run.stdout, run.stderr);
    let covered = check_of(&shop, "run.json", "covered_area");
    assert_eq!(
        (&covered["limit"], &covered["pass"]),
        (&0.97.into(), &false.into())
    );
    assert!(!covered["ids"].as_array().unwrap().is_empty());
    let told = &shop.json("run.json")["statistics"][0]["classical"];
    let count = |name: &str| told[name].as_u64().unwrap();
    assert!(
        count("forecast_taken_out") + count("forecast_came_true") <= count("forecast"),
        "{told}"
    );
    assert!(
        count("forecast") == 0 || run.stdout.contains("were taken out"),
        "{}",
        run.stdout
    );
}
