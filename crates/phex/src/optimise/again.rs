//! A layout that has changed here and there, optimised there alone.
//!
//! Vertices of which the panels are those of an earlier layout keep the places that the optimiser had found for them. Around panels
//! with others some rings go all the way from the start, everything else at rest.

use super::options::{OptimiseError, OptimiseOptions, PathKind, StartKind};
use super::parts::with_neighbours;
use super::path::Path;
use super::run::{Reached, Run, Way};
use super::solvers::Solvers;
use super::start::Start;
use super::{Optimised, Reference, Stage, Target, better, check_layout, check_mesh};
use crate::layout::Layout;
use crate::progress::Progress;
use phex_mesh::{Vec3, VertexId};
use std::collections::{HashMap, HashSet};

/// Share of the panels above which all of them are optimised.
const MOST: f64 = 0.3;

/// Optimises a layout around what is not as in an earlier one, of which `places` are the results. `None` if that is too much of it, or if panels do not become
/// planar that way: then the whole has to be optimised.
///
/// # Errors
/// As [`optimise`](super::optimise).
pub fn optimise_again(
    layout: &Layout,
    earlier: (&Layout, &[Vec3]),
    target: &dyn Target,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, OptimiseError> {
    options.check()?;
    check_mesh(&layout.mesh)?;
    check_layout(layout)?;
    let known = known_places(layout, earlier);
    let changed = faces_with_others(layout, &known);
    let count = layout.mesh.topology().n_faces();
    if changed.len() as f64 > MOST * count as f64 {
        return Ok(None);
    }
    let side = Some(layout.face_normal.as_slice().to_vec());
    let kinds = &layout.vertex_kind;
    let stage = Stage::new(
        &layout.mesh,
        Reference::Surface(target),
        side,
        kinds,
        options,
    );
    let cancelled = || progress.is_cancelled();
    let panels = &stage.panels;
    let place = |(v, known): (VertexId, &Option<Vec3>)| known.unwrap_or(layout.mesh.position(v));
    let places = layout.mesh.topology().vertices().zip(&known).map(place);
    let around = with_neighbours(panels, &changed);
    let mut free = vec![false; panels.n_vertices()];
    let of_face = |f: &u32| panels.vertices(*f as usize).iter();
    (around.iter().flat_map(of_face)).for_each(|v| free[*v as usize] = true);
    let smoothing = stage.smoothing(layout, target, options);
    let start = smoothing.from(places.collect(), |v| free[v], cancelled);
    let mut solvers = Solvers::new(panels)?;
    let run = stage.run_around(&mut solvers, &start, changed, options, progress)?;
    Ok(run.map(|run| better(&layout.mesh, run, None)))
}

/// Seeds of the panels at each vertex; at the boundary, where two panels may meet twice, its place, too.
fn names(layout: &Layout) -> Vec<(Vec<VertexId>, Option<[u64; 3]>)> {
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

/// The earlier place of each vertex that was there already.
fn known_places(layout: &Layout, (earlier, places): (&Layout, &[Vec3])) -> Vec<Option<Vec3>> {
    let mut places_of = HashMap::new();
    let mut doubtful = HashSet::new();
    for (name, place) in names(earlier).into_iter().zip(places) {
        if places_of.insert(name.clone(), *place).is_some() {
            doubtful.insert(name);
        }
    }
    let now = names(layout);
    let mut seen = HashSet::new();
    doubtful.extend(now.iter().filter(|n| !seen.insert(*n)).cloned());
    let known = |name| match doubtful.contains(name) {
        true => None,
        false => places_of.get(name).copied(),
    };
    now.iter().map(known).collect()
}

/// Faces with a vertex that has no place yet.
fn faces_with_others(layout: &Layout, known: &[Option<Vec3>]) -> Vec<u32> {
    let topology = layout.mesh.topology();
    let other = |v: &VertexId| known[v.index()].is_none();
    let faces = topology.faces().enumerate();
    let changed = faces.filter(|(_, f)| topology.face_vertices(*f).iter().any(other));
    changed.map(|(k, _)| k as u32).collect()
}

impl Stage<'_> {
    /// Optimises what is around some faces; `None` if something does not become planar.
    fn run_around(
        &self,
        solvers: &mut Solvers,
        start: &Start,
        faces: Vec<u32>,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Option<Run>, OptimiseError> {
        let setting = self.setting(&start.x);
        let mut path = Path::new(&setting, solvers, &start.x, options, progress)?;
        let mut x = start.x.clone();
        if !path.settle_around(faces, &mut x)? {
            return Ok(None);
        }
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
        Ok(Some(self.conclude(start.n_bad, best, way, options)))
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
        let earlier = (&before, first.mesh.positions.as_slice());
        let same = optimise_again(&before, earlier, &SHAPE, &options, &Silent).unwrap();
        assert_eq!(same.unwrap().mesh.positions, first.mesh.positions);

        let topology = before.mesh.topology();
        // Where K > 0.
        let hill = Vec3::new(1.2, 1.2, SHAPE.height(1.2, 1.2));
        let middle = topology.edges().find(|e| {
            let [a, b] = topology.edge_vertices(*e).map(|v| before.mesh.position(v));
            (a - hill).norm().max((b - hill).norm()) < 0.2
        });
        let [a, b] = topology.edge_vertices(middle.unwrap());
        let after = seeded(turn_edge(&before.mesh, a.index() as u32, b.index() as u32));
        let again = optimise_again(&after, earlier, &SHAPE, &options, &Silent).unwrap();
        let again = again.unwrap();
        assert!(again.is_sound(), "{:?}", again.offenders);
        let at = before.mesh.position(a);
        let (mut moved, mut at_rest) = (0, 0);
        for (v, p) in first.mesh.positions.enumerate() {
            let is_moved = again.mesh.position(v) != *p;
            assert!(!is_moved || (p - at).norm() < 1.2, "{p}");
            moved += usize::from(is_moved);
            at_rest += usize::from(!is_moved);
        }
        assert!(moved > 20 && at_rest > moved, "{moved} {at_rest}");
    }

    #[test]
    fn too_much_that_is_new_is_left_to_the_whole() {
        let options = OptimiseOptions::default();
        let wall = seeded(brick_wall(SHAPE, 25, 12));
        let mut other = wall.clone();
        other.face_seed = wall
            .face_seed
            .map(|s| VertexId::new(s.index() as u32 + 1000));
        let earlier = (&other, wall.mesh.positions.as_slice());
        let again = optimise_again(&wall, earlier, &SHAPE, &options, &Silent).unwrap();
        assert!(again.is_none());
    }
}
