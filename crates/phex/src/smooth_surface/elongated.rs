//! Long triangles cut short, as strips of a vault that were triangulated from edge to edge.
//!
//! New vertices lie on the cubic curves that the normals at the ends of an edge ask for, and have
//! the normals that belong to these (A. Vlachos et al., "Curved PN triangles", 2001).
//!
//! Fields, lattices and cells need vertices near one another in all directions. Where much of a
//! surface is in triangles much longer than wide, all edges longer than panels need are split; what
//! is finer than that in the other direction is left to [`super::coarsened`]. Large triangles at
//! creases count as well: the smooth surface would round them off by as much as they are large.
//!
//! Loop's surface through such triangles would bend to and fro across them, which is noise in the
//! curvature. Slivers along the boundary have no normals and are taken away ([`super::slivers`]).
//!
//! Creases stay: the surface is cut open along them, so that no normal knows what is beyond, and
//! they bend by themselves, as the boundary does ([`super::opened`]).

use super::coarsen::delaunay;
use super::creases::creases;
use super::opened::Opened;
use super::slivers::{IN_PLANE, without_slivers};
use super::{Refinement, SmoothTarget, spacing};
use phex_mesh::{
    EdgeId, FaceId, HalfEdgeId, PerEdge, PerFace, PerVertex, Topology, TriangleSurface, Vec3,
    VertexId,
};

/// Square of the longest edge over the area, that of an equilateral triangle being 1, from which on
/// a triangle is long: one that is half of a rectangle of sides 2 and 5 has 2.5.
const LONG: f64 = 2.5;
/// Share of the area in long triangles, and in large ones at creases, from which on they are cut:
/// meshes of CAD programs have .15 to .6, those of rows and of marching cubes less.
const MUCH: f64 = 0.15;
/// Share of the area in triangles that are large among many that are not from which on they are
/// cut: the flat end of a lathed body that is one fan has about as much.
const UNEVEN: f64 = 0.1;
/// Edge from which on a triangle is large: at a crease in units of the spacing, elsewhere in those
/// of the spacing of as many triangles as there are, if that is more.
const LARGE: f64 = 2.0;
/// Longest edge that is left, in units of the spacing: half of it, as inputs have that are finer
/// than panels need.
const LONGEST: f64 = 0.5;
/// Edges that are longer than that by no more are left where nothing longer is: diagonals of
/// rectangles whose sides are short enough.
const DIAGONAL: f64 = 1.5;
/// Vertices after which no round begins, over those that are wanted, and over those given: needles
/// without end are not cut without end.
const MANY: usize = 40;
const MORE: usize = 4;
/// Times that edges are halved at the most.
const ROUNDS: usize = 12;
/// Largest area of a plane face at a vertex, over the least one there, from which on areas count.
const UNLIKE: f64 = 2.0;
/// Cosine of the angle between triangles of one plane face: single precision turns slivers by less.
const IN_ONE_PLANE: f64 = 1.0 - 2e-6;
/// Turn of the boundary, degrees, from which on a vertex is a corner.
const CORNER: f64 = 40.0;
/// Height over the boundary, in units of the spacing, below which a triangle there is taken away.
const SLIVER: f64 = 0.05;

/// A surface whose long triangles are cut short.
pub(crate) struct CutShort {
    /// The surface; its first vertices are those of the other one.
    pub surface: TriangleSurface,
    opened: Opened,
    steps: Vec<Refinement>,
}

impl CutShort {
    /// Values at its vertices from those of the surface with long triangles.
    pub fn carried(&self, values: PerVertex<f64>) -> PerVertex<f64> {
        let values = self.opened.opened(&values);
        let values = self.steps.iter().fold(values, |v, step| step.apply(&v));
        self.opened.closed(&values)
    }
}

