//! The methods by planes and poles, on the surfaces that they are made for and on others.
use phex::classical::one_sign;
use phex::classical::{DomainError, LocatedVertex};
use phex::layout::LayoutError;
use phex::pipeline::Method;
use phex::{MeshOptions, MeshRun, PanelSize, PipelineError, Silent, mesh_surface};
use phex_mesh::polygon::is_simple;
use phex_mesh::{FlatFace, TriangleSurface, Violation, measure};

fn options(method: Method) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(120),
        method,
        ..Default::default()
    }
}

fn run(
    shape: &str,
    parameters: &[(&str, f64)],
    options: &MeshOptions,
) -> Result<MeshRun, PipelineError> {
    mesh_surface(
        &crate::common::shape_with(shape, parameters, 3000),
        options,
        &Silent,
    )
}

fn domain_error(shape: &str, method: Method) -> DomainError {
    match run(shape, &[], &options(method)) {
        Err(PipelineError::Layout(LayoutError::Domain(e))) => e,
        Err(other) => panic!("{shape}: {other}"),
        Ok(_) => panic!("{shape} is outside the domain of {method:?}"),
    }
}

const METHODS: [Method; 6] = [
    Method::PowerDiagram,
    Method::TangentPlanes,
    Method::ProjectiveDual,
    Method::DualSubdivision,
    Method::SupportFunction,
    Method::Parallel,
];

#[test]
fn planar_and_simple_on_their_domain() {
    let domain: [(&str, &[(&str, f64)]); 5] = [
        ("sphere", &[]),
        ("ellipsoid", &[]),
        ("ellipsoid", &[("a", 1.6), ("b", 1.0), ("c", 0.6)]),
        ("elliptic-paraboloid", &[]),
        ("hyperbolic-paraboloid", &[]),
    ];
    for method in METHODS {
        // Power diagrams know closed ellipsoids only; a piece of one follows below.
        let count = if method == Method::PowerDiagram { 3 } else { 5 };
        for (shape, parameters) in domain.into_iter().take(count) {
            let run = run(shape, parameters, &options(method)).unwrap();
            let measures = measure(&run.mesh);
            let planarity = measures.planarity.max;
            assert!(planarity < 1e-12, "{method:?} on {shape}: {planarity}");
            let crossed = measures.faces_not_simple;
            assert_eq!(crossed, 0, "{method:?} on {shape}");
            assert_eq!(measures.degree3, 1.0);
            assert!(
                (80..=160).contains(&measures.faces),
                "{method:?} on {shape}: {}",
                measures.faces
            );
            let flipped = |v: &Violation| {
                matches!(
                    v,
                    Violation::FlippedFace { .. } | Violation::WrongFan { .. }
                )
            };
            let turned = run.violations().iter().any(flipped);
            assert!(!turned, "{method:?} on {shape}");
        }
    }
}

/// Faces that are not simple, turned over, folded or crossed; short edges are not asked for.
fn faults(shape: &str, method: Method, panels: usize) -> usize {
    faults_on(&crate::common::shape(shape, 3000), method, panels)
}

fn faults_on(surface: &TriangleSurface, method: Method, panels: usize) -> usize {
    let mut options = options(method);
    options.size = PanelSize::Panels(panels);
    let run = mesh_surface(surface, &options, &Silent).unwrap();
    let measures = measure(&run.mesh);
    assert!(measures.planarity.max < 1e-12);
    assert_eq!(measures.faces_not_simple, 0);
    let found = run.violations();
    let wrong = found.iter().filter(|v| {
        use Violation::{Crossing, FlippedFace, Fold, NotSimple, WrongFan};
        matches!(
            v,
            NotSimple { .. } | FlippedFace { .. } | WrongFan { .. } | Fold { .. } | Crossing { .. }
        )
    });
    wrong.count()
}

