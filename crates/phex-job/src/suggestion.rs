//! What kind of surface one is, and how many panels suit it.

use crate::hexagon::{edge_length, hexagon_area};
use phex::curvature::{CurvatureOptions, Principal, principal, tensors_at};
use phex::directions::Guides;
use phex::layout::{CELL, MAX_PANELS};
use phex_mesh::{TriangleSurface, VertexId};
use serde::Serialize;

/// Panels at whose scale curvature is looked at.
const LOOKED_AT: f64 = 300.0;
/// Vertices at which it is looked at, at most.
const SAMPLES: usize = 4000;
/// Larger curvature times the length of such a panel below which a place is flat.
const FLAT: f64 = 0.02;
/// Smaller over larger curvature below which a place is curved one way only.
const ONE_WAY: f64 = 0.05;
/// Share of the area with one sign of curvature from which on a Koebe mesh may do.
const OF_ONE_SIGN: f64 = 0.999;
/// Angle between the normals of two triangles from which on their edge is a crease, in degrees:
/// what `--crease` takes.
const CREASE: f64 = 30.0;
/// Share of the area that is curved less than what is told as the strongest curvature.
const MOST: f64 = 0.99;
/// Largest distance of a panel from the surface, over its edge squared times the curvature: a
/// panel whose centre and corners are equally far off has a quarter, and what is measured on
/// built-in surfaces with 100 to 1000 panels is around it.
const SAGITTA: f64 = 0.25;
/// The same over the radius of curvature, where panels are longer than that.
const AROUND_A_BEND: f64 = 0.5;
/// Step from one number of panels to the next where one is looked for, as a share of it.
const STEP: f64 = 0.02;
/// Length of a panel over the radius of curvature from which on the surface has features below
/// panel size.
const RESOLVED: f64 = 0.8;

/// What kind of surface one is; shares of its area, 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurfaceKind {
    /// Where the Gauss curvature is positive: panels are convex.
    pub domes: f64,
    /// Where it is negative: panels are concave.
    pub saddles: f64,
    /// Where the surface is curved one way only, as a cylinder is: panels are bricks.
    pub one_way: f64,
    /// Where it is flat.
    pub flat: f64,
    /// Largest absolute normal curvature on all but a hundredth of the area, over model units.
    pub strongest: f64,
    /// Number of edges that are sharper than 30 degrees.
    pub creases: usize,
    /// Number of edges at which the surface passes through itself.
    pub self_crossings: usize,
    /// The middle of the first of them.
    pub crosses_at: Option<[f64; 3]>,
    /// Area in squared model units.
    pub area: f64,
    /// Curvature of places, and the area of each.
    #[serde(skip)]
    places: Vec<(Principal, f64)>,
    /// Whether the surface is a sphere or a disc but for its shape.
    #[serde(skip)]
    is_simple: bool,
}

/// A number of panels, and what to expect of it; lengths in model units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suggestion {
    /// Number of panels.
    pub panels: u64,
    /// Mean length of their edges, about.
    pub edge_length: f64,
    /// Their largest distance from the surface, about.
    pub deviation: f64,
}

impl SurfaceKind {
    /// Looks at a surface, at the scale of 300 panels.
    pub fn new(surface: &TriangleSurface) -> Self {
        let area = surface.area();
        let length = (area / (CELL * LOOKED_AT)).sqrt();
        let places = places(surface, length);
        let share = |is: &dyn Fn(&Principal) -> bool| {
            let all: f64 = places.iter().map(|p| p.1).sum();
            let some: f64 = places.iter().filter(|p| is(&p.0)).map(|p| p.1).sum();
            some / all
        };
        let flat = |p: &Principal| p.large.abs() * length < FLAT;
        let one_way = |p: &Principal| !flat(p) && p.small.abs() < ONE_WAY * p.large.abs();
        let curved = |p: &Principal| !flat(p) && !one_way(p);
        Self {
            domes: share(&|p| curved(p) && p.small * p.large > 0.0),
            saddles: share(&|p| curved(p) && p.small * p.large < 0.0),
            one_way: share(&one_way),
            flat: share(&flat),
            strongest: at_most(bends(&places)),
            creases: creases(surface),
            self_crossings: surface.self_crossings().len(),
            crosses_at: surface.self_crossings().first().map(|&p| p.into()),
            area,
            places,
            is_simple: is_simple(surface),
        }
    }

    /// What to expect of a number of panels.
    pub fn of_panels(&self, panels: u64) -> Suggestion {
        let edge_length = edge_length(self.area / panels as f64);
        Suggestion {
            panels,
            edge_length,
            deviation: self.deviation(edge_length),
        }
    }

