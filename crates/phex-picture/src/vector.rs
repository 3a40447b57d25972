//! The picture as vectors: panels from the farthest to the nearest, each with its edges, the hidden
//! ones left out.
//!
//! The order comes from the samples of the picture: where two panels cover the same sample, the
//! nearer one is drawn later. An order that keeps to all of these pairs is found by sorting
//! topologically, the farthest first where several are possible; in a cycle (panels that overlap
//! one another in turn) the farthest goes first.

use super::PictureOptions;
use super::camera::{Camera, Seen, panel_plane};
use super::covering::Covering;
use super::framing;
use super::legend_layout::{Item, LegendLayout};
use super::light::Shading;
use super::paint::Paint;
use super::raster::PanelRaster;
use crate::maps::Rgb;
use crate::srgb::srgb_byte;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerFace, Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use svg::node::element::{Group, Path, Rectangle, Text};
use svg::{Document, Node};

/// Width of lines over that of the picture's height.
const LINE_REL: f64 = 0.9 / 1200.0;
/// How much wider lines are that carry colours.
const COLOURED_WIDTH: f64 = 4.0;
/// Height of small letters of the font over the unit of the single-line alphabet.
const FONT: f64 = 9.0;

/// Draws a mesh as SVG.
pub fn draw(mesh: &HexMesh, paint: &Paint, options: &PictureOptions) -> String {
    let camera = framing::camera(mesh, paint, options);
    let shading = Shading::new(mesh, &camera, paint, false);
    let raster = PanelRaster::new(mesh, &camera, paint, 1);
    let covering = Covering::new(&raster, options);
    let order = drawing_order(mesh, &camera, &covering);
    let line = LINE_REL * options.height as f64;
    let bold = if paint.edges.is_some() {
        COLOURED_WIDTH
    } else {
        1.0
    };
    let mut panels = Group::new()
        .set("id", "panels")
        .set("stroke", "#1a1a1f")
        .set("stroke-width", short(bold * line))
        .set("stroke-linejoin", "round")
        .set("stroke-linecap", "round");
    let see = |p: Vec3| camera.see(camera.normalised(p));
    let seams_only = paint.edges.is_some() || !options.edges;
    for f in order {
        let outline: Vec<Seen> = mesh.corners(f).map(see).collect();
        panels.append(panel(f, &outline, rgb(shading.panels[f]), seams_only));
        if paint.edges.is_some() && options.edges {
            edges(mesh, f, see, |e| rgb(paint.ink(e))).for_each(|edge| panels.append(edge));
        }
    }
    let (width, height) = (options.width, options.height);
    let white = Rectangle::new().set("width", width).set("height", height);
    let mut document = Document::new()
        .set("width", width)
        .set("height", height)
        .set("viewBox", (0, 0, width, height))
        .add(white.set("fill", "#ffffff"))
        .add(panels);
    if options.legend {
        let size = Vec2::new(width as f64, height as f64);
        document.append(legend(paint, &covering, size));
    }
    format!("{document}\n")
}

fn rgb(light: Vec3) -> Rgb {
    [light.x, light.y, light.z].map(|c| srgb_byte(c, 0.5))
}

/// The panels of which something is seen, in an order in which nearer ones come later.
fn drawing_order(mesh: &HexMesh, camera: &Camera, covering: &Covering) -> Vec<FaceId> {
    let behind = covering.pairs();
    let mut waiting: PerFace<usize> = PerFace::filled(mesh.topology().n_faces(), 0);
    let mut nearer: BTreeMap<FaceId, Vec<FaceId>> = BTreeMap::new();
    for &(back, front) in behind {
        waiting[front] += 1;
        nearer.entry(back).or_default().push(front);
    }
    let rank = ranks(mesh, camera);
    let mut left: BTreeSet<(usize, FaceId)> = covering.seen().map(|f| (rank[f], f)).collect();
    let free = |&(_, f): &(usize, FaceId), waiting: &PerFace<usize>| waiting[f] == 0;
    let mut ready: BTreeSet<(usize, FaceId)> =
        left.iter().copied().filter(|x| free(x, &waiting)).collect();
    let mut order = Vec::with_capacity(left.len());
    while let Some(next) = ready.pop_first().or_else(|| left.first().copied()) {
        left.remove(&next);
        order.push(next.1);
        for &front in nearer.get(&next.1).into_iter().flatten() {
            waiting[front] -= 1;
            let entry = (rank[front], front);
            if free(&entry, &waiting) && left.contains(&entry) {
                ready.insert(entry);
            }
        }
    }
    order
}

