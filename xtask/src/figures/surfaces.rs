//! The surfaces of the table and the figures, each with the commands that make it.

use super::run::WORK;

/// Names of the surfaces of the table.
pub const SURFACES: [&str; 7] = [
    "sphere",
    "ellipsoid",
    "blob",
    "torus",
    "wave",
    "monkey-saddle",
    "b-spline",
];

/// The commands that make a surface in the work folder.
pub fn commands(name: &str) -> Vec<String> {
    let shape =
        |shape: &str| format!("phex shape {shape} --triangles 6000 -o {WORK}/{shape}.obj -q");
    let step = |words: &str, out: &str| {
        format!("cargo xtask obj {words} {WORK}/sphere.obj -o {WORK}/{out}.obj")
    };
    match name {
        "blob" => vec![shape("sphere"), step("blob", "blob")],
        "dome" => vec![shape("sphere"), step("above z 0.05", "dome")],
        other => vec![shape(other)],
    }
}
