//! Shapes along the trunk: elliptic sections at several heights, with smooth interpolation.

use super::form::{Place, join_inside};

/// A section at a height: its middle and its semi-axes, in mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub(super) middle: Place,
    pub(super) half_x: f64,
    pub(super) half_z: f64,
}

/// Sections in ascending order.
#[derive(Clone, Debug)]
pub(super) struct Loft {
    sections: Vec<Section>,
    /// Rounding of both ends, in mm.
    rounding: f64,
}

impl Loft {
    /// A loft through sections in any order.
    pub(super) fn new(mut sections: Vec<Section>, rounding: f64) -> Self {
        sections.sort_by(|a, b| a.middle.y.total_cmp(&b.middle.y));
        Self { sections, rounding }
    }

    /// Heights of the lowest and the highest middle.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.sections[0].middle.y, self.sections[self.sections.len() - 1].middle.y]
    }

    /// The section at a height; beyond the ends, that of the end.
    pub(super) fn at(&self, y: f64) -> Section {
        let value = |of: fn(&Section) -> f64| interpolate(&self.sections, |section| section.middle.y, of, y);
        Section {
            middle: Place::new(value(|s| s.middle.x), y, value(|s| s.middle.z)),
            half_x: value(|s| s.half_x),
            half_z: value(|s| s.half_z),
        }
    }

    /// Signed distance from the sides only, in mm.
    pub(super) fn side(&self, p: &Place) -> f64 {
        let Section { middle, half_x, half_z } = self.at(p.y);
        let (x, z) = ((p.x - middle.x) / half_x, (p.z - middle.z) / half_z);
        ((x * x + z * z).sqrt() - 1.0) * half_x.min(half_z)
    }

    /// Signed distance, in mm.
    pub(super) fn distance(&self, p: &Place) -> f64 {
        let [low, high] = self.ends();
        join_inside(self.side(p), (low - p.y).max(p.y - high), self.rounding)
    }
}

/// Catmull–Rom spline through values at positions; constant beyond the ends.
pub(super) fn interpolate<T>(knots: &[T], place: impl Fn(&T) -> f64, value: impl Fn(&T) -> f64, at: f64) -> f64 {
    let last = knots.len() - 1;
    let next = knots.partition_point(|knot| place(knot) <= at);
    if next == 0 || next > last {
        return value(&knots[next.min(last)]);
    }
    let (a, b) = (next - 1, next);
    let slope = |knot: usize| {
        let (before, after) = (knot.saturating_sub(1), (knot + 1).min(last));
        (value(&knots[after]) - value(&knots[before])) / (place(&knots[after]) - place(&knots[before]))
    };
    let span = place(&knots[b]) - place(&knots[a]);
    let t = (at - place(&knots[a])) / span;
    let (t2, t3) = (t * t, t * t * t);
    value(&knots[a]) * (2.0 * t3 - 3.0 * t2 + 1.0)
        + slope(a) * span * (t3 - 2.0 * t2 + t)
        + value(&knots[b]) * (3.0 * t2 - 2.0 * t3)
        + slope(b) * span * (t3 - t2)
}
