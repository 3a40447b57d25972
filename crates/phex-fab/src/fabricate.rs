//! From a mesh to everything that is written.

use crate::error::FabError;
use crate::groups::Groups;
use crate::ids::PanelIds;
use crate::labels::{self, PanelText, SideText};
use crate::nest::{Placement, SheetLayout, nest};
use crate::options::FabOptions;
use crate::plate::{Plate, PlateSide};
use phex::Progress;
use phex::offset::{
    GaussImage, OffsetError, OffsetOptions, PanelSolid, face_gauss_image, layer, panel_solids,
    safe_distances,
};
use phex_mesh::{FaceId, HexMesh, ValidHexMesh, ValidateOptions, validate};
use rayon::prelude::*;

/// Everything about the panels that the files are made from.
#[derive(Clone, Debug)]
pub struct Fabrication {
    /// The mesh.
    pub mesh: ValidHexMesh,
    /// What was asked for.
    pub options: FabOptions,
    /// Names.
    pub ids: PanelIds,
    /// Thick panels in place, by face, model units.
    pub solids: Vec<PanelSolid>,
    /// The same laid flat, mm.
    pub plates: Vec<Plate>,
    /// What is the same.
    pub groups: Groups,
    /// What is written on them.
    pub texts: Vec<PanelText>,
    /// Where they lie on sheets.
    pub sheets: Vec<SheetLayout>,
}

/// Area of panels over area of sheets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SheetUse {
    /// All sheets whole.
    pub whole_sheets: f64,
    /// The last sheet only up to where it is cut off: the rest goes back to stock.
    pub without_last_offcut: f64,
}

impl Fabrication {
    /// Sheet and place of each panel, in the order of the plates.
    pub fn placements(&self) -> Vec<(usize, Placement)> {
        let sheets = self.sheets.iter().enumerate();
        let mut placements: Vec<(usize, Placement)> = sheets
            .flat_map(|(k, sheet)| sheet.iter().map(move |p| (k, *p)))
            .collect();
        // Every panel is on one sheet.
        placements.sort_by_key(|(_, p)| p.plate);
        placements
    }

    /// Area of the panels of a sheet over its own.
    pub fn sheet_use(&self, sheet: usize) -> f64 {
        let [length, width] = self.options.sheet_mm;
        let area: f64 = self.sheets[sheet]
            .iter()
            .map(|p| self.plates[p.plate].area())
            .sum();
        area / (length * width)
    }

    /// How far along a sheet its panels reach, with the spacing, in mm.
    pub fn reach(&self, sheet: usize) -> f64 {
        let faces = self.sheets[sheet].iter().flat_map(|p| {
            let plate = &self.plates[p.plate];
            [p.apply(&plate.top), p.apply(&plate.bottom)].concat()
        });
        let right = faces.map(|p| p.x).fold(0.0, f64::max);
        (right + self.options.spacing_mm).min(self.options.sheet_mm[0])
    }

    /// Use of all sheets.
    pub fn total_use(&self) -> SheetUse {
        let [length, width] = self.options.sheet_mm;
        let area: f64 = self.plates.iter().map(Plate::area).sum();
        let full = (self.sheets.len() - 1) as f64 * length;
        let last = self.reach(self.sheets.len() - 1);
        SheetUse {
            whole_sheets: area / ((full + length) * width),
            without_last_offcut: area / ((full + last) * width),
        }
    }
}

/// The mesh with the promise that it is valid.
///
/// # Errors
/// If it is not; the panels of the first violation are named.
pub fn valid_mesh(
    mesh: HexMesh,
    ids: &PanelIds,
    options: &ValidateOptions,
) -> Result<ValidHexMesh, FabError> {
    validate(mesh, None, options).map_err(|cause| {
        let faces = cause.violations[0].faces(cause.mesh.topology());
        FabError::Invalid {
            panels: names(ids, faces),
            cause,
        }
    })
}

/// Makes panels of a mesh and puts them on sheets.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::Silent;
/// use phex_fab::folder::files;
/// use phex_fab::{FabOptions, PanelIds, fabricate};
/// use phex_mesh::{ValidateOptions, validate};
///
/// let ids = PanelIds::new(&cube);
/// let mesh = validate(cube, None, &ValidateOptions::default())?;
/// let fabrication = fabricate(mesh, ids, FabOptions::default(), &Silent)?;
/// assert_eq!(fabrication.plates.len(), 6);
/// let names: Vec<String> = files(&fabrication)?.into_iter().map(|(name, _)| name).collect();
/// assert!(names.contains(&"sheets/sheet-01.dxf".to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If an option is out of range, the thickness goes past the safe offset, the gap eats up a panel,
/// or a panel does not fit on a sheet; panels are named. Also if `progress` cancels.
pub fn fabricate(
    mesh: ValidHexMesh,
    ids: PanelIds,
    options: FabOptions,
    progress: &dyn Progress,
) -> Result<Fabrication, FabError> {
    check(&options)?;
    let solids = solids(&mesh, &ids, &options)?;
    let plates: Vec<Plate> = solids
        .iter()
        .map(|s| Plate::new(&mesh, s, options.unit_mm))
        .collect();
    let name = |k: usize| ids.panel(plates[k].face).to_owned();
    let sheets = nest(&plates, &options, name, progress)?;
    let texts = plates
        .par_iter()
        .map(|plate| texts(plate, &ids, options.text_mm))
        .collect();
    let groups = Groups::new(&mesh, &plates, &options);
    Ok(Fabrication {
        mesh,
        options,
        ids,
        solids,
        plates,
        groups,
        texts,
        sheets,
    })
}

