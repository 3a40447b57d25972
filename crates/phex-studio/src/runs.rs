//! One run at a time, on a thread; a newer one cancels the older.

use crate::frames::frame;
use crate::results::{Results, RunResult};
use crate::wish::{GrantedWish, PlaceInLine};
use axum::body::Bytes;
use phex::{Event, Progress};
use phex_html::MeshData;
use phex_job::{JobError, WholeProgress, WholeRun};
use phex_mesh::{PolygonSoup, Vec3};
use rayon::ThreadPool;
use serde::Serialize;
use std::convert::Infallible;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Instant;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_stream::{Stream, StreamExt};

/// Frames that wait for a page that is slow; what is newer is left out then, but for the last.
const WAITING: usize = 8;

/// Where runs take place.
pub struct Runs {
    pool: ThreadPool,
    /// Held by the run that computes.
    turn: Mutex<()>,
    current: Mutex<Option<CurrentRun>>,
    begun: AtomicU64,
    open: AtomicUsize,
    results: Mutex<Results>,
}

/// The run that was wanted last.
struct CurrentRun {
    asked: Option<PlaceInLine>,
    stopped: Arc<AtomicBool>,
}

impl CurrentRun {
    /// Whether a wish was overtaken by this one on its way: a preview by the run after it.
    fn has_overtaken(&self, wish: &GrantedWish) -> bool {
        let both = wish.asked.as_ref().zip(self.asked.as_ref());
        both.is_some_and(|(late, here)| late.is_older_than(here))
    }
}

/// A lock whose holder panicked protects nothing that is half-done.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Runs {
    /// A place with a thread for each core.
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn new() -> Result<Arc<Self>, rayon::ThreadPoolBuildError> {
        Ok(Arc::new(Self {
            pool: rayon::ThreadPoolBuilder::new().build()?,
            turn: Mutex::default(),
            current: Mutex::default(),
            begun: AtomicU64::new(0),
            open: AtomicUsize::new(0),
            results: Mutex::default(),
        }))
    }

    /// Number of runs that compute, or wait for the one before to end.
    pub fn open(&self) -> usize {
        self.open.load(Ordering::SeqCst)
    }

    /// Number of results that are kept.
    pub fn kept(&self) -> usize {
        locked(&self.results).len()
    }

    /// A result, by the number of its run.
    pub fn result(&self, number: u64) -> Option<Arc<RunResult>> {
        locked(&self.results).find(number)
    }

    /// Cancels the run there is.
    pub fn cancel(&self) {
        if let Some(older) = locked(&self.current).take() {
            older.stopped.store(true, Ordering::SeqCst);
        }
    }

    /// Does something in the threads of the runs, beside the run that computes.
    pub fn beside<T: Send>(&self, act: impl FnOnce() -> T + Send) -> T {
        self.pool.install(act)
    }

    /// Takes the place of the run there is, unless that is what the page wants since: whether the
    /// new one is cancelled.
    fn takes_place(&self, wish: &GrantedWish) -> Arc<AtomicBool> {
        let mut current = locked(&self.current);
        let late = current.as_ref().is_some_and(|run| run.has_overtaken(wish));
        let stopped = Arc::new(AtomicBool::new(late));
        if !late {
            let run = CurrentRun {
                asked: wish.asked.clone(),
                stopped: stopped.clone(),
            };
            if let Some(older) = current.replace(run) {
                older.stopped.store(true, Ordering::SeqCst);
            }
        }
        stopped
    }

    /// Begins a run: its frames. It is cancelled when they are dropped, or by the next one.
    pub fn begin(self: &Arc<Self>, wish: GrantedWish) -> RunFrames {
        let stopped = self.takes_place(&wish);
        let (told, hears) = mpsc::channel(WAITING);
        let (ends, end) = mpsc::channel(1);
        let number = self.begun.fetch_add(1, Ordering::SeqCst) + 1;
        let run = OngoingRun {
            number,
            stopped: stopped.clone(),
            told,
            whole: Mutex::default(),
            origin: wish.origin,
            begun: Instant::now(),
        };
        let runs = self.clone();
        let open = OpenRun::new(self.clone());
        let compute = move || {
            let _open = open;
            let last = runs.last_frame(&run, wish);
            // A page that is gone hears nothing.
            let _ = ends.try_send(last);
        };
        // Without a thread both channels end at once, which the page tells as a broken run.
        let _ = std::thread::Builder::new()
            .name("run".into())
            .spawn(compute);
        let frames = ReceiverStream::new(hears).chain(ReceiverStream::new(end));
        RunFrames {
            frames: Box::pin(frames.map(Ok)),
            stopped,
        }
    }

    fn last_frame(&self, run: &OngoingRun, wish: GrantedWish) -> Bytes {
        run.tell(&RunNews::Begun {
            run: run.number,
            job: &wish.text,
            command: &wish.command,
        });
        let compute = || {
            // What was overtaken on its way waits for nothing.
            run.goes_on()?;
            let _turn = locked(&self.turn);
            self.pool.install(|| self.computed(run, wish))
        };
        let made = catch_unwind(AssertUnwindSafe(compute)).unwrap_or_else(|_| {
            let cause = "the computation has panicked, which is a bug of phex";
            Err(JobError::Internal(cause.to_owned()))
        });
        made.unwrap_or_else(|error| match error {
            JobError::Cancelled => frame(&RunNews::Cancelled { run: run.number }),
            error => frame(&RunNews::Failed {
                run: run.number,
                message: &error.to_string(),
            }),
        })
    }

    fn computed(&self, run: &OngoingRun, wish: GrantedWish) -> Result<Bytes, JobError> {
        run.goes_on()?;
        if wish.job.until.is_some() {
            return laid_out(run, &wish);
        }
        let made = phex_job::run(&wish.job, run)?;
        run.goes_on()?;
        let seconds = run.begun.elapsed().as_secs_f64();
        let kept = RunResult::new(run.number, made, wish);
        let told = kept.told(seconds);
        locked(&self.results).add(kept);
        Ok(told)
    }
}

