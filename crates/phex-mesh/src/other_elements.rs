//! Elements of a file that are no faces, and that are counted and not read.

/// Numbers of elements that are no faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OtherElements {
    /// Free-form surfaces.
    pub surfaces: usize,
    /// Free-form curves; those that trim a surface are a part of it.
    pub curves: usize,
    /// Polylines.
    pub polylines: usize,
    /// Points that are elements.
    pub points: usize,
}

impl OtherElements {
    /// A sentence on them, if there are any.
    pub fn told(&self) -> Option<String> {
        let all = [
            (self.surfaces, "free-form surface"),
            (self.curves, "free-form curve"),
            (self.polylines, "polyline"),
            (self.points, "point element"),
        ];
        let were = match all.iter().map(|(count, _)| count).sum() {
            0 => return None,
            1 => "was",
            _ => "were",
        };
        let some = all.iter().filter(|(count, _)| *count > 0);
        let named = some.map(|(count, what)| match count {
            1 => format!("1 {what}"),
            _ => format!("{count} {what}s"),
        });
        let named: Vec<String> = named.collect();
        let named = named.join(", ");
        Some(format!(
            "{named} {were} left out: panels are made of faces alone"
        ))
    }
}
