//! What is held, shared out among the connected parts of a surface.

use super::wishes::{GroundPlane, Steering};
use crate::optimise::{SurfaceTarget, Target};
use phex_mesh::{TriangleSurface, Vec3};

impl Steering {
    /// What concerns each of several surfaces that are panelled one by one: points, anchors and
    /// curves go to the nearest, ground planes to those whose boundary reaches them, with panels of
    /// edge length `edge` (model units); a plane that none reaches goes to all, so that it is
    /// refused. Numbers of vertices belong to no surface and are left out.
    pub fn shared(&self, surfaces: &[TriangleSurface], edge: f64) -> Vec<Self> {
        let targets: Vec<SurfaceTarget> = surfaces.iter().map(SurfaceTarget::new).collect();
        let mut shares = vec![Self::default(); surfaces.len()];
        for &p in &self.fixed_points {
            shares[nearest(&targets, &[p])].fixed_points.push(p);
        }
        for &anchor in &self.anchors {
            shares[nearest(&targets, &[anchor.point])]
                .anchors
                .push(anchor);
        }
        for curve in &self.curves {
            shares[nearest(&targets, curve)].curves.push(curve.clone());
        }
        for ground in &self.grounds {
            let ground = placed(*ground, surfaces);
            let touched: Vec<bool> = surfaces.iter().map(|s| reaches(s, &ground, edge)).collect();
            let none = !touched.contains(&true);
            let takers = shares.iter_mut().zip(touched).filter(|(_, on)| *on || none);
            takers.for_each(|(share, _)| share.grounds.push(ground));
        }
        shares
    }
}

/// The target to which some points are nearest on the whole.
fn nearest(targets: &[SurfaceTarget<'_>], points: &[[f64; 3]]) -> usize {
    let points: Vec<Vec3> = points.iter().map(|&p| Vec3::from(p)).collect();
    let distance = |target: &SurfaceTarget<'_>| {
        let feet = target.closest_points(&points, &[]);
        let pairs = feet.iter().zip(&points);
        pairs
            .map(|(foot, p)| (foot.position - p).norm())
            .sum::<f64>()
    };
    let distances: Vec<f64> = targets.iter().map(distance).collect();
    let order = |a: &usize, b: &usize| distances[*a].total_cmp(&distances[*b]);
    (0..targets.len()).min_by(order).unwrap_or(0)
}

fn boundary(surface: &TriangleSurface) -> impl Iterator<Item = Vec3> + '_ {
    let rim = surface.topology().boundary_vertices();
    rim.map(|v| surface.positions()[v])
}

/// A ground plane with its point: the lowest of the boundaries of all surfaces, if it has none.
fn placed(mut ground: GroundPlane, surfaces: &[TriangleSurface]) -> GroundPlane {
    let normal = Vec3::from(ground.normal);
    let height = |p: &Vec3| normal.dot(p);
    let all = surfaces.iter().flat_map(boundary);
    let lowest = all.min_by(|p, q| height(p).total_cmp(&height(q)));
    ground.point = ground.point.or(lowest.map(Into::into));
    ground
}

/// Whether the boundary of a surface comes within the reach of a placed plane.
fn reaches(surface: &TriangleSurface, ground: &GroundPlane, edge: f64) -> bool {
    let normal = Vec3::from(ground.normal);
    let Some(point) = ground.point.map(Vec3::from) else {
        return false;
    };
    let reach = ground.farthest() * edge * normal.norm();
    boundary(surface).any(|p| normal.dot(&(p - point)).abs() <= reach)
}
