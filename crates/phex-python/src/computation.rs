//! A computation on a thread and a rayon pool of its own, while the caller's thread waits without
//! the interpreter's lock, a little at a time, and runs callbacks and signal handlers itself.
//!
//! Threads of a global pool do not survive `fork`; a pool that is made for each computation does
//! not have to.

use crate::answer::{Answer, into_dict};
use crate::arrays::{self, Arrays, GivenArrays};
use crate::errors::raised;
use crate::inputs::Inputs;
use crate::kept::{Kept, KeptSurface};
use crate::requests::{Work, work};
use numpy::PyReadonlyArray1;
use phex::{Event, Progress};
use phex_job::{JobError, WholeRun, thread_count};
use phex_mesh::PolygonSoup;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Events that wait for the caller at the most; the oldest go first.
const MOST_EVENTS: usize = 4096;

/// What the computation and the caller share.
#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    wants_preview: bool,
    news: Mutex<News>,
    /// Woken when there is a result.
    ended: Condvar,
}

#[derive(Default)]
struct News {
    events: Vec<String>,
    preview: Option<(&'static str, PolygonSoup)>,
    whole: Option<WholeRun>,
    result: Option<Result<Answer, JobError>>,
    has_ended: bool,
}

impl Shared {
    fn news(&self) -> MutexGuard<'_, News> {
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Shared {
    fn report(&self, event: &Event) {
        let mut news = self.news();
        let whole = news.whole.get_or_insert_with(WholeRun::default);
        let told = whole.take(event, None);
        let told = told.and_then(|w| serde_json::to_string(&w).ok());
        let event = serde_json::to_string(event).ok();
        news.events.extend(event.into_iter().chain(told));
        let many = news.events.len().saturating_sub(MOST_EVENTS);
        news.events.drain(..many);
    }

    fn is_cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn preview(&self, stage: &'static str, mesh: &dyn Fn() -> PolygonSoup) {
        if self.wants_preview {
            let soup = mesh();
            self.news().preview = Some((stage, soup));
        }
    }
}

/// A computation that runs or has ended.
#[pyclass(frozen, module = "phex._phex")]
pub struct Computation {
    shared: Arc<Shared>,
}

#[pymethods]
impl Computation {
    /// Waits for the end, `seconds` at the most, without the interpreter's lock; whether it ended.
    fn wait(&self, py: Python<'_>, seconds: f64) -> bool {
        let seconds = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::ZERO);
        py.detach(|| {
            let until = Instant::now() + seconds.min(Duration::from_secs(3600));
            let mut news = self.shared.news();
            while !news.has_ended {
                let left = until.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    break;
                }
                let woken = self.shared.ended.wait_timeout(news, left);
                news = woken.unwrap_or_else(PoisonError::into_inner).0;
            }
            news.has_ended
        })
    }

    /// The events since the last call, as JSON.
    fn events(&self) -> Vec<String> {
        std::mem::take(&mut self.shared.news().events)
    }

    /// The newest preview since the last call: its stage, and the mesh as arrays.
    fn preview<'py>(&self, py: Python<'py>) -> PyResult<Option<(&'static str, Arrays<'py>)>> {
        let preview = self.shared.news().preview.take();
        let arrays = |(stage, soup)| Ok((stage, arrays::arrays(py, &soup)?));
        preview.map(arrays).transpose()
    }

    /// Asks the computation to end.
    fn cancel(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// The answer, once.
    fn take(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        let result = self.shared.news().result.take();
        let none = JobError::Internal("there is no answer, or it was taken".to_owned());
        into_dict(py, result.unwrap_or(Err(none)).map_err(raised)?)
    }
}

/// Nobody can ask for the answer any more.
impl Drop for Computation {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// What a computation works on beside its request: meshes, a size of panels for each vertex, and
/// what an earlier computation kept of its result or of its surface.
type GivenParts<'py> = (
    Vec<GivenArrays<'py>>,
    Option<PyReadonlyArray1<'py, f64>>,
    Option<Py<Kept>>,
    Option<Py<KeptSurface>>,
);

/// Begins a computation.
#[pyfunction]
pub fn start(
    what: &str,
    request: &str,
    given: GivenParts<'_>,
    threads: Option<u16>,
    preview: bool,
) -> PyResult<Computation> {
    let (meshes, sizes, kept, session) = given;
    let files: Result<_, _> = meshes.iter().map(arrays::mesh_file).collect();
    let inputs = Inputs {
        files: files.map_err(raised)?,
        sizes: sizes.map(|s| s.as_array().to_vec()),
        kept: kept.map(|k| k.get().clone()),
        session: session.map(|k| k.get().clone()),
    };
    let work = work(what, request, inputs).map_err(raised)?;
    let threads = thread_count(threads).map_err(raised)?;
    let shared = Arc::new(Shared {
        wants_preview: preview,
        ..Shared::default()
    });
    let there = shared.clone();
    let thread = std::thread::Builder::new().name("phex".to_owned());
    let begun = thread.spawn(move || {
        let made = computed(work, threads, &there);
        let mut news = there.news();
        (news.result, news.has_ended) = (Some(made), true);
        there.ended.notify_all();
    });
    begun.map_err(|e| raised(JobError::Internal(e.to_string())))?;
    Ok(Computation { shared })
}

/// The answer of a piece of work, on a pool of its own.
fn computed(work: Work, threads: usize, shared: &Shared) -> Result<Answer, JobError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| JobError::Internal(e.to_string()))?;
    catch_unwind(AssertUnwindSafe(|| pool.install(|| work(shared)))).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().cloned();
        let said = said.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
        let said = said.unwrap_or_default();
        Err(JobError::Internal(format!("a bug of phex: {said}")))
    })
}
