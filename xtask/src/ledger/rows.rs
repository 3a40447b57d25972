//! The rows: every kind of surface that users bring, at sizes that are set once and for all.

use super::made;
use crate::figures::Obj;
use std::path::Path;

/// One surface at one size.
pub struct LedgerRow {
    /// Name, which never changes.
    pub name: &'static str,
    /// Where the surface comes from.
    pub surface: LedgerSurface,
    /// Options of `phex mesh`.
    pub options: &'static str,
    /// Whether `cargo xtask check` makes it.
    pub quick: bool,
}

/// Where a surface comes from.
pub enum LedgerSurface {
    /// Options of `phex shape`.
    Shape(&'static str),
    /// A formula of the tool.
    Made(fn() -> Obj),
    /// A file of the repository.
    Kept(&'static str),
    /// A file in the folder of models, where there is one.
    Model(&'static str),
}

impl LedgerSurface {
    /// Whether the surface can be had.
    pub fn is_there(&self, models: &Path) -> bool {
        match self {
            Self::Model(path) => models.join(path).is_file(),
            _ => true,
        }
    }
}

const fn row(name: &'static str, surface: LedgerSurface, options: &'static str) -> LedgerRow {
    LedgerRow {
        name,
        surface,
        options,
        quick: false,
    }
}

const fn quick(name: &'static str, surface: LedgerSurface, options: &'static str) -> LedgerRow {
    LedgerRow {
        quick: true,
        ..row(name, surface, options)
    }
}

use LedgerSurface::{Kept, Made, Model, Shape};

/// All rows, easy ones first within each kind.
pub const ROWS: [LedgerRow; 57] = [
    // Open, built in.
    quick("plane", Shape("plane"), "-n 200"),
    quick("cylinder", Shape("cylinder"), "-n 300"),
    quick("wave", Shape("wave"), "-n 300"),
    row("wave-1000", Shape("wave"), "-n 1000"),
    row("wave-edge-length", Shape("wave"), "--edge-length 0.2"),
    quick("hypar", Shape("hyperbolic-paraboloid"), "-n 200"),
    row(
        "hypar-deviation",
        Shape("hyperbolic-paraboloid"),
        "-n 200 --max-deviation 0.15%",
    ),
    row("monkey-saddle", Shape("monkey-saddle"), "-n 300"),
    quick("elliptic-dome", Shape("elliptic-paraboloid"), "-n 200"),
    row("catenoid", Shape("catenoid"), "-n 400"),
    row("hyperboloid", Shape("hyperboloid"), "-n 400"),
    row("helicoid", Shape("helicoid"), "-n 300"),
    row("enneper", Shape("enneper"), "-n 300"),
    row("b-spline", Shape("b-spline"), "-n 600"),
    row(
        "b-spline-whole",
        Shape("b-spline"),
        "-n 600 --boundary whole",
    ),
    row("b-spline-clip", Shape("b-spline"), "-n 600 --boundary clip"),
    row("b-spline-adaptive", Shape("b-spline"), "-n 600 --adaptive"),
    row(
        "b-spline-deviation",
        Shape("b-spline"),
        "-n 600 --max-deviation 0.15%",
    ),
    row("b-spline-coarse", Shape("b-spline"), "-n 80"),
    row("roof", Kept("data/roof.obj"), "-n 500"),
    row(
        "roof-whole",
        Kept("data/roof.obj"),
        "-n 500 --boundary whole",
    ),
    row(
        "brick-wall",
        Shape("catenoid"),
        "-n 300 --method brick-wall",
    ),
    // Closed, regular.
    quick("sphere", Shape("sphere"), "-n 200"),
    quick("torus", Shape("torus"), "-n 400"),
    row("ellipsoid", Shape("ellipsoid"), "-n 400"),
    row("long-ellipsoid", Made(made::long_ellipsoid), "-n 600"),
    row("blob", Made(made::blob), "-n 500"),
    row("trefoil", Made(made::trefoil), "-n 600"),
    row("bumpy-ring", Made(made::bumpy_ring), "-n 500"),
    // Hard ones that the tool makes.
    row("wild", Made(made::wild), "-n 500"),
    row("noisy-scan", Made(made::noisy_scan), "-n 500"),
    row("plate-holes", Made(made::plate_with_holes), "-n 600"),
    row(
        "plate-holes-clip",
        Made(made::plate_with_holes),
        "-n 600 --boundary clip",
    ),
    quick("corners", Made(made::shell_with_corners), "-n 200"),
    row("dumbbell", Made(made::dumbbell), "-n 400"),
    row("double-torus", Made(made::double_torus), "-n 600"),
    row("ears", Made(made::eared_body), "-n 600"),
    row("ears-adaptive", Made(made::eared_body), "-n 800 --adaptive"),
    row("block-rings", Made(made::block_with_rings), "-n 800"),
    // Models from elsewhere.
    row("metro", Model("phcpf/metro.off"), "-n 800"),
    row(
        "metro-deviation",
        Model("phcpf/metro.off"),
        "-n 800 --max-deviation 0.15%",
    ),
    row("car", Model("phcpf/car_r.off"), "-n 800"),
    row("c-s0", Model("phcpf/c_s0.off"), "-n 800"),
    row("sphere2con", Model("phcpf/sphere2con_s0.off"), "-n 800"),
    row("vase", Model("phcpf/vase.off"), "-n 800"),
    row(
        "aqua-center",
        Model("repo-level/directional/aqua-center.off"),
        "-n 500",
    ),
    row(
        "aqua-center-clip",
        Model("repo-level/directional/aqua-center.off"),
        "-n 500 --boundary clip",
    ),
    row("dome", Model("repo-level/directional/dome.off"), "-n 500"),
    row(
        "bubble",
        Model("repo-level/directional/botanic-garden-bubble.off"),
        "-n 500",
    ),
    row(
        "half-torus",
        Model("repo-level/directional/half-torus.obj"),
        "-n 500",
    ),
    row(
        "half-torus-clip",
        Model("repo-level/directional/half-torus.obj"),
        "-n 500 --boundary clip",
    ),
    row("eight", Model("repo-level/directional/eight.off"), "-n 500"),
    row(
        "spot-adaptive",
        Model("odedstein/spot.obj"),
        "-n 2000 --adaptive",
    ),
    row(
        "penguin-adaptive",
        Model("odedstein/penguin.obj"),
        "-n 2000 --adaptive",
    ),
    row(
        "skull-adaptive",
        Model("odedstein/skull_low_resolution.obj"),
        "-n 2000 --adaptive",
    ),
    row("plane-holes", Model("odedstein/plane_holes.obj"), "-n 1500"),
    row("round", Model("repo-level/trimesh/round.stl"), "-n 400"),
];
