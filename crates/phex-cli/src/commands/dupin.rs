//! `phex dupin`: Dupin's indicatrices of a surface, for drawing.

use super::network::push_curve;
use super::tell;
use crate::dual_arguments::DupinCommand;
use crate::exit::{Exit, Failure};
use crate::output::{check_writable, given, write_text};
use crate::progress::Reporter;
use phex::curvature::{
    CurvatureOptions, Indicatrix, inscribing_curves, principal, tensors_at_points,
};
use phex::directions::Curve;
use phex::layout::CELL;
use phex_job::{Content, MeshFile};
use phex_mesh::{FaceId, SurfacePoint, Topology, TriangleSurface, Vec3, VertexId};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Size of curves over their distance at the most: larger ones are nothing to be seen.
const LARGEST_SIZE: f64 = 1e6;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, or the output can't be written.
pub fn run(command: &DupinCommand) -> Result<Exit, Failure> {
    let inputs = given([Some(&command.input), command.panels.as_ref()]);
    check_writable(&[(&command.output, Content::Mesh)], &inputs)?;
    super::network::check_obj(&command.output)?;
    if !(command.size > 0.0 && command.size <= LARGEST_SIZE) || command.points == 0 {
        return Err(Failure::new(
            Exit::Usage,
            format!(
                "size and number of points must be positive, and the size at most {LARGEST_SIZE}"
            ),
        ));
    }
    let reporter = Reporter::new(&command.talk);
    let parts = MeshFile::read(&command.input)?.surfaces()?;
    let surface = parts.whole();
    for note in parts.notes.sentences() {
        reporter.note(note);
    }
    let panels = panels(command)?;
    let centres = panels
        .iter()
        .map(|p| p.iter().sum::<Vec3>() / p.len() as f64);
    let points = if panels.is_empty() {
        points(command, &surface)
    } else {
        surface.closest_points(&centres.collect::<Vec<_>>())
    };
    let spacing = (surface.area() / (CELL * points.len() as f64)).sqrt();
    let length = spacing.min(0.1 * surface.diagonal());
    let tensors = tensors_at_points(&surface, &points, length, &CurvatureOptions::default());
    let at = |(p, tensor): (&SurfacePoint, &_)| Indicatrix {
        point: p.position,
        normal: p.normal,
        principal: principal(p.normal, tensor),
    };
    let indicatrices: Vec<Indicatrix> = points.iter().zip(&tensors).map(at).collect();
    let curves: Vec<Vec<Vec<Vec3>>> = if panels.is_empty() {
        indicatrices
            .iter()
            .map(|d| d.curves(command.size * length))
            .collect()
    } else {
        let pairs = panels.iter().zip(&indicatrices);
        pairs
            .map(|(corners, d)| inscribing_curves(corners, d))
            .collect()
    };
    write_text(&command.output, &obj(&indicatrices, curves))?;
    tell(command.talk.quiet, &table(&indicatrices, &command.output))?;
    Ok(Exit::Success)
}

/// Corners of the inner panels that are asked for, those with six of them at least.
fn panels(command: &DupinCommand) -> Result<Vec<Vec<Vec3>>, Failure> {
    let Some(path) = &command.panels else {
        return Ok(Vec::new());
    };
    let (mesh, _) = MeshFile::read(path)?.polygon_mesh()?;
    let t = mesh.topology();
    let all = |f: &FaceId| command.at.is_empty() && !t.is_boundary_face(*f) && t.valence(*f) >= 6;
    let mut chosen: Vec<FaceId> = t.faces().filter(all).collect();
    if command.apart {
        chosen = apart(t, &chosen);
    }
    for p in &command.at {
        let distance = |f: &FaceId| (mesh.centre(*f) - Vec3::from(*p)).norm();
        let nearest = t.faces().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        chosen.extend(nearest);
    }
    if chosen.is_empty() {
        return Err(Failure::input(format!(
            "{}: no inner panel has six corners",
            path.display()
        )));
    }
    Ok(chosen
        .into_iter()
        .map(|f| mesh.corners(f).collect())
        .collect())
}

