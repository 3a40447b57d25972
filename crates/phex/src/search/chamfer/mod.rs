//! Chamfers: a crease over which panels fold by more than a right angle is cut off, so that they
//! turn in two steps.
//!
//! Where a body is thinner than its panels, or has an edge like the sides of a blade, the edges of
//! a mesh over which panels fold lie one behind the other, as *runs*. A strip as steep to the one
//! side as to the other takes the place of a run: its two sides lie in the panels beside the run,
//! which stay as planar as before, and edges across divide it into a row of panels of its own, of
//! six corners each but for the last. Where a run bends, as at the corners of the base of a
//! pyramid, a short panel of the strip keeps it from cutting the bend short; where three runs meet,
//! as at a corner of a sharp body, their strips meet in a vertex. Interior vertices still have
//! three faces. The optimiser then makes panels planar.

mod corners;
mod strip;

#[cfg(test)]
mod tests;

use super::draft::{DirectedEdge, Draft, Incidence};
use phex_mesh::{FlatFace, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;
use strip::{ChamferStrip, CreaseEdge};

/// Width of a strip on either side of a run, as a share of the lower panel's height above it.
const WIDTH: f64 = 0.3;
/// Share of an edge that meets a run, after which a strip, or what is cut off a corner, ends at the
/// farthest.
const REACH: f64 = 0.45;
/// Runs that are cut off in one patch at the most.
const RUNS: usize = 64;

/// The panels with all folds cut off that panels of `core` have, or any panel of the patch if it is
/// `None`, by strips whose depth is at most `deepest`; the sharpest first. `None` where there is
/// none.
pub(super) fn chamfered(draft: &Draft, core: Option<&[usize]>, deepest: f64) -> Option<Draft> {
    let old = draft.faces.len();
    let counts = |f: usize| core.is_none_or(|core| core.contains(&f));
    let (mut now, corners) = draft.without_corners(&counts, deepest);
    let strips = now.faces.len();
    let mut tried: BTreeSet<DirectedEdge> = BTreeSet::new();
    for _ in 0..RUNS {
        let mut folds = now.folds();
        folds.retain(|fold| {
            fold.faces.iter().all(|f| *f < old)
                && fold.faces.iter().any(|f| counts(*f))
                && !tried.contains(&fold.side)
        });
        let sharpest =
            (folds.iter()).max_by(|a, b| a.angle.total_cmp(&b.angle).then(b.side.cmp(&a.side)));
        let Some(fold) = sharpest else { break };
        let run = FoldRun::through(&now, fold.side, &folds);
        tried.extend(run.edges().map(|[a, b]| [a.min(b), a.max(b)]));
        if let Some(next) = now.cut_off(run, deepest) {
            now = next;
        }
    }
    (now.faces.len() > strips).then(|| {
        for corner in corners {
            now.join_strips(&corner, strips);
        }
        now
    })
}

/// Two panels that turn by more than a right angle over an edge.
struct BladeEdge {
    side: DirectedEdge,
    faces: [usize; 2],
    angle: f64,
}

/// Edges one behind the other over which panels fold.
struct FoldRun {
    vertices: Vec<u32>,
    /// Whether the last vertex comes before the first one.
    is_closed: bool,
}

impl FoldRun {
    /// The longest run through a fold: it ends where more than two folds meet, or one does.
    fn through(draft: &Draft, side: DirectedEdge, folds: &[BladeEdge]) -> Self {
        let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for [a, b] in folds.iter().map(|fold| fold.side) {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        }
        let incidence = draft.incidence();
        let inside = |v: u32| !draft.on_boundary[v as usize] && incidence.faces_at(v).count() == 3;
        let after = |from: u32, v: u32| match beside[&v][..] {
            [a, b] if inside(v) => Some(if a == from { b } else { a }),
            _ => None,
        };
        let mut vertices = side.to_vec();
        for _ in 0..2 {
            while let Some(next) = after(vertices[vertices.len() - 2], vertices[vertices.len() - 1])
            {
                if next == vertices[0] {
                    return Self {
                        vertices,
                        is_closed: true,
                    };
                }
                vertices.push(next);
            }
            vertices.reverse();
        }
        Self {
            vertices,
            is_closed: false,
        }
    }

    fn edges(&self) -> impl Iterator<Item = DirectedEdge> {
        let n = self.vertices.len();
        let count = if self.is_closed { n } else { n - 1 };
        (0..count).map(move |k| [self.vertices[k], self.vertices[(k + 1) % n]])
    }
}

impl Draft {
    fn folds(&self) -> Vec<BladeEdge> {
        let normal = |face: &Vec<u32>| match face.is_empty() {
            true => Vec3::zeros(),
            false => self.flat(face).normal(),
        };
        let normals: Vec<Vec3> = self.faces.iter().map(normal).collect();
        let incidence = self.incidence();
        let sides = incidence.sides().filter(|[a, b]| a < b);
        let fold = |side: DirectedEdge| {
            let faces = incidence.beside(side)?;
            let angle = normals[faces[0]].angle(&normals[faces[1]]);
            let open = faces.iter().all(|f| self.open[*f]);
            (open && angle > FRAC_PI_2).then_some(BladeEdge { side, faces, angle })
        };
        sides.filter_map(fold).collect()
    }

    fn flat(&self, face: &[u32]) -> FlatFace {
        let corners: Vec<Vec3> = face.iter().map(|v| self.places[*v as usize]).collect();
        FlatFace::new(&corners)
    }

    fn place(&self, v: u32) -> Vec3 {
        self.places[v as usize]
    }

    /// The panels with a run cut off, or what of it can be; `None` if that is nothing.
    fn cut_off(&self, mut run: FoldRun, deepest: f64) -> Option<Self> {
        let incidence = self.incidence();
        if !run.is_closed {
            while !self.can_end(&incidence, [run.vertices[0], run.vertices[1]]) {
                run.vertices.remove(0);
                (run.vertices.len() > 1).then_some(())?;
            }
            while let [.., before, last] = run.vertices[..]
                && !self.can_end(&incidence, [last, before])
            {
                run.vertices.pop();
            }
            (run.vertices.len() > 1).then_some(())?;
        }
        let edges: Vec<CreaseEdge> = (run.edges())
            .map(|side| self.run_edge(&incidence, side, deepest))
            .collect::<Option<_>>()?;
        ChamferStrip::new(self, run, edges)?.laid()
    }

    /// Whether a strip can end at the first vertex of a side: in one panel that may change, or at
    /// the boundary.
    fn can_end(&self, incidence: &Incidence, side: DirectedEdge) -> bool {
        let Some(faces) = incidence.beside(side) else {
            return false;
        };
        let others = || incidence.faces_at(side[0]).filter(|f| !faces.contains(f));
        others().count() < 2 && others().all(|f| self.open[f])
    }

    fn run_edge(
        &self,
        incidence: &Incidence,
        side: DirectedEdge,
        deepest: f64,
    ) -> Option<CreaseEdge> {
        let faces = incidence.beside(side)?;
        let [a, b] = side.map(|v| self.place(v));
        let along = (b - a).try_normalize(0.0)?;
        let normals = faces.map(|f| self.flat(&self.faces[f]).normal());
        let inwards = [normals[0].cross(&along), along.cross(&normals[1])];
        let height = |k: usize| {
            let corners = self.faces[faces[k]].iter();
            let heights = corners.map(|v| (self.place(*v) - a).dot(&inwards[k]));
            heights.fold(0.0, f64::max)
        };
        let half_turn = 0.5 * normals[0].angle(&normals[1]);
        let width = (WIDTH * height(0).min(height(1))).min(deepest / half_turn.sin());
        (width > 0.0).then_some(CreaseEdge {
            faces,
            inwards,
            width,
        })
    }
}
