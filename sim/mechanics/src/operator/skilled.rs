//! A skilled operator: errors drawn once, then mind, hand and tremor tick by tick.

use nalgebra::{Point3, Vector3};

use super::gauss::Draw;
use super::hand::{Hand, SetPoint};
use super::intent::{Act, Aim, Intent, Sensed};
use super::tremor::Tremor;
use super::{Motion, Plan, Skill, needle_pose};

/// How far off the planned entry a hand puts the needle, per radian of its angle error: 0.1 mm per degree (choice), in m/rad, for each axis.
const ENTRY_SD_M_PER_RAD: f64 = 0.0057;
/// How far off a hand judges a depth: 0.2 mm per degree of its angle error (choice), in m/rad.
const DEPTH_SD_M_PER_RAD: f64 = 0.0115;
/// Speed drawn for an attempt, as a part of the skill's mean: neither standing still nor a stab.
const SPEED_PARTS: (f64, f64) = (0.3, 2.0);
/// Nobody reacts faster than this, in s.
const MIN_REACTION_S: f64 = 0.1;

#[derive(Clone, Debug)]
pub(super) struct Skilled {
    entry_m: Point3<f64>,
    axis: Vector3<f64>,
    hand: Hand,
    intent: Intent,
    tremor: Tremor,
    /// The tremor's displacement now, in m.
    shake_m: Vector3<f64>,
    t_s: f64,
}

impl Skilled {
    pub fn new(skill: &Skill, plan: &Plan, seed: u64) -> Self {
        let mut draw = Draw::new(seed);
        let mean = skill.speed_m_per_s;
        let drawn = mean + draw.normal(skill.speed_sd_m_per_s);
        let speed_m_per_s = drawn.max(SPEED_PARTS.0 * mean).min(SPEED_PARTS.1 * mean);
        let reaction_s = (skill.reaction_s + draw.normal(skill.reaction_sd_s)).max(MIN_REACTION_S);
        let axis = tilt(&plan.axis, skill.angle_sd_rad, &mut draw);
        let entry_sd_m = ENTRY_SD_M_PER_RAD * skill.angle_sd_rad;
        let entry_m = plan.entry_m + Vector3::new(draw.normal(entry_sd_m), draw.normal(entry_sd_m), 0.0);
        let goal_m = plan.target_x_m + draw.normal(DEPTH_SD_M_PER_RAD * skill.angle_sd_rad);
        let aim = Aim {
            goal_m,
            approach_m: plan.approach_m,
            hold_s: plan.hold_s,
            speed_m_per_s,
            reaction_s,
            max_lead_m: Aim::max_lead_m(skill.stiffness_n_per_m),
        };
        let tremor = Tremor::new(skill.tremor_m, &mut draw);
        Self {
            entry_m,
            axis,
            hand: Hand::new(skill, entry_m.coords - axis * plan.approach_m),
            intent: Intent::new(aim),
            shake_m: tremor.at(0.0),
            tremor,
            t_s: 0.0,
        }
    }

    /// The motion before any time has passed.
    pub fn start(&self) -> Motion {
        self.motion(false, false)
    }

    pub fn advance(&mut self, dt_s: f64, force_n: &Vector3<f64>) -> Motion {
        let x_m = self.along(&self.hand.position_m);
        let tip_x_m = self.along(&(self.hand.position_m + self.shake_m));
        self.t_s += dt_s;
        let act = self.intent.act(&Sensed { dt_s, x_m, tip_x_m, force_n: -force_n.dot(&self.axis) });
        let Act { set_point_m, speed_m_per_s, confirm, done } = act;
        let set_point = SetPoint {
            position_m: self.entry_m.coords + self.axis * set_point_m,
            velocity_m_per_s: self.axis * speed_m_per_s,
        };
        self.hand.step(dt_s, &set_point, force_n);
        self.shake_m = self.tremor.at(self.t_s);
        self.motion(confirm, done)
    }

    /// Displacement of a point along the operator's own line, in m.
    fn along(&self, point_m: &Vector3<f64>) -> f64 {
        (point_m - self.entry_m.coords).dot(&self.axis)
    }

    fn motion(&self, confirm: bool, done: bool) -> Motion {
        let tip_m = Point3::from(self.hand.position_m + self.shake_m);
        Motion { patient_from_needle: needle_pose(&tip_m, &self.axis), confirm, done }
    }
}

/// An axis off by a random angle of the given standard deviation, in a random direction.
fn tilt(axis: &Vector3<f64>, sd_rad: f64, draw: &mut Draw) -> Vector3<f64> {
    let aside = if axis.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
    let u = axis.cross(&aside).normalize();
    let w = axis.cross(&u);
    let part_sd = sd_rad * core::f64::consts::FRAC_1_SQRT_2;
    (axis + u * draw.normal(part_sd) + w * draw.normal(part_sd)).normalize()
}
