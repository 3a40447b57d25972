//! Ctrl-C ends the program with 130 and leaves no half-written file.

#![cfg(unix)]
use crate::common::Workshop;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn interruption_ends_a_long_run_at_once_and_leaves_files_alone() {
    let shop = Workshop::new();
    shop.succeed("shape torus -o torus.obj --triangles 60000");
    shop.write("out.obj", "precious");
    let before = shop.files();
    let mut child = shop
        .command(
            "mesh torus.obj -o out.obj -n 40000 --report run.json --png out.png --progress json",
        )
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut line = String::new();
    stderr.read_line(&mut line).expect("a first event");
    assert!(line.contains("stage_started"), "{line}");

    let sent = Instant::now();
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .expect("kill exists");
    assert!(kill.success());
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    assert!(
        sent.elapsed() < Duration::from_secs(10),
        "it took {:?}",
        sent.elapsed()
    );
    assert_eq!(
        shop.files(),
        before,
        "nothing half-written, nothing temporary"
    );
    assert_eq!(shop.read("out.obj"), b"precious");
}

/// A limit that no panels keep to makes the program try whatever it knows: once there is a mesh, an
/// interruption ends that, and the mesh is judged and written.
#[test]
fn the_best_mesh_so_far_is_kept_on_request() {
    let shop = Workshop::new();
    shop.succeed("shape elliptic-paraboloid -o dome.obj --triangles 1500");
    let mut child = shop
        .command(
            "mesh dome.obj -o out.obj -n 80 --max-deviation 0.001% --keep-best --report run.json --progress json",
        )
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let stderr = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut lines = stderr.lines().map(|l| l.expect("a line"));
    let judged = |l: &String| l.contains("stage_finished") && l.contains("validate");
    assert!(lines.any(|l| judged(&l)), "a first mesh");
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("kill exists").success());
    let said: Vec<String> = lines.collect();
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(3), "{said:?}");
    assert!(
        said.iter()
            .any(|l| l.contains("interrupted: this is the best mesh so far")),
        "{said:?}"
    );
    assert!(shop.path("out.obj").exists());
    let notes = shop.json("run.json")["notes"].to_string();
    assert!(notes.contains("best mesh so far"), "{notes}");
}
