//! A skilled operator: errors drawn once, then mind, hand and tremor tick by tick.

use nalgebra::{Point3, Vector3};

use super::doubt::Doubt;
use super::gauss::Draw;
use super::grip::Grip;
use super::hand::{Hand, SetPoint};
use super::intent::{Act, Intent, IntentAim, Sensed};
use super::lean::Lean;
use super::occasion::{Occasion, Traits};
use super::pace::Pace;
use super::tremor::Tremor;
use super::{Felt, Motion, Plan, Skill, needle_pose};

/// Standard deviation of the entry error per radian of the hand's angle error: 0.1 mm per degree
/// (choice), in m/rad, for each axis.
const ENTRY_SD_M_PER_RAD: f64 = 0.0057;
/// Limits of an attempt's speed relative to the skill's mean: neither standing still nor a stab.
const SPEED_PARTS: (f64, f64) = (0.3, 2.0);
/// Lower bound of a reaction time, in s.
const MIN_REACTION_S: f64 = 0.1;
/// Spread of the tremor between hands of a skill, as a standard deviation of the logarithm (choice).
const SHAKINESS_SD: f64 = 0.2;
/// Spread of clumsiness between people of a skill, as a standard deviation of the logarithm: a
/// choice, fitted so that scores differ by the published effect sizes of 1 to 1.5. A clumsy person
/// has larger errors of angle and depth, more lapses, a softer grip and a less even pace.
const CLUMSINESS_SD: f64 = 0.8;
/// Exponent of clumsiness for the judgement of a line: the ratio of the presets' judgements is that
/// of their angles to this power.
const JUDGEMENT_EXPONENT: f64 = 0.4;
/// Softest and stiffest light grip of a person, in N/m (choice), which bound the clumsiness.
const GRIPS_N_PER_M: (f64, f64) = (175.0, 5200.0);
/// Largest unevenness of a pace: beyond it the hand mostly stands still.
const MAX_UNEVENNESS: f64 = 1.2;
/// Number of pops for which a lapse is drawn.
const POPS: u32 = 64;

#[derive(Clone, Debug)]
pub(super) struct Skilled {
    entry_m: Point3<f64>,
    lean: Lean,
    reach_m: f64,
    hand: Hand,
    grip: Grip,
    intent: Intent,
    doubt: Doubt,
    tremor: Tremor,
    /// The current displacement by tremor, in m.
    shake_m: Vector3<f64>,
    t_s: f64,
    skill: Skill,
    /// Random draws of redirections, made after all others.
    chance: Draw,
}

impl Skilled {
    pub fn new(skill: &Skill, plan: &Plan, occasion: &Occasion) -> Self {
        let mut traits = Traits::new(occasion);
        let skill = skill_of_person(skill, &mut traits);
        let lean = Lean::new(&plan.axis, skill.angle_sd_rad, &mut traits);
        let entry_sd_m = ENTRY_SD_M_PER_RAD * skill.angle_sd_rad;
        let entry_m = move_on_skin(plan, &(Vector3::new(traits.z(), traits.z(), 0.0) * entry_sd_m));
        let goal_m = plan.target_x_m + skill.depth_sd_m * traits.z();
        let mut chance = traits.into_chance();
        let aim = IntentAim {
            goal_m,
            approach_m: plan.approach_m,
            hold_s: plan.hold_s,
            speed_m_per_s: skill.speed_m_per_s,
            pace: Pace::new(skill.unevenness, &mut chance),
            care: skill.care,
            reaction_s: skill.reaction_s,
            lapses: (0..POPS).fold(0, |bits, pop| bits | u64::from(chance.uniform() < skill.lapse) << pop),
            pause_s: skill.pause_s,
            bone_push_n: skill.bone_push_n,
        };
        let tremor = Tremor::new(skill.tremor_m, &mut chance);
        let doubt = Doubt::new(&skill, goal_m, chance.branch());
        Self {
            entry_m,
            reach_m: plan.reach_m,
            hand: Hand::new(&skill, entry_m.coords - lean.axis * plan.approach_m),
            lean,
            grip: Grip::new(skill.stiffness_n_per_m, skill.brace_n_per_m),
            intent: Intent::new(aim),
            doubt,
            shake_m: tremor.at(0.0),
            tremor,
            t_s: 0.0,
            skill,
            chance,
        }
    }

    /// The motion before any time has passed.
    pub fn start(&self) -> Motion {
        self.motion(false, false)
    }

