//! The page itself.

/// The page where its script was not built.
const WITHOUT_SCRIPT: &str = "<!doctype html><html lang=\"en\"><title>phex studio</title><p>This program was built without npm, \
                              which makes the page of the studio. Everything else works: see <code>phex --help</code>.";

/// The page: its head and an empty body, which the script fills.
pub fn html() -> &'static str {
    match phex_html::studio_script() {
        Some(_) => include_str!("page.html"),
        None => WITHOUT_SCRIPT,
    }
}

/// Its style: that of the report's view, and its own.
pub fn style() -> String {
    format!("{}\n{}", phex_html::VIEW_STYLE, include_str!("page.css"))
}