/// The surface with edges no longer than 3/4 of the spacing of `wanted` vertices; `None` where most
/// triangles are about as wide as long, small at creases and, for panels of one size (`evenly`), of
/// about one size. Edges in one of the `mirrors`, each a point of a plane and its unit normal, stay
/// in it.
pub(crate) fn cut_short(
    surface: &TriangleSurface,
    (wanted, evenly): (usize, bool),
    mirrors: &[[Vec3; 2]],
) -> Option<CutShort> {
    let spacing = spacing(surface, wanted);
    if !(is_elongated(surface, spacing) || evenly && is_uneven(surface, spacing)) {
        return None;
    }
    let mut steps = Vec::new();
    let calm = without_slivers(surface, SLIVER * spacing, mirrors);
    let (mut opened, open) = Opened::along_creases(calm.as_ref().unwrap_or(surface));
    let open = with_flat_normals(open);
    let normals = arched_normals(&open);
    let mut now = open.with_normals(normals);
    let most = (MANY * wanted).max(MORE * now.positions().len());
    for _ in 0..ROUNDS {
        if now.positions().len() > most {
            break;
        }
        let Some((finer, step, split)) = halved(&now, LONGEST * spacing, mirrors) else {
            break;
        };
        opened.split(&now, &split);
        now = opened.in_step(finer);
        steps.push(step);
    }
    let surface = opened.glued(&now)?;
    Some(CutShort {
        surface,
        opened,
        steps,
    })
}

/// The surface with normals for which, where large plane faces meet small ones, each triangle
/// counts by its angle at the vertex and by the area of the plane face that it is a part of: where
/// a fillet runs into a plane face the normal is that of the plane, which would bulge over all of
/// its length otherwise.
fn with_flat_normals(surface: TriangleSurface) -> TriangleSurface {
    let topology = surface.topology();
    let area = areas_of_plane_faces(&surface);
    let normals = PerVertex::from_fn(topology.n_vertices(), |v| {
        let own = surface.normals()[v];
        let sizes = topology.faces_at(v).map(|f| area[f]);
        let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(l, m), a| (a.min(l), a.max(m)));
        if most < UNLIKE * least {
            return own;
        }
        let of_triangle = |h: HalfEdgeId| {
            let [next, before] = [topology.target(h), topology.origin(topology.prev(h))];
            let way = |w: VertexId| surface.positions()[w] - surface.positions()[v];
            let f = topology.face(h);
            let normal = surface.area_vector(f).try_normalize(0.0);
            normal.map_or(Vec3::zeros(), |n| {
                n * (way(next).angle(&way(before)) * area[f])
            })
        };
        let sum: Vec3 = topology.outgoing(v).map(of_triangle).sum();
        sum.try_normalize(0.0).unwrap_or(own)
    });
    surface.with_normals(normals)
}

/// Area of the plane face that each triangle is a part of.
fn areas_of_plane_faces(surface: &TriangleSurface) -> PerFace<f64> {
    let topology = surface.topology();
    let normal = PerFace::from_fn(topology.n_faces(), |f| {
        surface.area_vector(f).try_normalize(0.0)
    });
    let are_one = |f: FaceId, g: FaceId| {
        let pair = normal[f].zip(normal[g]);
        pair.is_some_and(|(m, n)| m.dot(&n) > IN_ONE_PLANE)
    };
    let mut area = PerFace::filled(topology.n_faces(), f64::NAN);
    for first in topology.faces() {
        if !area[first].is_nan() {
            continue;
        }
        area[first] = 0.0;
        let (mut part, mut done) = (vec![first], 0);
        while done < part.len() {
            let f = part[done];
            done += 1;
            for g in topology.adjacent_faces(f) {
                if area[g].is_nan() && are_one(f, g) {
                    area[g] = 0.0;
                    part.push(g);
                }
            }
        }
        let whole: f64 = part.iter().map(|f| surface.face_area(*f)).sum();
        part.iter().for_each(|f| area[*f] = whole);
    }
    area
}

