//! One check of all options, before anything is computed: every number finite and in its range,
//! every point where it can be.

use super::{Candidate, MeshOptions};
use crate::classical::duality::DualOptions;
use crate::directions::guides::Guides;
use crate::directions::size::SizeOptions;
use crate::directions::{DirectionOptions, network::NetworkOptions};
use crate::layout::LayoutOptions;
use crate::layout::brick_wall::BrickWallOptions;
use crate::optimise::Steering;
use crate::ranges::{BadOption, below, counts, not_negative, positive, within};
use crate::smooth_surface::TargetOptions;
use phex_mesh::LARGEST_COORDINATE;
use std::f64::consts::TAU;

/// Largest ratio of lengths of panels, and largest density of vertices per panel: beyond, memory
/// ends.
const LARGEST_RATIO: f64 = 100.0;
/// Levels of `dual-subdivision` at the most: four panels are made of one on each.
const MOST_LEVELS: f64 = 5.0;

impl MeshOptions {
    /// Refuses values that have no meaning. The size of the panels is judged with the surface.
    ///
    /// # Errors
    /// The first option that is not finite or outside its range, by the names of its table and
    /// itself.
    pub fn check(&self) -> Result<(), BadOption> {
        let densities = [
            ("field_density", self.field_density),
            ("cell_density", self.cell_density),
        ];
        positive(&densities)?;
        within(0.0..=LARGEST_RATIO, &densities)?;
        let repeat = [("repeat_rel", self.repeat_rel.unwrap_or(1.0))];
        positive(&repeat)?;
        within(0.0..=1.0, &repeat)?;
        let sizes = self.size_field.iter().flatten();
        sizes
            .map(|&x| ("size_field", x))
            .try_for_each(|x| coordinates(&[x]))?;
        let tables = [
            ("sizes", sizes_fit(&self.sizes)),
            ("target", target_fits(&self.target)),
            ("curvature", self.curvature_fits()),
            ("directions", directions_fit(&self.directions)),
            (
                "portfolio",
                self.portfolio.iter().try_for_each(candidate_fits),
            ),
            ("layout", layout_fits(&self.layout)),
            ("brick_wall", wall_fits(&self.brick_wall)),
            ("dual", dual_fits(&self.dual)),
            ("optimise", self.optimise.check()),
            ("steering", steering_fits(&self.steering)),
        ];
        let named =
            |(table, result): (_, Result<(), BadOption>)| result.map_err(|e| e.in_table(table));
        tables.into_iter().try_for_each(named)
    }

    fn curvature_fits(&self) -> Result<(), BadOption> {
        let radius = ("radius_rel", self.curvature.radius_rel);
        positive(&[radius])?;
        within(0.0..=LARGEST_RATIO, &[radius])?;
        counts(&[("smoothing", self.curvature.smoothing)])
    }
}

fn coordinates(options: &[(&'static str, f64)]) -> Result<(), BadOption> {
    within(-LARGEST_COORDINATE..=LARGEST_COORDINATE, options)
}

fn points<'a>(
    option: &'static str,
    points: impl IntoIterator<Item = &'a [f64; 3]>,
) -> Result<(), BadOption> {
    let mut all = points.into_iter().flatten();
    all.try_for_each(|&x| coordinates(&[(option, x)]))
}

fn sizes_fit(options: &SizeOptions) -> Result<(), BadOption> {
    positive(&[("adaptive", options.adaptive.unwrap_or(1.0))])
}

fn target_fits(options: &TargetOptions) -> Result<(), BadOption> {
    counts(&[("corrections", options.corrections)])?;
    within(0.0..=1.0, &[("damping", options.damping)])?;
    within(0.0..=180.0, &[("corner_angle", options.corner_angle)])
}

fn directions_fit(options: &DirectionOptions) -> Result<(), BadOption> {
    within(1.0..=LARGEST_RATIO, &[("anisotropy", options.anisotropy)])?;
    within(-TAU..=TAU, &[("rotate", options.rotate)])?;
    positive(&[("conformal_screening", options.conformal_screening)])?;
    not_negative(&[
        ("alignment", options.alignment),
        ("conformal_limit", options.conformal_limit),
        ("boundary_alignment", options.boundary_alignment),
        ("cancel_reach", options.cancel_reach.unwrap_or_default()),
        ("saddle_alignment", options.saddle_alignment),
    ])?;
    guides_fit(&options.guides).map_err(|e| e.in_table("guides"))
}

fn guides_fit(guides: &Guides) -> Result<(), BadOption> {
    below(180.0, &[("crease", guides.crease.unwrap_or(90.0))])?;
    points("lines", guides.lines.iter().flatten())?;
    points("cones", guides.cones.iter().map(|c| &c.position))?;
    let index = |index: i32| [("cones.index", f64::from(index))];
    let mut indices = guides.cones.iter().map(|c| c.index);
    indices.try_for_each(|i| within(-6.0..=5.0, &index(i)))
}

fn candidate_fits(candidate: &Candidate) -> Result<(), BadOption> {
    within(1.0..=LARGEST_RATIO, &[("anisotropy", candidate.anisotropy)])
}

fn layout_fits(options: &LayoutOptions) -> Result<(), BadOption> {
    counts(&[("sweeps", options.sweeps)])?;
    not_negative(&[
        (
            "annihilation_length",
            options.annihilation_length.unwrap_or(0.0),
        ),
        ("max_distortion", options.max_distortion),
        ("max_pull", options.max_pull.unwrap_or(0.0)),
    ])
}

fn wall_fits(options: &BrickWallOptions) -> Result<(), BadOption> {
    let ratio = [("ratio", options.ratio.unwrap_or(1.0))];
    positive(&ratio)?;
    within(0.0..=LARGEST_RATIO, &ratio)?;
    network_fits(&options.network).map_err(|e| e.in_table("network"))
}

fn network_fits(options: &NetworkOptions) -> Result<(), BadOption> {
    not_negative(&[("alignment", options.alignment)])?;
    positive(&[("strictness", options.strictness)])
}

fn dual_fits(options: &DualOptions) -> Result<(), BadOption> {
    let quadric = options.quadric.iter().flatten();
    quadric
        .map(|&x| ("quadric", x))
        .try_for_each(|x| coordinates(&[x]))?;
    not_negative(&[("regularisation", options.regularisation)])?;
    within(1.0..=MOST_LEVELS, &[("levels", options.levels as f64)])
}

fn steering_fits(steering: &Steering) -> Result<(), BadOption> {
    points("fixed_points", &steering.fixed_points)?;
    points("curves", steering.curves.iter().flatten())?;
    points("anchors.point", steering.anchors.iter().map(|a| &a.point))?;
    let grounds = || steering.grounds.iter();
    points("grounds.point", grounds().filter_map(|g| g.point.as_ref()))?;
    points("grounds.normal", grounds().map(|g| &g.normal))?;
    grounds().try_for_each(|g| not_negative(&[("grounds.reach", g.reach.unwrap_or(0.0))]))?;
    let mut weights = steering
        .anchors
        .iter()
        .map(|a| ("anchors.weight", a.weight));
    weights.try_for_each(|weight| positive(&[weight]))
}
