//! The operator's intention, tick by tick: approach, insert, react to pops, redirect off bone or in
//! doubt, settle at the target, hold, confirm, withdraw.
//!
//! The choices below are ours: the literature gives the hand and its reaction time, not a script.

use super::pace::Pace;
use super::pop::PopSense;

/// Speed in the air and while withdrawing, in m/s, if the insertion is slower.
const TRAVEL_M_PER_S: f64 = 0.010;
/// Height above the skin at which the insertion speed begins, in m.
const SLOW_ABOVE_M: f64 = 0.002;
/// Distance before the goal at which a careful hand slows down, in m.
const NEAR_M: f64 = 0.006;
/// Factor on the reaction time during a lapse of attention (choice, fitted to dural punctures).
const ABSENT: f64 = 4.0;
/// Hardest push, in N: above it the set-point waits. A choice above the 62 N that a trocar took in
/// patients (Fanning et al. 2011, 10.4293/108680811X13022985131219).
const MAX_PUSH_N: f64 = 80.0;
/// Hardest push beyond the force that the hand feels, in N, for example with the hub on the skin:
/// above it the set-point waits (choice).
const MAX_UNFELT_N: f64 = 25.0;
/// Duration of such a push without progress, in s, after which the operator gives up and confirms
/// at the present position.
const GIVE_UP_S: f64 = 3.0;
/// Depth error that the operator accepts, in m.
const GOOD_ENOUGH_M: f64 = 0.0003;
/// Maximum time spent on correcting the depth, in s.
const SETTLE_S: f64 = 6.0;
/// Rate at which a visible depth error is corrected, per second.
const CORRECTION_PER_S: f64 = 1.5;
/// Time after which an operator whose set-point is back at the start is done, in s, at any position
/// of the needle.
const STUCK_S: f64 = 3.0;

/// Maximum number of redirections off bone before the operator gives up.
const MAX_REDIRECTS: u32 = 3;
/// Rate at which a hand releases its push, per second.
const LET_GO_PER_S: f64 = 5.0;
/// Height above the skin at which a needle is turned, in m: inside, the tissue would hold it.
const CLEAR_M: f64 = 0.003;
/// Duration of re-aiming and turning the needle, in s.
const TURN_S: f64 = 1.5;

/// The operator's aims, drawn once for an attempt.
#[derive(Clone, Debug)]
pub(super) struct IntentAim {
    /// Depth of the target as estimated by the operator, in m along the axis.
    pub goal_m: f64,
    pub approach_m: f64,
    pub hold_s: f64,
    pub speed_m_per_s: f64,
    /// Modulation of the speed.
    pub pace: Pace,
    /// Fraction of the speed kept at the goal.
    pub care: f64,
    pub reaction_s: f64,
    /// One bit for each felt pop, from the lowest: a lapse of attention. No lapses after the last
    /// bit.
    pub lapses: u64,
    /// Halt after a felt pop, in s.
    pub pause_s: f64,
    /// Push on bone before it is recognised, in N.
    pub bone_push_n: f64,
}

impl IntentAim {
    /// Speed of the set-point, in m/s, at a time in s and a displacement in m, both as the operator
    /// perceives them.
    fn pace_m_per_s(&self, t_s: f64, x_m: f64) -> f64 {
        let near = 1.0 - ((self.goal_m - x_m) / NEAR_M).clamp(0.0, 1.0);
        self.speed_m_per_s * self.pace.at(t_s) * (1.0 - near * (1.0 - self.care))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum IntentPhase {
    Insert,
    /// Withdraws the needle from the skin.
    Redirect,
    /// Turns the needle to a new line.
    Turn,
    Settle,
    Hold,
    Withdraw,
    Done,
}

/// Perceptions of the hand and the eye in a tick.
#[derive(Clone, Copy)]
pub(super) struct Sensed {
    pub dt_s: f64,
    /// Displacement of the hand, in m: that of the tip without the tremor, which the eye averages
    /// out.
    pub x_m: f64,
    /// Displacement of the tip itself, in m, at which the force was felt.
    pub tip_x_m: f64,
    pub force_n: f64,
    /// Push of bone on the tip, in N.
    pub bone_n: f64,
    /// Stiffness of the grip, in N/m.
    pub stiffness_n_per_m: f64,
    /// Whether the operator hesitates in this tick.
    pub hesitates: bool,
    /// Whether the operator abandons its line in this tick.
    pub abandons: bool,
}

/// Actions of the operator in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Act {
    pub set_point_m: f64,
    pub speed_m_per_s: f64,
    /// Completed fraction of the turn to another line; 0 in the tick that chooses the line.
    pub turned: Option<f64>,
    pub confirm: bool,
    pub done: bool,
}

/// The operator's state of mind.
#[derive(Clone, Debug)]
pub(super) struct Intent {
    aim: IntentAim,
    phase: IntentPhase,
    t_s: f64,
    /// Start of the phase, in s.
    since_s: f64,
    set_point_m: f64,
    pops: PopSense,
    /// Time at which a reaction takes effect, in s: to a pop, and to reaching the goal.
    halt_at_s: f64,
    stop_at_s: f64,
    /// Time at which the operator reacts to bone, in s.
    bone_at_s: f64,
    redirects: u32,
    stalled_s: f64,
}

impl Intent {
    pub fn new(aim: IntentAim) -> Self {
        Self {
            set_point_m: -aim.approach_m,
            aim,
            phase: IntentPhase::Insert,
            t_s: 0.0,
            since_s: 0.0,
            pops: PopSense::new(),
            halt_at_s: f64::INFINITY,
            stop_at_s: f64::INFINITY,
            bone_at_s: f64::INFINITY,
            redirects: 0,
            stalled_s: 0.0,
        }
    }

