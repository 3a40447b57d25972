//! What no step may break: simple faces, their side of the surface, vertex fans and edges that do
//! not fold.
//!
//! A demand is armed where the first shape meets it; where it does not, it could only block every
//! step. While the penalty rises, faces are too bent for fans and folds to mean much, and one of
//! them must not stop the whole panelling: then only simplicity and sides are demanded, and a side
//! that blocks one step after another is given up for the rest of the phase.

use super::barrier::clearance;
use crate::optimise::panels::{FaceShapes, Panels, picked, point};
use crate::optimise::simple::is_simple;
use phex_mesh::{FaceId, Topology, Vec3, VertexId};

/// Least `n . n'` of the faces at an edge that is not called folded.
const UNFOLDED: f64 = 0.0;

/// A vertex of degree 3 with its neighbours and faces, counter-clockwise; at the boundary the first
/// face stands in for the third one.
#[derive(Clone, Copy, Debug)]
struct Fan {
    vertex: u32,
    neighbours: [u32; 3],
    faces: [u32; 3],
}

/// Demands on a shape.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct Guard {
    fans: Vec<Fan>,
    /// The two faces of each interior edge.
    hinges: Vec<[u32; 2]>,
    side: Option<Vec<Vec3>>,
    least_side: f64,
}

/// What is demanded of each element.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct Armed {
    simple: Vec<bool>,
    side: Vec<bool>,
    fan: Vec<bool>,
    hinge: Vec<bool>,
    /// Least clearance of each face, if clearances are guarded.
    clearance: Option<Vec<f64>>,
}

/// One broken demand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::optimise) enum Breach {
    NotSimple(usize),
    WrongSide(usize),
    Fan(usize),
    Fold([usize; 2]),
}

impl Guard {
    /// `side` is the surface's normal at each face, if there is a surface; `least_side` the least
    /// `n . side`.
    pub fn new(topology: &Topology, side: Option<Vec<Vec3>>, least_side: f64) -> Self {
        let is_fan = |v: &VertexId| topology.neighbours(*v).len() == 3;
        let hinge = |e| Some(topology.faces_beside(e)?.map(|f| f.index() as u32));
        Self {
            fans: topology
                .vertices()
                .filter(is_fan)
                .map(|v| fan(topology, v))
                .collect(),
            hinges: topology.edges().filter_map(hinge).collect(),
            side,
            least_side,
        }
    }

    /// The demands on some faces, with numbers of their own for these and for `vertices`; both
    /// lists are in order.
    pub fn part(&self, faces: &[u32], vertices: &[u32]) -> Self {
        let fan = |fan: &Fan| {
            Some(Fan {
                vertex: local(vertices, fan.vertex)?,
                neighbours: all_local(vertices, fan.neighbours)?,
                faces: all_local(faces, fan.faces)?,
            })
        };
        let hinges = self.hinges.iter();
        Self {
            fans: self.fans.iter().filter_map(fan).collect(),
            hinges: hinges.filter_map(|&h| all_local(faces, h)).collect(),
            side: self.side.as_ref().map(|side| picked(side, faces)),
            least_side: self.least_side,
        }
    }

    /// The two faces of each interior edge.
    pub(crate) fn hinges(&self) -> &[[u32; 2]] {
        &self.hinges
    }

    fn fan_goes_round_once(&self, fan: &Fan, shape: &FaceShapes, x: &[f64]) -> bool {
        let [f, g, last] = fan.faces;
        let faces = [f, g].into_iter().chain((last != f).then_some(last));
        let axis: Vec3 = faces.map(|f| shape.normal(f as usize)).sum();
        let centre = point(x, fan.vertex as usize);
        let e = fan.neighbours.map(|n| point(x, n as usize) - centre);
        // Three directions turn counter-clockwise once exactly if at most one of the turns is a
        // reflex one.
        let left = |k: usize| axis.dot(&e[k].cross(&e[(k + 1) % 3])) > 0.0;
        (0..3).filter(|&k| left(k)).count() >= 2
    }

    fn on_its_side(&self, shape: &FaceShapes, face: usize) -> bool {
        let dot = |side: &Vec<Vec3>| shape.normal(face).dot(&side[face]);
        self.side.as_ref().is_none_or(|s| dot(s) > self.least_side)
    }

    fn unfolded(&self, shape: &FaceShapes, [f, g]: [u32; 2]) -> bool {
        shape.normal(f as usize).dot(&shape.normal(g as usize)) > UNFOLDED
    }

    /// Arms every demand that a shape meets.
    pub fn arm(&self, panels: &Panels, shape: &FaceShapes, x: &[f64]) -> Armed {
        let faces = 0..panels.n_faces();
        let simple = |f: usize| is_simple(shape.face(panels, f));
        Armed {
            simple: faces.clone().map(simple).collect(),
            side: faces.map(|f| self.on_its_side(shape, f)).collect(),
            fan: self
                .fans
                .iter()
                .map(|fan| self.fan_goes_round_once(fan, shape, x))
                .collect(),
            hinge: self
                .hinges
                .iter()
                .map(|&h| self.unfolded(shape, h))
                .collect(),
            clearance: None,
        }
    }

