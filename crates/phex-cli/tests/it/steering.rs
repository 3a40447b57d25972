//! Holding vertices, dials, warm starts and sizes from files.
use crate::common::Workshop;

/// A height field on a grid, with `n` squares a side of length 10.
fn hill(n: usize) -> String {
    let at = |i: usize| 10.0 * i as f64 / n as f64 - 5.0;
    let mut text = String::new();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (at(i), at(j));
            let z = 2.0 - 0.05 * (x * x + 0.7 * y * y);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i + 1;
            text += &format!("f {} {} {} {}\n", a, a + 1, a + n + 2, a + n + 1);
        }
    }
    text
}

fn vertices(text: &str) -> Vec<[f64; 3]> {
    let lines = text.lines().filter_map(|l| l.strip_prefix("v "));
    let point = |l: &str| {
        let n: Vec<f64> = l.split_whitespace().map(|w| w.parse().unwrap()).collect();
        [n[0], n[1], n[2]]
    };
    lines.map(point).collect()
}

fn read(shop: &Workshop, name: &str) -> Vec<[f64; 3]> {
    vertices(&String::from_utf8(shop.read(name)).unwrap())
}

#[test]
fn pulled_inside_the_rim_stays_on_the_boundary() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    shop.write("pull.txt", "0.5 0.5 1.9 4\n-2 1 1.7\n");
    let distance = |run: &str| {
        let boundary = &shop.json(run)["boundary"];
        let both = ["to_curve_max", "from_curve_max"].map(|k| boundary[k].as_f64().unwrap());
        both[0].max(both[1])
    };
    shop.succeed("mesh hill.obj -o free.obj -n 60 --report free.json");
    shop.succeed("mesh hill.obj -o pulled.obj -n 60 --anchors pull.txt --report pulled.json");
    assert!(shop.read("pulled.obj") != shop.read("free.obj"));
    let (free, pulled) = (distance("free.json"), distance("pulled.json"));
    assert!(pulled < free + 1e-3, "{free} {pulled}");
}

#[test]
fn a_closed_surface_has_no_boundary_to_hold() {
    let shop = Workshop::new();
    shop.write(
        "ball.off",
        "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n\
        3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n",
    );
    let run = shop.phex("mesh ball.off -o m.obj -n 60 --ground");
    run.refuses(4, &["no boundary that a ground plane could hold"]);
}

#[test]
fn points_are_met_to_the_last_digit_and_an_earlier_mesh_is_taken_up() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    shop.write("points.txt", "# a column\n0.1 0.2 1.95\n-2.5, 1.25, 1.6\n");
    shop.succeed("mesh hill.obj -o held.obj -n 60 --fix points.txt --report run.json");
    let held = read(&shop, "held.obj");
    for p in [[0.1, 0.2, 1.95], [-2.5, 1.25, 1.6]] {
        assert!(held.contains(&p), "{p:?}");
    }
    let report = shop.json("run.json");
    assert_eq!(report["verdict"], "pass");
    let fixed = &report["settings"]["stages"]["steering"]["fixed_points"];
    assert_eq!(fixed.as_array().unwrap().len(), 2);
    let checks = report["checks"].as_array().unwrap();
    assert!(
        checks.iter().any(|c| c["name"] == "boundary"),
        "the rim is judged"
    );

    // A warm start, with vertices by number, and from a job file.
    shop.write("ids.txt", "0\n7\n");
    shop.write(
        "job.toml",
        "[steering]\nfix = 'IDS'\ncloseness = 4\n"
            .replace("IDS", &shop.path("ids.txt").display().to_string()),
    );
    shop.succeed(
        "mesh hill.obj -o again.obj --start held.obj --config job.toml --report again.json",
    );
    let report = shop.json("again.json");
    let [surface, start] = [0, 1].map(|i| &report["inputs"][i]);
    assert_eq!(
        (&surface["path"], &start["path"]),
        (&"hill.obj".into(), &"held.obj".into())
    );
    assert_eq!(report["settings"]["panels"], start["faces"]);
    // It asks for no number of panels where there are some.
    shop.phex("mesh hill.obj -o tight.obj --start held.obj --max-edge 1mm")
        .ends_well("a limit that the earlier mesh does not meet");
    let again = read(&shop, "again.obj");
    assert_eq!(again.len(), held.len());
    assert_eq!((again[0], again[7]), (held[0], held[7]));
    assert!(again != held);
    shop.succeed("planarize held.obj -o flat.obj --surface hill.obj --refit --config job.toml");
    let flat = read(&shop, "flat.obj");
    assert_eq!((flat[0], flat[7]), (held[0], held[7]));
    shop.write("unit.toml", "unit = 'mm'\n");
    for (typed, unit) in [("", "mm"), (" --unit ft", "ft")] {
        shop.succeed(&format!(
            "planarize held.obj -o flat.obj --config unit.toml --report flat.json{typed}"
        ));
        assert_eq!(shop.json("flat.json")["unit"], unit);
    }
    shop.phex("mesh hill.obj -o no.obj -n 60 --fix ids.txt")
        .refuses(4, &["--fix", "no numbers"]);
}

