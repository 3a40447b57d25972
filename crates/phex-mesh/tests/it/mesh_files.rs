//! Mesh files: what is written is read back bit by bit, bad files are refused by name, and no bytes
//! cause a panic.

use phex_mesh::io::{
    Format, HexMeshReadError, ReadCause, WriteCause, parse_soup, read_soup, write_soup,
    write_soup_to,
};
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface, Vec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

fn bytes_of(soup: &PolygonSoup, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_soup_to(&mut bytes, soup, format).unwrap();
    bytes
}

/// Polygons of three to `most` corners over points of all magnitudes.
fn polygons(seed: u64, most: usize) -> PolygonSoup {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = || rng.random_range(-1.0..1.0) * 10f64.powi(rng.random_range(-300..300));
    let mut positions: Vec<Vec3> = (0..300)
        .map(|_| Vec3::new(number(), number(), number()))
        .collect();
    positions[7] = Vec3::new(-0.0, f64::MIN_POSITIVE / 3.0, f64::MAX);
    positions[8] = Vec3::new(0.1 + 0.2, 1.0 / 3.0, -1e22);
    let mut face = || {
        let n = rng.random_range(3..=most);
        (0..n).map(|_| rng.random_range(0..300)).collect()
    };
    let faces = (0..50).map(|_| face()).collect();
    PolygonSoup { positions, faces }
}

fn bits(soup: &PolygonSoup) -> Vec<u64> {
    soup.positions
        .iter()
        .flatten()
        .map(|x| x.to_bits())
        .collect()
}

/// Two hexagons, one of them concave, and a quad; plane.
fn hexagons() -> PolygonSoup {
    let points = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.5, 0.8],
        [1.0, 1.6],
        [0.0, 1.6],
        [0.3, 0.8],
        [2.5, 0.8],
        [3.0, 1.6],
        [2.0, 2.4],
        [0.5, 2.6],
    ];
    PolygonSoup {
        positions: points.map(|[x, y]| Vec3::new(x, y, 0.25)).to_vec(),
        faces: vec![
            vec![0, 1, 2, 3, 4, 5],
            vec![2, 6, 7, 8, 3],
            vec![3, 8, 9, 4],
        ],
    }
}

#[test]
fn what_is_only_written_says_so_when_it_is_read() {
    for format in Format::WRITTEN_ONLY {
        let bytes = bytes_of(&hexagons(), format);
        let cause = parse_soup(&bytes, format).unwrap_err().cause;
        assert!(matches!(cause, ReadCause::WrittenOnly { .. }), "{cause}");
        assert_eq!(bytes, bytes_of(&hexagons(), format), "{format:?}");
    }
}

#[test]
fn polygons_come_back_bit_by_bit() {
    for (seed, most) in [(1, 8), (2, 400)] {
        let soup = polygons(seed, most);
        for format in [Format::Obj, Format::Ply, Format::Off] {
            let read = parse_soup(&bytes_of(&soup, format), format).unwrap();
            assert_eq!(read.faces, soup.faces, "{format:?}");
            assert_eq!(bits(&read), bits(&soup), "{format:?}");
        }
    }
}

#[test]
fn stl_holds_the_triangles_of_concave_polygons() {
    let read = parse_soup(&bytes_of(&hexagons(), Format::Stl), Format::Stl).unwrap();
    assert_eq!((read.positions.len(), read.faces.len()), (10, 4 + 3 + 2));
    let area = |soup: &PolygonSoup| {
        let parts = TriangleSurface::from_soup(soup).unwrap();
        assert_eq!((parts.components.len(), parts.notes.turned_faces), (1, 0));
        parts.components[0].surface.area()
    };
    assert!((area(&read) - area(&hexagons())).abs() < 1e-6);
}

#[test]
fn files_by_extension_in_new_folders() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.obj", "b/c.PLY", "b/d/e.Off"] {
        let path = folder.path().join(name);
        write_soup(&path, &hexagons()).unwrap();
        assert_eq!(read_soup(&path).unwrap(), hexagons());
        let mesh = HexMesh::read(&path).unwrap();
        mesh.write(&path).unwrap();
        assert_eq!(HexMesh::read(&path).unwrap(), mesh);
    }
    write_soup(&folder.path().join("f.STL"), &hexagons()).unwrap();
    let extra = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(extra, 3, "a.obj, b, f.STL and nothing else");
}

#[test]
fn unknown_extensions_name_the_known_ones() {
    for name in ["mesh.xyz", "mesh", "mesh.obj.gz", ".obj"] {
        let read = read_soup(Path::new(name)).unwrap_err();
        assert!(matches!(read.cause, ReadCause::UnknownExtension(_)));
        let write = write_soup(Path::new(name), &hexagons()).unwrap_err();
        assert!(matches!(write.cause, WriteCause::UnknownExtension(_)));
        for message in [read.to_string(), write.to_string()] {
            assert!(
                message.starts_with(&format!("{name}: "))
                    && message.contains(".obj, .ply, .stl and .off"),
                "{message}"
            );
        }
        assert!(!Path::new(name).exists());
    }
}

