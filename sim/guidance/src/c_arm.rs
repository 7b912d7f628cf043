//! The geometry of a C-arm: a point source and a flat detector around an isocentre.

use nalgebra::{Point3, Vector3};
use phrase::{Phrase, phrase};

/// Distance from the source to the detector, in m.
pub const SOURCE_DETECTOR_M: f64 = 1.0;
/// Edge of the detector, in m.
pub const DETECTOR_M: f64 = 0.3;
/// Allowed orbital angles, in degrees.
pub const ORBITAL_DEG: [f64; 2] = [-45.0, 90.0];
/// Allowed tilts, in degrees.
pub const TILT_DEG: [f64; 2] = [-45.0, 45.0];
/// Allowed distances from the source to the isocentre, in m.
pub const SOURCE_ISOCENTRE_M: [f64; 2] = [0.5, 0.8];
/// Allowed edges of the collimated square field at the detector, in m.
pub const FIELD_M: [f64; 2] = [0.06, 0.3];

/// Position of a C-arm. At angles of zero the tube is in front of the belly and the detector behind the back: below and
/// above a prone patient.
///
/// The focal spot is a point. A spot of 0.6 mm would blur by 0.4 mm at the detector, less than a pixel of 0.59 mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CArm {
    /// Rotation about the body's long axis, in rad; positive turns the detector to the patient's right.
    pub orbital_rad: f64,
    /// Rotation about the transverse axis, in rad; positive turns the detector to the head.
    pub tilt_rad: f64,
    /// The point about which the arm rotates, in m.
    pub isocentre_m: Point3<f64>,
    /// Distance from the source to the isocentre, in m.
    pub source_isocentre_m: f64,
    /// Edge of the collimated square field at the detector, in m.
    pub field_m: f64,
}

impl CArm {
    /// A C-arm at angles of zero with an open field, around a point in m.
    #[must_use]
    pub fn over(isocentre_m: Point3<f64>) -> Self {
        Self { orbital_rad: 0.0, tilt_rad: 0.0, isocentre_m, source_isocentre_m: 0.6, field_m: DETECTOR_M }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// The value out of range, with the allowed range.
    pub fn check(&self) -> Result<(), Phrase> {
        let values = [
            ("orbital", self.orbital_rad.to_degrees(), ORBITAL_DEG, "°"),
            ("tilt", self.tilt_rad.to_degrees(), TILT_DEG, "°"),
            ("source to isocentre", self.source_isocentre_m * 1e3, SOURCE_ISOCENTRE_M.map(|m| m * 1e3), " mm"),
            ("field", self.field_m * 1e3, FIELD_M.map(|m| m * 1e3), " mm"),
        ];
        // A degree that was converted to rad and back may be off by an ulp.
        let outside = |value: f64, [least, most]: [f64; 2]| !(value >= least - 1e-9 && value <= most + 1e-9);
        let Some((name, value, [least, most], unit)) =
            values.into_iter().find(|(_, value, range, _)| outside(*value, *range))
        else {
            return Ok(());
        };
        Err(phrase!(
            "{name} = {value}{unit}; allowed: {least} to {most}{unit}",
            name = name,
            value = value,
            unit = unit,
            least = least,
            most = most
        ))
    }

    /// Returns the direction from the source to the middle of the detector.
    #[must_use]
    pub fn direction(&self) -> Vector3<f64> {
        let ((so, co), (st, ct)) = (libm::sincos(self.orbital_rad), libm::sincos(self.tilt_rad));
        Vector3::new(so * ct, st, co * ct)
    }

    /// Returns the position of the source, in m.
    #[must_use]
    pub fn source_m(&self) -> Point3<f64> {
        self.isocentre_m - self.direction() * self.source_isocentre_m
    }

    /// Returns the axes of the picture: to the right and up, seen from the detector towards the source.
    #[must_use]
    pub fn picture_axes(&self) -> [Vector3<f64>; 2] {
        let ((so, co), (st, ct)) = (libm::sincos(self.orbital_rad), libm::sincos(self.tilt_rad));
        let up = Vector3::new(-so * st, ct, -co * st);
        [up.cross(&self.direction()), up]
    }
}

/// A C-arm's rays, one through the middle of each pixel.
#[derive(Clone, Copy, Debug)]
pub struct Detector {
    /// Pixels along an edge.
    pub pixels: usize,
    edge_m: f64,
    source_m: Point3<f64>,
    direction: Vector3<f64>,
    right: Vector3<f64>,
    up: Vector3<f64>,
}

impl Detector {
    /// The detector of a C-arm with so many pixels along an edge. Pixels are counted from the upper left.
    #[must_use]
    pub fn new(arm: &CArm, pixels: usize) -> Self {
        let [right, up] = arm.picture_axes();
        Self { pixels, edge_m: DETECTOR_M, source_m: arm.source_m(), direction: arm.direction(), right, up }
    }

    /// The nine sensors of the exposure control, in the middle third of a C-arm's field.
    #[must_use]
    pub fn sensors(arm: &CArm) -> Self {
        Self { edge_m: arm.field_m / 3.0, ..Self::new(arm, 3) }
    }

    /// Edge of a pixel, in m.
    #[must_use]
    pub fn pixel_m(&self) -> f64 {
        self.edge_m / self.pixels as f64
    }

    /// Position of the source, in m.
    #[must_use]
    pub fn source_m(&self) -> Point3<f64> {
        self.source_m
    }

    /// Projects a point: column and row in pixels, and its distance from the source along the central ray, in m. The
    /// middle of the pixel in column i is at i + 0.5.
    #[must_use]
    pub fn project(&self, point_m: &Point3<f64>) -> Vector3<f64> {
        let off = point_m - self.source_m;
        let along = off.dot(&self.direction);
        let scale = SOURCE_DETECTOR_M / along / self.pixel_m();
        let middle = 0.5 * self.pixels as f64;
        Vector3::new(middle + off.dot(&self.right) * scale, middle - off.dot(&self.up) * scale, along)
    }

    /// Returns the vector from the source to a place on the detector, given as column and row in pixels, in m.
    #[must_use]
    pub fn ray(&self, column: f64, row: f64) -> Vector3<f64> {
        let middle = 0.5 * self.pixels as f64;
        let [x, y] = [column - middle, middle - row].map(|pixels| pixels * self.pixel_m());
        self.direction * SOURCE_DETECTOR_M + self.right * x + self.up * y
    }
}
