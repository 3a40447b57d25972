//! What a person meets in the first minutes: the program alone, files that it can't read, what it
//! says of a surface, what this machine has, and how to complain.
use crate::common::Workshop;
use std::io::Read;

fn roof() -> Workshop {
    let shop = Workshop::new();
    shop.succeed("shape roof --triangles 2000 -o roof.obj");
    shop
}

#[test]
fn the_program_alone_says_what_to_do_next() {
    let run = Workshop::new().succeed("");
    for command in [
        "phex info",
        "phex mesh",
        "phex fab",
        "phex help",
        "phex doctor",
    ] {
        assert!(run.stdout.contains(command), "{}", run.stdout);
    }
}

#[test]
fn files_of_other_kinds_are_refused_with_a_way_out() {
    let shop = Workshop::new();
    for (name, way) in [
        ("hall.3dm", "Mesh the surface"),
        ("hall.STEP", "Mesh the surface"),
        ("hall.igs", "Mesh the surface"),
        ("scan.xyz", "Poisson"),
        ("scan.laz", "Poisson"),
        ("hall.fbx", "export the surface as OBJ"),
        ("hall.zip", "unpack"),
        ("hall.xyzzy", "export the surface as OBJ"),
        ("hall", "the name has none"),
    ] {
        shop.write(name, "anything");
        for command in ["info", "mesh -o a.obj"] {
            let run = shop.phex(&format!("{command} {name}"));
            run.refuses(4, &[name, "unknown extension", way]);
        }
    }
    // What a file to be written lacks is not told as what one to be read lacks.
    shop.write(
        "square.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    );
    let run = shop.phex("convert square.obj hall.3dm");
    run.refuses(4, &["unknown extension `3dm`"]);
    assert!(!run.stderr.contains("NURBS"), "{}", run.stderr);
    shop.write("cloud.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    shop.phex("info cloud.obj")
        .refuses(4, &["no faces", "Poisson"]);
}

#[test]
fn quadrilaterals_are_told_apart_from_panels() {
    let shop = Workshop::new();
    shop.write(
        "quad.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
    );
    let said = shop.succeed("info quad.obj").stdout;
    assert!(
        said.contains("phex planarize") && said.contains("100 % of the area is flat"),
        "{said}"
    );
}

#[test]
fn info_suggests_numbers_of_panels_that_keep_what_is_asked_for() {
    let shop = roof();
    let run = shop.succeed("info roof.obj --edge-length 2m --max-deviation 0.2% --json");
    let told: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let [by_edge, by_distance] = [0, 1].map(|k| told["suggestions"][k].clone());
    assert!(
        (by_edge["edge_length"].as_f64().unwrap() - 2.0).abs() < 0.1,
        "{by_edge}"
    );
    assert!(told["kind"]["domes"].as_f64().unwrap() > 0.2, "{told}");
    // The suggestion is an estimate; a run with it is in the limit, and one with a fifth is not.
    let panels = by_distance["panels"].as_u64().unwrap();
    let code = |n: u64| {
        let line = format!("mesh roof.obj -n {n} --max-deviation 0.2% -q -o a.obj");
        shop.phex(&line).code
    };
    assert_eq!(
        (code(panels), code(panels / 5)),
        (Some(0), Some(3)),
        "{panels}"
    );
}

/// Numbers that `mesh` would refuse are not suggested.
#[test]
fn info_refuses_what_no_number_of_panels_gives() {
    let shop = roof();
    for (asked, told) in [
        (
            "--edge-length 0",
            "--edge-length 0: the length must be positive",
        ),
        ("--edge-length 1e-6", "at most 200000 make sense"),
        (
            "--max-deviation 0",
            "--max-deviation 0: the length must be positive",
        ),
    ] {
        shop.phex(&format!("info roof.obj {asked}"))
            .refuses(4, &[told]);
    }
    let told = shop.succeed("info roof.obj --max-deviation 0.001mm").stdout;
    assert!(told.contains("-n 200000"), "{told}");
    assert!(told.contains("not as near as 0.001mm"), "{told}");
}

/// Panels of a saddle stand off by the difference of its two curvatures.
#[test]
fn info_knows_that_saddles_take_more_panels() {
    let shop = Workshop::new();
    shop.succeed("shape hyperbolic-paraboloid -o saddle.obj");
    let run = shop.succeed("info saddle.obj --max-deviation 0.2% --json");
    let told: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let panels = &told["suggestions"][0]["panels"];
    shop.succeed(&format!(
        "mesh saddle.obj -n {panels} --max-deviation 0.2% -q -o a.obj"
    ));
}

#[test]
fn the_doctor_says_what_there_is_and_tries_it() {
    let said = Workshop::new().succeed("doctor").stdout;
    for word in [
        "phex",
        "processor",
        "memory",
        "viewer",
        "studio",
        "is valid",
    ] {
        assert!(said.contains(word), "{word} is missing in {said}");
    }
}

#[test]
fn a_bundle_holds_what_the_check_read_and_said() {
    let shop = roof();
    shop.succeed("mesh roof.obj -n 40 --max-deviation 2% --report run.json -o panels.obj");
    shop.succeed("check panels.obj --report-of run.json --bundle claim.zip");
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(shop.read("claim.zip"))).unwrap();
    let mut held = |name: &str| {
        let mut bytes = Vec::new();
        archive
            .by_name(name)
            .expect(name)
            .read_to_end(&mut bytes)
            .unwrap();
        bytes
    };
    for name in ["panels.obj", "roof.obj", "run.json"] {
        assert_eq!(held(&format!("inputs/{name}")), shop.read(name), "{name}");
    }
    let check: serde_json::Value = serde_json::from_slice(&held("check.json")).unwrap();
    assert_eq!(check["verdict"], "pass");
    let about = String::from_utf8(held("about.txt")).unwrap();
    assert!(
        about.starts_with("phex check panels.obj") && about.contains("processor"),
        "{about}"
    );
    let run = shop.phex("check panels.obj --bundle panels.obj");
    run.refuses(4, &["also read, or written twice"]);
}