/// The first lattice, which is neither planar nor judged.
fn laid_out(run: &OngoingRun, wish: &GrantedWish) -> Result<Bytes, JobError> {
    let lattice = phex_job::lay_out(&wish.job, run)?;
    run.goes_on()?;
    Ok(run.mesh("layout", &lattice.to_soup()))
}

/// Counts a run as long as it is there, whatever becomes of it.
struct OpenRun(Arc<Runs>);

impl OpenRun {
    fn new(runs: Arc<Runs>) -> Self {
        runs.open.fetch_add(1, Ordering::SeqCst);
        Self(runs)
    }
}

impl Drop for OpenRun {
    fn drop(&mut self) {
        self.0.open.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A run on its way.
struct OngoingRun {
    number: u64,
    stopped: Arc<AtomicBool>,
    told: mpsc::Sender<Bytes>,
    whole: Mutex<WholeRun>,
    origin: Vec3,
    begun: Instant,
}

/// What the page is told of a run on its way.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum RunNews<'a> {
    /// It has a number, and can be repeated so.
    Begun {
        run: u64,
        job: &'a str,
        command: &'a str,
    },
    /// How much is done.
    Progress {
        run: u64,
        stage: &'static str,
        whole: WholeProgress,
    },
    /// What the panels look like after a stage; nobody has judged them.
    Mesh {
        run: u64,
        stage: &'static str,
        seconds: f64,
        mesh: MeshData,
    },
    /// It was cancelled.
    Cancelled { run: u64 },
    /// It has no result.
    Failed { run: u64, message: &'a str },
}

impl OngoingRun {
    fn goes_on(&self) -> Result<(), JobError> {
        if self.is_cancelled() {
            return Err(JobError::Cancelled);
        }
        Ok(())
    }

    /// Tells the page, unless it is so slow that it does not want to know.
    fn tell(&self, told: &RunNews<'_>) {
        self.send(|| frame(told));
    }

    fn send(&self, frame: impl FnOnce() -> Bytes) {
        if let Ok(place) = self.told.try_reserve() {
            place.send(frame());
        }
    }

    fn mesh(&self, stage: &'static str, soup: &PolygonSoup) -> Bytes {
        frame(&RunNews::Mesh {
            run: self.number,
            stage,
            seconds: self.begun.elapsed().as_secs_f64(),
            mesh: MeshData::new(soup, self.origin),
        })
    }
}

impl Progress for OngoingRun {
    fn report(&self, event: &Event) {
        let Some(whole) = locked(&self.whole).take(event, None) else {
            return;
        };
        let stage = match event {
            Event::StageStarted { stage }
            | Event::StageFinished { stage }
            | Event::Iteration { stage, .. }
            | Event::Counted { stage, .. } => stage,
            Event::Note { .. } => return,
        };
        self.tell(&RunNews::Progress {
            run: self.number,
            stage,
            whole,
        });
    }

    fn is_cancelled(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }

    fn preview(&self, stage: &'static str, mesh: &dyn Fn() -> PolygonSoup) {
        self.send(|| self.mesh(stage, &mesh()));
    }
}

/// The frames of a run; without a reader there is no run.
pub struct RunFrames {
    frames: Pin<Box<dyn Stream<Item = Result<Bytes, Infallible>> + Send>>,
    stopped: Arc<AtomicBool>,
}

impl Stream for RunFrames {
    type Item = Result<Bytes, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.frames.as_mut().poll_next(context)
    }
}

impl Drop for RunFrames {
    fn drop(&mut self) {
        self.stopped.store(true, Ordering::SeqCst);
    }
}
