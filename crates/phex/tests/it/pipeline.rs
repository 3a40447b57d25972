//! The whole flow: what every run promises, on surfaces of all kinds.
use crate::common::{figures, mapped, rotation, shape, two_components};
use phex::pipeline::{Candidate, Method};
use phex::trim::Boundary;
use phex::{
    Effort, Event, MeshOptions, MeshRun, PanelSize, PipelineError, Progress, Silent, mesh_surface,
};
use phex_mesh::{HexMesh, MeshMeasures, TriangleSurface, Vec3, deviation, measure, numbered};
use phex_numeric::Status;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

fn panels(count: usize) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(count),
        ..Default::default()
    }
}

fn run(surface: &TriangleSurface, count: usize) -> MeshRun {
    mesh_surface(surface, &panels(count), &Silent).unwrap()
}

/// The bits of a mesh.
fn bits(mesh: &HexMesh) -> (Vec<u64>, Vec<Vec<u32>>) {
    let coordinates = mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]);
    (
        coordinates.map(f64::to_bits).collect(),
        mesh.topology().face_lists(),
    )
}

/// Everything that a run promises when it says that its mesh is sound.
fn check(name: &str, surface: &TriangleSurface, asked: usize) {
    let run = run(surface, asked);
    let figures_of_run = measure(&run.mesh);
    assert!(run.is_sound(), "{name}: {:?}", run.violations());
    assert_eq!(run.outcome.status, Status::Converged, "{name}");
    assert!(figures_of_run.planarity.max <= 1e-12, "{name}");
    assert_eq!(figures_of_run.faces_not_simple, 0, "{name}");
    assert_eq!(figures_of_run.degree3, 1.0, "{name}");
    assert!(figures_of_run.clearance.min >= 0.05, "{name}");
    assert_eq!(
        figures(run.mesh.topology()),
        figures(surface.topology()),
        "{name}"
    );
    let ratio = figures_of_run.faces as f64 / asked as f64;
    assert!((ratio - 1.0).abs() < 0.15, "{name}: {ratio}");
    for to in [&run.target, surface] {
        let off = deviation(&run.mesh, to);
        assert!(off.deviation_max < 0.01, "{name}: {}", off.deviation_max);
    }
    assert_eq!(run.statistics.panels_asked, asked);
    let start = run.start.expect("a layout starts the optimiser");
    assert_eq!(start.faces.len(), figures_of_run.faces, "{name}");
    let foot = |p: &Vec3| (surface.closest_point(*p).position - p).norm();
    let far = start.positions.iter().map(foot).fold(0.0, f64::max);
    assert!(far < 0.01 * surface.diagonal(), "{name}: {far}");
}

#[test]
fn a_torus_is_meshed() {
    check("torus", &shape("torus", 2000), 200);
}

#[test]
fn a_wave_is_meshed() {
    check("wave", &shape("wave", 2000), 150);
}

#[test]
fn a_monkey_saddle_is_meshed() {
    check("monkey saddle", &shape("monkey-saddle", 2000), 150);
}

#[test]
fn a_camber_is_kept() {
    let rise = 0.1;
    let (width, depth) = (30.0, 20.0);
    let place = |k: u32| {
        let [u, v] = [k % 31, k / 31].map(|i| f64::from(i) / 30.0);
        let [across, along] = [u, v].map(|t| (std::f64::consts::PI * t).sin());
        Vec3::new(width * u, depth * v, rise * across * along)
    };
    let cells = (0..30 * 30).map(|k| k / 30 * 31 + k % 30);
    let halves = cells.flat_map(|k| [[k, k + 1, k + 32], [k, k + 32, k + 31]]);
    let triangles: Vec<[u32; 3]> = halves.collect();
    let surface = TriangleSurface::new((0..31 * 31).map(place).collect(), &triangles).unwrap();
    let run = run(&surface, 150);
    assert!(run.is_sound(), "{:?}", run.violations());
    let off = deviation(&run.mesh, &surface);
    let farthest = off.deviation_max.max(off.coverage_max) * off.diagonal;
    assert!(farthest < 0.2 * rise, "{farthest}");
}

#[test]
fn a_roof_is_meshed() {
    check("roof", &shape("roof", 2000), 150);
}

#[test]
fn a_b_spline_is_meshed() {
    check("b-spline", &shape("b-spline", 2000), 150);
}

#[test]
fn a_plane_is_meshed() {
    check("plane", &shape("plane", 500), 80);
}

