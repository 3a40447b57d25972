//! The page as text: complete in itself, harmless, and with everything in it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use phex::quality::{Assessment, Limits, Reading, References};
use phex::report::{InputFile, RunReport};
use phex_html::{CurveFamily, Report, Viewer, page};
use phex_mesh::{HexMesh, PanelLimits, TriangleSurface, Vec3};
use serde_json::Value;

/// A name that does harm where it is not escaped.
const HOSTILE: &str = "</script><img src=x onerror=alert(1)>.obj";
const VIEWER: &str = "console.log('</script>')";

/// Three panels round a corner of a cube; `x` is a coordinate of a corner of the first.
fn corner(x: f64) -> HexMesh {
    let points = [
        (0.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (x, 1.0, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 1.0, 1.0),
        (0.0, 0.0, 1.0),
        (1.0, 0.0, 1.0),
    ];
    let positions = points.iter().map(|&(x, y, z)| Vec3::new(x, y, z)).collect();
    HexMesh::new(positions, &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]).unwrap()
}

fn run(mesh: &HexMesh, surface: Option<&TriangleSurface>) -> RunReport {
    let references = References {
        facets: surface,
        ..Default::default()
    };
    let mut run = RunReport::new(
        "report",
        Assessment::new(mesh, references, &Limits::default()),
    );
    run.settings = serde_json::json!({ "note": HOSTILE, "stages": { "seed": 7 } });
    run.notes = vec![HOSTILE.to_owned()];
    run.inputs = vec![InputFile {
        path: HOSTILE.to_owned(),
        sha256: "0".repeat(64),
        vertices: 7,
        faces: 3,
    }];
    run
}

fn made(mesh: &HexMesh, viewer: Option<Viewer>) -> String {
    let run = run(mesh, None);
    let report = Report {
        title: HOSTILE,
        command: "phex report '</script><b>'",
        run: &run,
        mesh,
        names: None,
        surface: None,
        start: None,
        curves: Err("no </script> either"),
    };
    page(&report, viewer).unwrap()
}

fn data(html: &str) -> Value {
    let open = "<script type=\"application/json\" id=\"phex-data\">";
    let start = html.find(open).expect("data in the page") + open.len();
    let end = start + html[start..].find("</script>").unwrap();
    serde_json::from_str(&html[start..end]).unwrap()
}

fn floats(value: &Value) -> Vec<f32> {
    let bytes = STANDARD.decode(value.as_str().unwrap()).unwrap();
    let words = bytes.chunks_exact(4);
    words
        .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

#[test]
fn nothing_is_loaded_from_anywhere() {
    for viewer in [None, Some(Viewer::from_script(VIEWER))] {
        let html = made(&corner(1.0), viewer);
        for address in [
            "http://",
            "https://",
            "src=\"//",
            "url(",
            "@import",
            "<link rel=\"style",
        ] {
            assert!(!html.contains(address), "{address}");
        }
        assert!(html.contains("default-src 'none'"));
    }
}

#[test]
fn texts_from_outside_are_no_markup() {
    let html = made(&corner(1.0), Some(Viewer::from_script(VIEWER)));
    assert!(!html.contains("<img src=x"));
    assert!(!html.contains("<b>'"));
    assert_eq!(
        html.matches("</script>").count(),
        2,
        "those that end the page's own scripts"
    );
    assert!(html.contains("&lt;img src=x onerror=alert(1)&gt;.obj"));
    assert_eq!(data(&html)["missing"]["curves"], "no </script> either");
}

#[test]
fn data_come_back_as_they_were() {
    let mesh = corner(1.0);
    let packed = data(&made(&mesh, Some(Viewer::from_script(VIEWER))));
    let positions = floats(&packed["mesh"]["positions"]);
    let centre = Vec3::repeat(0.5);
    let back = positions.chunks_exact(3).zip(&mesh.positions);
    for (p, q) in back {
        let p = Vec3::new(p[0].into(), p[1].into(), p[2].into()) + centre;
        assert!((p - q).norm() < 1e-6);
    }
    assert_eq!(floats(&packed["area"]), [1.0; 3]);
    let angles = floats(&packed["angles"]);
    assert!(angles.len() == 12 && angles.iter().all(|a| (a - 90.0).abs() < 1e-4));
    let maps = packed["maps"].as_array().unwrap();
    let names: Vec<&str> = maps.iter().map(|m| m["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "valence",
            "validity",
            "planarity",
            "panel-area",
            "panel-aspect",
            "edge-length",
            "dihedral",
            "curvature"
        ],
        "no surface, no deviation"
    );
    for map in maps {
        let counted: u64 = map["counts"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(Value::as_u64)
            .sum();
        let values = floats(&map["values"]);
        let there = values.iter().filter(|v| !v.is_nan()).count() as u64;
        assert_eq!(counted, there, "{}", map["name"]);
    }
}

#[test]
fn gauss_image_of_a_cube_corner_is_a_cube_corner() {
    let packed = data(&made(&corner(1.0), Some(Viewer::from_script(VIEWER))));
    let directions = floats(&packed["gauss"]["directions"]);
    let length = directions[..3].iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!(
        (length - 3.0_f32.sqrt()).abs() < 1e-5,
        "the corner moves along its diagonal"
    );
    assert!(packed["gauss"]["outward"].as_f64().unwrap() > 0.0);
}

#[test]
fn without_a_viewer_there_are_pictures_and_a_reason() {
    let html = made(&corner(1.0), None);
    assert!(html.contains("built without npm"));
    assert!(html.contains("<details id=\"pictures\" open>"));
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 8);
    assert!(!html.contains("phex-data") && !html.contains("id=\"phex-viewer\""));
    assert!(html.contains("Simple panels"), "tables are there");
}

#[test]
fn panels_that_cross_themselves_are_loud_and_first() {
    // The side from (1, 0) to (-1, 1) of the first panel crosses the one from (0, 1) to (0, 0).
    let html = made(&corner(-1.0), Some(Viewer::from_script(VIEWER)));
    assert!(html.contains("<span class=\"verdict invalid\">Invalid</span>"));
    let packed = data(&html);
    let first = &packed["offenders"][0];
    assert_eq!(
        (&first["kind"], &first["loud"]),
        (&"not_simple".into(), &true.into())
    );
    assert_eq!(first["faces"][0], 0);
}

#[test]
fn layers_are_there_when_they_are_given() {
    let mesh = corner(1.0);
    let triangles = [
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 4],
        [0, 4, 5],
        [0, 5, 6],
        [0, 6, 1],
    ];
    let surface = TriangleSurface::new(mesh.positions.as_slice().to_vec(), &triangles).unwrap();
    let run = run(&mesh, Some(&surface));
    let start = corner(1.2).to_soup();
    let names = ["A1", "A2", "B1"].map(str::to_owned);
    let curves = [CurveFamily {
        name: "rows".to_owned(),
        curves: vec![vec![Vec3::zeros(), Vec3::x()], vec![Vec3::y(); 3]],
    }];
    let report = Report {
        title: "corner",
        command: "phex",
        run: &run,
        mesh: &mesh,
        names: Some(&names),
        surface: Some(&surface),
        start: Some(&start),
        curves: Ok(&curves),
    };
    let packed = data(&page(&report, Some(Viewer::from_script(VIEWER))).unwrap());
    assert_eq!(packed["names"], serde_json::json!(names));
    assert_eq!(floats(&packed["surface"]["positions"]).len(), 21);
    assert_eq!(floats(&packed["curves"][0]["points"]).len(), 15);
    assert_eq!(floats(&packed["start"]["planarity"]).len(), 3);
    assert!(
        packed["maps"]
            .as_array()
            .unwrap()
            .iter()
            .any(|m| m["name"] == "deviation")
    );
    assert_eq!(packed["missing"], serde_json::json!({}));
}

