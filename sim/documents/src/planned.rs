//! The planned entry of a needle.

use law::{Incidence, Skin};
use nalgebra::{Point3, Vector3};

/// A planned entry, angle and azimuth in the frame of the skin's normal at the entry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlannedNeedle {
    /// Entry in plan view, patient frame, in mm.
    pub entry_mm: [f64; 2],
    /// Angle to the skin's normal at the entry, in degrees.
    pub angle_deg: f64,
    /// Direction in which the tip moves, from +x towards +y, in degrees: at 0 an oblique needle
    /// advances towards +x while its hub leans to −x.
    pub azimuth_deg: f64,
}

/// Orthonormal directions at an entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EntryFrame {
    /// Along the skin, in the direction of the lean.
    pub lean: Vector3<f64>,
    /// Along the skin, to the left of `lean` seen from outside.
    pub side: Vector3<f64>,
    /// Out of the body.
    pub out: Vector3<f64>,
}

impl From<f64> for PlannedNeedle {
    /// Creates a plan for the origin, leaning towards +x, at an angle to the normal in degrees.
    fn from(angle_deg: f64) -> Self {
        Self { angle_deg, ..Self::default() }
    }
}

impl PlannedNeedle {
    /// Returns the entry on a skin, in m.
    #[must_use]
    pub fn entry_m(&self, skin: &Skin) -> Point3<f64> {
        skin.above(self.entry_mm[0] * 1e-3, self.entry_mm[1] * 1e-3)
    }

    /// Returns the direction into the body, of unit length.
    #[must_use]
    pub fn axis(&self, skin: &Skin) -> Vector3<f64> {
        let (angle, azimuth) = (self.angle_deg.to_radians(), self.azimuth_deg.to_radians());
        let sideways = libm::sin(angle);
        let level = Vector3::new(sideways * libm::cos(azimuth), sideways * libm::sin(azimuth), -libm::cos(angle));
        turn_upright(&skin.outward(&self.entry_m(skin)), &level)
    }

    /// Returns the incidence on the layers.
    #[must_use]
    pub fn incidence(&self, skin: &Skin) -> Incidence {
        skin.incidence(&self.entry_m(skin), &self.axis(skin))
    }

    /// Transforms a point to the frame of the entry, in m.
    pub(crate) fn seen_from_entry_m(&self, skin: &Skin, place_m: &Point3<f64>) -> Point3<f64> {
        let EntryFrame { lean, side, out } = self.frame(skin);
        let away_m = place_m - self.entry_m(skin);
        Point3::from([lean, side, out].map(|direction| away_m.dot(&direction)))
    }

    /// Returns the frame of the entry.
    pub(crate) fn frame(&self, skin: &Skin) -> EntryFrame {
        let out = skin.outward(&self.entry_m(skin));
        let azimuth = self.azimuth_deg.to_radians();
        let lean = turn_upright(&out, &Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0));
        EntryFrame { lean, side: out.cross(&lean), out }
    }
}

/// Rotates a vector by the smallest rotation that takes z to `to`, a direction with z > 0.
fn turn_upright(to: &Vector3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    let turn = Vector3::z().cross(to);
    let once = turn.cross(vector);
    vector + once + turn.cross(&once) / (1.0 + to.z)
}
