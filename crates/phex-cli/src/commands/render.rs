//! `phex render`: draws a mesh.

use super::tell;
use crate::exit::{Exit, Failure};
use crate::input::read_polylines;
use crate::input::{MeshFile, whole};
use crate::output::{Content, check_writable, write_picture, write_text};
use crate::picture_arguments::RenderCommand;
use crate::verdict::TypedLimits;
use phex::report::References;
use phex::report::maps::{ColourMap, Subject};
use phex::report::picture::{draw_svg, draw_with_curves};

/// The formats of pictures.
enum Format {
    Png,
    Svg,
}

/// Runs the command.
///
/// # Errors
/// If an input can't be used, the map needs a surface and there is none, or the picture can't be written.
pub fn run(command: &RenderCommand) -> Result<Exit, Failure> {
    let format = format(command)?;
    let inputs = std::iter::once(&command.input)
        .chain(&command.surface)
        .chain(&command.curves);
    let inputs: Vec<_> = inputs.map(|p| p.as_path()).collect();
    command.limits.check(command.surface.is_some())?;
    check_writable(&[(&command.output, Content::Other)], &inputs)?;
    let (mesh, _) = MeshFile::read(&command.input)?.polygon_mesh()?;
    let file = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let facets = file
        .map(|file| whole(&file.surfaces()?.components))
        .transpose()?;
    let references = References {
        facets: facets.as_ref(),
        ..Default::default()
    };
    let assessment = TypedLimits::from(&command.limits).judge(&mesh, references);
    let subject = Subject {
        mesh: &mesh,
        assessment: &assessment,
        surface: facets.as_ref(),
    };
    let map = ColourMap::new(command.color, &subject).ok_or_else(|| {
        let name = command.color.name();
        Failure::input(format!("--color {name} needs a surface: give --surface"))
    })?;
    let options = command.options();
    match format {
        Format::Png => {
            let curves = command
                .curves
                .as_deref()
                .map_or(Ok(Vec::new()), read_polylines)?;
            let picture = draw_with_curves(&mesh, &map, &curves, &options);
            write_picture(&command.output, &picture)?;
        }
        Format::Svg if command.curves.is_some() => {
            return Err(Failure::input("curves are drawn in PNG pictures only"));
        }
        Format::Svg => write_text(&command.output, &draw_svg(&mesh, &map, &options))?,
    }
    let written = format!("written      {}\n", command.output.display());
    tell(command.talk.quiet, &written)?;
    Ok(Exit::Success)
}

fn format(command: &RenderCommand) -> Result<Format, Failure> {
    let extension = command.output.extension().and_then(|e| e.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(Format::Png),
        Some("svg") => Ok(Format::Svg),
        _ => Err(Failure::input(format!(
            "{}: pictures are written as .png or .svg",
            command.output.display()
        ))),
    }
}
