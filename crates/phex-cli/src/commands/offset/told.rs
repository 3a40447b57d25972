//! What `phex offset` says: the short table, and the report.

use super::OffsetJob;
use super::base::{Base, Motion, MovedVertices, OffsetLayer, Turned};
use super::files::OffsetFile;
use crate::summary::SummaryTable;
use phex::offset::{SafeDistance, SafeDistances, rounded_down};
use phex_mesh::Violation;
use serde_json::{Value, json};

/// Everything that there is to tell.
pub(super) struct Told<'a> {
    pub job: &'a OffsetJob<'a>,
    pub base: &'a Base,
    pub safe: Option<&'a SafeDistances>,
    pub layers: &'a [OffsetLayer],
    pub contents: &'a [OffsetFile],
}

impl Told<'_> {
    /// The report, as JSON.
    pub fn report(&self) -> Value {
        let (job, base) = (self.job, self.base);
        let sides =
            |s: &SafeDistances| json!({ "outward": side(&s.outward), "inward": side(&s.inward) });
        let layers = self.layers.iter().map(|l| {
            json!({
                "distance": l.distance,
                "distance_error": l.distance_error,
                "planarity": l.planarity,
                "mean_edge": l.mean_edge,
                "turned": l.turned,
            })
        });
        json!({
            "schema_version": phex::report::SCHEMA_VERSION,
            "tool": phex::report::Tool::default(),
            "command": "offset",
            "input": job.command.input.display().to_string(),
            "unit": job.command.unit,
            "kind": base.motion.image().kind,
            "settings": { "offset": job.options, "gap": job.gap },
            "angle_condition": base.optimised.as_ref().map(|made| json!({
                "defect_before": made.result.angle_defect[0],
                "defect_after": made.result.angle_defect[1],
                "closing_before": made.result.closing_defect[0],
                "closing_after": made.result.closing_defect[1],
                "moved": made.moved,
                "deviation": made.deviation,
                "max_deviation": made.limit,
                "within_deviation": made.keeps_to_surface(),
                "tight_panels": made.result.offenders,
            })),
            "gauss_image": gauss_image(base),
            "inherited": base.inheritance.violations,
            "safe_distances": self.safe.map(sides),
            "layers": layers.collect::<Vec<_>>(),
            "outputs": self.contents.iter().map(OffsetFile::record).collect::<Vec<_>>(),
        })
    }

    /// The short table.
    pub fn summary(&self) -> String {
        let mut table = SummaryTable::default();
        let (base, unit) = (self.base, self.job.command.unit);
        let panels = base.mesh.topology().n_faces();
        let edge = base.mesh.mean_edge();
        let keeps = match &base.motion {
            Motion::Face(..) => "faces",
            Motion::Edge(found) if !found.free_edges.is_empty() => "inner edges",
            Motion::Edge(_) => "edges",
            Motion::Vertex(_) => "vertices",
        };
        table.row(
            "mesh",
            format!("{panels} panels, mean edge {edge:.4} {unit}; {keeps} keep their distance"),
        );
        if let Some(made) = &base.optimised {
            self.add_optimised(&mut table, made);
        }
        table.row("gauss image", certainty(&base.motion));
        self.add_safe(&mut table);
        for layer in self.layers {
            let text = format!(
                "{:+} {unit}: distances to {:.1e} {unit}, planar to {:.1e} mean edges, mean edge {:.4} {unit}",
                layer.distance, layer.distance_error, layer.planarity, layer.mean_edge
            );
            table.row("layer", text);
        }
        if let Some(text) = self.turned() {
            table.row("rim", text);
        }
        for volume in self.contents.iter().filter_map(OffsetFile::volume) {
            table.row(
                "solids",
                format!(
                    "{panels} closed panels, volume {}",
                    unit.told_volume(volume)
                ),
            );
        }
        if let Some(text) = inherited(&base.inheritance.violations) {
            table.row("INHERITED", text);
        }
        for content in self.contents {
            table.row("written", content.path().display());
        }
        if let Some(path) = &self.job.command.report {
            table.row("written", path.display());
        }
        table.into_text()
    }

    fn add_optimised(&self, table: &mut SummaryTable, made: &MovedVertices) {
        let (unit, edge) = (self.job.command.unit, self.base.mesh.mean_edge());
        let [before, after] = made.result.angle_defect;
        let text = format!(
            "condition {before:.1e} -> {after:.1e} rad; vertices moved by up to {:.3e} {unit} ({:.2} mean edges)",
            made.moved,
            made.moved / edge
        );
        table.row("angles", text);
        let (name, advice) = if made.keeps_to_surface() {
            ("deviation", "")
        } else {
            ("OUTSIDE", ": smaller panels stay closer")
        };
        let percent = |length: f64| 100.0 * length / made.diagonal;
        let text = format!(
            "{:.3e} {unit} from the {}, {:.3} % of the diagonal; limit {:.3e} {unit}, {:.3} %{advice}",
            made.deviation,
            made.reference,
            percent(made.deviation),
            made.limit,
            percent(made.limit)
        );
        table.row(name, text);
        if !made.result.offenders.is_empty() {
            let (n, least) = (made.result.offenders.len(), made.result.quality.clearance);
            table.row(
                "TIGHT",
                format!("{n} panels have little clearance, at least {least:.3} mean edges"),
            );
        }
    }

    /// Edges at the boundary that are not parallel to those of the mesh, and where they turn most.
    fn turned(&self) -> Option<String> {
        let edges = self.base.turned.len();
        let worse = |a: Turned, b: Turned| if b.angle > a.angle { b } else { a };
        let layers = self.layers.iter().map(|l| l.turned);
        let worst = layers.reduce(worse).unwrap_or_default();
        let most = worst.edge.map(|edge| {
            let degrees = worst.angle.to_degrees();
            format!(", in these layers by up to {degrees:.2} degrees (edge {edge})")
        });
        let all = self.base.mesh.topology();
        let all = all.boundary_edges().count();
        (edges > 0).then(|| {
            format!(
                "{edges} of {all} boundary edges turn in the planes of their panels{}; all others stay parallel",
                most.unwrap_or_default()
            )
        })
    }

    fn add_safe(&self, table: &mut SummaryTable) {
        let unit = self.job.command.unit;
        let Some(safe) = self.safe else { return };
        for (name, side) in [("outward", &safe.outward), ("inward", &safe.inward)] {
            let limit = side.limit.as_ref();
            let then = limit.map_or(String::new(), |v| format!("; then {v}"));
            let text = if side.distance.is_finite() {
                format!("up to {} {unit} {name}{then}", rounded_down(side.distance))
            } else {
                format!("any distance {name}")
            };
            table.row("safe", text);
        }
    }
}

