//! What the operator wants, tick by tick: approach, insert, react to pops, settle at the target, hold, confirm, withdraw.
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
    /// Stiffness of the grip, in N/m.
    pub stiffness_n_per_m: f64,
}

/// What the operator does in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Act {
    pub set_point_m: f64,
    pub speed_m_per_s: f64,
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
            stalled_s: 0.0,
        }
    }

    pub fn act(&mut self, sensed: &Sensed) -> Act {
        self.t_s += sensed.dt_s;
        let phase = self.phase;
        let speed_m_per_s = match phase {
            IntentPhase::Insert => self.insert(sensed),
            IntentPhase::Settle => self.settle(sensed),
            IntentPhase::Hold => self.hold(sensed),
            IntentPhase::Withdraw => self.withdraw(sensed),
            IntentPhase::Done => 0.0,
        };
        self.set_point_m += speed_m_per_s * sensed.dt_s;
        Act {
            set_point_m: self.set_point_m,
            speed_m_per_s,
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

    /// Stays at the goal: a hand that still pushed when it arrived would creep on. One that gave up on the way stays where it is.
    fn hold(&mut self, sensed: &Sensed) -> f64 {
        if self.t_s - self.since_s >= self.aim.hold_s {
            self.turn_to(IntentPhase::Withdraw);
        }
        if self.stop_at_s.is_finite() { self.correct(self.aim.goal_m - sensed.x_m) } else { 0.0 }
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
