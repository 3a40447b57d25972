//! What came of what was asked of rows, cones and sizes: told with figures, since a field of
//! directions can't follow everything.

use crate::error::JobError;
use phex::MeshOptions;
use phex::curvature::curvature;
use phex::directions::thickness;
use phex::directions::{Cone, Guides};
use phex::directions::{Demands, relative_sizes};
use phex::layout::CELL;
use phex::smooth_surface::coarsened;
use phex_mesh::polygon::sides;
use phex_mesh::{FaceId, HexMesh, TriangleSurface, Vec3};

/// Diagonals of the surface that points for rows, cones and holds may be away from its box: farther
/// off, their unit is another one.
const FARTHEST: f64 = 10.0;
/// Angle, degrees, up to which a row runs along a line; without any order a third of all rows
/// would.
const ALONG: f64 = 10.0;
/// Mean edges between a prescribed cone and the one that counts as it.
const IN_PLACE: f64 = 2.0;
/// Points at which lines are compared with rows, at the most.
const MOST_SAMPLES: usize = 2000;
/// Cones that a sentence names at the most.
const NAMED: usize = 5;
/// Largest size over the smallest below which all panels have one size.
const ONE_SIZE: f64 = 1.05;
/// Distance of sheets in panel lengths from which on it does not matter.
const THICK: f64 = 4.0;
/// Vertices a panel of the surface on which the sizes that are wanted are looked at.
const VERTICES: usize = 32;

/// Refuses points that are nowhere near the surface.
///
/// # Errors
/// The first of them, by the option and the number of what it belongs to, from 0.
pub fn check_near(options: &MeshOptions, surface: &TriangleSurface) -> Result<(), JobError> {
    let (guides, steering) = (&options.directions.guides, &options.steering);
    let lines = |lines: &[Vec<[f64; 3]>]| -> Vec<(usize, [f64; 3])> {
        let numbered = lines.iter().enumerate();
        numbered
            .flat_map(|(i, l)| l.iter().map(move |p| (i, *p)))
            .collect()
    };
    let all = [
        ("guide line", lines(&guides.lines)),
        (
            "cone",
            guides
                .cones
                .iter()
                .map(|c| c.position)
                .enumerate()
                .collect(),
        ),
        ("curve", lines(&steering.curves)),
        (
            "anchor",
            steering
                .anchors
                .iter()
                .map(|a| a.point)
                .enumerate()
                .collect(),
        ),
    ];
    let (low, high) = surface.bounding_box();
    let diagonal = surface.diagonal();
    for (what, points) in all {
        let away = |p: &[f64; 3]| {
            let p = Vec3::from(*p);
            (p - p.sup(&low).inf(&high)).norm() / diagonal
        };
        if let Some((index, p)) = points.iter().find(|(_, p)| away(p) > FARTHEST) {
            return Err(JobError::input(format!(
                "{what} {index} (counted from 0) has a point {:.3e} diagonals of the surface away from it, at most {FARTHEST} \
                 make sense: is it in another unit?",
                away(p)
            )));
        }
    }
    Ok(())
}

/// What came of the wishes.
pub struct Wishes<'a> {
    /// The options with them.
    pub options: &'a MeshOptions,
    /// The smallest and the largest size that was given, where sizes were.
    pub size_field: Option<[f64; 2]>,
    /// Number of panels that was asked for.
    pub panels: u64,
    /// The input.
    pub facets: &'a TriangleSurface,
    /// The smooth surface, where there is one.
    pub smooth: &'a TriangleSurface,
    /// The panels.
    pub mesh: &'a HexMesh,
    /// The cones of the fields that they were laid out by.
    pub cones: &'a [Cone],
}

