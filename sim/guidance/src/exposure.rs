//! Exposure control and dose of a pulse.

use crate::c_arm::{CArm, DETECTOR_M, SOURCE_DETECTOR_M};

/// Air kerma of the tube at 1 m, in µGy per mAs (SpekPy 2.5.4 for the spectrum of [`crate::attenuation`]).
pub const YIELD_UGY_PER_MAS: f64 = 35.76;
/// Allowed tube load of a pulse, in mAs.
pub const LOAD_MAS: [f64; 2] = [0.02, 1.0];
/// Distance of the reference point from the isocentre towards the source, in m (IEC 60601-2-43).
const REFERENCE_M: f64 = 0.15;

/// Air kerma at the detector that the exposure control aims at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KermaLevel {
    /// 30 nGy a pulse.
    Low,
    /// 45 nGy.
    Normal,
    /// 65 nGy.
    Boost,
}

impl KermaLevel {
    /// The kerma, in µGy.
    #[must_use]
    pub fn kerma_ugy(self) -> f64 {
        match self {
            Self::Low => 0.030,
            Self::Normal => 0.045,
            Self::Boost => 0.065,
        }
    }
}

/// A pulse's exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Tube load, in mAs.
    pub load_mas: f64,
    /// Air kerma at the detector without a body, in µGy.
    pub open_kerma_ugy: f64,
    /// Air kerma at the reference point, in µGy.
    pub kerma_ugy: f64,
    /// Kerma–area product, in µGy m².
    pub kerma_area_ugy_m2: f64,
}

impl Exposure {
    /// The exposure for a mean transmission in the middle of the field: the load that gives the detector its kerma,
    /// within the limits of the tube.
    #[must_use]
    pub fn control(arm: &CArm, level: KermaLevel, mean_transmission: f64) -> Self {
        let at_detector = 1.0 / (SOURCE_DETECTOR_M * SOURCE_DETECTOR_M);
        let wanted = level.kerma_ugy() / (YIELD_UGY_PER_MAS * mean_transmission * at_detector);
        Self::with_load(arm, wanted.clamp(LOAD_MAS[0], LOAD_MAS[1]))
    }

    /// The exposure for a tube load in mAs.
    #[must_use]
    pub fn with_load(arm: &CArm, load_mas: f64) -> Self {
        let at_detector = 1.0 / (SOURCE_DETECTOR_M * SOURCE_DETECTOR_M);
        let reference_m = arm.source_isocentre_m - REFERENCE_M;
        let kerma_ugy = YIELD_UGY_PER_MAS * load_mas / (reference_m * reference_m);
        let edge_m = arm.field_m.min(DETECTOR_M) * reference_m / SOURCE_DETECTOR_M;
        Self {
            load_mas,
            open_kerma_ugy: YIELD_UGY_PER_MAS * load_mas * at_detector,
            kerma_ugy,
            kerma_area_ugy_m2: kerma_ugy * edge_m * edge_m,
        }
    }
}
