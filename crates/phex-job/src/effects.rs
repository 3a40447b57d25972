//! Options that would do nothing: what is typed is carried out or refused, never passed over in
//! silence.

use crate::error::JobError;
use crate::given::Given;
use crate::run::LastStage;
use crate::settings::{AtBoundary, CloseTo, LayoutMethod, MeshSettings, TypedEffort};
use crate::steering::TypedSolver;
use phex::symmetry::Symmetry;

/// Methods that lay the lattice of `lattice` out, and then take planes of it.
const ON_LATTICE: [LayoutMethod; 4] = [
    LayoutMethod::Lattice,
    LayoutMethod::TangentPlanes,
    LayoutMethod::DualSubdivision,
    LayoutMethod::Parallel,
];
/// Methods whose lattice is regular in a metric of their own: it has directions and cones, but
/// neither sizes nor lines to follow.
const OWN_METRIC: [LayoutMethod; 2] = [LayoutMethod::ProjectiveDual, LayoutMethod::SupportFunction];
/// Methods that end with the optimiser, which keeps panels to the target.
const OPTIMISED: [LayoutMethod; 2] = [LayoutMethod::Lattice, LayoutMethod::BrickWall];

impl MeshSettings {
    /// Refuses options that have no effect with the method, or without another option.
    ///
    /// # Errors
    /// All of them that are set, with the methods that heed them.
    pub fn check_effects(&self, given: &Given) -> Result<(), JobError> {
        let method = LayoutMethod::from(self.options(1).method);
        let heeded = self.heeded(given).into_iter();
        let idle = heeded.filter(|(_, by)| !by.contains(&method));
        let told = idle.map(|(option, by)| {
            let by: Vec<String> = by.into_iter().map(name).collect();
            let (method, by) = (name(method), by.join(", "));
            format!("`{option}` has no effect with `{method}` (it has with {by})")
        });
        let twice = self.method == Some(LayoutMethod::Best) && self.effort.is_some();
        let twice = twice.then(|| "`effort` has no effect with `best`".to_owned());
        let told = told.chain(twice).chain(self.steering.without_effect());
        refused(told.collect())
    }

    /// The options that are set and that not every method heeds, with those that do.
    fn heeded(&self, given: &Given) -> Vec<(&'static str, Vec<LayoutMethod>)> {
        use LayoutMethod::{DualSubdivision, Koebe, Lattice, Parallel, PowerDiagram};
        use LayoutMethod::{ProjectiveDual, TangentPlanes};
        let all_but = |one| -> Vec<_> {
            let others = LayoutMethod::ALL.into_iter().filter(|m| *m != one);
            others.collect()
        };
        let directed = [ON_LATTICE.as_slice(), &OWN_METRIC].concat();
        let turned = [directed.as_slice(), &[Koebe]].concat();
        let one_sign = [OWN_METRIC.as_slice(), &[DualSubdivision, Parallel]].concat();
        let bounded = all_but(PowerDiagram);
        // Vertices that are moved afterwards turn the edges that have offsets.
        let movable = all_but(Koebe);
        let fitted = self.fitted();
        let near = match self.target {
            Some(CloseTo::Facets) => &fitted,
            _ => &bounded,
        };
        let s = &self.steering;
        let dials = match s.holds() || !given.steering.is_empty() {
            true => LayoutMethod::ALL.as_slice(),
            false => &fitted,
        };
        let [cones, lines, sizes] = self.guided(given);
        let snaps = self.boundary == Some(AtBoundary::Snap);
        let all: [(_, _, &[LayoutMethod]); 23] = [
            ("effort", self.effort.is_some(), &[Lattice]),
            ("regular", self.regular, &[Lattice]),
            ("rotate", self.rotate.is_some(), &turned),
            ("cones", cones, &directed),
            ("guide", lines, &ON_LATTICE),
            ("crease", self.guides.crease.is_some(), &ON_LATTICE),
            ("adaptive", self.adaptive.is_some(), &ON_LATTICE),
            ("size-field", sizes, &ON_LATTICE),
            ("boundary", self.boundary.is_some(), &bounded),
            ("symmetry", self.asks_for_symmetry(), &[Lattice]),
            ("target", self.target.is_some(), near),
            ("any-domain", self.any_domain, &one_sign),
            ("quadric", self.quadric.is_some(), &[ProjectiveDual]),
            ("regularise", self.regularise.is_some(), &[TangentPlanes]),
            ("minimal", self.minimal, &[Koebe]),
            ("boundary = snap", snaps, &movable),
            ("repeat", self.repeat.is_some(), &movable),
            ("held vertices", s.holds(), &movable),
            ("fairness", s.fairness.is_some(), dials),
            ("closeness", s.closeness.is_some(), dials),
            ("clearance", s.clearance.is_some(), dials),
            ("centres", s.centres.is_some(), dials),
            ("solver", s.solver.is_some(), dials),
        ];
        let set = all.into_iter().filter(|(_, set, _)| *set);
        set.map(|(option, _, by)| (option, by.to_vec())).collect()
    }

