//! `cargo xtask figures`: counterparts of the figures of Wang and Liu, "A note on planar hexagonal
//! meshes" (2010), and the table "method x surface", written to `docs/gallery` with the commands
//! that made them.

mod list;
mod obj;
mod run;
pub mod steps;
mod surfaces;
mod table;

pub use obj::Obj;

use run::{GALLERY, Phex, WORK};
use std::fmt::Write;
use std::path::Path;

/// One figure of the gallery.
pub struct GalleryFigure {
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
const ROWS: [&str; 12] = [
    "fit",
    "signs",
    "curvature",
    "dual",
    "conjugate",
    "flips",
    "forecast",
    "panels",
    "planarity",
    "simple",
    "deviation",
    "indicatrix",
];

impl Maker<'_> {
    /// Runs a command of the program that makes a file, and remembers it.
    fn run(&mut self, line: &str) -> Result<(), String> {
        self.follow(format!("phex {line}"))
    }

    /// Takes a step between two commands of the program.
    fn step(&mut self, line: &str) -> Result<(), String> {
        self.follow(format!("cargo xtask obj {line}"))
    }

    /// Makes a surface.
    fn surface(&mut self, name: &str) -> Result<(), String> {
        let commands = surfaces::commands(name);
        commands.into_iter().try_for_each(|line| self.follow(line))
    }

    /// Writes a job file.
    fn job(&mut self, name: &str, text: &str) -> Result<(), String> {
        let text = text.replace('\n', "\\n");
        self.follow(format!("printf '{text}' > {WORK}/{name}"))
    }

    /// Makes what a command line makes, and remembers it; once in a figure.
    fn follow(&mut self, line: String) -> Result<(), String> {
        self.phex.follow(&line)?;
        if !self.commands.contains(&line) {
            self.commands.push(line);
        }
        Ok(())
    }

    /// Runs a command and shows the figures of its table.
    fn measured(&mut self, name: &str, line: &str) -> Result<(), String> {
        let said = self.phex.make(&format!("{line} --progress none"))?;
        self.commands.push(format!("phex {line}"));
        self.phex.remember(line);
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

    /// Draws a mesh into the gallery, all from one side and in one size.
    fn draw(
        &mut self,
        mesh: &str,
        picture: &str,
        caption: &str,
        options: &str,
    ) -> Result<(), String> {
        let side = if options.contains("--view") {
            String::new()
        } else {
            format!(" --azimuth {SIDE}")
        };
        let line = format!(
            "render {WORK}/{mesh} -o {GALLERY}/{picture}.png --size 560x420{side} {options}"
        );
        self.run(line.trim())?;
        self.pictures
            .push((format!("{picture}.png"), caption.to_owned()));
        Ok(())
    }
}

/// The side from which meshes are seen, degrees: from the front, a little from the right.
const SIDE: i32 = -60;

/// Makes everything; with numbers only those figures, and their sections of the page.
pub fn figures(root: &Path, only: &[&str]) -> Result<(), String> {
    let phex = Phex::build(root)?;
    let path = phex.gallery("README.md");
    if !only.is_empty() {
        let mut page = crate::read(&path)?;
        let wanted = |f: &&GalleryFigure| only.contains(&f.number.to_string().as_str());
        for figure in list::FIGURES.iter().filter(wanted) {
            page = with_section(&page, &section(&phex, figure)?);
        }
        return std::fs::write(&path, page).map_err(|e| format!("{}: {e}", path.display()));
    }
    let mut page = String::from(INTRODUCTION);
    for figure in &list::FIGURES {
        println!("== figure {}", figure.number);
        page += &section(&phex, figure)?;
    }
    println!("== table");
    page += TABLE;
    page += &table::table(&phex)?;
    std::fs::write(&path, page).map_err(|e| format!("{}: {e}", path.display()))
}

/// A page with one of its sections written anew.
fn with_section(page: &str, section: &str) -> String {
    let title = section.lines().next().unwrap_or_default();
    let Some(start) = page.find(&format!("{title}\n")) else {
        return page.to_owned();
    };
    let rest = &page[start + title.len()..];
    let end = rest.find("\n## ").map_or("", |at| &rest[at + 1..]);
    format!("{}{section}{end}", &page[..start])
}

const INTRODUCTION: &str = "# Gallery

Counterparts of the figures of W. Wang and Y. Liu, \"A note on planar hexagonal meshes\" (2010), and the methods that the paper reviews side by side with
ours. Everything here is made by `cargo xtask figures`, with the commands given (`cargo xtask obj` cuts and joins files between them); figures under the pictures are what the program measured. Planarity is the
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

fn section(phex: &Phex, figure: &GalleryFigure) -> Result<String, String> {
    let mut maker = Maker {
        phex,
        commands: Vec::new(),
        pictures: Vec::new(),
        figures: Vec::new(),
    };
    (figure.make)(&mut maker).map_err(|e| format!("figure {}: {e}", figure.number))?;
    if let Some(path) = steps::unmade_input(&maker.commands, &format!("{WORK}/")) {
        let number = figure.number;
        return Err(format!(
            "figure {number}: no command makes {path}, which one reads"
        ));
    }
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

#[cfg(test)]
mod tests {
    use super::with_section;

    #[test]
    fn one_section_of_a_page_is_written_anew() {
        let page = "# Gallery\n\n## Figure 1\n\nold\n\n## Figure 11\n\nkept\n";
        let new = with_section(page, "## Figure 1\n\nnew\n\n");
        assert_eq!(
            new,
            "# Gallery\n\n## Figure 1\n\nnew\n\n## Figure 11\n\nkept\n"
        );
        assert!(with_section(page, "## Figure 11\n\nnew\n").ends_with("Figure 11\n\nnew\n"));
    }
}
