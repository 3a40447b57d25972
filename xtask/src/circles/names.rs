//! Which module defines what a path names.

use super::sources::{Segments, Source};
use std::collections::BTreeMap;

/// Steps from one `use` to the next that are followed.
const STEPS: usize = 16;

/// The modules of a crate and what `use` brings into each.
pub struct Names<'a> {
    modules: BTreeMap<&'a [String], &'a Source>,
}

impl<'a> Names<'a> {
    /// Takes the files of a crate.
    pub fn new(sources: &[&'a Source]) -> Self {
        let modules = sources.iter().map(|s| (&s.module[..], *s)).collect();
        Self { modules }
    }

    /// The module that defines what a path names where it stands in the module `from`. What is none
    /// of this crate's counts as that module's own.
    pub fn module_of(&self, from: &Segments, path: &Segments) -> Segments {
        self.followed(from, path, STEPS)
            .unwrap_or_else(|| from.clone())
    }

    fn followed(&self, from: &[String], path: &[String], steps: usize) -> Option<Segments> {
        let (mut module, mut rest) = self.start(from, path)?;
        loop {
            let Some(name) = rest.first() else {
                return Some(module);
            };
            let inner = [&module[..], std::slice::from_ref(name)].concat();
            if !self.modules.contains_key(&inner[..]) {
                break;
            }
            (module, rest) = (inner, &rest[1..]);
        }
        let imported = self.imported(&module, rest, steps);
        imported.or(Some(module))
    }

    /// The module at which a path begins, and the rest of the path.
    fn start<'p>(&self, from: &[String], path: &'p [String]) -> Option<(Segments, &'p [String])> {
        let climbs = path.iter().take_while(|s| *s == "super").count();
        match path[0].as_str() {
            "crate" => Some((Vec::new(), &path[1..])),
            "self" => Some((from.to_vec(), &path[1..])),
            "super" => Some((
                from.get(..from.len().checked_sub(climbs)?)?.to_vec(),
                &path[climbs..],
            )),
            // Only modules of its own and what `use` has brought in have a name without these.
            _ => Some((from.to_vec(), path)),
        }
    }

    /// Where a name comes from that a `use` has brought into a module.
    fn imported(&self, module: &[String], rest: &[String], steps: usize) -> Option<Segments> {
        let steps = steps.checked_sub(1)?;
        let source = self.modules.get(module)?;
        let (_, path) = source.imports.iter().find(|(name, _)| *name == rest[0])?;
        let path = [&path[..], &rest[1..]].concat();
        if path == rest {
            return None;
        }
        self.followed(module, &path, steps)
    }
}
