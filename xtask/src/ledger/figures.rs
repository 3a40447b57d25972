//! The figures of a row: where each stands in the report, which way is better, and by how much it
//! may differ by chance.

use super::entries::{Entry, Figures};
use serde_json::Value;
use wait4::ResUse;

/// Which way a figure is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Small ones.
    Low,
    /// Large ones.
    High,
    /// Neither: it describes.
    Neither,
}

/// One figure.
pub struct Figure {
    /// Name in the ledger.
    pub name: &'static str,
    /// Heading of its column.
    pub heading: &'static str,
    /// What it is, with its unit.
    pub meaning: &'static str,
    /// Which way is better.
    pub better: Better,
    /// Difference that counts as the same, over the figure before.
    pub relative: f64,
    /// Difference that counts as the same, in the figure's unit; the larger of the two holds.
    pub absolute: f64,
    /// Whether it is a cost, which depends on how the program was built.
    pub cost: bool,
    /// Digits behind the point in tables.
    pub digits: usize,
    /// Reads it from a run report.
    read: fn(&Value) -> Option<f64>,
}

use Better::{High, Low, Neither};

const fn figure(
    name: &'static str,
    heading: &'static str,
    meaning: &'static str,
    better: Better,
    (relative, absolute): (f64, f64),
    digits: usize,
    read: fn(&Value) -> Option<f64>,
) -> Figure {
    Figure {
        name,
        heading,
        meaning,
        better,
        relative,
        absolute,
        cost: false,
        digits,
        read,
    }
}

const fn cost(figure: Figure) -> Figure {
    Figure {
        cost: true,
        ..figure
    }
}

/// All figures, in the order of the columns.
pub const FIGURES: [Figure; 23] = [
    figure("panels", "panels", "panels", Neither, (0.0, 0.0), 0, |r| {
        at(r, "/measures/faces")
    }),
    figure(
        "hexagons",
        "hex",
        "share of hexagons among inner panels",
        High,
        (0.0, 0.01),
        3,
        |r| at(r, "/measures/hex"),
    ),
    figure(
        "irregular",
        "irr",
        "inner panels that are irregular without need",
        Low,
        (0.25, 3.0),
        0,
        |r| at(r, "/measures/irregular"),
    ),
    figure(
        "planarity",
        "planar",
        "largest distance of a corner to its panel's plane, mean edges",
        Low,
        (0.0, 1e-12),
        15,
        |r| at(r, "/measures/planarity/max"),
    ),
    figure(
        "clearance",
        "clear",
        "least distance of a corner to an edge of its panel, mean edges",
        High,
        (0.15, 0.02),
        3,
        |r| at(r, "/measures/clearance/min"),
    ),
    figure(
        "angle",
        "angle",
        "least angle of a panel, degrees",
        High,
        (0.15, 3.0),
        1,
        |r| at(r, "/measures/angle/min"),
    ),
    figure(
        "deviation",
        "dev",
        "largest distance of a panel to the smooth target, % of the diagonal",
        Low,
        (0.15, 0.01),
        3,
        |r| percent(r, "/deviation_smooth/deviation_max"),
    ),
    figure(
        "facets",
        "facets",
        "largest distance of a panel to the given facets, % of the diagonal",
        Low,
        (0.15, 0.01),
        3,
        |r| percent(r, "/deviation_facets/deviation_max"),
    ),
    figure(
        "coverage",
        "cover",
        "largest distance of the inner surface to the panels, % of the diagonal",
        Low,
        (0.15, 0.01),
        3,
        |r| percent(r, "/deviation_smooth/coverage_inner_max"),
    ),
    figure(
        "covered",
        "area",
        "share of the surface's area that is covered, %",
        High,
        (0.0, 0.3),
        2,
        |r| percent(r, "/boundary/covered_area"),
    ),
    figure(
        "boundary",
        "bound",
        "distance of the two boundaries, % of the diagonal",
        Low,
        (0.2, 0.03),
        3,
        boundary,
    ),
    figure(
        "smallest",
        "least",
        "smallest panel over the mean area",
        High,
        (0.2, 0.03),
        2,
        |r| Some(at(r, "/measures/face_area/min")? / at(r, "/measures/face_area/mean")?),
    ),
    figure(
        "largest",
        "most",
        "largest panel over the mean area",
        Low,
        (0.2, 0.1),
        2,
        |r| Some(at(r, "/measures/face_area/max")? / at(r, "/measures/face_area/mean")?),
    ),
    figure(
        "spread",
        "p95/p5",
        "95 % over 5 % quantile of the inner panels' areas over the wished ones",
        Low,
        (0.08, 0.05),
        2,
        |r| {
            at(r, "/measures/evenness/over_wished/spread")
                .or_else(|| at(r, "/measures/evenness/area_spread"))
        },
    ),
    figure(
        "longest",
        "long",
        "longest edge of inner panels over their mean edge",
        Low,
        (0.15, 0.1),
        2,
        |r| at(r, "/measures/evenness/longest_edge"),
    ),
    figure(
        "aspect",
        "aspect",
        "95 % quantile of the inner panels' length over width",
        Low,
        (0.1, 0.05),
        2,
        |r| at(r, "/measures/evenness/aspect_p95"),
    ),
    figure(
        "edge",
        "edge",
        "mean edge, model units",
        Neither,
        (0.0, 0.0),
        4,
        |r| at(r, "/measures/mean_edge"),
    ),
    figure(
        "changes",
        "changes",
        "local changes of the search that were kept",
        Neither,
        (0.0, 0.0),
        0,
        |r| sum(r, |s| s.pointer("/search/kept")?.as_f64()),
    ),
    figure(
        "attempts",
        "tries",
        "ways of the portfolio that were tried",
        Neither,
        (0.0, 0.0),
        0,
        |r| sum(r, |s| Some(s.pointer("/tried")?.as_array()?.len() as f64)),
    ),
    cost(figure(
        "factorisations",
        "fact",
        "factorisations of the optimiser",
        Low,
        (0.25, 10.0),
        0,
        |r| sum(r, |s| s.pointer("/factorisations")?.as_f64()),
    )),
    cost(figure(
        "cpu",
        "cpu",
        "CPU time over that of the reference computation",
        Low,
        (0.3, 1.0),
        1,
        |_| None,
    )),
    cost(figure(
        "seconds",
        "s",
        "CPU seconds, for orientation",
        Neither,
        (0.0, 0.0),
        1,
        |_| None,
    )),
    cost(figure(
        "memory",
        "MB",
        "largest memory, megabytes",
        Low,
        (0.25, 30.0),
        0,
        |_| None,
    )),
];