    pub fn advance(&mut self, dt_s: f64, felt: &Felt) -> Motion {
        let x_m = self.along(&self.hand.position_m);
        let tip_x_m = self.along(&(self.hand.position_m + self.shake_m));
        let push_n = -felt.force_n.dot(&self.lean.axis);
        self.t_s += dt_s;
        let slackening = self.grip.follow(dt_s, push_n);
        self.intent.keep_push(x_m, slackening);
        let stiffness_n_per_m = self.grip.stiffness_n_per_m;
        let bone_n = felt.bone_n;
        let (hesitates, abandons) = (self.doubt.hesitates(x_m), self.doubt.abandons(x_m, &self.lean));
        let sensed = Sensed { dt_s, x_m, tip_x_m, force_n: push_n, bone_n, stiffness_n_per_m, hesitates, abandons };
        let act = self.intent.act(&sensed);
        act.turned.into_iter().for_each(|share| self.turn(share));
        self.hand.grip(stiffness_n_per_m);
        self.move_hand(dt_s, &act, &felt.force_n);
        self.shake_m = self.tremor.at(self.t_s);
        self.motion(act.confirm, act.done)
    }

    /// Leans the needle towards another line, which is chosen as the turn begins.
    fn turn(&mut self, share: f64) {
        if share <= 0.0 {
            self.doubt.start_insertion();
            self.lean.choose(self.skill.correction, self.skill.redirect_sd_rad(), &mut self.chance);
        }
        self.lean.turn(share);
    }

    /// Moves the hand towards the set-point, as far as the hub allows.
    fn move_hand(&mut self, dt_s: f64, act: &Act, force_n: &Vector3<f64>) {
        let set_point = SetPoint {
            position_m: self.entry_m.coords + self.lean.axis * act.set_point_m,
            velocity_m_per_s: self.lean.axis * act.speed_m_per_s,
        };
        self.hand.step(dt_s, &set_point, force_n);
        let beyond_m = self.along(&self.hand.position_m) - self.reach_m;
        if beyond_m > 0.0 {
            self.hand.stop(&self.lean.axis, beyond_m);
        }
    }

    /// Displacement of a point along the operator's own line, in m.
    fn along(&self, point_m: &Vector3<f64>) -> f64 {
        (point_m - self.entry_m.coords).dot(&self.lean.axis)
    }

    fn motion(&self, confirm: bool, done: bool) -> Motion {
        let shaken_m = self.hand.position_m + self.shake_m;
        // The hub lies on the skin: tremor cannot push it in either.
        let beyond_m = (self.along(&shaken_m) - self.reach_m).max(0.0);
        let tip_m = Point3::from(shaken_m - self.lean.axis * beyond_m);
        Motion { patient_from_needle: needle_pose(&tip_m, &self.lean.axis), confirm, done }
    }
}

/// The planned entry, moved horizontally by `by_m`, in m, at the same height above the skin.
fn move_on_skin(plan: &Plan, by_m: &Vector3<f64>) -> Point3<f64> {
    let (planned_m, moved_m) = (plan.entry_m, plan.entry_m + by_m);
    let [before_m, after_m] = [planned_m, moved_m].map(|place| plan.skin.above(place.x, place.y).z);
    moved_m + Vector3::z() * (after_m - before_m)
}

/// The skill of a person in an attempt.
fn skill_of_person(skill: &Skill, traits: &mut Traits) -> Skill {
    let mean = skill.speed_m_per_s;
    let speed = mean + skill.speed_sd_m_per_s * traits.z();
    let (softest, stiffest) = GRIPS_N_PER_M;
    let grip = skill.stiffness_n_per_m / libm::exp(CLUMSINESS_SD * traits.z());
    let clumsiness = skill.stiffness_n_per_m / grip.max(softest).min(stiffest);
    let misjudgement = libm::pow(clumsiness, JUDGEMENT_EXPONENT);
    Skill {
        speed_m_per_s: speed.max(SPEED_PARTS.0 * mean).min(SPEED_PARTS.1 * mean),
        stiffness_n_per_m: skill.stiffness_n_per_m / clumsiness,
        damping_n_s_per_m: skill.damping_n_s_per_m / libm::sqrt(clumsiness),
        brace_n_per_m: skill.brace_n_per_m / clumsiness,
        reaction_s: (skill.reaction_s + skill.reaction_sd_s * traits.z()).max(MIN_REACTION_S),
        tremor_m: skill.tremor_m * libm::exp(SHAKINESS_SD * traits.z()),
        lapse: skill.lapse * clumsiness,
        angle_sd_rad: skill.angle_sd_rad * clumsiness,
        depth_sd_m: skill.depth_sd_m * clumsiness,
        unevenness: (skill.unevenness * clumsiness).min(MAX_UNEVENNESS),
        judgement_sd_rad: skill.judgement_sd_rad * misjudgement,
        accepted_m: skill.accepted_m * misjudgement,
        ..*skill
    }
}
