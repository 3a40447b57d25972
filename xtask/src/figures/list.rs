//! The figures, one function each.

use super::obj::Obj;
use super::run::WORK;
use super::steps::hexagon;
use super::{GalleryFigure, Maker};

pub const FIGURES: [GalleryFigure; 13] = [
    GalleryFigure {
        number: 1,
        sentence: "A geodesic dome as a power diagram on a sphere, and a dome of constant mean curvature: a mesh parallel to one whose edges touch the unit sphere (a Koebe mesh), which is a Gauss image of it.",
        make: domes,
    },
    GalleryFigure {
        number: 2,
        sentence: "An ellipsoid needs twelve pentagons, a torus none.",
        make: ellipsoid_and_torus,
    },
    GalleryFigure {
        number: 3,
        sentence: "Three developable strips run through every hexagon, across its three pairs of opposite edges.",
        make: strips,
    },
    GalleryFigure {
        number: 4,
        sentence: "A panel in its tangent plane: its corners lie on a homothetic copy of Dupin's indicatrix (red) at its middle.",
        make: inscribed,
    },
    GalleryFigure {
        number: 5,
        sentence: "A torus of hexagons with the indicatrices of panels that have no corner in common: ellipses round convex panels where K > 0, hyperbolas through concave ones where K < 0.",
        make: indicatrices,
    },
    GalleryFigure {
        number: 6,
        sentence: "A torus by a regular triangulation of its projective dual, and that dual: the outer half becomes the spindle, whose tips are the cusps, the inner half the waist round it, which runs through infinity (cut off here).",
        make: torus_dual,
    },
    GalleryFigure {
        number: 7,
        sentence: "A convex surface with nearly flat parts: the projective dual is convex and regularly triangulated, and still panels cross themselves, where triangles of touching points are obtuse in the second fundamental form. The convex hull of the dual gives convex panels of many shapes, some with very short edges; ours are valid and regular.",
        make: broken,
    },
    GalleryFigure {
        number: 8,
        sentence: "The paper's own method on a torus: conjugate network, shifted rows, planar panels.",
        make: brick_torus,
    },
    GalleryFigure {
        number: 9,
        sentence: "The same on an open surface with hills, hollows and saddles.",
        make: brick_wave,
    },
    GalleryFigure {
        number: 10,
        sentence: "A mesh with its offset at constant face distance, and its Gauss image, whose faces touch the unit sphere.",
        make: face_offset,
    },
    GalleryFigure {
        number: 11,
        sentence: "A panel of a mesh that meets the angle condition, and the parallel panel of its Gauss image, which has a circumscribed circle.",
        make: parallel_panels,
    },
    GalleryFigure {
        number: 12,
        sentence: "A mesh that meets the angle condition with its offset at constant vertex distance, and its Gauss image, whose vertices lie on the unit sphere.",
        make: vertex_offset,
    },
    GalleryFigure {
        number: 13,
        sentence: "What the paper leaves open: a saddle with its offsets at constant edge distance on both sides, and its Gauss image, whose edges touch the unit sphere. One of three families of edges runs against that of the Gauss image.",
        make: edge_offset,
    },
];

fn edge_offset(m: &mut Maker<'_>) -> Result<(), String> {
    m.run(&format!(
        "shape hyperbolic-paraboloid --set side=1.6 -o {WORK}/saddle.obj -q"
    ))?;
    let mesh = format!("mesh {WORK}/saddle.obj -o {WORK}/saddle-phex.obj --method koebe -n 150");
    m.measured("Saddle", &mesh)?;
    let options = "--distance -0.05,0.05 --beams";
    offset(m, "saddle-phex.obj", "edge", options)?;
    let (below, above) = ("edge-offset/layer_-0.05.obj", "edge-offset/layer_+0.05.obj");
    half_covered(m, below, above, "edge-layers")?;
    m.draw(
        "edge-layers.obj",
        "figure-13-layers",
        "one layer and half of the other",
        "--no-legend",
    )?;
    m.draw(
        "edge-offset/gauss_image.obj",
        "figure-13-gauss-image",
        "Gauss image",
        "--no-legend",
    )
}

fn domes(m: &mut Maker<'_>) -> Result<(), String> {
    m.surface("dome")?;
    m.measured("Geodesic", &format!("mesh {WORK}/dome.obj -o {WORK}/dome-phex.obj --method power-diagram -n 180 --keep-invalid"))?;
    m.step(&format!("honeycomb 8 -o {WORK}/honeycomb.obj"))?;
    m.run(&format!(
        "koebe {WORK}/honeycomb.obj -o {WORK}/koebe.obj --opening 30 -q"
    ))?;
    m.run(&format!(
        "shape elliptic-paraboloid --set a=1.2 --set b=1.8 -o {WORK}/paraboloid.obj -q"
    ))?;
    m.measured("Constant mean curvature", &format!("parallel {WORK}/koebe.obj --surface {WORK}/paraboloid.obj -o {WORK}/parallel.obj --constant-mean-curvature 100"))?;
    m.draw(
        "dome-phex.obj",
        "figure-01-dome",
        "power diagram",
        "--no-legend",
    )?;
    m.draw(
        "parallel.obj",
        "figure-01-parallel",
        "constant mean curvature",
        "--no-legend",
    )
}