#[test]
fn paths_that_can_not_be_read_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.obj");
    let error = read_soup(&missing).unwrap_err();
    assert!(
        matches!(error.cause, ReadCause::Io(_)) && error.to_string().contains("missing.obj"),
        "{error}"
    );
    let is_folder = folder.path().join("folder.ply");
    std::fs::create_dir(&is_folder).unwrap();
    assert!(matches!(
        read_soup(&is_folder).unwrap_err().cause,
        ReadCause::Io(_)
    ));
    let error = write_soup(&is_folder, &hexagons()).unwrap_err();
    assert!(
        matches!(error.cause, WriteCause::Io(_)) && error.to_string().contains("folder.ply"),
        "{error}"
    );
    let below_file = folder.path().join("file");
    std::fs::write(&below_file, "x").unwrap();
    assert!(write_soup(&below_file.join("mesh.off"), &hexagons()).is_err());
}

#[test]
fn a_mesh_that_can_not_be_written_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut infinite = hexagons();
    infinite.positions[5].z = f64::INFINITY;
    let mut beyond = hexagons();
    beyond.faces[1][2] = 10;
    let mut thin = hexagons();
    thin.faces[2].truncate(2);
    let mut crossing = hexagons();
    crossing.faces[0].swap(1, 3);
    for format in Format::READ {
        let path = folder
            .path()
            .join("mesh")
            .with_extension(format.extension());
        std::fs::write(&path, "old").unwrap();
        let cause = |soup| write_soup(&path, soup).unwrap_err().cause;
        assert!(matches!(
            cause(&infinite),
            WriteCause::NonFinite { vertex: 5 }
        ));
        assert!(matches!(
            cause(&beyond),
            WriteCause::IndexOutOfRange {
                face: 1,
                vertex: 10,
                vertices: 10
            }
        ));
        assert!(matches!(
            cause(&thin),
            WriteCause::TooFewCorners {
                face: 2,
                corners: 2
            }
        ));
        if format == Format::Stl {
            assert!(matches!(
                cause(&crossing),
                WriteCause::NotSimple { face: 0 }
            ));
        }
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
    }
}

#[test]
fn empty_files_and_text_that_is_no_mesh() {
    for format in Format::READ {
        for empty in ["", " \r\n\t\n"] {
            let cause = parse_soup(empty.as_bytes(), format).unwrap_err().cause;
            assert!(matches!(cause, ReadCause::Empty), "{format:?}: {cause}");
        }
        let letter = "Dear reader,\nthis file holds a letter, it does not hold a mesh; it is long enough for a header.\n";
        let cause = parse_soup(letter.as_bytes(), format).unwrap_err().cause;
        let expected = matches!(
            cause,
            ReadCause::WrongStart { .. } | ReadCause::NoVertices | ReadCause::Truncated { .. }
        );
        assert!(expected, "{format:?}: {cause}");
    }
}

#[test]
fn files_without_faces_are_refused() {
    let points = PolygonSoup {
        faces: Vec::new(),
        ..hexagons()
    };
    for format in [Format::Obj, Format::Ply, Format::Off] {
        let cause = parse_soup(&bytes_of(&points, format), format)
            .unwrap_err()
            .cause;
        assert!(matches!(cause, ReadCause::NoFaces), "{format:?}: {cause}");
    }
    let cause = parse_soup(&bytes_of(&points, Format::Stl), Format::Stl)
        .unwrap_err()
        .cause;
    assert!(matches!(cause, ReadCause::NoVertices), "{cause}");
}

#[test]
fn errors_name_file_place_and_cause() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("roof.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n").unwrap();
    let message = read_soup(&path).unwrap_err().to_string();
    let expected = "line 4: a face names vertex 4, but there are 3 vertices (numbered from 1)";
    assert_eq!(message, format!("{}: {expected}", path.display()));
    std::fs::write(
        &path,
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n",
    )
    .unwrap();
    let error = HexMesh::read(&path).unwrap_err();
    assert!(matches!(error, HexMeshReadError::Mesh { .. }));
    assert!(
        error
            .to_string()
            .starts_with(&format!("{}: faces 0 and 1 run", path.display())),
        "{error}"
    );
}

