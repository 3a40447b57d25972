//! The program phex.
fn main() {}
