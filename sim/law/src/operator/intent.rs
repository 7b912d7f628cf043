//! What the operator wants, tick by tick: approach, insert, react to pops, redirect off bone, settle at the target, hold, confirm, withdraw.
//!
//! The choices below are ours: the literature gives the hand and its reaction time, not a script.

use super::pace::Pace;
use super::pop::PopSense;

/// Speed through the air and out of the body, in m/s, where the insertion is slower.
const TRAVEL_M_PER_S: f64 = 0.010;
/// Distance above the skin at which the insertion speed is taken up, in m.
const SLOW_ABOVE_M: f64 = 0.002;
/// From this far before the goal a careful hand slows down, in m.
const NEAR_M: f64 = 0.006;
/// How many times its reaction time a mind takes that was elsewhere.
const ABSENT: f64 = 2.0;
/// Hardest push, in N: beyond it the set-point waits.
const MAX_PUSH_N: f64 = 25.0;
/// After pushing that hard without getting on for this long, in s, the operator gives up and confirms where the needle is.
const GIVE_UP_S: f64 = 3.0;
/// Depth errors the operator lets be, in m.
const GOOD_ENOUGH_M: f64 = 0.0003;
/// Longest time spent on correcting the depth, in s.
const SETTLE_S: f64 = 6.0;
/// How fast a seen depth error is corrected, per second.
const CORRECTION_PER_S: f64 = 1.5;
/// The set-point has been back at the start for this long, in s: done, wherever the needle hangs.
const STUCK_S: f64 = 3.0;

/// How often the operator redirects off bone before it gives up.
const MAX_REDIRECTS: u32 = 3;
/// How fast a hand lets go of what it pushes on, per second.
const LET_GO_PER_S: f64 = 5.0;
/// Distance above the skin at which a needle is turned, in m: inside, the tissue would hold it.
const CLEAR_M: f64 = 0.003;
/// How long looking again and leaning the needle takes, in s.
const TURN_S: f64 = 1.5;

/// The operator's aims, drawn once for an attempt.
#[derive(Clone, Debug)]
pub(super) struct IntentAim {
    /// Where the operator believes the target to be, in m along the axis.
    pub goal_m: f64,
    pub approach_m: f64,
    pub hold_s: f64,
    pub speed_m_per_s: f64,
    /// How evenly it advances.
    pub pace: Pace,
    /// Part of the speed kept at the goal.
    pub care: f64,
    pub reaction_s: f64,
    /// A bit for each felt pop, from the lowest: the mind is elsewhere. A pop after the last is met awake.
    pub lapses: u64,
    /// Halt after a felt pop, in s.
    pub pause_s: f64,
    /// Push on bone before it is believed, in N.
    pub bone_push_n: f64,
}

impl IntentAim {
    /// Speed of the set-point, in m/s, at a time in s and a displacement in m, both as the operator knows them.
    fn pace_m_per_s(&self, t_s: f64, x_m: f64) -> f64 {
        let near = 1.0 - ((self.goal_m - x_m) / NEAR_M).clamp(0.0, 1.0);
        self.speed_m_per_s * self.pace.at(t_s) * (1.0 - near * (1.0 - self.care))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum IntentPhase {
    Insert,
    /// Off bone and out of the skin.
    Redirect,
    /// Leans the needle anew.
    Turn,
    Settle,
    Hold,
    Withdraw,
    Done,
}

/// What the hand feels and sees in a tick.
#[derive(Clone, Copy)]
pub(super) struct Sensed {
    pub dt_s: f64,
    /// Displacement of the hand, in m: where the tip is, but for the tremor that the eye averages out.
    pub x_m: f64,
    /// Displacement of the tip itself, in m, at which the force was felt.
    pub tip_x_m: f64,
    pub force_n: f64,
    /// How hard bone pushes on the tip, in N.
    pub bone_n: f64,
    /// Stiffness of the grip, in N/m.
    pub stiffness_n_per_m: f64,
}

/// What the operator does in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Act {
    pub set_point_m: f64,
    pub speed_m_per_s: f64,
    /// Share of the turn to another line that is done; 0 in the tick that chooses the line.
    pub turned: Option<f64>,
    pub confirm: bool,
    pub done: bool,
}

/// The operator's mind.
#[derive(Clone, Debug)]
pub(super) struct Intent {
    aim: IntentAim,
    phase: IntentPhase,
    t_s: f64,
    /// When the phase began, in s.
    since_s: f64,
    set_point_m: f64,
    pops: PopSense,
    /// When a reaction takes effect, in s: to a pop, and to having reached the goal.
    halt_at_s: f64,
    stop_at_s: f64,
    /// When the operator reacts to bone, in s.
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

    /// The grip has changed with the hand at `x_m`: the set-point moves so that the push stays. `slackening` is the old stiffness
    /// over the new.
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
        if self.set_point_m - sensed.x_m > MAX_PUSH_N / sensed.stiffness_n_per_m {
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

    /// Whether bone was felt, a reaction time ago.
    fn meets_bone(&mut self, sensed: &Sensed) -> bool {
        if sensed.bone_n >= self.aim.bone_push_n && self.bone_at_s.is_infinite() {
            self.bone_at_s = self.t_s + self.aim.reaction_s;
        }
        self.t_s >= self.bone_at_s
    }

    /// Redirects, or gives up and confirms where the needle is.
    fn leave_bone(&mut self) -> f64 {
        let gives_up = self.redirects >= MAX_REDIRECTS;
        self.stop_at_s = f64::INFINITY;
        self.turn_to(if gives_up { IntentPhase::Hold } else { IntentPhase::Redirect });
        0.0
    }

    /// Draws the needle out of the skin.
    fn redirect(&mut self, sensed: &Sensed) -> f64 {
        if sensed.x_m > -CLEAR_M {
            return self.let_go_m_per_s(sensed) - self.travel_m_per_s();
        }
        self.redirects += 1;
        self.turn_to(IntentPhase::Turn);
        0.0
    }

    /// Speed of a set-point that gives up its push, in m/s.
    fn let_go_m_per_s(&self, sensed: &Sensed) -> f64 {
        (LET_GO_PER_S * (sensed.x_m - self.set_point_m)).min(0.0)
    }

    /// Waits until the needle leans as it is to, and begins anew.
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

    /// Time to react to the pop that was just felt, in s.
    fn react_s(&mut self) -> f64 {
        let absent = self.aim.lapses & 1 == 1;
        self.aim.lapses >>= 1;
        if absent { ABSENT * self.aim.reaction_s } else { self.aim.reaction_s }
    }

    /// Whether the operator stands still after a pop; the reaction is forgotten when the pause is over.
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

    /// Speed that takes away an error of depth, in m/s.
    fn correct(&self, error_m: f64) -> f64 {
        let limit = 0.5 * self.aim.speed_m_per_s;
        (CORRECTION_PER_S * error_m).max(-limit).min(limit)
    }

    /// Stays at the goal: a hand that still pushed when it arrived would creep on. One that gave up on the way stays where it is, and
    /// lets go of bone.
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
