//! What may be asked.

use crate::guard::{OwnNames, guard};
use crate::page;
use crate::results::WorkshopWish;
use crate::runs::{Runs, locked};
use crate::surfaces::{DroppedSurface, DroppedSurfaces, samples};
use crate::upload::{MOST_BYTES, MOST_OF_A_REQUEST, RefusedRequest, whole};
use crate::wish::{Wish, settings};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Path, Query, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use phex::{Event, Progress};
use phex_job::{JobError, MeshSettings};
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::net::TcpListener;

/// How often it is asked whether the studio is to end.
const GLANCE: Duration = Duration::from_millis(50);
/// How long answers on their way may take then.
const FAREWELL: Duration = Duration::from_millis(300);
/// Threads that answer requests, and threads that read files and write them; runs have their own.
const ANSWERING: usize = 2;
const READING: usize = 4;

/// The largest whole number up to which double precision has all of them.
const MOST_WHOLE: u64 = (1 << 53) - 1;

/// How the studio is started.
#[derive(Clone, Debug, Default)]
pub struct StudioOptions {
    /// A surface to begin with.
    pub surface: Option<PathBuf>,
    /// The port; 0 for any that is free.
    pub port: u16,
}

/// Serves the studio until `is_over` says so; `ready` is told the address, with the token without
/// which nothing is answered.
///
/// # Errors
/// If the surface can't be read, or the port can't be had.
pub fn serve(
    options: &StudioOptions,
    ready: impl FnOnce(&str),
    is_over: impl Fn() -> bool,
) -> Result<(), JobError> {
    let cannot = |e: &dyn std::fmt::Display| JobError::Internal(format!("the studio: {e}"));
    let studio = Studio::new().map_err(|e| cannot(&e))?;
    let mut state = String::new();
    if let Some(path) = &options.surface {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|e| JobError::input(format!("{name}: {e}")))?;
        let surface = DroppedSurface::read(&name, &bytes)?;
        state = format!("#surface={}", surface.id);
        locked(&studio.surfaces).add(surface);
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(ANSWERING)
        .max_blocking_threads(READING)
        .enable_all()
        .build()
        .map_err(|e| cannot(&e))?;
    runtime.block_on(async {
        let listener = TcpListener::bind(("127.0.0.1", options.port)).await;
        let busy = |e| JobError::input(format!("--port {}: {e}", options.port));
        let listener = listener.map_err(busy)?;
        let port = listener.local_addr().map_err(|e| cannot(&e))?.port();
        let token = format!("{:032x}", rand::random::<u128>());
        ready(&format!("http://127.0.0.1:{port}/{token}/{state}"));
        let over = Arc::new(tokio::sync::Notify::new());
        let told = over.clone();
        let server = axum::serve(listener, router(studio.clone(), port, &token))
            .with_graceful_shutdown(async move { told.notified().await });
        let server = tokio::spawn(server.into_future());
        while !is_over() && !server.is_finished() {
            tokio::time::sleep(GLANCE).await;
        }
        studio.runs.cancel();
        over.notify_one();
        let _ = tokio::time::timeout(FAREWELL, server).await;
        Ok(())
    })?;
    // Downloads that are being computed are not waited for.
    runtime.shutdown_background();
    Ok(())
}

/// What the answers share.
struct Studio {
    runs: Arc<Runs>,
    surfaces: Mutex<DroppedSurfaces>,
}

impl Studio {
    fn new() -> Result<Arc<Self>, rayon::ThreadPoolBuildError> {
        Ok(Arc::new(Self {
            runs: Runs::new()?,
            surfaces: Mutex::default(),
        }))
    }
}

fn router(studio: Arc<Studio>, port: u16, token: &str) -> Router {
    let script = || async { script() };
    let styled = || async { as_type("text/css; charset=utf-8", page::style()) };
    let paged = || async { as_type("text/html; charset=utf-8", page::html()) };
    let own = Router::new()
        .route("/", get(paged))
        .route("/studio.js", get(script))
        .route("/studio.css", get(styled))
        .route("/samples", get(async || axum::Json(samples())))
        .route("/status", get(status))
        .route("/surface", post(drop_surface))
        .route("/surface/{id}", get(surface))
        .route("/job", post(read_job))
        .route("/run", post(run))
        .route("/result/{run}/{file}", get(result))
        .with_state(studio);
    let refused = || async { StatusCode::FORBIDDEN };
    Router::new()
        .nest_service(&format!("/{token}"), own)
        .fallback(refused)
        .layer(from_fn_with_state(OwnNames::new(port), guard))
}

fn script() -> Response {
    let kind = "text/javascript; charset=utf-8";
    as_type(kind, phex_html::studio_script().unwrap_or_default())
}

fn as_type(kind: &'static str, content: impl Into<Body>) -> Response {
    let mut response = Response::new(content.into());
    let kind = HeaderValue::from_static(kind);
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    response
}

/// What runs and what is kept.
async fn status(State(studio): State<Arc<Studio>>) -> impl IntoResponse {
    axum::Json(json!({ "runs": studio.runs.open(), "results": studio.runs.kept() }))
}

