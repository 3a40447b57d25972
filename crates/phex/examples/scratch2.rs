use phex::*;
use phex_mesh::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let panels: usize = a[2].parse().unwrap();
    let soup = io::read_soup(a[1].as_ref()).unwrap();
    let parts = TriangleSurface::from_soup(&soup).unwrap();
    let s = &parts.components[0].surface;
    let mut o = MeshOptions {
        size: PanelSize::Panels(panels),
        ..Default::default()
    };
    if let Some(j) = a.get(4) {
        let mut v = serde_json::to_value(&o).unwrap();
        fn merge(a: &mut serde_json::Value, b: serde_json::Value) {
            if let (Some(x), serde_json::Value::Object(y)) = (a.as_object_mut(), b.clone()) {
                for (k, w) in y {
                    merge(x.entry(k).or_insert(serde_json::Value::Null), w);
                }
            } else {
                *a = b;
            }
        }
        merge(&mut v, serde_json::from_str(j).unwrap());
        o = serde_json::from_value(v).unwrap();
    }
    let r = match mesh_surface(s, &o, &Silent) {
        Ok(r) => r,
        Err(e) => {
            println!("ERR {e}");
            return;
        }
    };
    let m = measure(&r.mesh);
    let d = deviation(&r.mesh, &r.target);
    println!(
        "{:30} F {} hex {:.3} plan {:.1e} clear {:.3} ang {:.1} dev {:.3}% cov {:.3}% off {} viol {} sound {} runs {:?} rep {:?} fac {}",
        a[1].rsplit('/').next().unwrap(),
        m.faces,
        m.hex.unwrap_or(0.0),
        m.planarity.max,
        m.clearance.min,
        m.angle.min,
        d.deviation_max * 100.,
        d.coverage_inner_max * 100.,
        r.offenders.len(),
        r.violations.len(),
        r.is_sound(),
        r.statistics
            .runs
            .iter()
            .map(|x| (x.start, x.iterations, x.factorisations))
            .collect::<Vec<_>>(),
        r.statistics
            .repairs
            .iter()
            .map(|x| (x.panels, x.dropped))
            .collect::<Vec<_>>(),
        r.statistics.factorisations
    );
    println!(
        "    {:?} {:?} {:?}",
        m.face_sizes,
        r.stages
            .iter()
            .map(|s| format!("{} {:.2}", s.stage, s.seconds))
            .collect::<Vec<_>>(),
        r.offenders.iter().take(3).collect::<Vec<_>>()
    );
    println!(
        "    {:?} {:?}",
        r.statistics.layout,
        r.violations
            .iter()
            .map(|v| v.kind())
            .take(20)
            .collect::<Vec<_>>()
    );
    for x in &r.statistics.runs {
        println!(
            "    {:?} faults {} {:?} its {} off {} plan {:.1e} clear {:.3} score {:.2}",
            x.start,
            x.start_faults,
            x.status,
            x.iterations,
            x.offenders,
            x.quality.planarity,
            x.quality.clearance,
            x.score
        );
    }
    let mut c = std::collections::BTreeMap::new();
    for o in &r.offenders {
        *c.entry(
            format!("{:?}", o.fault)
                .split([' ', '{'])
                .next()
                .unwrap()
                .to_string(),
        )
        .or_insert(0) += 1;
    }
    println!("    {c:?}");
    if let Some(p) = a.get(3) {
        io::write_soup(p.as_ref(), &r.mesh.to_soup()).unwrap();
        let t = PolygonSoup {
            positions: r.target.positions().as_slice().to_vec(),
            faces: r.target.topology().face_lists(),
        };
        io::write_soup(p.replace(".obj", "-target.obj").as_ref(), &t).unwrap();
    }
}