/// Normals with which the surface goes on bending up to its boundary: triangles there lie on one
/// side of a vertex, and their normals are those half-way to the next one. An arc has the normals
/// of one end at the other, mirrored across the edge between them.
fn arched_normals(surface: &TriangleSurface) -> PerVertex<Vec3> {
    let topology = surface.topology();
    PerVertex::from_fn(topology.n_vertices(), |v| {
        let inside = |w: &VertexId| !topology.is_boundary_vertex(*w);
        let neighbours = topology.neighbours(v).into_iter().filter(inside);
        let mirrored = |w: VertexId| {
            let (n, along) = (
                surface.normals()[w],
                surface.positions()[w] - surface.positions()[v],
            );
            let square = along.norm_squared();
            (n - along * (2.0 * n.dot(&along) / square)) / square.sqrt()
        };
        let sum: Vec3 = neighbours.map(mirrored).sum();
        let arched = sum
            .try_normalize(0.0)
            .filter(|_| topology.is_boundary_vertex(v));
        arched.unwrap_or(surface.normals()[v])
    })
}

/// Whether much of a surface is in triangles that are large among many that are not: where the
/// spacing is theirs panels of one size would be as uneven as the triangles.
fn is_uneven(surface: &TriangleSurface, wanted: f64) -> bool {
    let faces = surface.topology().faces();
    let even = wanted.max(spacing(surface, faces.len() / 2));
    let is_large = |f: &FaceId| longest_side(surface, *f) > LARGE * even;
    let large: f64 = faces.filter(is_large).map(|f| surface.face_area(f)).sum();
    large > UNEVEN * surface.area()
}

fn longest_side(surface: &TriangleSurface, f: FaceId) -> f64 {
    let [a, b, c] = surface.corners(f);
    let sides = [b - a, c - b, a - c].map(|side| side.norm());
    sides.into_iter().fold(0.0, f64::max)
}

/// Whether much of a surface is in triangles that are long, or large and at creases.
fn is_elongated(surface: &TriangleSurface, spacing: f64) -> bool {
    let equilateral = 0.25 * 3.0_f64.sqrt();
    let topology = surface.topology();
    let mut at_crease = PerVertex::filled(topology.n_vertices(), false);
    for (e, _) in creases(surface).enumerate().filter(|(_, is)| **is) {
        let ends = topology.edge_vertices(e);
        ends.into_iter().for_each(|v| at_crease[v] = true);
    }
    let area = |f: FaceId| surface.face_area(f);
    let is_long = |f: &FaceId| {
        let longest = longest_side(surface, *f);
        let touches = || topology.face_vertices(*f).iter().any(|v| at_crease[*v]);
        let is_large = longest > LARGE * spacing;
        equilateral * longest * longest > LONG * area(*f) || is_large && touches()
    };
    let long: f64 = topology.faces().filter(is_long).map(area).sum();
    long > MUCH * surface.area()
}

