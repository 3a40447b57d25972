//! A layout that has changed here and there, optimised there alone.
//!
//! Vertices of which the panels are those of an earlier layout keep the places that the optimiser had found for them. Around panels
//! with others some rings go all the way from the start, everything else at rest.

use super::areas;
use super::options::{OptimiseError, OptimiseOptions, PathKind, StartKind};
use super::panels::{Panels, Shape, point};
use super::parts::with_neighbours;
use super::path::Path;
use super::run::{Reached, Run, Way};
use super::solvers::Solvers;
use super::start::Start;
use super::{Optimised, Reference, Stage, Target, better, check_layout, check_mesh};
use crate::layout::Layout;
use crate::progress::Progress;
use phex_mesh::{FaceId, Vec3, VertexId};
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Share of the panels above which all of them are optimised.
const MOST: f64 = 0.3;
/// Distance from a panel's plane, in mean edges, up to which vertices with known places are planar.
const PLANAR: f64 = 1e-12;

/// The seeds of the panels at a vertex; at the boundary, where two panels may meet twice, its place, too.
type Name = (Vec<VertexId>, Option<[u64; 3]>);

/// Places that the optimiser has found for the vertices of layouts, by the panels around them.
#[derive(Clone, Debug, Default)]
pub struct Known {
    places: BTreeMap<Name, Vec3>,
}

impl Known {
    /// The results for a layout.
    pub fn of(layout: &Layout, places: &[Vec3]) -> Self {
        let mut known = BTreeMap::new();
        let mut doubtful = BTreeSet::new();
        for (name, place) in names(layout).into_iter().zip(places) {
            if known.insert(name.clone(), *place).is_some() {
                doubtful.insert(name);
            }
        }
        known.retain(|name, _| !doubtful.contains(name));
        Self { places: known }
    }

    /// The vertices of both whose places are where `others` tells, or elsewhere those of `self`.
    pub fn with(mut self, others: &Self, is_others: impl Fn(Vec3) -> bool) -> Self {
        self.places.retain(|_, p| !is_others(*p));
        let theirs = others.places.iter().filter(|(_, p)| is_others(**p));
        self.places
            .extend(theirs.map(|(name, p)| (name.clone(), *p)));
        self
    }

    fn places_in(&self, layout: &Layout) -> Vec<Option<Vec3>> {
        let names = names(layout);
        let mut seen = HashSet::new();
        let doubtful: HashSet<&Name> = names.iter().filter(|n| !seen.insert(*n)).collect();
        let place = |name: &Name| match doubtful.contains(name) {
            true => None,
            false => self.places.get(name).copied(),
        };
        names.iter().map(place).collect()
    }
}

/// A layout that was optimised in part.
pub struct Again {
    /// The result.
    pub result: Optimised,
    /// Panels of groups that did not become planar.
    pub unsettled: Vec<FaceId>,
}

