//! What is found on one face.

use phex_mesh::FaceId;

/// What a panel costs that has half the room that is wanted.
const MUCH: f64 = 0.25;

/// By how much a face is outside limits, each over its limit, 0 where it is within.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Findings {
    /// Violations that make it no panel, or not planar.
    pub invalid: f64,
    /// A panel that passes through it, or it through that one.
    pub crossed: Option<FaceId>,
    /// Folds against its neighbours.
    pub folded: f64,
    /// Clearance or an edge below the limit.
    pub narrow: f64,
    /// Distance to the surface.
    pub far: f64,
    /// Distance of the surface to it.
    pub bare: f64,
    /// Distance between the boundaries.
    pub rim: f64,
    /// Amounts of panels, edges, corners and joints, summed.
    pub unfit: f64,
    /// Whether a smaller panel would fit.
    pub too_large: bool,
    /// Distance to the surface, in limits.
    pub off: f64,
    /// What a tight panel costs.
    pub tight: f64,
    /// What a sharp corner costs, where that counts.
    pub sharp: f64,
    /// What a long edge costs, or a large area at the boundary, where that counts.
    pub large: f64,
    /// What a small panel at the boundary costs.
    pub small: f64,
    /// What a distance between the boundaries costs that is seen beside panels of that size.
    pub ragged: f64,
    /// Square of the logarithm of its area over the area that it is to have.
    pub uneven: f64,
    /// Whether it is an inner panel without six corners.
    pub irregular: bool,
}

impl Findings {
    /// All excesses over limits.
    pub fn outside(&self) -> f64 {
        self.folded + self.narrow + self.far + self.bare + self.rim + self.unfit
    }

    /// How bad it is, to compare faces: what is invalid counts before what is outside, and that
    /// before what is not liked.
    pub(super) fn amount(&self) -> f64 {
        1e3 * self.invalid + self.outside() + 1e-3 * self.disliked()
    }

    /// What is against it that is allowed, without irregular and uneven panels.
    pub(super) fn disliked(&self) -> f64 {
        self.tight + self.misshapen() + self.small + self.ragged
    }

    /// What is against its shape.
    pub fn misshapen(&self) -> f64 {
        self.sharp + self.large
    }

    /// Whether smaller panels would help.
    pub(super) fn needs_more(&self) -> bool {
        self.crossed.is_some() || self.bare > 0.0 || self.far > 0.0 || self.too_large
    }

    /// Whether it is no panel, not planar, folded against another, or too narrow.
    pub(crate) fn is_broken(&self) -> bool {
        self.invalid + self.folded + self.narrow > 0.0
    }

    /// Whether nothing is invalid or outside limits.
    pub fn is_within(&self) -> bool {
        self.invalid + self.outside() == 0.0
    }

    /// Whether nothing but a little room is lacking, or a better shape.
    pub(super) fn is_slight(&self) -> bool {
        self.is_within() && self.small + self.ragged == 0.0 && self.tight.max(self.sharp) < MUCH
    }

    /// Whether something is to be done there.
    pub fn is_defect(&self) -> bool {
        self.invalid + self.outside() + self.disliked() > 0.0
    }
}
