//! Theorem 1 of Wang and Liu under refinement: how far the corners of panels are from a homothetic
//! copy of Dupin's indicatrix, over the panel's radius, and the rate at which that falls with the
//! size of the panels.
//!
//! `cargo run --release -p phex --example dupin_convergence -- 600 2400 9600` prints a table for
//! both layouts on a torus and a wave (by default for 150, 600 and 2400 panels): the median and the
//! mean of all inner panels, and the share beyond 0.05. *usual* are the weights as they are,
//! *refined* those that go with the size, see
//! [`OptimiseOptions::refined`](phex::optimise::OptimiseOptions::refined).
//!
//! On the torus nothing is in the way of the theorem, and *usual* weights show first order. On the
//! wave they do in the median only. Regions with `K < 0` lie there between parabolic curves of both
//! families, along which rows must run, so rows turn by 30 degrees within each of them; half-way an
//! edge of the lattice is an asymptotic direction, and a panel that is inscribed there has an edge
//! without length. The barrier holds such panels open: lines one or two panels wide, their distance
//! as large as ever or, since closeness loses against barrier and fairness as panels become
//! smaller, larger. No valid mesh of the wave does without these lines, so the mean can't fall
//! faster than their share, the size, times their distance. *Refined* weights keep the balance and
//! let go of the barrier: first order in the mean, too. A brick wall on the wave teeth where the
//! curvature across its rows vanishes, and those panels are not inscribed, however small they are.

use phex::curvature::indicatrix_distances;
use phex::curvature::{CurvatureOptions, curvature};
use phex::pipeline::Method;
use phex::{Effort, MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::TriangleSurface;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

/// Panels for which refined weights are the usual ones.
const USUAL: f64 = 150.0;
/// Distance beyond which a panel is not inscribed.
const OFF: f64 = 0.05;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Result<Vec<usize>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    let sizes = Some(given?).filter(|g| !g.is_empty());
    let sizes = sizes.unwrap_or_else(|| vec![150, 600, 2400]);
    for name in ["torus", "wave"] {
        let options = TriangulationOptions {
            triangles: 60_000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[])?, &options)?;
        for (method, refined) in [
            (Method::BrickWall, false),
            (Method::Lattice, false),
            (Method::Lattice, true),
        ] {
            let weights = if refined { "refined" } else { "usual" };
            println!("{name}, {method:?}, {weights} weights");
            println!("  panels  mean edge  median  rate   mean    rate   share > {OFF}  clearance");
            let mut last: Option<Measured> = None;
            for &panels in &sizes {
                let now = measure(&surface, method, panels, refined)?;
                now.print(last.as_ref());
                last = Some(now);
            }
        }
    }
    Ok(())
}

/// What one mesh has.
struct Measured {
    panels: usize,
    edge: f64,
    /// Median and mean of the distances.
    figures: [f64; 2],
    /// Share of the panels that is farther off than [`OFF`].
    share: f64,
    /// Least clearance, in mean edges.
    clearance: f64,
}

impl Measured {
    fn print(&self, last: Option<&Self>) {
        let columns = (0..2).map(|k| {
            let rate = last.map_or(f64::NAN, |l| {
                (l.figures[k] / self.figures[k]).ln() / (l.edge / self.edge).ln()
            });
            format!("{:.4}  {rate:.2}", self.figures[k])
        });
        println!(
            "  {:>6}  {:.4}     {}   {:.3}         {:.3}",
            self.panels,
            self.edge,
            columns.collect::<Vec<_>>().join("   "),
            self.share,
            self.clearance
        );
    }
}

fn measure(
    surface: &TriangleSurface,
    method: Method,
    panels: usize,
    refined: bool,
) -> Result<Measured, Box<dyn std::error::Error>> {
    let mut options = MeshOptions {
        size: PanelSize::Panels(panels),
        method,
        // One lattice and few repairs, so that nothing but the size differs.
        portfolio: Vec::new(),
        effort: Effort::Draft,
        ..Default::default()
    };
    if refined {
        options.optimise = options.optimise.refined((panels as f64 / USUAL).sqrt());
    }
    let run = mesh_surface(surface, &options, &Silent)?;
    if !run.is_sound() {
        return Err(format!("{panels} panels: not sound").into());
    }
    // Curvature at the points themselves, not at the scale of panels.
    let curvature = curvature(
        surface,
        0.02 * surface.diagonal(),
        &CurvatureOptions::default(),
    );
    let distances = indicatrix_distances(&run.mesh, surface, &curvature);
    let mut known: Vec<f64> = distances.iter().flatten().copied().collect();
    known.sort_by(f64::total_cmp);
    let count = known.len() as f64;
    Ok(Measured {
        panels: run.mesh.topology().n_faces(),
        edge: run.mesh.mean_edge(),
        figures: [known[known.len() / 2], known.iter().sum::<f64>() / count],
        share: known.iter().filter(|d| **d > OFF).count() as f64 / count,
        clearance: phex_mesh::measure(&run.mesh).clearance.min,
    })
}