/// Optimises a layout around what has no known places. `None` if that is too much of it: then the whole has to be optimised.
///
/// # Errors
/// As [`optimise`](super::optimise).
pub fn optimise_again(
    layout: &Layout,
    known: &Known,
    target: &dyn Target,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Again>, OptimiseError> {
    options.check()?;
    check_mesh(&layout.mesh)?;
    check_layout(layout)?;
    let known = known.places_in(layout);
    let side = Some(layout.face_normal.as_slice().to_vec());
    let kinds = &layout.vertex_kind;
    let mut stage = Stage::new(
        &layout.mesh,
        Reference::Surface(target),
        side,
        kinds,
        options,
    );
    let changed = faces_to_settle(&stage.panels, &known);
    if changed.len() as f64 > MOST * stage.panels.n_faces() as f64 {
        return Ok(None);
    }
    let cancelled = || progress.is_cancelled();
    let place = |(v, known): (VertexId, &Option<Vec3>)| known.unwrap_or(layout.mesh.position(v));
    let places = layout.mesh.topology().vertices().zip(&known).map(place);
    let panels = &stage.panels;
    let around = with_neighbours(panels, &changed);
    let mut free = vec![false; panels.n_vertices()];
    let of_face = |f: &u32| panels.vertices(*f as usize).iter();
    (around.iter().flat_map(of_face)).for_each(|v| free[*v as usize] = true);
    let smoothing = stage.smoothing(layout, target, options);
    let start = smoothing.from(places.collect(), |v| free[v], cancelled);
    stage.areas = areas::of_layout(layout, &stage.panels, &start.x, options.evenness);
    let mut solvers = Solvers::new(&stage.panels)?;
    let (run, unsettled) = stage.run_around(&mut solvers, &start, changed, options, progress)?;
    Ok(Some(Again {
        result: better(&layout.mesh, run, None),
        unsettled: unsettled.into_iter().map(FaceId::new).collect(),
    }))
}

fn names(layout: &Layout) -> Vec<Name> {
    let topology = layout.mesh.topology();
    let name = |v: VertexId| {
        let faces = topology.outgoing(v).map(|h| topology.face(h));
        let mut seeds: Vec<VertexId> = faces.map(|f| layout.face_seed[f]).collect();
        seeds.sort_unstable();
        let p = layout.mesh.position(v);
        let place = topology.is_boundary_vertex(v);
        (seeds, place.then(|| [p.x, p.y, p.z].map(f64::to_bits)))
    };
    topology.vertices().map(name).collect()
}

/// Faces with a vertex that has no place yet, and those that known places leave out of plane: where results of two layouts meet.
fn faces_to_settle(panels: &Panels, known: &[Option<Vec3>]) -> Vec<u32> {
    let places = known.iter().map(|p| p.unwrap_or_else(Vec3::zeros));
    let x: Vec<f64> = places.flat_map(|p| [p.x, p.y, p.z]).collect();
    let shape = Shape::at(panels, &x);
    let is_new = |f: usize| {
        let mut vertices = panels.vertices(f).iter();
        vertices.any(|v| known[*v as usize].is_none())
    };
    let faces = 0..panels.n_faces();
    let settled: Vec<usize> = faces.clone().filter(|f| !is_new(*f)).collect();
    let lengths = settled.iter().flat_map(|&f| side_lengths(panels, f, &x));
    let (sum, count) = lengths.fold((0.0, 0), |(sum, n), l| (sum + l, n + 1));
    let limit = PLANAR * sum / f64::from(count.max(1));
    let bent = |f: usize| {
        let corners = shape.face(panels, f).iter();
        corners.map(|c| c.height.abs()).fold(0.0, f64::max) > limit
    };
    let open = faces.filter(|f| is_new(*f) || bent(*f));
    open.map(|f| f as u32).collect()
}

/// Lengths of a face's sides.
fn side_lengths(panels: &Panels, f: usize, x: &[f64]) -> Vec<f64> {
    let ring: Vec<Vec3> = (panels.vertices(f).iter())
        .map(|&v| point(x, v as usize))
        .collect();
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(p, q)| (q - p).norm()).collect()
}

