//! A needle in the hand of a test: poses at 1 kHz, and what came of each.

use mechanics::axial::AxialSpec;
use mechanics::operator::needle_pose;
use mechanics::puncture::{
    PunctureEvent, PunctureInput, PunctureOutput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState, step,
};
use mechanics::structures::StructureSpec;
use nalgebra::{Isometry3, Point3, Vector3};

/// Time of a tick, in s.
pub const DT: f64 = 1e-3;

/// A needle driven pose by pose at 1 kHz.
pub struct Needle {
    pub params: PunctureParams,
    pub state: PunctureState,
    pub scratch: PunctureScratch,
    pub tick: u32,
}

impl Needle {
    pub fn new(axial: AxialSpec, structures: Vec<StructureSpec>) -> Self {
        let spec = PunctureSpec { axial, lateral_stiffness_n_per_m2: 10_000.0, needle_length_m: 0.15, structures };
        let params = PunctureParams::new(spec).expect("a valid scene");
        let (state, scratch) = (PunctureState::new(&params), PunctureScratch::new(&params));
        Self { params, state, scratch, tick: 0 }
    }

    pub fn pose(&mut self, patient_from_needle: Isometry3<f64>) -> PunctureOutput {
        let input = PunctureInput { t_s: f64::from(self.tick) * DT, patient_from_needle };
        self.tick += 1;
        step(&self.params, &mut self.state, &mut self.scratch, &input)
    }

    /// Puts the tip at a point with the needle straight down.
    pub fn down(&mut self, x_m: f64, y_m: f64, z_m: f64) -> PunctureOutput {
        self.pose(needle_pose(&Point3::new(x_m, y_m, z_m), &-Vector3::z()))
    }

    /// Moves the tip along a line at 20 mm/s, returning every output with its events.
    pub fn travel(&mut self, axis: Vector3<f64>, from: Point3<f64>, to: Point3<f64>) -> Vec<Tick> {
        let ticks = ((to - from).norm() / (0.02 * DT)).ceil() as u32;
        (1..=ticks)
            .map(|tick| {
                let tip_m = from + (to - from) * (f64::from(tick) / f64::from(ticks));
                let output = self.pose(needle_pose(&tip_m, &axis));
                Tick { tip_m, output, events: self.scratch.events.clone() }
            })
            .collect()
    }
}

pub struct Tick {
    pub tip_m: Point3<f64>,
    pub output: PunctureOutput,
    pub events: Vec<PunctureEvent>,
}
