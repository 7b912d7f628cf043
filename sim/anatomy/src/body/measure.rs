//! Measurements of a body, taken from its shape and not from its input dimensions.

use nalgebra::{Point3, Vector3};

use super::form::Place;
use super::part::{AnatomyPart, Level};
use super::{Body, LayerOnPath, Tissue};

/// Measurements of an interspace and of the vertebra above it, in mm.
#[derive(Clone, Copy, Debug)]
pub struct BodyMeasure {
    /// The vertebra, or the interspace below it.
    pub level: Level,
    /// Width of the body at its upper endplate.
    pub body_width_mm: f64,
    /// Depth of the canal in the midline.
    pub canal_depth_mm: f64,
    /// Distance between the tips of the transverse processes.
    pub transverse_span_mm: f64,
    /// Smallest distance in the midline between two spinous processes.
    pub interspinous_mm: f64,
    /// Distance from skin to flavum, between the processes; `None` if bone is in the way.
    pub skin_to_flavum_mm: Option<f64>,
}

/// A straight path in the midline of an interspace.
#[derive(Clone, Copy, Debug)]
pub struct MidlinePath {
    /// Entry point on the skin, in m.
    pub entry_m: Point3<f64>,
    /// Its direction.
    pub direction: Vector3<f64>,
    /// Distance from skin to flavum, in m; `None` if bone is met first.
    pub to_flavum_m: Option<f64>,
}

impl Body {
    /// The path between two spinous tips, perpendicular to the line between them, rotated towards
    /// the head by an angle in rad.
    #[must_use]
    pub fn midline_path(&self, level: Level, towards_head: f64) -> MidlinePath {
        let (above, below) = (&self.column[level as usize + 1], &self.column[level as usize + 2]);
        let (high, low) = (above.tip(), below.tip());
        let lean = libm::atan2(high.z - low.z, high.y - low.y);
        let (sin, cos) = libm::sincos(towards_head - lean);
        let direction = Vector3::new(0.0, sin, -cos);
        // An interspace is palpated between the lower edge of one tip and the upper edge of the
        // next.
        let edge = |bone: &super::ColumnBone, sign: f64| {
            let tip = bone.values.spinous_tip() + Place::new(0.0, sign * 0.5 * bone.values.spinous_height, 3.0);
            bone.pose.to_outer(tip)
        };
        let mut middle = (edge(above, -1.0) + edge(below, 1.0)) * 0.5;
        middle.z = self.skin_depth(&middle);
        let entry_m = Point3::from((middle - self.origin) * 1e-3);
        let layers = self.list_layers(&entry_m, &direction, 0.16);
        MidlinePath { entry_m, direction, to_flavum_m: depth_of_flavum(&layers) }
    }

    /// Whether a straight midline path through the palpated middle of an interspace, up to 30°
    /// towards the head, reaches the flavum.
    #[must_use]
    pub fn has_midline_path(&self, level: Level) -> bool {
        (0..=12).any(|step| self.midline_path(level, (2.5 * f64::from(step)).to_radians()).to_flavum_m.is_some())
    }

    /// Measures a vertebra and the interspace below it.
    #[must_use]
    pub fn measure(&self, level: Level) -> BodyMeasure {
        let bone = &self.column[level as usize + 1];
        let values = &bone.values;
        let bone_at = |own: Place| bone.distance(&bone.pose.to_outer(own)) < 0.0;
        // From outside inwards, so that gaps in between are ignored.
        let reach = |from: f64, height: [f64; 2]| {
            let hit = (0..1200)
                .map(|step| from - 0.1 * f64::from(step))
                .find(|x| bone_at(Place::new(*x, height[0], height[1])));
            hit.unwrap_or(f64::NAN)
        };
        let span = (0..60).flat_map(|up| (0..30).map(move |back| [f64::from(up) - 30.0, f64::from(back)]));
        let span = span.map(|[up, back]| reach(75.0, [up, 0.5 * values.depth + back])).fold(0.0, f64::max);
        let back = (0..400).map(|step| 0.5 * values.depth + 2.0 + 0.1 * f64::from(step));
        let lamina = back.clone().find(|z| bone_at(Place::new(0.0, -0.3 * values.height, *z))).unwrap_or(f64::NAN);
        BodyMeasure {
            level,
            body_width_mm: 2.0 * reach(40.0, [0.44 * values.height, -0.05 * values.depth]),
            canal_depth_mm: lamina - 0.5 * values.depth,
            transverse_span_mm: 2.0 * span,
            interspinous_mm: self.interspinous_gap(level),
            skin_to_flavum_mm: self.midline_path(level, 0.0).to_flavum_m.map(|depth| depth * 1e3),
        }
    }

    fn interspinous_gap(&self, level: Level) -> f64 {
        let (above, below) = (level as usize + 1, level as usize + 2);
        let bone = &self.column[above];
        let edge = |at: usize| {
            let bone = &self.column[at];
            let first = bone.values.canal_back() + 6.0;
            let places = (0..=24).flat_map(move |up| {
                (0..=30).map(move |back| Place::new(0.0, f64::from(up) - 20.0, first + f64::from(back) * 1.5))
            });
            places
                .map(|own| bone.pose.to_outer(own))
                .filter(move |p| self.bone_distance(at, p) < 0.0)
                .collect::<Vec<_>>()
        };
        // Distance of the upper process from each point of the lower one.
        edge(below).iter().map(|p| bone.distance(p)).fold(f64::INFINITY, f64::min)
    }
}

fn depth_of_flavum(layers: &[LayerOnPath]) -> Option<f64> {
    let flavum = |layer: &&LayerOnPath| matches!(layer.tissue, Tissue::Part(AnatomyPart::Flavum(_)));
    let first = layers.iter().find(|layer| layer.is_bone() || flavum(layer))?;
    (!first.is_bone()).then_some(first.from_m)
}
