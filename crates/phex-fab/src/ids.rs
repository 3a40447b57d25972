//! Names of panels, edges and nodes, by which all files refer to one another.
//!
//! *Panels.* Where the connectivity has [rows](crate::rows), a letter for the row and a number in
//! it (`A1`, `B12`, after `Z` comes `AA`); else `P0001`, in the order of the faces in the file.
//! Both depend on connectivity and, for rows, on which family of rows is the most level: they are
//! the same in every run, and stay when vertices move a little. When panels are added or removed,
//! give the `panels` table of the last run ([`PanelIds::keeping`]): every panel whose centre is
//! within half a mean edge of one in that table, and nearer to it than any other, keeps its name;
//! names of panels that are gone are not used again.
//!
//! Names are engraved in capitals, stand in lists and in tables that spreadsheets open; what can't
//! be told apart or read there is no name ([`check_name`]).
//!
//! *Edges* and *nodes* are `E0001` and `N0001`, in the order of the mesh.

use crate::rows::rows;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerFace, Vec3, VertexId};
use phex_picture::strokes::{SLASHED_ZERO, is_drawn};
use std::collections::HashSet;

/// Names of all panels of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelIds {
    names: PerFace<String>,
    has_rows: bool,
    kept: Option<usize>,
}

impl PanelIds {
    /// The names that the mesh itself leads to.
    pub fn new(mesh: &HexMesh) -> Self {
        let count = mesh.topology().n_faces();
        let rows = rows(mesh);
        let numbered = || PerFace::from_fn(count, |f: FaceId| numbered('P', f.index(), count));
        let named = |rows: &PerFace<[usize; 2]>| {
            rows.map(|&[row, place]| format!("{}{}", letters(row), place + 1))
        };
        Self {
            names: rows.as_ref().map_or_else(numbered, named),
            has_rows: rows.is_some(),
            kept: None,
        }
    }

    /// As [`new`](Self::new), but panels near one of `previous` (name and centre, model units) keep
    /// its name.
    pub fn keeping(mesh: &HexMesh, previous: &[(String, Vec3)]) -> Self {
        let fresh = Self::new(mesh);
        let kept = kept(mesh, previous);
        let mut taken: HashSet<String> = previous.iter().map(|(name, _)| engraved(name)).collect();
        let mut next = mesh.topology().n_faces();
        let name = |f: FaceId| match kept[f] {
            Some(k) => previous[k].0.clone(),
            None => {
                let mut name = fresh.names[f].clone();
                while !taken.insert(engraved(&name)) {
                    name = numbered('P', next, next + 1);
                    next += 1;
                }
                name
            }
        };
        Self {
            names: PerFace::from_fn(mesh.topology().n_faces(), name),
            has_rows: fresh.has_rows,
            kept: Some(kept.iter().flatten().count()),
        }
    }

    /// Name of a panel.
    pub fn panel(&self, face: FaceId) -> &str {
        &self.names[face]
    }

    /// The names of all panels, in the order of the faces.
    pub fn into_names(self) -> Vec<String> {
        self.names.into_vec()
    }

    /// How many panels keep a name of an earlier run, where there is one.
    pub fn kept(&self) -> Option<usize> {
        self.kept
    }

    /// Whether the mesh has rows.
    pub fn has_rows(&self) -> bool {
        self.has_rows
    }
}

/// Most characters of a name.
const LONGEST: usize = 32;

/// Checks that a text can be the name of a panel: 1 to 32 letters A to Z, digits, blanks and
/// `.-_+/:%°`, no blank at either end, and none of the signs with which a spreadsheet's formulas
/// begin at the start.
///
/// ```
/// use phex_fab::ids::check_name;
///
/// assert!(check_name("North 12-B").is_ok());
/// assert!(check_name("=A1").is_err());
/// ```
///
/// # Errors
/// Says what is wrong.
pub fn check_name(name: &str) -> Result<(), String> {
    let count = name.chars().count();
    if count > LONGEST {
        return Err(format!(
            "the name has {count} characters, more than {LONGEST}"
        ));
    }
    let Some(first) = name.chars().next() else {
        return Err("the name is empty".into());
    };
    if "=+-@".contains(first) {
        return Err(format!(
            "the name {name:?} begins with {first:?}, as formulas of spreadsheets do"
        ));
    }
    // Commas part the columns of tables.
    let is_fit = |c| c == ' ' || !(c == ',' || c == SLASHED_ZERO) && is_drawn(c);
    if let Some(sign) = name.chars().find(|&c| !is_fit(c)) {
        return Err(format!(
            "the name {name:?} holds {sign:?}, which can't be engraved: take letters A to Z, digits, blanks and .-_+/:%°"
        ));
    }
    if name.trim() != name {
        return Err(format!("the name {name:?} begins or ends with a blank"));
    }
    Ok(())
}

