//! A virtual wall that tests a device before an attempt: a spring of bounded stiffness and force.
//!
//! It is an attempt without tissue: the servo and the safety chain are those of an attempt, and the
//! force law has one boundary that never ruptures, without friction, cutting or damping. The energy
//! observer holds for it as for tissue.

use std::sync::Arc;

use law::Skin;
use law::axial::{AxialSpec, ForceLaw, Layer, LayerOptions};
use law::puncture::{PunctureParams, PunctureSpec};

use crate::device::DeviceInfo;
use crate::mapping::Mapping;
use crate::safety::SafetyParams;
use crate::scaling::{Limit, ScaledBoundary, Scaling};
use crate::servo::Setup;

/// Stiffness of the wall on a device that can show it, in N/m: that of muscle in the training
/// scenes.
const WALL_N_PER_M: f64 = 497.0;
/// Greatest force of the wall on a device that can give it, in N (choice): that of a puncture.
const WALL_N: f64 = 3.0;
/// Fraction of a device's greatest force that the wall uses (choice).
const SHARE: f64 = 0.9;
/// Depth up to which the wall returns all energy of a press, in m (choice): further in, the energy
/// observer damps the way out.
const RETURNED_M: f64 = 0.03;
/// Rupture force of the boundary, in N: the largest that the law accepts. The force is limited far
/// below it.
const NEVER_N: f64 = 1e9;

/// The wall for a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestWall {
    /// Stiffness, in N/m: at most what the device can show.
    pub stiffness_n_per_m: f64,
    /// Greatest force, in N: below that of the device. 0 for a device without motors.
    pub max_force_n: f64,
}

impl TestWall {
    /// The wall for a device.
    #[must_use]
    pub fn new(info: &DeviceInfo) -> Self {
        // A device without motors shows no stiffness; the law needs one above 0.
        let stiffness_n_per_m = WALL_N_PER_M.min(info.max_stiffness_n_per_m).max(1.0);
        Self { stiffness_n_per_m, max_force_n: WALL_N.min(SHARE * info.max_force_n).max(0.0) }
    }

    /// Force at a depth in m, in N: a spring up to the greatest force.
    #[must_use]
    pub fn force_n(&self, depth_m: f64) -> f64 {
        (self.stiffness_n_per_m * depth_m.max(0.0)).min(self.max_force_n)
    }

    /// Everything that a servo needs at a rate in Hz. The wall is the plane z = 0 of the patient
    /// frame.
    #[must_use]
    pub fn setup(&self, mapping: Mapping, info: &DeviceInfo, rate_hz: f64) -> Setup {
        let limited = DeviceInfo { max_force_n: self.max_force_n, ..info.clone() };
        Setup {
            params: Arc::new(self.params()),
            mapping,
            scaling: self.scaling(),
            safety: SafetyParams::new(&limited, rate_hz, self.softest_n_per_m()),
            rate_hz,
        }
    }

    /// Stiffness of a spring that stores, at the greatest force, the energy of a press to
    /// [`RETURNED_M`], in N/m: the wall's own spring, and the way on with the greatest force.
    fn softest_n_per_m(&self) -> f64 {
        let (stiffness, force_n) = (self.stiffness_n_per_m, self.max_force_n);
        let spring_m = force_n / stiffness;
        let stored_j = 0.5 * force_n * spring_m + force_n * (RETURNED_M - spring_m).max(0.0);
        if stored_j > 0.0 { (force_n * force_n / (2.0 * stored_j)).min(stiffness) } else { stiffness }
    }

    #[expect(clippy::expect_used, reason = "the numbers are constants, but for a stiffness from 1 N/m to 497 N/m")]
    fn params(&self) -> PunctureParams {
        let wall = Layer {
            name: "wall".to_owned(),
            thickness_m: 1.0,
            stiffness_n_per_m: self.stiffness_n_per_m,
            damping_n_s_per_m2: 0.0,
            tip_rupture_n: NEVER_N,
            rim_rupture_n: NEVER_N,
            friction_n_per_m: 0.0,
            cutting_n: 0.0,
            options: LayerOptions::default(),
        };
        let axial = AxialSpec {
            law: ForceLaw::Version5,
            layers: vec![wall],
            tip_to_rim_m: 0.0,
            presliding_stiffness_n_per_m: self.stiffness_n_per_m,
            speed_window_s: 0.0,
            damping_time_s: 0.0,
            rate: None,
            breakaway: None,
        };
        let spec = PunctureSpec {
            axial,
            lateral_stiffness_n_per_m2: 0.0,
            needle_length_m: 1.0,
            hub_stiffness_n_per_m: None,
            needle_bending_n_m2: None,
            skin: Skin::Flat,
            structures: Vec::new(),
        };
        PunctureParams::new(spec).expect("a valid wall")
    }

    /// The force is not scaled: the wall is made for the device.
    fn scaling(&self) -> Scaling {
        let has_motors = self.max_force_n > 0.0;
        let factor = f64::from(u8::from(has_motors));
        Scaling {
            factor,
            sliding_factor: factor,
            limit: if has_motors { Limit::None } else { Limit::NoMotors },
            peak_n: self.max_force_n,
            scaled_peak_n: self.max_force_n,
            boundaries: vec![ScaledBoundary { name: "wall".to_owned(), factor, pop_n: None }],
            scaled_softest_n_per_m: self.stiffness_n_per_m,
        }
    }
}
