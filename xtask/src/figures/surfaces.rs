//! The surfaces of the table and the figures.

use super::obj::Obj;
use super::run::{Phex, WORK};

/// Name of each surface of the table, and the built-in shape that it is made of.
pub const SURFACES: [(&str, &str); 7] = [
    ("sphere", "sphere"),
    ("ellipsoid", "ellipsoid"),
    ("blob", "sphere"),
    ("torus", "torus"),
    ("wave", "wave"),
    ("monkey-saddle", "monkey-saddle"),
    ("b-spline", "b-spline"),
];

/// Writes all of them.
pub fn make(phex: &Phex) -> Result<(), String> {
    for (name, shape) in SURFACES {
        phex.make(&format!(
            "shape {shape} --triangles 6000 -o {WORK}/{name}.obj -q"
        ))?;
    }
    let path = phex.work("blob.obj");
    Obj::read(&path)?.mapped(superellipsoid).write(&path)?;
    let dome = Obj::read(&phex.work("sphere.obj"))?.part(|c| c[2] > 0.05);
    dome.write(&phex.work("dome.obj"))
}

/// The point of `|x|^3.5 + |y / 0.9|^3.5 + |z / 0.7|^3.5 = 1` in a direction: convex, with six nearly flat parts.
fn superellipsoid(d: [f64; 3]) -> [f64; 3] {
    const EXPONENT: f64 = 3.5;
    let axes = [1.0, 0.9, 0.7];
    let sum: f64 = (0..3).map(|k| (d[k] / axes[k]).abs().powf(EXPONENT)).sum();
    d.map(|x| x * sum.powf(-1.0 / EXPONENT))
}
