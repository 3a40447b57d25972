//! Panel sizes: a number for each vertex of the input.

use crate::error::JobError;
use crate::hexagon::hexagon_area;
use crate::input::read_numbers;
use crate::wishes::range;
use phex::report::InputFile;
use phex_mesh::{SurfaceComponent, TriangleSurface};
use std::path::Path;

/// Reads a positive number on each line, in the order of the input's vertices.
///
/// # Errors
/// If the file can't be read, or a line is no positive number.
pub fn read_sizes(path: &Path) -> Result<Vec<f64>, JobError> {
    let size = |line: crate::input::NumberLine| match line.numbers[..] {
        [size] if size > 0.0 => Ok(size),
        _ => Err(line.wrong("one positive number")),
    };
    read_numbers(path)?.into_iter().map(size).collect()
}

/// Length of the panels' edges at each vertex of each component, model units.
pub struct SizeField {
    components: Vec<Vec<f64>>,
}

impl SizeField {
    /// The sizes at the vertices of each component of an input with `vertices` vertices; `source`
    /// and `input` name both in a refusal.
    ///
    /// # Errors
    /// If there are not as many sizes as vertices, or one is no positive number.
    pub fn new(
        sizes: &[f64],
        source: &str,
        input: &InputFile,
        components: &[&SurfaceComponent],
    ) -> Result<Self, JobError> {
        let (found, expected) = (sizes.len(), input.vertices);
        if found != expected {
            return Err(JobError::input(format!(
                "{source}: {found} sizes for the {expected} vertices of {}",
                input.path
            )));
        }
        if let Some(k) = sizes.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
            let message = format!("{source}: the size of vertex {k} is no positive number");
            return Err(JobError::Input(message));
        }
        let of = |component: &&SurfaceComponent| {
            let vertices = component.original_vertices.iter();
            vertices.map(|&v| sizes[v as usize]).collect()
        };
        Ok(Self {
            components: components.iter().map(of).collect(),
        })
    }

    /// The sizes of a component.
    pub fn of(&self, component: usize) -> &[f64] {
        &self.components[component]
    }

    /// The smallest and the largest size.
    pub fn range(&self) -> [f64; 2] {
        range(self.components.iter().flatten().copied())
    }

    /// The number of panels that the sizes mean as edge lengths.
    pub fn panels(&self, components: &[&SurfaceComponent]) -> f64 {
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