    /// Whether a shape meets every armed demand.
    pub fn holds(&self, armed: &Armed, panels: &Panels, shape: &FaceShapes, x: &[f64]) -> bool {
        self.broken(armed, panels, shape, x).next().is_none()
    }

    /// The faces at which a shape breaks an armed demand; some more than once.
    pub(crate) fn broken<'a>(
        &'a self,
        armed: &'a Armed,
        panels: &'a Panels,
        shape: &'a FaceShapes,
        x: &'a [f64],
    ) -> impl Iterator<Item = u32> + 'a {
        let simple = |f: usize| !armed.simple[f] || is_simple(shape.face(panels, f));
        let faces = (0..panels.n_faces())
            .filter(move |&f| !simple(f) || (armed.side[f] && !self.on_its_side(shape, f)));
        let hinges = (self.hinges.iter().zip(&armed.hinge))
            .filter(|&(&h, &on)| on && !self.unfolded(shape, h));
        let fans = (self.fans.iter().zip(&armed.fan))
            .filter(|&(fan, &on)| on && !self.fan_goes_round_once(fan, shape, x));
        let tight = (armed.clearance.iter().flatten().enumerate())
            .filter(|(f, least)| clearance(shape.face(panels, *f)) < **least);
        (faces.map(|f| f as u32))
            .chain(hinges.flat_map(|(h, _)| *h))
            .chain(fans.flat_map(|(fan, _)| fan.faces))
            .chain(tight.map(|(f, _)| f as u32))
    }

    /// Gives up the demands on sides that a shape breaks.
    pub(crate) fn give_up_sides(&self, armed: &mut Armed, shape: &FaceShapes) {
        for (f, on) in armed.side.iter_mut().enumerate() {
            *on &= self.on_its_side(shape, f);
        }
    }

    /// Everything that a shape breaks.
    pub(crate) fn breaches(&self, panels: &Panels, shape: &FaceShapes, x: &[f64]) -> Vec<Breach> {
        let mut found = Vec::new();
        for f in 0..panels.n_faces() {
            if !is_simple(shape.face(panels, f)) {
                found.push(Breach::NotSimple(f));
            }
            if !self.on_its_side(shape, f) {
                found.push(Breach::WrongSide(f));
            }
        }
        let wrong = |fan: &&Fan| !self.fan_goes_round_once(fan, shape, x);
        let fans = self.fans.iter().filter(wrong);
        found.extend(fans.map(|fan| Breach::Fan(fan.vertex as usize)));
        let folded = self.hinges.iter().filter(|&&h| !self.unfolded(shape, h));
        found.extend(folded.map(|h| Breach::Fold(h.map(|f| f as usize))));
        found
    }
}

impl Armed {
    /// Whether a face was simple when the guard was armed.
    pub fn is_simple(&self, face: usize) -> bool {
        self.simple[face]
    }

    /// Without the demands on fans and folds.
    pub(crate) fn without_neighbours(mut self) -> Self {
        self.fan.fill(false);
        self.hinge.fill(false);
        self
    }

    /// Without any demand.
    pub(crate) fn of_nothing(mut self) -> Self {
        self.simple.fill(false);
        self.side.fill(false);
        self.clearance = None;
        self.without_neighbours()
    }

    /// Also demands a clearance of `least`, or half of what a face has now if that is less.
    pub(crate) fn keep_clear(&mut self, panels: &Panels, shape: &FaceShapes, least: f64) {
        let now = |f: usize| clearance(shape.face(panels, f));
        let demands = (0..panels.n_faces()).map(|f| least.min(0.5 * now(f)));
        self.clearance = Some(demands.collect());
    }
}

/// Number of an element within a list.
fn local(list: &[u32], number: u32) -> Option<u32> {
    list.binary_search(&number).ok().map(|k| k as u32)
}

fn all_local<const N: usize>(list: &[u32], numbers: [u32; N]) -> Option<[u32; N]> {
    let mut found = [0; N];
    for (f, n) in found.iter_mut().zip(numbers) {
        *f = local(list, n)?;
    }
    Some(found)
}

fn fan(topology: &Topology, v: VertexId) -> Fan {
    let neighbours = topology.neighbours(v);
    let faces: Vec<FaceId> = topology.faces_at(v).collect();
    Fan {
        vertex: v.index() as u32,
        neighbours: std::array::from_fn(|k| neighbours[k].index() as u32),
        faces: std::array::from_fn(|k| faces[k % faces.len()].index() as u32),
    }
}
