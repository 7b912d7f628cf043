//! Maxwell branches parallel to a tent: the force decay of a held needle.
//!
//! Each branch is a spring g k in series with a dashpot of time τ ([`super::maxwell`]). If a
//! contactor touches or leaves a boundary within a tick, the branch acts for its part of the tick.
//!
//! A tip that retracts faster than the tissue follows would be pulled by branches that have
//! relaxed. Tissue does not stick to a needle: if spring and branches together would pull, the
//! pulling branches are reduced so that the force is 0, and their stored energy is lost. A
//! contactor without a tent has no branches.

use serde::{Deserialize, Serialize};

use super::maxwell::Stretch;
use super::options::{MAX_BRANCHES, MaxwellBranch};
use super::state::Contactor;

/// The branches of one tent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Branches {
    /// Force q of each, in N; 0 for unused entries.
    pub forces_n: [f64; MAX_BRANCHES],
}

/// The branches of the tents of both contactors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct HeldBranches {
    pub tip: Branches,
    pub rim: Branches,
}

/// A boundary with branches, and its stiffness under the needle, in N/m.
#[derive(Clone, Copy, Debug)]
pub(super) struct BranchedBoundary<'a> {
    pub branches: &'a [MaxwellBranch],
    pub stiffness_n_per_m: f64,
}

/// Motion of a tent in a tick: its deflections in m and its spring's force in N at the end.
#[derive(Clone, Copy, Debug)]
pub(super) struct TentMotion {
    pub from_m: f64,
    pub to_m: f64,
    /// Displacement of the needle, in m: more than that of the tent if it is touched or left within
    /// the tick.
    pub dx_m: f64,
    pub dt_s: f64,
    pub spring_n: f64,
}

impl Branches {
    /// Total force, in N.
    pub fn force_n(&self) -> f64 {
        self.forces_n.iter().sum()
    }

    /// Energy stored by all branches of a boundary of stiffness k, Σ q²/(2 g k), in J.
    pub fn stored_j(&self, beside: &BranchedBoundary<'_>) -> f64 {
        let stored_j = |(branch, q): (&MaxwellBranch, &f64)| q * q / (2.0 * branch.share * beside.stiffness_n_per_m);
        beside.branches.iter().zip(&self.forces_n).map(stored_j).sum()
    }

    /// Advances by a tick; returns the loss of the dashpots, in J, never negative.
    pub fn relax(&mut self, beside: &BranchedBoundary<'_>, motion: &TentMotion) -> f64 {
        if beside.branches.is_empty() || (motion.from_m <= 0.0 && motion.to_m <= 0.0) {
            *self = Self::default();
            return 0.0;
        }
        let dent_m = motion.to_m - motion.from_m;
        let touches = motion.from_m <= 0.0 || motion.to_m <= 0.0;
        let part = if touches && motion.dx_m != 0.0 { (dent_m / motion.dx_m).abs().min(1.0) } else { 1.0 };
        let mut lost_j = 0.0;
        for (branch, q) in beside.branches.iter().zip(&mut self.forces_n) {
            let stiffness = branch.share * beside.stiffness_n_per_m;
            lost_j += Stretch { way_m: dent_m, delta: motion.dt_s * part / branch.time_s }.relax(q, stiffness);
        }
        lost_j + self.let_go(beside, motion)
    }

    /// Removes the part that would pull the contactor; returns its stored energy, in J.
    fn let_go(&mut self, beside: &BranchedBoundary<'_>, motion: &TentMotion) -> f64 {
        let before_j = self.stored_j(beside);
        if motion.to_m <= 0.0 {
            *self = Self::default();
            return before_j;
        }
        let total_n = motion.spring_n + self.force_n();
        if total_n >= 0.0 {
            return 0.0;
        }
        let pulling_n: f64 = self.forces_n.iter().map(|q| q.min(0.0)).sum();
        // The remaining fraction of the pulling forces is the pull minus its excess: total_n is
        // negative, and no more so than pulling_n.
        let kept = ((pulling_n - total_n) / pulling_n).clamp(0.0, 1.0);
        for q in self.forces_n.iter_mut().filter(|q| **q < 0.0) {
            *q *= kept;
        }
        (before_j - self.stored_j(beside)).max(0.0)
    }
}

/// Result of a tick for the branches of one tent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RelaxedTent {
    /// Index of the boundary.
    pub boundary: usize,
    /// Their stored energy, in J.
    pub stored_j: f64,
    /// Their loss in the tick before its ruptures, in J.
    pub lost_j: f64,
}

/// Result of a tick for the branches of both tents.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RelaxedTents {
    pub held: HeldBranches,
    pub tip: RelaxedTent,
    pub rim: RelaxedTent,
}

impl RelaxedTents {
    /// Total stored energy, in J.
    pub fn stored_j(&self) -> f64 {
        self.tip.stored_j + self.rim.stored_j
    }

    /// Total loss, in J.
    pub fn lost_j(&self) -> f64 {
        self.tip.lost_j + self.rim.lost_j
    }

    /// Clears the branches of a contactor at a rupture. The next boundary was dented slowly, or
    /// long ago: its branches have relaxed.
    pub fn give_way(&mut self, contactor: Contactor) {
        match contactor {
            Contactor::Tip => {
                self.held.tip = Branches::default();
                self.tip.stored_j = 0.0;
            }
            Contactor::Rim => {
                self.held.rim = Branches::default();
                self.rim.stored_j = 0.0;
            }
        }
    }
}

impl HeldBranches {
    /// The branches of a contactor.
    pub fn of(&self, contactor: Contactor) -> &Branches {
        match contactor {
            Contactor::Tip => &self.tip,
            Contactor::Rim => &self.rim,
        }
    }
}
