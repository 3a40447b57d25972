//! Runs on a surface that is kept.

use phex::{Boundary, MeshRun, Session, Silent, Surface, mesh_surface};
use phex::{Effort, Event, MeshOptions, Method, PanelSize, PipelineError, Progress};
use phex_mesh::HexMesh;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use std::sync::Mutex;

fn wave() -> Surface {
    let options = TriangulationOptions {
        triangles: 3000,
        ..Default::default()
    };
    triangulate(&Shape::from_name("wave", &[]).unwrap(), &options).unwrap()
}

fn panels(count: usize) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(count),
        ..Default::default()
    }
}

fn bits(mesh: &HexMesh) -> (Vec<Vec<u32>>, Vec<[u64; 3]>) {
    let bits = |p: &phex_mesh::Vec3| [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()];
    let places = mesh.positions.iter().map(bits).collect();
    (mesh.topology().face_lists(), places)
}

/// Whatever was run before, the bytes are those of a surface that is new.
#[test]
fn earlier_runs_change_nothing() {
    let surface = wave();
    let session = Session::new(surface.clone());
    let mut turned = panels(60);
    turned.directions.rotate = 0.3;
    let mut clipped = turned.clone();
    clipped.boundary = Boundary::Clip;
    let mut sized = clipped.clone();
    sized.size_field = Some(
        surface
            .positions()
            .iter()
            .map(|p| 1.0 + p.x.abs())
            .collect(),
    );
    let adaptive = {
        let mut options = panels(40);
        options.sizes.adaptive = Some(0.4);
        options
    };
    // With 40 panels the surface is so fine that it gets fewer vertices, how few the sizes decide.
    for options in [panels(60), turned, clipped, sized, panels(40), adaptive] {
        let fresh = mesh_surface(&surface, &options, &Silent).unwrap();
        let kept = session.run(&options, &Silent).unwrap();
        assert_eq!(bits(&fresh.mesh), bits(&kept.mesh));
    }
}

/// Long triangles are cut short for a lattice, and not for bricks.
#[test]
fn a_run_of_another_method_changes_nothing() {
    let ends = |j: u32| {
        let angle = std::f64::consts::PI * f64::from(j) / 40.0;
        [0.0, 3.0].map(|x| phex_mesh::Vec3::new(x, angle.cos(), angle.sin()))
    };
    let triangles = (0..40).flat_map(|j| {
        let [a, b, c, d] = [2 * j, 2 * j + 1, 2 * j + 3, 2 * j + 2];
        [[a, b, c], [a, c, d]]
    });
    let places = (0..=40).flat_map(ends).collect();
    let vault = Surface::new(places, &triangles.collect::<Vec<_>>()).unwrap();
    let mut lattice = panels(60);
    lattice.effort = Effort::Draft;
    lattice.target.corner_angle = 20.0;
    lattice.size_field = Some(vec![1.0; vault.positions().len()]);
    let bricks = MeshOptions {
        method: Method::BrickWall,
        size_field: None,
        ..lattice.clone()
    };
    let session = Session::new(vault.clone());
    for options in [lattice, bricks] {
        let fresh = mesh_surface(&vault, &options, &Silent).unwrap();
        let kept = session.run(&options, &Silent).unwrap();
        assert_eq!(bits(&fresh.mesh), bits(&kept.mesh));
    }
}

/// The stages that are computed; those that are looked up end at once.
#[derive(Default)]
struct Stages(Mutex<Vec<&'static str>>);

impl Progress for Stages {
    fn report(&self, event: &Event) {
        if let Event::StageStarted { stage } = event {
            self.0.lock().unwrap().push(stage);
        }
    }
}

fn seconds(stages: &[phex::pipeline::StageSeconds], name: &str) -> f64 {
    let of = stages.iter().filter(|s| s.stage == name);
    of.map(|s| s.seconds).sum()
}

/// A preview is the lattice that the first pass of a run starts from, and ends before anything is
/// planar.
#[test]
fn a_preview_shows_the_panels_of_the_run() {
    let session = Session::new(wave());
    let stages = Stages::default();
    let preview = session.lay_out(&panels(60), &stages).unwrap();
    let heard = stages.0.into_inner().unwrap();
    assert!(
        heard.contains(&"layout") && !heard.contains(&"optimise"),
        "{heard:?}"
    );
    let draft = MeshOptions {
        effort: Effort::Draft,
        ..panels(60)
    };
    let run: MeshRun = session.run(&draft, &Silent).unwrap();
    let first = session.lay_out(&draft, &Silent).unwrap();
    assert_eq!(
        first.mesh.topology().n_faces(),
        run.start.unwrap().faces.len()
    );
    assert!(preview.mesh.topology().n_faces() > 50);
    assert!(seconds(&first.stages, "layout") > 0.0);
    let planes = MeshOptions {
        method: Method::TangentPlanes,
        ..panels(60)
    };
    let refused = session.lay_out(&planes, &Silent);
    assert!(matches!(refused, Err(PipelineError::NoPreview)));
}

/// A draft makes one pass, and says what is wrong as any run does.
#[test]
fn a_draft_is_one_pass() {
    let draft = MeshOptions {
        effort: Effort::Draft,
        ..panels(120)
    };
    let run = mesh_surface(&wave(), &draft, &Silent).unwrap();
    assert_eq!(run.statistics.tried.len(), 1);
    assert!(run.statistics.search.is_none());
}
