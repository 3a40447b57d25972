//! A contact sheet as a page: meshes side by side, with what is said of each.

use crate::escape::escaped;
use crate::page::head;
use crate::pictures::address;
use phex_picture::{ContactTile, common_azimuth, contact_sheet};
use std::path::Path;

/// What a contact sheet is written as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SheetKind {
    /// A PNG picture.
    #[default]
    Picture,
    /// An HTML page.
    Page,
}

impl SheetKind {
    /// The kind that the extension of a name says.
    ///
    /// ```
    /// use phex_html::SheetKind;
    ///
    /// assert_eq!(SheetKind::of("roof.PNG".as_ref()), Some(SheetKind::Picture));
    /// assert_eq!(SheetKind::of("roof.html".as_ref()), Some(SheetKind::Page));
    /// assert_eq!(SheetKind::of("roof.jpg".as_ref()), None);
    /// ```
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(Self::Picture),
            "html" | "htm" => Some(Self::Page),
            _ => None,
        }
    }
}

/// The bytes of a contact sheet's file.
pub fn contact_file(
    kind: SheetKind,
    title: &str,
    heading: &str,
    tiles: &[ContactTile<'_>],
) -> Vec<u8> {
    match kind {
        SheetKind::Picture => contact_sheet(heading, tiles).to_png(),
        SheetKind::Page => contact_page(title, heading, tiles).into_bytes(),
    }
}

/// The page of a contact sheet; it needs neither scripts nor a network.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()].to_vec();
/// # let mesh = HexMesh::new(corners, &[[0, 1, 2]])?;
/// use phex_html::contact_page;
/// use phex_picture::ContactTile;
///
/// let lines = ["1 panel".to_owned()];
/// let tile = ContactTile { mesh: &mesh, title: "A triangle", lines: &lines };
/// assert!(contact_page("roof.obj", "One way was tried.", &[tile]).contains("1 panel"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_page(title: &str, heading: &str, tiles: &[ContactTile<'_>]) -> String {
    let azimuth = common_azimuth(tiles);
    let figures: String = tiles.iter().map(|tile| figure(tile, azimuth)).collect();
    let title = escaped(title);
    format!(
        "{}<body>\n<header>\n<div class=\"title\"><span class=\"brand\">phex</span><h1>{title}</h1></div>\n</header>\n<main>\n\
         <p class=\"note\">{}</p>\n<div class=\"gallery\">\n{figures}</div>\n</main>\n</body>\n</html>\n",
        head(&title, "contact sheet"),
        escaped(heading)
    )
}

fn figure(tile: &ContactTile<'_>, azimuth: Option<f64>) -> String {
    let lines: String = (tile.lines.iter())
        .map(|line| format!("<br>{}", escaped(line)))
        .collect();
    let title = escaped(tile.title);
    format!(
        "<figure><img alt=\"{title}\" src=\"{}\"><figcaption><b>{title}</b>{lines}</figcaption></figure>\n",
        address(&tile.picture(azimuth))
    )
}
