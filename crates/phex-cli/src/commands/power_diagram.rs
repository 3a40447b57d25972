//! `phex power-diagram`: polyhedra from sites in the plane, on spheres and ellipsoids.

use super::deliver::{Delivery, judged, outputs};
use crate::dual_arguments::PowerCommand;
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::output::{check_writable, given};
use crate::summary::SummaryTable;
use anyhow::Context;
use nalgebra::Matrix3x4;
use phex::classical::{PowerDiagram, PowerSite, goldberg, power_diagram};
use phex::report::InputFile;
use phex_job::TypedLimits;
use phex_job::{NumberLine, read_numbers, sha256};
use phex_mesh::{HexMesh, Vec2};
use serde_json::json;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If the sites can't be used, or the output can't be written.
pub fn run(command: &PowerCommand) -> Result<Exit, Failure> {
    check_writable(
        &outputs(&command.output, &command.extras),
        &given([command.sites.as_ref()]),
    )?;
    if let Some(axis) = command.axes.iter().find(|a| **a <= 0.0) {
        return Err(Failure::input(format!(
            "a semi-axis is {axis}, it must be positive"
        )));
    }
    let diagram = diagram(command)?;
    let mesh = placed(&diagram.mesh, &map(command))?;
    let mut table = SummaryTable::default();
    if !diagram.hidden.is_empty() {
        let first = diagram.hidden.iter().take(10).map(ToString::to_string);
        let first: Vec<String> = first.collect();
        let count = diagram.hidden.len();
        table.row(
            "hidden",
            format!("{count} sites have no cell: {}", first.join(" ")),
        );
    }
    let shown = Shown::of(&mesh);
    let limits = TypedLimits::default();
    let mut report = judged("power-diagram", &shown, &limits);
    report.settings = json!({ "goldberg": command.goldberg, "cap": command.cap, "axes": command.axes, "affine": command.affine });
    report.statistics = json!({ "hidden": diagram.hidden });
    let sites = command.sites.iter().map(|path| record(path));
    report.inputs = sites.collect::<Result<_, _>>()?;
    Delivery {
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        after: table.into_text(),
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
}

/// The affine map of the sphere.
fn map(command: &PowerCommand) -> Matrix3x4<f64> {
    let [a, b, c] = command.axes;
    let axes = || Matrix3x4::new(a, 0.0, 0.0, 0.0, 0.0, b, 0.0, 0.0, 0.0, 0.0, c, 0.0);
    command
        .affine
        .map_or_else(axes, |m| Matrix3x4::from_row_slice(&m))
}

/// The image of a mesh on the unit sphere, its faces turned round if the map reflects.
fn placed(mesh: &HexMesh, map: &Matrix3x4<f64>) -> Result<HexMesh, Failure> {
    let linear = map.fixed_columns::<3>(0).into_owned();
    let determinant = linear.determinant();
    if determinant.abs() <= 1e-12 * linear.norm().powi(3) {
        let message = format!(
            "the affine map is singular (determinant {determinant:.1e}): the ellipsoid would be flat"
        );
        return Err(Failure::input(message));
    }
    let positions = mesh.positions.map(|p| map * p.push(1.0));
    let image = mesh.with_positions(positions);
    Ok(match determinant > 0.0 {
        true => image,
        false => image.turned_over(),
    })
}

fn diagram(command: &PowerCommand) -> Result<PowerDiagram, Failure> {
    match (&command.sites, command.goldberg) {
        (Some(path), _) => {
            let sites = read_sites(path)?;
            power_diagram(&sites, command.cap)
                .with_context(|| path.display().to_string())
                .or_exit(Exit::InputUnusable)
        }
        (None, Some([m, n])) => goldberg(m, n).or_exit(Exit::InputUnusable),
        (None, None) => Err(Failure::input("give --goldberg M,N or --sites FILE")),
    }
}

/// What the report says about the file of the sites.
fn record(path: &Path) -> Result<InputFile, Failure> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).with_context(|| name.clone());
    Ok(InputFile {
        sha256: sha256(bytes.or_exit(Exit::InputUnusable)?),
        path: name,
        vertices: read_numbers(path)?.len(),
        faces: 0,
    })
}

fn read_sites(path: &Path) -> Result<Vec<PowerSite>, Failure> {
    let site = |line: &NumberLine| match line.numbers[..] {
        [x, y] => Ok((x, y, 0.0)),
        [x, y, weight] => Ok((x, y, weight)),
        _ => Err(Failure::from(line.wrong("a site `x y` or `x y weight`"))),
    };
    let sites = read_numbers(path)?;
    let placed = sites.iter().map(site).map(|s| {
        s.map(|(x, y, weight)| PowerSite {
            position: Vec2::new(x, y),
            weight,
        })
    });
    placed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::{FlatFace, measure};

    #[test]
    fn affine_maps_keep_panels_planar_and_turned_outwards() {
        let sphere = goldberg(2, 1).unwrap().mesh;
        for sign in [1.0, -1.0] {
            let map = Matrix3x4::new(
                sign, 0.3, 0.0, 5.0, 0.0, 2.0, -0.4, 0.0, 0.1, 0.0, 0.7, -1.0,
            );
            let mesh = placed(&sphere, &map).ok().unwrap();
            assert!(measure(&mesh).planarity.max < 1e-13);
            let centre = map.column(3).into_owned();
            let outwards = |f| {
                FlatFace::of(&mesh, f)
                    .normal()
                    .dot(&(mesh.centre(f) - centre))
                    > 0.0
            };
            assert!(mesh.topology().faces().all(outwards));
        }
        assert!(placed(&sphere, &Matrix3x4::zeros()).is_err());
    }

    #[test]
    fn sites_with_and_without_weight() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sites.txt");
        let sites = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_sites(&path).map(|all| {
                let at = |s: &PowerSite| (s.position.x, s.position.y, s.weight);
                all.iter().map(at).collect::<Vec<_>>()
            })
        };
        let both = sites("# two\n1 -2\n\n 1,2, 0.5 \n").unwrap();
        assert_eq!(both, [(1.0, -2.0, 0.0), (1.0, 2.0, 0.5)]);
        for wrong in ["1", "a b", "1 inf", "1 2 3 4"] {
            let message = sites(&format!("0 0\n{wrong}\n")).unwrap_err().to_string();
            assert!(message.contains("sites.txt:2"), "{message}");
        }
    }
}
