//! Embeds the viewer where `cargo xtask viewer` has built it.

use std::path::Path;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bundle");
    let bundle = folder.join("viewer.js");
    println!("cargo::rerun-if-changed={}", folder.display());
    println!("cargo::rustc-check-cfg=cfg(viewer_bundle)");
    if bundle.is_file() {
        println!("cargo::rustc-cfg=viewer_bundle");
        println!("cargo::rustc-env=PHEX_VIEWER={}", bundle.display());
    }
}
