//! Rows of lattice vertices and the triangles between neighbouring rows.

/// Vertices of one row: abscissa and number, by rising abscissa.
pub(super) type LatticeRow = Vec<(f64, u32)>;

/// Triangles between two rows, counter-clockwise with `lower` below `upper`. Each step advances on
/// the row whose next edge has its middle further left, which pairs the rows of an equilateral
/// lattice as they belong.
pub(super) fn stitch(lower: &LatticeRow, upper: &LatticeRow, triangles: &mut Vec<[u32; 3]>) {
    let middle = |row: &LatticeRow, i: usize| {
        row.get(i + 1)
            .map_or(f64::INFINITY, |next| next.0 + row[i].0)
    };
    let (mut i, mut j) = (0, 0);
    while i + 1 < lower.len() || j + 1 < upper.len() {
        if middle(lower, i) < middle(upper, j) {
            triangles.push([lower[i].1, lower[i + 1].1, upper[j].1]);
            i += 1;
        } else {
            triangles.push([lower[i].1, upper[j + 1].1, upper[j].1]);
            j += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifted_rows_make_equilateral_triangles_with_halves_at_the_ends() {
        let lower: LatticeRow = vec![(0.0, 0), (1.0, 1), (2.0, 2)];
        let upper: LatticeRow = vec![(0.0, 3), (0.5, 4), (1.5, 5), (2.0, 6)];
        let mut triangles = Vec::new();
        stitch(&lower, &upper, &mut triangles);
        assert_eq!(
            triangles,
            [[0, 4, 3], [0, 1, 4], [1, 5, 4], [1, 2, 5], [2, 6, 5]]
        );
        triangles.clear();
        stitch(&upper, &lower, &mut triangles);
        assert_eq!(
            triangles,
            [[3, 4, 0], [4, 1, 0], [4, 5, 1], [5, 2, 1], [5, 6, 2]]
        );
    }
}
