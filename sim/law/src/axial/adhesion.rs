//! Static and kinetic friction: selects the cap of the presliding spring.
//!
//! The cap is Σ c_s l until the spring has slid by the breakaway length, in either direction, then
//! Σ c l. It is Σ c_s l again after a rest without sliding, and after the needle has moved
//! backwards by the same length from where it had slid to. The criterion is slid length and not
//! speed, so an encoder's steps do not switch between the two.

use serde::{Deserialize, Serialize};

use super::options::Breakaway;
use super::springs::{SpringTick, SpringWork};

/// State between static and kinetic friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Adhesion {
    /// Whether the shaft has broken away: friction is kinetic.
    is_broken: bool,
    /// Whether it broke away, or last slid in that direction, while moving into the body.
    inwards: bool,
    /// Before breakaway, the length slid, in m; after it, the distance moved back, in m.
    way_m: f64,
    /// Time without sliding, in s.
    still_s: f64,
}

/// The caps of friction at a depth, in N.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrictionCaps {
    pub kinetic_n: f64,
    pub static_n: f64,
}

/// The presliding spring of friction over a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrictionTick {
    pub stiffness_n_per_m: f64,
    pub before_n: f64,
    pub dx_m: f64,
    pub dt_s: f64,
    pub caps: FrictionCaps,
}

/// Result of friction in a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slid {
    pub force_n: f64,
    pub work: SpringWork,
    pub adhesion: Adhesion,
}

/// A spring under one cap: its force and work, and the sliding of its far end over the tissue, in
/// m, including that by a shrinking cap.
struct Capped {
    force_n: f64,
    work: SpringWork,
    way_m: f64,
}

impl FrictionTick {
    /// F ← clip(F + k Δx, ± cap).
    fn cap(&self, cap_n: f64) -> Capped {
        let Self { stiffness_n_per_m, before_n, dx_m, .. } = *self;
        let trial_n = before_n + stiffness_n_per_m * dx_m;
        let after_n = trial_n.max(-cap_n).min(cap_n);
        // A spring that its cap never stopped has only been stretched, for any previous cap.
        let kept_n = if trial_n.abs() <= cap_n { before_n } else { before_n.max(-cap_n).min(cap_n) };
        let slid_m = if trial_n.abs() <= cap_n { 0.0 } else { dx_m - (after_n - kept_n) / stiffness_n_per_m };
        let work = SpringTick { stiffness_n_per_m, before_n, kept_n, after_n, slid_m }.integrate();
        Capped { force_n: after_n, work, way_m: (trial_n - after_n) / stiffness_n_per_m }
    }

    /// Slides under the kinetic cap alone, as in version 2.
    pub fn slide(&self) -> Slid {
        let Capped { force_n, work, .. } = self.cap(self.caps.kinetic_n);
        Slid { force_n, work, adhesion: Adhesion::default() }
    }

    /// Slides under the cap of the shaft's adhesion.
    pub fn slide_with(&self, breakaway: &Breakaway, adhesion: Adhesion) -> Slid {
        if self.caps.static_n <= 0.0 {
            // Nothing is inserted, or there is no friction.
            return self.slide();
        }
        let adhesion = adhesion.turned(self.dx_m, breakaway);
        if adhesion.is_broken {
            let Capped { force_n, work, way_m } = self.cap(self.caps.kinetic_n);
            return Slid { force_n, work, adhesion: adhesion.after(way_m, self.dt_s, breakaway) };
        }
        let Capped { force_n, work, way_m } = self.cap(self.caps.static_n);
        let left_m = breakaway.slid_m - adhesion.way_m;
        if way_m.abs() < left_m {
            let held = Adhesion { way_m: adhesion.way_m + way_m.abs(), ..adhesion };
            return Slid { force_n, work, adhesion: held.after(way_m, self.dt_s, breakaway) };
        }
        self.break_away(left_m.max(0.0), way_m)
    }

    /// Slides at the static cap for the rest of the breakaway length, drops the force to the
    /// kinetic cap, and slides on.
    fn break_away(&self, left_m: f64, way_m: f64) -> Slid {
        let direction = if way_m < 0.0 { -1.0 } else { 1.0 };
        let rest_m = direction * (way_m.abs() - left_m).min(self.dx_m.abs());
        let until = FrictionTick { dx_m: self.dx_m - rest_m, ..*self }.cap(self.caps.static_n);
        let beyond = FrictionTick { before_n: until.force_n, dx_m: rest_m, ..*self }.cap(self.caps.kinetic_n);
        let work = SpringWork {
            work_j: until.work.work_j + beyond.work.work_j,
            lost_j: until.work.lost_j + beyond.work.lost_j,
        };
        let adhesion = Adhesion { is_broken: true, inwards: direction > 0.0, way_m: 0.0, still_s: 0.0 };
        Slid { force_n: beyond.force_n, work, adhesion }
    }
}

impl Adhesion {
    /// State after travel: moving back by the breakaway length restores static friction.
    fn turned(self, dx_m: f64, breakaway: &Breakaway) -> Self {
        if !self.is_broken {
            return self;
        }
        let back_m = if self.inwards { -dx_m } else { dx_m };
        let way_m = (self.way_m + back_m).max(0.0);
        if way_m >= breakaway.slid_m { Self::default() } else { Self { way_m, ..self } }
    }

    /// State after a tick with this sliding: rest restores static friction.
    fn after(self, way_m: f64, dt_s: f64, breakaway: &Breakaway) -> Self {
        let still_s = if way_m == 0.0 { self.still_s + dt_s } else { 0.0 };
        if still_s >= breakaway.rest_s { Self::default() } else { Self { still_s, ..self } }
    }
}