/// Some of the panels, no two of which have a corner in common: of those that may still be taken
/// always the one next to most panels that may not, so that they lie close.
fn apart(t: &Topology, among: &[FaceId]) -> Vec<FaceId> {
    let around = |f: FaceId| -> BTreeSet<FaceId> {
        let corners = t.face_vertices(f).iter();
        let all = corners.flat_map(|v| t.faces_at(*v));
        all.filter(|g| *g != f).collect()
    };
    // How many panels round each open one may not be taken; the order is that of the choice.
    let mut closed: BTreeMap<FaceId, usize> = among.iter().map(|f| (*f, 0)).collect();
    let shut = |f: FaceId| around(f).iter().filter(|g| !closed.contains_key(g)).count();
    let counts: Vec<(FaceId, usize)> = among.iter().map(|f| (*f, shut(*f))).collect();
    closed.extend(counts);
    let mut order: BTreeSet<(usize, Reverse<FaceId>)> = (closed.iter())
        .map(|(f, count)| (*count, Reverse(*f)))
        .collect();
    let mut taken = Vec::new();
    while let Some(&(_, Reverse(next))) = order.last() {
        taken.push(next);
        for shut in around(next).into_iter().chain([next]) {
            let Some(count) = closed.remove(&shut) else {
                continue;
            };
            order.remove(&(count, Reverse(shut)));
            for f in around(shut) {
                if let Some(count) = closed.get_mut(&f) {
                    order.remove(&(*count, Reverse(f)));
                    *count += 1;
                    order.insert((*count, Reverse(f)));
                }
            }
        }
    }
    taken
}

fn points(command: &DupinCommand, surface: &TriangleSurface) -> Vec<SurfacePoint> {
    let given: Vec<Vec3> = command.at.iter().map(|p| Vec3::from(*p)).collect();
    if given.is_empty() {
        surface.closest_points(&spread(surface, command.points))
    } else {
        surface.closest_points(&given)
    }
}

/// Vertices far from each other: each is the one farthest from those before it.
fn spread(surface: &TriangleSurface, count: usize) -> Vec<Vec3> {
    let positions = surface.positions();
    let mut distance = vec![f64::INFINITY; positions.len()];
    let mut chosen = vec![positions[VertexId::new(0)]];
    while chosen.len() < count.min(positions.len()) {
        let last = chosen[chosen.len() - 1];
        for (d, p) in distance.iter_mut().zip(positions) {
            *d = d.min((p - last).norm());
        }
        let all = distance.iter().enumerate();
        let farthest = all.max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        chosen.extend(farthest.map(|(i, _)| positions.as_slice()[i]));
    }
    chosen
}

/// A group for each indicatrix, with its point, normal and curvatures as a comment.
fn obj(indicatrices: &[Indicatrix], curves: Vec<Vec<Vec<Vec3>>>) -> String {
    let mut text = String::from("# Dupin's indicatrices\n");
    let mut next = 1;
    for (i, (d, curves)) in indicatrices.iter().zip(curves).enumerate() {
        let (p, n, k) = (d.point, d.normal, &d.principal);
        let _ = writeln!(text, "g indicatrix-{i}");
        let _ = writeln!(
            text,
            "# point {} {} {} normal {} {} {} curvatures {} {}",
            p.x, p.y, p.z, n.x, n.y, n.z, k.small, k.large
        );
        for points in curves {
            let count = points.len();
            push_curve(
                &mut text,
                &Curve {
                    points,
                    closed: false,
                },
                next,
            );
            next += count;
        }
    }
    text
}

fn table(indicatrices: &[Indicatrix], path: &Path) -> String {
    let count = |test: &dyn Fn(f64, f64) -> bool| {
        let all = indicatrices
            .iter()
            .map(|d| (d.principal.small, d.principal.large));
        all.filter(|&(s, l)| test(s, l)).count()
    };
    let flat = |s: f64, l: f64| s.abs() <= 1e-3 * l.abs();
    let ellipses = count(&|s, l| s * l > 0.0 && !flat(s, l));
    let hyperbolas = count(&|s, l| s * l < 0.0 && !flat(s, l));
    let lines = indicatrices.len() - ellipses - hyperbolas;
    format!(
        "{}: {} indicatrices: {ellipses} ellipses, {hyperbolas} pairs of hyperbolas, {lines} pairs of lines or flat\n",
        path.display(),
        indicatrices.len()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex::classical::goldberg;

    /// The rule as it is told, with everything counted anew for each panel that is taken.
    #[test]
    fn panels_apart_are_those_of_the_rule() {
        let mesh = goldberg(5, 2).unwrap().mesh;
        let t = mesh.topology();
        let touch = |f: FaceId, g: FaceId| {
            let mut corners = t.face_vertices(f).iter();
            f != g && corners.any(|v| t.face_vertices(g).contains(v))
        };
        let hexagons: Vec<FaceId> = t.faces().filter(|f| t.valence(*f) == 6).collect();
        let (mut open, mut expected) = (hexagons.clone(), Vec::new());
        let closed = |open: &[FaceId], f: FaceId| {
            let around = t.faces().filter(|g| touch(f, *g));
            around.filter(|g| !open.contains(g)).count()
        };
        while let Some(next) =
            (open.iter().copied()).max_by_key(|f| (closed(&open, *f), Reverse(*f)))
        {
            expected.push(next);
            open.retain(|f| *f != next && !touch(next, *f));
        }
        assert_eq!(apart(t, &hexagons), expected);
    }
}
