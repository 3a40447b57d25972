//! Linking for Linux systems with an old C library: zig's linker, from PyPI, knows which functions
//! each version of glibc has.

use crate::{Stop, foreign, succeed, target_folder, verdict, viewer};
use std::path::Path;
use std::process::Command;

/// What brings the linker, from PyPI.
const ZIG: &str = "ziglang==0.16.*";
/// The oldest glibc that what is linked so runs on, that of manylinux2014.
const GLIBC: Version = (2, 17);

/// Major and minor number of a version of glibc.
type Version = (u32, u32);

/// The words for rustc by which only the last link step is zig's.
pub fn linking(root: &Path) -> Result<[String; 2], Stop> {
    let python = foreign::environment(root, &[])?;
    foreign::add(&python, ZIG)?;
    let path = target_folder(root).join("zigcc.sh");
    let python = std::path::absolute(python).map_err(|e| e.to_string())?;
    let text = format!(
        "#!/bin/sh\nexec \"{}\" -m ziglang cc -target {}-linux-gnu.{}.{} \"$@\"\n",
        python.display(),
        std::env::consts::ARCH,
        GLIBC.0,
        GLIBC.1
    );
    crate::write(&path, &text)?;
    succeed(Command::new("chmod").arg("+x").arg(&path))?;
    Ok(["-C".to_owned(), format!("linker={}", path.display())])
}

/// Checks that a program asks for no function that is younger than the oldest glibc.
pub fn check(program: &Path) -> Result<(), String> {
    let objdump = viewer::program("objdump").ok_or("objdump is not installed (binutils)")?;
    let mut list = Command::new(objdump);
    let listed = list.arg("-T").arg(program).output();
    let listed = listed.map_err(|e| format!("objdump: {e}"))?;
    let table = String::from_utf8_lossy(&listed.stdout);
    let versions = versions(&table);
    let newest = versions
        .iter()
        .max()
        .ok_or_else(|| format!("{} names no symbol of glibc", program.display()))?;
    println!("newest symbol: GLIBC_{}.{}", newest.0, newest.1);
    verdict(younger(&table))
}

/// The lines of a table of symbols that ask for more than the oldest glibc has.
fn younger(table: &str) -> Vec<String> {
    let too_young = |line: &&str| versions(line).iter().any(|v| *v > GLIBC);
    table.lines().filter(too_young).map(str::to_owned).collect()
}

/// The versions of glibc that a text names; a part after the second number changes nothing here.
fn versions(text: &str) -> Vec<Version> {
    let number = |s: Option<&str>| s.and_then(|s| s.parse().ok());
    let named = text.split("GLIBC_").skip(1);
    named
        .filter_map(|rest| {
            let mut parts = rest.split(|c: char| !c.is_ascii_digit());
            Some((number(parts.next())?, number(parts.next())?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "\
0000000000000000      DF *UND*\t0000000000000000 (GLIBC_2.2.5) memcpy
0000000000000000      DF *UND*\t0000000000000000 (GLIBC_2.17) clock_gettime
0000000000000000  w   DF *UND*\t0000000000000000  Base        __gmon_start__
0000000000000000      DF *UND*\t0000000000000000 (GLIBC_2.29) exp
0000000000000000      DO *UND*\t0000000000000000  GLIBC_PRIVATE something";

    #[test]
    fn symbols_of_a_younger_library_are_told_by_their_lines() {
        assert_eq!(versions(TABLE), [(2, 2), (2, 17), (2, 29)]);
        let told = younger(TABLE);
        assert!(told.len() == 1 && told[0].ends_with(" exp"), "{told:?}");
    }
}
