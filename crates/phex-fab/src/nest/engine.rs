//! One sheet in jagua-rs, which answers whether a panel in a place collides with others or with the
//! border.
//!
//! The library computes in single precision. Shapes are made larger by [`Margins::rounding`], far
//! more than it loses.

use jagua_rs::collision_detection::CDEConfig;
use jagua_rs::collision_detection::hazards::filter::NoFilter;
use jagua_rs::entities::{Container, Item, Layout};
use jagua_rs::geometry::fail_fast::SPSurrogateConfig;
use jagua_rs::geometry::geo_enums::RotationRange;
use jagua_rs::geometry::geo_traits::TransformableFrom;
use jagua_rs::geometry::primitives::{Point, SPolygon};
use jagua_rs::geometry::shape_modification::{ShapeModifyConfig, ShapeModifyMode};
use jagua_rs::geometry::{AllowedOrientations, DTransformation, OriginalShape};
use phex_mesh::Vec2;
use std::sync::Arc;

/// Distances that are kept, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Half of the distance of panels from one another.
    pub half_spacing: f64,
    /// What single precision may lose.
    pub rounding: f64,
}

impl Margins {
    /// For a sheet and a spacing: a millionth of the sheet's length is 8 units in the last place of
    /// its coordinates.
    pub fn new(sheet: [f64; 2], spacing: f64) -> Self {
        Self {
            half_spacing: 0.5 * spacing,
            rounding: 1e-6 * sheet[0].max(sheet[1]),
        }
    }
}

/// A sheet with the panels on it.
#[derive(Clone)]
pub struct Engine {
    layout: Layout,
}

/// What the library says of a shape that it refuses.
pub type Refusal = String;

/// A shape as the library wants it.
///
/// # Errors
/// If it takes it for no simple polygon.
pub fn item(number: usize, polygon: &[Vec2]) -> Result<Arc<Item>, Refusal> {
    let any = AllowedOrientations::new(RotationRange::Continuous, Vec::new())
        .map_err(|e| e.to_string())?;
    let shape = original(polygon)?;
    let item = Item::new(
        number,
        number as u64,
        shape,
        any,
        None,
        SPSurrogateConfig::none(),
    );
    item.map(Arc::new).map_err(|e| e.to_string())
}

fn original(polygon: &[Vec2]) -> Result<OriginalShape, Refusal> {
    let points = polygon
        .iter()
        .map(|p| Point(p.x as f32, p.y as f32))
        .collect();
    Ok(OriginalShape {
        shape: SPolygon::new(points).map_err(|e| e.to_string())?,
        pre_transform: DTransformation::empty(),
        modify_mode: ShapeModifyMode::Inflate,
        modify_config: ShapeModifyConfig::default(),
    })
}

impl Engine {
    /// An empty sheet, its corners given counter-clockwise.
    ///
    /// # Errors
    /// If the library refuses it.
    pub fn new(border: &[Vec2; 4]) -> Result<Self, Refusal> {
        let config = CDEConfig {
            quadtree_depth: 5,
            cd_threshold: 16,
            item_surrogate_config: SPSurrogateConfig::none(),
        };
        let container =
            Container::new(original(border)?, Vec::new(), config).map_err(|e| e.to_string())?;
        Ok(Self {
            layout: Layout::new(container),
        })
    }

    /// Whether an item can be turned by an angle and then moved without colliding; `scratch` is a
    /// clone of its shape.
    pub fn is_free(
        &self,
        item: &Item,
        rotation: f64,
        translation: Vec2,
        scratch: &mut SPolygon,
    ) -> bool {
        scratch.transform_from(item.shape_cd(), &place(rotation, translation).compose());
        !self.layout.cde().detect_poly_collision(scratch, &NoFilter)
    }

    /// Puts an item there.
    pub fn put(&mut self, item: &Arc<Item>, rotation: f64, translation: Vec2) {
        self.layout.place_item(item, place(rotation, translation));
    }
}

fn place(rotation: f64, translation: Vec2) -> DTransformation {
    DTransformation::new(
        rotation as f32,
        (translation.x as f32, translation.y as f32),
    )
}