    /// Panels that are no farther from the surface than a length, or as many as make sense.
    pub fn of_deviation(&self, length: f64) -> Suggestion {
        let larger = |n: &u64| Some((*n + 1).max((*n as f64 * (1.0 + STEP)) as u64));
        let counts = std::iter::successors(Some(1), larger);
        let mut counts = counts.take_while(|n| *n < MAX_PANELS as u64);
        let near = counts.find(|n| self.of_panels(*n).deviation <= length);
        self.of_panels(near.unwrap_or(MAX_PANELS as u64))
    }

    /// Distance from the surface of most panels with edges of a length.
    fn deviation(&self, edge: f64) -> f64 {
        let off = |p: &Principal| {
            // A concave panel has corners above the surface and corners below it.
            let across = (-p.small * p.large.signum()).max(0.0);
            let sagitta = SAGITTA * (p.large.abs() + across) * edge * edge;
            sagitta.min(AROUND_A_BEND / p.large.abs())
        };
        at_most(self.places.iter().map(|(p, area)| (off(p), *area)))
    }

    /// The least number of panels that are not longer than features of the surface.
    pub fn resolving(&self) -> u64 {
        let edge = 0.5 * RESOLVED / self.strongest;
        ((self.area / hexagon_area(edge)).ceil() as u64).max(1)
    }

    /// What the curvature means for panels, in sentences.
    pub fn sentences(&self) -> Vec<String> {
        let percent = |x: f64| format!("{:.0} %", 100.0 * x);
        let kinds = [
            (self.domes, "dome-like (K > 0: convex panels)"),
            (
                self.saddles,
                "saddle-like (K < 0: concave panels, with two re-entrant corners)",
            ),
            (
                self.one_way,
                "curved one way (bricks with rows along the straight direction)",
            ),
            (self.flat, "flat (regular hexagons)"),
        ];
        let shown = kinds.iter().filter(|k| k.0 >= 0.005);
        let mut sentences: Vec<String> = shown
            .map(|(share, what)| format!("{} of the area is {what}", percent(*share)))
            .collect();
        let largest = self.domes.max(self.saddles);
        if self.is_simple && largest > OF_ONE_SIGN {
            sentences
                .push("one sign of K: `--method koebe` may give beams of one height".to_owned());
        }
        if self.creases > 0 {
            sentences.push(format!(
                "{} edges are sharper than {CREASE} degrees: panels round them off; `--crease` lets rows run along them",
                self.creases
            ));
        }
        if let Some([x, y, z]) = self.crosses_at {
            sentences.push(format!(
                "{} edges pass through other triangles, as at ({x:.6}, {y:.6}, {z:.6}): the surface passes through itself, and panels will, too",
                self.self_crossings
            ));
        }
        sentences
    }
}

/// Curvature at some vertices, and the area round each.
fn places(surface: &TriangleSurface, length: f64) -> Vec<(Principal, f64)> {
    let count = surface.positions().len();
    let step = count.div_ceil(SAMPLES);
    let vertices: Vec<VertexId> = (0..count)
        .step_by(step)
        .map(|i| VertexId::new(i as u32))
        .collect();
    let tensors = tensors_at(surface, &vertices, length, &CurvatureOptions::default());
    let area = |v: VertexId| -> f64 {
        let around = surface.topology().outgoing(v);
        around
            .map(|h| surface.area_vector(surface.topology().face(h)).norm())
            .sum()
    };
    let at = |(v, tensor): (&VertexId, &_)| (principal(surface.normals()[*v], tensor), area(*v));
    vertices.iter().zip(&tensors).map(at).collect()
}

/// The larger curvature of each place, and its area.
fn bends(places: &[(Principal, f64)]) -> impl Iterator<Item = (f64, f64)> {
    places.iter().map(|p| (p.0.large.abs(), p.1))
}

/// The figure that all but a small share of the area stays below.
fn at_most(figures: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut sorted: Vec<(f64, f64)> = figures.collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = sorted.iter().map(|f| f.1).sum();
    let mut below = 0.0;
    let found = sorted.iter().find(|f| {
        below += f.1;
        below >= MOST * whole
    });
    found.map_or(0.0, |f| f.0)
}

/// Whether a surface has no handle, and one boundary curve at the most.
fn is_simple(surface: &TriangleSurface) -> bool {
    let topology = surface.topology();
    let loops = topology.boundary_loops().len() as i64;
    loops <= 1 && topology.euler_characteristic() + loops == 2
}

fn creases(surface: &TriangleSurface) -> usize {
    let guides = Guides {
        crease: Some(CREASE),
        ..Default::default()
    };
    guides.with_creases(surface).lines.len()
}