impl Stage<'_> {
    /// Optimises what is around some faces; besides the faces of groups that do not become planar.
    fn run_around(
        &self,
        solvers: &mut Solvers,
        start: &Start,
        faces: Vec<u32>,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<(Run, Vec<u32>), OptimiseError> {
        let setting = self.setting(&start.x);
        let mut path = Path::new(&setting, solvers, &start.x, options, progress)?;
        let mut x = start.x.clone();
        let unsettled = path.settle_around(faces, &mut x)?;
        let mut best = Reached::at(&setting, x);
        if !path.is_over() {
            best = path.retry(best)?;
        }
        let way = Way {
            kind: StartKind::SmoothedCells,
            path: PathKind::Feasible,
            in_parts: path.in_parts,
            outcome: path.outcome,
        };
        let run = self.conclude(start.n_bad, best, way, options);
        Ok((run, unsettled))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::optimise;
    use crate::optimise::tests::fixtures::{Shape, brick_wall, layout, turn_edge};
    use crate::progress::Silent;
    use phex_mesh::{FaceId, HexMesh, PerFace};

    const SHAPE: Shape = Shape::Wave;

    /// A layout whose panels have seeds of their own, by their numbers.
    fn seeded(mesh: HexMesh) -> Layout {
        let mut layout = layout(mesh, &SHAPE);
        let seed = |f: FaceId| VertexId::new(f.index() as u32);
        layout.face_seed = PerFace::from_fn(layout.mesh.topology().n_faces(), seed);
        layout
    }

    #[test]
    fn only_what_is_around_a_change_moves() {
        let options = OptimiseOptions::default();
        let before = seeded(brick_wall(SHAPE, 73, 36));
        let first = optimise(&before, &SHAPE, &options, &Silent).unwrap();
        assert!(first.is_sound());
        let known = Known::of(&before, first.mesh.positions.as_slice());
        let again = |layout: &Layout, known: &Known| {
            let again = optimise_again(layout, known, &SHAPE, &options, &Silent).unwrap();
            again.expect("little has changed")
        };
        let same = again(&before, &known);
        assert_eq!(same.result.mesh.positions, first.mesh.positions);

        let topology = before.mesh.topology();
        // Where K > 0.
        let hill = Vec3::new(1.2, 1.2, SHAPE.height(1.2, 1.2));
        let middle = topology.edges().find(|e| {
            let [a, b] = topology.edge_vertices(*e).map(|v| before.mesh.position(v));
            (a - hill).norm().max((b - hill).norm()) < 0.2
        });
        let [a, b] = topology.edge_vertices(middle.unwrap());
        let after = seeded(turn_edge(&before.mesh, a.index() as u32, b.index() as u32));
        let turned = again(&after, &known);
        assert!(turned.unsettled.is_empty());
        let turned = turned.result;
        assert!(turned.is_sound(), "{:?}", turned.offenders);
        let at = before.mesh.position(a);
        let (mut moved, mut at_rest) = (0, 0);
        for (v, p) in first.mesh.positions.enumerate() {
            let is_moved = turned.mesh.position(v) != *p;
            assert!(!is_moved || (p - at).norm() < 1.2, "{p}");
            moved += usize::from(is_moved);
            at_rest += usize::from(!is_moved);
        }
        assert!(moved > 20 && at_rest > moved, "{moved} {at_rest}");
    }

    #[test]
    fn two_results_are_taken_each_in_its_region() {
        let layout = seeded(brick_wall(SHAPE, 25, 12));
        let first = layout.mesh.positions.as_slice().to_vec();
        let second: Vec<Vec3> = first.iter().map(|p| p + Vec3::y()).collect();
        let known = |places: &[Vec3]| Known::of(&layout, places);
        let both = known(&first).with(&known(&second), |p| p.x > 1.0);
        let mut counts = [0, 0];
        for (found, p) in both.places_in(&layout).into_iter().zip(&first) {
            let shift = if p.x > 1.0 { Vec3::y() } else { Vec3::zeros() };
            if let Some(found) = found {
                assert_eq!(found, p + shift);
                counts[usize::from(p.x > 1.0)] += 1;
            }
        }
        assert!(counts[0] > 50 && counts[1] > 50, "{counts:?}");
    }

    #[test]
    fn too_much_that_is_new_is_left_to_the_whole() {
        let options = OptimiseOptions::default();
        let wall = seeded(brick_wall(SHAPE, 25, 12));
        let mut other = wall.clone();
        other.face_seed = wall
            .face_seed
            .map(|s| VertexId::new(s.index() as u32 + 1000));
        let known = Known::of(&other, wall.mesh.positions.as_slice());
        let again = optimise_again(&wall, &known, &SHAPE, &options, &Silent).unwrap();
        assert!(again.is_none());
    }
}
