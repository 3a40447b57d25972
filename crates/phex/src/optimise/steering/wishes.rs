//! Steering: what the user holds on to, from positions and numbers to vertices of a mesh.
//!
//! Points name the nearest vertex. Vertices that must move to their places take their surroundings
//! along (a few rounds of averaging of the displacement), so that simple panels stay simple; the
//! optimiser then starts from there.

use crate::optimise::error::{MOST_MOVE, OptimiseError, SteeringError};
use crate::optimise::holds::{Anchored, Hold, Holds, PUT_THERE};
use crate::optimise::inspect::{Fault, Offender};
use crate::optimise::panels::{FaceShapes, Panels, flatten, point, points, put, unknowns};
use crate::optimise::simple::crossed;
use phex_mesh::{BoundaryCurve, FaceId, FacePlane, HexMesh, PerVertex, Vec3, VertexId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A plane in which vertices stay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundPlane {
    /// A point of the plane, model units; without it, the vertex of the boundary that is lowest
    /// along the normal.
    #[serde(default)]
    pub point: Option<[f64; 3]>,
    /// Its normal, of any length but 0.
    #[serde(default = "upwards")]
    pub normal: [f64; 3],
    /// Vertices of the boundary within this distance are put in the plane, mean edges, >= 0.
    /// Without it half a mean edge, and no farther than panels may be from the surface.
    #[serde(default)]
    pub reach: Option<f64>,
}

fn upwards() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl Default for GroundPlane {
    fn default() -> Self {
        Self {
            point: None,
            normal: upwards(),
            reach: None,
        }
    }
}

impl GroundPlane {
    /// Mean edges from the plane beyond which it concerns no vertex.
    pub(super) fn farthest(&self) -> f64 {
        self.reach.unwrap_or(GROUND_REACH)
    }

    /// Mean edges from the plane within which vertices are put in it; `most` is how far panels may
    /// be from the surface.
    fn nearest(&self, most: Option<f64>) -> f64 {
        let most = most.filter(|_| self.reach.is_none());
        self.farthest().min(most.unwrap_or(f64::INFINITY))
    }
}

/// A pull towards a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Anchor {
    /// The point, model units.
    pub point: [f64; 3],
    /// Weight, > 0; 1 pulls as strongly as the surface pulls a vertex.
    pub weight: f64,
}

/// What the user holds on to. Nothing by default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Steering {
    /// Numbers of vertices that stay where they are, to the last bit.
    pub fixed_vertices: Vec<u32>,
    /// Points, model units, that the nearest vertex is moved to and stays at, to the last bit.
    pub fixed_points: Vec<[f64; 3]>,
    /// Planes in which vertices of the boundary stay.
    pub grounds: Vec<GroundPlane>,
    /// Polylines, model units, on which the vertices of the boundary within half a mean edge slide;
    /// closed where the last point repeats the first. A panel with three corners on a curve lies in
    /// the plane of the curve there: where panels can't be planar so, corners between their ends
    /// are let go.
    pub curves: Vec<Vec<[f64; 3]>>,
    /// Pulls of the nearest vertices.
    pub anchors: Vec<Anchor>,
}

impl Steering {
    /// Whether nothing is held.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Refuses what holds the boundary where there is none, before anything is computed.
    pub(crate) fn check_boundary(&self, is_closed: bool) -> Result<(), SteeringError> {
        let holders = [
            ("a curve", !self.curves.is_empty()),
            ("a ground plane", !self.grounds.is_empty()),
        ];
        let given = holders.into_iter().find(|(_, is_given)| *is_given);
        given
            .filter(|_| is_closed)
            .map_or(Ok(()), |(what, _)| Err(SteeringError::NoBoundary { what }))
    }

    /// The same with all points mapped by a similarity.
    pub(crate) fn moved(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        let move_to = |p: &mut [f64; 3]| *p = map(Vec3::from(*p)).into();
        let mut moved = self.clone();
        moved.fixed_points.iter_mut().for_each(move_to);
        moved.curves.iter_mut().flatten().for_each(move_to);
        let anchors = moved.anchors.iter_mut().map(|a| &mut a.point);
        anchors.for_each(move_to);
        let grounds = moved.grounds.iter_mut();
        grounds.filter_map(|g| g.point.as_mut()).for_each(move_to);
        moved
    }

