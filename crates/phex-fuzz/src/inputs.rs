//! Files that are nearly right: random choices applied to files of a corpus.

use arbitrary::{Result, Unstructured};
use std::path::Path;

/// Most edits of one file.
const EDITS: usize = 8;
/// Largest file that is made.
const LARGEST: usize = 8192;
/// Numbers with which a count or an index is replaced, little endian.
const NASTY: [u32; 8] = [
    0,
    1,
    2,
    0xff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
];

/// What files of one kind are made from.
pub struct Corpus {
    seeds: Vec<Vec<u8>>,
    words: Vec<String>,
}

impl Corpus {
    /// The files of a folder, in the order of their names, and words of the format besides those
    /// that stand for bad numbers everywhere.
    pub fn new(folder: &Path, words: &[&str]) -> Self {
        let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{folder:?}: {e}"));
        let mut paths: Vec<_> = entries.map(|e| e.expect("an entry").path()).collect();
        paths.sort();
        let read = |p| std::fs::read(p).expect("a readable file");
        let everywhere = [
            "nan",
            "inf",
            "-inf",
            "1e999",
            "-1e-999",
            "1e308",
            "0",
            "-0",
            "-1",
            "4294967295",
            "4294967296",
            "18446744073709551616",
            "-9223372036854775808",
            "0x10",
            "1_0",
            "1e",
            ".",
            "\u{0}",
            "\u{1b}[0m",
            "é",
            "\\\n",
            "\r",
            "\n\n",
            " ",
            "#",
            "/",
            ",",
        ];
        Self {
            seeds: paths.iter().map(read).collect(),
            words: everywhere
                .iter()
                .chain(words)
                .map(|w| w.to_string())
                .collect(),
        }
    }

    /// The file that some random bytes stand for.
    pub fn file(&self, random: &[u8]) -> Vec<u8> {
        let mut u = Unstructured::new(random);
        let mut file = u.choose(&self.seeds).cloned().unwrap_or_default();
        let edits = u.int_in_range(0..=EDITS).unwrap_or(0);
        for _ in 0..edits {
            if u.is_empty() || self.edit(&mut u, &mut file).is_err() {
                break;
            }
        }
        file.truncate(LARGEST);
        file
    }

    fn edit(&self, u: &mut Unstructured, file: &mut Vec<u8>) -> Result<()> {
        let (start, end) = range(u, file.len())?;
        match u.int_in_range(0..=9u8)? {
            0 => file
                .iter_mut()
                .skip(start)
                .take(1)
                .for_each(|b| *b ^= 1 << (end % 8)),
            1 => insert(file, start, u.choose(&self.words)?.as_bytes()),
            2 => drop(file.drain(start..end)),
            3 => {
                let copy = file[start..end].to_vec();
                let at = u.int_in_range(0..=file.len())?;
                insert(file, at, &copy);
            }
            4 => file.truncate(end),
            5 => {
                let other = u.choose(&self.seeds)?;
                file.truncate(start);
                file.extend(&other[end.min(other.len())..]);
            }
            6 => replace_word(file, start, u.choose(&self.words)?.as_bytes()),
            7 => insert(file, start, u.bytes(4)?),
            8 => {
                let number = u.choose(&NASTY)?.to_le_bytes();
                file.iter_mut()
                    .skip(start)
                    .zip(number)
                    .for_each(|(b, n)| *b = n);
            }
            _ => {
                let copy = file[start..end].repeat(u.int_in_range(2..=40)?);
                insert(file, end, &copy);
            }
        }
        Ok(())
    }
}

/// A part of a file, mostly a short one.
fn range(u: &mut Unstructured, length: usize) -> Result<(usize, usize)> {
    let start = u.int_in_range(0..=length)?;
    let reach = if u.ratio(1, 8)? { length } else { 16 };
    let end = u.int_in_range(start..=length.min(start + reach))?;
    Ok((start, end))
}

fn insert(file: &mut Vec<u8>, at: usize, bytes: &[u8]) {
    if file.len() + bytes.len() <= LARGEST {
        file.splice(at..at, bytes.iter().copied());
    }
}

/// Puts another word in the place of the one at a byte.
fn replace_word(file: &mut Vec<u8>, at: usize, word: &[u8]) {
    let is_blank = |b: &u8| b.is_ascii_whitespace();
    let end = file[at..]
        .iter()
        .position(is_blank)
        .map_or(file.len(), |k| at + k);
    let start = file[..at].iter().rposition(is_blank).map_or(0, |k| k + 1);
    file.splice(start..end.max(start), word.iter().copied());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_bytes_give_the_same_file_and_most_bytes_another_one() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/obj");
        let corpus = Corpus::new(&folder, &["v"]);
        let random = |k: u8| -> Vec<u8> {
            (0..200u8)
                .map(|i| i.wrapping_mul(37) ^ k.wrapping_mul(91))
                .collect()
        };
        let files: std::collections::BTreeSet<Vec<u8>> =
            (0..100).map(|k| corpus.file(&random(k))).collect();
        assert_eq!(corpus.file(&random(3)), corpus.file(&random(3)));
        assert!(files.len() > 60, "{} different files", files.len());
        assert!(corpus.file(&[]) == corpus.seeds[0]);
    }
}