fn ellipsoid_and_torus(m: &mut Maker<'_>) -> Result<(), String> {
    m.surface("ellipsoid")?;
    m.surface("torus")?;
    m.measured(
        "Ellipsoid",
        &format!(
            "mesh {WORK}/ellipsoid.obj -o {WORK}/ellipsoid-phex.obj --method power-diagram -n 360"
        ),
    )?;
    m.measured(
        "Torus",
        &format!("mesh {WORK}/torus.obj -o {WORK}/torus-phex.obj --method brick-wall -n 650"),
    )?;
    m.draw(
        "ellipsoid-phex.obj",
        "figure-02-ellipsoid",
        "twelve pentagons",
        "",
    )?;
    m.draw("torus-phex.obj", "figure-02-torus", "only hexagons", "")
}

/// The torus of Figure 2.
fn torus(m: &mut Maker<'_>) -> Result<Obj, String> {
    m.surface("torus")?;
    m.run(&format!(
        "mesh {WORK}/torus.obj -o {WORK}/torus-phex.obj --method brick-wall -n 650"
    ))?;
    Obj::read(&m.phex.work("torus-phex.obj"))
}

fn strips(m: &mut Maker<'_>) -> Result<(), String> {
    const PLACE: &str = "1.0,-0.9,0.3";
    let torus = torus(m)?;
    m.step(&format!(
        "strips {PLACE} {WORK}/torus-phex.obj -o {WORK}/strips.txt"
    ))?;
    let strips = torus.strips(hexagon(&torus, PLACE)?);
    let lengths: Vec<String> = strips.iter().map(|s| s.len().to_string()).collect();
    m.say(format!(
        "Strips through one hexagon (red) of the torus of Figure 2, drawn over {} panels. Each is a strip of planar panels, so it can be unrolled.",
        lengths.join(", ")
    ));
    m.draw(
        "torus-phex.obj",
        "figure-03-strips",
        "three strips",
        &format!("--mark {WORK}/strips.txt --no-legend"),
    )
}

/// A panel of the torus near a point, with its neighbours, and the copy of the indicatrix that fits
/// it.
fn panel(m: &mut Maker<'_>, near: &str, name: &str) -> Result<(), String> {
    let torus = torus(m)?;
    m.step(&format!(
        "near {near} {WORK}/torus-phex.obj -o {WORK}/{name}.obj"
    ))?;
    let centre = torus.centre(&torus.faces[hexagon(&torus, near)?]);
    let at = centre.map(|x| format!("{x:.6}")).join(",");
    m.run(&format!(
        "dupin {WORK}/torus.obj -o {WORK}/{name}-dupin.obj --panels {WORK}/{name}.obj --at={at}"
    ))
}

fn inscribed(m: &mut Maker<'_>) -> Result<(), String> {
    panel(m, "1.4,0,0", "convex-panel")?;
    let curves = format!("--curves {WORK}/convex-panel-dupin.obj --no-legend --view right");
    m.draw(
        "convex-panel.obj",
        "figure-04-inscribed",
        "corners on the indicatrix",
        &curves,
    )?;
    m.measured(
        "Torus of Figure 2",
        &format!("check {WORK}/torus-phex.obj --surface {WORK}/torus.obj"),
    )
}

fn indicatrices(m: &mut Maker<'_>) -> Result<(), String> {
    panel(m, "1.4,0,0", "convex-panel")?;
    panel(m, "0.6,0,0", "concave-panel")?;
    let coarse =
        format!("mesh {WORK}/torus.obj -o {WORK}/torus-coarse.obj --method brick-wall -n 250");
    m.measured("Coarse torus", &coarse)?;
    m.run(&format!(
        "dupin {WORK}/torus.obj -o {WORK}/torus-dupin.obj --panels {WORK}/torus-coarse.obj --apart"
    ))?;
    let torus = format!("--curves {WORK}/torus-dupin.obj --no-legend");
    m.draw(
        "torus-coarse.obj",
        "figure-05-torus",
        "one panel in three",
        &torus,
    )?;
    let convex = format!("--curves {WORK}/convex-panel-dupin.obj --no-legend --view right");
    m.draw(
        "convex-panel.obj",
        "figure-05-ellipse",
        "K > 0: an ellipse",
        &convex,
    )?;
    let concave = format!("--curves {WORK}/concave-panel-dupin.obj --no-legend --view left");
    m.draw(
        "concave-panel.obj",
        "figure-05-hyperbola",
        "K < 0: a hyperbola",
        &concave,
    )
}