/// Announced sizes must not be allocated: were they, each of these would ask for tens of gigabytes.
#[test]
fn four_billion_announced_faces() {
    let mut stl = bytes_of(&hexagons(), Format::Stl);
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    stl.truncate(84 + 50 + 17);
    let ply = bytes_of(&hexagons(), Format::Ply);
    let cut = |bytes: &[u8]| {
        let head = String::from_utf8_lossy(bytes).find("end_header").unwrap();
        let text = String::from_utf8_lossy(&bytes[..head]).replace("face 3", "face 4294967295");
        [text.as_bytes(), &bytes[head..bytes.len() - 3]].concat()
    };
    for (format, bytes) in [(Format::Stl, stl), (Format::Ply, cut(&ply))] {
        let cause = parse_soup(&bytes, format).unwrap_err().cause;
        assert!(
            matches!(
                cause,
                ReadCause::Truncated {
                    announced: 4_294_967_295,
                    ..
                }
            ),
            "{format:?}: {cause}"
        );
    }
}

fn big_endian_triangle() -> Vec<u8> {
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uchar short vertex_index\nend_header\n";
    let mut bytes = head.as_bytes().to_vec();
    let coordinates = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    bytes.extend(coordinates.iter().flat_map(|x| x.to_be_bytes()));
    bytes.push(3);
    bytes.extend([0u16, 1, 2].iter().flat_map(|v| v.to_be_bytes()));
    bytes
}

fn mutate(rng: &mut ChaCha8Rng, valid: &[u8]) -> Vec<u8> {
    const PIECES: [&[u8]; 12] = [
        b"-",
        b"99999999999",
        b"nan",
        b"\n",
        b" ",
        b"0",
        b"\xff\xff\xff\xff",
        b"\0",
        b"\\",
        b"1e999",
        b"#",
        b"facet",
    ];
    let mut bytes = valid.to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..=bytes.len());
        match rng.random_range(0..5) {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] = rng.random(),
            2 => drop(bytes.splice(
                at..at,
                PIECES[rng.random_range(0..PIECES.len())].iter().copied(),
            )),
            3 => drop(bytes.drain(at..(at + rng.random_range(0..20)).min(bytes.len()))),
            _ => {
                let end = (at + rng.random_range(0..40)).min(bytes.len());
                bytes.extend_from_within(at..end);
            }
        }
    }
    bytes
}

#[test]
fn no_bytes_cause_a_panic() {
    let text_ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let text_stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
        endfacet\nendsolid a\n";
    let mut seeds: Vec<(Format, Vec<u8>)> =
        Format::READ.map(|f| (f, bytes_of(&hexagons(), f))).to_vec();
    seeds.push((Format::Ply, text_ply.into()));
    seeds.push((Format::Ply, big_endian_triangle()));
    seeds.push((Format::Stl, text_stl.into()));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut read, mut refused) = (0, 0);
    for (format, valid) in &seeds {
        assert!(parse_soup(valid, *format).is_ok());
        for _ in 0..1000 {
            match parse_soup(&mutate(&mut rng, valid), *format) {
                Ok(soup) => {
                    read += 1;
                    check(&soup);
                }
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty());
                }
            }
        }
    }
    assert!(
        read > 300 && refused > 3000,
        "{read} read, {refused} refused"
    );
}

/// What every reader promises, and that building on it does not panic either.
fn check(soup: &PolygonSoup) {
    assert!(!soup.faces.is_empty() && soup.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(soup.faces.iter().all(|f| f.len() >= 3));
    assert!(
        soup.faces
            .iter()
            .flatten()
            .all(|&v| (v as usize) < soup.positions.len())
    );
    let _ = TriangleSurface::from_soup(soup).map(|parts| parts.components.len());
    let _ = HexMesh::from_soup(soup);
}

/// A line that goes on over many lines costs its length, not its square: that would be minutes
/// here.
#[test]
fn a_long_continued_line_is_read_at_once() {
    const PARTS: usize = 400_000;
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let text = format!("{points}f \\\n{}1\n", "1 2 3 \\\n".repeat(PARTS));
    let start = std::time::Instant::now();
    let soup = parse_soup(text.as_bytes(), Format::Obj).unwrap();
    assert_eq!(soup.faces[0].len(), 3 * PARTS + 1);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

/// What overflows when it is computed with is no mesh, nor is a mesh without extent.
#[test]
fn a_mesh_keeps_to_the_limits_of_surfaces() {
    let triangle = |size: f64| PolygonSoup {
        positions: vec![Vec3::zeros(), Vec3::x() * size, Vec3::y() * size],
        faces: vec![vec![0, 1, 2]],
    };
    for size in [1e-50, 1.0, 1e50] {
        assert!(HexMesh::from_soup(&triangle(size)).is_ok(), "{size:e}");
        assert!(
            TriangleSurface::from_soup(&triangle(size)).is_ok(),
            "{size:e}"
        );
    }
    for size in [0.0, 1e-51, 1e51, 1e155] {
        let error = HexMesh::from_soup(&triangle(size)).unwrap_err();
        assert!(error.to_string().contains("extent"), "{size:e}: {error}");
    }
}