fn side(safe: &SafeDistance) -> Value {
    json!({
        "distance": if safe.distance.is_finite() { json!(safe.distance) } else { Value::Null },
        "limit": safe.limit,
    })
}

fn gauss_image(base: &Base) -> Value {
    let mut value = motion(&base.motion);
    value["turned_edges"] = json!(base.turned);
    value
}

fn motion(motion: &Motion) -> Value {
    match motion {
        Motion::Face(_, (vertex, error)) => {
            json!({ "error_estimate": error, "worst_vertex": vertex })
        }
        Motion::Edge(found) => json!({
            "closing_defect": found.defect,
            "worst_edge": found.edge,
            "facing": found.facing,
            "free_edges": found.free_edges,
        }),
        Motion::Vertex(found) => json!({
            "holonomy": found.holonomy,
            "facing": found.facing,
            "free_edges": found.free_edges,
        }),
    }
}

fn certainty(motion: &Motion) -> String {
    match motion {
        Motion::Face(_, (vertex, error)) => {
            format!("node normals certain to {error:.1e}, least so at vertex {vertex}")
        }
        Motion::Edge(found) => {
            let edges = match found.free_edges.len() {
                0 => "edges touch the sphere".to_owned(),
                free => format!(
                    "inner edges touch the sphere, {free} at the boundary have no distance of their own"
                ),
            };
            format!(
                "{edges}; from both ends to {:.1e}; cosine to the normals at least {:.3}",
                found.defect, found.facing
            )
        }
        Motion::Vertex(found) => format!(
            "closes to {:.1e} (loops {}, odd faces inside {}); cosine to the normals at least {:.3}",
            found.holonomy.defect, found.holonomy.loops, found.holonomy.odd_faces, found.facing
        ),
    }
}

/// What the layers have from the mesh.
fn inherited(violations: &[Violation]) -> Option<String> {
    let first = violations.first()?;
    let more = match violations.len() - 1 {
        0 => String::new(),
        n => format!(" (and {n} more)"),
    };
    let decisive = violations.iter().find(|v| v.is_decisive());
    let (are, first) = decisive.map_or(("outside a tolerance", first), |v| ("invalid", v));
    Some(format!(
        "the mesh itself is {are}, and so are its layers: {first}{more}"
    ))
}
