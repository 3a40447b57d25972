//! Vertex-distance offsets.

use super::fixtures::*;
use crate::optimise::tests::fixtures::planar_paraboloid;
use crate::optimise::{AngleOptimised, AngleOptions, satisfy_angle_condition};
use crate::parallel_mesh::*;
use crate::progress::Silent;
use phex_mesh::{FaceId, FlatFace, HexMesh, ValidateOptions, Vec3, VertexId, violations};
use std::f64::consts::{PI, TAU};

fn torus(u: f64, v: f64) -> Vec3 {
    let r = 1.0 + 0.4 * v.cos();
    Vec3::new(r * u.cos(), r * u.sin(), 0.4 * v.sin())
}

fn between(from: f64, to: f64, t: f64) -> f64 {
    from + (to - from) * t
}

fn torus_patch(v: [f64; 2], kink: f64) -> HexMesh {
    patch(25, 9, kink, |s, t| {
        torus(1.2 * s, between(v[0], v[1], t))
    })
}

/// Open patches of hexagons of every curvature; the last one is exactly planar before.
fn patches() -> Vec<(&'static str, HexMesh)> {
    let wave = patch(25, 9, 0.0, |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        Vec3::new(x, y, 0.3 * x.sin() + 0.2 * y.cos())
    });
    let saddle = patch(19, 9, -0.1, |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        Vec3::new(x, y, 0.3 * (x * x - y * y))
    });
    vec![
        ("torus, K > 0", torus_patch([-1.0, 1.0], 0.1)),
        ("torus, K < 0", torus_patch([2.3, 4.0], -0.1)),
        ("torus, K = 0 crossed", torus_patch([0.7, 2.4], 0.0)),
        ("wave", wave),
        ("saddle", saddle),
        ("paraboloid", planar_paraboloid(24, 12)),
    ]
}

fn optimised(mesh: &HexMesh) -> AngleOptimised {
    satisfy_angle_condition(mesh, None, &AngleOptions::default(), &Silent).unwrap()
}

#[test]
fn probe() {
    for (name, mesh) in patches() {
        let t = std::time::Instant::now();
        let r = optimised(&mesh);
        println!(
            "{name}: F {} {:?} its {} fac {} angle {:.2e}->{:.2e} dev/h {:.3}->{:.4} plan {:.1e} clear {:.2} off {} {:.2}s",
            mesh.topology().n_faces(),
            r.outcome.status,
            r.outcome.iterations,
            r.outcome.factorisations,
            r.angle_defect[0],
            r.angle_defect[1],
            r.deviation[0] / r.quality.mean_edge,
            r.deviation[1] / r.quality.mean_edge,
            r.quality.planarity,
            r.quality.clearance,
            r.offenders.len(),
            t.elapsed().as_secs_f64()
        );
        println!("   violations {:?}", violations(&r.mesh, None, &ValidateOptions::default()).first());
        match vertex_gauss_image(&r.mesh, &VertexOffsetOptions { angle: 1e-6, closing: 1e-3, ..Default::default() }) {
            Ok(s) => {
                let m = s.image.mesh(&r.mesh);
                let norm = m.positions.iter().map(|p| (p.norm() - 1.0).abs()).fold(0.0, f64::max);
                let d = 0.05 * r.quality.mean_edge;
                let o = s.image.offset(&r.mesh, d);
                println!("   holonomy {:?} sphere {norm:.1e} parallel M' {:.1e} M_d {:.1e} ", s.holonomy, parallelism(&r.mesh, &m), parallelism(&r.mesh, &o));
                println!("   safe {:?}", safe_distances(&r.mesh, &s.image, &ValidateOptions::default()));
            }
            Err(e) => println!("   {e}"),
        }
    }
}
