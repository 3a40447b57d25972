//! Random files for every reader: it takes them or says what is wrong, and never allocates more
//! than a multiple of what it was given.

use peak_alloc::PeakAlloc;
use phex_fuzz::campaign::{Tried, campaign};
use phex_fuzz::inputs::Corpus;
use phex_job::{FileInfo, MeshFile, MeshSettings, read_numbers, read_polylines};
use phex_mesh::io::{Format, parse_soup, write_soup_to};
use phex_mesh::{HexMesh, PolygonSoup};
use phex_study::StudyFile;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Tests of this file run one after another: the allocator counts for all of them.
static TURN: Mutex<()> = Mutex::new(());

/// Bytes that may be allocated at one time for each byte of a file.
const MOST: f64 = 64.0;
/// The same for TOML, whose library takes more where every token is a byte long; such files are at
/// most [`phex_job::LONGEST_TOML`] long.
const MOST_OF_TOML: f64 = 104.0;
/// Bytes that every file counts as at least: libraries have buffers, and the one for PLY makes room
/// for a list of 16,384 entries, 16 bytes each, before it reads them.
const SMALLEST: usize = 8192;

fn turn() -> MutexGuard<'static, ()> {
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn corpus(folder: &str, words: &[&str]) -> Corpus {
    let at = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    Corpus::new(&at.join(folder), words)
}

/// What a reader made of a file, and the bytes that it had at one time, over those of the file.
fn measured<T>(length: usize, most: f64, read: impl FnOnce() -> T) -> Result<(T, f64), String> {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let read = read();
    let used = MEMORY.peak_usage().saturating_sub(before);
    let ratio = used as f64 / length.max(SMALLEST) as f64;
    match ratio <= most {
        true => Ok((read, ratio)),
        false => Err(format!("{used} bytes are allocated for a file of {length}")),
    }
}

/// Reads random files of a format, and what is read once more after writing it.
fn meshes(format: Format, words: &[&str]) {
    let _turn = turn();
    let corpus = corpus(format.extension(), words);
    let figures = campaign(|u| {
        let file = corpus.file(u.peek_bytes(u.len()).unwrap_or_default());
        let (soup, ratio) = measured(file.len(), MOST, || parse_soup(&file, format))?;
        let shown = String::from_utf8_lossy(&file);
        let taken = match soup {
            Err(error) if !(1..1000).contains(&error.to_string().len()) => {
                return Err(format!("the message is {error}"));
            }
            Err(_) => false,
            Ok(soup) => {
                check_soup(&soup, format).map_err(|e| format!("{e} in {shown}"))?;
                true
            }
        };
        // What follows costs more than reading does.
        if file.len().is_multiple_of(8) {
            read_as_job(&file, format)?;
        }
        Ok(Tried { taken, ratio })
    });
    println!("{}: {figures}", format.extension());
    assert!(figures.taken > 0);
}

/// Corners that exist, coordinates that are finite, and the same mesh again after writing it.
fn check_soup(soup: &PolygonSoup, format: Format) -> Result<(), String> {
    let finite = soup.positions.iter().flatten().all(|x| x.is_finite());
    let exist =
        |f: &Vec<u32>| f.len() > 2 && f.iter().all(|&v| (v as usize) < soup.positions.len());
    if !finite || !soup.faces.iter().all(exist) {
        return Err("not finite, or a corner that does not exist".to_owned());
    }
    if format == Format::Stl {
        return Ok(());
    }
    let mut bytes = Vec::new();
    write_soup_to(&mut bytes, soup, format).map_err(|e| e.to_string())?;
    let again = parse_soup(&bytes, format).map_err(|e| e.to_string())?;
    let bits = |s: &PolygonSoup| -> Vec<u64> {
        s.positions.iter().flatten().map(|x| x.to_bits()).collect()
    };
    let same = bits(&again) == bits(soup) && again.faces == soup.faces;
    same.then_some(())
        .ok_or_else(|| "written and read it is another".to_owned())
}

/// Everything that commands do with a file before they compute.
fn read_as_job(file: &[u8], format: Format) -> Result<(), String> {
    let name = format!("a.{}", format.extension());
    let Ok(read) = MeshFile::from_bytes(Path::new(&name), file) else {
        return Ok(());
    };
    if let Ok(parts) = read.surfaces() {
        let areas = parts.components.iter().map(|c| c.surface.area());
        if !areas.clone().all(|a| a > 0.0 && a.is_finite()) {
            return Err(format!("areas {:?}", areas.collect::<Vec<_>>()));
        }
    }
    let _ = FileInfo::new(&read);
    let _ = read
        .polygon_mesh()
        .map(|(mesh, _): (HexMesh, usize)| mesh.mean_edge());
    Ok(())
}

