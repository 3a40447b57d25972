//! The picture as vectors: panels from the farthest to the nearest, each with its edges, the hidden ones left out.
//!
//! The order comes from the samples of the picture: where two panels cover the same sample, the nearer one is drawn
//! later. An order that keeps to all of these pairs is found by sorting topologically, the farthest first where several
//! are possible; in a cycle (panels that overlap one another in turn) the farthest goes first.

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
use std::fmt::Write;

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
    let mut svg = Svg::new(options);
    let width = LINE_REL * options.height as f64;
    svg.open_panels(if paint.edges.is_some() {
        COLOURED_WIDTH * width
    } else {
        width
    });
    let see = |p: Vec3| camera.see(camera.normalised(p));
    for f in order {
        let outline: Vec<Seen> = mesh.corners(f).map(see).collect();
        let seams_only = paint.edges.is_some() || !options.edges;
        svg.panel(f, &outline, rgb(shading.panels[f]), seams_only);
        if paint.edges.is_some() && options.edges {
            svg.edges(mesh, f, &see, |e| rgb(paint.ink(e)));
        }
    }
    svg.close_panels();
    if options.legend {
        svg.legend(paint, &covering);
    }
    svg.finish()
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

/// A drawing that grows.
struct Svg {
    text: String,
    size: Vec2,
}

impl Svg {
    fn new(options: &PictureOptions) -> Self {
        let (width, height) = (options.width, options.height);
        let mut svg = Self {
            text: String::new(),
            size: Vec2::new(width as f64, height as f64),
        };
        svg.line(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">"
        ));
        svg.line(&format!(
            "<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"
        ));
        svg
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn open_panels(&mut self, width: f64) {
        self.line(&format!(
            "<g id=\"panels\" stroke=\"#1a1a1f\" stroke-width=\"{width:.2}\" stroke-linejoin=\"round\" stroke-linecap=\"round\">"
        ));
    }

    /// A panel with its outline; where edges carry colours, the outline only closes the seams between fillings.
    fn panel(&mut self, f: FaceId, outline: &[Seen], fill: Rgb, seams_only: bool) {
        let points: Vec<String> = outline.iter().map(point).collect();
        let (fill, number) = (hex(fill), f.index());
        let seam = if seams_only {
            format!(" stroke=\"{fill}\" stroke-width=\"0.6\"")
        } else {
            String::new()
        };
        self.line(&format!(
            "<path id=\"p{number}\" d=\"M{}Z\" fill=\"{fill}\"{seam}/>",
            points.join("L")
        ));
    }

    /// The edges of a panel in their own colours.
    fn edges(
        &mut self,
        mesh: &HexMesh,
        f: FaceId,
        see: &impl Fn(Vec3) -> Seen,
        ink: impl Fn(EdgeId) -> Rgb,
    ) {
        let topology = mesh.topology();
        for h in topology.face_half_edges(f) {
            let ends = [topology.origin(h), topology.target(h)].map(|v| see(mesh.position(v)));
            let colour = hex(ink(topology.edge(h)));
            let [a, b] = ends.each_ref().map(point);
            self.line(&format!("<path d=\"M{a}L{b}\" stroke=\"{colour}\"/>"));
        }
    }

    fn close_panels(&mut self) {
        self.line("</g>");
    }

    fn legend(&mut self, paint: &Paint, covering: &Covering) {
        let layout = LegendLayout::new(&paint.legend, self.size.y);
        let corner = layout.place(self.size, |low, high| covering.seen_within(low, high));
        self.line(
            "<g id=\"legend\" font-family=\"Helvetica, Arial, sans-serif\" fill=\"#38383f\">",
        );
        for item in &layout.items {
            self.item(corner, item);
        }
        self.line("</g>");
    }

    fn item(&mut self, corner: Vec2, item: &Item) {
        match item {
            Item::Hexagon {
                centre,
                radius,
                colour,
            } => self.hexagon(corner + centre, *radius, *colour),
            Item::Rectangle { low, high, colour } => {
                let (at, size) = (corner + low, high - low);
                self.line(&format!(
                    "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"{}\"/>",
                    at.x,
                    at.y,
                    size.x,
                    size.y,
                    hex(*colour)
                ));
            }
            Item::Text { start, unit, text } => {
                let at = corner + start;
                self.line(&format!(
                    "<text x=\"{:.2}\" y=\"{:.2}\" font-size=\"{:.2}\">{text}</text>",
                    at.x,
                    at.y,
                    FONT * unit
                ));
            }
        }
    }

    fn hexagon(&mut self, centre: Vec2, radius: f64, colour: Rgb) {
        let mut path = String::new();
        for k in 0..6 {
            let (sin, cos) = (std::f64::consts::FRAC_PI_3 * (k as f64 + 0.5)).sin_cos();
            let p = centre + Vec2::new(cos, sin) * radius;
            // Writing to a string does not fail.
            let _ = write!(
                path,
                "{}{:.2} {:.2}",
                if k == 0 { 'M' } else { 'L' },
                p.x,
                p.y
            );
        }
        self.line(&format!(
            "<path d=\"{path}Z\" fill=\"{}\" stroke=\"#40404a\" stroke-width=\"1\"/>",
            hex(colour)
        ));
    }

    fn finish(mut self) -> String {
        self.line("</svg>");
        self.text
    }
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

    /// Quads between `around` meridians, on a profile of `rows` points given by radius and height; closed along the profile
    /// or open.
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
        let paths = svg.matches("<path id=\"p").count();
        let all = mesh.topology().n_faces();
        assert!(paths < all * 3 / 4 && paths > all / 4, "{paths} of {all}");
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    }
}
