//! `phex dual`, `phex subdivide`, `phex power-diagram`, `phex dupin`, and methods that refuse a
//! surface.
use crate::common::Workshop;
use phex_mesh::io::read_soup;

#[test]
fn dual_of_the_dual_is_the_mesh() {
    let shop = Workshop::new();
    shop.succeed("power-diagram --goldberg 2,1 --axes 1.4,1,0.8 -o dome.obj");
    shop.succeed("dual dome.obj -o dual.obj --centre=0.1,-0.05,0.1 --radius 0.8");
    shop.succeed("dual dual.obj -o back.obj --centre=0.1,-0.05,0.1 --radius 0.8");
    let read = |name: &str| read_soup(&shop.path(name)).unwrap();
    let (mesh, dual, back) = (read("dome.obj"), read("dual.obj"), read("back.obj"));
    assert_eq!((dual.positions.len(), dual.faces.len()), (72, 140));
    assert_eq!(mesh.faces.len(), back.faces.len());
    for (p, q) in mesh.positions.iter().zip(&back.positions) {
        assert!((p - q).norm() < 1e-10, "{p:?} {q:?}");
    }
    // The same by the matrix of the unit sphere.
    shop.succeed("dual dome.obj -o q.obj --quadric=1,0,0,0,1,0,0,1,0,-1");
    shop.succeed("dual dome.obj -o s.obj --centre=0,0,0");
    assert_eq!(shop.read("q.obj"), shop.read("s.obj"));
    let run = shop.phex("dual dome.obj -o x.obj --quadric=0,0,0,0,0,0,0,0,0,0");
    run.refuses(4, &["dome.obj", "singular"]);
}

#[test]
fn goldberg_polyhedra_and_given_sites() {
    let shop = Workshop::new();
    let run = shop.succeed("power-diagram --goldberg 3,0 -o dome.obj --png dome.png");
    assert!(
        run.stdout
            .contains("92 (80 hexagons, 12 pentagons; 0 concave)"),
        "{}",
        run.stdout
    );
    let lattice = (-4..=4).flat_map(|i| (-4..=4).map(move |j| (i, j)));
    let site = |(i, j): (i32, i32)| {
        let (x, y) = (f64::from(i) + 0.5 * f64::from(j), 0.866 * f64::from(j));
        format!("{} {} {}\n", 0.3 * x, 0.3 * y, 0.01 * x.sin())
    };
    shop.write(
        "sites.txt",
        "# x y weight\n".to_owned() + &lattice.map(site).collect::<String>(),
    );
    let run = shop.phex("power-diagram --sites sites.txt -o sites.obj --report sites.json");
    let input = &shop.json("sites.json")["inputs"][0];
    assert_eq!(input["path"], "sites.txt");
    assert_eq!(input["sha256"].as_str().map(str::len), Some(64));
    assert!(
        run.stdout.contains("every face"),
        "{} {}",
        run.stdout,
        run.stderr
    );
    shop.succeed("power-diagram --goldberg 2,1 --axes 2,1,0.5 -o axes.obj");
    shop.succeed("power-diagram --goldberg 2,1 --affine=2,0,0,0,0,1,0,0,0,0,0.5,0 -o affine.obj");
    assert_eq!(shop.read("axes.obj"), shop.read("affine.obj"));
    let run = shop.phex("power-diagram --goldberg 2,1 --affine=1,0,0,0,1,0,1,1,0 -o flat.obj");
    run.refuses(4, &["singular"]);
    shop.write("bad.txt", "0 0\n1 x\n");
    let run = shop.phex("power-diagram --sites bad.txt -o bad.obj");
    run.refuses(4, &["bad.txt:2", "1 x"]);
    let run = shop.phex("power-diagram --goldberg 0,0 -o bad.obj");
    run.refuses(4, &["(0, 0)"]);
    assert!(!shop.files().contains(&"bad.obj".to_owned()));
}