fn texts(plate: &Plate, ids: &PanelIds, largest: f64) -> PanelText {
    let text = |(side, s): (usize, &PlateSide)| {
        Some(SideText {
            side,
            neighbour: ids.panel(s.neighbour?).to_owned(),
            mitre: format!("{:+.1}", s.mitre.to_degrees()),
        })
    };
    let texts: Vec<SideText> = plate.sides.iter().enumerate().filter_map(text).collect();
    labels::place(plate, ids.panel(plate.face), &texts, largest)
}

/// Degrees beyond which no two angles are the same.
const LARGEST_ANGLE_TOLERANCE: f64 = 10.0;

fn check(options: &FabOptions) -> Result<(), FabError> {
    let positive = [
        ("the thickness", options.thickness),
        ("the unit", options.unit_mm),
        ("the sheet's length", options.sheet_mm[0]),
        ("the sheet's width", options.sheet_mm[1]),
        ("the tolerance", options.tolerance_mm),
        ("the angle tolerance", options.angle_tolerance),
    ];
    let bad = |value: f64, least: f64| !(value.is_finite() && value >= least);
    if let Some(&(name, value)) = positive.iter().find(|(_, v)| bad(*v, f64::MIN_POSITIVE)) {
        return Err(FabError::Option {
            name,
            range: "a finite number above 0",
            value,
        });
    }
    if options.angle_tolerance > LARGEST_ANGLE_TOLERANCE.to_radians() {
        return Err(FabError::Option {
            name: "the angle tolerance",
            range: "at most 10 degrees, as parts that differ by more are not the same",
            value: options.angle_tolerance.to_degrees(),
        });
    }
    let not_negative = [
        ("the gap", options.gap),
        ("the spacing", options.spacing_mm),
    ];
    if let Some(&(name, value)) = not_negative.iter().find(|(_, v)| bad(*v, 0.0)) {
        return Err(FabError::Option {
            name,
            range: "a finite number of at least 0",
            value,
        });
    }
    if bad(options.text_mm, labels::LEAST) {
        return Err(FabError::Option {
            name: "the text height",
            range: "at least 3.4 mm, as smaller engraving can't be read",
            value: options.text_mm,
        });
    }
    check_room(options)
}

fn check_room(options: &FabOptions) -> Result<(), FabError> {
    let (sheet, spacing) = (options.sheet_mm, options.spacing_mm);
    if sheet[0].min(sheet[1]) > 2.0 * spacing {
        return Ok(());
    }
    Err(FabError::NoRoom { sheet, spacing })
}

fn solids(
    mesh: &ValidHexMesh,
    ids: &PanelIds,
    options: &FabOptions,
) -> Result<Vec<PanelSolid>, FabError> {
    let offset_options = OffsetOptions {
        validity: options.validity,
        ..Default::default()
    };
    let refused = |cause: OffsetError, safe| FabError::Offset {
        panels: names(ids, faces_of(&cause, mesh)),
        safe,
        cause,
    };
    let image = face_gauss_image(mesh, &offset_options).map_err(|e| refused(e, None))?;
    let [low, high] = options.side.layers(options.thickness);
    let moved = |distance: f64| -> Result<HexMesh, FabError> {
        if distance == 0.0 {
            return Ok(HexMesh::clone(mesh));
        }
        let layer = layer(mesh, &image, distance, &offset_options);
        layer.map_err(|e| refused(e, safe(mesh, &image, distance, options)))
    };
    panel_solids(&moved(low)?, &moved(high)?, options.gap).map_err(|e| refused(e, None))
}

/// The largest thickness whose layer on the side of `distance` is valid.
fn safe(mesh: &HexMesh, image: &GaussImage, distance: f64, options: &FabOptions) -> Option<f64> {
    let offset_options = OffsetOptions {
        validity: options.validity,
        ..Default::default()
    };
    let safe = safe_distances(mesh, image, &offset_options);
    let side = if distance < 0.0 {
        safe.inward
    } else {
        safe.outward
    };
    Some(side.distance * options.thickness / distance.abs())
}

fn faces_of(error: &OffsetError, mesh: &HexMesh) -> Vec<FaceId> {
    match error {
        OffsetError::NotPlanar { face, .. }
        | OffsetError::NoArea { face }
        | OffsetError::Gap { face, .. }
        | OffsetError::Volume { face, .. } => vec![*face],
        OffsetError::NotValid { first, .. } => first.faces(mesh.topology()),
        OffsetError::WrongDegree { vertex, .. } | OffsetError::Incompatible { vertex, .. } => {
            mesh.topology().faces_at(*vertex).collect()
        }
        _ => Vec::new(),
    }
}

fn names(ids: &PanelIds, faces: Vec<FaceId>) -> Vec<String> {
    faces.into_iter().map(|f| ids.panel(f).to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_without_room_inside_of_its_spacing_is_refused() {
        let checked = |sheet_mm, spacing_mm| {
            check(&FabOptions {
                sheet_mm,
                spacing_mm,
                ..FabOptions::default()
            })
        };
        for sheet in [[5.0, 5.0], [2500.0, 10.0], [4.0, 1250.0]] {
            let told = checked(sheet, 5.0).unwrap_err().to_string();
            assert!(told.contains("no room for a panel with 5 mm"), "{told}");
        }
        assert!(checked([10.1, 10.1], 5.0).is_ok());
        assert!(checked([5.0, 5.0], 0.0).is_ok());
    }

    #[test]
    fn a_text_height_that_can_t_be_the_largest_is_refused() {
        let checked = |text_mm| {
            check(&FabOptions {
                text_mm,
                ..FabOptions::default()
            })
        };
        assert!(checked(labels::LEAST).is_ok());
        let told = checked(2.0).unwrap_err().to_string();
        let least = format!("at least {} mm", labels::LEAST);
        assert!(told.contains(&least), "{told}");
    }
}
