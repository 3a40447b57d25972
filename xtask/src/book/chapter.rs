//! Running the commands of a chapter.

use super::BookFolder;
use super::transcript::{RunBlock, ShownCommand, agrees, blocks};
use crate::{read, verdict, write};
use std::path::Path;
use std::time::Instant;

/// Runs the commands of a chapter in a folder of their own and compares what they print with what
/// the chapter shows; with `writes` output that is shown whole is brought up to date instead.
pub fn check(place: &BookFolder, path: &Path, writes: bool) -> Result<(), String> {
    let text = read(path)?;
    let blocks = blocks(&text);
    if blocks.is_empty() {
        return Ok(());
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let folder = place.folder(&name)?;
    let start = Instant::now();
    let (mut complaints, mut news) = (Vec::new(), Vec::new());
    for block in &blocks {
        match block {
            RunBlock::File { name, text } => write(&folder.join(name), text)?,
            RunBlock::Console(commands) => {
                for shown in commands {
                    let (said, fine) = place.said(&folder, &shown.command)?;
                    let lines: Vec<&str> = said.lines().collect();
                    if !fine {
                        complaints.push(complaint(path, shown, "fails", &said));
                    } else if !agrees(&shown.output, &lines) {
                        if writes && !shown.output.iter().any(|l| l.contains("...")) {
                            news.push((shown.clone(), said));
                        } else {
                            complaints.push(complaint(path, shown, "prints", &said));
                        }
                    }
                }
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{name}: {seconds:.1} s");
    if !news.is_empty() {
        write(path, &renewed(&text, &news))?;
    }
    verdict(complaints)
}

fn complaint(path: &Path, shown: &ShownCommand, what: &str, said: &str) -> String {
    let ShownCommand { line, command, .. } = shown;
    format!("{}:{line}: `{command}` {what}\n{said}", path.display())
}

/// A chapter with the outputs of some commands brought up to date.
fn renewed(text: &str, news: &[(ShownCommand, String)]) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    for (shown, said) in news.iter().rev() {
        let first = shown.line - 1 + shown.command.lines().count();
        lines.splice(first..first + shown.output.len(), said.lines());
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_brought_up_to_date_in_their_places() {
        let text = "```console\n$ a \\\n  b\nold\n$ c\n$ d\nold\nolder\n```\nend\n";
        let RunBlock::Console(commands) = &blocks(text)[0] else {
            panic!("no block");
        };
        let said = ["1\n2\n", "3\n", "4\n"];
        let news: Vec<_> = (commands.iter().cloned())
            .zip(said.map(str::to_owned))
            .collect();
        assert_eq!(
            renewed(text, &news),
            "```console\n$ a \\\n  b\n1\n2\n$ c\n3\n$ d\n4\n```\nend\n"
        );
    }
}
