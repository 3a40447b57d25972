//! Limits of a workshop: met where they can be, told where not, judged here by code of its own.
use crate::common::{Workshop, honeycomb};
use serde_json::Value;

/// Corners of every panel of an OBJ file.
fn panels(shop: &Workshop, name: &str) -> Vec<Vec<[f64; 3]>> {
    let text = String::from_utf8(shop.read(name)).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        let words = line.split_whitespace().skip(1);
        words.map(|w| w.parse().unwrap()).collect()
    };
    let points: Vec<[f64; 3]> = (text.lines().filter(|l| l.starts_with("v ")))
        .map(|l| numbers(l)[..3].try_into().unwrap())
        .collect();
    let faces = text.lines().filter(|l| l.starts_with("f "));
    let corners = |l: &str| numbers(l).iter().map(|n| points[*n as usize - 1]).collect();
    faces.map(corners).collect()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Shortest edge, and sharpest corner in degrees, by the law of cosines; re-entrant corners are not
/// sharp.
fn least(panel: &[[f64; 3]]) -> (f64, f64) {
    let n = panel.len();
    let at = |i: usize| panel[i % n];
    let edges = (0..n).map(|i| norm(minus(at(i + 1), at(i))));
    let angle = |i: usize| {
        let (a, b) = (minus(at(i + n - 1), at(i)), minus(at(i + 1), at(i)));
        (dot(a, b) / (norm(a) * norm(b))).acos().to_degrees()
    };
    let angles = (0..n).map(angle);
    (
        edges.fold(f64::MAX, f64::min),
        angles.fold(f64::MAX, f64::min),
    )
}

/// Whether a sheet holds a panel: in one of many directions its extents are within both sides.
fn fits(panel: &[[f64; 3]], [a, b]: [f64; 2]) -> bool {
    let along = minus(panel[1], panel[0]);
    let x = along.map(|c| c / norm(along));
    let away = (2..panel.len()).map(|k| {
        let d = minus(panel[k], panel[0]);
        let across = dot(d, x);
        minus(d, x.map(|c| c * across))
    });
    let y = away.max_by(|p, q| norm(*p).total_cmp(&norm(*q))).unwrap();
    let y = y.map(|c| c / norm(y));
    let extent = |angle: f64| {
        let along = panel.iter().map(|p| {
            let d = minus(*p, panel[0]);
            dot(d, x) * angle.cos() + dot(d, y) * angle.sin()
        });
        let ends = along.fold((f64::MAX, f64::MIN), |(l, h), c| (l.min(c), h.max(c)));
        ends.1 - ends.0
    };
    (0..3600)
        .map(|k| f64::from(k) * std::f64::consts::PI / 3600.0)
        .any(|angle| {
            let half = std::f64::consts::FRAC_PI_2;
            // Directions between those that are tried are a little better.
            extent(angle) <= a * 1.0001 && extent(angle + half) <= b * 1.0001
        })
}

fn check_of<'a>(report: &'a Value, name: &str) -> &'a Value {
    let checks = report["checks"].as_array().unwrap();
    let found = checks.iter().find(|c| c["name"] == name);
    found.unwrap_or_else(|| panic!("no check {name}"))
}

#[test]
fn limits_that_can_be_met_are_met() {
    let shop = Workshop::new();
    let surfaces = [
        ("wave", 200),
        ("hyperbolic-paraboloid", 150),
        ("elliptic-paraboloid", 150),
        ("torus", 250),
    ];
    for (surface, n) in surfaces {
        shop.succeed(&format!("shape {surface} -o s.obj"));
        shop.succeed(&format!(
            "mesh s.obj -o free.obj -n {n} --report free.json -q"
        ));
        let free = shop.json("free.json");
        let measures = &free["measures"];
        let mean = |key: &str| measures[key].as_f64().unwrap();
        let (edge, area) = (mean("mean_edge"), mean("area") / mean("faces"));
        // A sheet of 2.2 times the mean panel, with sides of 2 to 3.
        let side = (2.2 * area / 1.5).sqrt();
        let sheet = [side, 1.5 * side];
        let limits = format!(
            "--max-panel {}x{} --min-edge {} --min-angle 25",
            sheet[0],
            sheet[1],
            0.25 * edge
        );
        shop.succeed(&format!(
            "mesh s.obj -o m.obj -n {n} {limits} -q --report m.json"
        ));
        for panel in panels(&shop, "m.obj") {
            let (shortest, sharpest) = least(&panel);
            assert!(
                shortest >= 0.25 * edge && sharpest >= 25.0,
                "{surface}: {shortest} {sharpest}"
            );
            assert!(fits(&panel, sheet), "{surface}: {panel:?}");
        }
        let report = shop.json("m.json");
        for name in ["max_panel", "min_edge", "min_angle"] {
            assert_eq!(check_of(&report, name)["pass"], true, "{surface} {name}");
        }
        shop.write(
            "job.toml",
            format!("[limits]\nmin-angle = 25\nmin-edge = {}\n", 0.25 * edge),
        );
        shop.succeed("check m.obj --limits job.toml");
    }
}