#[test]
fn hyperbolic_patches_are_sound_at_any_size() {
    // Rows off the asymptotic directions and no dislocations: without them edges vanish and planes
    // meet behind each other.
    let methods = [
        Method::ProjectiveDual,
        Method::DualSubdivision,
        Method::SupportFunction,
    ];
    for (shape, method) in methods
        .into_iter()
        .flat_map(|m| ["hyperbolic-paraboloid", "hyperboloid"].map(|shape| (shape, m)))
    {
        for panels in [100, 150, 300] {
            assert_eq!(
                faults(shape, method, panels),
                0,
                "{method:?} on {shape}: {panels}"
            );
        }
    }
    for (shape, panels) in [("helicoid", 300), ("enneper", 300), ("hyperboloid", 300)] {
        assert_eq!(faults(shape, Method::TangentPlanes, panels), 0, "{shape}");
    }
}

#[test]
fn the_two_signs_of_a_torus_of_panels_are_told_with_a_vertex_each() {
    let mesh = run("torus", &[], &options(Method::BrickWall)).unwrap().mesh;
    let DomainError::MixedCurvature {
        positive, negative, ..
    } = one_sign(&mesh).unwrap_err()
    else {
        panic!("another error");
    };
    // Outside and inside of the circle of radius 1 round the axis.
    let from_axis = |p: LocatedVertex| p.position.xy().norm();
    assert!(from_axis(positive) > 1.1, "{positive}");
    assert!(from_axis(negative) < 0.9, "{negative}");
}

/// On these a panel at the boundary has no room, and one behind it that comes to lie there has none
/// either; of the parallel mesh one turns over when it is fitted.
#[test]
fn panels_behind_those_that_are_left_out_are_looked_at_again() {
    let saddle = crate::common::shape_with("hyperbolic-paraboloid", &[("b", 2.0)], 8_000);
    assert_eq!(faults_on(&saddle, Method::DualSubdivision, 600), 0);
    let enneper = crate::common::shape("enneper", 8_000);
    assert_eq!(faults_on(&enneper, Method::Parallel, 200), 0);
}

#[test]
fn facets_too_coarse_for_the_curvature_are_refused() {
    let crease = [("a", 0.05), ("b", 0.1)];
    let surface = crate::common::shape_with("hyperbolic-paraboloid", &crease, 600);
    for method in [
        Method::ProjectiveDual,
        Method::SupportFunction,
        Method::Parallel,
        Method::DualSubdivision,
    ] {
        let error = mesh_surface(&surface, &options(method), &Silent)
            .map(|_| ())
            .unwrap_err();
        let PipelineError::Layout(LayoutError::Domain(DomainError::Unresolved {
            degrees,
            place,
            ..
        })) = error
        else {
            panic!("{method:?}: {error}");
        };
        assert!(degrees > 30.0);
        // Coordinates go through a grid of 2^-32 diagonals.
        let nearest = surface.positions()[place.vertex];
        assert!((nearest - place.position).norm() < 1e-9 * surface.diagonal());
    }
    // Tangent planes can be taken of any lattice: the same is told as a remark.
    let run = mesh_surface(&surface, &options(Method::TangentPlanes), &Silent).unwrap();
    let told = run.statistics.classical.and_then(|c| c.outside_domain);
    assert!(told.is_some_and(|t| t.contains("tangent-planes") && t.contains("sign is not known")));
}

#[test]
fn panels_of_the_hull_are_convex_and_those_of_the_regular_triangulation_cross_themselves() {
    let parameters: [(&str, f64); 3] = [("a", 1.6), ("b", 1.0), ("c", 0.6)];
    let crossed = |method, hull| {
        let mut options = options(method);
        options.dual.hull = hull;
        let run = run("ellipsoid", &parameters, &options).unwrap();
        let measures = measure(&run.mesh);
        let told = run.statistics.classical.unwrap();
        // The rule is of second order; a hull is convex for sure.
        assert_eq!(told.forecast.is_none(), hull, "{method:?}");
        let flips = told.flips;
        (measures.faces_not_simple, measures.faces_concave, flips)
    };
    for method in [Method::SupportFunction, Method::ProjectiveDual] {
        let (not_simple, concave, flips) = crossed(method, true);
        assert_eq!((not_simple, concave), (0, 0), "{method:?}");
        assert!(flips.unwrap() > 0);
        let (not_simple, _, flips) = crossed(method, false);
        assert!(
            not_simple > 0 && flips.is_none(),
            "the rule of theory is sharp"
        );
    }
}

