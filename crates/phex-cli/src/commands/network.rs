//! `phex network`: writes a conjugate curve network.

use super::{tell, use_threads};
use crate::args::NetworkCommand;
use crate::exit::{Exit, Failure};
use crate::output::{check_writable, write_text};
use crate::progress::Reporter;
use crate::summary::SummaryTable;
use phex::MeshOptions;
use phex::directions::{Conjugacy, Curve, NetworkFamily};
use phex::pipeline::NetworkCurves;
use phex_job::TypedPanelSize;
use phex_job::Unit;
use phex_job::{Content, MeshFile};
use std::fmt::Write;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If the input can't be used, the surface has no network, or the output can't be written.
pub fn run(command: &NetworkCommand) -> Result<Exit, Failure> {
    check_writable(
        &[(&command.output, Content::Mesh)],
        &[command.input.as_path()],
    )?;
    check_obj(&command.output)?;
    use_threads(command.threads)?;
    let reporter = Reporter::new(&command.talk);
    let parts = MeshFile::read(&command.input)?.surfaces()?;
    let surface = parts.whole();
    for note in parts.notes.sentences() {
        reporter.note(note);
    }
    let size = TypedPanelSize::Panels(command.panels);
    let panels = phex_job::panels(size, &surface, Unit::default())?;
    let curves = phex_job::network(&surface, &options(command, panels), &reporter)?;
    reporter.finish();
    write_text(&command.output, &obj(&curves))?;
    tell(command.talk.quiet, &told(&curves, &command.output))?;
    Ok(Exit::Success)
}

fn told(curves: &NetworkCurves, path: &Path) -> String {
    let mut table = SummaryTable::default();
    let (rows, columns) = (curves.rows.len(), curves.columns.len());
    table.row("curves", format!("{rows} along rows, {columns} across"));
    match &curves.conjugacy {
        Some(Conjugacy {
            median,
            p95,
            worst,
            place,
        }) => {
            let [x, y, z] = [place.x, place.y, place.z];
            let text = format!(
                "|II(a, b)| / |II| of rows a and columns b: median {median:.1e}, 95 % below {p95:.1e}, worst {worst:.1e} near ({x:.4}, {y:.4}, {z:.4})"
            );
            table.row("conjugate", text);
        }
        None => table.row("conjugate", "everywhere, since the surface is flat"),
    }
    table.row("written", path.display());
    table.into_text()
}

/// Whether a path names an OBJ file, the only format for curves.
///
/// # Errors
/// If not.
pub(super) fn check_obj(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().and_then(|e| e.to_str());
    if extension.is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{}: curves are written as OBJ only",
        path.display()
    )))
}

fn options(command: &NetworkCommand, panels: u64) -> MeshOptions {
    let mut options = MeshOptions {
        size: phex::PanelSize::Panels(usize::try_from(panels).unwrap_or(usize::MAX)),
        ..Default::default()
    };
    if let Some(axis) = command.columns_along {
        options.brick_wall.network.family = NetworkFamily::ConjugateTo(axis);
    }
    options
}

/// Polylines as OBJ: two groups with `l` elements; a closed curve ends with its first vertex.
fn obj(curves: &NetworkCurves) -> String {
    let mut text = String::from("# conjugate curve network\n");
    let mut next = 1;
    for (name, family) in [("rows", &curves.rows), ("columns", &curves.columns)] {
        let _ = writeln!(text, "g {name}");
        for curve in family {
            push_curve(&mut text, curve, next);
            next += curve.points.len();
        }
    }
    text
}

/// Appends a polyline whose first vertex has number `first`.
pub(super) fn push_curve(text: &mut String, curve: &Curve, first: usize) {
    for p in &curve.points {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    let numbers = (first..first + curve.points.len()).chain(curve.closed.then_some(first));
    text.push('l');
    for number in numbers {
        let _ = write!(text, " {number}");
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn a_closed_curve_returns_to_its_first_vertex() {
        let curve = |closed| Curve {
            points: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            closed,
        };
        let text = obj(&NetworkCurves {
            rows: vec![curve(true)],
            columns: vec![curve(false)],
            conjugacy: None,
        });
        let lines: Vec<&str> = text.lines().filter(|l| l.starts_with(['l', 'g'])).collect();
        assert_eq!(lines, ["g rows", "l 1 2 3 1", "g columns", "l 4 5 6"]);
    }
}
