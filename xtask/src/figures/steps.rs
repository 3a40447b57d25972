//! `cargo xtask obj`: the steps of the gallery between two runs of the program. They cut and join
//! OBJ files, so that every input of the gallery's commands is made by one of them.

use super::obj::{Obj, along, distance, write_curves};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// How the steps are typed.
pub const USAGE: &str = "usage: cargo xtask obj STEP... -o OUT
  honeycomb RINGS              regular hexagons in rings about one
  blob SPHERE                  the unit sphere made |x|^3.5 + |y / 0.9|^3.5 + |z / 0.7|^3.5 = 1
  above AXIS HEIGHT MESH       the faces whose centre is above a height along x, y, z or r, the distance from the z axis
  between AXIS LOW HIGH MESH   what lies between two heights; faces are cut there
  finite LENGTH MESH           the faces without an edge longer than LENGTH
  near X,Y,Z MESH              the hexagon nearest to a point, and the faces around it
  face X,Y,Z MESH [OTHER]      that hexagon alone, or the same face of another mesh
  strips X,Y,Z MESH            marks (for `phex render --mark`) of the three strips of hexagons through that hexagon
  circle FACE                  the circle through every second corner of a hexagon
  join MESH MESH               both in one";

/// Takes a step; paths are relative to `root`.
pub fn run(root: &Path, words: &[&str]) -> Result<(), String> {
    let usage = || USAGE.to_owned();
    let [step @ .., "-o", out] = words else {
        return Err(usage());
    };
    let out = root.join(out);
    std::fs::create_dir_all(out.parent().unwrap_or(root))
        .map_err(|e| format!("{}: {e}", out.display()))?;
    let read = |path: &str| Obj::read(&root.join(path));
    let made = match *step {
        ["honeycomb", rings] => Obj::honeycomb(rings.parse().map_err(|_| usage())?),
        ["blob", sphere] => read(sphere)?.mapped(superellipsoid),
        ["above", axis, height, mesh] => {
            let (axis, height) = (axis_number(axis)?, number(height)?);
            read(mesh)?.part(|c| along(c, axis) > height)
        }
        ["between", axis, low, high, mesh] => {
            read(mesh)?.between(axis_number(axis)?, number(low)?, number(high)?)
        }
        ["finite", length, mesh] => read(mesh)?.without_long_edges(number(length)?),
        ["near", place, mesh] => {
            let mesh = read(mesh)?;
            let face = hexagon(&mesh, place)?;
            mesh.around(face)
        }
        ["face", place, mesh] => {
            let mesh = read(mesh)?;
            mesh.face(hexagon(&mesh, place)?)
        }
        ["face", place, mesh, other] => {
            let face = hexagon(&read(mesh)?, place)?;
            read(other)?.face(face)
        }
        ["join", first, second] => read(first)?.with(&read(second)?),
        ["strips", place, mesh] => return write_marks(&read(mesh)?, place, &out),
        ["circle", face] => return write_curves(&out, &[read(face)?.circle().0]),
        _ => return Err(usage()),
    };
    made.write(&out)
}

/// A file below the work folder that a command reads and no earlier one has made.
pub fn unmade_input(commands: &[String], folder: &str) -> Option<String> {
    let mut made: Vec<PathBuf> = Vec::new();
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let is_output = |k: usize| k > 0 && ["-o", ">"].contains(&words[k - 1]);
        let named = (0..words.len()).filter(|&k| words[k].starts_with(folder));
        let (outputs, inputs): (Vec<usize>, Vec<usize>) = named.partition(|&k| is_output(k));
        let is_made = |k: &usize| {
            let path = Path::new(words[*k]);
            made.iter().any(|folder| path.starts_with(folder))
        };
        if let Some(missing) = inputs.into_iter().find(|k| !is_made(k)) {
            return Some(words[missing].to_owned());
        }
        made.extend(outputs.into_iter().map(|k| PathBuf::from(words[k])));
    }
    None
}

fn number(word: &str) -> Result<f64, String> {
    word.parse()
        .map_err(|_| format!("`{word}` is no number\n{USAGE}"))
}