    /// Whether there are cones, lines and sizes, in files or in memory.
    fn guided(&self, given: &Given) -> [bool; 3] {
        [
            self.guides.cones.is_some() || !given.guides.cones.is_empty(),
            self.guides.guide.is_some() || !given.guides.lines.is_empty(),
            self.size_field.is_some() || given.size_field.is_some(),
        ]
    }

    /// The methods that end with the optimiser; that of tangent planes does where vertices are held
    /// back.
    fn fitted(&self) -> Vec<LayoutMethod> {
        let mut fitted = OPTIMISED.to_vec();
        if self.options(1).dual.regularisation > 0.0 {
            fitted.push(LayoutMethod::TangentPlanes);
        }
        fitted
    }

    /// Refuses options that were typed (or are `given`, or are `others` by name) and have no effect
    /// where a run ends after a stage. What a job file says is for whole runs; `whole` is what was
    /// typed with what that file adds.
    ///
    /// # Errors
    /// All of them that are set.
    pub fn check_until(
        &self,
        until: Option<LastStage>,
        whole: &Self,
        given: &Given,
        others: &[(&'static str, bool)],
    ) -> Result<(), JobError> {
        if until.is_none() {
            return Ok(());
        }
        // Sizes may stand in the job file.
        let typed = Self {
            panels: whole.panels,
            edge_length: whole.edge_length,
            ..self.clone()
        };
        let mut idle = typed.idle_on_layout(given);
        idle.extend(those_set(others.iter().copied()));
        none_idle(&idle, "`until layout`, which ends before panels are planar")
    }

    /// Refuses options that were typed (or are `given`) and have no effect where an earlier mesh is
    /// taken up.
    ///
    /// # Errors
    /// All of them that are set.
    pub fn check_start(&self, given: &Given) -> Result<(), JobError> {
        none_idle(
            &self.idle_on_start(given),
            "`start`, which lays nothing out",
        )
    }

    /// The options that are set and mean nothing where panels are laid out and no more. Limits of
    /// size say how many panels there are, where nothing else does.
    fn idle_on_layout(&self, given: &Given) -> Vec<&'static str> {
        let limits = &self.limits;
        let sized = self.is_sized();
        let s = &self.steering;
        let held = &given.steering;
        let later = [
            // A draft makes one lattice, all others the most regular of the same ones.
            ("effort best", self.effort == Some(TypedEffort::Best)),
            ("method best", self.method == Some(LayoutMethod::Best)),
            ("symmetry", self.asks_for_symmetry()),
            ("target facets", self.target == Some(CloseTo::Facets)),
            ("repeat", self.repeat.is_some()),
            (
                "fix",
                s.fix.is_some()
                    || !(held.fixed_points.is_empty() && held.fixed_vertices.is_empty()),
            ),
            ("curve", s.curve.is_some() || !held.curves.is_empty()),
            ("ground", s.ground.is_some()),
            ("anchors", s.anchors.is_some() || !held.anchors.is_empty()),
            ("fairness", s.fairness.is_some()),
            ("closeness", s.closeness.is_some()),
            ("clearance", s.clearance.is_some()),
            ("centres", s.centres.is_some()),
            ("solver", s.solver.is_some()),
            ("max-deviation", self.max_deviation.is_some()),
            ("planarity", self.planarity.is_some()),
            ("max-panel", sized && limits.max_panel.is_some()),
            ("max-edge", sized && limits.max_edge.is_some()),
            ("max-area", sized && limits.max_area.is_some()),
            ("min-edge", limits.min_edge.is_some()),
            ("min-angle", limits.min_angle.is_some()),
            ("max-aspect", limits.max_aspect.is_some()),
            ("min-dihedral", limits.min_dihedral.is_some()),
            ("max-dihedral", limits.max_dihedral.is_some()),
        ];
        those_set(later).collect()
    }

    fn asks_for_symmetry(&self) -> bool {
        self.symmetry.is_some_and(|s| s != Symmetry::None)
    }

    /// The options that are set and mean nothing where an earlier mesh is taken up: nothing is laid
    /// out.
    pub(crate) fn idle_on_start(&self, given: &Given) -> Vec<&'static str> {
        let [cones, lines, sizes] = self.guided(given);
        let laid_out = [
            ("panels", self.panels.is_some()),
            ("edge-length", self.edge_length.is_some()),
            ("method", self.method.is_some()),
            ("effort", self.effort.is_some()),
            ("any-domain", self.any_domain),
            ("quadric", self.quadric.is_some()),
            ("regularise", self.regularise.is_some()),
            ("minimal", self.minimal),
            ("regular", self.regular),
            ("rotate", self.rotate.is_some()),
            ("adaptive", self.adaptive.is_some()),
            ("size-field", sizes),
            ("boundary", self.boundary.is_some()),
            ("symmetry", self.symmetry.is_some()),
            ("guide", lines),
            ("crease", self.guides.crease.is_some()),
            ("cones", cones),
            ("seed", self.seed.is_some()),
        ];
        those_set(laid_out).collect()
    }
}

