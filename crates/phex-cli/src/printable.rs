//! Texts that do not steer the terminal that they are shown on.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write as _;

/// A text as it may be shown on a terminal: characters of file names and files that would steer it
/// are told instead, as JSON writes them, so that JSON stays what it is.
pub fn printable(text: &str) -> Cow<'_, str> {
    let steers = |c: char| {
        let turns_text = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns_text || (c.is_control() && !matches!(c, '\n' | '\t'))
    };
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match steers(c) {
            // Writing to a string does not fail.
            true => drop(write!(safe, "\\u{:04x}", u32::from(c))),
            false => safe.push(c),
        }
    }
    Cow::Owned(safe)
}

/// Writes a line to the standard error. Where that can't be done, on a full disc for instance, what
/// was to be said is lost, and the exit code is not.
pub fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", printable(line));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_steers_a_terminal_is_printed() {
        assert_eq!(printable("panels\t7\n§ é ✓"), "panels\t7\n§ é ✓");
        let steering = "\u{1b}[31mred\u{9b}2J\r\u{7}\u{202e}";
        let told = "\\u001b[31mred\\u009b2J\\u000d\\u0007\\u202e";
        assert_eq!(printable(steering), told);
        let json = serde_json::to_string(steering).unwrap();
        assert_eq!(
            serde_json::from_str::<String>(&printable(&json)).unwrap(),
            steering
        );
    }
}
