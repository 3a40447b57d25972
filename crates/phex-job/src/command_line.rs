//! A job as a command line.

/// A word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,%+:@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The words after `phex mesh SURFACE` that repeat a job, given as the table of its job file;
/// `file` is where the job file is, which is named if it holds what no option says.
///
/// ```
/// let job = "panels = 300\nrotate = -15\n[steering]\nfairness = 2".parse()?;
/// let words = phex_job::options_of(&job, "job.toml");
/// assert_eq!(words, "--panels=300 --rotate=-15 --fairness=2");
/// # Ok::<(), toml::de::Error>(())
/// ```
pub fn options_of(job: &toml::Table, file: &str) -> String {
    if job.contains_key("stages") {
        return format!("--config={}", quoted(file));
    }
    let tables = job.values().filter_map(toml::Value::as_table);
    let plain = std::iter::once(job).chain(tables).flatten();
    let words = plain.filter_map(|(name, value)| option(name, value));
    words.collect::<Vec<_>>().join(" ")
}

fn option(name: &str, value: &toml::Value) -> Option<String> {
    let typed = match value {
        toml::Value::Table(_) | toml::Value::Boolean(false) => return None,
        toml::Value::Boolean(true) => return Some(format!("--{name}")),
        toml::Value::String(text) => quoted(text),
        toml::Value::Array(items) => {
            let items: Vec<String> = items.iter().map(ToString::to_string).collect();
            items.join(",")
        }
        number => number.to_string(),
    };
    Some(format!("--{name}={typed}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_a_shell_would_split_are_quoted() {
        assert_eq!(quoted("--rotate=30"), "--rotate=30");
        assert_eq!(quoted("my roof.obj"), "'my roof.obj'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
