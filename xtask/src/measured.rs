//! Processes, and what they use.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use wait4::{ResUse, Wait4};

/// Seconds after which a process has failed.
const LIMIT: u64 = 900;

/// Exit code and use of a process, which is ended after [`LIMIT`] seconds.
pub fn timed(command: &mut Command) -> Result<(i32, ResUse), String> {
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(Stdio::null());
    let spawned = command.spawn();
    let mut child = spawned.map_err(|e| format!("{command:?}: {e}"))?;
    let (id, start) = (child.id(), Instant::now());
    let (ended, watched) = std::sync::mpsc::channel::<()>();
    let watch = std::thread::spawn(move || {
        let left = Duration::from_secs(LIMIT).saturating_sub(start.elapsed());
        if watched.recv_timeout(left) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
            let _ = Command::new("kill").arg(id.to_string()).status();
        }
    });
    let used = child.wait4().map_err(|e| format!("waiting: {e}"))?;
    drop(ended);
    let _ = watch.join();
    Ok((used.status.code().unwrap_or(-1), used))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_tells_its_exit_code_and_what_it_used() {
        let (code, used) = timed(Command::new("sh").args(["-c", "exit 3"])).unwrap();
        assert_eq!(code, 3);
        assert!(used.rusage.maxrss > 0);
        assert!(timed(&mut Command::new("no-such-program")).is_err());
    }
}
