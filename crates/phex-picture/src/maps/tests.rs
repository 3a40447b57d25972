use super::*;
use phex::quality::{Assessment, Limits, References};
use phex::report::FeatureSizes;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{HexMesh, PanelLimits, TriangleSurface, Vec3};

/// A map of a mesh without a surface.
pub fn map(mesh: &HexMesh, map: Map) -> ColourMap {
    map_over(mesh, map, Range::Automatic)
}

fn map_over(mesh: &HexMesh, map: Map, range: Range) -> ColourMap {
    let assessment = Assessment::new(mesh, References::default(), &Limits::default());
    let subject = Subject {
        mesh,
        assessment: &assessment,
        surface: None,
    };
    ColourMap::over(map, &subject, range).unwrap()
}

/// A map that shows differences: not all elements have the colour of one end.
fn shows_differences(map: &ColourMap) -> bool {
    let ColourScale::Continuous(scale) = &map.scale else {
        return false;
    };
    let places = map.values.iter().filter(|v| !v.is_nan());
    let places: Vec<f64> = places.map(|&v| scale.place(v)).collect();
    let low = places.iter().copied().fold(1.0, f64::min);
    let high = places.iter().copied().fold(0.0, f64::max);
    high - low > 0.2
}

/// Three panels in a plane, their corners off it by thousandths of an edge: next to nothing in a
/// range for every mesh.
fn nearly_flat() -> HexMesh {
    let corner = |k: u32| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_3 * f64::from(k)).sin_cos();
        let off = 1e-3 * f64::from(k * k);
        Vec3::new(cos * (1.0 + off), sin, off)
    };
    let mut positions = vec![Vec3::zeros()];
    positions.extend((0..6).map(corner));
    HexMesh::new(positions, &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]).unwrap()
}

#[test]
fn a_map_of_a_good_mesh_is_not_blank() {
    let mesh = nearly_flat();
    for kind in [Map::Planarity, Map::Dihedral, Map::EdgeLength] {
        let shown = map(&mesh, kind);
        assert!(shows_differences(&shown), "{kind:?}: {:?}", shown.scale);
        let histogram = shown.histogram();
        assert_eq!(histogram.below + histogram.above, 0, "{kind:?}");
    }
    assert!(!shows_differences(&map_over(
        &mesh,
        Map::Dihedral,
        Range::Fixed
    )));
}

#[test]
fn a_range_of_one_s_choice_is_kept() {
    let given = map_over(&corner([1.0; 2]), Map::EdgeLength, Range::Given([0.5, 2.5]));
    let ColourScale::Continuous(scale) = given.scale else {
        panic!("lengths have a range");
    };
    assert_eq!((scale.low, scale.high), (0.5, 2.5));
}

/// Three unit squares round a corner of a cube; a corner of the first is at (x, y) in its plane.
fn corner([x, y]: [f64; 2]) -> HexMesh {
    let points = [
        (0.0, 0.0, 0.0),
        (1.0, 0.0, 0.0),
        (x, y, 0.0),
        (0.0, 1.0, 0.0),
        (0.0, 1.0, 1.0),
        (0.0, 0.0, 1.0),
        (1.0, 0.0, 1.0),
    ];
    let positions: Vec<Vec3> = points.iter().map(|&(x, y, z)| Vec3::new(x, y, z)).collect();
    HexMesh::new(positions, &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]).unwrap()
}

#[test]
fn dihedral_angles_of_a_cube_are_right_angles_and_the_boundary_has_none() {
    let dihedral = map_over(&corner([1.0; 2]), Map::Dihedral, Range::Fixed);
    let inner = dihedral.values.iter().filter(|v| !v.is_nan());
    let inner: Vec<f64> = inner.copied().collect();
    assert_eq!(inner.len(), 3);
    assert!(
        inner
            .iter()
            .all(|v| (v - 270.0).abs() < 1e-9 || (v - 90.0).abs() < 1e-9)
    );
    let histogram = dihedral.histogram();
    assert_eq!(histogram.counts.iter().sum::<usize>(), 3);
    assert_eq!(histogram.below + histogram.above, 3);
}