#[test]
fn other_surfaces_are_refused_and_the_place_is_named() {
    for method in [
        Method::ProjectiveDual,
        Method::SupportFunction,
        Method::DualSubdivision,
        Method::Parallel,
    ] {
        for shape in ["torus", "wave"] {
            let error = domain_error(shape, method);
            let DomainError::MixedCurvature {
                positive, negative, ..
            } = &error
            else {
                panic!("{shape}: {error}");
            };
            if shape == "torus" {
                let from_axis = |p: phex_mesh::Vec3| p.x.hypot(p.y);
                assert!(from_axis(positive.position) > 1.0 && from_axis(negative.position) < 1.0);
            }
            assert!(error.to_string().contains("at vertex"), "{error}");
        }
    }
    let monkey = domain_error("monkey-saddle", Method::SupportFunction);
    let DomainError::ManyToOne { first, second, .. } = &monkey else {
        panic!("{monkey}");
    };
    // The normals of x^3 - 3 x y^2 are even.
    let sum = first.position.xy() + second.position.xy();
    assert!(sum.norm() < 0.2, "{monkey}");
}

#[test]
fn a_flat_point_between_saddles_is_refused_and_named_by_a_vertex_of_the_input() {
    let surface = crate::common::shape("monkey-saddle", 3000);
    for method in [
        Method::ProjectiveDual,
        Method::DualSubdivision,
        Method::Parallel,
    ] {
        let error = domain_error("monkey-saddle", method);
        let DomainError::FlatPoint { place, .. } = &error else {
            panic!("{error}");
        };
        let p = surface.positions()[place.vertex];
        assert!((p - place.position).norm() < 1e-9, "{error}");
        assert!(p.norm() < 0.2, "{error}");
        let mut options = options(method);
        options.dual.any_domain = true;
        let told = run("monkey-saddle", &[], &options)
            .unwrap()
            .statistics
            .classical;
        assert!(told.unwrap().outside_domain.unwrap().contains("flat"));
    }
}

#[test]
fn panels_whose_planes_cut_nothing_off_are_taken_out() {
    // A convex surface with nearly flat parts, whose dual has ridges: the butterfly rule leaves
    // poles inside the hull.
    let sphere = crate::common::shape("sphere", 3000);
    let superellipsoid = |p: &phex_mesh::Vec3| {
        let sum: f64 = p.iter().map(|x| x.abs().powf(3.5)).sum();
        p * sum.powf(-1.0 / 3.5)
    };
    let positions = sphere.positions().iter().map(superellipsoid).collect();
    let blob =
        phex_mesh::TriangleSurface::new(positions, &crate::common::triangles(&sphere)).unwrap();
    let options = MeshOptions {
        size: PanelSize::Panels(240),
        ..options(Method::DualSubdivision)
    };
    let run = mesh_surface(&blob, &options, &Silent).unwrap();
    let measures = measure(&run.mesh);
    assert_eq!((measures.faces_not_simple, measures.faces_concave), (0, 0));
    assert!(measures.planarity.max < 1e-12);
    let told = run.statistics.classical.unwrap();
    assert!(told.flips.unwrap() > 0 && told.taken_out > 0, "{told:?}");
}

#[test]
fn asked_to_go_on_they_show_what_fails() {
    let mut options = options(Method::ProjectiveDual);
    options.dual.any_domain = true;
    let run = run("wave", &[], &options).unwrap();
    assert!(measure(&run.mesh).faces_not_simple > 0);
    assert!(!run.is_sound());
    let told = run.statistics.classical.unwrap();
    assert!(told.outside_domain.unwrap().contains("one sign"));
    assert!(told.defects.unwrap().singular_edges > 0);
}

#[test]
fn regularised_tangent_planes_leave_planarity_to_the_optimiser() {
    let raw = run("wave", &[], &options(Method::TangentPlanes)).unwrap();
    let mut options = options(Method::TangentPlanes);
    options.dual.regularisation = 0.2;
    let regularised = run("wave", &[], &options).unwrap();
    let invalid = |run: &MeshRun| measure(&run.mesh).faces_not_simple;
    assert!(invalid(&raw) > 5, "{}", invalid(&raw));
    assert_eq!(invalid(&regularised), 0);
    assert!(measure(&regularised.mesh).planarity.max < 1e-12);
}

