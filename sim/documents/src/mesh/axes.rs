//! The axes of a mesh's coordinates and their rotation into the patient frame.
//!
//! The patient lies prone, so that +z, out of the body, is posterior; +y is superior, towards the
//! head. The third axis of a right-handed frame, superior × posterior, is the patient's right: +x.

use nalgebra::Point3;

/// The axes of a mesh's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axes {
    /// Those of the patient frame: right, superior, posterior.
    Patient,
    /// Right, anterior, superior, as in `NIfTI` and 3D Slicer.
    Ras,
    /// Left, posterior, superior, as in DICOM and ITK.
    Lps,
}

impl Axes {
    /// Keywords in documents.
    pub(crate) const WORDS: &[&str] = &["patient", "RAS", "LPS"];

    /// Returns the axes for a keyword; those of the patient frame for an unknown one.
    pub(crate) fn named(word: &str) -> Self {
        match word {
            "RAS" => Self::Ras,
            "LPS" => Self::Lps,
            _ => Self::Patient,
        }
    }

    /// Rotates a point into the patient frame. Each case is a rotation: a reflection would turn a
    /// mesh inside out.
    pub(crate) fn to_patient(self, [a, b, c]: [f64; 3]) -> Point3<f64> {
        match self {
            Self::Patient => Point3::new(a, b, c),
            Self::Ras => Point3::new(a, c, -b),
            Self::Lps => Point3::new(-a, c, b),
        }
    }

    /// Rotates a point of the patient frame into the mesh's own coordinates.
    pub(crate) fn to_file(self, point: &Point3<f64>) -> [f64; 3] {
        let [x, y, z] = [point.x, point.y, point.z];
        match self {
            Self::Patient => [x, y, z],
            Self::Ras => [x, -z, y],
            Self::Lps => [-x, z, y],
        }
    }
}
