//! Ranges of options: what the checks of options structs are made of.

use std::ops::RangeInclusive;
use thiserror::Error;

/// An option has a value outside its range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{option} can't be {}: it must be {range}", shown(*.value))]
pub struct BadOption {
    /// Name of the option, after those of the tables that it is in, with dots between them.
    pub option: String,
    /// Its value.
    pub value: f64,
    /// What it may be.
    pub range: String,
}

/// The largest weight or ratio: what is larger drowns everything else in rounding.
pub const LARGEST_WEIGHT: f64 = 1e12;
/// The most iterations, passes or tries of one kind.
pub const MOST_STEPS: f64 = 1e6;

/// Options by their names.
pub type Named<'a> = &'a [(&'static str, f64)];

/// Whether numbers are above 0, and no larger than weights may be.
///
/// # Errors
/// The first of them that is not.
pub fn positive(options: Named<'_>) -> Result<(), BadOption> {
    let range = || format!("above 0, at most {LARGEST_WEIGHT:e}");
    all(options, |x| x > 0.0 && x <= LARGEST_WEIGHT, range)
}

/// Whether numbers are 0 or above, and no larger than weights may be.
///
/// # Errors
/// The first of them that is not.
pub fn not_negative(options: Named<'_>) -> Result<(), BadOption> {
    within(0.0..=LARGEST_WEIGHT, options)
}

/// Whether numbers lie between 0 and a limit, both excluded.
///
/// # Errors
/// The first of them that does not.
pub fn below(limit: f64, options: Named<'_>) -> Result<(), BadOption> {
    let range = || format!("above 0 and below {limit}");
    all(options, |x| x > 0.0 && x < limit, range)
}

/// Whether numbers of steps are at most [`MOST_STEPS`].
///
/// # Errors
/// The first of them that is not.
pub fn counts(options: &[(&'static str, usize)]) -> Result<(), BadOption> {
    let number = |&(name, n): &(&'static str, usize)| (name, n as f64);
    let options: Vec<_> = options.iter().map(number).collect();
    within(0.0..=MOST_STEPS, &options)
}

/// Whether numbers are within a range.
///
/// # Errors
/// The first of them that is not.
pub fn within(range: RangeInclusive<f64>, options: Named<'_>) -> Result<(), BadOption> {
    let (least, most) = (*range.start(), *range.end());
    let text = || format!("from {} to {}", shown(least), shown(most));
    all(options, |x| range.contains(&x), text)
}

/// A number without endless zeros.
fn shown(x: f64) -> String {
    match x.abs() {
        0.0 | 1e-6..1e6 => x.to_string(),
        _ => format!("{x:e}"),
    }
}

fn all(
    options: Named<'_>,
    fits: impl Fn(f64) -> bool,
    range: impl Fn() -> String,
) -> Result<(), BadOption> {
    match options.iter().find(|(_, x)| !fits(*x)) {
        None => Ok(()),
        Some(&(option, value)) => Err(BadOption {
            option: option.to_owned(),
            value,
            range: range(),
        }),
    }
}

impl BadOption {
    /// The same in a table, whose name comes before that of the option.
    pub fn in_table(self, table: &str) -> Self {
        Self {
            option: format!("{table}.{}", self.option),
            ..self
        }
    }
}

/// A positive ratio in single precision: in another unit it is the same.
pub(crate) fn without_unit(ratio: f64) -> f64 {
    match ratio > f64::from(f32::MIN_POSITIVE) {
        true => f64::from(ratio as f32),
        false => ratio,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_in_no_range() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let option: Named<'_> = &[("x", x)];
            assert!(
                positive(option).is_err() && not_negative(option).is_err(),
                "{x}"
            );
            assert!(
                below(1.0, option).is_err() && within(-1.0..=1.0, option).is_err(),
                "{x}"
            );
        }
        assert!(positive(&[("x", 0.0)]).is_err() && not_negative(&[("x", 0.0)]).is_ok());
        let error = within(-1.0..=1e12, &[("a", 0.5), ("b", -2.0)]).unwrap_err();
        let said = "t.b can't be -2: it must be from -1 to 1e12";
        assert_eq!(error.in_table("t").to_string(), said);
        let error = positive(&[("a", f64::NAN)]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a can't be NaN: it must be above 0, at most 1e12"
        );
    }
}