/// Edges of the surface's own boundary, and all of it: vertices of the adjoining edges stay where
/// they are, and panels planar.
#[test]
fn a_curve_along_the_boundary_itself_breaks_nothing() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    let points = vertices(&hill(20));
    let along = |numbers: Vec<usize>, closed: bool| {
        let mut text = String::new();
        for v in &numbers {
            let [x, y, z] = points[*v];
            text += &format!("v {x} {y} {z}\n");
        }
        let line = (1..=numbers.len()).chain(closed.then_some(1));
        text + "l" + &line.map(|k| format!(" {k}")).collect::<String>() + "\n"
    };
    let sides: [Vec<usize>; 4] = [
        (0..20).collect(),
        (0..20).map(|j| j * 21 + 20).collect(),
        (0..20).map(|i| 440 - i).collect(),
        (0..20).map(|j| (20 - j) * 21).collect(),
    ];
    for k in 0..4 {
        let mut side = sides[k].clone();
        side.push(sides[(k + 1) % 4][0]);
        shop.write(&format!("curve{k}.obj"), along(side, false));
    }
    shop.write("curve4.obj", along(sides.concat(), true));
    for k in 0..5 {
        shop.succeed(&format!(
            "mesh hill.obj -o out.obj -n 80 --curve curve{k}.obj -q"
        ));
    }
}

/// Two hills side by side: what is held goes to the nearest, the ground holds both, and a warm
/// start takes both.
#[test]
fn surfaces_of_several_parts_are_held_too() {
    let shop = Workshop::new();
    let one = hill(12);
    let count = vertices(&one).len();
    let mut both = one.clone();
    for line in one.lines() {
        let numbers: Vec<f64> = (line.split_whitespace().skip(1))
            .map(|w| w.parse().unwrap())
            .collect();
        match line.strip_prefix("v ") {
            Some(_) => both += &format!("v {} {} {}\n", numbers[0] + 20.0, numbers[1], numbers[2]),
            None => {
                let shifted = numbers.iter().map(|n| format!(" {}", *n as usize + count));
                both += &format!("f{}\n", shifted.collect::<String>());
            }
        }
    }
    shop.write("two.obj", both);
    shop.write("points.txt", "0.1 0.2 1.95\n20.1 0.2 1.95\n");
    shop.succeed(
        "mesh two.obj -o held.obj -n 80 --all-components --fix points.txt --ground=0,-5,0,0,1,0",
    );
    let held = read(&shop, "held.obj");
    for p in [[0.1, 0.2, 1.95], [20.1, 0.2, 1.95]] {
        assert!(held.contains(&p), "{p:?}");
    }
    let on_ground = |p: &&[f64; 3], side: bool| p[1] == -5.0 && (p[0] > 10.0) == side;
    for side in [false, true] {
        assert!(held.iter().filter(|p| on_ground(p, side)).count() >= 3);
    }
    shop.succeed("mesh two.obj -o warm.obj --all-components --start held.obj");
    assert_eq!(read(&shop, "warm.obj").len(), held.len());
}

