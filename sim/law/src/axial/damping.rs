//! Damping along the shaft from version 5 of the law: a dashpot B = Σ b_j l_j in series with a
//! spring B/τ, a Maxwell element.
//!
//! Speed over a window lags by half of it, and a lagging force drives a free handle above 1/(2 T).
//! This force depends on displacement only, and an element of a spring and a dashpot never returns
//! more than its spring stores, q²τ/(2 B). τ keeps the effect of an encoder's steps small.
//!
//! B changes with the inserted length at the start of a tick. If it grows, the force q is kept; if
//! it shrinks, the strain q τ/B: both lose energy, and so does the stored energy when the needle
//! leaves.

use super::maxwell::Stretch;
use super::springs::SpringWork;

/// The element over a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct DampingTick {
    /// τ, in s; 0 for a dashpot alone.
    pub time_s: f64,
    /// Force at the last tick, in N.
    pub before_n: f64,
    /// B at the last tick and at this one, in N·s/m.
    pub from_n_s_per_m: f64,
    pub to_n_s_per_m: f64,
    pub dx_m: f64,
    pub dt_s: f64,
}

/// Result of the element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Damped {
    pub force_n: f64,
    pub stored_j: f64,
    pub work: SpringWork,
}

impl DampingTick {
    /// Force, stored energy, work and loss at the end of the tick.
    pub fn advance(&self) -> Damped {
        let Self { time_s, before_n, from_n_s_per_m, to_n_s_per_m, dx_m, dt_s } = *self;
        let before_j = stored_j(time_s, from_n_s_per_m, before_n);
        if to_n_s_per_m <= 0.0 {
            return Damped { force_n: 0.0, stored_j: 0.0, work: SpringWork { work_j: 0.0, lost_j: before_j } };
        }
        if time_s <= 0.0 {
            let force_n = if dt_s > 0.0 { to_n_s_per_m * (dx_m / dt_s) } else { 0.0 };
            let work_j = force_n * dx_m;
            return Damped { force_n, stored_j: 0.0, work: SpringWork { work_j, lost_j: work_j } };
        }
        let shrinks = to_n_s_per_m < from_n_s_per_m;
        let mut force_n = if shrinks { before_n * (to_n_s_per_m / from_n_s_per_m) } else { before_n };
        let changed_j = before_j - stored_j(time_s, to_n_s_per_m, force_n);
        let relaxed_j = Stretch { way_m: dx_m, delta: dt_s / time_s }.relax(&mut force_n, to_n_s_per_m / time_s);
        // The floor removes round-off.
        let lost_j = changed_j.max(0.0) + relaxed_j;
        let stored_j = stored_j(time_s, to_n_s_per_m, force_n);
        Damped { force_n, stored_j, work: SpringWork { work_j: stored_j - before_j + lost_j, lost_j } }
    }
}

/// q²τ/(2 B), in J.
fn stored_j(time_s: f64, damping_n_s_per_m: f64, force_n: f64) -> f64 {
    if damping_n_s_per_m > 0.0 { force_n * force_n * time_s / (2.0 * damping_n_s_per_m) } else { 0.0 }
}
