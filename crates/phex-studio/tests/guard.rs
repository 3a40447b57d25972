//! Who is answered, and what becomes of runs, uploads and clients that misbehave.

use phex_mesh::io::{Format, parse_soup, write_soup_to};
use phex_studio::{StudioOptions, serve};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A studio that runs as long as the test has it.
struct Running {
    port: u16,
    token: String,
    address: String,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    fn new(surface: Option<PathBuf>) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let (tell, hear) = mpsc::channel();
        let is_over = over.clone();
        let thread = std::thread::spawn(move || {
            let options = StudioOptions { surface, port: 0 };
            let ready = |address: &str| tell.send(address.to_owned()).unwrap();
            serve(&options, ready, || is_over.load(Ordering::SeqCst)).unwrap();
        });
        let address = hear.recv_timeout(Duration::from_secs(20)).unwrap();
        let (place, path) = address
            .strip_prefix("http://127.0.0.1:")
            .unwrap()
            .split_once('/')
            .unwrap();
        Self {
            port: place.parse().unwrap(),
            token: path.split('/').next().unwrap().to_owned(),
            address,
            over,
            thread: Some(thread),
        }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        stream
    }

    /// Sends a request with a token, and headers of the caller's own.
    fn send(&self, method: &str, path: &str, headers: &str, body: &[u8]) -> TcpStream {
        let own = format!("Host: 127.0.0.1:{}\r\n", self.port);
        let host = if headers.contains("Host:") { "" } else { &own };
        let head = format!(
            "{method} /{}/{path} HTTP/1.1\r\n{host}Connection: close\r\nContent-Length: {}\r\n{headers}\r\n",
            self.token,
            body.len()
        );
        let mut stream = self.connect();
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(body).unwrap();
        stream
    }

    fn answer(&self, method: &str, path: &str, headers: &str, body: &[u8]) -> Answer {
        Answer::read(self.send(method, path, headers, body))
    }

    fn status(&self) -> Value {
        self.answer("GET", "status", "", b"").json()
    }

    fn drop_roof(&self) -> String {
        let answer = self.answer("POST", "surface?sample=roof", "", b"");
        assert_eq!(answer.status, 200);
        answer.frames()[0]["id"].as_str().unwrap().to_owned()
    }

    fn wish(&self, surface: &str, job: Value, until: Option<&str>) -> Vec<u8> {
        let wish = json!({ "surface": surface, "job": job, "until": until });
        wish.to_string().into_bytes()
    }

    /// Waits until no run computes; how long that took.
    fn quiet(&self) -> Duration {
        let begun = Instant::now();
        while self.status()["runs"] != 0 {
            assert!(
                begun.elapsed() < Duration::from_secs(60),
                "a run goes on without an end"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
        begun.elapsed()
    }

    fn end(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        self.thread
            .take()
            .into_iter()
            .for_each(|t| t.join().unwrap());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
    }
}

struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn read(mut stream: TcpStream) -> Self {
        let mut bytes = Vec::new();
        // A server that refuses an upload may close before it has read all of it.
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").unwrap_or(0);
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|s| s.parse().ok())
            .unwrap_or(0);
        let body = bytes[(end + 4).min(bytes.len())..].to_vec();
        let chunked = head
            .to_ascii_lowercase()
            .contains("transfer-encoding: chunked");
        let body = if chunked { unchunked(&body) } else { body };
        Self { status, head, body }
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&self.body)))
    }

    fn message(&self) -> String {
        self.json()["message"].as_str().unwrap().to_owned()
    }

    /// The JSON of each frame.
    fn frames(&self) -> Vec<Value> {
        let mut rest = &self.body[..];
        let mut frames = Vec::new();
        while rest.len() >= 8 {
            let length =
                |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap()) as usize;
            let (json, arrays) = (length(0), length(4));
            frames.push(serde_json::from_slice(&rest[8..8 + json]).unwrap());
            rest = &rest[8 + json + arrays..];
        }
        frames
    }
}

fn unchunked(mut body: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    while let Some(end) = body.windows(2).position(|w| w == b"\r\n") {
        let length = std::str::from_utf8(&body[..end]).unwrap();
        let length = usize::from_str_radix(length, 16).unwrap();
        if length == 0 {
            break;
        }
        out.extend_from_slice(&body[end + 2..end + 2 + length]);
        body = &body[end + 4 + length..];
    }
    out
}

/// A run that takes a while.
fn long() -> Value {
    json!({ "panels": 1500, "effort": "best" })
}

