//! `phex sweep`: what it says of variants, and what `collect` leaves alone.
use crate::common::Workshop;

/// A study's folder with a finished variant, written by hand.
fn with_variant() -> Workshop {
    let shop = Workshop::new();
    std::fs::create_dir_all(shop.path("study/whole")).unwrap();
    let run = r#"{ "version": "", "variant": {}, "limits": {}, "cost": { "seconds": 1, "megabytes": 1, "threads": 1 },
        "row": { "in:surface": "roof.obj", "out:status": "pass", "key": "whole" } }"#;
    shop.write("study/whole/run.json", run);
    shop
}

#[test]
fn collecting_replaces_nothing_of_others() {
    for name in ["designs.csv", "index.html"] {
        let shop = with_variant();
        shop.write(&format!("study/{name}"), "mine");
        let told = format!("{name} is in the way");
        shop.phex("sweep collect study").refuses(4, &[&told]);
        assert_eq!(shop.read(&format!("study/{name}")), b"mine");
        std::fs::remove_file(shop.path(&format!("study/{name}"))).unwrap();
        shop.succeed("sweep collect study");
        shop.succeed("sweep collect study --title other");
        shop.write(&format!("study/{name}"), "changed");
        let told = format!("{name} has been changed since");
        shop.phex("sweep collect study").refuses(4, &[&told]);
    }
}

#[test]
fn a_broken_variant_is_named_and_the_others_are_collected() {
    let shop = with_variant();
    std::fs::create_dir(shop.path("study/broken")).unwrap();
    shop.write("study/broken/run.json", "{ \"version\"");
    let run = shop.succeed("sweep collect study");
    for told in ["broken", "run the sweep again"] {
        assert!(run.stderr.contains(told), "{}", run.stderr);
    }
    let table = String::from_utf8(shop.read("study/designs.csv")).unwrap();
    assert_eq!(table.lines().count(), 2, "{table}");
}

#[test]
fn a_sweep_tells_of_its_size_of_doubles_and_of_panels_that_fit_no_sheet() {
    let shop = Workshop::new();
    shop.succeed("shape sphere --triangles 500 -o a/ball.obj");
    std::fs::create_dir(shop.path("b")).unwrap();
    shop.write("b/ball.obj", shop.read("a/ball.obj"));
    shop.write(
        "study.toml",
        "surfaces = ['a/ball.obj', 'b/ball.obj']\n[settings]\npanels = 32\neffort = 'draft'\nmax-deviation = '5%'\n\
         [workshop]\nthickness = '1mm'\nsheet = ['20mm', '10mm']\n",
    );
    let run = shop.succeed("sweep study.toml -o study");
    assert!(
        run.stdout.starts_with("study      2 variants\n"),
        "{}",
        run.stdout
    );
    assert!(run.stdout.contains("(workshop: "), "{}", run.stdout);
    let told = "one of the variants is the same as another and becomes one row with it (a/ball.obj and b/ball.obj hold";
    assert!(run.stderr.contains(told), "{}", run.stderr);
    shop.succeed("sweep collect study");
    let table = String::from_utf8(shop.read("study/designs.csv")).unwrap();
    assert!(table.contains("a/ball.obj"), "{table}");
}

#[test]
fn a_sweep_tells_of_each_variant_in_json_and_of_stages_where_asked() {
    let shop = Workshop::new();
    shop.succeed("shape sphere --triangles 500 -o ball.obj");
    let study = "surfaces = ['ball.obj']\n[settings]\neffort = 'draft'\nmax-deviation = '5%'\n[space]\npanels = [32, 36]\n";
    shop.write("study.toml", study);
    let run = shop.succeed("sweep study.toml -o study --progress json -v");
    let events = run.stderr.lines().filter(|line| line.starts_with('{'));
    let events: Vec<serde_json::Value> = events
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let names: Vec<&str> = events.iter().filter_map(|e| e["event"].as_str()).collect();
    assert_eq!(names, ["variant", "progress", "variant", "progress"]);
    assert_eq!(events[2]["row"]["in:panels"], 36);
    assert_eq!(
        (&events[1]["done"], &events[3]["done"]),
        (&0.5.into(), &1.0.into())
    );
    assert!(run.stderr.contains("optimise: done"), "{}", run.stderr);
}
