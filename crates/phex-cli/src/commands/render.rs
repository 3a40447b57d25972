//! `phex render`: draws a mesh.

use super::tell;
use crate::exit::{Exit, Failure};
use crate::output::{check_writable, given, write_picture, write_text};
use crate::picture_arguments::RenderCommand;
use phex::quality::References;
use phex_job::TypedLimits;
use phex_job::{Content, MeshFile, read_numbers, read_polylines};
use phex_mesh::HexMesh;
use phex_picture::maps::{Class, ColourMap, ColourScale, Coloured, Map, Range, Rgb, Subject};
use phex_picture::{draw_svg, draw_with_curves};
use std::path::Path;

/// The formats of pictures.
enum PictureFormat {
    Png,
    Svg,
}

/// Runs the command.
///
/// # Errors
/// If an input can't be used, the map needs a surface and there is none, or the picture can't be
/// written.
pub fn run(command: &RenderCommand) -> Result<Exit, Failure> {
    let format = format(command)?;
    let inputs = given([
        Some(&command.input),
        command.surface.as_ref(),
        command.mark.as_ref(),
        command.curves.as_ref(),
    ]);
    command.limits.check(command.surface.is_some())?;
    check_writable(&[(&command.output, Content::Other)], &inputs)?;
    let (mesh, _) = MeshFile::read(&command.input)?.polygon_mesh()?;
    let file = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let facets = file.map(|file| file.surface()).transpose()?;
    let references = References::of_facets(facets.as_ref());
    let assessment = TypedLimits::from(&command.limits).judge(&mesh, references);
    let subject = Subject {
        mesh: &mesh,
        assessment: &assessment,
        surface: facets.as_ref(),
    };
    let map = match &command.mark {
        Some(path) => marked(path, &mesh)?,
        None => coloured(command, &subject)?,
    };
    let options = command.options();
    match format {
        PictureFormat::Png => {
            let curves = command
                .curves
                .as_deref()
                .map_or(Ok(Vec::new()), read_polylines)?;
            let picture = draw_with_curves(&mesh, &map, &curves, &options);
            write_picture(&command.output, &picture)?;
        }
        PictureFormat::Svg if command.curves.is_some() => {
            return Err(Failure::input("curves are drawn in PNG pictures only"));
        }
        PictureFormat::Svg => write_text(&command.output, &draw_svg(&mesh, &map, &options))?,
    }
    let written = format!("written      {}\n", command.output.display());
    tell(command.talk.quiet, &written)?;
    Ok(Exit::Success)
}

/// The colours of a map.
fn coloured(command: &RenderCommand, subject: &Subject<'_>) -> Result<ColourMap, Failure> {
    let (map, name) = (command.color, command.color.name());
    let coloured = ColourMap::over(map, subject, command.range)
        .ok_or_else(|| Failure::input(format!("--color {name} needs a surface: give --surface")))?;
    let Range::Given([low, _]) = command.range else {
        return Ok(coloured);
    };
    match &coloured.scale {
        ColourScale::Classes(_) => Err(Failure::input(format!(
            "--range: the colours of --color {name} are classes, which have no range"
        ))),
        ColourScale::Continuous(scale) if scale.logarithmic && low <= 0.0 => Err(Failure::input(
            format!("--range: --color {name} is logarithmic, its range begins above 0"),
        )),
        ColourScale::Continuous(_) => Ok(coloured),
    }
}

/// Colours of marked panels, the first for those that are not.
const MARKS: [Class; 7] = [
    class("plain", [0xF0, 0xE9, 0xE0]),
    class("marked 1", [0x5C, 0x9C, 0xE6]),
    class("marked 2", [0xF2, 0xA6, 0x59]),
    class("marked 3", [0x6F, 0xB9, 0x7A]),
    class("marked 4", [0xD9, 0x59, 0x4D]),
    class("marked 5", [0x8C, 0x66, 0xBF]),
    class("marked 6", [0xE8, 0xD1, 0x4E]),
];

const fn class(label: &'static str, colour: Rgb) -> Class {
    Class { label, colour }
}

/// Colours by a file of marks.
fn marked(path: &Path, mesh: &HexMesh) -> Result<ColourMap, Failure> {
    let mut values = vec![0.0; mesh.topology().n_faces()];
    for line in read_numbers(path)? {
        let wrong = || line.wrong("`panel colour`, a panel of the mesh and a colour from 1 to 6,");
        let [panel, colour] = line.numbers[..] else {
            return Err(wrong().into());
        };
        let whole = [panel, colour]
            .iter()
            .all(|x| x.fract() == 0.0 && *x >= 0.0);
        let fits = whole && (1.0..MARKS.len() as f64).contains(&colour);
        let value = values.get_mut(panel as usize).filter(|_| fits);
        *value.ok_or_else(wrong)? = colour;
    }
    Ok(ColourMap {
        map: Map::Valence,
        element: Coloured::Face,
        values,
        scale: ColourScale::Classes(MARKS.to_vec()),
    })
}

fn format(command: &RenderCommand) -> Result<PictureFormat, Failure> {
    let extension = command.output.extension().and_then(|e| e.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(PictureFormat::Png),
        Some("svg") => Ok(PictureFormat::Svg),
        _ => Err(Failure::input(format!(
            "{}: pictures are written as .png or .svg",
            command.output.display()
        ))),
    }
}
