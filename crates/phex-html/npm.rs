//! Which packages the viewer is built with: for the build script and for `cargo xtask`, so that the
//! two can't differ. Neither has libraries: npm writes its lock files one field a line, and this
//! reads them so.

use std::collections::BTreeMap;
use std::path::Path;

/// How packages are fetched: those of the lock file alone, none of whose scripts runs; without a
/// network this fails at once.
pub const FETCH: [&str; 4] = ["ci", "--silent", "--ignore-scripts", "--fetch-retries=0"];

/// A package of a lock file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Package {
    /// The hash of its archive.
    integrity: Option<String>,
    /// Whether it may be missing: it is for another machine.
    optional: bool,
}

/// Whether the packages that are installed are those of the lock file, by their hashes.
///
/// # Errors
/// If the lock file can't be read, holds no package, or holds one without a hash: such a one could
/// be anything.
pub fn is_installed(source: &Path) -> Result<bool, String> {
    let path = source.join("package-lock.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("package-lock.json: {e}"))?;
    let locked = packages(&text);
    if locked.is_empty() {
        return Err("package-lock.json names no package".to_owned());
    }
    if let Some((name, _)) = locked.iter().find(|(_, p)| p.integrity.is_none()) {
        return Err(format!(
            "package-lock.json has no integrity hash of {name}, so it is not fetched"
        ));
    }
    let installed = std::fs::read_to_string(source.join("node_modules/.package-lock.json"));
    let installed = packages(&installed.unwrap_or_default());
    let agrees = |(name, package): (&String, &Package)| match installed.get(name) {
        Some(there) => there.integrity == package.integrity,
        None => package.optional,
    };
    let known = |name: &String| locked.contains_key(name);
    Ok(locked.iter().all(agrees) && installed.keys().all(known))
}

/// The packages of a lock file by their folders.
fn packages(lock: &str) -> BTreeMap<String, Package> {
    let mut found: BTreeMap<String, Package> = BTreeMap::new();
    let mut current: Option<String> = None;
    for line in lock.lines().map(str::trim) {
        if let Some(name) = line.strip_suffix("\": {").and_then(|l| l.strip_prefix('"')) {
            let is_package = name.starts_with("node_modules/");
            // Tables inside of a package, such as its dependencies, hold no hash of its own.
            if is_package {
                found.insert(name.to_owned(), Package::default());
                current = Some(name.to_owned());
            }
            continue;
        }
        let Some(package) = current.as_ref().and_then(|name| found.get_mut(name)) else {
            continue;
        };
        if let Some(hash) = line.strip_prefix("\"integrity\": ") {
            let hash = hash.trim_matches([',', '"']);
            package.integrity = Some(hash.to_owned()).filter(|h| h.starts_with("sha512-"));
        } else if line.starts_with("\"optional\": true") {
            package.optional = true;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOCK: &str = r#"{
  "packages": {
    "": { "version": "0.1.0" },
    "node_modules/three": {
      "version": "0.187.0",
      "integrity": "sha512-abc==",
      "dependencies": {
        "tslib": "^2.4.0"
      }
    },
    "node_modules/for-a-mac": {
      "integrity": "sha512-def==",
      "optional": true
    }
  }
}"#;

    /// Says whether `installed` are the packages of `lock`.
    fn judged(lock: &str, installed: Option<&str>, name: &str) -> Result<bool, String> {
        let folder = std::env::temp_dir().join(format!("phex-npm-{}-{name}", std::process::id()));
        std::fs::create_dir_all(folder.join("node_modules")).unwrap();
        std::fs::write(folder.join("package-lock.json"), lock).unwrap();
        if let Some(text) = installed {
            std::fs::write(folder.join("node_modules/.package-lock.json"), text).unwrap();
        }
        let result = is_installed(&folder);
        std::fs::remove_dir_all(&folder).unwrap();
        result
    }

    #[test]
    fn packages_of_another_lock_file_are_fetched_anew() {
        let mac = LOCK.find("    \"node_modules/for-a-mac").unwrap();
        let here = &LOCK[..mac];
        assert_eq!(judged(LOCK, Some(here), "same"), Ok(true));
        let stale = here.replace("abc==", "old==");
        assert_eq!(judged(LOCK, Some(&stale), "stale"), Ok(false));
        let more = format!("{here}    \"node_modules/left-over\": {{\n    }}");
        assert_eq!(judged(LOCK, Some(&more), "more"), Ok(false));
        assert_eq!(judged(LOCK, None, "none"), Ok(false));
    }

    #[test]
    fn a_package_without_a_hash_is_never_fetched() {
        let bare = LOCK.replace("\"integrity\": \"sha512-abc==\",", "");
        let refusal = judged(&bare, None, "bare").unwrap_err();
        assert!(refusal.contains("node_modules/three"), "{refusal}");
        let weak = LOCK.replace("sha512-abc", "sha1-abc");
        assert!(judged(&weak, None, "weak").is_err());
        assert!(judged("{}", None, "empty").is_err());
    }

    #[test]
    fn the_viewer_s_lock_file_has_a_hash_of_every_package() {
        let lock = include_str!("../../studio/viewer/package-lock.json");
        let all = packages(lock);
        assert!(all.len() > 20 && all.values().all(|p| p.integrity.is_some()));
    }
}