    pub fn act(&mut self, sensed: &Sensed) -> Act {
        self.t_s += sensed.dt_s;
        let phase = self.phase;
        let speed_m_per_s = match phase {
            IntentPhase::Insert | IntentPhase::Settle if self.meets_bone(sensed) => self.leave_bone(),
            IntentPhase::Insert if sensed.abandons => self.withdraw_to_turn(),
            IntentPhase::Insert => self.insert(sensed),
            IntentPhase::Redirect => self.redirect(sensed),
            IntentPhase::Turn => self.turn(),
            IntentPhase::Settle => self.settle(sensed),
            IntentPhase::Hold => self.hold(sensed),
            IntentPhase::Withdraw => self.withdraw(sensed),
            IntentPhase::Done => 0.0,
        };
        self.set_point_m += speed_m_per_s * sensed.dt_s;
        Act {
            set_point_m: self.set_point_m,
            speed_m_per_s,
            turned: self.turned(),
            confirm: phase == IntentPhase::Hold && self.phase == IntentPhase::Withdraw,
            done: self.phase == IntentPhase::Done,
        }
    }

    /// Moves the set-point so that the push stays constant after a change of the grip, with the
    /// hand at `x_m`. `slackening` is the old stiffness divided by the new.
    pub fn keep_push(&mut self, x_m: f64, slackening: f64) {
        self.set_point_m = x_m + (self.set_point_m - x_m) * slackening;
    }

    fn turn_to(&mut self, phase: IntentPhase) {
        self.phase = phase;
        self.since_s = self.t_s;
    }

    fn travel_m_per_s(&self) -> f64 {
        self.aim.speed_m_per_s.max(TRAVEL_M_PER_S)
    }

    fn insert(&mut self, sensed: &Sensed) -> f64 {
        if self.pops.feel(self.t_s, sensed.force_n, sensed.tip_x_m) && self.halt_at_s.is_infinite() {
            self.halt_at_s = self.t_s + self.react_s();
        }
        if sensed.hesitates && self.halt_at_s.is_infinite() {
            self.halt_at_s = self.t_s;
        }
        if sensed.x_m >= self.aim.goal_m && self.stop_at_s.is_infinite() {
            self.stop_at_s = self.t_s + self.aim.reaction_s;
        }
        if self.t_s >= self.stop_at_s {
            self.turn_to(IntentPhase::Settle);
            return 0.0;
        }
        if self.halted() {
            return 0.0;
        }
        let push_n = (self.set_point_m - sensed.x_m) * sensed.stiffness_n_per_m;
        if push_n > MAX_PUSH_N.min(MAX_UNFELT_N + sensed.force_n.max(0.0)) {
            self.stalled_s += sensed.dt_s;
            if self.stalled_s > GIVE_UP_S {
                self.turn_to(IntentPhase::Hold);
            }
            return 0.0;
        }
        self.stalled_s = 0.0;
        if self.set_point_m < -SLOW_ABOVE_M {
            return self.travel_m_per_s();
        }
        self.aim.pace_m_per_s(self.t_s, sensed.x_m)
    }

