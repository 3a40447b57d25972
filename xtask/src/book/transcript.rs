//! Blocks of a chapter that are run: commands with what they print, and files.

/// A block of a chapter that is run.
#[derive(Debug, PartialEq, Eq)]
pub enum RunBlock {
    /// Commands, each with the output that is shown.
    Console(Vec<ShownCommand>),
    /// A file that the commands after it find.
    File {
        /// Its name.
        name: String,
        /// What is in it.
        text: String,
    },
}

/// A command as the book shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownCommand {
    /// The line of the chapter on which it stands, from 1.
    pub line: usize,
    /// The command line; it may go on over several lines.
    pub command: String,
    /// What it prints, line by line.
    pub output: Vec<String>,
}

/// Processor and system for which a block is meant, as `x86_64-linux`.
fn here() -> String {
    format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
}

/// The blocks of a chapter that are run here: fences that open with `console` (perhaps `console
/// only=x86_64-linux`), and `toml file=NAME` or the like.
pub fn blocks(text: &str) -> Vec<RunBlock> {
    let mut found = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((_, line)) = lines.next() {
        let Some(info) = line.strip_prefix("```") else {
            continue;
        };
        let body: Vec<(usize, &str)> = lines.by_ref().take_while(|l| l.1 != "```").collect();
        let word = |key: &str| info.split(' ').find_map(|w| w.strip_prefix(key));
        if let Some(name) = word("file=") {
            let name = name.to_owned();
            let text = body.iter().map(|l| format!("{}\n", l.1)).collect();
            found.push(RunBlock::File { name, text });
        } else if info.split(' ').next() == Some("console")
            && word("only=").is_none_or(|only| only == here())
        {
            found.push(RunBlock::Console(commands(&body)));
        }
    }
    found
}

fn commands(body: &[(usize, &str)]) -> Vec<ShownCommand> {
    let mut all: Vec<ShownCommand> = Vec::new();
    let mut goes_on = false;
    for &(index, line) in body {
        if let Some(command) = line.strip_prefix("$ ") {
            all.push(ShownCommand {
                line: index + 1,
                command: command.to_owned(),
                output: Vec::new(),
            });
            goes_on = line.ends_with('\\');
        } else if let Some(last) = all.last_mut() {
            if goes_on {
                last.command += &format!("\n{line}");
                goes_on = line.ends_with('\\');
            } else {
                last.output.push(line.trim_end().to_owned());
            }
        }
    }
    all
}

/// Whether an output is what is shown: `...` in a line stands for any text, and on a line of its
/// own for any lines.
pub fn agrees(shown: &[String], said: &[&str]) -> bool {
    match shown.split_first() {
        None => said.is_empty(),
        Some((first, rest)) if first.trim() == "..." => {
            (0..=said.len()).any(|skipped| agrees(rest, &said[skipped..]))
        }
        Some((first, rest)) => said
            .split_first()
            .is_some_and(|(line, later)| line_agrees(first, line) && agrees(rest, later)),
    }
}

fn line_agrees(shown: &str, said: &str) -> bool {
    let mut pieces = shown.split("...");
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = said.trim_end().strip_prefix(first) else {
        return false;
    };
    let pieces: Vec<&str> = pieces.collect();
    let Some((last, middle)) = pieces.split_last() else {
        return rest.is_empty();
    };
    for piece in middle {
        match rest.find(piece) {
            Some(at) => rest = &rest[at + piece.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn blocks_hold_commands_outputs_and_files() {
        let text = "a\n```console\n$ phex a \\\n    -o b\none\n$ c\n```\n```sh\n$ no\n```\n```toml file=x.toml\nk = 1\n```\n```console only=none\n$ d\n```\n";
        let found = blocks(text);
        let [RunBlock::Console(commands), RunBlock::File { name, text }] = &found[..] else {
            panic!("{found:?}");
        };
        assert_eq!(commands[0].command, "phex a \\\n    -o b");
        assert_eq!(
            (commands[0].line, &commands[0].output[..]),
            (3, &shown("one")[..])
        );
        assert_eq!(
            (commands[1].command.as_str(), commands[1].output.len()),
            ("c", 0)
        );
        assert_eq!((name.as_str(), text.as_str()), ("x.toml", "k = 1\n"));
    }

    #[test]
    fn elisions_stand_for_text_and_lines_and_nothing_else_is_let_through() {
        let agree = |a: &str, b: &str| agrees(&shown(a), &b.lines().collect::<Vec<_>>());
        assert!(agree("x ... z\n...\nend", "x 1 2 z\nmore\nlines\nend"));
        assert!(agree("...", ""));
        assert!(agree("a...", "a"));
        for (a, b) in [
            ("x", "x\ny"),
            ("x\ny", "x"),
            ("x ... z", "x 1"),
            ("...\nend", "end\nmore"),
            ("x", "xx"),
            ("", "x"),
            ("aa...aa", "aaa"),
        ] {
            assert!(!agree(a, b), "{a} against {b}");
        }
    }
}