/// The names of options that are set.
fn those_set(
    options: impl IntoIterator<Item = (&'static str, bool)>,
) -> impl Iterator<Item = &'static str> {
    let set = options.into_iter().filter(|(_, is_set)| *is_set);
    set.map(|(name, _)| name)
}

/// Refuses the options that sentences say do nothing.
fn refused(told: Vec<String>) -> Result<(), JobError> {
    match told.is_empty() {
        true => Ok(()),
        false => Err(JobError::input(format!(
            "{}: leave it out",
            told.join("; ")
        ))),
    }
}

impl crate::steering::SteeringSettings {
    /// Refuses options that do nothing without another, or with the solver.
    ///
    /// # Errors
    /// All of them that are set.
    pub fn check_effects(&self) -> Result<(), JobError> {
        refused(self.without_effect())
    }

    /// Sentences on the options that are set and do nothing without another, or with the solver.
    fn without_effect(&self) -> Vec<String> {
        let mut told = Vec::new();
        if self.ground_reach.is_some() && self.ground.is_none() {
            told.push("`ground-reach` has no effect without `ground`".to_owned());
        }
        let unheeded = [
            ("fairness", self.fairness),
            ("clearance", self.clearance),
            ("centres", self.centres),
        ];
        if self.solver == Some(TypedSolver::Tetrahedra) {
            let set = unheeded.into_iter().filter(|(_, dial)| dial.is_some());
            told.extend(
                set.map(|(name, _)| format!("`{name}` has no effect with the solver `tetrahedra`")),
            );
        }
        told
    }

    /// Whether something is held: then the optimiser comes last, whatever the method.
    fn holds(&self) -> bool {
        self.inputs().next().is_some() || self.ground.is_some()
    }
}

/// Refuses options that have no effect with another one.
fn none_idle(idle: &[&str], with: &str) -> Result<(), JobError> {
    let has = if idle.len() == 1 { "has" } else { "have" };
    match idle.is_empty() {
        true => Ok(()),
        false => Err(JobError::input(format!(
            "`{}` {has} no effect with {with}: leave {} out",
            idle.join("`, `"),
            if idle.len() == 1 { "it" } else { "them" }
        ))),
    }
}