#[test]
fn edges_of_mean_length_are_in_the_middle_of_the_scale() {
    let lengths = map_over(&corner([1.0; 2]), Map::EdgeLength, Range::Fixed);
    assert!(lengths.values.iter().all(|v| (v - 1.0).abs() < 1e-12));
    let ColourScale::Continuous(scale) = &lengths.scale else {
        panic!("lengths have a range");
    };
    assert!((scale.place(1.0) - 0.5).abs() < 1e-12);
    assert!((scale.at(scale.place(0.7)) - 0.7).abs() < 1e-12);
}

#[test]
fn areas_are_over_the_mean_one_and_shapes_over_a_square() {
    let corners = [
        [0.0, 0.0],
        [1.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    let corners = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
    let mesh = HexMesh::new(corners, &[[0, 1, 4, 5], [1, 2, 3, 4]]).unwrap();
    assert_eq!(map(&mesh, Map::PanelArea).values, [0.5, 1.5]);
    let shapes = map(&mesh, Map::PanelAspect);
    assert!((shapes.values[0] - 1.0).abs() < 1e-12 && (shapes.values[1] - 3.0).abs() < 1e-12);
    let ColourScale::Continuous(scale) = &shapes.scale else {
        panic!("shapes are no classes")
    };
    assert_eq!(scale.low, 1.0, "no panel is wider than long");
}

#[test]
fn a_panel_that_crosses_itself_is_told_from_a_concave_one() {
    let class = |x, y| map(&corner([x, y]), Map::Validity).values[0] as usize;
    assert_eq!(values::VALIDITY[class(1.0, 1.0)].label, "convex, valid");
    assert_eq!(values::VALIDITY[class(0.3, 0.3)].label, "concave, valid");
    assert_eq!(
        values::VALIDITY[class(0.5, -0.5)].label,
        "self-intersecting"
    );
}

#[test]
fn panels_beyond_a_limit_are_outside_a_tolerance() {
    let mesh = corner([1.0; 2]);
    let limits = Limits {
        panels: PanelLimits {
            max_edge: Some(0.5),
            ..Default::default()
        },
        ..Default::default()
    };
    let assessment = Assessment::new(&mesh, References::default(), &limits);
    let subject = Subject {
        mesh: &mesh,
        assessment: &assessment,
        surface: None,
    };
    let shown = ColourMap::new(Map::Validity, &subject).unwrap();
    let label = |v: &f64| values::VALIDITY[*v as usize].label;
    assert!(
        shown
            .values
            .iter()
            .all(|v| label(v) == "outside a tolerance")
    );
}

#[test]
fn curvature_has_the_sign_of_the_surface() {
    let ratio = |name: &str, parameters: &[(&str, f64)]| {
        let options = TriangulationOptions {
            triangles: 3000,
            ..Default::default()
        };
        let surface: TriangleSurface =
            triangulate(&Shape::from_name(name, parameters).unwrap(), &options).unwrap();
        // A patch of the surface's own triangles stands for panels.
        let mesh = HexMesh::new(
            surface.positions().as_slice().to_vec(),
            &surface.topology().face_lists(),
        )
        .unwrap();
        let references = References {
            facets: Some(&surface),
            ..Default::default()
        };
        let assessment = Assessment::new(&mesh, references, &Limits::default());
        let subject = Subject {
            mesh: &mesh,
            assessment: &assessment,
            surface: Some(&surface),
        };
        let mut values = ColourMap::new(Map::Curvature, &subject).unwrap().values;
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    assert!(ratio("sphere", &[]) > 0.8);
    assert!(ratio("catenoid", &[]) < -0.8);
    assert!(ratio("cylinder", &[]).abs() < 0.1);
}

#[test]
fn without_a_surface_there_is_no_deviation() {
    let mesh = corner([1.0; 2]);
    let assessment = Assessment::new(&mesh, References::default(), &Limits::default());
    let subject = Subject {
        mesh: &mesh,
        assessment: &assessment,
        surface: None,
    };
    assert!(ColourMap::new(Map::Deviation, &subject).is_none());
}

#[test]
fn values_outside_of_the_range_keep_the_colours_of_its_ends() {
    let mesh = corner([1.0; 2]);
    let planarity = map_over(&mesh, Map::Planarity, Range::Fixed);
    let colour = |v: f64| planarity.scale.colour(v);
    assert_eq!(colour(0.0), colour(1e-12));
    assert_eq!(colour(7.0), colour(0.1));
    assert_ne!(colour(0.1), colour(1e-12));
    assert_eq!(scale::label(1e-12), "1e-12");
    assert_eq!(scale::label(0.25), "0.25");
    assert_eq!(scale::label(-1.0), "-1");
}

#[test]
fn histogram_counts_every_value_once() {
    let valence = map(&corner([1.0; 2]), Map::Valence).histogram();
    assert_eq!(valence.counts.iter().sum::<usize>(), 3);
    let planarity = map_over(&corner([1.0; 2]), Map::Planarity, Range::Fixed).histogram();
    assert_eq!((planarity.counts[0], planarity.below), (3, 3));
}

#[test]
fn panels_longer_than_the_radius_of_curvature_are_too_large() {
    let sphere = Shape::from_name("sphere", &[]).unwrap();
    let fine = |triangles| {
        let options = TriangulationOptions {
            triangles,
            ..Default::default()
        };
        triangulate(&sphere, &options).unwrap()
    };
    let (surface, panels) = (fine(8000), fine(1000));
    let positions = panels.positions().as_slice().to_vec();
    let small = HexMesh::new(positions, &panels.topology().face_lists()).unwrap();
    let lengths = small.topology().edges().map(|e| small.edge_length(e));
    let longest = lengths.fold(0.0, f64::max);
    let sizes = FeatureSizes::new(&small, &surface);
    assert!((sizes.max / longest - 1.0).abs() < 0.05, "the radius is 1");
    let judged = |mesh: &HexMesh| {
        let references = References {
            facets: Some(&surface),
            ..Default::default()
        };
        let tolerances = Limits {
            deviation_rel: Some(0.005),
            ..Default::default()
        };
        Assessment::new(mesh, references, &tolerances).checks
    };
    assert!(sizes.coarse.is_empty() && sizes.warning(&judged(&small)).is_none());

    let octant = vec![Vec3::x(), Vec3::y(), Vec3::z()];
    let large = HexMesh::new(octant, &[[0, 1, 2]]).unwrap();
    let sizes = FeatureSizes::new(&large, &surface);
    assert_eq!(sizes.coarse, [0], "the square root of 2");
    let warning = sizes.warning(&judged(&large)).unwrap();
    assert!(warning.contains("below the panel size"));
    assert_eq!(sizes.warning(&[]), None, "where the surface is not missed");
}

#[test]
fn a_panel_may_be_long_where_the_surface_is_straight() {
    // A strip of a cylinder of radius 1 about the x axis, and a panel 4 long and 0.2 round.
    let at = |x: f64, angle: f64| Vec3::new(x, angle.sin(), angle.cos());
    let (columns, rows) = (41u32, 21u32);
    let places = (0..columns * rows).map(|v| {
        let (i, k) = (f64::from(v % columns), f64::from(v / columns));
        at(0.15 * i - 3.0, 0.05 * k - 0.5)
    });
    let cells = (0..(columns - 1) * (rows - 1)).map(|c| (c % (columns - 1), c / (columns - 1)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, k)| {
            let a = k * columns + i;
            let (b, c, d) = (a + columns, a + columns + 1, a + 1);
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let surface = TriangleSurface::new(places.collect(), &triangles).unwrap();
    let corners = [(-2.0, -0.1), (-2.0, 0.1), (2.0, 0.1), (2.0, -0.1)];
    let positions = corners.map(|(x, angle)| at(x, angle)).to_vec();
    let mesh = HexMesh::new(positions, &[[0, 1, 2, 3]]).unwrap();
    let sizes = FeatureSizes::new(&mesh, &surface);
    assert!(sizes.max > 0.1 && sizes.max < 0.3, "{}", sizes.max);
}
