//! The text of a job file, or of a study file.

use crate::error::JobError;
use serde::de::DeserializeOwned;

/// Bytes of such a text at the most. The library takes up to 101 bytes of memory for each, where
/// every token is one byte long, so no text takes more than about 110 MB.
pub const LONGEST_TOML: usize = 1 << 20;
/// Characters of the parser's message that are shown: it quotes names and values of any length.
const SHOWN: usize = 1000;

/// What the text of a job file or a study file says.
///
/// ```
/// use phex_job::{MeshSettings, from_toml};
///
/// let settings: MeshSettings = from_toml("panels = 300\nboundary = 'clip'")?;
/// assert_eq!(settings.panels, Some(300));
/// let told = from_toml::<MeshSettings>("panels = 300\nedge = 2").unwrap_err();
/// assert!(told.to_string().contains("line 2"));
/// # Ok::<(), phex_job::JobError>(())
/// ```
///
/// # Errors
/// If it is longer than [`LONGEST_TOML`], is no TOML, or says something that `T` does not know; the
/// message begins with the line.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, JobError> {
    if text.len() > LONGEST_TOML {
        let found = text.len();
        return Err(JobError::input(format!(
            "the file has {found} bytes, and a file of settings has at most {LONGEST_TOML}: lists of points, cones and sizes \
             stand in files of their own, and `space` names combinations instead of each variant"
        )));
    }
    toml::from_str(text).map_err(|e| JobError::input(located(&e, text)))
}

/// The parser's message in one line, with the line of the file.
fn located(error: &toml::de::Error, text: &str) -> String {
    let message: String = error
        .message()
        .replace('\n', ", ")
        .chars()
        .take(SHOWN)
        .collect();
    match error.span() {
        Some(span) => {
            let line = 1 + text[..span.start].matches('\n').count();
            format!("line {line}: {message}")
        }
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshSettings;

    #[test]
    fn a_text_that_is_too_long_is_refused_before_it_is_parsed() {
        let comment = |bytes: usize| "#".repeat(bytes);
        assert!(from_toml::<MeshSettings>(&comment(LONGEST_TOML)).is_ok());
        let told = from_toml::<MeshSettings>(&comment(LONGEST_TOML + 1)).unwrap_err();
        assert!(told.to_string().contains("1048577 bytes"), "{told}");
    }
}
