//! How a needle is planned to go in.

use law::{Incidence, Skin};
use nalgebra::{Point3, Vector3};

/// A planned way in, measured in the frame of the skin's normal at its entry.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlannedNeedle {
    /// Place of the entry in plan, patient frame, in mm.
    pub entry_mm: [f64; 2],
    /// Angle to the skin's normal there, in degrees.
    pub angle_deg: f64,
    /// Where the tip heads for, from +x towards +y, in degrees: at 0 an oblique needle goes in towards +x while its hub leans to −x.
    pub azimuth_deg: f64,
}

/// Directions at an entry, each of unit length and at right angles to the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EntryFrame {
    /// Along the skin, towards where the needle leans.
    pub lean: Vector3<f64>,
    /// Along the skin, to the left of that as seen from outside.
    pub side: Vector3<f64>,
    /// Out of the body.
    pub out: Vector3<f64>,
}

impl From<f64> for PlannedNeedle {
    /// At the origin, towards +x, at an angle to the normal in degrees.
    fn from(angle_deg: f64) -> Self {
        Self { angle_deg, ..Self::default() }
    }
}

impl PlannedNeedle {
    /// Where it meets a skin, in m.
    #[must_use]
    pub fn entry_m(&self, skin: &Skin) -> Point3<f64> {
        skin.above(self.entry_mm[0] * 1e-3, self.entry_mm[1] * 1e-3)
    }

    /// Its direction into the body, of unit length.
    #[must_use]
    pub fn axis(&self, skin: &Skin) -> Vector3<f64> {
        let (angle, azimuth) = (self.angle_deg.to_radians(), self.azimuth_deg.to_radians());
        let sideways = libm::sin(angle);
        let level = Vector3::new(sideways * libm::cos(azimuth), sideways * libm::sin(azimuth), -libm::cos(angle));
        turn_upright(&skin.outward(&self.entry_m(skin)), &level)
    }

    /// How it meets the layers.
    #[must_use]
    pub fn incidence(&self, skin: &Skin) -> Incidence {
        skin.incidence(&self.entry_m(skin), &self.axis(skin))
    }

    /// A place in the frame of its entry, in m.
    pub(crate) fn seen_from_entry_m(&self, skin: &Skin, place_m: &Point3<f64>) -> Point3<f64> {
        let EntryFrame { lean, side, out } = self.frame(skin);
        let away_m = place_m - self.entry_m(skin);
        Point3::from([lean, side, out].map(|direction| away_m.dot(&direction)))
    }

    /// The frame of its entry.
    pub(crate) fn frame(&self, skin: &Skin) -> EntryFrame {
        let out = skin.outward(&self.entry_m(skin));
        let azimuth = self.azimuth_deg.to_radians();
        let lean = turn_upright(&out, &Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0));
        EntryFrame { lean, side: out.cross(&lean), out }
    }
}

/// A vector of the frame of z, turned with z into a direction above the plane z = 0 by the shortest way.
fn turn_upright(to: &Vector3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    let turn = Vector3::z().cross(to);
    let once = turn.cross(vector);
    vector + once + turn.cross(&once) / (1.0 + to.z)
}