    /// Puts vertices that were held at points exactly there, where a similarity there and back has
    /// left a rounding error; `size` is a length of the model.
    pub(crate) fn put_exactly(&self, positions: &mut PerVertex<Vec3>, size: f64) {
        for p in self.fixed_points.iter().map(|p| Vec3::from(*p)) {
            let held = |q: &&mut Vec3| (**q - p).norm() <= SAME_PLACE * size;
            if let Some(q) = positions.iter_mut().find(held) {
                *q = p;
            }
        }
    }
}

/// Lengths of a model within which two places differ by rounding alone.
const SAME_PLACE: f64 = 1e-13;
/// Mean edges within which vertices of the boundary are put in a ground plane, where the surface
/// may be that far.
const GROUND_REACH: f64 = 0.5;
/// Mean edges within which vertices of the boundary slide on a curve.
const CURVE_REACH: f64 = 0.5;
/// Mean edges from the end of a curve within which a vertex beyond it is put on it.
const END_REACH: f64 = 0.05;
/// Rounds in which a displacement spreads to the neighbours.
const SPREADING: usize = 40;

/// The holds on a mesh; `most` is how far from the surface panels may be, over the diagonal.
pub(in crate::optimise) fn resolve(
    steering: &Steering,
    mesh: &HexMesh,
    most: Option<f64>,
) -> Result<Holds, OptimiseError> {
    let mut resolver = Resolver::new(mesh, most);
    resolver.fix_vertices(&steering.fixed_vertices)?;
    resolver.fix_points(&steering.fixed_points)?;
    resolver.slide(&steering.curves)?;
    for (index, ground) in steering.grounds.iter().enumerate() {
        resolver.stand(index, ground)?;
    }
    resolver.anchor(&steering.anchors)?;
    Ok(resolver.holds)
}

struct Resolver<'a> {
    mesh: &'a HexMesh,
    mean_edge: f64,
    /// How far panels may be from the surface, mean edges.
    most: Option<f64>,
    holds: Holds,
}

fn finite(what: &'static str, index: usize, p: [f64; 3]) -> Result<Vec3, SteeringError> {
    let reason = "its coordinates are not finite";
    match p.iter().all(|c| c.is_finite()) {
        true => Ok(Vec3::from(p)),
        false => Err(SteeringError::Unusable {
            what,
            index,
            reason,
        }),
    }
}

impl<'a> Resolver<'a> {
    fn new(mesh: &'a HexMesh, most: Option<f64>) -> Self {
        Self {
            mesh,
            mean_edge: mesh.mean_edge(),
            most: most.map(|m| m * mesh.diagonal() / mesh.mean_edge()),
            holds: Holds::default(),
        }
    }

    fn hold(
        &mut self,
        what: &'static str,
        index: usize,
        vertex: VertexId,
        hold: Hold,
    ) -> Result<(), SteeringError> {
        match self.holds.held.insert(vertex.index() as u32, hold) {
            None => Ok(()),
            Some(_) => Err(SteeringError::Taken {
                what,
                index,
                vertex,
            }),
        }
    }

    /// The vertex nearest to a point, and its distance.
    fn nearest(&self, p: Vec3) -> (VertexId, f64) {
        let distances = self.mesh.positions.enumerate();
        let distances = distances.map(|(v, q)| (v, (q - p).norm()));
        distances
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("a mesh has vertices")
    }

    fn fix_vertices(&mut self, vertices: &[u32]) -> Result<(), SteeringError> {
        let count = self.mesh.positions.len();
        for (index, &vertex) in vertices.iter().enumerate() {
            if vertex as usize >= count {
                return Err(SteeringError::NoSuchVertex { vertex, count });
            }
            let v = VertexId::new(vertex);
            let hold = Hold::At(self.mesh.positions[v]);
            self.hold("fixed vertex", index, v, hold)?;
        }
        Ok(())
    }