#[test]
fn the_ground_is_met_exactly() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    shop.succeed("mesh hill.obj -o hill-phex.obj -n 80");
    let lowest = |points: &[[f64; 3]]| points.iter().map(|p| p[1]).fold(f64::MAX, f64::min);
    let before = lowest(&read(&shop, "hill-phex.obj"));
    shop.succeed(
        "planarize hill-phex.obj -o wall.obj --surface hill.obj --ground 0,-5,0,0,1,0 --ground-reach 0.4",
    );
    let on_plane = read(&shop, "wall.obj")
        .iter()
        .filter(|p| p[1] == -5.0)
        .count();
    assert!(on_plane >= 5, "{on_plane}, lowest before {before}");
    // Without a value, another option may follow.
    shop.succeed("planarize hill-phex.obj -o low.obj --ground --ground-reach 0.1 --fairness 2");
    let least = |points: &[[f64; 3]]| points.iter().map(|p| p[2]).fold(f64::MAX, f64::min);
    let ground = least(&read(&shop, "hill-phex.obj"));
    assert!(read(&shop, "low.obj").iter().any(|p| p[2] == ground));
    shop.phex("planarize hill-phex.obj -o no.obj --ground 99")
        .refuses(4, &["ground plane"]);
    shop.phex("planarize hill-phex.obj -o no.obj --ground 1,2")
        .refuses(2, &["1,2"]);
}

#[test]
fn wrong_files_are_refused_with_line_and_cause() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(6));
    shop.write("bad.txt", "0 0 0\n1 2\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --fix bad.txt")
        .refuses(4, &["bad.txt:2", "x y z"]);
    shop.write("word.txt", "0 0 zero\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --anchors word.txt")
        .refuses(4, &["word.txt:1"]);
    shop.write("comma.txt", "12,5 3 8\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --anchors comma.txt")
        .refuses(4, &["comma.txt:1", "decimals have a point"]);
    shop.write("weight.txt", "1 2 3\n0 0 1 -1\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --anchors weight.txt")
        .refuses(4, &["weight.txt:2", "a weight above 0"]);
    shop.write("empty.txt", "# none\n");
    for option in ["--fix", "--anchors", "--cones"] {
        shop.phex(&format!("mesh hill.obj -o a.obj -n 20 {option} empty.txt"))
            .refuses(4, &["empty.txt: no line of it holds numbers"]);
    }
    shop.write("far.txt", "500 0 0\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --fix far.txt")
        .refuses(4, &["fixed point 0"]);
    shop.write("none.obj", "v 0 0 0\n");
    shop.phex("mesh hill.obj -o a.obj -n 20 --curve none.obj")
        .refuses(4, &["no polyline"]);
    shop.write("sizes.txt", "1\n".repeat(48));
    shop.phex("mesh hill.obj -o a.obj --size-field sizes.txt")
        .refuses(4, &["48 sizes", "49 vertices"]);
    shop.write("sizes.txt", "1\n".repeat(48) + "0\n");
    shop.phex("mesh hill.obj -o a.obj --size-field sizes.txt")
        .refuses(4, &["sizes.txt:49", "positive"]);
    shop.phex("mesh hill.obj -o a.obj --fairness 0")
        .refuses(2, &["fairness"]);
}

#[test]
fn sizes_from_a_file_are_edge_lengths() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    // Half as long on the right.
    let sizes: String = (0..441)
        .map(|v| if v % 21 < 10 { "1.2\n" } else { "0.6\n" })
        .collect();
    shop.write("sizes.txt", sizes);
    let run = shop.succeed("mesh hill.obj -o sized.obj --size-field sizes.txt --report run.json");
    assert!(
        run.stdout
            .contains("size-field   lengths in a ratio of 2.00 are wanted"),
        "{}",
        run.stdout
    );
    let points = read(&shop, "sized.obj");
    let right = points.iter().filter(|p| p[0] > 1.0).count() as f64;
    let left = points.iter().filter(|p| p[0] < -1.0).count() as f64;
    assert!(right > 1.3 * left, "{right} {left}");
    let faces = shop.json("run.json")["measures"]["faces"].as_u64().unwrap();
    // 50 / (2.6 * 1.44) + 50 / (2.6 * 0.36) = 67
    assert!((50..90).contains(&faces), "{faces}");
}

#[test]
fn the_paper_s_solver_is_there_to_compare() {
    let shop = Workshop::new();
    shop.write("hill.obj", hill(20));
    shop.phex("mesh hill.obj -o a.obj -n 60 --solver tetrahedra --keep-invalid --report run.json");
    let report = shop.json("run.json");
    assert_eq!(
        report["settings"]["stages"]["optimise"]["solver"],
        "tetrahedra"
    );
    let planarity = report["measures"]["planarity"]["max"].as_f64().unwrap();
    assert!(planarity < 1e-6, "{planarity:e}");
    shop.phex("mesh hill.obj -o b.obj -n 60 --solver magic")
        .refuses(2, &["magic", "tetrahedra"]);
}