fn axis_number(word: &str) -> Result<usize, String> {
    let axis = ["x", "y", "z", "r"].iter().position(|axis| *axis == word);
    axis.ok_or_else(|| format!("`{word}` is no axis\n{USAGE}"))
}

/// The hexagon of a mesh nearest to a point.
pub fn hexagon(mesh: &Obj, place: &str) -> Result<usize, String> {
    let numbers: Result<Vec<f64>, String> = place.split(',').map(number).collect();
    let [x, y, z] = numbers?[..] else {
        return Err(format!("`{place}` is no point X,Y,Z"));
    };
    let face = mesh.hexagon_near([x, y, z]);
    face.ok_or_else(|| "the mesh has no hexagon".to_owned())
}

/// The strips through a hexagon in three colours, the hexagon itself in a fourth.
fn write_marks(mesh: &Obj, place: &str, out: &Path) -> Result<(), String> {
    let face = hexagon(mesh, place)?;
    let mut text = String::new();
    for (k, strip) in mesh.strips(face).iter().enumerate() {
        for panel in strip {
            let _ = writeln!(text, "{panel} {}", k + 1);
        }
    }
    let _ = writeln!(text, "{face} 4");
    std::fs::write(out, text).map_err(|e| format!("{}: {e}", out.display()))
}

impl Obj {
    /// A face with its neighbours.
    fn around(&self, face: usize) -> Self {
        let centre = self.centre(&self.faces[face]);
        let corners = self.faces[face]
            .iter()
            .map(|&v| distance(self.points[v], centre));
        let reach = corners.fold(0.0, f64::max);
        self.part(|c| distance(c, centre) < 2.3 * reach)
    }

    /// The faces whose edges are at most so long.
    fn without_long_edges(&self, most: f64) -> Self {
        let short = |face: &&Vec<usize>| {
            let next = |k: usize| self.points[face[(k + 1) % face.len()]];
            (0..face.len()).all(|k| distance(self.points[face[k]], next(k)) <= most)
        };
        let kept = Self {
            points: self.points.clone(),
            faces: self.faces.iter().filter(short).cloned().collect(),
        };
        kept.part(|_| true)
    }
}

/// The point of `|x|^3.5 + |y / 0.9|^3.5 + |z / 0.7|^3.5 = 1` in a direction: convex, with six
/// nearly flat parts.
fn superellipsoid(d: [f64; 3]) -> [f64; 3] {
    const EXPONENT: f64 = 3.5;
    let axes = [1.0, 0.9, 0.7];
    let sum: f64 = (0..3).map(|k| (d[k] / axes[k]).abs().powf(EXPONENT)).sum();
    d.map(|x| x * sum.powf(-1.0 / EXPONENT))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_that_no_command_has_made_is_found() {
        let commands =
            |lines: &[&str]| -> Vec<String> { lines.iter().map(|l| (*l).to_owned()).collect() };
        let made = commands(&[
            "phex shape torus -o out/gallery/torus.obj -q",
            "printf 'x' > out/gallery/job.toml",
            "phex mesh out/gallery/torus.obj -o out/gallery/m.obj --config out/gallery/job.toml",
            "phex offset out/gallery/m.obj -o out/gallery/layers --distance 0.1",
            "phex render out/gallery/layers/layer_+0.1.obj -o docs/gallery/a.png",
        ]);
        assert_eq!(unmade_input(&made, "out/gallery/"), None);
        let missing = &made[2..];
        let found = unmade_input(missing, "out/gallery/");
        assert_eq!(found.as_deref(), Some("out/gallery/torus.obj"));
    }

    #[test]
    fn steps_that_are_not_understood_say_how_they_are_typed() {
        let refused = run(
            Path::new("."),
            &["above", "w", "1", "a.obj", "-o", "no/b.obj"],
        );
        let _ = std::fs::remove_dir("no");
        assert!(refused.is_err());
        assert!(
            run(Path::new("."), &["honeycomb"])
                .unwrap_err()
                .contains("usage")
        );
    }
}