/// Without curvature rows are straight, along the longest side: every panel off the boundary is a
/// hexagon, with all its sides alike.
#[test]
fn rows_on_a_plane_are_straight() {
    let made = run(&shape("plane", 500), 150);
    let figures = measure(&made.mesh);
    assert_eq!(figures.hex, Some(1.0));
    let turned = shape("plane", 500);
    let turned = mapped(&turned, |p| rotation() * p);
    let figures_turned = measure(&run(&turned, 150).mesh);
    assert_eq!(figures_turned.hex, Some(1.0));
    assert!(figures.clearance.min > 0.6, "{:?}", figures.clearance);
    assert!(figures.angle.min > 60.0, "{:?}", figures.angle);
}

/// A lens thinner than its panels: they meet at its rim like the sides of a blade, until they are
/// turned or the edges cut off.
#[test]
fn a_thin_body_does_not_fold() {
    let lens = mapped(&shape("sphere", 4000), |p| {
        Vec3::new(2.0 * p.x, 1.2 * p.y, 0.25 * p.z)
    });
    let run = run(&lens, 100);
    assert_eq!(run.violations(), []);
    assert!(measure(&run.mesh).planarity.max <= 1e-12);
}

/// Convex bodies need 12 pentagons and get no other irregular panel, not even where they are
/// pointed; all panels are convex. With as many panels as here this takes halves that are joined,
/// and a seamless lattice.
#[test]
fn ellipsoids_have_twelve_pentagons() {
    for [a, b, c] in [[1.5, 1.0, 0.7], [3.0, 1.0, 1.0]] {
        let ellipsoid = mapped(&shape("sphere", 4000), |p| {
            Vec3::new(a * p.x, b * p.y, c * p.z)
        });
        let mesh = run(&ellipsoid, 600).mesh;
        let topology = mesh.topology();
        let of = |n: usize| {
            topology
                .faces()
                .filter(|f| topology.valence(*f) == n)
                .count()
        };
        assert_eq!((of(5), of(6)), (12, topology.n_faces() - 12), "{a}:{b}:{c}");
        assert_eq!(measure(&mesh).faces_concave, 0);
    }
}

/// A ring can be covered with hexagons alone. Where its girth varies these differ much in size: by
/// default pairs of a pentagon and a heptagon even them out.
#[test]
fn pairs_even_panels_out_unless_hexagons_alone_are_asked_for() {
    let ring = mapped(&shape("torus", 4000), |p| {
        let far = (p.x * p.x + p.y * p.y).sqrt();
        let middle = Vec3::new(p.x / far, p.y / far, 0.0);
        middle + (p - middle) * (1.0 + 0.6 * p.x / far)
    });
    let spread = |mesh: &HexMesh| measure(mesh).evenness.unwrap().area_spread;
    let mut options = panels(400);
    let even = mesh_surface(&ring, &options, &Silent).unwrap();
    assert!(even.violations().is_empty() && measure(&even.mesh).irregular > 0);
    assert!(spread(&even.mesh) < 2.5, "{}", spread(&even.mesh));
    options.regular = true;
    let regular = mesh_surface(&ring, &options, &Silent).unwrap();
    assert!(regular.violations().is_empty());
    assert_eq!(measure(&regular.mesh).irregular, 0);
    assert!(spread(&regular.mesh) > 2.5, "{}", spread(&regular.mesh));
}

/// Side by side, a brick wall and all lattices are judged, and the one that is kept is what comes
/// out.
#[test]
fn the_best_of_the_portfolio_is_kept() {
    let torus = shape("torus", 2000);
    let options = MeshOptions {
        effort: Effort::Best,
        ..panels(120)
    };
    let run = mesh_surface(&torus, &options, &Silent).unwrap();
    let tried = &run.statistics.tried;
    assert_eq!(tried.len(), 2 + options.portfolio.len());
    let is_tried = |what: fn(&Candidate) -> bool| tried.iter().any(|t| what(&t.candidate));
    assert!(is_tried(|c| c.method == Method::BrickWall));
    assert!(is_tried(|c| c.resolving));
    let kept: Vec<_> = tried.iter().filter(|t| t.kept).collect();
    assert_eq!(kept.len(), 1);
    assert_eq!(kept[0].panels, run.mesh.topology().n_faces());
    assert_eq!(kept[0].irregular, 0);
    assert!(run.is_sound());
}

fn relative(m: &MeshMeasures) -> [f64; 6] {
    [
        m.edge_length.min,
        m.edge_length.max,
        m.clearance.min,
        m.angle.min,
        m.dihedral.max,
        m.mean_edge / m.diagonal,
    ]
}