fn torus_dual(m: &mut Maker<'_>) -> Result<(), String> {
    m.surface("torus")?;
    m.measured("Projective dual", &format!("mesh {WORK}/torus.obj -o {WORK}/torus-dual-phex.obj --method projective-dual --any-domain -n 400 --keep-invalid"))?;
    m.run(&format!(
        "dual {WORK}/torus-dual-phex.obj -o {WORK}/torus-dual-all.obj --centre=0,0,0"
    ))?;
    // The waist runs through infinity, where its panels are as long as one likes; beyond the tips
    // the spindle goes on as a cone.
    let file = |name: &str| format!("{WORK}/torus-dual-{name}.obj");
    let [all, finite, thin, spindle, wide, waist, cut] =
        ["all", "finite", "thin", "spindle", "wide", "waist", "cut"].map(file);
    m.step(&format!("finite 3 {all} -o {finite}"))?;
    m.step(&format!("between r 0 1.1 {finite} -o {thin}"))?;
    m.step(&format!("between z -2.4 2.4 {thin} -o {spindle}"))?;
    m.step(&format!("between r 1.1 9 {finite} -o {wide}"))?;
    m.step(&format!("between z -0.6 0.6 {wide} -o {waist}"))?;
    m.step(&format!("join {spindle} {waist} -o {cut}"))?;
    m.draw(
        "torus-dual-phex.obj",
        "figure-06-torus",
        "self-intersecting panels in red",
        "--color validity",
    )?;
    m.draw(
        "torus-dual-cut.obj",
        "figure-06-dual",
        "its projective dual",
        "--no-legend",
    )
}

fn broken(m: &mut Maker<'_>) -> Result<(), String> {
    m.surface("blob")?;
    m.job("regular.toml", "[stages.dual]\nhull = false\n")?;
    let made = format!("mesh {WORK}/blob.obj --method projective-dual -n 400 --keep-invalid");
    m.measured(
        "Regular triangulation",
        &format!("{made} -o {WORK}/blob-dual-phex.obj --config {WORK}/regular.toml"),
    )?;
    m.measured("Hull", &format!("{made} -o {WORK}/blob-hull-phex.obj"))?;
    m.run(&format!(
        "dual {WORK}/blob-dual-phex.obj -o {WORK}/blob-dual.obj --centre=0,0,0"
    ))?;
    m.measured(
        "Ours",
        &format!("mesh {WORK}/blob.obj -o {WORK}/blob-phex.obj -n 400 --keep-invalid"),
    )?;
    m.draw(
        "blob-dual-phex.obj",
        "figure-07-broken",
        "projective dual",
        "--color validity",
    )?;
    m.draw(
        "blob-dual.obj",
        "figure-07-dual",
        "the triangulation that it comes from",
        "--no-legend",
    )?;
    m.draw(
        "blob-hull-phex.obj",
        "figure-07-hull",
        "the dual's convex hull",
        "--color validity",
    )?;
    m.draw(
        "blob-phex.obj",
        "figure-07-ours",
        "ours",
        "--color validity",
    )
}

/// The three pictures of the paper's method.
fn brick(m: &mut Maker<'_>, surface: &str, number: usize, panels: usize) -> Result<(), String> {
    m.surface(surface)?;
    m.measured(
        "Network",
        &format!("network {WORK}/{surface}.obj -o {WORK}/{surface}-network.obj -n {panels}"),
    )?;
    m.run(&format!(
        "shape {surface} --triangles 60000 -o {WORK}/{surface}-smooth.obj -q"
    ))?;
    let wall = format!("mesh {WORK}/{surface}.obj --method brick-wall -n {panels}");
    m.measured(
        "Shifted",
        &format!("{wall} -o {WORK}/{surface}-shifted.obj --until layout"),
    )?;
    let bricks = format!("{wall} --keep-invalid -o {WORK}/{surface}-bricks.obj");
    m.measured("Final", &bricks)?;
    m.draw(
        &format!("{surface}-smooth.obj"),
        &format!("figure-{number:02}-network"),
        "conjugate network",
        &format!("--curves {WORK}/{surface}-network.obj --no-legend --no-edges"),
    )?;
    m.draw(
        &format!("{surface}-shifted.obj"),
        &format!("figure-{number:02}-shifted"),
        "shifted rows",
        "--no-legend",
    )?;
    m.draw(
        &format!("{surface}-bricks.obj"),
        &format!("figure-{number:02}-final"),
        "planar panels",
        "--no-legend",
    )
}

fn brick_torus(m: &mut Maker<'_>) -> Result<(), String> {
    brick(m, "torus", 8, 500)
}

