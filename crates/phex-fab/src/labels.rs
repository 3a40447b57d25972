//! Where text goes on a panel: its name in the middle, and along each side the name of the
//! neighbour with the mitre angle.
//!
//! Texts stay inside the panel's upper face and off one another, with a margin. They are as large
//! as asked for where there is room; where there is not, all texts of the panel shrink, down to 2
//! mm. What does not fit then is left out and said.

use crate::ids::written;
use crate::layer::{Layer, Stroke};
use crate::outline::outward;
use crate::plate::Plate;
use phex_mesh::polygon::{contains, point_segment_distance, segments_touch, sides};
use phex_mesh::{Vec2, bounds};
use phex_picture::strokes;

/// Height of a side's text over that of the name.
const SIDE: f64 = 0.6;
/// Free room round a text, over its height.
const MARGIN: f64 = 0.35;
/// Least height of a panel's name, in mm: the names at its sides are smaller.
pub const LEAST: f64 = 3.4;
/// Largest height over the radius of the largest circle in the panel.
const OF_RADIUS: f64 = 0.5;
/// Ratio of successive heights.
const SHRINK: f64 = 0.85;
/// Points of the grid on which places for the name are looked for, along a side of the bounding
/// box.
const GRID: usize = 24;
/// Places along a side, and distances from it in text heights.
const PLACES: [f64; 9] = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74, 0.18, 0.82];
const DEPTHS: [f64; 4] = [0.0, 0.6, 1.2, 1.8];

/// What is written along one side.
#[derive(Clone, Debug, PartialEq)]
pub struct SideText {
    /// Number of the side.
    pub side: usize,
    /// Engraved: the neighbour.
    pub neighbour: String,
    /// Not engraved: the mitre angle.
    pub mitre: String,
}

/// The strokes of all texts of a panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PanelText {
    /// Lines, in the panel's own coordinates.
    pub strokes: Vec<Stroke>,
    /// Rectangles round the texts.
    pub boxes: Vec<[Vec2; 4]>,
    /// Texts that found no room.
    pub left_out: Vec<String>,
}

/// Places the texts of a panel; `largest` is the height of its name where there is room, in mm.
pub fn place(plate: &Plate, name: &str, texts: &[SideText], largest: f64) -> PanelText {
    let spots = spots(&plate.top);
    let radius = spots.first().map_or(0.0, |s| s.0);
    let mut height = largest.min(OF_RADIUS * radius).max(LEAST);
    let mut best = attempt(plate, name, texts, height, &spots);
    while !best.left_out.is_empty() && height > LEAST {
        height = (height * SHRINK).max(LEAST);
        let smaller = attempt(plate, name, texts, height, &spots);
        if smaller.left_out.len() < best.left_out.len() {
            best = smaller;
        }
    }
    best
}

/// Points of a grid inside a polygon, farthest from its sides first, with that distance.
fn spots(polygon: &[Vec2]) -> Vec<(f64, Vec2)> {
    let [low, high] = bounds(polygon);
    let step = (high - low) / GRID as f64;
    let point = |k: usize| {
        low + Vec2::new((k % GRID) as f64 + 0.5, (k / GRID) as f64 + 0.5).component_mul(&step)
    };
    let depth = |p: Vec2| {
        sides(polygon)
            .map(|[a, b]| point_segment_distance(p, a, b))
            .fold(f64::INFINITY, f64::min)
    };
    let inside = (0..GRID * GRID)
        .map(point)
        .filter(|&p| contains(polygon, p));
    let mut spots: Vec<(f64, Vec2)> = inside.map(|p| (depth(p), p)).collect();
    spots.sort_by(|a, b| b.0.total_cmp(&a.0));
    spots
}

/// A rectangle that a text fills.
#[derive(Clone, Copy)]
struct TextBox {
    centre: Vec2,
    along: Vec2,
    half: Vec2,
}

impl TextBox {
    fn new(centre: Vec2, along: Vec2, width: f64, height: f64) -> Self {
        Self {
            centre,
            along,
            half: Vec2::new(width, height) * 0.5,
        }
    }

    fn corners(&self, margin: f64) -> [Vec2; 4] {
        let u = self.along * (self.half.x + margin);
        let v = Vec2::new(-self.along.y, self.along.x) * (self.half.y + margin);
        [
            self.centre - u - v,
            self.centre + u - v,
            self.centre + u + v,
            self.centre - u + v,
        ]
    }

