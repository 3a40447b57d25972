//! The program, run as a user runs it, in one binary: linking one for each file takes minutes.

mod bad_input;
mod brick_wall;
mod commands;
mod common;
mod duality;
mod fab;
mod faults;
mod first_minutes;
mod guides;
mod hostile;
mod interrupt;
mod koebe;
mod limits;
mod mesh;
mod offset;
mod repetition;
mod steering;
mod sweep;