impl Wishes<'_> {
    /// Sentences, each with what it is about; none where nothing was asked for.
    pub fn told(&self) -> Vec<(&'static str, String)> {
        let guides = &self.options.directions.guides;
        let mut told = Vec::new();
        if !guides.cones.is_empty() {
            told.push(("cones", self.of_cones(&guides.cones)));
        }
        if !guides.lines.is_empty() {
            told.push(("guides", self.of_lines(&guides.lines)));
        }
        if let Some(angle) = guides.crease {
            told.push(("creases", self.of_creases(angle)));
        }
        if let Some(limit) = self.options.sizes.adaptive {
            told.push(("adaptive", self.of_sizes(limit)));
        }
        if let Some([smallest, largest]) = self.size_field {
            told.push(("size-field", self.of_ratio(largest / smallest)));
        }
        told
    }

    fn of_cones(&self, wanted: &[Cone]) -> String {
        let edge = self.mesh.mean_edge();
        let off = |cone: &Cone| {
            let same = self.cones.iter().filter(|c| c.index == cone.index);
            let distance = |c: &Cone| (Vec3::from(c.position) - Vec3::from(cone.position)).norm();
            same.map(distance).fold(f64::INFINITY, f64::min) / edge
        };
        let missed: Vec<(usize, f64)> = wanted
            .iter()
            .map(off)
            .enumerate()
            .filter(|m| m.1 > IN_PLACE)
            .collect();
        let (placed, all) = (wanted.len() - missed.len(), wanted.len());
        if missed.is_empty() {
            return format!("all {all} prescribed ones are in their places");
        }
        let name = |&(i, off): &(usize, f64)| match off.is_finite() {
            true => format!("{i} (the nearest of its index is {off:.1} mean edges away)"),
            false => format!("{i} (none has its index)"),
        };
        let named: Vec<String> = missed.iter().take(NAMED).map(name).collect();
        let more = if missed.len() > NAMED { ", ..." } else { "" };
        format!(
            "NOT ALL PLACED: {placed} of {all} prescribed ones are in their places; not so, counted from 0: {}{more}",
            named.join(", ")
        )
    }

    fn of_lines(&self, lines: &[Vec<[f64; 3]>]) -> String {
        let edge = self.mesh.mean_edge();
        let samples = samples(lines, 0.5 * edge);
        let rows = PanelRows::of(self.mesh);
        let angles = samples
            .iter()
            .filter_map(|(p, t)| rows.angle(*p, *t, 2.0 * edge));
        let angles: Vec<f64> = angles.collect();
        if angles.is_empty() {
            return "NOT FOLLOWED: no panel lies near the lines".to_owned();
        }
        let count = angles.len() as f64;
        let along = angles.iter().filter(|a| **a <= ALONG).count() as f64 / count;
        let mean = angles.iter().sum::<f64>() / count;
        let off = 1.0 - count / samples.len() as f64;
        let beside = match off > 0.05 {
            true => format!("; {:.0} % of their length is off the panels", 100.0 * off),
            false => String::new(),
        };
        let [not, instead] = match along < 0.5 {
            true => [
                "NOT FOLLOWED: ",
                "; panels may be better with fewer lines, or none",
            ],
            false => [""; 2],
        };
        format!(
            "{not}rows run along {:.0} % of the lines (within {ALONG} degrees; {mean:.1} on average){beside}{instead}",
            100.0 * along
        )
    }

    fn of_creases(&self, angle: f64) -> String {
        let none = Guides {
            crease: Some(angle),
            ..Guides::default()
        };
        let creases = none.with_creases(self.facets).lines;
        if creases.is_empty() {
            return format!(
                "NO EFFECT: no edge of the surface is as sharp as {angle} degrees, the sharpest has {:.1}",
                sharpest(self.facets)
            );
        }
        format!(
            "{} edges of the surface; {}",
            creases.len(),
            self.of_lines(&creases)
        )
    }

    fn of_sizes(&self, limit: f64) -> String {
        let wanted = VERTICES * self.panels as usize;
        let is_fine = self.smooth.positions().len() > 2 * wanted;
        let coarse = is_fine.then(|| coarsened(self.smooth, &[], wanted).surface);
        let surface = coarse.as_ref().unwrap_or(self.smooth);
        let length = (surface.area() / (CELL * self.panels as f64)).sqrt();
        let principal = curvature(surface, length, &self.options.curvature).principal();
        let thickness = thickness(surface, THICK * length);
        let demands = Demands {
            principal: &principal,
            thickness: Some(&thickness),
            field: None,
        };
        let sizes = relative_sizes(surface, &demands, length, &self.options.sizes);
        let [smallest, largest] = range(sizes.iter().flatten().copied());
        if largest <= ONE_SIZE * smallest {
            let [least, most] = range(principal.iter().map(|p| p.large.abs() * length));
            return format!(
                "HARDLY ANY EFFECT: panels of about one size are wanted everywhere (lengths in a ratio of {:.2}; panel length times curvature is {least:.2} to {most:.2}, the limit {limit})",
                largest / smallest
            );
        }
        self.of_ratio(largest / smallest)
    }

    /// The ratio of the largest to the smallest panel length that is wanted, and the one there is.
    fn of_ratio(&self, wanted: f64) -> String {
        let [small, large] = panel_lengths(self.mesh);
        format!(
            "lengths in a ratio of {wanted:.2} are wanted, those of the inner panels have {:.2} (5 % and 95 % of them: {small:.4}, {large:.4})",
            large / small
        )
    }
}