#[test]
fn obj() {
    meshes(
        Format::Obj,
        &["v", "f", "vn", "l", "1/2/3", "f 1 2 3", "v 1 2 3\n"],
    );
}

#[test]
fn ply() {
    let words = [
        "element", "property", "list", "uchar", "double", "int", "vertex", "face", "ascii",
    ];
    meshes(Format::Ply, &words);
}

#[test]
fn stl() {
    meshes(
        Format::Stl,
        &[
            "solid",
            "facet",
            "outer loop",
            "vertex",
            "endfacet",
            "vertex 0 0 1\n",
        ],
    );
}

#[test]
fn off() {
    meshes(Format::Off, &["OFF", "NOFF", "STOFF", "4OFF", "3 0 1 2\n"]);
}

#[test]
fn job_files() {
    let _turn = turn();
    let words = [
        "[stages.layout]",
        "[steering]",
        "=",
        "[[",
        "]]",
        "'clip'",
        "panels = 3\n",
        "1mm",
        "true",
        "\"",
        "{ a = 1 }",
    ];
    let corpus = corpus("job", &words);
    let figures = campaign(|u| {
        let file = corpus.file(u.peek_bytes(u.len()).unwrap_or_default());
        let text = String::from_utf8_lossy(&file);
        let (settings, ratio) =
            measured(text.len(), MOST_OF_TOML, || MeshSettings::from_toml(&text))?;
        let taken = settings.is_ok_and(|s| s.check().is_ok());
        Ok(Tried { taken, ratio })
    });
    println!("job files: {figures}");
    assert!(figures.taken > 0);
}

#[test]
fn study_files() {
    let _turn = turn();
    let corpus = corpus(
        "study",
        &[
            "[space]",
            "[[variants]]",
            "from",
            "count",
            "[",
            "]",
            "1GB",
            "'",
        ],
    );
    let figures = campaign(|u| {
        let file = corpus.file(u.peek_bytes(u.len()).unwrap_or_default());
        let text = String::from_utf8_lossy(&file);
        let (study, ratio) = measured(text.len(), MOST_OF_TOML, || StudyFile::from_toml(&text))?;
        Ok(Tried {
            taken: study.is_ok(),
            ratio,
        })
    });
    println!("study files: {figures}");
    assert!(figures.taken > 0);
}

/// Points, cones, sizes and lines are read from files; these are written anew for each input.
#[test]
fn side_files() {
    let _turn = turn();
    let memory = Path::new("/dev/shm");
    let folder = match memory.is_dir() {
        true => tempfile::tempdir_in(memory),
        false => tempfile::tempdir(),
    };
    let folder = folder.expect("a temporary folder");
    let [points, lines] = ["points.txt", "lines.obj"].map(|name| folder.path().join(name));
    let (numbers, polylines) = (
        corpus("numbers", &["# 1"]),
        corpus("lines", &["v", "l", "-1/2", "l 1 2\n"]),
    );
    let figures = campaign(|u| {
        let is_line = u.arbitrary().unwrap_or(false);
        let random = u.peek_bytes(u.len()).unwrap_or_default();
        let file = if is_line {
            polylines.file(random)
        } else {
            numbers.file(random)
        };
        let path = if is_line { &lines } else { &points };
        std::fs::write(path, &file).map_err(|e| e.to_string())?;
        let (taken, ratio) = measured(file.len(), MOST, || match is_line {
            true => read_polylines(path).is_ok(),
            false => read_numbers(path).is_ok(),
        })?;
        Ok(Tried { taken, ratio })
    });
    println!("side files: {figures}");
    assert!(figures.taken > 0);
}

/// Lengths, areas, times and lists of numbers as they are typed.
#[test]
fn typed_values() {
    let _turn = turn();
    let corpus = corpus("words", &["m", "mm", "%", "x", "s", "h", "GB", "m2"]);
    let figures = campaign(|u| {
        let file = corpus.file(u.peek_bytes(u.len()).unwrap_or_default());
        let text = String::from_utf8_lossy(&file);
        let quantity = text.parse::<phex_job::Quantity>();
        let finite = quantity.as_ref().map_or(true, |q| q.value().is_finite());
        let three = phex_job::three(&text);
        let listed = three
            .as_ref()
            .map_or(true, |v| v.iter().all(|x| x.is_finite()));
        if !finite || !listed {
            return Err(format!("`{text}` is not finite"));
        }
        let others = [
            text.parse::<phex_job::Rectangle>().is_ok(),
            text.parse::<phex_job::Area>().is_ok(),
            phex_job::time_limit(&text).is_ok(),
            phex_job::ten(&text).is_ok(),
            phex_study::memory_limit(&text).is_ok(),
        ];
        let taken = quantity.is_ok() || three.is_ok() || others.contains(&true);
        Ok(Tried { taken, ratio: 0.0 })
    });
    println!("typed values: {figures}");
    assert!(figures.taken > 0);
}