#[test]
fn offenders_have_the_names_and_checks_the_words_of_the_page() {
    let mesh = corner(1.0);
    let limits = Limits {
        panels: PanelLimits {
            max_edge: Some(0.5),
            max_area: Some(0.5),
            ..Default::default()
        },
        ..Default::default()
    };
    let run = RunReport::new(
        "report",
        Assessment::new(&mesh, References::default(), &limits),
    );
    let names = ["A1", "A2", "B1"].map(str::to_owned);
    let report = Report {
        title: "corner",
        command: "phex",
        run: &run,
        mesh: &mesh,
        names: Some(&names),
        surface: None,
        start: None,
        curves: Err("none"),
    };
    let html = page(&report, Some(Viewer::from_script(VIEWER))).unwrap();
    assert!(html.contains("<td>panels A1, A2, B1, worst at"), "{html}");
    let packed = data(&html);
    let texts = packed["offenders"].as_array().unwrap().iter();
    let texts: Vec<&str> = texts.filter_map(|o| o["text"].as_str()).collect();
    assert!(
        texts.contains(&"Largest area: 2.000 times what is allowed"),
        "{texts:?}"
    );
    assert!(texts.iter().all(|text| !text.contains("--")), "{texts:?}");
}

#[test]
fn checks_have_the_typed_unit_a_place_that_can_be_found_and_what_helps() {
    let mesh = corner(1.0);
    let limits = Limits {
        panels: PanelLimits {
            max_panel: Some([0.5, 0.5]),
            min_edge: Some(1.1),
            ..Default::default()
        },
        ..Default::default()
    };
    let mut run = RunReport::new(
        "report",
        Assessment::new(&mesh, References::default(), &limits),
    );
    let check = run
        .assessment
        .checks
        .iter_mut()
        .find(|c| c.name == "min_edge")
        .unwrap();
    check.place = Some([512_347.7, 5_401_232.59, 414.87]);
    check.reading = Some(Reading {
        unit: "mm".to_owned(),
        limit: 1200.0,
        value: 1000.0,
        across: None,
    });
    let report = Report {
        title: "corner",
        command: "phex",
        run: &run,
        mesh: &mesh,
        names: None,
        surface: None,
        start: None,
        curves: Err("none"),
    };
    let html = page(&report, None).unwrap();
    for told in [
        "<td>1000</td><td>≥ 1200 mm</td>",
        "worst at (512347.7, 5401232.59, 414.87)",
        "What helps: about 2 panels instead of 3, if all grow alike",
        "min-edge asks for fewer panels, max-panel asks for more",
    ] {
        assert!(html.contains(told), "{told}: {html}");
    }
}

#[test]
fn same_input_same_bytes() {
    let viewer = Some(Viewer::from_script(VIEWER));
    assert_eq!(made(&corner(1.0), viewer), made(&corner(1.0), viewer));
}
