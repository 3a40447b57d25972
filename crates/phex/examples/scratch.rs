use phex::*;
use phex_mesh::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let panels: f64 = a[2].parse().unwrap();
    let fper: f64 = a.get(3).map(|s| s.parse().unwrap()).unwrap_or(8.0);
    let cper: f64 = a.get(4).map(|s| s.parse().unwrap()).unwrap_or(24.0);
    let soup = io::read_soup(a[1].as_ref()).unwrap();
    let tris: Vec<[u32; 3]> = soup.faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
    let mut used = vec![u32::MAX; soup.positions.len()];
    let mut pos = vec![];
    let tris: Vec<[u32; 3]> = tris
        .iter()
        .map(|t| {
            t.map(|i| {
                if used[i as usize] == u32::MAX {
                    used[i as usize] = pos.len() as u32;
                    pos.push(soup.positions[i as usize]);
                }
                used[i as usize]
            })
        })
        .collect();
    let s0 = TriangleSurface::new(pos.clone(), &tris).unwrap();
    let sim = target::Similarity::normalising(&s0);
    let s = TriangleSurface::new(pos.iter().map(|p| sim.normalise(*p)).collect(), &tris).unwrap();
    let t = Instant::now();
    let st = target::smooth_target(&s, (cper * panels) as usize, &Default::default());
    let tick = |n: &str, t: Instant| println!("  {n} {:.2}s", t.elapsed().as_secs_f64());
    tick("target", t);
    let fl = st
        .levels
        .iter()
        .position(|l| l.positions().len() as f64 >= fper * panels)
        .unwrap_or(st.levels.len() - 1);
    println!(
        "levels {:?} field level {fl} interp err {:.1e} corners {}",
        st.levels
            .iter()
            .map(|l| l.positions().len())
            .collect::<Vec<_>>(),
        st.interpolation_error,
        st.corners.len()
    );
    let surf = &st.levels[fl];
    let length = (surf.area() / panels / layout::lattice::CELL).sqrt();
    let t = Instant::now();
    let curv = curvature::curvature(surf, length, &Default::default());
    tick("curvature", t);
    let t = Instant::now();
    let dir = directions::directions(surf, &curv, length, &Default::default()).unwrap();
    tick("directions", t);
    let t = Instant::now();
    let (seeds, stat) = layout::place_seeds(surf.topology(), &dir, &Default::default()).unwrap();
    tick("seeds", t);
    println!("seeds {} {:?}", seeds.len(), stat);
    let t = Instant::now();
    let mut curv = curv;
    let mut metric = dir.metric.clone();
    for r in &st.refinements[fl..] {
        curv = curv.refined(r);
        metric = r.apply(&metric);
    }
    let fine = st.finest().clone().with_normals(curv.normal.clone());
    let im = directions::intrinsic::IntrinsicMesh::new(&fine, &metric);
    let corners = st.corners.iter().copied().collect();
    let cs = layout::CellSurface {
        surface: &fine,
        metric: &metric,
        mesh: &im,
        corners: &corners,
    };
    let lay = layout::panelling(&cs, &seeds).unwrap();
    tick("cells", t);
    let m = measure(&lay.mesh);
    println!(
        "faces {} hex {:.3} sizes {:?} notsimple {} minedge {:.3}",
        m.faces,
        m.hex.unwrap(),
        m.face_sizes,
        m.faces_not_simple,
        m.edge_length.min
    );
    io::write_soup("/tmp/lay.obj".as_ref(), &lay.mesh.to_soup()).unwrap();
}
