//! Coaching during an attempt: evaluates an exercise's rules, with hysteresis, on each tick.

use documents::{CoachingRule, Exercise, Wording};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use recording::sample::flags;
use recording::{FluoroscopyPulse, Sample};

/// Time constant of the speed's low-pass, in s: a hand's tremor of 10 Hz must not count as haste.
const SMOOTHED_S: f64 = 0.05;

/// Evaluates coaching rules during an attempt. Deterministic: the same samples produce the same
/// messages.
#[derive(Clone, Debug)]
pub struct Coach<'e> {
    rules: &'e [CoachingRule],
    /// Whether each rule is armed.
    armed: Vec<bool>,
    planned: Vector3<f64>,
    pulses_per_s: f64,
    last_s: Option<f64>,
    speed_m_per_s: f64,
    /// Time with X-rays so far, in s, and air kerma at the reference point so far, in mGy.
    fluoroscopy_s: f64,
    kerma_mgy: f64,
}

impl<'e> Coach<'e> {
    /// Creates a coach at the start of an attempt.
    #[must_use]
    pub fn new(exercise: &'e Exercise) -> Self {
        let rules = exercise.coaching.as_slice();
        Self {
            rules,
            armed: vec![true; rules.len()],
            planned: exercise.axis(),
            pulses_per_s: exercise.fluoroscopy.as_ref().map_or(1.0, |settings| settings.pulses_per_s),
            last_s: None,
            speed_m_per_s: 0.0,
            fluoroscopy_s: 0.0,
            kerma_mgy: 0.0,
        }
    }

    /// Adds a pulse of X-rays, which the next [`Self::watch`] takes into account.
    pub fn note_pulse(&mut self, pulse: &FluoroscopyPulse) {
        self.kerma_mgy = pulse.kerma_mgy;
        if !pulse.shot {
            self.fluoroscopy_s += 1.0 / self.pulses_per_s;
        }
    }

    /// Returns the messages due at a tick, where the force on the hand along the needle is `hand_n`, in N: of each rule once when its
    /// quantity rises above its limit, and again only after the quantity has been below the limit at which the rule arms again.
    pub fn watch(&mut self, sample: &Sample, hand_n: f64) -> Vec<&'e Wording> {
        self.smooth(sample);
        let mut said = Vec::new();
        for (at, rule) in self.rules.iter().enumerate() {
            let value = self.live_quantity(&rule.quantity, sample, hand_n);
            if self.armed[at] && value > rule.above {
                self.armed[at] = false;
                said.push(&rule.message);
            } else if value < rule.rearm_below {
                self.armed[at] = true;
            }
        }
        said
    }

    /// A live quantity, in the unit of its name. Outside the body there is neither depth nor force to speak of, and the needle may hurry.
    fn live_quantity(&self, name: &str, sample: &Sample, hand_n: f64) -> f64 {
        let is_inside = sample.flags & flags::INSIDE != 0;
        match name {
            "fluoroscopy_time_s" => self.fluoroscopy_s,
            "kerma_mgy" => self.kerma_mgy,
            _ if !is_inside => 0.0,
            "depth_mm" => sample.x_m * 1e3,
            "force_n" => hand_n.abs(),
            "speed_mm_per_s" => self.speed_m_per_s * 1e3,
            "angle_error_deg" => angle_error_rad(sample.orientation, &self.planned).to_degrees(),
            _ => 0.0,
        }
    }

    fn smooth(&mut self, sample: &Sample) {
        let speed_m_per_s = Vector3::from(sample.velocity_m_per_s).cast::<f64>().norm();
        let dt_s = self.last_s.map_or(0.0, |last_s| sample.t_s - last_s);
        let share = 1.0 - libm::exp(-dt_s.max(0.0) / SMOOTHED_S);
        self.speed_m_per_s += share * (speed_m_per_s - self.speed_m_per_s);
        self.last_s = Some(sample.t_s);
    }
}

fn angle_error_rad(orientation: [f64; 4], planned: &Vector3<f64>) -> f64 {
    let axis = UnitQuaternion::new_normalize(Quaternion::from(orientation)) * Vector3::z();
    libm::atan2(axis.cross(planned).norm(), axis.dot(planned))
}