/// A method as it is typed.
fn name(method: LayoutMethod) -> String {
    let value = serde_json::to_value(method).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(method: &str, settings: &str) -> String {
        let text = format!("method = '{method}'\n{settings}");
        let settings: MeshSettings = toml::from_str(&text).unwrap();
        settings
            .check_effects(&Given::default())
            .map_or_else(|e| e.to_string(), |()| String::new())
    }

    #[test]
    fn each_method_refuses_what_it_does_not_heed() {
        let options = [
            ("rotate", "rotate = 10"),
            ("adaptive", "adaptive = 0.4"),
            ("size-field", "size-field = 's.txt'"),
            ("guide", "[guides]\nguide = 'g.obj'"),
            ("crease", "[guides]\ncrease = 20"),
            ("cones", "[guides]\ncones = 'c.txt'"),
            ("fairness", "[steering]\nfairness = 2"),
            ("solver", "[steering]\nsolver = 'tetrahedra'"),
            ("target", "target = 'facets'"),
            ("boundary", "boundary = 'clip'"),
        ];
        // One letter for each of the options above: heeded or refused.
        for (method, heeded) in [
            ("lattice", "hhhhhhhhhh"),
            ("best", "hhhhhhhhhh"),
            ("brick-wall", "rrrrrrhhhh"),
            ("power-diagram", "rrrrrrrrrr"),
            ("projective-dual", "hrrrrhrrrh"),
            ("koebe", "hrrrrrrrrh"),
            ("support-function", "hrrrrhrrrh"),
            ("dual-subdivision", "hhhhhhrrrh"),
            ("tangent-planes", "hhhhhhrrrh"),
            ("parallel", "hhhhhhrrrh"),
        ] {
            for ((name, line), expected) in options.iter().zip(heeded.chars()) {
                let told = told(method, line);
                assert_eq!(told.is_empty(), expected == 'h', "{method} {name}: {told}");
                let named = told.contains(&format!("`{name}` has no effect with `{method}`"));
                assert_eq!(named, expected == 'r', "{method} {name}: {told}");
            }
        }
    }

    #[test]
    fn a_layout_heeds_no_limits_but_those_that_say_how_many_panels() {
        let idle = |text: &str| {
            toml::from_str::<MeshSettings>(text)
                .unwrap()
                .idle_on_layout(&Given::default())
        };
        let all = "repeat = '5mm'\n[limits]\nmax-edge = 2\nmin-angle = 30";
        assert_eq!(idle(all), ["repeat", "min-angle"]);
        assert_eq!(
            idle(&format!("panels = 60\n{all}")),
            ["repeat", "max-edge", "min-angle"]
        );
        assert!(idle("panels = 60\nboundary = 'clip'\nrotate = 5").is_empty());
        assert!(idle("target = 'half-way'\nsymmetry = 'none'\neffort = 'draft'").is_empty());
        assert_eq!(
            idle("target = 'facets'\nsymmetry = 4\neffort = 'best'"),
            ["effort best", "symmetry", "target facets"]
        );
        assert_eq!(idle("method = 'best'"), ["method best"]);
        assert_eq!(idle("method = 'lattice'"), Vec::<&str>::new());
        let steering =
            "ground = '0'\nfairness = 2\ncloseness = 2\nclearance = 0.1\nsolver = 'barrier'";
        assert_eq!(
            idle(&format!("[steering]\n{steering}")),
            ["ground", "fairness", "closeness", "clearance", "solver"]
        );
    }

    #[test]
    fn what_makes_an_option_work_lets_it_pass() {
        let held = "[steering]\nfairness = 2\nfix = 'p.txt'";
        assert_eq!(told("parallel", held), "", "the optimiser comes last");
        assert_eq!(
            told(
                "tangent-planes",
                "regularise = 0.1\n[steering]\nfairness = 2"
            ),
            ""
        );
        assert_eq!(told("parallel", "target = 'half-way'"), "");
        assert!(told("lattice", "regularise = 0.1").contains("tangent-planes"));
        assert!(told("lattice", "any-domain = true").contains("projective-dual"));
        assert!(told("lattice", "[steering]\nground-reach = 1").contains("without `ground`"));
        let paper = "[steering]\nsolver = 'tetrahedra'\ncentres = 2";
        assert!(told("lattice", paper).contains("`centres` has no effect with the solver"));
    }
}
