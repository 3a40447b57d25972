//! What the words of the tables mean.

/// The words, as `phex terms` and `phex help terms` print them.
pub const TERMS: &str = "Words of the tables, in the order in which they appear:

anisotropy     of a lattice: how many times longer its panels may be along one
               principal direction of the surface than along the other. 1:
               panels are as long as wide. More follows the curvature closely,
               less is calmer
irregular      panels inside that are no hexagons, where hexagons would do: a
without need   closed surface like a ball needs twelve pentagons, a ring none.
               What is more comes in pairs of a pentagon and a heptagon, where
               the lattice does not fit
mean edge      the mean length of all edges: the unit of figures that do not
               depend on the size of the model
planarity      the largest distance of a corner to its panel's plane
simple         a panel's outline does not cross itself
sound          panels do not fold over, cross or cover each other, and exactly
               three meet at each vertex inside
clearance      the least distance, within a panel, of a corner to an edge that
               does not hold it: how narrow its narrowest place is
least angle    the sharpest corner of all panels
deviation      how far vertices and panel centres are from the surface; `rms`
               is their quadratic mean
back           the other way: how far points of the surface, or of its
               boundary, are from the mesh. Large where the mesh leaves
               something out
diagonal       of the bounding box of the surface: the unit of deviations in
               per cent
boundary       how far the mesh's boundary is from the surface's, and the other
               way; `covered` is the share of the surface's area that has a
               panel over it, `beyond` the share of the panels' area that
               sticks out
fold           an edge over which two panels meet at less than a right angle
indicatrix     Dupin's: the curve in which a plane near the tangent plane cuts
               the surface. Small hexagons are inscribed in it
conjugate      of two directions a, b in the surface: II(a, b) = 0. Rows of
               quadrilaterals with planar panels have them
verdict        PASS: every check holds. OUTSIDE TOLERANCE: panels are simple
               and lie side by side, and a figure, as of planarity, is outside
               its limit (exit code 3). INVALID: no panelling (exit code 5, not
               written without --keep-invalid)";

#[cfg(test)]
mod tests {
    use super::TERMS;

    #[test]
    fn lines_are_not_wrapped_again_by_a_terminal_of_80_columns() {
        for line in TERMS.lines() {
            assert!(line.chars().count() < 80, "{line}");
        }
    }
}
