//! Panel sizes from a file: a number for each vertex of the input.

use crate::exit::Failure;
use crate::input::{MeshFile, read_numbers};
use crate::panel_size::hexagon_area;
use phex_mesh::{SurfaceComponent, TriangleSurface};
use std::path::Path;

/// Length of the panels' edges at each vertex of each component, model units.
pub struct SizeField {
    components: Vec<Vec<f64>>,
}

impl SizeField {
    /// Reads a file with a positive number on each line, in the order of the input's vertices.
    ///
    /// # Errors
    /// If it can't be read, a line is no positive number, or there are not as many as vertices.
    pub fn read(
        path: &Path,
        input: &MeshFile,
        components: &[SurfaceComponent],
    ) -> Result<Self, Failure> {
        let mut values = Vec::new();
        for line in read_numbers(path)? {
            match line.numbers[..] {
                [size] if size > 0.0 => values.push(size),
                _ => return Err(line.wrong("one positive number")),
            }
        }
        let (found, expected) = (values.len(), input.soup.positions.len());
        if found != expected {
            return Err(Failure::input(format!(
                "{}: {found} sizes for the {expected} vertices of {}",
                path.display(),
                input.path.display()
            )));
        }
        let of = |component: &SurfaceComponent| {
            let vertices = component.original_vertices.iter();
            vertices.map(|&v| values[v as usize]).collect()
        };
        Ok(Self {
            components: components.iter().map(of).collect(),
        })
    }

    /// The sizes of a component.
    pub fn of(&self, component: usize) -> &[f64] {
        &self.components[component]
    }

    /// The number of panels that the sizes mean as edge lengths.
    pub fn panels(&self, components: &[SurfaceComponent]) -> f64 {
        let pairs = components.iter().zip(&self.components);
        pairs.map(|(c, sizes)| panels_on(&c.surface, sizes)).sum()
    }
}

/// Integral of one over the area of a panel, with areas of panels averaged over each triangle.
fn panels_on(surface: &TriangleSurface, sizes: &[f64]) -> f64 {
    let topology = surface.topology();
    let on_triangle = |f| {
        let corners = topology.face_vertices(f);
        let [a, b, c] = [0, 1, 2].map(|k| surface.positions()[corners[k]]);
        let areas = corners.iter().map(|v| hexagon_area(sizes[v.index()]));
        let mean = areas.sum::<f64>() / 3.0;
        0.5 * (b - a).cross(&(c - a)).norm() / mean
    };
    topology.faces().map(on_triangle).sum()
}