    /// Strokes of a text that starts `skip` from the left.
    fn write(
        &self,
        text: &str,
        height: f64,
        skip: f64,
        layer: Layer,
    ) -> impl Iterator<Item = Stroke> {
        let [start, ..] = self.corners(0.0);
        let (u, v) = (self.along, Vec2::new(-self.along.y, self.along.x));
        let place = move |p: Vec2| start + u * (p.x + skip) + v * p.y;
        let lines = strokes::strokes(&written(text), height);
        lines.into_iter().map(move |line| Stroke {
            layer,
            points: line.into_iter().map(place).collect(),
            closed: false,
        })
    }
}

fn attempt(
    plate: &Plate,
    name: &str,
    texts: &[SideText],
    height: f64,
    spots: &[(f64, Vec2)],
) -> PanelText {
    let mut placed = PanelText::default();
    let wide = width(name, height);
    let frame = |&(_, p): &(f64, Vec2)| TextBox::new(p, Vec2::x(), wide, height);
    let margin = MARGIN * height;
    match spots
        .iter()
        .map(frame)
        .find(|f| is_free(f, margin, &plate.top, &placed.boxes))
    {
        Some(frame) => placed.add(&frame, [(name, Layer::Engrave), ("", Layer::Label)], height),
        None => placed.left_out.push(name.to_owned()),
    }
    let small = SIDE * height;
    let mut shortest_first: Vec<&SideText> = texts.iter().collect();
    let lengths = plate.lengths();
    shortest_first.sort_by(|a, b| lengths[a.side].total_cmp(&lengths[b.side]));
    for text in shortest_first {
        place_side(plate, text, small, &mut placed);
    }
    placed
}

/// Width of a text as it is engraved.
fn width(text: &str, height: f64) -> f64 {
    strokes::width(&written(text), height)
}

fn place_side(plate: &Plate, text: &SideText, height: f64, placed: &mut PanelText) {
    let whole = format!("{} {}", text.neighbour, text.mitre);
    let size = width(&whole, height);
    let n = plate.top.len();
    let [a, b] = [plate.top[text.side], plate.top[(text.side + 1) % n]];
    let inward = -outward(a, b);
    let margin = MARGIN * height;
    let along = upright((b - a).normalize());
    let beside = DEPTHS
        .iter()
        .flat_map(|depth| PLACES.iter().map(move |t| (*t, *depth)))
        .map(|(t, depth)| {
            let from_side = 1.01 * margin + (0.5 + depth) * height;
            TextBox::new(a + (b - a) * t + inward * from_side, along, size, height)
        });
    let across = PLACES.iter().map(|t| {
        let centre = a + (b - a) * *t + inward * (1.01 * margin + 0.5 * size);
        TextBox::new(centre, upright(inward), size, height)
    });
    match beside
        .chain(across)
        .find(|f| is_free(f, margin, &plate.top, &placed.boxes))
    {
        Some(frame) => {
            placed.add(
                &frame,
                [
                    (&text.neighbour, Layer::Engrave),
                    (&text.mitre, Layer::Label),
                ],
                height,
            );
        }
        None => placed.left_out.push(whole),
    }
}

/// The direction or its opposite, such that text along it is not upside down.
fn upright(d: Vec2) -> Vec2 {
    if d.x < -1e-9 || (d.x < 1e-9 && d.y < 0.0) {
        -d
    } else {
        d
    }
}

impl PanelText {
    fn add(&mut self, frame: &TextBox, [first, second]: [(&str, Layer); 2], height: f64) {
        let skip = strokes::advance(&written(&format!("{} ", first.0)), height);
        self.strokes
            .extend(frame.write(first.0, height, 0.0, first.1));
        self.strokes
            .extend(frame.write(second.0, height, skip, second.1));
        self.boxes.push(frame.corners(0.0));
    }
}

/// Whether a rectangle with its margin lies in a polygon and off other rectangles.
fn is_free(frame: &TextBox, margin: f64, polygon: &[Vec2], others: &[[Vec2; 4]]) -> bool {
    let wide = frame.corners(margin);
    let inside = || {
        let crosses = |[a, b]: [Vec2; 2]| sides(&wide).any(|[c, d]| segments_touch(a, b, c, d));
        contains(polygon, frame.centre) && !sides(polygon).any(crosses)
    };
    others.iter().all(|other| apart(&wide, other)) && inside()
}

/// Whether a side of one of two rectangles separates them.
fn apart(a: &[Vec2; 4], b: &[Vec2; 4]) -> bool {
    let separates = |p: &[Vec2; 4], q: &[Vec2; 4]| {
        sides(p).any(|[c, d]| {
            let out = outward(c, d);
            q.iter().all(|r| (r - c).dot(&out) > 0.0)
        })
    };
    separates(a, b) || separates(b, a)
}