    /// Whether bone was felt at least one reaction time ago.
    fn meets_bone(&mut self, sensed: &Sensed) -> bool {
        if sensed.bone_n >= self.aim.bone_push_n && self.bone_at_s.is_infinite() {
            self.bone_at_s = self.t_s + self.aim.reaction_s;
        }
        self.t_s >= self.bone_at_s
    }

    /// Redirects, or gives up and confirms at the present position.
    fn leave_bone(&mut self) -> f64 {
        if self.redirects < MAX_REDIRECTS {
            self.redirects += 1;
            return self.withdraw_to_turn();
        }
        self.stop_at_s = f64::INFINITY;
        self.turn_to(IntentPhase::Hold);
        0.0
    }

    /// Begins to withdraw the needle, to turn it outside.
    fn withdraw_to_turn(&mut self) -> f64 {
        self.stop_at_s = f64::INFINITY;
        self.turn_to(IntentPhase::Redirect);
        0.0
    }

    /// Withdraws the needle from the skin.
    fn redirect(&mut self, sensed: &Sensed) -> f64 {
        if sensed.x_m > -CLEAR_M {
            return self.let_go_m_per_s(sensed) - self.travel_m_per_s();
        }
        self.turn_to(IntentPhase::Turn);
        0.0
    }

    /// Speed of a set-point that releases its push, in m/s.
    fn let_go_m_per_s(&self, sensed: &Sensed) -> f64 {
        (LET_GO_PER_S * (sensed.x_m - self.set_point_m)).min(0.0)
    }

    /// Waits for the end of the turn, and starts the insertion again.
    fn turn(&mut self) -> f64 {
        if self.t_s - self.since_s >= TURN_S {
            self.pops = PopSense::new();
            (self.halt_at_s, self.bone_at_s, self.stalled_s) = (f64::INFINITY, f64::INFINITY, 0.0);
            self.turn_to(IntentPhase::Insert);
        }
        0.0
    }

    fn turned(&self) -> Option<f64> {
        (self.phase == IntentPhase::Turn).then(|| ((self.t_s - self.since_s) / TURN_S).min(1.0))
    }

    /// Reaction time to the pop that was just felt, in s.
    fn react_s(&mut self) -> f64 {
        let absent = self.aim.lapses & 1 == 1;
        self.aim.lapses >>= 1;
        if absent { ABSENT * self.aim.reaction_s } else { self.aim.reaction_s }
    }

    /// Whether the operator pauses after a pop; clears the reaction when the pause is over.
    fn halted(&mut self) -> bool {
        let since_halt_s = self.t_s - self.halt_at_s;
        if since_halt_s >= self.aim.pause_s {
            self.halt_at_s = f64::INFINITY;
        }
        (0.0..self.aim.pause_s).contains(&since_halt_s)
    }

    fn settle(&mut self, sensed: &Sensed) -> f64 {
        let error_m = self.aim.goal_m - sensed.x_m;
        if error_m.abs() < GOOD_ENOUGH_M || self.t_s - self.since_s > SETTLE_S {
            self.turn_to(IntentPhase::Hold);
            return 0.0;
        }
        self.correct(error_m)
    }

    /// Speed that corrects a depth error, in m/s.
    fn correct(&self, error_m: f64) -> f64 {
        let limit = 0.5 * self.aim.speed_m_per_s;
        (CORRECTION_PER_S * error_m).max(-limit).min(limit)
    }

    /// Stays at the goal: a hand that still pushed on arrival would creep on. An operator that gave
    /// up stays at its position, and releases bone.
    fn hold(&mut self, sensed: &Sensed) -> f64 {
        if self.t_s - self.since_s >= self.aim.hold_s {
            self.turn_to(IntentPhase::Withdraw);
        }
        match (self.stop_at_s.is_finite(), self.bone_at_s.is_finite()) {
            (true, _) => self.correct(self.aim.goal_m - sensed.x_m),
            (false, true) => self.let_go_m_per_s(sensed),
            (false, false) => 0.0,
        }
    }

    fn withdraw(&mut self, sensed: &Sensed) -> f64 {
        if self.set_point_m > -self.aim.approach_m {
            self.since_s = self.t_s;
            return -self.travel_m_per_s();
        }
        let back = sensed.x_m <= -self.aim.approach_m + 2.0 * GOOD_ENOUGH_M;
        if back || self.t_s - self.since_s > STUCK_S {
            self.turn_to(IntentPhase::Done);
        }
        0.0
    }
}