    fn fix_points(&mut self, points: &[[f64; 3]]) -> Result<(), SteeringError> {
        for (index, &p) in points.iter().enumerate() {
            let p = finite("fixed point", index, p)?;
            let (vertex, distance) = self.nearest(p);
            let distance = distance / self.mean_edge;
            if distance > MOST_MOVE {
                return Err(SteeringError::TooFar {
                    index,
                    vertex,
                    distance,
                });
            }
            self.hold("fixed point", index, vertex, Hold::At(p))?;
        }
        Ok(())
    }

    /// Holds the free vertices of the boundary that `near` says so of; tells whether there are any.
    fn hold_rim(&mut self, hold: Hold, near: impl Fn(Vec3) -> bool) -> bool {
        let mut any = false;
        for v in self.mesh.topology().boundary_vertices() {
            if near(self.mesh.positions[v]) {
                self.holds.held.entry(v.index() as u32).or_insert(hold);
                any = true;
            }
        }
        any
    }

    fn slide(&mut self, curves: &[Vec<[f64; 3]>]) -> Result<(), SteeringError> {
        let line = |(index, line): (usize, &Vec<[f64; 3]>)| {
            let points = line.iter().map(|&p| finite("curve", index, p));
            points.collect::<Result<Vec<Vec3>, _>>()
        };
        let lines: Vec<Vec<Vec3>> = (curves.iter().enumerate())
            .map(line)
            .collect::<Result<_, _>>()?;
        let Some(curve) = BoundaryCurve::of_polylines(&lines) else {
            return match curves.is_empty() {
                true => Ok(()),
                false => Err(SteeringError::Unusable {
                    what: "curve",
                    index: 0,
                    reason: "it has no segment",
                }),
            };
        };
        let reach = CURVE_REACH * self.mean_edge;
        // Beyond the end of a curve another edge of the boundary begins, whose vertices stay on it.
        let (ends, at_end) = (open_ends(&lines), END_REACH * self.mean_edge);
        let beyond = |p: Vec3, foot: Vec3| ends.contains(&foot) && (p - foot).norm() > at_end;
        let near = |p: Vec3| {
            let foot = curve.closest_point(p).position;
            (foot - p).norm() <= reach && !beyond(p, foot)
        };
        if !self.hold_rim(Hold::OnCurve, near) {
            return Err(SteeringError::NothingNear {
                what: "a curve",
                reach: CURVE_REACH,
            });
        }
        self.holds.curves = Some(curve);
        Ok(())
    }

    fn stand(&mut self, index: usize, ground: &GroundPlane) -> Result<(), SteeringError> {
        let (point, normal) = self.plane(index, ground)?;
        let height = |p: Vec3| normal.dot(&(p - point)).abs();
        let rounding = PUT_THERE * self.mesh.diagonal();
        let reach = ground.nearest(self.most) * self.mean_edge;
        self.hold_rim(Hold::InPlane { point, normal }, |p| {
            height(p) <= reach.max(rounding)
        });
        let mut rim = self.mesh.topology().boundary_vertices();
        let farthest = ground.farthest() * self.mean_edge;
        match rim.any(|v| height(self.mesh.position(v)) <= farthest) {
            true => Ok(()),
            false => Err(SteeringError::NothingNear {
                what: "the ground plane",
                reach: ground.farthest(),
            }),
        }
    }

    /// A point of a ground plane and its unit normal.
    fn plane(&self, index: usize, ground: &GroundPlane) -> Result<(Vec3, Vec3), SteeringError> {
        let unusable = |reason| SteeringError::Unusable {
            what: "ground plane",
            index,
            reason,
        };
        if (ground.reach).is_some_and(|reach| !(reach >= 0.0 && reach.is_finite())) {
            return Err(unusable("its reach is negative or not finite"));
        }
        let normal = finite("ground plane", index, ground.normal)?;
        let normal = normal
            .try_normalize(0.0)
            .ok_or_else(|| unusable("its normal is 0"))?;
        let point = match ground.point {
            Some(p) => finite("ground plane", index, p)?,
            None => self.lowest(normal)?,
        };
        Ok((point, normal))
    }

