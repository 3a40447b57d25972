//! Lines, tokens and numbers of the text formats.

use super::error::{FilePlace, ReadCause, ReadError};
use crate::Vec3;
use std::borrow::Cow;
use std::num::IntErrorKind;

/// A file's text. Bytes that are no UTF-8 (names and comments in older encodings) are replaced.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    String::from_utf8_lossy(bytes)
}

/// Lines with their numbers from 1, without comments, outer white space and empty lines.
pub(super) fn numbered_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().map(without_comment).enumerate();
    lines
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty())
}

/// The part of a line before `#`.
pub(super) fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default()
}

/// What stands in a file, as it is shown in a message: cut after 40 characters.
pub fn shown(token: &str) -> String {
    let mut text: String = token.chars().take(40).collect();
    if text.len() < token.len() {
        text.push('…');
    }
    text
}

/// The first three tokens as a point; further ones (weight, colour, normal) are ignored.
pub(super) fn point<'a>(
    tokens: impl Iterator<Item = &'a str>,
    place: FilePlace,
) -> Result<Vec3, ReadError> {
    let mut point = Vec3::zeros();
    let mut found = 0;
    for (x, token) in point.iter_mut().zip(tokens) {
        *x = coordinate(token).map_err(|cause| cause.at(place))?;
        found += 1;
    }
    if found < 3 {
        return Err(ReadCause::TooFewCoordinates { found }.at(place));
    }
    Ok(point)
}

fn coordinate(token: &str) -> Result<f64, ReadCause> {
    match token.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(ReadCause::NonFinite {
            token: shown(token),
        }),
        Err(_) => Err(not_a_number(token)),
    }
}

/// A whole number; one that overflows is returned as the largest or smallest.
pub(super) fn integer(token: &str) -> Result<i64, ReadCause> {
    token
        .parse()
        .or_else(|error: std::num::ParseIntError| match error.kind() {
            IntErrorKind::PosOverflow => Ok(i64::MAX),
            IntErrorKind::NegOverflow => Ok(i64::MIN),
            _ => Err(not_a_number(token)),
        })
}

/// A count that is not negative.
pub(super) fn count(token: &str) -> Result<usize, ReadCause> {
    usize::try_from(integer(token)?).map_err(|_| not_a_number(token))
}

/// A vertex number counted from 0 and below `vertices`.
pub(super) fn vertex_number(index: i64, vertices: usize) -> Result<u32, ReadCause> {
    let number = u32::try_from(index).ok();
    number
        .filter(|&v| (v as usize) < vertices)
        .ok_or_else(|| out_of_range(index, vertices, 0))
}

/// The error for a vertex number that does not exist.
pub(super) fn out_of_range(index: i64, vertices: usize, first: u32) -> ReadCause {
    let index = match index {
        i64::MAX => "above 9223372036854775806".to_owned(),
        i64::MIN => "below -9223372036854775807".to_owned(),
        _ => index.to_string(),
    };
    ReadCause::IndexOutOfRange {
        index,
        vertices,
        first,
    }
}

fn not_a_number(token: &str) -> ReadCause {
    ReadCause::NotANumber {
        token: shown(token),
    }
}
