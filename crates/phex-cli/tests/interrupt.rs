//! Ctrl-C ends the program with 130 and leaves no half-written file.

#![cfg(unix)]

mod common;
use common::Workshop;
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