#[test]
fn every_rule_of_subdivision_keeps_panels_planar() {
    let shop = Workshop::new();
    shop.succeed("shape ellipsoid -o surface.obj --triangles 2000");
    shop.succeed("power-diagram --goldberg 2,0 --axes 1.5,1,0.7 -o coarse.obj");
    for rule in ["loop", "butterfly", "robust --surface surface.obj"] {
        let run = shop.phex(&format!(
            "subdivide coarse.obj -o fine.obj -l 2 --rule {rule} --report r.json"
        ));
        assert!(
            run.stdout.contains("642 ("),
            "{rule}: {} {}",
            run.stdout,
            run.stderr
        );
        let report = shop.json("r.json");
        let planarity = report["measures"]["planarity"]["max"].as_f64().unwrap();
        assert!(planarity < 1e-12, "{rule}: {planarity}");
        assert_eq!(report["measures"]["faces_not_simple"], 0, "{rule}");
    }
    assert!(
        shop.json("r.json")["deviation_facets"]["deviation_max"]
            .as_f64()
            .unwrap()
            < 5e-3
    );
    shop.write(
        "quads.off",
        "OFF\n5 4 0\n0 0 1\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n3 0 1 2\n3 0 2 3\n3 0 3 4\n3 0 4 1\n",
    );
    let run = shop.phex("subdivide quads.off -o x.obj --rule loop");
    run.refuses(4, &["vertex 0", "4 faces"]);
    assert!(!shop.files().contains(&"x.obj".to_owned()));
}

#[test]
fn indicatrices_are_written_and_panels_measured_against_them() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 4000");
    let run = shop.succeed("dupin torus.obj -o curves.obj -n 60");
    assert!(run.stdout.contains("60 indicatrices"), "{}", run.stdout);
    shop.succeed("mesh torus.obj -o mesh.obj --method brick-wall -n 200 -q");
    shop.succeed("dupin torus.obj -o inscribed.obj --panels mesh.obj");
    shop.succeed("render mesh.obj -o picture.png --curves inscribed.obj --size 200x150");
    // Of a torus of hexagons one in seven at the least, and one in three at the most, has no corner
    // in common with another.
    let count = |run: crate::common::Run| -> usize {
        let words = run.stdout.split_whitespace().nth(1);
        words.and_then(|n| n.parse().ok()).expect("a number")
    };
    let all = count(shop.succeed("dupin torus.obj -o inscribed.obj --panels mesh.obj"));
    let apart = count(shop.succeed("dupin torus.obj -o apart.obj --panels mesh.obj --apart"));
    assert!(7 * apart >= all && 3 * apart <= all, "{apart} of {all}");
    let run = shop.succeed("check mesh.obj --surface torus.obj --report check.json");
    assert!(
        run.stdout.contains("(root mean square of its corners)"),
        "{}",
        run.stdout
    );
    let mean = shop.json("check.json")["statistics"]["indicatrix"]["all"]["mean"]
        .as_f64()
        .unwrap();
    assert!(mean > 1e-4 && mean < 0.1, "{mean}");
    let run = shop.phex("dupin torus.obj -o curves.ply");
    run.refuses(4, &["OBJ only"]);
}

#[test]
fn the_projective_dual_takes_any_quadric() {
    let shop = Workshop::new();
    shop.succeed("shape ellipsoid -o surface.obj --triangles 2000");
    let mesh = "mesh surface.obj --method projective-dual -n 100";
    let run = shop.phex(&format!(
        "{mesh} -o near.obj --quadric=1,0,0,0,1,0,0,1,0,-1"
    ));
    assert!(
        run.stdout.contains("every face"),
        "{} {}",
        run.stdout,
        run.stderr
    );
    // Another one: panels elsewhere.
    let run = shop.phex(&format!(
        "{mesh} -o far.obj --quadric=1,0,0,0.3,2,0,0,1,0.1,-1"
    ));
    assert!(
        run.stdout.contains("every face"),
        "{} {}",
        run.stdout,
        run.stderr
    );
    assert_ne!(shop.read("near.obj"), shop.read("far.obj"));
    // A sphere about a point outside, through which tangent planes pass.
    let run = shop.phex(&format!("{mesh} -o x.obj --quadric=-8,0,0,-3,1,0,0,1,0,-1"));
    run.refuses(4, &["projective-dual", "centre", "vertex"]);
    let run = shop.phex(&format!("{mesh} -o x.obj --quadric=0,0,0,0,0,0,0,0,0,0"));
    run.refuses(4, &["singular"]);
}