/// A model in other units is the same model: absolute tolerances anywhere are caught.
#[test]
fn units_do_not_matter() {
    for name in ["b-spline", "torus", "monkey-saddle"] {
        let surface = shape(name, 1500);
        let reference = run(&surface, 80);
        for scale in [1e-3, 1e4] {
            let other = run(&mapped(&surface, |p| p * scale), 80);
            assert_eq!(
                reference.mesh.topology().face_lists(),
                other.mesh.topology().face_lists()
            );
            let pairs = [&reference, &other].map(|r| relative(&measure(&r.mesh)));
            // Where rounding ends up after 30 iterations; a unit that matters shows in the first
            // digits.
            for (a, b) in pairs[0].iter().zip(pairs[1]) {
                assert!((a - b).abs() <= 1e-7 * a.abs(), "{name} {a} {b} at {scale}");
            }
        }
    }
}

/// A patch whose radius of curvature is below the panel size: a last bit decides where its
/// dislocations lie.
fn wild_patch() -> TriangleSurface {
    mapped(&shape("plane", 1200), |p| {
        let z = 0.12 * (7.0 * p.x + 1.3 * p.y).sin() + 0.1 * (6.1 * p.y - 2.0 * p.x).cos();
        Vec3::new(p.x, p.y, z + 0.05 * (11.0 * p.x * p.y).sin())
    })
}

/// Few panels, laid out once.
fn hasty(count: usize) -> MeshOptions {
    MeshOptions {
        effort: Effort::Draft,
        ..panels(count)
    }
}

/// A hard model in metres and in millimetres, and moved, is the same model.
#[test]
fn neither_unit_nor_place_changes_the_panels() {
    let surface = wild_patch();
    let of = |s: &TriangleSurface| mesh_surface(s, &hasty(40), &Silent).unwrap().mesh;
    let reference = of(&surface);
    let millimetres = mapped(&surface, |p| p * 1000.0);
    let moved = mapped(&surface, |p| p + Vec3::new(3.1, -7.7, 12.3));
    for other in [millimetres, moved] {
        let other = of(&other);
        let lists = |mesh: &HexMesh| mesh.topology().face_lists();
        assert_eq!(lists(&other), lists(&reference));
    }
}

/// Sizes belong to vertices of the input.
#[test]
fn a_size_field_makes_panels_small_where_it_is_small() {
    let surface = shape("plane", 500);
    let size = |p: &Vec3| if p.x > 0.0 { 2.0 } else { 1.0 };
    let options = MeshOptions {
        size_field: Some(surface.positions().iter().map(size).collect()),
        ..panels(60)
    };
    let run = mesh_surface(&surface, &options, &Silent).unwrap();
    let mesh = run.mesh;
    let right = |f: &phex_mesh::FaceId| mesh.centre(*f).x > 0.0;
    let count = mesh.topology().faces().filter(right).count();
    assert!(2 * count + 4 < mesh.topology().n_faces(), "{count}");
    let evenness = phex_mesh::measure(&mesh).over_wished(&mesh, &run.wished);
    let evenness = evenness.evenness.expect("panels inside");
    let wished = evenness.over_wished.expect("sizes are wished for");
    assert!(wished.spread < 0.6 * evenness.area_spread, "{evenness:?}");
}

/// A tighter limit does not end farther from the surface where panels are too large for it.
#[test]
fn a_tighter_deviation_is_no_worse() {
    let surface = shape("monkey-saddle", 1500);
    let off = |limit: Option<f64>| {
        let mut options = panels(40);
        options.optimise.max_deviation = limit;
        let run = mesh_surface(&surface, &options, &Silent).unwrap();
        let deviation = deviation(&run.mesh, &run.target);
        deviation.deviation_max.max(deviation.coverage_inner_max)
    };
    let usual = off(Some(5e-3));
    for limit in [2e-3, 5e-4] {
        let tight = off(Some(limit));
        assert!(tight <= usual * (1.0 + 1e-9), "{limit}: {tight} {usual}");
    }
}

fn topology_key(
    run: &MeshRun,
) -> (
    usize,
    (i64, usize),
    std::collections::BTreeMap<usize, usize>,
) {
    let t = run.mesh.topology();
    (t.n_faces(), figures(t), crate::common::valences(&run.mesh))
}

/// Without the term that holds areas, panels slide along the surface.
#[test]
fn inner_panels_have_the_areas_that_are_asked_for() {
    let surface = shape("wave", 3000);
    let spread = |evenness: f64| {
        let mut options = panels(150);
        options.optimise.evenness = evenness;
        let run = mesh_surface(&surface, &options, &Silent).unwrap();
        assert!(run.is_sound());
        let evenness = phex_mesh::measure(&run.mesh).evenness;
        evenness.expect("panels inside").area_spread
    };
    let (even, free) = (
        spread(MeshOptions::default().optimise.evenness),
        spread(0.0),
    );
    assert!(even < 1.2 && free > 1.5, "{even} {free}");
}

