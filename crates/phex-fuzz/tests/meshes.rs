//! Random panels for what is computed from panels: nothing panics, and what is said to be valid is
//! right by the judge that shares no code with the project.

use arbitrary::Unstructured;
use phex::Silent;
use phex::offset::{OffsetOptions, face_gauss_image, layer, safe_distances};
use phex::optimise::{OptimiseOptions, Steering};
use phex::smooth_surface::extend;
use phex::trim::{Boundary, Domain, trim};
use phex_fab::{FabOptions, PanelIds, fabricate};
use phex_fuzz::RawMesh;
use phex_fuzz::campaign::{Tried, campaign};
use phex_fuzz::referee::faults;
use phex_job::{Planarization, planarize};
use phex_mesh::validate::violations;
use phex_mesh::{HexMesh, TopologyError, TriangleSurface, ValidateOptions, Vec3, validate};
use std::collections::HashMap;

/// Limits of phex and of the judge differ by rounding at most; a mesh this close to one is left
/// out.
const NEAR: f64 = 1e-6;

/// A honeycomb with edges of length 1 whose vertices are in the planes of a bowl, so that its
/// panels are planar.
fn bowl(rows: usize, columns: usize, bend: f64) -> RawMesh {
    let mut numbers: HashMap<(usize, usize), usize> = HashMap::new();
    let mut mesh = RawMesh::default();
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        // In units of half the width and a quarter of the height.
        let (x, y) = (2 * column + row % 2 + 1, 6 * row + 4);
        let ring = [(1, 0), (2, 2), (2, 6), (1, 8), (0, 6), (0, 2)];
        let face = ring.map(|(dx, dy)| {
            *numbers.entry((x + dx - 1, y + dy - 4)).or_insert_with(|| {
                let (x, y) = (
                    0.75_f64.sqrt() * (x + dx - 1) as f64,
                    0.25 * (y + dy - 4) as f64,
                );
                mesh.points.push([x, y, bend * (x * x + y * y - 1.0)]);
                mesh.points.len() - 1
            })
        });
        mesh.faces.push(face.to_vec());
    }
    mesh
}

/// A honeycomb of which some vertices are moved, nearly always by little.
fn random_mesh(u: &mut Unstructured) -> arbitrary::Result<RawMesh> {
    let (rows, columns) = (u.int_in_range(1..=4)?, u.int_in_range(1..=4)?);
    let bend = *u.choose(&[0.0, 0.02, 0.1, -0.05, 1.0])?;
    let mut mesh = bowl(rows, columns, bend);
    for _ in 0..u.int_in_range(0..=6)? {
        let k = u.choose_index(mesh.points.len())?;
        let axis = u.choose_index(3)?;
        let other = mesh.points[u.choose_index(mesh.points.len())?];
        match u.int_in_range(0..=5u8)? {
            0 => mesh.points[k] = other,
            1 => mesh.points[k][axis] += *u.choose(&[1e-13, 1e-11, 1e-9, 1e-3])?,
            2 => mesh.points[k][axis] = other[axis],
            3 => mesh.points.swap(k, 0),
            _ => mesh.points[k][axis] += f64::from(u.arbitrary::<i16>()?) / 16384.0,
        }
    }
    let scale = *u.choose(&[1.0, 1e-3, 1e6, 1e-20, 1e20])?;
    let shift = *u.choose(&[0.0, 0.0, 0.0, 1e3])?;
    Ok(mesh.mapped(|p| p.map(|x| scale * (x + shift))))
}

fn hex_mesh(raw: &RawMesh) -> Option<HexMesh> {
    let positions = raw.points.iter().map(|&[x, y, z]| Vec3::new(x, y, z));
    let faces: Vec<Vec<u32>> = raw
        .faces
        .iter()
        .map(|f| f.iter().map(|&v| v as u32).collect())
        .collect();
    HexMesh::new(positions.collect(), &faces).ok()
}

fn raw_mesh(mesh: &HexMesh) -> RawMesh {
    let soup = mesh.to_soup();
    RawMesh {
        points: soup.positions.iter().map(|p| [p.x, p.y, p.z]).collect(),
        faces: soup
            .faces
            .iter()
            .map(|f| f.iter().map(|&v| v as usize).collect())
            .collect(),
    }
}

/// Kinds of violations, with limits that are a little wider or narrower.
fn kinds(mesh: &HexMesh, wider: f64) -> Vec<&'static str> {
    let usual = ValidateOptions::default();
    let options = ValidateOptions {
        // Far from the origin, rounding decides about a part of what is measured.
        planarity: Some(usual.planarity_limit(mesh) * (1.0 + 0.3 * wider.signum())),
        edge_length_rel: usual.edge_length_rel * (1.0 - wider),
        clearance: usual.clearance * (1.0 - wider),
        ..usual
    };
    let found = violations(mesh, None, &options);
    found.iter().map(|v| v.kind()).collect()
}