#[test]
fn open_meshes_are_subdivided_with_their_rim() {
    let shop = Workshop::new();
    shop.succeed("shape hyperbolic-paraboloid -o surface.obj --triangles 2000");
    shop.phex("mesh surface.obj -o coarse.obj -n 40");
    for rule in ["loop", "butterfly"] {
        shop.phex(&format!(
            "subdivide coarse.obj -o fine.obj --rule {rule} --report r.json"
        ));
        let measures = &shop.json("r.json")["measures"];
        assert!(
            measures["planarity"]["max"].as_f64().unwrap() < 1e-12,
            "{rule}"
        );
        assert_eq!(measures["boundary_loops"], 1, "{rule}");
        // The square has area 4, and more as it is curved.
        assert!(measures["area"].as_f64().unwrap() > 4.0, "{rule}");
    }
}

#[test]
fn rules_through_the_dual_refuse_a_mesh_with_curvature_of_both_signs() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 4000");
    shop.succeed("mesh torus.obj -o coarse.obj -n 150 --method brick-wall --max-deviation 5%");
    for rule in ["loop", "butterfly"] {
        let run = shop.phex(&format!("subdivide coarse.obj -o x.obj --rule {rule} -l 2"));
        run.refuses(
            4,
            &["positive at vertex", "negative at vertex", "folds over"],
        );
        assert!(!shop.files().contains(&"x.obj".to_owned()));
    }
    let forced = "subdivide coarse.obj -o x.obj --rule butterfly --any-domain --report r.json";
    let run = shop.phex(forced);
    assert!(
        run.stdout.contains("outside: dual subdivision"),
        "{}",
        run.stdout
    );
    assert_eq!(run.code, Some(5), "{}", run.stdout);
    assert!(!shop.files().contains(&"x.obj".to_owned()));
    let run = shop.phex(&format!("{forced} --keep-invalid"));
    assert_eq!(run.code, Some(5), "{}", run.stdout);
    assert!(shop.files().contains(&"x.obj".to_owned()));
    let told = &shop.json("r.json")["statistics"]["outside_domain"];
    assert!(
        told.as_str().is_some_and(|t| t.contains("one sign")),
        "{told}"
    );
}

#[test]
fn a_method_says_where_the_surface_leaves_its_domain() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 2000");
    for method in [
        "projective-dual",
        "support-function",
        "dual-subdivision",
        "parallel",
    ] {
        let run = shop.phex(&format!("mesh torus.obj -o x.obj --method {method} -n 80"));
        run.refuses(4, &[method, "positive at vertex", "negative at vertex"]);
    }
    let run = shop.phex("mesh torus.obj -o x.obj --method power-diagram -n 80");
    run.refuses(4, &["ellipsoids only"]);
    assert_eq!(shop.files(), ["torus.obj"]);
    let run = shop.phex(
        "mesh torus.obj -o x.obj --method projective-dual -n 80 --any-domain --report r.json",
    );
    // What becomes of it stands far off the surface, or crosses itself.
    assert!(matches!(run.code, Some(3 | 5)), "{}", run.stdout);
    let told = &shop.json("r.json")["statistics"][0]["classical"];
    assert!(
        told["outside_domain"]
            .as_str()
            .unwrap()
            .contains("one sign")
    );
    assert!(told["defects"]["singular_edges"].as_u64().unwrap() > 10);
}

#[test]
fn surfaces_that_bend_in_one_direction_are_refused_by_methods_in_the_dual() {
    let shop = Workshop::new();
    shop.succeed("shape cylinder --triangles 2000 -o cylinder.obj");
    for method in ["projective-dual", "dual-subdivision", "parallel"] {
        shop.phex(&format!(
            "mesh cylinder.obj --method {method} -n 60 -o mesh.obj"
        ))
        .refuses(4, &["other than zero", "bends in one direction at most"]);
    }
}
