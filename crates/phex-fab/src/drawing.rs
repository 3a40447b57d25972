//! Sheets as drawings: DXF for machines, SVG for people and laser cutters. Millimetres; y up in
//! DXF.
//!
//! | layer | what is on it |
//! |---|---|
//! | `CUT` | outlines of the panels' upper faces (the side of the normals); the blade is tilted by the mitre angle of each side, and where that is negative the lower face reaches beyond |
//! | `ENGRAVE` | the panel's name, the neighbour's name at each side |
//! | `LABEL` | mitre angles in degrees beside the neighbours' names; not for the machine |
//! | `SHEET` | the sheet's border and title |

use crate::fabricate::Fabrication;
use crate::ids::written;
use crate::labels::PanelText;
use crate::layer::{Layer, Stroke};
use crate::nest::Placement;
use phex_mesh::io::DxfDrawing;
use phex_mesh::{Vec2, bounds};
use phex_picture::strokes::strokes;
use std::fmt::Write as _;

/// Height of a sheet's title, over the sheet's width.
const TITLE: f64 = 0.02;

/// What a sheet says of its lines.
const FACE: &str = "CUT: UPPER FACES, NEGATIVE MITRES WIDEN BELOW";

/// Path of a sheet's drawing, without extension.
pub fn sheet_name(fabrication: &Fabrication, number: usize) -> String {
    let width = fabrication.sheets.len().to_string().len().max(2);
    format!("sheets/sheet-{:0width$}", number + 1)
}

/// All lines of one sheet, from its lower left corner. `texts` are those of all panels.
pub fn sheet(fabrication: &Fabrication, number: usize, texts: &[PanelText]) -> Vec<Stroke> {
    let [width, height] = fabrication.options.sheet_mm;
    let border =
        [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|[x, y]| Vec2::new(x, y));
    let line = |layer, points: Vec<Vec2>, closed| Stroke {
        layer,
        points,
        closed,
    };
    let mut lines = vec![line(Layer::Sheet, border.to_vec(), true)];
    let size = TITLE * width.min(height);
    for (row, text) in [title(fabrication, number), FACE.to_owned()]
        .iter()
        .enumerate()
    {
        let below = Vec2::new(0.0, -2.0 * (row + 1) as f64 * size);
        let moved = |s: Vec<Vec2>| line(Layer::Sheet, s.iter().map(|p| p + below).collect(), false);
        lines.extend(strokes(&written(text), size).into_iter().map(moved));
    }
    for placement in &fabrication.sheets[number] {
        let plate = &fabrication.plates[placement.plate];
        lines.push(line(Layer::Cut, placement.apply(&plate.top), true));
        lines.extend(
            texts[placement.plate]
                .strokes
                .iter()
                .map(|s| placed(s, placement)),
        );
    }
    lines
}

fn placed(stroke: &Stroke, placement: &Placement) -> Stroke {
    Stroke {
        points: placement.apply(&stroke.points),
        ..stroke.clone()
    }
}

fn title(fabrication: &Fabrication, number: usize) -> String {
    let [width, height] = fabrication.options.sheet_mm.map(short);
    let panels = fabrication.sheets[number].len();
    let (sheets, used) = (
        fabrication.sheets.len(),
        100.0 * fabrication.sheet_use(number),
    );
    format!(
        "SHEET {}/{sheets}  {width} X {height} MM  {} MM THICK  {panels} PANELS  USE {used:.1}%",
        number + 1,
        short(fabrication.options.thickness * fabrication.options.unit_mm)
    )
}

/// Without the digits that products of decimal numbers end in.
fn short(millimetres: f64) -> f64 {
    (millimetres * 1e3).round() / 1e3
}

/// A drawing as DXF R12.
pub fn dxf(strokes: &[Stroke]) -> String {
    let mut drawing = DxfDrawing::new(&Layer::ALL.map(|l| (l.name(), l.colour().0)));
    for stroke in strokes {
        drawing.polyline(stroke.layer.name(), &stroke.points, stroke.closed);
    }
    drawing.to_text()
}

/// A drawing as SVG in millimetres, a group for each layer.
pub fn svg(strokes: &[Stroke]) -> String {
    let all: Vec<Vec2> = strokes
        .iter()
        .flat_map(|s| s.points.iter().copied())
        .collect();
    let [low, high] = bounds(&all);
    let rim = Vec2::repeat(0.01 * (high - low).max());
    let (low, high) = (low - rim, high + rim);
    let size = high - low;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3}mm\" height=\"{1:.3}mm\" viewBox=\"{2:.3} {3:.3} {0:.3} {1:.3}\">\n",
        size.x, size.y, low.x, -high.y
    );
    let thin = 4e-4 * size.max();
    for layer in Layer::ALL {
        let (name, colour) = (layer.name(), layer.colour().1);
        let _ = writeln!(
            text,
            "<g id=\"{name}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{thin:.3}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">"
        );
        for stroke in strokes.iter().filter(|s| s.layer == layer) {
            let point = |p: &Vec2| format!("{:.6} {:.6}", p.x, -p.y);
            let points: Vec<String> = stroke.points.iter().map(point).collect();
            let end = if stroke.closed { " Z" } else { "" };
            let _ = writeln!(text, "<path d=\"M {}{end}\"/>", points.join(" L "));
        }
        text += "</g>\n";
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    #[test]
    fn titles_have_short_numbers() {
        assert_eq!(super::short(0.0007 * 3.0 * 1e3).to_string(), "2.1");
        assert_eq!(super::short(1219.2).to_string(), "1219.2");
    }
}
