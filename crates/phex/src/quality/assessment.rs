//! Measures, checks and verdict of a mesh.

use super::Limits;
use super::advice::with_advice;
use super::check::{Check, boundary_checks, surface_checks, validity_checks};
use super::panel_checks::panel_checks;
use crate::smooth_surface::teeth::{Calmed, LARGEST_TOOTH, without_teeth};
use phex_mesh::measure::{
    BoundaryFit, Deviation, MeshMeasures, boundary_fit, deviation_beyond, measure,
};
use phex_mesh::validate::{Violation, violations};
use phex_mesh::{FaceId, HexMesh, TriangleSurface, add_flips};
use rayon::join;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A check that was not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Omitted {
    /// Name of the check.
    pub name: &'static str,
    /// Why not.
    pub reason: Reason,
}

/// Why a check was not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// There is no surface to compare with.
    NoSurface,
    /// It is not known what the mesh is to keep to.
    NoLimit,
    /// The smooth surface that the mesh was fitted to is not at hand.
    NoSmoothSurface,
    /// Panels are left whole at the boundary and may stick out of it.
    LeftWhole,
    /// The boundary of panels is led elsewhere than along the surface's own.
    LedElsewhere,
}

/// The surfaces that a mesh stands for, in its coordinates.
#[derive(Clone, Copy, Default)]
pub struct References<'a> {
    /// The smooth surface through the input's vertices, which the optimiser looked at.
    pub smooth: Option<&'a TriangleSurface>,
    /// The input's facets.
    pub facets: Option<&'a TriangleSurface>,
    /// Both continued beyond the boundary, where panels may stick out: their distance is measured
    /// to these.
    pub beyond: Option<[&'a TriangleSurface; 2]>,
    /// Faces, in order, whose boundary is led elsewhere than along the surface's own, by a curve or
    /// a ground plane: there it is not compared with that, and no share of the area is asked for.
    pub elsewhere: &'a [FaceId],
    /// The number of panels that was asked for, which is the one to be changed where another is
    /// told to help; `None` changes the number that the mesh has.
    pub asked: Option<usize>,
}

impl<'a> References<'a> {
    /// Facets alone, or none.
    pub fn of_facets(facets: Option<&'a TriangleSurface>) -> Self {
        Self {
            facets,
            ..Self::default()
        }
    }

    /// Whether the boundary of a face is led elsewhere.
    pub(super) fn is_led(&self, face: FaceId) -> bool {
        self.elsewhere.binary_search(&face).is_ok()
    }

    /// The surface that the limits refer to: the smooth one where there is one.
    fn judge(&self) -> Option<&'a TriangleSurface> {
        self.smooth.or(self.facets)
    }

    /// The facets with the calm line that panels follow through teeth of their boundary, where they
    /// have some; a smooth surface has it.
    fn calm(&self, limits: &Limits) -> Option<Calmed> {
        let facets = self.facets.filter(|_| self.smooth.is_none())?;
        let most = LARGEST_TOOTH * limits.boundary_rel? * facets.diagonal();
        without_teeth(facets, most)
    }

    /// Whether the smooth surface and the facets are the same surface, and end where it ends.
    fn are_one(&self) -> bool {
        let same = |a: &TriangleSurface| self.facets.is_some_and(|b| a.is_clone_of(b));
        self.beyond.is_none() && self.smooth.is_some_and(same)
    }
}

/// What the checks amount to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every check holds.
    Pass,
    /// Panels are simple and lie side by side, but a figure, planarity included, is outside its
    /// limit.
    OutsideTolerance,
    /// No valid mesh.
    Invalid,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pass => "PASS",
            Self::OutsideTolerance => "OUTSIDE TOLERANCE",
            Self::Invalid => "INVALID",
        })
    }
}

/// Measures, deviations, violations, checks and verdict of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assessment {
    /// What the checks amount to.
    pub verdict: Verdict,
    /// Every check that was made.
    pub checks: Vec<Check>,
    /// Every check that was not.
    pub not_checked: Vec<Omitted>,
    /// Figures of the mesh.
    pub measures: MeshMeasures,
    /// Distance to the smooth target.
    pub deviation_smooth: Option<Deviation>,
    /// Distance to the original facets.
    pub deviation_facets: Option<Deviation>,
    /// How the mesh ends where the surface ends; `None` without a surface, or if one of the two is
    /// closed.
    pub boundary: Option<BoundaryFit>,
    /// How far teeth of the surface's boundary stand out of the calm line that the mesh's boundary
    /// was compared with instead, a length; `None` without teeth, or where a smooth surface, which
    /// has none, was compared with.
    #[serde(skip)]
    pub calmed: Option<f64>,
    /// Everything that is wrong, located.
    pub violations: Vec<Violation>,
}

