//! Lists of numbers that are typed with commas between them.

use crate::input::number;

/// Reads as many numbers as are wanted; `form` says how they are written.
///
/// # Errors
/// If there are more or fewer, or one of them is none.
pub fn finite<const N: usize>(text: &str, form: &str) -> Result<[f64; N], String> {
    let numbers = text.split(',').map(|n| number(n.trim()));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("write {form}"))
}

/// A point.
pub fn three(text: &str) -> Result<[f64; 3], String> {
    finite(text, "X,Y,Z")
}

/// The upper triangle of a symmetric matrix of four rows.
pub fn ten(text: &str) -> Result<[f64; 10], String> {
    finite(text, "ten numbers: Q11,Q12,Q13,Q14,Q22,Q23,Q24,Q33,Q34,Q44")
}