fn is_valid(mesh: &HexMesh, wider: f64) -> bool {
    kinds(mesh, wider).is_empty()
}

/// Two judges that share no code: neither passes what the other refuses.
#[test]
fn validating() {
    let figures = campaign(|u| {
        let Some(mesh) = random_mesh(u).ok().as_ref().and_then(hex_mesh) else {
            return Ok(Tried::default());
        };
        let raw = raw_mesh(&mesh);
        let (narrow, wide) = (is_valid(&mesh, -NEAR), kinds(&mesh, NEAR));
        // The judge leaves out edges that cross a panel at a vertex of it.
        let wide = wide.iter().all(|kind| *kind == "crossing");
        let faults = faults(&raw);
        match (narrow, wide, faults.is_empty()) {
            (true, _, false) => Err(format!("valid, but {faults:?}\n{}", raw.to_obj())),
            (_, false, true) => {
                let found = violations(&mesh, None, &ValidateOptions::default());
                Err(format!("no faults, but {found:?}\n{}", raw.to_obj()))
            }
            _ => Ok(Tried {
                taken: narrow,
                ratio: 0.0,
            }),
        }
    });
    println!("validate: {figures}");
    assert!(figures.taken > 0);
}

/// What comes out is as it went in but for its vertices, finite, and judged alike by both judges.
#[test]
fn planarizing() {
    let figures = campaign(|u| {
        let Some(mesh) = random_mesh(u).ok().as_ref().and_then(hex_mesh) else {
            return Ok(Tried::default());
        };
        let how = Planarization {
            options: OptimiseOptions::default(),
            steering: Steering::default(),
            refit: u.ratio(1, 3).unwrap_or(false),
            is_own: true,
        };
        let Ok(made) = planarize(&mesh, None, &how, &Silent) else {
            return Ok(Tried::default());
        };
        let raw = raw_mesh(&made.mesh);
        if made.mesh.topology().face_lists() != mesh.topology().face_lists() {
            return Err("the faces are others".to_owned());
        }
        let taken = is_valid(&made.mesh, -NEAR);
        match faults(&raw) {
            found if taken && !found.is_empty() => Err(format!("{found:?}\n{}", raw.to_obj())),
            _ => Ok(Tried { taken, ratio: 0.0 }),
        }
    });
    println!("planarize: {figures}");
    assert!(figures.taken > 0);
}

/// Layers are as valid as their mesh, and within the safe distances they exist.
#[test]
fn offsets() {
    let figures = campaign(|u| {
        let mesh = random_mesh(u).ok().as_ref().and_then(hex_mesh);
        let Some(mesh) = mesh.filter(|m| is_valid(m, -NEAR)) else {
            return Ok(Tried::default());
        };
        let options = OffsetOptions::default();
        let Ok(image) = face_gauss_image(&mesh, &options) else {
            return Ok(Tried::default());
        };
        let safe = safe_distances(&mesh, &image, &options);
        let far = u.int_in_range(-200..=200i32).unwrap_or(0);
        let part = f64::from(far) / 100.0;
        let side = if far < 0 { &safe.inward } else { &safe.outward };
        let reach = if side.distance > 0.0 && side.distance.is_finite() {
            side.distance
        } else {
            mesh.mean_edge()
        };
        let made = layer(&mesh, &image, part * reach, &options);
        let taken = made.is_ok();
        if let Err(error) = &made
            && side.distance > 0.0
            && part.abs() < 0.5
        {
            let (reach, obj) = (side.distance, raw_mesh(&mesh).to_obj());
            return Err(format!("no layer at {part} of {reach}: {error}\n{obj}"));
        }
        match made.map(|m| faults(&raw_mesh(&m))) {
            Ok(found) if !found.is_empty() && part.abs() < 0.99 => {
                Err(format!("{found:?}\n{}", raw_mesh(&mesh).to_obj()))
            }
            _ => Ok(Tried { taken, ratio: 0.0 }),
        }
    });
    println!("offsets: {figures}");
    assert!(figures.taken > 0);
}

