//! Panels with the symmetries of their surface: `symmetric_panels [SURFACE PANELS SYMMETRY
//! [MESH]]`.
//!
//! Without arguments a torus gets 300 panels. SYMMETRY is `auto`, `mirror` or the order of a
//! rotation. What is printed is what was found, how many panels differ, and how many vertices are
//! the images of others to the last bit.

use phex::symmetry::Symmetry;
use phex::{MeshOptions, Mesher, PanelSize, Surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{VertexId, measure};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let surface = match words.first() {
        Some(file) => Surface::read(file)?,
        None => triangulate(
            &Shape::from_name("torus", &[])?,
            &TriangulationOptions::default(),
        )?,
    };
    let panels = words.get(1).map_or(Ok(300), |w| w.parse())?;
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        symmetry: words.get(2).map_or(Ok(Symmetry::Auto), |w| w.parse())?,
        ..Default::default()
    };
    let made = Mesher::new().options(options).run(&surface)?;
    let (run, figures) = (&made.run, measure(made.mesh()));
    println!(
        "{} panels, {} not hexagonal inside; planarity {:.1e} mean edges; {} violations",
        figures.faces,
        phex_mesh::irregular_faces(run.mesh.topology()),
        figures.planarity.max,
        run.violations().len()
    );
    if let (Some(found), Some(orbits)) = (&run.statistics.symmetry, &run.orbits) {
        let place = |v: u32| run.mesh.position(VertexId::new(v));
        let vertices = orbits.vertices.iter().enumerate();
        let exact = vertices.filter(|(v, (source, operation))| {
            let image = orbits.operations[*operation as usize].image(place(*source));
            *operation > 0 && image == place(*v as u32)
        });
        println!(
            "{}, order {}, to {:.1e} of the diagonal; {} panels differ; {} of {} vertices are images",
            found.group,
            found.order,
            found.distance_rel,
            found.distinct_panels,
            exact.count(),
            orbits.vertices.len()
        );
    }
    for stage in &run.stages {
        println!("{:>10} {:.2} s", stage.stage, stage.seconds);
    }
    if let Some(file) = words.get(3) {
        made.write(file)?;
    }
    Ok(())
}
