//! Rows along lines and creases, and cones from a file.
use crate::common::Workshop;

#[test]
fn cones_are_where_the_file_says_and_are_reported() {
    let shop = Workshop::new();
    shop.succeed("shape sphere --triangles 3000 -o sphere.obj");
    // Twelve pentagons in two rings of six, instead of the icosahedron's corners.
    let ring = |k: u32, z: f64| {
        let a = f64::from(k) * std::f64::consts::FRAC_PI_3 + 0.2;
        format!("{} {} {z} 1\n", 0.75 * a.cos(), 0.75 * a.sin())
    };
    let file: String = (0..6)
        .flat_map(|k| [ring(k, 0.66), ring(k, -0.66)])
        .collect();
    shop.write("cones.txt", file);
    let run =
        shop.succeed("mesh sphere.obj -o mesh.obj -n 300 --cones cones.txt --report run.json");
    assert!(
        run.stdout.contains("all 12 prescribed ones"),
        "{}",
        run.stdout
    );
    let report = shop.json("run.json");
    let cones = report["statistics"][0]["cones"].as_array().unwrap();
    assert_eq!(cones.len(), 12);
    for cone in cones {
        assert_eq!(cone["index"], 1);
        let z = cone["position"][2].as_f64().unwrap();
        assert!((z.abs() - 0.66).abs() < 0.1, "{z}");
    }
}

#[test]
fn wrong_guides_are_refused() {
    let shop = Workshop::new();
    shop.succeed("shape sphere --triangles 800 -o sphere.obj");
    shop.write("five.txt", "0 0 1 5\n");
    shop.write("half.txt", "0 0 1 0.5\n");
    shop.write("none.obj", "v 0 0 0\n");
    let refuse = |options: &str, words: &str| {
        let run = shop.phex(&format!("mesh sphere.obj -o mesh.obj -n 50 {options}"));
        run.refuses(4, &[words]);
        assert!(!shop.path("mesh.obj").exists());
    };
    refuse("--cones five.txt", "add up to 5 sixths");
    refuse("--cones half.txt", "half.txt:1: `x y z index`");
    refuse("--guide none.obj", "holds no polyline");
    shop.write("point.obj", "v 0 0 1\nl 1\nl 1 1\n");
    refuse("--guide point.obj", "holds no polyline");
}

/// How well the edges of a flat mesh fit hexagons in rows along a direction: the mean of `-cos 6
/// t`, 1 at best.
fn fit(text: &str, along: f64) -> f64 {
    let numbers = |l: &str| -> Vec<f64> {
        let words = l.split_whitespace().skip(1);
        words
            .map(|w| w.split('/').next().unwrap().parse().unwrap())
            .collect()
    };
    let points: Vec<Vec<f64>> = text
        .lines()
        .filter(|l| l.starts_with("v "))
        .map(numbers)
        .collect();
    let faces = text.lines().filter(|l| l.starts_with("f ")).map(numbers);
    let (mut sum, mut count) = (0.0, 0.0);
    for face in faces {
        for (i, a) in face.iter().enumerate() {
            let [a, b] = [*a, face[(i + 1) % face.len()]].map(|v| &points[v as usize - 1]);
            let angle = (b[1] - a[1]).atan2(b[0] - a[0]);
            sum -= (6.0 * (angle - along)).cos();
            count += 1.0;
        }
    }
    sum / count
}

/// A plate has no curvature: rows follow its boundary, or a line that lies askew.
#[test]
fn rows_run_along_a_line() {
    let shop = Workshop::new();
    shop.succeed("shape plane --triangles 1000 -o plate.obj");
    let along = 0.26_f64;
    let (x, y) = (0.9 * along.cos(), 0.9 * along.sin());
    shop.write(
        "line.obj",
        format!("v {} {} 0\nv {x} {y} 0\nl 1 2\n", -x, -y),
    );
    let made = |options: &str| {
        let run = shop.succeed(&format!("mesh plate.obj -o mesh.obj -n 150 {options}"));
        let told = run.stdout.contains("rows run along");
        assert_eq!(told, !options.is_empty(), "{}", run.stdout);
        String::from_utf8(shop.read("mesh.obj")).unwrap()
    };
    let (with, without) = (fit(&made("--guide line.obj"), along), fit(&made(""), along));
    assert!(with > without + 0.2, "{with} {without}");
}

#[test]
fn creases_are_guides_from_a_job_file_too() {
    let shop = Workshop::new();
    shop.succeed("shape plane --triangles 300 -o plate.obj");
    shop.write("job.toml", "[guides]\ncrease = 25\n");
    let run = shop.succeed("mesh plate.obj -o mesh.obj -n 40 --config job.toml --report run.json");
    let idle = "NO EFFECT: no edge of the surface is as sharp as 25 degrees, the sharpest has 0.0";
    assert!(run.stdout.contains(idle), "{}", run.stdout);
    let notes = shop.json("run.json")["notes"].to_string();
    assert!(notes.contains("creases: NO EFFECT"), "{notes}");
    let guides = &shop.json("run.json")["settings"]["stages"]["directions"]["guides"];
    assert_eq!(guides["crease"], 25.0);
    shop.phex("mesh plate.obj -o mesh.obj -n 40 --crease 200")
        .refuses(2, &["between 0 and 180"]);
}

/// A field of directions can't follow everything: what it did not is told with figures.
#[test]
fn wishes_that_come_to_nothing_are_told() {
    let shop = Workshop::new();
    shop.succeed("shape sphere --triangles 800 -o sphere.obj");
    let run = shop.phex("mesh sphere.obj -o mesh.obj -n 150 --boundary clip");
    run.refuses(0, &["--boundary has no effect"]);
    shop.succeed("shape plane --triangles 600 -o plate.obj");
    let run = shop.phex("mesh plate.obj -o mesh.obj -n 60 --adaptive");
    let told = "adaptive     HARDLY ANY EFFECT: panels of about one size are wanted everywhere (lengths in a ratio of 1.00;";
    assert!(run.stdout.contains(told), "{}", run.stdout);
    // Rows can't turn as fast as a zigzag of half a panel.
    let zigzag: String = (0..40)
        .map(|k| {
            format!(
                "v {} {} 0\n",
                0.04 * f64::from(k) - 0.8,
                0.06 * f64::from(k % 2)
            )
        })
        .collect();
    let line: String = (1..=40).map(|k| format!(" {k}")).collect();
    shop.write("zigzag.obj", format!("{zigzag}l{line}\n"));
    let run = shop.phex("mesh plate.obj -o mesh.obj -n 60 --guide zigzag.obj");
    let told = [
        "guides       NOT FOLLOWED: rows run along",
        "with fewer lines, or none",
    ];
    assert!(
        told.iter().all(|t| run.stdout.contains(t)),
        "{}",
        run.stdout
    );
}