/// A name as it is engraved: two names that are the same here can't be told apart.
pub fn engraved(name: &str) -> String {
    name.to_ascii_uppercase()
}

/// A text in the characters that are engraved: a zero is no letter.
pub fn written(text: &str) -> String {
    engraved(text).replace('0', &SLASHED_ZERO.to_string())
}

/// Name of an edge.
pub fn edge_name(mesh: &HexMesh, edge: EdgeId) -> String {
    numbered('E', edge.index(), mesh.topology().n_edges())
}

/// Name of a node.
pub fn node_name(mesh: &HexMesh, vertex: VertexId) -> String {
    numbered('N', vertex.index(), mesh.topology().n_vertices())
}

fn numbered(letter: char, index: usize, count: usize) -> String {
    let width = count.to_string().len().max(4);
    format!("{letter}{:0width$}", index + 1)
}

/// `A` to `Z`, then `AA`.
fn letters(row: usize) -> String {
    let last = char::from(b'A' + (row % 26) as u8);
    match row / 26 {
        0 => last.to_string(),
        more => letters(more - 1) + &last.to_string(),
    }
}

/// Which of the previous panels each face is: mutually nearest, within half a mean edge.
fn kept(mesh: &HexMesh, previous: &[(String, Vec3)]) -> PerFace<Option<usize>> {
    let reach = 0.5 * mesh.mean_edge();
    let centres = mesh.centres();
    let old: Vec<Vec3> = previous.iter().map(|(_, centre)| *centre).collect();
    let back: Vec<Option<usize>> = old
        .iter()
        .map(|p| nearest(p, centres.as_slice(), reach))
        .collect();
    PerFace::from_fn(centres.len(), |f: FaceId| {
        nearest(&centres[f], &old, reach).filter(|&k| back[k] == Some(f.index()))
    })
}

fn nearest(p: &Vec3, among: &[Vec3], reach: f64) -> Option<usize> {
    let distances = among.iter().map(|q| (q - p).norm()).enumerate();
    let (k, distance) = distances.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (distance <= reach).then_some(k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{cuboid, honeycomb};

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!(
            [0, 25, 26, 51, 52, 701, 702].map(letters),
            ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA"]
        );
    }

    #[test]
    fn names_survive_moved_vertices_and_a_lost_row() {
        let flat = honeycomb(3, 4, |p| p);
        let ids = PanelIds::new(&flat);
        assert_eq!(
            (ids.panel(FaceId::new(0)), ids.panel(FaceId::new(7))),
            ("A1", "B4")
        );
        let bent = honeycomb(3, 4, |p| p + Vec3::z() * 1e-3 * p.x * p.x);
        assert_eq!(PanelIds::new(&bent).names, ids.names);

        // Without the first row the names shift, unless the old ones are kept.
        let previous: Vec<(String, Vec3)> = flat
            .topology()
            .faces()
            .map(|f| (ids.panel(f).to_owned(), flat.centre(f)))
            .collect();
        let mut soup = flat.to_soup();
        soup.faces.drain(..4);
        let used: Vec<u32> = (0..soup.positions.len() as u32)
            .filter(|v| soup.faces.iter().flatten().any(|w| w == v))
            .collect();
        let faces: Vec<Vec<u32>> = soup
            .faces
            .iter()
            .map(|f| {
                f.iter()
                    .map(|v| used.iter().position(|w| w == v).unwrap() as u32)
                    .collect()
            })
            .collect();
        let positions = used.iter().map(|&v| soup.positions[v as usize]).collect();
        let cut = HexMesh::new(positions, &faces).unwrap();
        assert_eq!(PanelIds::new(&cut).panel(FaceId::new(0)), "A1");
        let kept = PanelIds::keeping(&cut, &previous);
        assert_eq!((kept.kept(), ids.kept()), (Some(8), None));
        assert_eq!(
            (kept.panel(FaceId::new(0)), kept.panel(FaceId::new(7))),
            ("B1", "C4")
        );
    }

    #[test]
    fn a_new_panel_gets_a_name_that_was_never_used() {
        let mesh = cuboid(1.0, 1.0, 1.0);
        let centre = |f: u32| mesh.centre(FaceId::new(f));
        let previous = vec![
            ("P0001".to_owned(), centre(3)),
            ("P0004".to_owned(), Vec3::repeat(9.0)),
        ];
        let ids = PanelIds::keeping(&mesh, &previous);
        let names: Vec<&str> = mesh.topology().faces().map(|f| ids.panel(f)).collect();
        assert_eq!(
            names,
            ["P0007", "P0002", "P0003", "P0001", "P0005", "P0006"]
        );
    }
}
