//! Use of a C-arm in an attempt: its controls, topic `/c_arm`, and its pulses, topic `/fluoroscopy`.

/// Controls of a C-arm at a time. They hold until the next ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CArmControls {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Rotation about the body's long axis, in rad; positive turns the detector to the patient's right.
    pub orbital_rad: f64,
    /// Rotation about the transverse axis, in rad; positive turns the detector to the head.
    pub tilt_rad: f64,
    /// Edge of the collimated square field at the detector, in m.
    pub field_m: f64,
    /// Whether the pedal is pressed.
    pub pedal: bool,
    /// Number of single shots requested so far.
    pub shots: u32,
    /// Contrast medium injected so far, in ml.
    pub contrast_ml: f64,
}

impl CArmControls {
    /// Whether two differ in more than their time.
    #[must_use]
    pub fn differ(&self, other: &Self) -> bool {
        Self { t_s: other.t_s, ..*self } != *other
    }

    /// Whether two have the same position, field and contrast medium, and so the same picture but for the needle.
    #[must_use]
    pub fn is_same_view(&self, other: &Self) -> bool {
        let Self { t_s, pedal, shots, .. } = *other;
        Self { t_s, pedal, shots, ..*self } == *other
    }
}

/// A pulse of X-rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluoroscopyPulse {
    /// Time since the start, in s: that of a sample.
    pub t_s: f64,
    /// Index of the pulse in the attempt, from 0.
    pub index: u32,
    /// Whether it is a single shot, with the tube load of ten pulses.
    pub shot: bool,
    /// Tube load, in mAs.
    pub load_mas: f64,
    /// Mean transmission in the middle of the field, 0 to 1.
    pub mean_transmission: f64,
    /// Air kerma at the reference point since the start, in mGy.
    pub kerma_mgy: f64,
    /// Kerma–area product since the start, in Gy cm².
    pub kerma_area_gycm2: f64,
}

/// The fluoroscopy of an attempt; empty if the exercise has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fluoroscopy {
    /// The controls at the start and at each change, in order of time.
    pub controls: Vec<CArmControls>,
    /// The pulses in order of time.
    pub pulses: Vec<FluoroscopyPulse>,
}

impl Fluoroscopy {
    /// Returns the controls at a time in s; `None` before the first.
    #[must_use]
    pub fn controls_at(&self, t_s: f64) -> Option<&CArmControls> {
        let later = self.controls.partition_point(|controls| controls.t_s <= t_s);
        later.checked_sub(1).map(|at| &self.controls[at])
    }
}
