//! The interactive viewer, where it was built.

/// The script that makes a report interactive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewer {
    script: &'static str,
}

impl Viewer {
    /// The viewer that was built into this program, if there is one.
    pub fn embedded() -> Option<Self> {
        #[cfg(viewer_bundle)]
        let script = Some(include_str!(env!("PHEX_VIEWER")));
        #[cfg(not(viewer_bundle))]
        let script = None;
        script.map(|script| Self { script })
    }

    /// Why no viewer was built in; nothing if one was.
    pub fn absent() -> Option<&'static str> {
        #[cfg(viewer_bundle)]
        let reason = None;
        #[cfg(not(viewer_bundle))]
        let reason = Some(env!("PHEX_NO_VIEWER"));
        reason
    }

    /// A viewer that is a script of the caller's own.
    pub fn from_script(script: &'static str) -> Self {
        Self { script }
    }

    /// The script so that it can stand in a page: nothing in it ends the element.
    pub fn inline_script(&self) -> String {
        self.script.replace("</script", "<\\/script")
    }
}

/// The script of the page of `phex studio`, which shares modules with the viewer and is built with
/// it; nothing where the viewer was not built.
pub fn studio_script() -> Option<&'static str> {
    #[cfg(viewer_bundle)]
    let script = Some(include_str!(env!("PHEX_STUDIO")));
    #[cfg(not(viewer_bundle))]
    let script = None;
    script
}
