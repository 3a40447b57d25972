//! What the dials do, and what the paper's own formulation does, measured on two surfaces: the
//! table of `docs/book/src/steering.md`.

use phex::optimise::{
    Dials, OptimiseOptions, Optimised, Solver, Steering, SurfaceTarget, Target, refit,
};
use phex::{MeshOptions, MeshRun, PanelSize, Silent, mesh_surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{HexMesh, measure};

const FACTORS: [f64; 2] = [0.1, 10.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| surface | setting | planarity | not simple | deviation max, rms % | of corners max % | least clearance | least angle | asymmetry |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for name in ["wave", "ellipsoid"] {
        let shape = Shape::from_name(name, &[])?;
        let surface = triangulate(&shape, &TriangulationOptions::default())?;
        let options = MeshOptions {
            size: PanelSize::Panels(300),
            ..MeshOptions::default()
        };
        let run = mesh_surface(&surface, &options, &Silent)?;
        for (setting, options) in settings(&options.optimise) {
            let result = again(&run, &options)?;
            println!("| {name} | {setting} | {}", row(&run, &result));
        }
    }
    Ok(())
}

/// The default, each dial turned down and up, and the other solver.
fn settings(default: &OptimiseOptions) -> Vec<(String, OptimiseOptions)> {
    let mut list = vec![("default".to_owned(), default.clone())];
    for name in ["fairness", "closeness", "clearance"] {
        for factor in FACTORS {
            let mut dials = Dials::default();
            match name {
                "fairness" => dials.fairness = factor,
                "closeness" => dials.closeness = factor,
                _ => dials.clearance = factor,
            }
            let mut options = default.clone();
            dials.turn(&mut options);
            list.push((format!("`--{name} {factor}`"), options));
        }
    }
    let dials = Dials {
        centres: 0.0,
        ..Dials::default()
    };
    let mut on_surface = default.clone();
    dials.turn(&mut on_surface);
    list.push(("`--centres 0`".to_owned(), on_surface));
    let tetrahedra = OptimiseOptions {
        solver: Solver::Tetrahedra,
        ..default.clone()
    };
    list.push(("`--solver tetrahedra`".to_owned(), tetrahedra));
    list
}

/// The layout of a run, optimised with other options.
fn again(
    run: &MeshRun,
    options: &OptimiseOptions,
) -> Result<Optimised, Box<dyn std::error::Error>> {
    let start = run.start.as_ref().ok_or("a run has a start")?;
    let mesh = HexMesh::from_soup(start)?;
    let target = SurfaceTarget::new(&run.target);
    Ok(refit(
        &mesh,
        Some(&target),
        &Steering::default(),
        options,
        &Silent,
    )?)
}

fn row(run: &MeshRun, result: &Optimised) -> String {
    let (figures, quality) = (measure(&result.mesh), &result.quality);
    let share = 100.0 / run.target.diagonal();
    format!(
        "{:.0e} | {} | {:.3}, {:.3} | {:.3} | {:.2} | {:.0} | {:.3} |",
        quality.planarity,
        figures.faces_not_simple,
        share * quality.deviation_max,
        share * quality.deviation_rms,
        share * farthest_corner(run, &result.mesh),
        quality.clearance,
        figures.angle.min,
        asymmetry(&result.mesh)
    )
}

/// Largest distance of a corner to the surface.
fn farthest_corner(run: &MeshRun, mesh: &HexMesh) -> f64 {
    let corners: Vec<_> = mesh
        .topology()
        .vertices()
        .map(|v| mesh.position(v))
        .collect();
    let feet = SurfaceTarget::new(&run.target).closest_points(&corners, &[]);
    let pairs = corners.iter().zip(&feet);
    pairs.fold(0.0, |most, (p, foot)| {
        f64::max(most, (p - foot.position).norm())
    })
}

/// Root mean square distance of the corners of hexagons to the images of their opposite corners in
/// the centre, mean edges.
fn asymmetry(mesh: &HexMesh) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for f in mesh
        .topology()
        .faces()
        .filter(|&f| mesh.topology().valence(f) == 6)
    {
        let corners: Vec<_> = mesh.corners(f).collect();
        for i in 0..3 {
            let image = mesh.centre(f) * 2.0 - corners[i + 3];
            sum += (corners[i] - image).norm_squared();
            count += 1.0;
        }
    }
    f64::sqrt(sum / count) / mesh.mean_edge()
}