/// A model turned in space, and moved, is the same model.
#[test]
fn turning_a_model_turns_its_panels() {
    let surface = shape("torus", 1500);
    let shift = Vec3::new(3.0, -1.0, 7.0);
    let turned = mapped(&surface, |p| rotation() * p + shift);
    let (a, b) = (run(&surface, 100), run(&turned, 100));
    assert!(a.is_sound() && b.is_sound());
    assert_eq!(topology_key(&a), topology_key(&b));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let surface = shape("wave", 1500);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| run(&surface, 80))
    };
    let (one, two) = (with(1), with(2));
    assert_eq!(bits(&one.mesh), bits(&two.mesh));
    assert_eq!(one.target.positions(), two.target.positions());
}

/// Remembers the events, and cancels after some.
struct Watch {
    events: Mutex<Vec<Event>>,
    questions: AtomicUsize,
    patience: usize,
    wants_best: bool,
}

impl Watch {
    fn new(patience: usize) -> Self {
        Self {
            wants_best: true,
            events: Mutex::default(),
            questions: AtomicUsize::new(0),
            patience,
        }
    }
}

impl Progress for Watch {
    fn report(&self, event: &Event) {
        self.events.lock().unwrap().push(event.clone());
    }
    fn is_cancelled(&self) -> bool {
        self.questions.fetch_add(1, Ordering::Relaxed) >= self.patience
    }
    fn wants_best(&self) -> bool {
        self.wants_best
    }
}

/// Same options, same bytes; and every stage that starts ends, in the order of the flow.
#[test]
fn a_run_can_be_repeated_and_watched() {
    let surface = shape("ellipsoid", 1000);
    let watch = Watch::new(usize::MAX);
    let first = mesh_surface(&surface, &panels(60), &watch).unwrap();
    let second = run(&surface, 60);
    assert_eq!(bits(&first.mesh), bits(&second.mesh));
    let events = watch.events.into_inner().unwrap();
    let mut open: Option<&str> = None;
    let mut order: Vec<&str> = Vec::new();
    for event in &events {
        match event {
            Event::StageStarted { stage } => {
                assert_eq!(open.replace(stage), None);
                if !order.contains(stage) {
                    order.push(stage);
                }
            }
            Event::StageFinished { stage } => assert_eq!(open.take(), Some(*stage)),
            Event::Iteration {
                stage,
                iteration,
                limit,
                ..
            } => assert!(open == Some(*stage) && (1..=*limit).contains(iteration)),
            Event::Note { message } => assert!(!message.is_empty()),
            Event::Counted { done, total, .. } => assert!(done <= total),
        }
    }
    let flow = [
        "target",
        "symmetry",
        "curvature",
        "directions",
        "layout",
        "optimise",
        "trim",
        "validate",
        "search",
    ];
    assert_eq!(order, flow);
    let timed: Vec<&str> = first.stages.iter().map(|s| s.stage).collect();
    assert_eq!(timed, flow);
}

/// Whenever the user loses patience: an error that says so, or a mesh that does not claim more than
/// it is.
#[test]
fn cancelling_is_safe_at_every_moment() {
    let surface = shape("monkey-saddle", 1000);
    let watch = Watch::new(usize::MAX);
    mesh_surface(&surface, &panels(40), &watch).unwrap();
    let questions = watch.questions.into_inner();
    assert!(questions > 10);
    let (mut refused, mut returned) = (0, 0);
    for patience in (0..questions).step_by(questions.div_ceil(16)).chain(0..6) {
        match mesh_surface(&surface, &panels(40), &Watch::new(patience)) {
            Err(PipelineError::Cancelled) => refused += 1,
            Err(e) => panic!("{e}"),
            Ok(run) => {
                returned += 1;
                assert_eq!(figures(run.mesh.topology()), (1, 1));
                assert!(measure(&run.mesh).planarity.max <= 1e-12 || !run.is_sound());
            }
        }
    }
    assert!(refused > 4 && returned > 0, "{refused} {returned}");
}

/// Who wants nothing any more waits for no further stage.
#[test]
fn a_run_of_which_nothing_is_wanted_ends_at_once() {
    let surface = shape("monkey-saddle", 1000);
    // Of several threads one may ask more often or less where another one is late.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().unwrap();
    let made = |watch: &Watch| pool.install(|| mesh_surface(&surface, &panels(40), watch));
    let watch = Watch::new(usize::MAX);
    made(&watch).unwrap();
    let questions = watch.questions.into_inner();
    for patience in (0..questions).step_by(questions.div_ceil(24)) {
        let watch = Watch {
            wants_best: false,
            ..Watch::new(patience)
        };
        let ended = made(&watch);
        assert!(
            matches!(ended, Err(PipelineError::Cancelled)),
            "{patience} of {questions}"
        );
    }
}