impl Assessment {
    /// Judges a mesh.
    ///
    /// ```
    /// # use phex_mesh::{HexMesh, Vec3};
    /// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    /// # let faces = [
    /// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
    /// # ];
    /// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
    /// use phex::quality::{Assessment, Limits, References, Verdict};
    ///
    /// let found = Assessment::new(&cube, References::default(), &Limits::default());
    /// assert_eq!(found.verdict, Verdict::Pass);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(mesh: &HexMesh, references: References<'_>, limits: &Limits) -> Self {
        let found = || {
            let mut found = violations(mesh, references.judge(), &limits.validity);
            if let Some(facets) = references.facets {
                add_flips(&mut found, mesh, facets);
            }
            found
        };
        let away = |s: &TriangleSurface, k: usize| {
            let lengths = [mesh.mean_edge(), s.diagonal()];
            let bare_rim = |f| limits.bare_rim(lengths, references.is_led(f));
            let beyond = references.beyond.map_or(s, |b| b[k]);
            deviation_beyond(mesh, s, beyond, bare_rim)
        };
        let from_smooth = || references.smooth.map(|s| away(s, 0));
        let from_facets = || match references.are_one() {
            true => None,
            false => references.facets.map(|s| away(s, 1)),
        };
        let calm = references.calm(limits);
        let ends = || {
            let line = calm.as_ref().map(|calmed| &calmed.part.surface);
            line.or(references.judge())
                .and_then(|s| boundary_fit(mesh, s))
        };
        // What has to be found out at the end of a run, where nothing else is left to do.
        let ((measures, violations), ((deviation_smooth, from_facets), boundary)) = join(
            || join(|| measure(mesh), found),
            || join(|| join(from_smooth, from_facets), ends),
        );
        let deviation_facets = match references.are_one() {
            true => deviation_smooth.clone(),
            false => from_facets,
        };
        let checks = validity_checks(mesh, &measures, &violations, &limits.validity);
        let mut checks = with_advice(
            checks,
            mesh,
            (references.judge(), references.facets),
            limits,
            &violations,
        );
        let panels = references.asked.unwrap_or(mesh.topology().n_faces());
        checks.extend(panel_checks(mesh, &limits.panels, panels));
        let deviation = deviation_smooth.as_ref().or(deviation_facets.as_ref());
        if let (Some(deviation), Some(surface)) = (deviation, references.judge()) {
            checks.extend(surface_checks(mesh, surface, deviation, (limits, panels)));
            if let Some(fit) = &boundary {
                let elsewhere = references.elsewhere;
                let size = (panels, deviation.diagonal);
                checks.extend(boundary_checks(fit, size, limits, elsewhere));
            }
        }
        Self {
            verdict: verdict(&checks),
            checks,
            not_checked: omitted(&references, boundary.is_some(), limits),
            measures,
            deviation_smooth,
            deviation_facets,
            boundary,
            calmed: calm.map(|calmed| calmed.moved),
            violations,
        }
    }

    /// The deviation that the tolerance refers to, where there is a surface.
    pub fn judged_deviation(&self) -> Option<&Deviation> {
        self.deviation_smooth
            .as_ref()
            .or(self.deviation_facets.as_ref())
    }

    /// What the boundary of the mesh was compared with, where that of the surface has teeth.
    pub fn calm_line(&self) -> Option<String> {
        let share = 100.0 * self.calmed? / self.judged_deviation()?.diagonal;
        Some(format!(
            "the boundary has teeth: panels are compared with a calmer line, up to {share:.2} % of the diagonal off it"
        ))
    }

    /// The checks that do not hold.
    pub fn failures(&self) -> impl Iterator<Item = &Check> {
        self.checks.iter().filter(|c| !c.pass)
    }
}

/// The checks that a mesh is not put to; `ends` says whether mesh and surface both have a boundary.
fn omitted(references: &References<'_>, ends: bool, limits: &Limits) -> Vec<Omitted> {
    let no_limit = |name, without: bool| without.then_some((name, Reason::NoLimit));
    let apart = match limits.leaves_boundary() {
        true => Reason::LeftWhole,
        false => Reason::NoLimit,
    };
    let bare = match references.elsewhere {
        [] => limits.covered.is_none().then_some(Reason::NoLimit),
        _ => Some(Reason::LedElsewhere),
    };
    let named: Vec<(&'static str, Reason)> = match references.judge() {
        None => [
            "same_topology",
            "deviation",
            "coverage_inner",
            "boundary",
            "covered_area",
        ]
        .map(|name| (name, Reason::NoSurface))
        .to_vec(),
        Some(_) => [
            no_limit("deviation", limits.deviation_rel.is_none()),
            no_limit("coverage_inner", limits.deviation_rel.is_none()),
            (ends && limits.boundary_rel.is_none()).then_some(("boundary", apart)),
            bare.filter(|_| ends).map(|reason| ("covered_area", reason)),
        ]
        .into_iter()
        .flatten()
        .collect(),
    };
    let omitted = named.into_iter();
    omitted
        .map(|(name, reason)| Omitted { name, reason })
        .collect()
}

