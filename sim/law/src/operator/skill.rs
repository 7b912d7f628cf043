//! Parameters of a hand's skill, and the three presets.
//!
//! Fitted so that the shipped scenes reproduce published figures of people; [`super`] lists the
//! sources and our choices, and `stylet bench operators` measures the result.

/// Parameters of a hand's skill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skill {
    /// Mass of the hand, in kg.
    pub mass_kg: f64,
    /// Damping of the hand that pushes lightly, in N·s/m. It grows with the root of the stiffness.
    pub damping_n_s_per_m: f64,
    /// Stiffness of the hand that pushes lightly, in N/m.
    pub stiffness_n_per_m: f64,
    /// Stiffness added by a hard push, when the other hand joins and both rest on the body, in N/m.
    pub brace_n_per_m: f64,
    /// Mean insertion speed, in m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the speed between attempts of different people, in m/s.
    pub speed_sd_m_per_s: f64,
    /// Standard deviation of the speed within an attempt, relative to its mean: 0 advances evenly,
    /// 1 in fits and starts.
    pub unevenness: f64,
    /// Fraction of its speed that the hand keeps near the goal, 0 to 1.
    pub care: f64,
    /// Mean reaction time to a felt pop, in s.
    pub reaction_s: f64,
    /// Standard deviation of the reaction time, in s.
    pub reaction_sd_s: f64,
    /// Probability of a lapse of attention at a pop, which multiplies the reaction time by four.
    pub lapse: f64,
    /// Duration of a halt, after a felt pop or in a hesitation, in s.
    pub pause_s: f64,
    /// Tremor, rms, in m.
    pub tremor_m: f64,
    /// Standard deviation of the angle error, in rad. The entry error is proportional to it.
    pub angle_sd_rad: f64,
    /// Standard deviation of the depth estimate, in m.
    pub depth_sd_m: f64,
    /// Push on bone before it is recognised as bone, in N.
    pub bone_push_n: f64,
    /// Fraction of its angle error that a hand removes when it redirects, 0 to 1. The new
    /// error is [`Skill::angle_sd_rad`] times the rest.
    pub correction: f64,
    /// Mean number of hesitations in each metre of advance, each as long as [`Skill::pause_s`].
    pub hesitations_per_m: f64,
    /// Standard deviation of the error with which a hand judges the angle of its line, in rad.
    pub judgement_sd_rad: f64,
    /// Distance from the planned line at the target that a hand accepts, as it judges it, in m.
    pub accepted_m: f64,
}

impl Skill {
    /// The novice preset: a relaxed hand that advances in fits and starts.
    #[must_use]
    pub fn novice() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 8.5,
            stiffness_n_per_m: 350.0,
            brace_n_per_m: 2500.0,
            speed_m_per_s: 0.0065,
            speed_sd_m_per_s: 0.0018,
            unevenness: 1.0,
            care: 0.8,
            reaction_s: 0.25,
            reaction_sd_s: 0.06,
            lapse: 0.25,
            pause_s: 2.9,
            tremor_m: 150e-6,
            angle_sd_rad: 6.0_f64.to_radians(),
            depth_sd_m: 0.0015,
            bone_push_n: 3.0,
            correction: 0.5,
            hesitations_per_m: 230.0,
            judgement_sd_rad: 2.5_f64.to_radians(),
            accepted_m: 0.005,
        }
    }

    /// The intermediate preset: a normal grip.
    #[must_use]
    pub fn intermediate() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 19.0,
            stiffness_n_per_m: 800.0,
            brace_n_per_m: 3000.0,
            speed_m_per_s: 0.004,
            speed_sd_m_per_s: 0.0009,
            unevenness: 0.5,
            care: 0.6,
            reaction_s: 0.20,
            reaction_sd_s: 0.03,
            lapse: 0.1,
            pause_s: 1.2,
            tremor_m: 100e-6,
            angle_sd_rad: 4.0_f64.to_radians(),
            depth_sd_m: 0.0010,
            bone_push_n: 2.0,
            correction: 0.6,
            hesitations_per_m: 100.0,
            judgement_sd_rad: 2.2_f64.to_radians(),
            accepted_m: 0.004,
        }
    }

    /// The expert preset: a braced hand.
    #[must_use]
    pub fn expert() -> Self {
        Self {
            mass_kg: 0.55,
            damping_n_s_per_m: 40.0,
            stiffness_n_per_m: 2600.0,
            brace_n_per_m: 6000.0,
            speed_m_per_s: 0.0032,
            speed_sd_m_per_s: 0.0005,
            unevenness: 0.2,
            care: 0.5,
            reaction_s: 0.15,
            reaction_sd_s: 0.02,
            lapse: 0.03,
            pause_s: 0.9,
            tremor_m: 60e-6,
            angle_sd_rad: 1.6_f64.to_radians(),
            depth_sd_m: 0.000_45,
            bone_push_n: 1.0,
            correction: 0.8,
            hesitations_per_m: 30.0,
            judgement_sd_rad: 1.5_f64.to_radians(),
            accepted_m: 0.003,
        }
    }

    /// Standard deviation of the angle error added by a redirection, in rad.
    pub(super) fn redirect_sd_rad(&self) -> f64 {
        self.angle_sd_rad * (1.0 - self.correction)
    }

    /// Interpolates between two skills, `s` = 0 for `self`, 1 for `other`; used to simulate
    /// improving trainees.
    #[must_use]
    pub fn towards(&self, other: &Self, s: f64) -> Self {
        let between = |of: fn(&Self) -> f64| of(self) * (1.0 - s) + of(other) * s;
        Self {
            mass_kg: between(|skill| skill.mass_kg),
            damping_n_s_per_m: between(|skill| skill.damping_n_s_per_m),
            stiffness_n_per_m: between(|skill| skill.stiffness_n_per_m),
            brace_n_per_m: between(|skill| skill.brace_n_per_m),
            speed_m_per_s: between(|skill| skill.speed_m_per_s),
            speed_sd_m_per_s: between(|skill| skill.speed_sd_m_per_s),
            unevenness: between(|skill| skill.unevenness),
            care: between(|skill| skill.care),
            reaction_s: between(|skill| skill.reaction_s),
            reaction_sd_s: between(|skill| skill.reaction_sd_s),
            lapse: between(|skill| skill.lapse),
            pause_s: between(|skill| skill.pause_s),
            tremor_m: between(|skill| skill.tremor_m),
            angle_sd_rad: between(|skill| skill.angle_sd_rad),
            depth_sd_m: between(|skill| skill.depth_sd_m),
            bone_push_n: between(|skill| skill.bone_push_n),
            correction: between(|skill| skill.correction),
            hesitations_per_m: between(|skill| skill.hesitations_per_m),
            judgement_sd_rad: between(|skill| skill.judgement_sd_rad),
            accepted_m: between(|skill| skill.accepted_m),
        }
    }
}
