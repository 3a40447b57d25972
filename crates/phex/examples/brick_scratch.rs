use phex::pipeline::*;
use phex::*;
use phex_mesh::shapes::*;
use phex_mesh::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let panels: usize = a[2].parse().unwrap();
    let s = if a[1].contains('.') {
        let soup = io::read_soup(a[1].as_ref()).unwrap();
        TriangleSurface::from_soup(&soup).unwrap().components[0]
            .surface
            .clone()
    } else {
        let o = TriangulationOptions {
            jitter: std::env::var("JIT").map_or(0.2, |x| x.parse().unwrap()),
            triangles: std::env::var("TRI").map_or(8000, |x| x.parse().unwrap()),
            ..Default::default()
        };
        triangulate(&Shape::from_name(&a[1], &[]).unwrap(), &o).unwrap()
    };
    let mut o = MeshOptions {
        size: PanelSize::Panels(panels),
        method: Method::BrickWall,
        ..Default::default()
    };
    if let Some(j) = a.get(4) {
        let mut v = serde_json::to_value(&o).unwrap();
        fn merge(a: &mut serde_json::Value, b: serde_json::Value) {
            if let (true, serde_json::Value::Object(y)) = (a.is_object(), b.clone()) {
                for (k, w) in y {
                    merge(
                        a.as_object_mut()
                            .unwrap()
                            .entry(k)
                            .or_insert(serde_json::Value::Null),
                        w,
                    );
                }
            } else {
                *a = b;
            }
        }
        merge(&mut v, serde_json::from_str(j).unwrap());
        o = serde_json::from_value(v).unwrap();
    }
    let mut o0 = o.clone();
    o0.optimise.penalties = vec![];
    o0.optimise.projection_iterations = 0;
    o0.optimise.starts = optimise::Starts::SmoothedCells;
    let raw = match mesh_surface(&s, &o0, &Silent) {
        Ok(r) => r,
        Err(e) => {
            println!("ERR {} {e}", a[1]);
            return;
        }
    };
    let r = mesh_surface(&s, &o, &Silent).unwrap();
    let (m0, m) = (measure(&raw.mesh), measure(&r.mesh));
    let d = deviation(&r.mesh, &r.target);
    println!(
        "{} F {} hex {:.4} chi {} plan0 {:.2e} plan {:.1e} clear {:.3} ang {:.1} dev {:.4}% cov {:.3}% off {} viol {} sound {}",
        a[1],
        m.faces,
        m.hex.unwrap_or(0.0),
        r.mesh.topology().euler_characteristic(),
        m0.planarity.max,
        m.planarity.max,
        m.clearance.min,
        m.angle.min,
        d.deviation_max * 100.,
        d.coverage_inner_max * 100.,
        r.offenders.len(),
        r.violations.len(),
        r.is_sound()
    );
    println!("    {:?} {:?}", m.face_sizes, r.statistics.brick_wall);
    println!(
        "    {:?} fac {} start_faults {:?}",
        r.stages
            .iter()
            .map(|s| format!("{} {:.2}", s.stage, s.seconds))
            .collect::<Vec<_>>(),
        r.statistics.factorisations,
        r.statistics
            .runs
            .iter()
            .map(|r| r.start_faults)
            .collect::<Vec<_>>()
    );
    if let Some(p) = a.get(3) {
        if p != "-" {
            io::write_soup(p.as_ref(), &raw.mesh.to_soup()).unwrap();
            for (mesh, tag) in [(&raw.mesh, "raw"), (&r.mesh, "fin")] {
                let pic = report::picture::draw(
                    mesh,
                    &report::picture::PictureOptions {
                        width: 1100,
                        height: 800,
                        supersampling: 2,
                        ..Default::default()
                    },
                );
                let f = std::fs::File::create(p.replace(".obj", &format!("-{tag}.ppm"))).unwrap();
                use std::io::Write;
                let mut f = std::io::BufWriter::new(f);
                write!(f, "P6\n{} {}\n255\n", pic.width, pic.height).unwrap();
                for c in pic.rgba.chunks(4) {
                    f.write_all(&c[..3]).unwrap();
                }
            }
        }
    }
}