    /// Distances from a ground plane, in mean edges, of vertices of the boundary that are near it
    /// and not put in it, since panels may not be that far from the surface.
    fn beyond(&self, index: usize, ground: &GroundPlane) -> Result<Vec<f64>, SteeringError> {
        let (point, normal) = self.plane(index, ground)?;
        let reach = ground.nearest(self.most);
        let height = |v| normal.dot(&(self.mesh.position(v) - point)).abs() / self.mean_edge;
        let heights = self.mesh.topology().boundary_vertices().map(height);
        Ok(heights
            .filter(|h| (reach..ground.farthest()).contains(h))
            .collect())
    }

    /// The lowest vertex of the boundary.
    fn lowest(&self, normal: Vec3) -> Result<Vec3, SteeringError> {
        let rim = self.mesh.topology().boundary_vertices();
        rim.map(|v| self.mesh.positions[v])
            .min_by(|p, q| normal.dot(p).total_cmp(&normal.dot(q)))
            .ok_or(SteeringError::NoBoundary {
                what: "a ground plane",
            })
    }

    fn anchor(&mut self, anchors: &[Anchor]) -> Result<(), SteeringError> {
        for (index, anchor) in anchors.iter().enumerate() {
            let point = finite("anchor", index, anchor.point)?;
            let weight = anchor.weight;
            if !(weight > 0.0 && weight.is_finite()) {
                return Err(SteeringError::Unusable {
                    what: "anchor",
                    index,
                    reason: "its weight is not a positive number",
                });
            }
            let (vertex, _) = self.nearest(point);
            let anchored = Anchored { point, weight };
            let taken = self
                .holds
                .anchors
                .insert(vertex.index() as u32, anchored)
                .is_some();
            if taken {
                return Err(SteeringError::Taken {
                    what: "anchor",
                    index,
                    vertex,
                });
            }
        }
        Ok(())
    }
}

/// Ends of polylines that are not closed, and where no other one goes on.
fn open_ends(lines: &[Vec<Vec3>]) -> Vec<Vec3> {
    let ends = lines
        .iter()
        .flat_map(|l| l.first().into_iter().chain(l.last()));
    let all: Vec<Vec3> = ends.copied().collect();
    let alone = |e: &Vec3| all.iter().filter(|f| *f == e).count() == 1;
    all.iter().copied().filter(alone).collect()
}

/// Lets go of corners of single panels that slide on a curve or in a plane, in some faces, else
/// beside them, else all: a panel between two others needs only its ends there, and with a corner
/// between them it would have to lie in the plane of the curve. In the end any vertex of the faces
/// is let go. Tells whether there was one.
pub(in crate::optimise) fn let_go(
    holds: &Holds,
    mesh: &HexMesh,
    faces: &[FaceId],
    loose: &mut BTreeSet<u32>,
) -> bool {
    let topology = mesh.topology();
    let corners = |faces: &[FaceId]| -> Vec<VertexId> {
        let all = faces.iter().flat_map(|f| topology.face_vertices(*f));
        all.copied().collect()
    };
    let own = corners(faces);
    let around: Vec<FaceId> = own.iter().flat_map(|v| topology.faces_at(*v)).collect();
    let single = |v: &VertexId| topology.face_degree(*v) == 1;
    let slides = |v: &VertexId| {
        let number = v.index() as u32;
        let slides = matches!(
            holds.held.get(&number),
            Some(Hold::OnCurve | Hold::InPlane { .. })
        );
        slides && !loose.contains(&number)
    };
    let sets = [
        own.iter().copied().filter(single).collect(),
        corners(&around).into_iter().filter(single).collect(),
        topology.vertices().filter(single).collect(),
        own,
    ];
    let sets = sets.map(|set: Vec<VertexId>| {
        let sliding = set.iter().filter(|v| slides(v));
        sliding.map(|v| v.index() as u32).collect::<Vec<u32>>()
    });
    let found = sets.into_iter().find(|set| !set.is_empty());
    let any = found.is_some();
    loose.extend(found.into_iter().flatten());
    any
}

