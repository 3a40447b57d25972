//! Progress on standard error, and interruption.

use crate::exit::Failure;
use crate::printable::{printable, tell};
use crate::shared_arguments::{ProgressMode, Talk};
use indicatif::{ProgressBar, ProgressStyle};
use phex::{Event, Progress};
use phex_job::{TimeLimit, WholeProgress, WholeRun};
use std::collections::BTreeSet;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// Held while a file is written, so that an interruption never leaves a part of one.
static WRITING: Mutex<()> = Mutex::new(());
/// Whether an interruption ends the computation alone, and what it has reached is written.
static KEEPS_BEST: AtomicBool = AtomicBool::new(false);
/// How long a computation may take to end by itself after an interruption.
const GRACE: Duration = Duration::from_millis(500);

/// Whether the user has interrupted the program.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Ends a command that the user has interrupted.
///
/// # Errors
/// If the user has.
pub fn check_interruption() -> Result<(), Failure> {
    match is_interrupted() {
        true => Err(Failure::interrupted()),
        false => Ok(()),
    }
}

/// From now on the first interruption ends the computation, the second one the program.
pub fn keep_best() {
    KEEPS_BEST.store(true, Ordering::Relaxed);
}

/// The computation has ended: from now on an interruption ends the program.
pub fn take_interruption() {
    KEEPS_BEST.store(false, Ordering::Relaxed);
    INTERRUPTED.store(false, Ordering::Relaxed);
}

/// Runs `write` such that an interruption waits for its end.
pub fn while_writing<T>(write: impl FnOnce() -> T) -> T {
    let _guard = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    write()
}

/// Lets Ctrl-C cancel the computation, and end the program if that takes too long.
///
/// # Errors
/// If the system refuses the handler.
pub fn install_interrupt_handler() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        let again = INTERRUPTED.swap(true, Ordering::Relaxed);
        if KEEPS_BEST.load(Ordering::Relaxed) && !again {
            return;
        }
        std::thread::sleep(GRACE);
        while_writing(|| {
            tell("interrupted");
            std::process::exit(crate::exit::Exit::Interrupted as i32)
        })
    })
}

/// Shows the events of a computation the way the user wants them.
pub struct Reporter {
    bar: Option<ProgressBar>,
    whole: Mutex<WholeRun>,
    until: Option<Instant>,
    json: bool,
    verbose: bool,
    quiet: bool,
    /// Notes that were said: every run of a stage says its own again.
    said: Mutex<BTreeSet<String>>,
}

impl Reporter {
    /// A reporter for these wishes.
    pub fn new(talk: &Talk) -> Self {
        let json = talk.progress == ProgressMode::Json;
        let wants_bar =
            talk.progress == ProgressMode::Auto && !talk.quiet && std::io::stderr().is_terminal();
        Self {
            bar: wants_bar.then(bar),
            whole: Mutex::new(WholeRun::default()),
            until: None,
            json,
            verbose: talk.verbose,
            quiet: talk.quiet,
            said: Mutex::default(),
        }
    }

    /// The same for a computation that ends when a time is over.
    pub fn within(self, limit: Option<TimeLimit>) -> Self {
        let until = limit.map(|l| l.until);
        Self { until, ..self }
    }

    /// Says something that the user should know.
    pub fn note(&self, message: impl Into<String>) {
        self.report(&Event::Note {
            message: message.into(),
        });
    }

    /// Takes the bar off the terminal.
    pub fn finish(&self) {
        if self.json {
            say(self.whole().end());
        }
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    /// Whether a note is said for the first time.
    fn is_new(&self, note: &str) -> bool {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        said.insert(note.to_owned())
    }

    fn whole(&self) -> MutexGuard<'_, WholeRun> {
        self.whole.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Time that is left at the most.
    fn most_left(&self) -> Option<Duration> {
        self.until
            .map(|u| u.saturating_duration_since(Instant::now()))
    }

    fn line(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| tell(text)),
            None => tell(text),
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    // The template is constant; a test draws it.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed:>4} {prefix} {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

impl Progress for Reporter {
    fn report(&self, event: &Event) {
        if let Event::Note { message } = event
            && !self.is_new(message)
        {
            return;
        }
        let whole = self.whole().take(event, self.most_left());
        if self.json {
            if let Ok(line) = serde_json::to_string(event) {
                tell(&line);
            }
            whole.into_iter().for_each(say);
            return;
        }
        if let Some(bar) = &self.bar {
            bar.set_message(printable(&sentence(event)).into_owned());
            if let Some(whole) = whole {
                bar.set_prefix(whole.to_string());
            }
        }
        match event {
            Event::Note { message } if !self.quiet => self.line(&format!("note: {message}")),
            Event::StageFinished { .. } if self.verbose => self.line(&sentence(event)),
            _ => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        is_interrupted()
    }
}

fn say(whole: WholeProgress) {
    if let Ok(line) = serde_json::to_string(&whole) {
        tell(&line);
    }
}

fn sentence(event: &Event) -> String {
    match event {
        Event::StageStarted { stage } => (*stage).to_owned(),
        Event::StageFinished { stage } => format!("{stage}: done"),
        Event::Iteration {
            stage,
            iteration,
            limit,
            residual,
        } => {
            format!("{stage}: {iteration} of at most {limit}, residual {residual:.1e}")
        }
        Event::Counted { stage, done, total } => format!("{stage}: {done} of {total}"),
        Event::Note { message } => message.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_s_template_is_valid() {
        assert!(ProgressStyle::with_template("{spinner} {elapsed:>4} {prefix} {msg}").is_ok());
    }

    #[test]
    fn a_note_is_said_once() {
        let reporter = Reporter::new(&Talk::default());
        assert!(reporter.is_new("planarity can't be reached here"));
        assert!(!reporter.is_new("planarity can't be reached here"));
        assert!(reporter.is_new("another"));
    }

    #[test]
    fn iterations_are_said_with_their_residual() {
        let event = Event::Iteration {
            stage: "optimise",
            iteration: 3,
            limit: 60,
            residual: 1.24e-6,
        };
        assert_eq!(
            sentence(&event),
            "optimise: 3 of at most 60, residual 1.2e-6"
        );
    }
}
