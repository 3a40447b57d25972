//! Equal edges, and ways to choose from by looking.
use crate::common::Workshop;
use serde_json::Value;

/// The least number of intervals that hold all edge lengths of an OBJ file, by code of its own.
fn intervals(shop: &Workshop, name: &str, width: f64) -> usize {
    let text = String::from_utf8(shop.read(name)).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        let words = line.split_whitespace().skip(1);
        words.map(|w| w.parse().unwrap()).collect()
    };
    let of = |kind: &str| -> Vec<Vec<f64>> {
        text.lines()
            .filter(|l| l.starts_with(kind))
            .map(numbers)
            .collect()
    };
    let (points, faces) = (of("v "), of("f "));
    let mut lengths: Vec<f64> = Vec::new();
    for face in &faces {
        for (i, a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            let [p, q] = [*a, b].map(|n| &points[n as usize - 1]);
            let squares = p.iter().zip(q).map(|(p, q)| (p - q) * (p - q));
            lengths.push(squares.sum::<f64>().sqrt());
        }
    }
    lengths.sort_by(f64::total_cmp);
    let mut ends = vec![f64::NEG_INFINITY];
    for length in lengths {
        if length > ends[ends.len() - 1] {
            ends.push(length + width);
        }
    }
    ends.len() - 1
}

#[test]
fn edges_are_made_equal_and_the_figures_are_those_of_the_files() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 3000 --set major=3 --set minor=1.2");
    shop.succeed("mesh torus.obj -o plain.obj -n 160 --max-deviation 2%");
    let told = shop.succeed(
        "mesh torus.obj -o equal.obj -n 160 --max-deviation 2% --repeat 5mm --report run.json --html run.html",
    );
    let report = shop.json("run.json");
    let repetition = &report["repetition"];
    let count = |when: &str| repetition[when]["edge_lengths"].as_u64().unwrap() as usize;
    let [before, after] = ["before", "after"].map(count);
    assert_eq!(before, intervals(&shop, "plain.obj", 0.005));
    assert_eq!(after, intervals(&shop, "equal.obj", 0.005));
    assert!(2 * after <= before, "{before} -> {after}");
    assert_eq!(report["verdict"], "pass");
    assert!(report["measures"]["planarity"]["max"].as_f64() <= Some(1e-12));
    let sentence = format!("within 0.005 m: {before} -> {after} edge lengths");
    assert!(told.stdout.contains(&sentence), "{}", told.stdout);
    let page = String::from_utf8(shop.read("run.html")).unwrap();
    assert!(page.contains("<h2>Repetition</h2>"));
    // A length with a unit, in a job file, of a model in another unit.
    shop.write(
        "job.toml",
        "repeat = '0.5cm'\npanels = 160\nmax-deviation = '2%'\n",
    );
    shop.succeed("mesh torus.obj -o again.obj --config job.toml");
    assert_eq!(shop.read("again.obj"), shop.read("equal.obj"));
}

#[test]
fn tolerances_without_meaning_are_refused() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 2000");
    shop.phex("mesh torus.obj -o o.obj -n 60 --repeat 0")
        .refuses(4, &["repeat"]);
    shop.phex("mesh torus.obj -o o.obj -n 60 --repeat 100m")
        .refuses(4, &["--repeat 100m: edges would be equal", "diagonal"]);
    // A percentage is one of the diagonal of all parts, and no part may be shorter than that.
    shop.succeed("shape wave -o wave.obj");
    let wave = String::from_utf8(shop.read("wave.obj")).unwrap();
    let vertices = wave.lines().filter(|l| l.starts_with("v ")).count();
    let [a, b, c] = [1, 2, 3].map(|k| vertices + k);
    let small = format!("v 9 0 0\nv 9.01 0 0\nv 9 0.01 0\nf {a} {b} {c}\n");
    shop.write("two.obj", format!("{wave}{small}"));
    shop.phex("mesh two.obj -o o.obj -n 60 --all-components --repeat 1%")
        .refuses(4, &["--repeat 1%: edges would be equal", "0.0141 m"]);
    for wrong in ["-1mm", "nan", "inf", "1km"] {
        shop.phex(&format!("mesh torus.obj -o o.obj -n 60 --repeat={wrong}"))
            .refuses(2, &["repeat"]);
    }
    shop.phex("mesh torus.obj -o o.obj --method koebe --repeat 1mm")
        .refuses(4, &["`repeat` has no effect with `koebe`"]);
    shop.write("job.toml", "[stages]\nrepeat_rel = 0.1\n");
    shop.phex("mesh torus.obj -o o.obj --config job.toml")
        .refuses(4, &["write `repeat` before all tables"]);
}