fn at(report: &Value, pointer: &str) -> Option<f64> {
    report.pointer(pointer)?.as_f64()
}

fn percent(report: &Value, pointer: &str) -> Option<f64> {
    at(report, pointer).map(|share| 100.0 * share)
}

fn boundary(report: &Value) -> Option<f64> {
    let to = percent(report, "/boundary/to_curve_max")?;
    Some(to.max(percent(report, "/boundary/from_curve_max")?))
}

/// Sums over the components of a surface.
fn sum(report: &Value, of: impl Fn(&Value) -> Option<f64>) -> Option<f64> {
    report
        .pointer("/statistics")?
        .as_array()?
        .iter()
        .map(of)
        .sum()
}

/// The figures of a run report.
pub fn of_report(report: &Value) -> Figures {
    let read = |f: &Figure| Some((f.name.to_owned(), (f.read)(report)?));
    FIGURES.iter().filter_map(read).collect()
}

/// What a row cost, and what the reference computation took beside it.
pub fn of_cost(used: &ResUse, reference: &ResUse) -> Figures {
    let cpu = |used: &ResUse| (used.rusage.utime + used.rusage.stime).as_secs_f64();
    let figures = [
        ("cpu", cpu(used) / cpu(reference)),
        ("seconds", cpu(used)),
        ("memory", used.rusage.maxrss as f64 / 1e6),
    ];
    figures.map(|(name, value)| (name.to_owned(), value)).into()
}

/// The verdict of a run report.
pub fn verdict(report: &Value) -> Option<String> {
    Some(report.pointer("/verdict")?.as_str()?.to_owned())
}

/// Names of the checks that fail.
pub fn failed(report: &Value) -> Vec<String> {
    let checks = report.pointer("/checks").and_then(Value::as_array);
    let fails = |check: &&Value| check["pass"] == Value::Bool(false);
    let name = |check: &Value| check["name"].as_str().unwrap_or("?").to_owned();
    checks
        .into_iter()
        .flatten()
        .filter(fails)
        .map(name)
        .collect()
}

/// Which figures are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureScope {
    /// All.
    All,
    /// All but times, counts of steps and memory.
    WithoutCost,
}