#[test]
fn limits_that_can_t_be_met_are_told_with_panels_and_what_helps() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 4000");
    let run = shop.phex("mesh torus.obj -o m.obj -n 60 --max-edge 0.2m --max-dihedral 100 --unit mm --report run.json");
    assert_eq!(
        run.code,
        Some(3),
        "200 units are long: {}{}",
        run.stdout,
        run.stderr
    );
    let report = shop.json("run.json");
    assert_eq!(check_of(&report, "max_edge")["pass"], true);
    let joints = check_of(&report, "max_dihedral");
    let ids = joints["ids"].as_array().unwrap();
    assert_eq!(ids.len(), joints["values"].as_array().unwrap().len());
    assert!(!ids.is_empty() && joints["place"].is_array(), "{joints}");
    assert!(
        run.stdout.contains("max_dihedral") && run.stdout.contains("fewer panels"),
        "{}",
        run.stdout
    );

    let run = shop.phex("mesh torus.obj -o m.obj -n 60 --max-edge 20cm --report run.json");
    assert_eq!(run.code, Some(3), "{}{}", run.stdout, run.stderr);
    let report = shop.json("run.json");
    let edges = check_of(&report, "max_edge");
    let values: Vec<f64> = edges["values"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect();
    assert!(values.iter().all(|v| *v > 0.2), "{values:?}");
    assert_eq!(edges["reading"]["unit"], "cm");
    assert!(
        edges["advice"].as_str().unwrap().contains("panels"),
        "{edges}"
    );
    shop.phex("check m.obj --report-of run.json");
    shop.write("job.toml", "unit = 'm'\n[limits]\nmax-edge = '20cm'\n");
    assert_eq!(shop.phex("check m.obj --limits job.toml").code, Some(3));
    assert_eq!(shop.phex("check m.obj --report-of run.json").code, Some(3));
}

#[test]
fn limits_of_size_give_the_number_of_panels() {
    let shop = Workshop::new();
    shop.succeed("shape elliptic-paraboloid -o s.obj --triangles 4000");
    shop.succeed("mesh s.obj -o large.obj --max-area 0.2 --report large.json -q");
    shop.succeed("mesh s.obj -o small.obj --max-area 0.05 --report small.json -q");
    let faces = |name: &str| shop.json(name)["measures"]["faces"].as_f64().unwrap();
    let ratio = faces("small.json") / faces("large.json");
    assert!((3.0..5.0).contains(&ratio), "{ratio}");
}

#[test]
fn nonsense_is_refused() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o s.obj --triangles 2000");
    for (limits, told) in [
        ("--max-panel 3m", "1.5x3.0m"),
        ("--max-panel 0x3m", "rectangle"),
        ("--max-area 3m", "area"),
        ("--min-edge nan", "length"),
        ("--min-angle 0", "positive"),
        ("--min-angle 180", "min-angle can't be 180"),
        ("--max-aspect 0.5", "max-aspect"),
        ("--min-edge 2m --max-edge 1m", "min-edge 2m"),
        ("--min-dihedral 170 --max-dihedral 160", "min-dihedral 170"),
        ("--max-dihedral 190", "max-dihedral"),
        ("--max-edge 1e300m", "max-edge"),
    ] {
        let run = shop.phex(&format!("mesh s.obj -o m.obj -n 30 {limits}"));
        assert!(
            matches!(run.code, Some(2 | 4)),
            "{limits}: {:?} {}",
            run.code,
            run.stderr
        );
        assert!(run.stderr.contains(told), "{limits}: {}", run.stderr);
    }
    shop.write("job.toml", "[stages.optimise.panels]\nmin_edge = 1.0\n");
    shop.phex("mesh s.obj -o m.obj --config job.toml")
        .refuses(4, &["[limits]"]);
    assert_eq!(shop.files(), ["job.toml", "s.obj"]);
}

/// Lengths have units; the same model in another unit gives the same panels.
#[test]
fn limits_have_no_unit_inside() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o m.obj --triangles 2000");
    let text = String::from_utf8(shop.read("m.obj")).unwrap();
    let scaled = text.lines().map(|l| match l.strip_prefix("v ") {
        Some(point) => {
            let numbers = point
                .split_whitespace()
                .map(|w| w.parse::<f64>().unwrap() * 1024.0);
            format!(
                "v {}\n",
                numbers.map(|x| x.to_string()).collect::<Vec<_>>().join(" ")
            )
        }
        None => format!("{l}\n"),
    });
    shop.write("large.obj", scaled.collect::<String>());
    shop.phex("mesh m.obj -o a.obj -n 60 --min-edge 0.1 --min-angle 25 -q --keep-invalid");
    shop.phex("mesh large.obj -o b.obj -n 60 --min-edge 102.4 --min-angle 25 -q --keep-invalid");
    let (a, b) = (panels(&shop, "a.obj"), panels(&shop, "b.obj"));
    assert_eq!(a.len(), b.len());
    for (p, q) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!(norm(minus(p.map(|c| c * 1024.0), *q)) < 1e-9 * 1024.0);
    }
}

/// The unit of a job's limits holds unless another one is typed.
#[test]
fn a_typed_unit_comes_before_that_of_a_job() {
    let shop = Workshop::new();
    shop.write("h.obj", honeycomb(3, 4, |_, p| p));
    shop.write(
        "job.toml",
        "unit = \"mm\"\n[limits]\nmax-edge = \"500mm\"\n",
    );
    shop.succeed("check h.obj --limits job.toml");
    let run = shop.phex("check h.obj --limits job.toml --unit m");
    assert_eq!(run.code, Some(3), "{}", run.stdout);
    assert!(
        run.stdout.contains("FAILED       max_edge"),
        "{}",
        run.stdout
    );
}
