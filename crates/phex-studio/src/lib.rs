//! `phex studio`: a page, served on this machine alone, on which a surface becomes panels.
//!
//! [`serve`] answers one browser of one person. What is computed is a job of `phex-job`, so that
//! the page, the command line and a job file mean the same; the page's script comes from
//! `phex-html`, with whose report it shares the three-dimensional view.
//!
//! | module | what it knows |
//! |---|---|
//! | `guard` | who may ask: this machine, by the printed address, with its token |
//! | `server` | what may be asked |
//! | `upload` | a request's body, in time and up to a size |
//! | `surfaces` | surfaces that were dropped, with what earlier jobs on them have computed |
//! | `wish` | what is wanted of a run, and how it is repeated |
//! | `runs` | one run at a time, on a thread; a newer one cancels the older |
//! | `frames` | what the page is told: JSON, and arrays behind it |
//! | `results` | meshes that were made, and the files that they become |
//!
//! Guaranteed: nothing but 127.0.0.1 is listened to; a request without the token, or from a page of
//! another origin, is refused; no file is read but the one that is named when the program starts,
//! and none is written. A run whose page is gone is cancelled.

mod frames;
mod guard;
mod page;
mod results;
mod runs;
mod server;
mod surfaces;
mod upload;
mod wish;

pub use server::{StudioOptions, serve};
pub use upload::MOST_BYTES;