#[test]
fn a_plane_has_no_meets() {
    let flat = run("plane", &[], &options(Method::TangentPlanes));
    let message = flat.map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("do not meet"), "{message}");
}

#[test]
fn power_diagrams_have_twelve_pentagons_and_know_a_piece_of_an_ellipsoid() {
    let run = run("ellipsoid", &[], &options(Method::PowerDiagram)).unwrap();
    let measures = measure(&run.mesh);
    assert_eq!((measures.face_sizes[&5], measures.faces), (12, 122));
    assert!(run.is_sound());
    let whole = crate::common::shape("ellipsoid", 3000);
    let upper = |t: &[u32; 3]| {
        t.iter()
            .all(|&v| whole.positions().as_slice()[v as usize].z > 0.2)
    };
    let kept: Vec<[u32; 3]> = crate::common::triangles(&whole)
        .into_iter()
        .filter(upper)
        .collect();
    let soup = phex_mesh::PolygonSoup {
        positions: whole.positions().as_slice().to_vec(),
        faces: kept.iter().map(|t| t.to_vec()).collect(),
    };
    let parts = phex_mesh::TriangleSurface::from_soup(&soup).unwrap();
    let piece = &parts.components[0].surface;
    let run = mesh_surface(piece, &options(Method::PowerDiagram), &Silent).unwrap();
    let measures = measure(&run.mesh);
    assert!((90..=150).contains(&measures.faces), "{}", measures.faces);
    assert!(
        run.mesh
            .topology()
            .faces()
            .all(|f| run.mesh.centre(f).z > 0.15)
    );
    assert_eq!(measures.faces_not_simple, 0);
    for shape in ["torus", "hyperboloid", "wave"] {
        let error = domain_error(shape, Method::PowerDiagram).to_string();
        assert!(error.contains("ellipsoids only"), "{error}");
    }
}

#[test]
fn forecast_agrees_with_what_becomes_of_the_planes() {
    let told = |shape: &str, parameters: &[(&str, f64)], method| {
        let mut options = options(method);
        options.size = PanelSize::Panels(250);
        options.dual.hull = false;
        let run = run(shape, parameters, &options).unwrap();
        let not_simple = measure(&run.mesh).faces_not_simple;
        (
            run.statistics.classical.unwrap().forecast.unwrap(),
            not_simple,
        )
    };
    for shape in ["sphere", "hyperbolic-paraboloid", "torus"] {
        let (forecast, crossed) = told(shape, &[], Method::TangentPlanes);
        assert!(
            forecast <= 2 && forecast.abs_diff(crossed) <= 1,
            "{shape}: {forecast} {crossed}"
        );
    }
    // Near parabolic curves terms of third order decide: the rule is too low, but says where it is
    // in doubt.
    for shape in ["wave", "b-spline"] {
        let run = run(shape, &[], &options(Method::TangentPlanes)).unwrap();
        let topology = run.mesh.topology();
        let inner = topology.inner_faces();
        let simple = |f| is_simple(&FlatFace::of(&run.mesh, f).polygon);
        let crossed = inner.filter(|f| !simple(*f)).count();
        let told = run.statistics.classical.as_ref().unwrap();
        let (sure, doubt) = (told.forecast.unwrap(), told.in_doubt.unwrap());
        let bounds = sure..=sure + doubt;
        assert!(
            bounds.contains(&crossed),
            "{shape}: {crossed} in {bounds:?}"
        );
    }
    // A regular triangulation of the dual that is obtuse in the metric II.
    let axes = [("a", 1.6), ("b", 1.0), ("c", 0.6)];
    let (forecast, crossed) = told("ellipsoid", &axes, Method::ProjectiveDual);
    let ratio = forecast as f64 / crossed as f64;
    assert!(
        crossed > 20 && (0.8..1.25).contains(&ratio),
        "{forecast} {crossed}"
    );
}