/// How a row changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FigureChange {
    /// What became better.
    pub better: Vec<String>,
    /// What became worse.
    pub worse: Vec<String>,
}

impl FigureChange {
    /// Whether anything became worse.
    pub fn is_worse(&self) -> bool {
        !self.worse.is_empty()
    }
}

/// Compares a row with the same row before.
pub fn compare(before: &Entry, now: &Entry, scope: FigureScope) -> FigureChange {
    let mut change = FigureChange::default();
    let (old, new) = (severity(before), severity(now));
    let verdicts = format!("{} -> {}", outcome(before), outcome(now));
    match new.cmp(&old) {
        std::cmp::Ordering::Less => change.better.push(verdicts),
        std::cmp::Ordering::Greater => change.worse.push(verdicts),
        std::cmp::Ordering::Equal => {}
    }
    for figure in &FIGURES {
        if scope == FigureScope::WithoutCost && figure.cost {
            continue;
        }
        let values = (
            before.figures.get(figure.name),
            now.figures.get(figure.name),
        );
        let (Some(&old), Some(&new)) = values else {
            continue;
        };
        let gain = match figure.better {
            Low => old - new,
            High => new - old,
            Neither => continue,
        };
        // A plain comparison would call NaN the same.
        let same = gain.abs() <= (figure.relative * old.abs()).max(figure.absolute);
        if same {
            continue;
        }
        let digits = figure.digits;
        let text = format!("{} {old:.digits$} -> {new:.digits$}", figure.heading);
        match gain > 0.0 {
            true => change.better.push(text),
            false => change.worse.push(text),
        }
    }
    change
}

fn outcome(entry: &Entry) -> String {
    match entry.failed[..] {
        [] => format!("{} ({})", entry.verdict, entry.exit_code),
        _ => format!(
            "{} ({}: {})",
            entry.verdict,
            entry.exit_code,
            entry.failed.join(", ")
        ),
    }
}

/// How bad an ending is, by its exit code.
fn severity(entry: &Entry) -> usize {
    const ORDER: [i32; 3] = [0, 3, 5];
    let known = ORDER.iter().position(|code| *code == entry.exit_code);
    known.unwrap_or(ORDER.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(exit_code: i32, figures: &[(&str, f64)]) -> Entry {
        let figures = figures.iter().map(|(name, x)| ((*name).to_owned(), *x));
        Entry {
            name: "row".to_owned(),
            options: String::new(),
            verdict: String::new(),
            failed: Vec::new(),
            exit_code,
            figures: figures.collect(),
        }
    }

    #[test]
    fn every_figure_has_its_direction_and_its_tolerance() {
        for figure in FIGURES.iter().filter(|f| f.better != Neither) {
            let old = 2.0;
            let step = 1.01 * (figure.relative * old).max(figure.absolute);
            let up = entry(0, &[(figure.name, old + step)]);
            let before = entry(0, &[(figure.name, old)]);
            let change = compare(&before, &up, FigureScope::All);
            assert_eq!(change.is_worse(), figure.better == Low, "{}", figure.name);
            assert_eq!(change.better.len(), usize::from(figure.better == High));
            let within = entry(0, &[(figure.name, old + 0.9 * step)]);
            assert_eq!(
                compare(&before, &within, FigureScope::All),
                FigureChange::default()
            );
        }
    }

    #[test]
    fn endings_are_ordered_and_costs_left_out_where_asked() {
        let order = [0, 3, 5, 1, -1];
        let codes = order.map(|code| severity(&entry(code, &[])));
        assert!(codes.windows(2).all(|w| w[0] <= w[1]), "{codes:?}");
        assert!(compare(&entry(0, &[]), &entry(3, &[]), FigureScope::All).is_worse());
        assert!(!compare(&entry(5, &[]), &entry(3, &[]), FigureScope::All).is_worse());
        let (fast, slow) = (entry(0, &[("cpu", 10.0)]), entry(0, &[("cpu", 99.0)]));
        assert!(compare(&fast, &slow, FigureScope::All).is_worse());
        assert!(!compare(&fast, &slow, FigureScope::WithoutCost).is_worse());
    }

    #[test]
    fn not_a_number_is_worse() {
        let (old, new) = (
            entry(0, &[("hexagons", 0.9)]),
            entry(0, &[("hexagons", f64::NAN)]),
        );
        assert!(compare(&old, &new, FigureScope::All).is_worse());
    }
}