#[test]
fn a_contact_sheet_shows_every_way_or_says_that_there_was_one() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj --triangles 2000");
    shop.succeed(
        "mesh wave.obj -o a.obj -n 60 --effort best --contact-sheet a.html --report a.json",
    );
    let tried: Value = shop.json("a.json")["statistics"][0]["tried"].clone();
    let tried = tried.as_array().unwrap();
    let page = String::from_utf8(shop.read("a.html")).unwrap();
    assert_eq!(page.matches("<figure>").count(), tried.len() + 1);
    assert_eq!(page.matches("not chosen: ").count(), tried.len() - 1);
    assert!(page.contains(&format!("{} ways were tried", tried.len())));
    shop.succeed(
        "mesh wave.obj -o b.obj -n 60 --effort draft --contact-sheet b.png --report b.json",
    );
    assert!(shop.read("b.png").starts_with(b"\x89PNG"));
    let outputs = shop.json("b.json")["outputs"].to_string();
    assert!(outputs.contains("contact_sheet"), "{outputs}");
    shop.succeed("mesh wave.obj -o c.obj -n 60 --effort draft --contact-sheet c.html");
    let page = String::from_utf8(shop.read("c.html")).unwrap();
    assert!(page.contains("nothing to choose from"));
    shop.phex("mesh wave.obj -o d.obj -n 60 --contact-sheet d.jpg")
        .refuses(2, &["a contact sheet is a .png or a .html file"]);
}

#[test]
fn the_table_of_panels_says_how_near_each_is_to_the_limits() {
    let shop = Workshop::new();
    shop.succeed("shape wave -o wave.obj --triangles 2000");
    shop.succeed("mesh wave.obj -o a.obj -n 60 --report a.json");
    let longest = shop.json("a.json")["measures"]["edge_length"]["max"]
        .as_f64()
        .unwrap();
    let mean = shop.json("a.json")["measures"]["mean_edge"]
        .as_f64()
        .unwrap();
    let limit = 0.9 * longest * mean;
    shop.write(
        "job.toml",
        format!("[limits]\nmax-edge = {limit}\nmin-angle = 10\n"),
    );
    shop.succeed(
        "fab a.obj -o parts --thickness 1mm --sheet 9000x9000 --nest-effort 0 --limits job.toml",
    );
    let table = String::from_utf8(shop.read("parts/panels.csv")).unwrap();
    let mut rows = table.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    let column = |name: &str| head.iter().position(|h| *h == name).unwrap();
    let (edge, lengths) = (column("max_edge_used"), column("lengths_mm"));
    let mut most: f64 = 0.0;
    for row in rows {
        let used: f64 = row[edge].parse().unwrap();
        let own = row[lengths]
            .split([' ', ';'])
            .map(|l| l.parse::<f64>().unwrap());
        assert!(
            (used - own.fold(0.0, f64::max) / 1000.0 / limit).abs() < 1e-4,
            "{row:?}"
        );
        most = most.max(used);
    }
    assert!((most - 1.0 / 0.9).abs() < 1e-3, "{most}");
    assert!(head.contains(&"min_angle_used") && !head.contains(&"min_edge_used"));
}
