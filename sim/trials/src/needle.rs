//! A needle driven by poses at 1 kHz, with the result of each.

use law::Skin;
use law::axial::{AxialSpec, ParamError};
use law::operator::needle_pose;
use law::puncture::{
    PunctureEvent, PunctureInput, PunctureOutput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState, step,
};
use law::structures::StructureSpec;
use nalgebra::{Isometry3, Point3, Vector3};

/// Duration of a tick, in s.
pub const DT: f64 = 1e-3;
/// Speed of a straight motion, in m/s.
pub const SPEED_M_PER_S: f64 = 0.02;

/// A needle driven pose by pose at 1 kHz.
pub struct DrivenNeedle {
    /// The scene.
    pub params: PunctureParams,
    /// The state of the puncture.
    pub state: PunctureState,
    /// The last step's events.
    pub scratch: PunctureScratch,
    /// Number of steps so far.
    pub tick: u32,
}

impl DrivenNeedle {
    /// Creates a rigid needle above the skin of a scene with structures.
    ///
    /// # Errors
    /// If the law refuses the scene or a structure.
    pub fn new(axial: AxialSpec, structures: Vec<StructureSpec>) -> Result<Self, ParamError> {
        Self::bending(axial, structures, None)
    }

    /// Creates a needle with a bending stiffness, in N·m², or a rigid one.
    ///
    /// # Errors
    /// As [`DrivenNeedle::new`].
    pub fn bending(
        axial: AxialSpec,
        structures: Vec<StructureSpec>,
        needle_bending_n_m2: Option<f64>,
    ) -> Result<Self, ParamError> {
        Self::held_over(PunctureSpec {
            axial,
            lateral_stiffness_n_per_m2: 10_000.0,
            needle_length_m: 0.15,
            hub_stiffness_n_per_m: None,
            needle_bending_n_m2,
            skin: Skin::Flat,
            structures,
        })
    }

    /// Creates a needle above the skin of a specification.
    ///
    /// # Errors
    /// As [`DrivenNeedle::new`].
    pub fn held_over(spec: PunctureSpec) -> Result<Self, ParamError> {
        let params = PunctureParams::new(spec)?;
        let (state, scratch) = (PunctureState::new(&params), PunctureScratch::new(&params));
        Ok(Self { params, state, scratch, tick: 0 })
    }

    /// Steps to a pose.
    pub fn pose(&mut self, patient_from_needle: Isometry3<f64>) -> PunctureOutput {
        let input = PunctureInput { t_s: f64::from(self.tick) * DT, patient_from_needle };
        self.tick += 1;
        step(&self.params, &mut self.state, &mut self.scratch, &input)
    }

    /// Moves the tip to a point with the needle pointing straight down.
    pub fn down(&mut self, x_m: f64, y_m: f64, z_m: f64) -> PunctureOutput {
        self.pose(needle_pose(&Point3::new(x_m, y_m, z_m), &-Vector3::z()))
    }

    /// Moves the tip along a line at [`SPEED_M_PER_S`] and returns every output with its events.
    pub fn travel(&mut self, axis: Vector3<f64>, from: Point3<f64>, to: Point3<f64>) -> Vec<NeedleTick> {
        let ticks = ((to - from).norm() / (SPEED_M_PER_S * DT)).ceil() as u32;
        (1..=ticks)
            .map(|tick| {
                let tip_m = from + (to - from) * (f64::from(tick) / f64::from(ticks));
                let output = self.pose(needle_pose(&tip_m, &axis));
                NeedleTick { tip_m, output, events: self.scratch.events.clone() }
            })
            .collect()
    }
}

/// The result of one pose.
pub struct NeedleTick {
    /// Tip position, in m.
    pub tip_m: Point3<f64>,
    /// The forces.
    pub output: PunctureOutput,
    /// The events.
    pub events: Vec<PunctureEvent>,
}