/// The rim at the bottom stands on the ground, and is judged like the one at the top.
#[test]
fn a_ground_plane_leaves_the_boundary_to_be_judged() {
    let shop = Workshop::new();
    shop.succeed("shape catenoid --triangles 3000 -o shell.obj");
    let check = |name: &str| {
        let report = shop.json("run.json");
        let checks = report["checks"].as_array().unwrap().clone();
        checks.into_iter().find(|c| c["name"] == name)
    };
    let line = "mesh shell.obj -o m.obj -n 200 --report run.json --max-deviation";
    shop.succeed(&format!("{line} 1% --ground -0.8"));
    assert_eq!(check("boundary").unwrap()["pass"], true);
    // Panels are never that near the rim: the check is made.
    shop.phex(&format!("{line} 0.0001% --ground -0.8"));
    let boundary = check("boundary").unwrap();
    assert_eq!(boundary["pass"], false);
    assert!(!boundary["ids"].as_array().unwrap().is_empty());
}

/// The plan of a pillow has its corners still when its rim, level as it is, is put on the ground.
#[test]
fn corners_of_the_plan_stay_on_the_ground() {
    let shop = Workshop::new();
    let n = 24;
    let at = |i: usize| -5.0 + 10.0 * i as f64 / n as f64;
    let mut text = String::new();
    for (i, k) in (0..=n).flat_map(|k| (0..=n).map(move |i| (i, k))) {
        let (x, y) = (at(i), at(k));
        let z = 2.0 * (1.0 - x * x / 25.0) * (1.0 - y * y / 25.0);
        text += &format!("v {x} {y} {z}\n");
    }
    for (i, k) in (0..n).flat_map(|k| (0..n).map(move |i| (i, k))) {
        let a = k * (n + 1) + i + 1;
        let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    shop.write("pillow.obj", text);
    shop.succeed("mesh pillow.obj -o m.obj -n 80 --ground --report run.json");
    let report = shop.json("run.json");
    let mut checks = report["checks"].as_array().unwrap().iter();
    let boundary = checks.find(|c| c["name"] == "boundary").unwrap();
    assert!(boundary["value"].as_f64().unwrap() > 0.0, "{boundary}");
    let points = read(&shop, "m.obj");
    for (x, y) in [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)] {
        let gap = |p: &[f64; 3]| (p[0] - x).hypot(p[1] - y);
        let gap = points.iter().map(gap).fold(f64::MAX, f64::min);
        assert!(gap < 0.05, "({x}, {y}): {gap}");
    }
    let standing = points.iter().filter(|p| p[2].abs() < 1e-9).count();
    assert!(standing > 20, "{standing}");
}

/// On a rim that is not level the ground takes no panels off the surface unless that is asked for,
/// which is told.
#[test]
fn a_rim_that_is_not_level_is_told() {
    let shop = Workshop::new();
    shop.succeed("shape catenoid --triangles 3000 -o level.obj");
    let text = String::from_utf8(shop.read("level.obj")).unwrap();
    let waved = text.lines().map(|line| match line.strip_prefix("v ") {
        None => line.to_owned() + "\n",
        Some(xyz) => {
            let p: Vec<f64> = (xyz.split_whitespace().map(|x| x.parse().unwrap())).collect();
            let lift = 0.1 * (2.0 * p[1].atan2(p[0])).sin() * (-p[2]).max(0.0);
            format!("v {} {} {}\n", p[0], p[1], p[2] + lift)
        }
    });
    shop.write("shell.obj", waved.collect::<String>());
    let run = shop.succeed("mesh shell.obj -o m.obj -n 200 --ground -0.8");
    assert!(run.stderr.contains("`--ground-reach 0."), "{}", run.stderr);
    let run = shop
        .phex("mesh shell.obj -o m.obj -n 200 --ground -0.8 --ground-reach 0.5 --report run.json");
    assert_eq!(run.code, Some(3), "{}", run.stdout);
    let report = shop.json("run.json");
    let far = report["checks"].as_array().unwrap().iter();
    let far = far.clone().find(|c| c["name"] == "deviation").unwrap();
    assert_eq!(far["pass"], false);
    assert!(far["place"][2].as_f64().unwrap() < -0.5, "{far}");
}