/// The surface with its edges longer than a limit split in two, and these edges; `None` if there
/// are none.
fn halved(
    surface: &TriangleSurface,
    limit: f64,
    mirrors: &[[Vec3; 2]],
) -> Option<(TriangleSurface, Refinement, Vec<EdgeId>)> {
    let topology = surface.topology();
    let place = |v| surface.positions()[v];
    let length = PerEdge::from_fn(topology.n_edges(), |e| {
        let [a, b] = topology.edge_vertices(e);
        (place(a) - place(b)).norm()
    });
    if length.iter().all(|l| *l <= DIAGONAL * limit) {
        return None;
    }
    let length = without_diagonals(topology, length, limit);
    let mut split_once = SmoothTarget::of(surface.clone()).split_longer(0, &length, limit)?;
    let (mut levels, step) = (split_once.levels, split_once.refinements.remove(0));
    let split: Vec<EdgeId> = topology.edges().filter(|e| length[*e] > limit).collect();
    let normals = split.iter();
    let normals = normals.map(|e| middle_normal(surface, topology.edge_vertices(*e)));
    let normals = surface.normals().iter().copied().chain(normals);
    let normals = PerVertex::from_vec(normals.collect());
    let surface = levels.remove(1);
    let lines = BoundaryLines::of(&levels[0]);
    let middles = split.iter().map(|e| lines.middle(&levels[0], *e));
    let on_lines: Vec<Option<Vec3>> = middles.collect();
    let first = topology.n_vertices();
    let placed = |v: VertexId, p: Vec3| {
        let new = v.index().checked_sub(first);
        new.and_then(|k| on_lines[k]).unwrap_or(p)
    };
    let near = IN_PLANE * surface.diagonal();
    let half_way = step.apply(levels[0].positions());
    let held = surface.positions().enumerate().map(|(v, p)| {
        let holds = |[o, n]: &&[Vec3; 2]| n.dot(&(half_way[v] - o)).abs() <= near;
        let planes = mirrors.iter().filter(holds);
        planes.fold(placed(v, *p), |p, [o, n]| p - n * n.dot(&(p - o)))
    });
    let held = PerVertex::from_vec(held.collect());
    // Edges turn in the planes of the long triangles: bent along a strip, half of one is steep.
    let flat = TriangleSurface::from_topology(half_way, surface.topology().clone());
    let turned = delaunay(&flat).topology().clone();
    let finer = TriangleSurface::from_topology(held, turned).with_normals(normals);
    Some((finer, step, split))
}

/// The boundary of a surface, which bends by itself: along a cut in a plane normals are tilted.
struct BoundaryLines {
    /// The vertices before and after each vertex of the boundary.
    beside: PerVertex<Option<[VertexId; 2]>>,
}

impl BoundaryLines {
    fn of(surface: &TriangleSurface) -> Self {
        let mut beside = PerVertex::filled(surface.topology().n_vertices(), None);
        for line in surface.topology().boundary_loops() {
            let n = line.len();
            for (i, v) in line.iter().enumerate() {
                beside[*v] = Some([line[(i + n - 1) % n], line[(i + 1) % n]]);
            }
        }
        Self { beside }
    }

    /// The middle of the cubic over an edge of the boundary; its tangents at vertices that are no
    /// corners run along the line between the two beside them: where an arc runs into a straight
    /// line, which is longer, that stays straight. `None` for an edge inside.
    fn middle(&self, surface: &TriangleSurface, e: EdgeId) -> Option<Vec3> {
        if !surface.topology().is_boundary_edge(e) {
            return None;
        }
        let [a, b] = surface.topology().edge_vertices(e);
        let [[a0, a1], [b0, b1]] = [self.beside[a]?, self.beside[b]?];
        let (before, after) = if a1 == b { (a0, b1) } else { (a1, b0) };
        let [o, p, q, r] = [before, a, b, after].map(|v| surface.positions()[v]);
        let (along, length) = (q - p, (q - p).norm());
        let tangent = |way: Vec3| {
            let far = way.norm();
            let is_corner = way.angle(&along).to_degrees() > CORNER;
            (!is_corner).then(|| (way + along) * (length / (far + length)))
        };
        let [at_p, at_q] = match [tangent(p - o), tangent(r - q)] {
            [Some(s), Some(t)] => [s, t],
            [Some(s), None] => [s, along * 2.0 - s],
            [None, Some(t)] => [along * 2.0 - t, t],
            [None, None] => [along, along],
        };
        Some((p + q) * 0.5 + (at_p - at_q) * 0.125)
    }
}

/// The lengths of edges, those that are longest in each of their triangles no longer than the limit
/// where others are: two sides of a strip are halved, and the diagonal between them turns. Halved
/// with them it would halve the width of the strip, too.
fn without_diagonals(topology: &Topology, length: PerEdge<f64>, limit: f64) -> PerEdge<f64> {
    let is_side = |e: EdgeId| {
        let h = topology.edge_half_edge(e);
        let mut faces = [Some(h), topology.twin(h)].into_iter().flatten();
        let is_longest = |h| {
            let mut sides = topology.face_half_edges(topology.face(h));
            sides.all(|k| length[topology.edge(k)] <= length[e])
        };
        // An edge of the boundary is no diagonal.
        topology.is_boundary_edge(e) || !faces.all(is_longest)
    };
    if !topology.edges().any(|e| length[e] > limit && is_side(e)) {
        return length;
    }
    PerEdge::from_fn(topology.n_edges(), |e| match is_side(e) {
        true => length[e],
        false => length[e].min(limit),
    })
}

