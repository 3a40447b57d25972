//! Lattices from several random starts, of which the most regular is kept: where dislocations fall is chance, and panels that no optimiser has seen yet cost
//! little.

use super::field::{COUNT_TOLERANCE, Field, FineSurface};
use super::portfolio::irregular_panels;
use super::{Clock, MeshOptions, PipelineError};
use crate::ground::Ground;
use crate::layout::{self, Layout, LayoutError, LayoutOptions, Placed};
use rayon::prelude::*;

/// Share of panels that are irregular without need, up to which one lattice is enough.
const FEW: f64 = 0.01;
/// Draws number themselves in the upper half of the seed, so that seeds one after the other share none.
const DRAW_BITS: u32 = 32;

/// Seeds, and the panels that grow from them.
pub(super) struct Drawn {
    pub placed: Placed,
    pub layout: Layout,
}

impl Drawn {
    fn new(placed: Placed, fine: &FineSurface) -> Result<Self, LayoutError> {
        let layout = fine.calm_panels(&placed.seeds)?;
        Ok(Self { placed, layout })
    }

    /// Irregular panels first, then the distortion of the lattice.
    fn cost(&self) -> (usize, f64) {
        let irregular = irregular_panels(&self.layout.mesh);
        (irregular, self.placed.statistics.distortion_p95)
    }

    fn is_regular(&self) -> bool {
        let panels = self.layout.mesh.topology().n_faces();
        self.cost().0 as f64 <= FEW * panels as f64
    }

    /// How far the number of panels is from what is asked for.
    fn miscount(&self, panels: usize) -> f64 {
        let count = self.placed.seeds.len().max(1);
        (count as f64 / panels as f64).ln().abs()
    }
}

/// The most regular of a few lattices with the field's directions, the field's own the first.
pub(super) fn most_regular(
    ground: &Ground,
    field: &Field,
    fine: &FineSurface,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<Drawn, PipelineError> {
    let drawn = clock.stage("layout", || {
        let first = Drawn::new(field.placed.clone(), fine)?;
        if first.is_regular() {
            return Ok(first);
        }
        let most = first.miscount(ground.panels).max(COUNT_TOLERANCE);
        let topology = ground.smooth.levels[field.level].topology();
        let again = |&k: &u64| {
            let seed = options.layout.seed.wrapping_add(k << DRAW_BITS);
            let options = LayoutOptions {
                seed,
                ..options.layout.clone()
            };
            let placed = layout::place_seeds(topology, &field.directions, &options)?;
            Drawn::new(placed, fine)
        };
        let numbers: Vec<u64> = (1..options.draws as u64).collect();
        let others: Vec<_> = numbers.par_iter().with_max_len(1).map(again).collect();
        // A start from which no panels come is no better than the first.
        let others = others.into_iter().flatten();
        let others = others.filter(|d| d.miscount(ground.panels) <= most);
        let better = |best: Drawn, other: Drawn| match other.cost() < best.cost() {
            true => other,
            false => best,
        };
        Ok::<_, LayoutError>(others.fold(first, better))
    })??;
    Ok(drawn)
}

#[cfg(test)]
mod tests {
    use super::super::field::direction_options;
    use super::*;
    use crate::progress::Silent;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    /// Costs of the field's own lattice and of what is drawn.
    fn costs(name: &str, panels: usize, draws: usize) -> [(usize, f64); 2] {
        let triangulation = TriangulationOptions {
            triangles: 4000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &triangulation).unwrap();
        let options = MeshOptions {
            draws,
            ..Default::default()
        };
        let mut clock = Clock::new(&Silent);
        let ground = Ground::new(&surface, panels, &options);
        let settings = direction_options(&options, 2.0);
        let level = ground.field_level(&options);
        let field = Field::new(&ground, level, &options, &settings, &mut clock).unwrap();
        let fine = FineSurface::new(&ground, &field);
        let first = Drawn::new(field.placed.clone(), &fine).unwrap();
        let drawn = most_regular(&ground, &field, &fine, &options, &mut clock).unwrap();
        [first.cost(), drawn.cost()]
    }

    #[test]
    fn more_draws_are_more_regular() {
        let [first, same] = costs("wave", 500, 1);
        assert_eq!(first, same);
        let [first, drawn] = costs("wave", 500, 6);
        assert!(drawn.0 < first.0, "{first:?} {drawn:?}");
        let [torus, drawn] = costs("torus", 300, 6);
        assert_eq!((torus.0, torus), (0, drawn));
    }
}