/// A star about the origin with random corners, cut out of a honeycomb that covers it: no panel is
/// flipped or crosses itself.
#[test]
fn trimming() {
    let honeycomb = bowl(14, 13, 0.0).mapped(|[x, y, _]| [0.2 * x - 2.1, 0.2 * y - 2.0, 0.0]);
    let panels = hex_mesh(&honeycomb).expect("a manifold");
    let figures = campaign(|u| {
        let Ok((star, boundary)) = random_star(u) else {
            return Ok(Tried::default());
        };
        let Ok(surface) = surface(&star) else {
            return Ok(Tried::default());
        };
        let extension = extend(&surface, 0.5, 0.0).ok_or("a star has a boundary")?;
        let domain = Domain {
            extended: &extension.surface,
            extension: &extension,
            levels: 0,
            original: &surface,
            corner_angle: 0.5,
            limit: 5e-3,
        };
        let Ok(trimmed) = trim(&panels, &domain, boundary) else {
            return Ok(Tried::default());
        };
        let raw = raw_mesh(&trimmed.mesh);
        // What is too small is for the search that follows.
        let is_small = |f: &String| f.contains("length") || f.contains("clearance");
        let found: Vec<String> = faults(&raw).into_iter().filter(|f| !is_small(f)).collect();
        if !found.is_empty() {
            return Err(format!("{boundary:?}: {found:?} for\n{}", star.to_obj()));
        }
        Ok(Tried {
            taken: true,
            ratio: 0.0,
        })
    });
    println!("trimming: {figures}");
    assert!(figures.taken > 0);
}

fn random_star(u: &mut Unstructured) -> arbitrary::Result<(RawMesh, Boundary)> {
    let n = u.int_in_range(3..=16usize)?;
    let boundary = *u.choose(&[Boundary::Clip, Boundary::Whole])?;
    let mut star = RawMesh {
        points: vec![[0.0; 3]],
        faces: Vec::new(),
    };
    for k in 0..n {
        let radius = 0.5 + f64::from(u.int_in_range(0..=100u8)?) / 100.0;
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
        star.points.push([radius * cos, radius * sin, 0.0]);
        star.faces.push(vec![0, 1 + k, 1 + (k + 1) % n]);
    }
    Ok((star, boundary))
}

fn surface(raw: &RawMesh) -> Result<TriangleSurface, TopologyError> {
    let triangles: Vec<[u32; 3]> = raw
        .faces
        .iter()
        .map(|f| [0, 1, 2].map(|k| f[k] as u32))
        .collect();
    let positions = raw.points.iter().map(|&[x, y, z]| Vec3::new(x, y, z));
    TriangleSurface::new(positions.collect(), &triangles)
}

/// Every panel lies on a sheet, once, inside its border and clear of the others.
#[test]
fn nesting() {
    let figures = campaign(|u| {
        let mesh = random_mesh(u).ok().as_ref().and_then(hex_mesh);
        let Some(mesh) = mesh.and_then(|m| validate(m, None, &ValidateOptions::default()).ok())
        else {
            return Ok(Tried::default());
        };
        let edge = mesh.mean_edge();
        let pick = |u: &mut Unstructured, from: &[f64]| u.choose(from).copied().unwrap_or(1.0);
        let options = FabOptions {
            thickness: pick(u, &[0.01, 0.1, 0.3, 0.0, -1.0, f64::NAN]) * edge,
            gap: pick(u, &[0.0, 0.001, 0.1, 2.0]) * edge,
            unit_mm: pick(u, &[300.0, 100.0, 1000.0, 1e9, 1e-9]) / edge,
            spacing_mm: pick(u, &[5.0, 0.0, 200.0, 1e9]),
            nest_effort: 0,
            ..FabOptions::default()
        };
        let ids = PanelIds::new(&mesh);
        let Ok(made) = fabricate(mesh, ids, options, &Silent) else {
            return Ok(Tried::default());
        };
        let mut placed: Vec<usize> = made.sheets.iter().flatten().map(|p| p.plate).collect();
        placed.sort_unstable();
        if placed != (0..made.plates.len()).collect::<Vec<_>>() {
            return Err(format!("panels on sheets: {placed:?}"));
        }
        check_sheets(&made).map(|()| Tried {
            taken: true,
            ratio: 0.0,
        })
    });
    println!("nesting: {figures}");
    assert!(figures.taken > 0);
}

fn check_sheets(made: &phex_fab::Fabrication) -> Result<(), String> {
    let [length, width] = made.options.sheet_mm;
    let room = made.options.spacing_mm * (1.0 - NEAR) - NEAR;
    for sheet in &made.sheets {
        for placement in sheet {
            let plate = &made.plates[placement.plate];
            let corners = [placement.apply(&plate.top), placement.apply(&plate.bottom)].concat();
            let inside = |p: &_| in_sheet(p, [length, width], room);
            if !corners.iter().all(inside) {
                return Err(format!(
                    "panel {} reaches beyond its sheet",
                    placement.plate
                ));
            }
        }
    }
    Ok(())
}

fn in_sheet(p: &phex_mesh::Vec2, [length, width]: [f64; 2], room: f64) -> bool {
    (room..=length - room).contains(&p.x) && (room..=width - room).contains(&p.y)
}