/// Lets go of vertices that a ground plane takes for want of a reach: those of some faces, else of
/// the faces beside them. Tells whether there was one.
pub(crate) fn let_go_of_ground(
    steering: &Steering,
    mesh: &HexMesh,
    faces: &BTreeSet<FaceId>,
    loose: &mut BTreeSet<u32>,
) -> bool {
    let taking = Steering {
        grounds: (steering.grounds.iter().copied())
            .filter(|ground| ground.reach.is_none())
            .collect(),
        ..Steering::default()
    };
    let topology = mesh.topology();
    let held = resolve(&taking, mesh, None).unwrap_or_default().held;
    let found = |faces: &BTreeSet<FaceId>| -> Vec<u32> {
        let corners = faces.iter().flat_map(|f| topology.face_vertices(*f));
        let numbers = corners.map(|v| v.index() as u32);
        numbers
            .filter(|v| held.contains_key(v) && !loose.contains(v))
            .collect()
    };
    let corners = faces.iter().flat_map(|f| topology.face_vertices(*f));
    let around = corners.flat_map(|v| topology.faces_at(*v)).collect();
    let all = [found(faces), found(&around)];
    let more = all.into_iter().find(|found| !found.is_empty());
    let any = more.is_some();
    loose.extend(more.into_iter().flatten());
    any
}

/// Vertices named in a note at the most.
const NAMED: usize = 10;

/// Faces of which a vertex is led along a curve, in order: their boundary is not that of the
/// surface.
pub fn led_elsewhere(steering: &Steering, mesh: &HexMesh) -> Vec<FaceId> {
    let leading = Steering {
        curves: steering.curves.clone(),
        ..Steering::default()
    };
    // What can't be led at all was refused before there was a mesh.
    let held = resolve(&leading, mesh, None)
        .map_or_else(|_| Vec::new(), |holds| holds.held.into_keys().collect());
    let faces: BTreeSet<FaceId> = (held.into_iter())
        .flat_map(|v| mesh.topology().faces_at(VertexId::new(v)))
        .collect();
    faces.into_iter().collect()
}

/// What to tell of vertices that are not on the curves and in the planes that hold them; nothing
/// of none.
pub(in crate::optimise) fn told_loose(holds: &Holds, after: &HexMesh) -> Option<String> {
    let x = unknowns(after);
    let near = PUT_THERE * after.diagonal();
    let away = |&(v, place): &(u32, Vec3)| (place - point(&x, v as usize)).norm() > near;
    let loose: Vec<u32> = holds.places(&x).filter(away).map(|(v, _)| v).collect();
    let names: Vec<String> = loose.iter().take(NAMED).map(u32::to_string).collect();
    let more = match loose.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!loose.is_empty()).then(|| {
        format!(
            "vertices of the boundary that are not held on the curve or in the plane, since panels there could not be planar, would lie flat, or be outside limits: {}{more}",
            names.join(" ")
        )
    })
}

/// What to tell of vertices near ground planes that are too far to be put in them; nothing of none.
pub(in crate::optimise) fn told_beyond(
    steering: &Steering,
    mesh: &HexMesh,
    most: Option<f64>,
) -> Option<String> {
    let resolver = Resolver::new(mesh, most);
    let grounds = steering.grounds.iter().enumerate();
    let far = grounds.filter_map(|(index, ground)| resolver.beyond(index, ground).ok());
    let far: Vec<f64> = far.flatten().collect();
    let most = (100.0 * far.iter().copied().reduce(f64::max)?).ceil() / 100.0;
    let (count, it) = match far.len() {
        1 => ("1 vertex".to_owned(), "it"),
        n => (format!("{n} vertices"), "them"),
    };
    Some(format!(
        "not in the ground plane, since it is farther than the largest deviation: {count} of the boundary, up to {most} mean edges away; `--ground-reach {most}` puts {it} in it, off the surface"
    ))
}

