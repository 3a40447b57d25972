//! `phex network` and `phex mesh --method brick-wall`.

mod common;
use common::Workshop;

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