/// The smallest and the largest of positive values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[a, b], x| {
        [f64::min(a, x), f64::max(b, x)]
    })
}

/// Largest angle, degrees, by which the normals of neighbouring triangles differ.
fn sharpest(surface: &TriangleSurface) -> f64 {
    let topology = surface.topology();
    let angle = |e| {
        let sides = topology.faces_beside(e)?.map(|f| surface.area_vector(f));
        Some(sides[0].angle(&sides[1]).to_degrees())
    };
    topology.edges().filter_map(angle).fold(0.0, f64::max)
}

/// The panel length that 5 % of the inner panels stay below, and that 95 % do.
fn panel_lengths(mesh: &HexMesh) -> [f64; 2] {
    let topology = mesh.topology();
    let inner = topology.inner_faces();
    let length = |f: FaceId| {
        let (corners, centre): (Vec<Vec3>, Vec3) = (mesh.corners(f).collect(), mesh.centre(f));
        let doubled = sides(&corners).map(|[a, b]| (a - centre).cross(&(b - centre)));
        let area: Vec3 = doubled.sum();
        (0.5 * area.norm() / CELL).sqrt()
    };
    let mut lengths: Vec<f64> = inner.map(length).collect();
    lengths.sort_by(f64::total_cmp);
    let last = lengths.len().saturating_sub(1) as f64;
    let at = |share: f64| {
        lengths
            .get((share * last).round() as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    [at(0.05), at(0.95)]
}

/// Points along lines with unit tangents, `step` apart, or farther where they would be too many.
fn samples(lines: &[Vec<[f64; 3]>], step: f64) -> Vec<(Vec3, Vec3)> {
    let ends = || {
        lines
            .iter()
            .flat_map(|l| l.windows(2))
            .map(|w| [w[0], w[1]].map(Vec3::from))
    };
    let whole: f64 = ends().map(|[a, b]| (b - a).norm()).sum();
    let step = step.max(whole / MOST_SAMPLES as f64);
    let (mut points, mut passed, mut next) = (Vec::new(), 0.0, 0.5 * step);
    for [a, b] in ends() {
        let length = (b - a).norm();
        while length > 0.0 && next < passed + length {
            points.push((a + (b - a) * ((next - passed) / length), (b - a) / length));
            next += step;
        }
        passed += length;
    }
    points
}

/// Panels with the directions of the rows that run through them.
struct PanelRows {
    panels: Vec<(Vec3, Vec<Vec3>)>,
}

impl PanelRows {
    fn of(mesh: &HexMesh) -> Self {
        let topology = mesh.topology();
        let panel = |f: FaceId| {
            let centre = mesh.centre(f);
            let beside = topology.adjacent_faces(f);
            let ways = beside.map(|g| (mesh.centre(g) - centre).normalize());
            (centre, ways.collect::<Vec<Vec3>>())
        };
        let panels = topology.faces().map(panel);
        Self {
            panels: panels.filter(|(_, ways)| !ways.is_empty()).collect(),
        }
    }

    /// Angle in degrees, up to 30 in a regular lattice, between a line and the nearest row through
    /// the nearest panel, if there is one within `reach`.
    fn angle(&self, p: Vec3, tangent: Vec3, reach: f64) -> Option<f64> {
        let distance = |(centre, _): &&(Vec3, Vec<Vec3>)| (centre - p).norm_squared();
        let nearest = self
            .panels
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let (_, ways) = nearest.filter(|(centre, _)| (centre - p).norm() <= reach)?;
        let cosine = ways
            .iter()
            .map(|w| w.dot(&tangent).abs())
            .fold(0.0, f64::max);
        Some(cosine.min(1.0).acos().to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_on_the_lines_at_even_steps() {
        let lines = [vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]];
        let points = samples(&lines, 0.5);
        let expected = [[0.25, 0.0], [0.75, 0.0], [1.0, 0.25], [1.0, 0.75]];
        assert_eq!(points.len(), 4);
        for ((p, t), [x, y]) in points.iter().zip(expected) {
            assert!((p - Vec3::new(x, y, 0.0)).norm() < 1e-15 && (t.norm() - 1.0).abs() < 1e-15);
        }
        let many = vec![vec![[0.0; 3], [1e6, 0.0, 0.0]]];
        assert!(samples(&many, 1e-3).len() <= MOST_SAMPLES + 1);
    }
}