/// The mesh with held vertices at their places, where that breaks no panel.
pub(in crate::optimise) fn put_in_place(
    holds: &Holds,
    panels: &Panels,
    mesh: &HexMesh,
) -> Result<Vec<f64>, SteeringError> {
    let x = unknowns(mesh);
    refuse_impossible_faces(holds, panels, &x)?;
    let crossed = |x: &[f64]| crossed(panels, &FaceShapes::at(panels, x));
    let before = crossed(&x);
    let new_one = |y: &[f64]| (crossed(y).into_iter()).find(|f| !before.contains(f));
    let mut raw = x.clone();
    holds.retract(&mut raw);
    if raw == x {
        return Ok(x);
    }
    let spread = spread_out(holds, mesh, &x);
    match (new_one(&spread), new_one(&raw)) {
        (None, _) => Ok(spread),
        (_, None) => Ok(raw),
        (Some(f), Some(_)) => Err(SteeringError::Crossed {
            face: FaceId::new(f as u32),
        }),
    }
}

/// Held vertices at their places, the others along with them.
fn spread_out(holds: &Holds, mesh: &HexMesh, x: &[f64]) -> Vec<f64> {
    let topology = mesh.topology();
    let before = points(x);
    let mut way = vec![Vec3::zeros(); before.len()];
    let moved: Vec<(usize, Vec3)> = holds
        .places(x)
        .map(|(v, place)| (v as usize, place - before[v as usize]))
        .collect();
    for _ in 0..SPREADING {
        moved.iter().for_each(|&(v, d)| way[v] = d);
        let mean = |v: VertexId| {
            let ring = topology.neighbours(v);
            let sum: Vec3 = ring.iter().map(|n| way[n.index()]).sum();
            sum / ring.len().max(1) as f64
        };
        way = topology.vertices().map(mean).collect();
    }
    let after: Vec<Vec3> = before.iter().zip(&way).map(|(p, d)| p + d).collect();
    let mut y = flatten(&after);
    for (v, place) in holds.places(x) {
        put(&mut y, v as usize, &place);
    }
    y
}

/// Refuses faces whose fixed corners alone do not lie in a plane.
fn refuse_impossible_faces(holds: &Holds, panels: &Panels, x: &[f64]) -> Result<(), SteeringError> {
    const PLANAR: f64 = 1e-9;
    let mean_edge = panels.mean_edge(x);
    for f in 0..panels.n_faces() {
        let fixed = panels
            .vertices(f)
            .iter()
            .filter_map(|v| match holds.held.get(v) {
                Some(Hold::At(p)) => Some(*p),
                _ => None,
            });
        let fixed: Vec<Vec3> = fixed.collect();
        if fixed.len() < 4 {
            continue;
        }
        let plane = FacePlane::fit(&fixed);
        let heights = fixed.iter().map(|p| plane.height(*p).abs());
        let distance = heights.fold(0.0, f64::max) / mean_edge;
        if distance > PLANAR {
            return Err(SteeringError::OverConstrained {
                face: FaceId::new(f as u32),
                count: fixed.len(),
                distance,
            });
        }
    }
    Ok(())
}

/// Which of the held faces is farthest from planar, as a sentence; `None` if all are planar.
pub(in crate::optimise) fn blame(
    holds: &Holds,
    panels: &Panels,
    offenders: &[Offender],
) -> Option<String> {
    let held = |f: FaceId| {
        let corners = panels.vertices(f.index()).iter();
        corners.filter(|v| holds.held.contains_key(v)).count()
    };
    let off = offenders.iter().filter_map(|o| match o.fault {
        Fault::NotPlanar { distance } => Some((o.face, distance, held(o.face))),
        _ => None,
    });
    let worst = off.filter(|&(_, _, held)| held > 0);
    let (face, distance, held) = worst.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let corners = panels.valence(face.index());
    Some(format!(
        "face {face} stays {distance:.1e} mean edges off its plane: {held} of its {corners} corners are held"
    ))
}