/// Where a surface comes from: a sample, or the bytes of a file of some name.
#[derive(Deserialize)]
struct Origin {
    name: Option<String>,
    sample: Option<String>,
}

async fn drop_surface(
    State(studio): State<Arc<Studio>>,
    Query(origin): Query<Origin>,
    body: Body,
) -> Result<Bytes, RefusedRequest> {
    let bytes = whole(body, MOST_BYTES).await?;
    let read = move || match origin.sample {
        Some(sample) => DroppedSurface::sample(&sample),
        None => DroppedSurface::read(&origin.name.unwrap_or_default(), &bytes),
    };
    let read = tokio::task::spawn_blocking(read).await;
    let surface = read
        .map_err(RefusedRequest::internal)?
        .map_err(RefusedRequest::unusable)?;
    Ok(locked(&studio.surfaces).add(surface).told.clone())
}

async fn surface(
    State(studio): State<Arc<Studio>>,
    Path(id): Path<String>,
) -> Result<Bytes, RefusedRequest> {
    let surface = locked(&studio.surfaces).find(&id);
    Ok(surface.ok_or_else(no_surface)?.told.clone())
}

fn no_surface() -> RefusedRequest {
    RefusedRequest::gone("the surface is not there any more: drop it again")
}

/// What a job file sets, as JSON.
async fn read_job(body: Body) -> Result<axum::Json<Value>, RefusedRequest> {
    let text = String::from_utf8(whole(body, MOST_OF_A_REQUEST).await?);
    let text = text.map_err(|_| RefusedRequest::unusable("the job file is no text"))?;
    let _: MeshSettings = settings(&text).map_err(RefusedRequest::unusable)?;
    let table: toml::Table = text.parse().map_err(RefusedRequest::unusable)?;
    let value = serde_json::to_value(table).map_err(RefusedRequest::unusable)?;
    if !keeps_digits(&value) {
        return Err(RefusedRequest::unusable(format!(
            "the job file has a whole number above {MOST_WHOLE}, of which the studio does not keep all digits: use `phex mesh`"
        )));
    }
    Ok(axum::Json(value))
}

/// Whether the page, whose numbers have double precision, keeps all digits of whole numbers.
fn keeps_digits(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().all(keeps_digits),
        Value::Object(entries) => entries.values().all(keeps_digits),
        Value::Number(number) => number
            .as_i64()
            .is_none_or(|n| n.unsigned_abs() <= MOST_WHOLE),
        _ => true,
    }
}

async fn run(State(studio): State<Arc<Studio>>, body: Body) -> Result<Body, RefusedRequest> {
    let bytes = whole(body, MOST_OF_A_REQUEST).await?;
    let wish: Wish = serde_json::from_slice(&bytes).map_err(RefusedRequest::unusable)?;
    let surface = locked(&studio.surfaces).find(&wish.surface);
    let surface = surface.ok_or_else(no_surface)?;
    let granted = wish.grant(&surface).map_err(RefusedRequest::unusable)?;
    Ok(Body::from_stream(studio.runs.begin(granted)))
}

async fn result(
    State(studio): State<Arc<Studio>>,
    Path((run, file)): Path<(u64, String)>,
    Query(workshop): Query<WorkshopWish>,
) -> Result<Response, RefusedRequest> {
    let kept = studio.runs.result(run);
    let gone = || RefusedRequest::gone("this result is not kept any more: run it again");
    let kept = kept.ok_or_else(gone)?;
    let waits = Waits::default();
    let progress = waits.clone();
    let make = move || {
        studio
            .runs
            .beside(|| kept.file(&file, &workshop, &progress))
    };
    let made = tokio::task::spawn_blocking(make).await;
    drop(waits);
    let handout = made.map_err(RefusedRequest::internal)??;
    let mut response = as_type("application/octet-stream", handout.bytes);
    let value = HeaderValue::from_str(&attachment(&handout.name));
    let value = value.map_err(RefusedRequest::internal)?;
    (response.headers_mut()).insert(header::CONTENT_DISPOSITION, value);
    Ok(response)
}

/// A name as a header holds it: in ASCII, and whole as RFC 5987 encodes it.
fn attachment(name: &str) -> String {
    let is_plain = |b: &u8| b.is_ascii_alphanumeric() || b"-_.".contains(b);
    let is_other = |c: char| !u8::try_from(c).is_ok_and(|b| is_plain(&b));
    let ascii = name.replace(is_other, "_");
    let encoded = |b: u8| match is_plain(&b) {
        true => char::from(b).to_string(),
        false => format!("%{b:02X}"),
    };
    let whole: String = name.bytes().map(encoded).collect();
    format!("attachment; filename=\"{ascii}\"; filename*=UTF-8''{whole}")
}

/// Whether somebody still waits for a file: what is dropped on the way cancels it.
#[derive(Clone, Default)]
struct Waits(Arc<AtomicBool>);

impl Drop for Waits {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Progress for Waits {
    fn report(&self, _: &Event) {}

    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