/// The normal in the middle of an edge of a surface whose normals change quadratically along it
/// (Vlachos et al., as above): those of short and narrow triangles would tell of rounding.
fn middle_normal(surface: &TriangleSurface, ends: [VertexId; 2]) -> Vec3 {
    let [p, q] = ends.map(|v| surface.positions()[v]);
    let [m, n] = ends.map(|v| surface.normals()[v]);
    let (along, sum) = (q - p, m + n);
    let bent = sum - along * (2.0 * along.dot(&sum) / along.norm_squared());
    bent.try_normalize(0.0).unwrap_or(m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A vault of `along` by `around` rectangles, half a turn of a cylinder of radius 1.
    fn vault(along: u32, around: u32) -> TriangleSurface {
        let id = |i: u32, j: u32| i * (around + 1) + j;
        let place = |i: u32, j: u32| {
            let angle = std::f64::consts::PI * f64::from(j) / f64::from(around);
            Vec3::new(
                3.0 * f64::from(i) / f64::from(along),
                angle.cos(),
                angle.sin(),
            )
        };
        let places = (0..=along).flat_map(|i| (0..=around).map(move |j| place(i, j)));
        let cells = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        TriangleSurface::new(places.collect(), &triangles.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn strips_of_a_vault_are_cut_along_it() {
        let strips = vault(1, 40);
        let cut = cut_short(&strips, (500, true), &[]).unwrap();
        let topology = cut.surface.topology();
        assert_eq!(topology.euler_characteristic(), 1);
        let most = DIAGONAL * LONGEST * (strips.area() * 2.0 / (3.0_f64.sqrt() * 500.0)).sqrt();
        for e in topology.edges() {
            assert!(cut.surface.edge_length(e) <= most);
        }
        // Facets are off by 1 - cos(pi / 80), 8e-4, in their middles; so are normals at the ends.
        let off = |p: &Vec3| (p.y.hypot(p.z) - 1.0).abs();
        let places = cut.surface.positions();
        let mean = places.iter().map(off).sum::<f64>() / places.len() as f64;
        let worst = places.iter().map(off).fold(0.0, f64::max);
        assert!(mean < 5e-5 && worst < 5e-4, "{mean} {worst}");
        // Values that are linear along the vault stay so.
        let along = cut.carried(strips.positions().map(|p| p.x));
        for (v, x) in along.enumerate() {
            assert!((x - cut.surface.positions()[v].x).abs() < 1e-3);
        }
    }

    /// A cylinder of radius 1 and length 4 with its bases, as strips and two fans.
    fn can(around: u32) -> TriangleSurface {
        let rim = |z: f64| {
            (0..around).map(move |k| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(around);
                Vec3::new(angle.cos(), angle.sin(), z)
            })
        };
        let centres = [0.0, 4.0].map(|z| Vec3::new(0.0, 0.0, z));
        let places: Vec<Vec3> = rim(0.0).chain(rim(4.0)).chain(centres).collect();
        let triangles = (0..around).flat_map(|k| {
            let [a, b] = [k, (k + 1) % around];
            let [c, d] = [a + around, b + around];
            let [low, high] = [2 * around, 2 * around + 1];
            [[a, b, d], [a, d, c], [b, a, low], [c, d, high]]
        });
        TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap()
    }

    /// Normals at a rim that know both sides would bulge the strips by a tenth of their length.
    #[test]
    fn a_rim_stays_sharp_and_round() {
        let around = 48;
        let can = can(around);
        let cut = cut_short(&can, (1000, true), &[]).unwrap();
        let topology = cut.surface.topology();
        assert_eq!(topology.euler_characteristic(), 2);
        let sagitta = 1.0 - (std::f64::consts::PI / f64::from(around)).cos();
        let count = cut.surface.positions().len();
        let (mut on_rim, mut on_base) = (0, 0);
        for (v, p) in cut.surface.positions().enumerate() {
            let (radius, off) = (p.x.hypot(p.y), p.z.min(4.0 - p.z));
            let is_side = (radius - 1.0).abs() <= 0.6 * sagitta && off > -1e-12;
            let is_base = off.abs() < 1e-12 && radius < 1.0;
            assert!(is_side || is_base, "{v:?} at {p}");
            on_rim += usize::from(is_side && off < 1e-12);
            on_base += usize::from(!is_side);
        }
        assert!(
            on_rim >= 4 * around as usize && on_base > count / 20,
            "{on_rim} {on_base}"
        );
        let heights = cut.carried(can.positions().map(|p| p.z));
        for (v, z) in heights.enumerate() {
            assert!((z - cut.surface.positions()[v].z).abs() < 0.1);
        }
    }

    #[test]
    fn the_boundary_bends_as_the_inside_does() {
        // Four strips round the axis, each a quarter of 180 degrees, and many rows along it.
        let steep = vault(200, 4);
        let normals = arched_normals(&steep);
        for (v, n) in normals
            .enumerate()
            .filter(|(v, _)| steep.topology().is_boundary_vertex(*v))
        {
            let p = steep.positions()[v];
            // Corners have no neighbour inside, or one.
            if p.y.abs() < 0.99 || (p.x - 1.5).abs() > 1.4 {
                continue;
            }
            let inwards = Vec3::new(0.0, -p.y, -p.z);
            let [arched, given] = [*n, steep.normals()[v]].map(|n| n.angle(&inwards).to_degrees());
            assert!(arched < 1.0 && given > 20.0, "{arched} {given}");
        }
    }

    #[test]
    fn a_boundary_in_a_plane_stays_there() {
        // A paraboloid over a square of side 2, bent along its eight strips, where normals at the
        // boundary are tilted.
        let flat = vault(8, 200);
        let bent = |(v, _): (VertexId, &Vec3)| {
            let (i, j) = (v.index() / 201, v.index() % 201);
            let (x, y) = (i as f64 / 4.0 - 1.0, j as f64 / 100.0 - 1.0);
            Vec3::new(x, y, -0.5 * (x * x + y * y))
        };
        let places = flat.positions().enumerate().map(bent).collect();
        let cap =
            TriangleSurface::from_topology(PerVertex::from_vec(places), flat.topology().clone());
        let cut = cut_short(&cap, (1000, true), &[]).unwrap();
        let topology = cut.surface.topology();
        for (v, p) in cut.surface.positions().enumerate() {
            let beyond = p.x.abs().max(p.y.abs()) - 1.0;
            assert!(beyond < 1e-3, "{p}");
            assert!(
                !topology.is_boundary_vertex(v) || beyond.abs() < 1e-12,
                "{p}"
            );
        }
    }

    #[test]
    fn needles_are_not_cut_without_end() {
        let needles = vault(1, 4000);
        let cut = cut_short(&needles, (10, true), &[]).unwrap();
        assert!(cut.surface.positions().len() < 10 * needles.positions().len());
    }

    #[test]
    fn triangles_about_as_wide_as_long_stay() {
        assert!(cut_short(&vault(40, 40), (5000, true), &[]).is_none());
        assert!(cut_short(&vault(16, 40), (5000, true), &[]).is_none());
    }

    #[test]
    fn large_triangles_among_small_ones_are_cut_for_panels_of_one_size() {
        // Half of an annulus in squares that grow with the radius, from 0.04 to 1.
        let grown = |p: &Vec3| {
            let (angle, radius) = (p.z.atan2(p.y), (PI * (p.x / 3.0 - 1.0)).exp());
            Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let even = vault(40, 40);
        let places = even.positions().map(grown);
        let graded = TriangleSurface::from_topology(places, even.topology().clone());
        let cut = cut_short(&graded, (1000, true), &[]).unwrap().surface;
        let mut edges = cut.topology().edges();
        let most = DIAGONAL * LONGEST * spacing(&graded, 1000);
        assert!(edges.all(|e| cut.edge_length(e) <= most));
        assert!(cut_short(&graded, (1000, false), &[]).is_none());
    }

    #[test]
    fn what_lies_in_a_mirror_plane_stays_in_it() {
        let tilted = vault(1, 40);
        // Normals at the edge of half a ball's strip are not in the plane of its boundary.
        let narrower = |p: &Vec3| Vec3::new(p.x, p.y * (1.0 - 0.2 * p.x), p.z * (1.0 - 0.2 * p.x));
        let tilted = TriangleSurface::from_topology(
            tilted.positions().map(narrower),
            tilted.topology().clone(),
        );
        let cut = cut_short(&tilted, (500, true), &[[Vec3::zeros(), Vec3::x()]]).unwrap();
        let at_end = cut.surface.topology().boundary_loops().concat();
        let places = at_end.iter().map(|v| cut.surface.positions()[*v]);
        let in_plane = places.filter(|p| p.x.abs() < 1e-3);
        let (mut count, mut worst) = (0, 0.0_f64);
        in_plane.for_each(|p| (count, worst) = (count + 1, worst.max(p.x.abs())));
        assert!(count > 41 && worst < 1e-15, "{count} {worst}");
    }

    #[test]
    fn both_sides_of_a_crease_are_split_together() {
        // A disc with lobes, extruded: corners of its outline lie on creases.
        let n = 90;
        let rim = |z: f64| {
            (0..n).map(move |i| {
                let a = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                let r = 1.0 + 0.25 * (9.0 * a).cos().signum();
                Vec3::new(r * a.cos(), r * a.sin(), z)
            })
        };
        let centres = [0.0, 0.4].map(|z| Vec3::new(0.0, 0.0, z));
        let places: Vec<Vec3> = rim(0.0).chain(rim(0.4)).chain(centres).collect();
        let n = n as u32;
        let triangles = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [
                [i, j, j + n],
                [i, j + n, i + n],
                [j, i, 2 * n],
                [i + n, j + n, 2 * n + 1],
            ]
        });
        let body = TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap();
        for wanted in (1..12).map(|k| 700 * k) {
            let cut = cut_short(&body, (wanted, true), &[]).unwrap().surface;
            let topology = cut.topology();
            assert!(
                topology.is_closed() && topology.euler_characteristic() == 2,
                "{wanted}"
            );
        }
    }

    #[test]
    fn a_plane_face_stays_plane_beside_a_fillet() {
        // A plate of 4 by 4 that ends in a quarter of a round of radius .5, six strips wide.
        let across = |k: usize| match k {
            0 => Vec3::zeros(),
            _ => {
                let a = 15.0_f64.to_radians() * (k - 1) as f64;
                Vec3::new(4.0 + 0.5 * a.sin(), 0.0, 0.5 * a.cos() - 0.5)
            }
        };
        let places = (0..8).flat_map(|k| [across(k), across(k) + 4.0 * Vec3::y()]);
        let triangles = (0..7)
            .map(|k| 2 * k)
            .flat_map(|a| [[a, a + 2, a + 3], [a, a + 3, a + 1]]);
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let plate = TriangleSurface::new(places.collect(), &triangles).unwrap();
        let cut = cut_short(&plate, (600, true), &[]).unwrap().surface;
        let off = cut
            .positions()
            .iter()
            .filter(|p| p.x < 3.9)
            .map(|p| p.z.abs());
        let most = off.fold(0.0, f64::max);
        assert!(most < 5e-3, "{most}");
    }
}
