//! The shadow of a needle: a steel tube, with its stylet or without.

use nalgebra::{Point3, Vector3};

/// A needle in the beam. Its ends are flat: the bevel is shorter than two pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImagedNeedle {
    /// Its tip, in m.
    pub tip_m: Point3<f64>,
    /// Unit vector from the hub to the tip.
    pub direction: Vector3<f64>,
    /// Length from tip to hub, in m.
    pub length_m: f64,
    /// Outer diameter, in m.
    pub outer_m: f64,
    /// Inner diameter of the tube, in m.
    pub bore_m: f64,
    /// Whether a steel stylet fills the bore.
    pub has_stylet: bool,
}

impl ImagedNeedle {
    /// Returns the length of steel along the stretch of a ray from a point over a vector, in m.
    #[must_use]
    pub fn steel_m(&self, from_m: &Point3<f64>, over_m: &Vector3<f64>) -> f64 {
        let outer = self.inside_m(from_m, over_m, 0.5 * self.outer_m);
        if self.has_stylet || outer == 0.0 {
            return outer;
        }
        outer - self.inside_m(from_m, over_m, 0.5 * self.bore_m)
    }

    /// Length of a stretch of a ray inside a cylinder around the needle's axis.
    fn inside_m(&self, from_m: &Point3<f64>, over_m: &Vector3<f64>, radius_m: f64) -> f64 {
        let off = from_m - self.tip_m;
        let along = [off.dot(&self.direction), over_m.dot(&self.direction)];
        let [off, over] = [off - self.direction * along[0], over_m - self.direction * along[1]];
        // |off + t over| = radius, and −length ≤ along ≤ 0.
        let Some(across) = roots(over.norm_squared(), off.dot(&over), off.norm_squared() - radius_m * radius_m) else {
            return 0.0;
        };
        let ends = if along[1] == 0.0 {
            if (-self.length_m..=0.0).contains(&along[0]) { [0.0, 1.0] } else { return 0.0 }
        } else {
            let [one, two] = [-along[0] / along[1], (-self.length_m - along[0]) / along[1]];
            [one.min(two), one.max(two)]
        };
        let [enters, leaves] = [across[0].max(ends[0]).max(0.0), across[1].min(ends[1]).min(1.0)];
        (leaves - enters).max(0.0) * over_m.norm()
    }
}

/// The range in which a t² + 2 b t + c ≤ 0; unbounded if a ray is parallel to the axis and inside.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a < 1e-18 {
        return (c <= 0.0).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let discriminant = b * b - a * c;
    let root = (discriminant > 0.0).then(|| libm::sqrt(discriminant))?;
    Some([(-b - root) / a, (-b + root) / a])
}
