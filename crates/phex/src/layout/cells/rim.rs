//! Cells at the boundary made even: what the boundary cuts small is dropped, and the others move to
//! their middles.
//!
//! Seeds whose cells hold less than `MIN_CELL` of a lattice cell (or of the mean panel of space)
//! are dropped, smallest first and never two neighbours in one round; then every cell at the
//! boundary grows again from its centroid (Lloyd's step, for that row alone). Inside, the lattice
//! stays as it is.

use super::voronoi::{self, Cells, UNREACHED};
use crate::layout::CellSurface;
use crate::layout::lattice::eisenstein::CELL;
use crate::layout::seeds::{CORE, Seed};
use crate::progress::Progress;
use phex_mesh::{PerVertex, Vec3, VertexId};
use std::collections::HashSet;

/// Least area of a cell at the boundary, in lattice cells.
const MIN_CELL: f64 = 0.42;
/// Least area of a panel at the boundary, in mean panels.
const MIN_PANEL: f64 = 0.35;
/// Rounds of dropping and moving.
const ROUNDS: usize = 4;

/// Seeds with the row at the boundary made even, and their cells. Seeds keep the vertices that name
/// them.
pub(crate) fn even_rim(
    fine: &CellSurface<'_>,
    seeds: &[Seed],
    progress: &dyn Progress,
) -> (Vec<Seed>, Cells) {
    let mut seeds = seeds.to_vec();
    let topology = fine.surface.topology();
    let mut grown = voronoi::grow(topology, fine.mesh, &seeds);
    if topology.is_closed() {
        return (seeds, grown);
    }
    let area = fine.surface.vertex_areas();
    for round in 0..ROUNDS {
        if progress.is_cancelled() {
            break;
        }
        let rim = rim_cells(fine, &grown, &area, seeds.len());
        let dropped = too_small(fine, &grown, &rim, &area, seeds.len());
        let before = seeds.len();
        for cell in rim.iter().filter(|c| c.images == 1) {
            seeds[cell.label].core = core(fine, cell);
        }
        let number = without(before, &dropped);
        let mut kept = number.iter().map(Option::is_some);
        seeds.retain(|_| kept.next().unwrap_or(true));
        let changed = rim.iter().map(|c| c.label);
        grown = voronoi::regrow(topology, fine.mesh, &seeds, &grown, changed, &number);
        if seeds.len() == before && round + 1 >= ROUNDS / 2 {
            break;
        }
    }
    (seeds, grown)
}

/// New number of each of `count` cells, `None` for those that are dropped.
fn without(count: usize, dropped: &HashSet<usize>) -> Vec<Option<u32>> {
    let mut next = 0..;
    let kept = (0..count).map(|l| !dropped.contains(&l));
    kept.map(|kept| if kept { next.next() } else { None })
        .collect()
}

/// A cell that touches the boundary.
struct RimCell {
    label: usize,
    members: Vec<VertexId>,
    /// Images of it in its place, itself one of them.
    images: u32,
    /// Area in lattice cells.
    cells: f64,
    /// Area in model units.
    area: f64,
    centroid: Vec3,
}

fn rim_cells(
    fine: &CellSurface<'_>,
    grown: &Cells,
    area: &PerVertex<f64>,
    count: usize,
) -> Vec<RimCell> {
    let topology = fine.surface.topology();
    let mut members: Vec<Vec<VertexId>> = vec![Vec::new(); count];
    let mut at_rim = vec![false; count];
    let reached = || grown.label.enumerate().filter(|(_, l)| **l != UNREACHED);
    for (_, &l) in reached().filter(|(v, _)| topology.is_boundary_vertex(*v)) {
        at_rim[l as usize] = true;
    }
    for (v, &l) in reached().filter(|(_, l)| at_rim[**l as usize]) {
        members[l as usize].push(v);
    }
    let cells = members.into_iter().enumerate();
    let cells = cells.filter(|(l, _)| at_rim[*l]);
    cells
        .map(|(label, members)| {
            let mass: f64 = members.iter().map(|&v| fine.mesh.mass[v]).sum();
            let images = members.iter().map(|v| fine.mesh.multiplicity[*v]);
            let images = images.max().unwrap_or(1);
            let sum = |v: &VertexId| fine.surface.positions()[*v] * fine.mesh.mass[*v];
            RimCell {
                label,
                images,
                cells: f64::from(images) * mass / CELL,
                area: f64::from(images) * members.iter().map(|&v| area[v]).sum::<f64>(),
                centroid: members.iter().map(sum).sum::<Vec3>() / mass.max(f64::MIN_POSITIVE),
                members,
            }
        })
        .collect()
}

/// Labels to drop: too small, and no neighbour of one that is dropped already.
fn too_small(
    fine: &CellSurface<'_>,
    grown: &Cells,
    rim: &[RimCell],
    area: &PerVertex<f64>,
    count: usize,
) -> HashSet<usize> {
    let mean = area.iter().sum::<f64>() / count as f64;
    let size = |c: &RimCell| (c.cells / MIN_CELL).min(c.area / (MIN_PANEL * mean));
    let mut small: Vec<&RimCell> = rim.iter().filter(|c| size(c) < 1.0).collect();
    small.sort_by(|a, b| size(a).total_cmp(&size(b)).then(a.label.cmp(&b.label)));
    let (mut dropped, mut kept) = (HashSet::new(), HashSet::new());
    for cell in small {
        // The last seed of all stays, and so does whoever inherits a neighbour.
        if kept.contains(&cell.label) || dropped.len() + 1 >= count {
            continue;
        }
        dropped.insert(cell.label);
        let around = cell
            .members
            .iter()
            .flat_map(|&v| fine.surface.topology().neighbours(v));
        kept.extend(around.map(|w| grown.label[w] as usize));
    }
    dropped
}

/// Vertices of a cell round its centroid, with their distances.
fn core(fine: &CellSurface<'_>, cell: &RimCell) -> Vec<(VertexId, f64)> {
    let distance = |v: &VertexId| {
        let d = fine.surface.positions()[*v] - cell.centroid;
        d.dot(&(fine.metric[*v] * d)).sqrt()
    };
    let all = cell.members.iter().map(|v| (*v, distance(v)));
    let nearest = all.clone().map(|c| c.1).fold(f64::INFINITY, f64::min);
    all.filter(|c| c.1 <= CORE.max(nearest)).collect()
}