fn verdict(checks: &[Check]) -> Verdict {
    let of = |check: &Check| match (check.pass, check.decisive) {
        (true, _) => Verdict::Pass,
        (false, false) => Verdict::OutsideTolerance,
        (false, true) => Verdict::Invalid,
    };
    checks.iter().map(of).max().unwrap_or(Verdict::Pass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::Boundary;
    use phex_mesh::Vec3;

    /// Three panels round one vertex; `lift` raises a corner of the first out of its plane, `slide`
    /// moves it along.
    fn three_panels(lift: f64, slide: f64) -> HexMesh {
        let mut positions = vec![Vec3::zeros()];
        for k in 0..6 {
            let a = std::f64::consts::FRAC_PI_3 * k as f64;
            positions.push(Vec3::new(a.cos(), a.sin(), 0.0));
        }
        positions[2] += Vec3::new(-slide, -slide, lift);
        HexMesh::new(positions, &[[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 1]]).unwrap()
    }

    fn failing(a: &Assessment) -> Vec<&str> {
        a.failures().map(|c| c.name).collect()
    }

    #[test]
    fn flat_panels_pass() {
        let a = Assessment::new(
            &three_panels(0.0, 0.0),
            References::default(),
            &Limits::default(),
        );
        assert_eq!((a.verdict, failing(&a)), (Verdict::Pass, vec![]));
    }

    #[test]
    fn lifted_corner_is_outside_tolerance_and_named() {
        let a = Assessment::new(
            &three_panels(0.01, 0.0),
            References::default(),
            &Limits::default(),
        );
        assert_eq!(failing(&a), ["planarity"]);
        assert_eq!(a.verdict, Verdict::OutsideTolerance);
        let planarity = a.failures().next().unwrap();
        assert_eq!(planarity.ids, [0]);
        assert!(planarity.value > planarity.limit);
    }

    #[test]
    fn self_intersecting_panel_is_invalid() {
        let a = Assessment::new(
            &three_panels(0.0, 2.0),
            References::default(),
            &Limits::default(),
        );
        assert_eq!(a.verdict, Verdict::Invalid);
        assert!(
            failing(&a)
                .iter()
                .any(|name| ["faces_not_simple", "flipped_faces", "wrong_fans"].contains(name))
        );
    }

    /// Two squares that pass through each other, or that stand `apart`.
    fn squares(apart: f64) -> (HexMesh, TriangleSurface) {
        let flat = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let lying = flat.map(|[x, y]| Vec3::new(x, y, 0.0));
        let upright = flat.map(|[x, z]| Vec3::new(x, 0.1, z + apart) * 0.7);
        let places = [lying, upright].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        (
            HexMesh::new(places.clone(), &[[0, 1, 2, 3], [4, 5, 6, 7]]).unwrap(),
            TriangleSurface::new(places, &triangles).unwrap(),
        )
    }

    /// The verdict, and what is said of crossings, where panels cross.
    fn judged(surface: &TriangleSurface, limits: &Limits) -> (Verdict, Option<String>) {
        let references = References {
            facets: Some(surface),
            ..Default::default()
        };
        let found = Assessment::new(&squares(0.0).0, references, limits);
        let check = found.failures().find(|c| c.name == "crossings").unwrap();
        (found.verdict, check.advice.clone())
    }

    #[test]
    fn crossings_of_the_surface_are_told_from_those_of_panels() {
        let (verdict, advice) = judged(&squares(0.0).1, &Limits::default());
        let advice = advice.unwrap();
        assert_eq!(verdict, Verdict::OutsideTolerance);
        assert!(
            advice.contains("at 2 of 2 the surface passes through itself"),
            "{advice}"
        );
        let (verdict, advice) = judged(&squares(2.0).1, &Limits::default());
        assert_eq!(verdict, Verdict::Invalid);
        assert!(advice.unwrap().contains("more panels"));
    }

    #[test]
    fn panels_that_are_left_whole_and_overlap_are_told_to_end_at_the_boundary() {
        let advice = |boundary| {
            let limits = Limits::new(Some(0.5), Some(boundary));
            judged(&squares(2.0).1, &limits).1
        };
        assert!(advice(Boundary::Whole).unwrap().contains("--boundary snap"));
        assert!(advice(Boundary::Snap).unwrap().contains("more panels"));
    }

    #[test]
    fn the_boundary_is_compared_with_the_calm_line_through_teeth() {
        let toothed = crate::smooth_surface::teeth::tests::rhomb(true);
        let limits = Limits::new(Some(0.05), Some(Boundary::Snap));
        let calm = without_teeth(&toothed, LARGEST_TOOTH * 0.05 * toothed.diagonal()).unwrap();
        let of = |surface: &TriangleSurface| {
            let topology = surface.topology();
            let corners = topology.faces().map(|f| topology.face_vertices(f));
            let faces: Vec<[u32; 3]> = corners
                .map(|c| [0, 1, 2].map(|k| c[k].index() as u32))
                .collect();
            let mesh = HexMesh::new(surface.positions().as_slice().to_vec(), &faces).unwrap();
            let references = References {
                facets: Some(&toothed),
                ..Default::default()
            };
            Assessment::new(&mesh, references, &limits)
        };
        let distance = |found: &Assessment| found.boundary.as_ref().unwrap().distance_max();
        let (followed, zigzag) = (of(&calm.part.surface), of(&toothed));
        assert!(distance(&followed) < 1e-3 && followed.calm_line().is_some());
        assert!(distance(&zigzag) > 0.01);
    }

    /// A square of side 4 with a bump, of height .4, at a distance of 1 to the boundary.
    fn bumpy_square() -> TriangleSurface {
        let corner = |k: u32| [k % 5, k / 5];
        let positions = (0..25).map(|k| {
            let [x, y] = corner(k).map(f64::from);
            let bump = if corner(k) == [1, 2] { 0.4 } else { 0.0 };
            Vec3::new(x, y, bump)
        });
        let cells = (0..25).filter(|k| corner(*k).iter().all(|c| *c < 4));
        let halves = cells.flat_map(|k| [[k, k + 1, k + 6], [k, k + 6, k + 5]]);
        let triangles: Vec<[u32; 3]> = halves.collect();
        TriangleSurface::new(positions.collect(), &triangles).unwrap()
    }

    #[test]
    fn the_surface_is_to_be_near_the_panels_up_to_a_boundary_that_they_follow() {
        let surface = bumpy_square();
        let flat = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let corners = flat.map(|[x, y]| Vec3::new(x, y, 0.0));
        let mesh = HexMesh::new(corners.to_vec(), &[[0, 1, 2, 3]]).unwrap();
        let misses = |boundary, led: &[FaceId]| {
            let references = References {
                facets: Some(&surface),
                elsewhere: led,
                ..Default::default()
            };
            let limits = Limits::new(Some(0.05), Some(boundary));
            let found = Assessment::new(&mesh, references, &limits);
            failing(&found).contains(&"coverage_inner")
        };
        assert!(misses(Boundary::Snap, &[]) && misses(Boundary::Clip, &[]));
        assert!(!misses(Boundary::Whole, &[]));
        assert!(!misses(Boundary::Snap, &[FaceId::new(0)]));
    }

    #[test]
    fn distance_to_the_surface_is_judged_against_the_diagonal() {
        let square = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)];
        let positions = square
            .iter()
            .map(|&(x, y)| Vec3::new(x, y, -0.05))
            .collect();
        let surface = TriangleSurface::new(positions, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let references = References {
            facets: Some(&surface),
            ..Default::default()
        };
        let judged = |limit| {
            let limits = Limits {
                deviation_rel: Some(limit),
                ..Default::default()
            };
            Assessment::new(&three_panels(0.0, 0.0), references, &limits)
        };
        let rel = 0.05 / 32.0_f64.sqrt();
        assert!(!failing(&judged(rel * 1.001)).contains(&"deviation"));
        let strict = judged(rel * 0.999);
        let check = strict.failures().find(|c| c.name == "deviation").unwrap();
        assert_eq!(check.ids, [0, 1, 2]);
        assert!((check.value - rel).abs() < 1e-12);
    }

    /// A figure just beyond its limit asks for more panels than were asked for, not for as many.
    #[test]
    fn the_panels_that_help_are_counted_from_those_that_were_asked_for() {
        let surface = bumpy_square();
        let told = |asked| {
            let references = References {
                facets: Some(&surface),
                asked,
                ..Default::default()
            };
            let mesh = three_panels(0.0, 0.0);
            let deviation = |limit| {
                let limits = Limits {
                    deviation_rel: Some(limit),
                    ..Default::default()
                };
                let found = Assessment::new(&mesh, references, &limits);
                let mut checks = found.checks.into_iter();
                checks.find(|c| c.name == "coverage_inner").unwrap()
            };
            deviation(0.999 * deviation(1.0).value).advice.unwrap()
        };
        assert!(told(Some(100)).contains("about 111 panels instead of 100"));
        assert!(told(None).contains("about 4 panels instead of 3"));
    }
}
