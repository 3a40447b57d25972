//! `cargo xtask figures`: counterparts of the figures of Wang and Liu, "A note on planar hexagonal meshes" (2010), and the table
//! "method x surface", written to `docs/gallery` with the commands that made them.

mod list;
mod obj;
mod run;
mod surfaces;
mod table;

pub use obj::Obj;

use run::{GALLERY, Phex, WORK};
use std::fmt::Write;
use std::path::Path;

/// One figure of the gallery.
pub struct Figure {
    /// Its number in the paper.
    number: usize,
    /// What it shows, one sentence.
    sentence: &'static str,
    /// Makes its pictures.
    make: fn(&mut Maker<'_>) -> Result<(), String>,
}

/// A figure in the making: the commands that were run, the pictures, and the figures under them.
pub struct Maker<'a> {
    phex: &'a Phex,
    commands: Vec<String>,
    pictures: Vec<(String, String)>,
    figures: Vec<String>,
}

/// Rows of the program's table that are shown under a picture.
const ROWS: [&str; 8] = [
    "dual",
    "flips",
    "forecast",
    "panels",
    "planarity",
    "simple",
    "deviation",
    "indicatrix",
];

impl Maker<'_> {
    /// Runs a command that makes a file, and remembers it.
    fn run(&mut self, line: &str) -> Result<(), String> {
        let said = self.phex.make(line)?;
        self.commands.push(said.line);
        Ok(())
    }

    /// Runs a command and shows the figures of its table.
    fn measured(&mut self, name: &str, line: &str) -> Result<(), String> {
        let said = self.phex.make(&format!("{line} --progress none"))?;
        self.commands.push(format!("phex {line}"));
        let rows = ROWS
            .iter()
            .filter_map(|r| Some(format!("{r} {}", said.row(r)?)));
        self.figures
            .push(format!("{name}: {}.", rows.collect::<Vec<_>>().join("; ")));
        Ok(())
    }

    /// Says something that was measured elsewhere.
    fn say(&mut self, text: String) {
        self.figures.push(text);
    }

    /// A step that the task makes itself.
    fn note(&mut self, text: &str) {
        self.commands.push(format!("# {text}"));
    }

    /// Draws a mesh into the gallery.
    fn draw(
        &mut self,
        mesh: &str,
        picture: &str,
        caption: &str,
        options: &str,
    ) -> Result<(), String> {
        let size = if options.contains("--size") {
            ""
        } else {
            "--size 560x420 "
        };
        let line = format!("render {WORK}/{mesh} -o {GALLERY}/{picture}.png {size}{options}");
        self.run(line.trim())?;
        self.pictures
            .push((format!("{picture}.png"), caption.to_owned()));
        Ok(())
    }
}

/// Makes everything; with numbers only the pictures of those figures, and no page.
pub fn figures(root: &Path, only: &[&str]) -> Result<(), String> {
    let phex = Phex::build(root)?;
    surfaces::make(&phex)?;
    if !only.is_empty() {
        let wanted = |f: &&Figure| only.contains(&f.number.to_string().as_str());
        return list::FIGURES
            .iter()
            .filter(wanted)
            .try_for_each(|f| section(&phex, f).map(|_| ()));
    }
    let mut page = String::from(INTRODUCTION);
    for figure in &list::FIGURES {
        println!("== figure {}", figure.number);
        page += &section(&phex, figure)?;
    }
    println!("== table");
    page += TABLE;
    page += &table::table(&phex)?;
    let path = phex.gallery("README.md");
    std::fs::write(&path, page).map_err(|e| format!("{}: {e}", path.display()))
}

const INTRODUCTION: &str = "# Gallery

Counterparts of the figures of W. Wang and Y. Liu, \"A note on planar hexagonal meshes\" (2010), and the methods that the paper reviews side by side with
ours. Everything here is made by `cargo xtask figures`, with the commands given; figures under the pictures are what the program measured. Planarity is the
largest distance of a corner to its panel's plane in mean edges, deviation is over the diagonal of the bounding box.
Colours: convex hexagons cream, concave ones green, pentagons blue, heptagons orange, smaller panels violet.

";

const TABLE: &str = "## Method by surface

Each cell: planarity (mean edges), number of self-intersecting panels, largest deviation; about 200 panels. `lattice` is ours, `brick-wall` the paper's own method with our kinks and
optimiser; it needs a global conjugate network. The others refuse surfaces outside their domain, and *forced* is what `--any-domain` makes of them all the same; only `tangent-planes` takes any surface,
and keeps the triangulation of the lattice. Where `K > 0` the rest join their planes as the convex hull of the poles, so that no panel crosses itself. Where `K < 0` they keep to the sign rule:
to second order a panel is simple if and only if, of the three edges `e` of every triangle of touching points, `II(e, e)` is positive for some and negative for others. `blob` is `|x|^3.5 + |y/0.9|^3.5 + |z/0.7|^3.5 = 1`, convex with
nearly flat parts.

";

fn section(phex: &Phex, figure: &Figure) -> Result<String, String> {
    let mut maker = Maker {
        phex,
        commands: Vec::new(),
        pictures: Vec::new(),
        figures: Vec::new(),
    };
    (figure.make)(&mut maker).map_err(|e| format!("figure {}: {e}", figure.number))?;
    let mut text = format!("## Figure {}\n\n{}\n\n", figure.number, figure.sentence);
    let cells = |f: &dyn Fn(&(String, String)) -> String| -> String {
        let cells: Vec<String> = maker.pictures.iter().map(f).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    text += &cells(&|(file, caption)| format!("![{caption}]({file})"));
    text += &cells(&|_| "---".to_owned());
    text += &cells(&|(_, caption)| caption.clone());
    text.push('\n');
    for line in &maker.figures {
        let _ = writeln!(text, "- {line}");
    }
    let _ = write!(text, "\n```sh\n{}\n```\n\n", maker.commands.join("\n"));
    Ok(text)
}