fn refusal(surface: &TriangleSurface, size: PanelSize) -> String {
    let options = MeshOptions {
        size,
        ..Default::default()
    };
    let result = mesh_surface(surface, &options, &Silent);
    result.err().expect("this can't be meshed").to_string()
}

#[test]
fn sizes_without_meaning_are_refused() {
    let surface = shape("plane", 200);
    let cases = [
        (PanelSize::Panels(0), "at least 1"),
        (PanelSize::Panels(usize::MAX), "more than 200000"),
        (PanelSize::EdgeLength(0.0), "positive"),
        (PanelSize::EdgeLength(-1.0), "positive"),
        (PanelSize::EdgeLength(f64::NAN), "positive"),
        (PanelSize::EdgeLength(f64::INFINITY), "positive"),
        (PanelSize::EdgeLength(1e-6), "more than 200000"),
        (PanelSize::EdgeLength(1e3), "at least 1"),
    ];
    for (size, expected) in cases {
        let message = refusal(&surface, size);
        assert!(message.contains(expected), "{size:?}: {message}");
    }
}

#[test]
fn several_components_are_refused() {
    let message = refusal(&two_components(), PanelSize::Panels(100));
    assert!(message.contains("2 components"), "{message}");
}

/// Far too few panels for the surface: a mesh of its topology or a clear refusal, never a panic or
/// a wrong claim.
#[test]
fn few_panels_give_a_mesh_or_a_reason() {
    for (name, count) in [
        ("torus", 1),
        ("torus", 5),
        ("sphere", 3),
        ("plane", 1),
        ("catenoid", 2),
        ("wave", 4),
    ] {
        let surface = shape(name, 500);
        match mesh_surface(&surface, &panels(count), &Silent) {
            Ok(run) => {
                assert_eq!(
                    figures(run.mesh.topology()),
                    figures(surface.topology()),
                    "{name}"
                );
                assert!(measure(&run.mesh).planarity.max <= 1e-12 || !run.is_sound());
            }
            Err(e) => assert!(!e.to_string().is_empty(), "{name}"),
        }
    }
}

#[test]
fn an_edge_length_is_met() {
    for (name, edge) in [("torus", 0.25), ("monkey-saddle", 0.16), ("plane", 0.15)] {
        let options = MeshOptions {
            size: PanelSize::EdgeLength(edge),
            ..Default::default()
        };
        let run = mesh_surface(&shape(name, 1500), &options, &Silent).unwrap();
        let ratio = run.mesh.mean_inner_edge() / edge;
        assert!((ratio - 1.0).abs() < 0.06, "{name}: {ratio}");
    }
}

/// Squares in a vault of which every second one at the boundary is missing.
fn vault_with_teeth() -> TriangleSurface {
    let n = 25;
    let at_rim = |i: u32| i == 0 || i == n - 1;
    let is_there = |i: u32, j: u32| match (at_rim(i), at_rim(j)) {
        (true, true) => false,
        (true, false) => j % 2 == 1,
        (false, true) => i % 2 == 1,
        (false, false) => true,
    };
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let corners = |(i, j)| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
    let squares: Vec<[(u32, u32); 4]> = (squares.filter(|(i, j)| is_there(*i, *j)))
        .map(corners)
        .collect();
    let (vertices, faces) = numbered(squares.iter().map(|s| s.iter().copied()));
    let place = |&(i, j): &(u32, u32)| {
        let [x, y] = [i, j].map(|k| 0.1 * f64::from(k));
        Vec3::new(x, y, 0.1 * (x - 1.2).powi(2))
    };
    let halves = |s: &Vec<u32>| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]];
    let triangles: Vec<[u32; 3]> = faces.iter().flat_map(halves).collect();
    TriangleSurface::new(vertices.iter().map(place).collect(), &triangles).unwrap()
}

#[test]
fn teeth_at_the_boundary_do_not_make_panels_grow() {
    let options = MeshOptions {
        size: PanelSize::EdgeLength(0.25),
        boundary: Boundary::Clip,
        effort: Effort::Draft,
        ..Default::default()
    };
    let run = mesh_surface(&vault_with_teeth(), &options, &Silent).unwrap();
    let panels = run.mesh.topology().n_faces();
    assert!((30..60).contains(&panels), "{panels}");
}
