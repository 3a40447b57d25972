//! Makes the rows: each a process of its own on one thread, as many side by side as there are
//! processors.

use super::WORK;
use super::entries::{Entry, Ledger};
use super::figures;
use super::rows::{LedgerRow, LedgerSurface};
use crate::measured::timed;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use wait4::ResUse;

/// Runs a program on rows.
pub struct Runner<'a> {
    root: &'a Path,
    program: PathBuf,
    models: &'a Path,
    work: PathBuf,
}

impl<'a> Runner<'a> {
    /// Makes the folder for surfaces and meshes.
    pub fn new(root: &'a Path, program: PathBuf, models: &'a Path) -> Result<Self, String> {
        let work = root.join(WORK);
        std::fs::create_dir_all(&work).map_err(|e| format!("{WORK}: {e}"))?;
        Ok(Self {
            root,
            program,
            models,
            work,
        })
    }

    /// Makes rows, and says each one's verdict when it is there.
    pub fn run(&self, rows: &[&'static LedgerRow]) -> Result<Ledger, String> {
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let next = AtomicUsize::new(0);
        let done: Mutex<Vec<Option<Result<Entry, String>>>> = Mutex::new(vec![None; rows.len()]);
        let work = || {
            while let Some(row) = rows.get(next.fetch_add(1, Ordering::SeqCst)) {
                let entry = self.entry(row);
                if let Ok(entry) = &entry {
                    println!("{}", super::table::line(entry));
                }
                let place = rows.iter().position(|other| other.name == row.name);
                let mut done = done.lock().expect("no worker panics with the lock");
                done[place.expect("a row of the list")] = Some(entry);
            }
        };
        std::thread::scope(|scope| {
            (0..workers).for_each(|_| {
                scope.spawn(work);
            });
        });
        let done = done.into_inner().expect("no worker panics with the lock");
        let rows: Result<Vec<Entry>, String> = done.into_iter().flatten().collect();
        Ok(Ledger { rows: rows? })
    }

    fn entry(&self, row: &'static LedgerRow) -> Result<Entry, String> {
        let surface = self.surface(row)?;
        let (mesh, report) = (self.file(row, "obj"), self.file(row, "json"));
        for old in [&mesh, &report] {
            // An earlier run's report must not pass for this one's.
            let _ = std::fs::remove_file(old);
        }
        let reference = self.reference()?;
        let mut command = Command::new(&self.program);
        command.current_dir(self.root).arg("mesh").arg(&surface);
        command.args(row.options.split_whitespace());
        command.args(["-q", "--progress", "none", "-t", "1", "-o"]);
        command.arg(&mesh).arg("--report").arg(&report);
        let (exit_code, used) = timed(&mut command)?;
        let report = crate::read(&report).ok();
        let report = report.and_then(|text| serde_json::from_str(&text).ok());
        let verdict = report.as_ref().and_then(figures::verdict);
        let mut figures = report.as_ref().map(figures::of_report).unwrap_or_default();
        figures.extend(figures::of_cost(&used, &reference));
        Ok(Entry {
            name: row.name.to_owned(),
            options: row.options.to_owned(),
            verdict: verdict.unwrap_or_else(|| "no mesh".to_owned()),
            failed: report.as_ref().map(figures::failed).unwrap_or_default(),
            exit_code,
            figures,
        })
    }

    fn file(&self, row: &LedgerRow, ending: &str) -> PathBuf {
        self.work.join(format!("{}.{ending}", row.name))
    }

    /// The file of a row's surface, written first where the tool makes it.
    fn surface(&self, row: &'static LedgerRow) -> Result<PathBuf, String> {
        let own = self.work.join(format!("{}.surface.obj", row.name));
        match row.surface {
            LedgerSurface::Kept(path) => return Ok(self.root.join(path)),
            LedgerSurface::Model(path) => return Ok(self.models.join(path)),
            LedgerSurface::Made(make) => make().write(&own)?,
            LedgerSurface::Shape(name) => {
                let mut command = Command::new(&self.program);
                command.args(["shape", name, "-q", "-o"]).arg(&own);
                crate::succeed(&mut command)?;
            }
        }
        Ok(own)
    }

    /// What the reference computation takes now, on this machine.
    fn reference(&self) -> Result<ResUse, String> {
        let own = std::env::current_exe().map_err(|e| format!("the path of xtask: {e}"))?;
        Ok(timed(Command::new(own).arg("ledger-reference"))?.1)
    }
}