#[test]
fn foreign_names_foreign_pages_and_guessed_tokens_are_refused() {
    let studio = Running::new(None);
    let get = |headers: &str| studio.answer("GET", "", headers, b"").status;
    assert_eq!(get(""), 200);
    assert_eq!(get(&format!("Host: localhost:{}\r\n", studio.port)), 200);
    for host in [
        "evil.example",
        "127.0.0.1",
        "127.0.0.1:1",
        "localhost.evil.example",
    ] {
        assert_eq!(get(&format!("Host: {host}\r\n")), 403, "{host}");
    }
    let port = studio.port;
    for origin in [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        format!("https://127.0.0.1:{port}"),
        format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        assert_eq!(get(&format!("Origin: {origin}\r\n")), 403, "{origin}");
    }
    assert_eq!(get(&format!("Origin: http://127.0.0.1:{port}\r\n")), 200);
    for path in [
        "",
        "status",
        "studio.js",
        &"0".repeat(32),
        &format!("{}/status", "f".repeat(32)),
    ] {
        let mut stream = studio.connect();
        write!(
            stream,
            "GET /{path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        assert_eq!(Answer::read(stream).status, 403, "/{path}");
    }
    let page = studio.answer("GET", "", "", b"");
    let head = page.head.to_ascii_lowercase();
    for wanted in [
        "default-src 'none'",
        "frame-ancestors 'none'",
        "no-referrer",
        "no-store",
        "nosniff",
    ] {
        assert!(head.contains(wanted), "{wanted}: {head}");
    }
    assert!(!head.contains("access-control-allow-origin"));
    assert_ne!(
        Running::new(None).token,
        studio.token,
        "tokens are not said twice"
    );
}

#[test]
fn a_bad_file_is_refused_in_the_words_of_its_reader() {
    let studio = Running::new(None);
    let refused = |name: &str, bytes: &[u8]| {
        let answer = studio.answer("POST", &format!("surface?name={name}"), "", bytes);
        assert_eq!(answer.status, 422, "{name}");
        answer.message()
    };
    assert!(
        refused("a.obj", b"v 0 0 x\n").contains("a.obj: line 1"),
        "line and file"
    );
    assert!(refused("a.xyz", b"v 0 0 0\n").contains("xyz"));
    assert!(refused("..%2F..%2Fetc%2Fpasswd", b"").contains("passwd"));
    assert!(refused("a.stl", &[0; 100]).contains("a.stl"));
    assert!(
        refused(
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n"
        )
        .contains("a.ply")
    );
    assert!(refused("", b"").len() > 5);
    // What can be read and is no surface is shown, with the place of the problem.
    let fan = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n";
    let told = studio
        .answer("POST", "surface?name=fan.obj", "", fan.as_bytes())
        .frames();
    let problem = told[0]["info"]["problem"].as_str().unwrap();
    assert!(problem.contains("more than two faces"), "{problem}");
    assert_eq!(
        told[0]["broken"]["points"]["$"][1],
        2 * 12,
        "both ends of the edge"
    );
    let id = told[0]["id"].as_str().unwrap();
    let run = studio.answer("POST", "run", "", &studio.wish(id, json!({}), None));
    assert_eq!(run.status, 422);
    assert!(run.message().contains("more than two faces"));
}

#[test]
fn what_can_not_be_wanted_is_refused_by_name() {
    let studio = Running::new(None);
    let roof = studio.drop_roof();
    let refused = |body: &[u8]| {
        let answer = studio.answer("POST", "run", "", body);
        assert!(
            answer.status == 422 || answer.status == 410,
            "{}",
            answer.status
        );
        answer.message()
    };
    assert!(refused(b"{").len() > 5);
    assert!(refused(&studio.wish("nobody", json!({}), None)).contains("drop it again"));
    assert!(refused(&studio.wish(&roof, json!({ "pannels": 1 }), None)).contains("pannels"));
    assert!(refused(&studio.wish(&roof, json!({ "panels": 1e300 }), None)).len() > 5);
    let told = studio
        .answer(
            "POST",
            "run",
            "",
            &studio.wish(&roof, json!({ "panels": 0 }), None),
        )
        .frames();
    let last = told.last().unwrap();
    assert_eq!(last["kind"], "failed");
    assert!(
        last["message"]
            .as_str()
            .unwrap()
            .contains("at least one panel")
    );
    let job = studio.answer(
        "POST",
        "job",
        "",
        b"panels = 40\n[guides]\nguide = '/etc/passwd'\n",
    );
    assert!(job.message().contains("reads none"));
    assert_eq!(
        studio.answer("POST", "job", "", b"panels = 40\n").json(),
        json!({ "panels": 40 })
    );
    let large = studio.answer("POST", "job", "", b"seed = 9007199254740993\n");
    assert!(large.message().contains("does not keep all digits"));
    assert_eq!(
        studio.answer("GET", "result/77/mesh.obj", "", b"").status,
        410
    );
}

#[test]
fn an_upload_without_end_and_one_that_breaks_off_hurt_nobody() {
    let studio = Running::new(None);
    // More than is taken: refused before it is all there.
    let mut stream = studio.connect();
    let head = format!(
        "POST /{}/surface?name=big.obj HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nTransfer-Encoding: chunked\r\n\r\n",
        studio.token, studio.port
    );
    stream.write_all(head.as_bytes()).unwrap();
    let chunk = vec![b'#'; 1 << 20];
    let mut sent = 0;
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(60) {
        let whole = stream
            .write_all(b"100000\r\n")
            .and_then(|()| stream.write_all(&chunk))
            .and_then(|()| stream.write_all(b"\r\n"));
        if whole.is_err() || sent > 300 {
            break;
        }
        sent += 1;
    }
    assert!((256..300).contains(&sent), "{sent} MB were taken");
    // One that breaks off, and one that never ends.
    let mut broken = studio.connect();
    let head = head.replace("Transfer-Encoding: chunked", "Content-Length: 1000000");
    broken.write_all(head.as_bytes()).unwrap();
    broken.write_all(b"v 0 0 0\n").unwrap();
    drop(broken);
    let mut silent = studio.connect();
    silent.write_all(b"POST /").unwrap();
    assert_eq!(studio.status()["runs"], 0);
    drop(silent);
}

#[test]
fn a_run_is_told_in_frames_and_its_result_becomes_files() {
    let studio = Running::new(None);
    let roof = studio.drop_roof();
    let lattice = studio
        .answer(
            "POST",
            "run",
            "",
            &studio.wish(&roof, json!({ "panels": 80 }), Some("layout")),
        )
        .frames();
    assert_eq!(lattice.last().unwrap()["kind"], "mesh");
    assert_eq!(lattice.last().unwrap()["stage"], "layout");
    let told = studio
        .answer(
            "POST",
            "run",
            "",
            &studio.wish(&roof, json!({ "panels": 80 }), None),
        )
        .frames();
    assert_eq!(told[0]["kind"], "begun");
    assert!(
        told.iter().any(|t| t["kind"] == "mesh"),
        "panels are seen before they are judged"
    );
    assert!(told.iter().any(|t| t["kind"] == "progress"));
    let result = told.last().unwrap();
    assert_eq!(
        (&result["kind"], &result["verdict"]),
        (&json!("result"), &json!("pass"))
    );
    assert_eq!(
        result["command"],
        "phex mesh roof.obj --panels=80 -o roof-phex.obj"
    );
    let run = result["run"].as_u64().unwrap();
    let file = |name: &str| {
        let answer = studio.answer("GET", &format!("result/{run}/{name}"), "", b"");
        assert_eq!(
            answer.status,
            200,
            "{name}: {}",
            String::from_utf8_lossy(&answer.body)
        );
        assert!(
            answer.head.contains("attachment; filename=\"roof-"),
            "{}",
            answer.head
        );
        answer.body
    };
    for format in result["formats"].as_array().unwrap() {
        let bytes = file(&format!("mesh.{}", format.as_str().unwrap()));
        assert!(bytes.len() > 1000);
    }
    let mesh = phex_job::MeshFile::from_bytes("roof.obj".as_ref(), &file("mesh.obj")).unwrap();
    assert_eq!(
        mesh.soup.faces.len() as u64,
        result["figures"]["panels"].as_u64().unwrap()
    );
    assert!(file("report.html").starts_with(b"<!doctype html>"));
    assert!(file("picture.png").starts_with(b"\x89PNG"));
    assert!(file("picture.svg").starts_with(b"<svg") || file("picture.svg").starts_with(b"<?xml"));
    let report: Value = serde_json::from_slice(&file("report.json")).unwrap();
    assert_eq!(report["verdict"], "pass");
    assert_eq!(file("job.toml"), b"panels = 80\n");
    let archive = zip::ZipArchive::new(std::io::Cursor::new(file(
        "workshop.zip?thickness=20mm&sheet=12000x12000",
    )))
    .unwrap();
    assert!(
        archive
            .file_names()
            .any(|name| name.is_ok_and(|n| n == "roof-workshop/sheets/sheet-01.dxf"))
    );
    let refused = studio.answer(
        "GET",
        &format!("result/{run}/workshop.zip?thickness=20m"),
        "",
        b"",
    );
    assert_eq!(refused.status, 422);
    assert!(refused.message().len() > 10);
}

#[test]
fn files_have_the_unit_of_their_format_and_the_name_of_the_surface() {
    let studio = Running::new(None);
    let roof = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/roof.obj");
    let roof = std::fs::read(roof).unwrap();
    let dropped = studio.answer("POST", "surface?name=Dach-S%C3%BCd%22.obj", "", &roof);
    let id = dropped.frames()[0]["id"].as_str().unwrap().to_owned();
    let wish = studio.wish(&id, json!({ "panels": 40, "unit": "mm" }), None);
    let told = studio.answer("POST", "run", "", &wish).frames();
    let run = told.last().unwrap()["run"].as_u64().unwrap();
    let file = |name: &str| studio.answer("GET", &format!("result/{run}/mesh.{name}"), "", b"");
    let mut soup = parse_soup(&file("obj").body, Format::Obj).unwrap();
    soup.positions.iter_mut().for_each(|p| *p *= 1e-3);
    for format in [Format::Glb, Format::ThreeMf] {
        let mut metres = Vec::new();
        write_soup_to(&mut metres, &soup, format).unwrap();
        assert!(file(format.extension()).body == metres, "{format:?}");
    }
    let head = file("obj").head;
    let named = "filename=\"Dach-S_d_-phex.obj\"; filename*=UTF-8''Dach-S%C3%BCd%22-phex.obj";
    assert!(head.contains(named), "{head}");
}

#[test]
fn a_newer_run_a_client_that_goes_and_one_that_does_not_listen_end_a_run() {
    let studio = Running::new(None);
    let roof = studio.drop_roof();
    let first = studio.send("POST", "run", "", &studio.wish(&roof, long(), None));
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(studio.status()["runs"], 1);
    // A newer one cancels the older, which is told.
    let second = studio.answer(
        "POST",
        "run",
        "",
        &studio.wish(&roof, json!({ "panels": 40 }), Some("layout")),
    );
    assert_eq!(second.frames().last().unwrap()["kind"], "mesh");
    assert_eq!(
        Answer::read(first).frames().last().unwrap()["kind"],
        "cancelled"
    );
    assert_eq!(studio.status()["runs"], 0);
    // A client that goes.
    let third = studio.send("POST", "run", "", &studio.wish(&roof, long(), None));
    std::thread::sleep(Duration::from_millis(300));
    drop(third);
    println!("a run without a client ends after {:?}", studio.quiet());
    // One that does not listen holds nobody up.
    let deaf = studio.send(
        "POST",
        "run",
        "",
        &studio.wish(&roof, json!({ "panels": 300 }), None),
    );
    // Which of two connections is served first is chance.
    std::thread::sleep(Duration::from_millis(300));
    let next = studio.answer(
        "POST",
        "run",
        "",
        &studio.wish(&roof, json!({ "panels": 40 }), Some("layout")),
    );
    assert_eq!(next.frames().last().unwrap()["kind"], "mesh");
    drop(deaf);
    studio.quiet();
}

#[test]
fn a_request_that_was_overtaken_does_not_cancel_what_the_page_wants_since() {
    let studio = Running::new(None);
    let roof = studio.drop_roof();
    let asked = |page: &str, before: u64, job: Value, until: Option<&str>| {
        let asked = json!({ "page": page, "before": before });
        let wish = json!({ "surface": &roof, "job": job, "until": until, "asked": asked });
        wish.to_string().into_bytes()
    };
    let last = |answer: Answer| answer.frames().last().unwrap()["kind"].clone();
    let few = || json!({ "panels": 40 });
    let wanted = studio.send("POST", "run", "", &asked("one", 7, long(), None));
    std::thread::sleep(Duration::from_millis(300));
    // A preview that the page has given up comes late.
    let late = studio.answer("POST", "run", "", &asked("one", 6, few(), Some("layout")));
    assert_eq!(last(late), "cancelled");
    assert_eq!(studio.status()["runs"], 1);
    // Another page, and the same one later, are newer whatever they count.
    let other = studio.answer("POST", "run", "", &asked("two", 0, few(), Some("layout")));
    assert_eq!(last(other), "mesh");
    assert_eq!(last(Answer::read(wanted)), "cancelled");
    let again = studio.answer("POST", "run", "", &asked("one", 8, few(), Some("layout")));
    assert_eq!(last(again), "mesh");
}

#[test]
fn the_studio_begins_with_a_surface_and_ends_in_the_middle_of_a_run() {
    let roof = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/roof.obj"));
    let mut studio = Running::new(Some(roof));
    let id = studio.address.split("#surface=").nth(1).unwrap().to_owned();
    assert_eq!(
        studio
            .answer("GET", &format!("surface/{id}"), "", b"")
            .frames()[0]["name"],
        "roof.obj"
    );
    let run = studio.send("POST", "run", "", &studio.wish(&id, long(), None));
    std::thread::sleep(Duration::from_millis(200));
    let begun = Instant::now();
    studio.end();
    assert!(
        begun.elapsed() < Duration::from_secs(2),
        "{:?}",
        begun.elapsed()
    );
    drop(run);
    let missing = StudioOptions {
        surface: Some("nowhere.obj".into()),
        port: 0,
    };
    assert!(
        serve(&missing, |_| {}, || true)
            .unwrap_err()
            .to_string()
            .contains("nowhere.obj")
    );
}