fn brick_wave(m: &mut Maker<'_>) -> Result<(), String> {
    brick(m, "wave", 9, 500)
}

/// Offsets of a mesh with its Gauss image, in the folder `{kind}-offset`.
fn offset(m: &mut Maker<'_>, mesh: &str, kind: &str, options: &str) -> Result<(), String> {
    let line = format!(
        "offset {WORK}/{mesh} -o {WORK}/{kind}-offset --kind {kind} --gauss-image {options}"
    );
    let said = m.phex.make(&line)?;
    m.commands.push(said.line.clone());
    m.phex.remember(&line);
    let rows = said.out.lines().filter(|l| !l.contains(WORK));
    let rows: Vec<String> = rows
        .map(|l| l.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    m.say(format!("Offset: {}.", rows.join("; ")));
    Ok(())
}

/// The mesh, and one half of its offset over it.
fn half_covered(m: &mut Maker<'_>, mesh: &str, layer: &str, name: &str) -> Result<(), String> {
    let half = format!("{WORK}/{name}-half.obj");
    m.step(&format!("above x 0 {WORK}/{layer} -o {half}"))?;
    m.step(&format!("join {WORK}/{mesh} {half} -o {WORK}/{name}.obj"))
}

/// A cap whose bricks are regular enough for offsets of both kinds.
fn cap(m: &mut Maker<'_>) -> Result<(), String> {
    m.run(&format!(
        "shape elliptic-paraboloid --set a=1.2 --set b=1.2 --set radius=0.9 -o {WORK}/cap.obj -q"
    ))?;
    let mesh = format!("mesh {WORK}/cap.obj -o {WORK}/cap-phex.obj --method brick-wall -n 120");
    m.measured("Mesh", &mesh)
}

fn face_offset(m: &mut Maker<'_>) -> Result<(), String> {
    cap(m)?;
    offset(m, "cap-phex.obj", "face", "--distance 0.06")?;
    half_covered(
        m,
        "cap-phex.obj",
        "face-offset/layer_+0.06.obj",
        "face-layers",
    )?;
    m.draw(
        "face-layers.obj",
        "figure-10-layers",
        "mesh and half of its offset",
        "--no-legend",
    )?;
    m.draw(
        "face-offset/gauss_image.obj",
        "figure-10-gauss-image",
        "Gauss image",
        "--no-legend",
    )
}

fn capped(m: &mut Maker<'_>) -> Result<(), String> {
    cap(m)?;
    let options = format!("--optimise --surface {WORK}/cap.obj --distance 0.06");
    offset(m, "cap-phex.obj", "vertex", &options)
}

fn parallel_panels(m: &mut Maker<'_>) -> Result<(), String> {
    capped(m)?;
    const PLACE: &str = "0.2,0.05,0";
    let (mesh, image) = ("vertex-offset/mesh.obj", "vertex-offset/gauss_image.obj");
    m.step(&format!("face {PLACE} {WORK}/{mesh} -o {WORK}/panel.obj"))?;
    m.step(&format!(
        "face {PLACE} {WORK}/{mesh} {WORK}/{image} -o {WORK}/parallel-panel.obj"
    ))?;
    m.step(&format!(
        "circle {WORK}/parallel-panel.obj -o {WORK}/circle.obj"
    ))?;
    let [panel, parallel] =
        ["panel.obj", "parallel-panel.obj"].map(|name| Obj::read(&m.phex.work(name)));
    let (angles, error) = (panel?.angles(), parallel?.circle().1);
    let sum = |first: usize| {
        (0..3)
            .map(|k| angles[first + 2 * k])
            .sum::<f64>()
            .to_degrees()
    };
    m.say(format!(
        "Angles of the panel: {:.6} and {:.6} degrees in the two alternating sums; corners of the parallel panel off the circle by at most {error:.1e} of its radius.",
        sum(0),
        sum(1)
    ));
    m.draw(
        "parallel-panel.obj",
        "figure-11-inscribed",
        "panel of the Gauss image",
        &format!("--curves {WORK}/circle.obj --no-legend --view top"),
    )?;
    m.draw(
        "panel.obj",
        "figure-11-parallel",
        "parallel panel of the mesh",
        "--no-legend --view top",
    )
}

fn vertex_offset(m: &mut Maker<'_>) -> Result<(), String> {
    capped(m)?;
    half_covered(
        m,
        "vertex-offset/mesh.obj",
        "vertex-offset/layer_+0.06.obj",
        "vertex-layers",
    )?;
    m.draw(
        "vertex-layers.obj",
        "figure-12-layers",
        "mesh and half of its offset",
        "--no-legend",
    )?;
    m.draw(
        "vertex-offset/gauss_image.obj",
        "figure-12-gauss-image",
        "Gauss image",
        "--no-legend",
    )
}