/// Panels by the distance of their centres, the farthest first.
fn ranks(mesh: &HexMesh, camera: &Camera) -> PerFace<usize> {
    let topology = mesh.topology();
    let nearness = |f: FaceId| camera.see(panel_plane(mesh, camera, f).centre).nearness;
    let mut far: Vec<(f64, FaceId)> = topology.faces().map(|f| (nearness(f), f)).collect();
    far.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut ranks = PerFace::filled(far.len(), 0);
    for (rank, (_, f)) in far.into_iter().enumerate() {
        ranks[f] = rank;
    }
    ranks
}

/// A panel with its outline; where edges carry colours, the outline only closes the seams between
/// fillings.
fn panel(f: FaceId, outline: &[Seen], fill: Rgb, seams_only: bool) -> Path {
    let points: Vec<String> = outline.iter().map(point).collect();
    let path = Path::new()
        .set("id", format!("p{}", f.index()))
        .set("d", format!("M{}Z", points.join("L")))
        .set("fill", hex(fill));
    if seams_only {
        path.set("stroke", hex(fill)).set("stroke-width", "0.6")
    } else {
        path
    }
}

/// The edges of a panel in their own colours.
fn edges(
    mesh: &HexMesh,
    f: FaceId,
    see: impl Fn(Vec3) -> Seen,
    ink: impl Fn(EdgeId) -> Rgb,
) -> impl Iterator<Item = Path> {
    let topology = mesh.topology();
    topology.face_half_edges(f).map(move |h| {
        let ends = [topology.origin(h), topology.target(h)].map(|v| see(mesh.position(v)));
        let [a, b] = ends.each_ref().map(point);
        let path = Path::new().set("d", format!("M{a}L{b}"));
        path.set("stroke", hex(ink(topology.edge(h))))
    })
}

fn legend(paint: &Paint, covering: &Covering, size: Vec2) -> Group {
    let layout = LegendLayout::new(&paint.legend, size.y);
    let corner = layout.place(size, |low, high| covering.seen_within(low, high));
    let group = Group::new()
        .set("id", "legend")
        .set("font-family", "Helvetica, Arial, sans-serif")
        .set("fill", "#38383f");
    layout
        .items
        .iter()
        .fold(group, |group, part| group.add(item(corner, part)))
}

fn item(corner: Vec2, item: &Item) -> Box<dyn Node> {
    match item {
        Item::Hexagon {
            centre,
            radius,
            colour,
        } => Box::new(hexagon(corner + centre, *radius, *colour)),
        Item::Rectangle { low, high, colour } => {
            let (at, size) = (corner + low, high - low);
            let rectangle = Rectangle::new()
                .set("x", short(at.x))
                .set("y", short(at.y))
                .set("width", short(size.x))
                .set("height", short(size.y));
            Box::new(rectangle.set("fill", hex(*colour)))
        }
        Item::Text { start, unit, text } => {
            let at = corner + start;
            let text = Text::new(text).set("x", short(at.x)).set("y", short(at.y));
            Box::new(text.set("font-size", short(FONT * unit)))
        }
    }
}

fn hexagon(centre: Vec2, radius: f64, colour: Rgb) -> Path {
    let corner = |k: u32| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_3 * (f64::from(k) + 0.5)).sin_cos();
        let p = centre + Vec2::new(cos, sin) * radius;
        format!("{:.2} {:.2}", p.x, p.y)
    };
    let corners: Vec<String> = (0..6).map(corner).collect();
    Path::new()
        .set("d", format!("M{}Z", corners.join("L")))
        .set("fill", hex(colour))
        .set("stroke", "#40404a")
        .set("stroke-width", "1")
}

fn short(x: f64) -> String {
    format!("{x:.2}")
}

fn point(seen: &Seen) -> String {
    format!("{:.2} {:.2}", seen.x, seen.y)
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::scan_polygon;

    /// Quads between `around` meridians, on a profile of `rows` points given by radius and height;
    /// closed along the profile or open.
    fn revolved(around: usize, profile: &[[f64; 2]], closed: bool) -> HexMesh {
        let rows = profile.len();
        let point = |i: usize, [r, z]: [f64; 2]| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / around as f64).sin_cos();
            Vec3::new(r * cos, r * sin, z)
        };
        let ring = |i: usize| profile.iter().map(move |&p| point(i, p));
        let number = |i: usize, j: usize| ((i % around) * rows + j % rows) as u32;
        let strips = if closed { rows } else { rows - 1 };
        let cells = (0..around).flat_map(|i| (0..strips).map(move |j| (i, j)));
        let faces: Vec<[u32; 4]> = cells
            .map(|(i, j)| {
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| number(i, j))
            })
            .collect();
        HexMesh::new((0..around).flat_map(ring).collect(), &faces).unwrap()
    }

    fn torus(around: usize, across: usize) -> HexMesh {
        let at = |j: usize| {
            let (sin, cos) = (std::f64::consts::TAU * j as f64 / across as f64).sin_cos();
            [2.0 + cos, sin]
        };
        revolved(around, &(0..across).map(at).collect::<Vec<_>>(), true)
    }

    /// A hemisphere with a hole at its top.
    fn dome(around: usize, rows: usize) -> HexMesh {
        let at = |j: usize| {
            let (sin, cos) = (1.4 * j as f64 / rows as f64).sin_cos();
            [cos, sin]
        };
        revolved(around, &(0..=rows).map(at).collect::<Vec<_>>(), false)
    }

    /// The panel on top of each sample when panels are painted in the drawing's order.
    fn painted(mesh: &HexMesh, options: &PictureOptions) -> (Vec<u32>, Vec<u32>) {
        let camera = Camera::facing(mesh, options);
        let paint = Paint::kinds(mesh);
        let raster = PanelRaster::new(mesh, &camera, &paint, 1);
        let covering = Covering::new(&raster, options);
        let mut top = vec![u32::MAX; options.width * options.height];
        for f in drawing_order(mesh, &camera, &covering) {
            let seen = mesh.corners(f).map(|p| camera.see(camera.normalised(p)));
            let outline: Vec<Vec2> = seen.map(|s| Vec2::new(s.x, s.y)).collect();
            scan_polygon(
                &outline,
                0..options.height,
                options.width,
                |row, columns| {
                    top[row * options.width..][columns].fill(f.index() as u32);
                },
            );
        }
        (top, covering.top().to_vec())
    }

    #[test]
    fn painting_in_order_shows_what_is_nearest_on_every_sample() {
        let views = [(35.0, -60.0), (8.0, 10.0), (-50.0, 200.0)];
        let meshes = [torus(40, 24), dome(36, 14)];
        for (mesh, (elevation, azimuth)) in meshes.iter().flat_map(|m| views.map(|v| (m, v))) {
            let options = PictureOptions {
                width: 320,
                height: 240,
                elevation,
                azimuth: Some(azimuth),
                ..Default::default()
            };
            let (painted, nearest) = painted(mesh, &options);
            let wrong = painted.iter().zip(&nearest).filter(|(a, b)| a != b);
            assert_eq!(wrong.count(), 0, "elevation {elevation}");
        }
    }

    #[test]
    fn hidden_panels_are_left_out() {
        let mesh = torus(40, 24);
        let map = crate::maps::tests::map(&mesh, crate::maps::Map::Valence);
        let svg = crate::draw_svg(&mesh, &map, &PictureOptions::default());
        // The group of the panels has a name, too.
        let paths = svg.matches(" id=\"p").count() - 1;
        let all = mesh.topology().n_faces();
        assert!(paths < all * 3 / 4 && paths > all / 4, "{paths} of {all}");
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    }
}
