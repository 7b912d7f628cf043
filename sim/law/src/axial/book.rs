//! Books a tick into the energy ledger.
//!
//! The hand's work in a tick is the change of elastic energy before the ruptures, the exact work on
//! the presliding springs ([`super::springs`]), and viscous force times Δx or, from version 5, the
//! exact work on the damping's spring and dashpot ([`super::damping`]). Every joule of it is booked
//! once, so the ledger closes to round-off by construction; the tests establish that each part is a
//! dissipation, agrees with ∫F dx and does not depend on the tick.
//!
//! Up to version 4 viscous force follows speed over a window, so that for a tick within one window
//! after a reversal it may push with the motion. The energy that it returns is subtracted from its
//! layers' loss and counted separately, in [`Ledger::lagged_j`].
//!
//! Choices. Elastic and rupture energy belong to the layer whose boundary is tented or opened.
//! Viscous and friction losses are distributed by b_j l_j and by the friction cap, c_j l_j or its
//! static value; the loss by relaxation is viscous, and belongs to the layer whose boundary is
//! tented. Cutting belongs to the layer that contains the tip, or contained it in the previous
//! tick.

use super::params::{AxialParams, Layer};
use super::path::{Open, Path};
use super::relaxation::{RelaxedTent, RelaxedTents};
use super::springs::SpringWork;
use super::state::{AxialOutput, AxialScratch, AxialState, Rupture};
use crate::ledger::{LayerEnergy, Ledger};

/// The energies of a tick.
pub(super) struct BookedTick<'a> {
    pub open: Open,
    pub x_m: f64,
    /// Change of the elastic energy before the ruptures plus the loss of the branches, in J.
    pub elastic_work_j: f64,
    /// The branches after the ruptures.
    pub relaxed: &'a RelaxedTents,
    pub before: AxialOutput,
    pub after: AxialOutput,
    /// Work and loss of damping, friction and cutting.
    pub viscous: SpringWork,
    pub friction: SpringWork,
    pub cutting: SpringWork,
    /// Energy stored now by the springs of friction, cutting and damping, in J.
    pub presliding_j: f64,
}

pub(super) fn book_tick(ledger: &mut Ledger, path: &Path<'_>, tick: &BookedTick<'_>, ruptures: &[Rupture]) {
    book_work(ledger, tick.elastic_work_j + tick.viscous.work_j + tick.friction.work_j + tick.cutting.work_j);
    book_ruptures(ledger, ruptures);
    book_elastic(ledger, path, tick);
    ledger.presliding_j = tick.presliding_j;
    let before_m = tick.before.depth_m;
    let along = |total_j, part| Share { depth_m: tick.after.depth_m, total_j, part };
    book_along(ledger, path, &along(tick.friction.lost_j, FRICTION), before_m);
    book_cutting(ledger, path, tick);
    ledger.lagged_j += (-tick.viscous.lost_j).max(0.0);
    book_along(ledger, path, &along(tick.viscous.lost_j, VISCOUS), before_m);
}

fn book_work(ledger: &mut Ledger, work_j: f64) {
    if work_j > 0.0 {
        ledger.input_j += work_j;
    } else {
        ledger.returned_j -= work_j;
    }
}

/// Books the tick's drop of elastic energy, for a cascade as a whole.
///
/// Within a cascade a member may raise the energy, because the tick evaluates all of them at its
/// end and the next boundary is by then tented deeper than the ruptured one. The rises are paid by
/// the falls in proportion. An unpaid rest (a coarse tick over an unsound boundary) is work that
/// the hand would have done on the way: it is booked as input, so that a dissipation never
/// decreases.
fn book_ruptures(ledger: &mut Ledger, ruptures: &[Rupture]) {
    if ruptures.is_empty() {
        return;
    }
    let (mut falls_j, mut rises_j) = (0.0, 0.0);
    for rupture in ruptures {
        falls_j += rupture.dissipated_j.max(0.0);
        rises_j += (-rupture.dissipated_j).max(0.0);
    }
    let kept = if falls_j > rises_j { (falls_j - rises_j) / falls_j } else { 0.0 };
    for rupture in ruptures {
        if let Some(entry) = ledger.layers.get_mut(rupture.boundary) {
            entry.rupture_j += rupture.dissipated_j.max(0.0) * kept;
        }
    }
    ledger.input_j += (rises_j - falls_j).max(0.0);
}

/// Books the energy stored by springs and branches, and the loss of the branches' dashpots as
/// viscosity.
fn book_elastic(ledger: &mut Ledger, path: &Path<'_>, tick: &BookedTick<'_>) {
    for entry in &mut ledger.layers {
        entry.elastic_j = 0.0;
    }
    let tents = [(tick.open.tip, path.tip(tick.open, tick.x_m)), (tick.open.rim, path.rim(tick.open, tick.x_m))];
    for (boundary, tent) in tents {
        if let Some(entry) = ledger.layers.get_mut(boundary) {
            entry.elastic_j += tent.energy_j;
        }
    }
    for &RelaxedTent { boundary, stored_j, lost_j } in [&tick.relaxed.tip, &tick.relaxed.rim] {
        // After a rupture nothing is stored, and an earlier loss belongs to the boundary that was
        // tented.
        if let Some(entry) = ledger.layers.get_mut(boundary) {
            entry.elastic_j += stored_j;
            entry.viscous_j += lost_j;
        }
    }
}

/// Books a loss along the shaft. When the needle leaves completely, nothing is inserted any more
/// and the loss is distributed as in the previous tick.
fn book_along(ledger: &mut Ledger, path: &Path<'_>, here: &Share, before_m: f64) {
    if !book_share(ledger, path, here) {
        book_share(ledger, path, &Share { depth_m: before_m, ..*here });
    }
}

fn book_cutting(ledger: &mut Ledger, path: &Path<'_>, tick: &BookedTick<'_>) {
    let layer = path.layer_at(tick.after.depth_m).or_else(|| path.layer_at(tick.before.depth_m));
    if let Some(entry) = layer.and_then(|layer| ledger.layers.get_mut(layer)) {
        entry.cutting_j += tick.cutting.lost_j;
    }
}

/// A loss distributed among the layers by coefficient × inserted length.
struct Share {
    depth_m: f64,
    total_j: f64,
    part: Part,
}

/// The weighting coefficient, and the entry to book.
#[derive(Clone, Copy)]
struct Part {
    coefficient: fn(&Layer) -> f64,
    entry: fn(&mut LayerEnergy) -> &mut f64,
}

const VISCOUS: Part = Part { coefficient: |layer| layer.damping_n_s_per_m2, entry: |energy| &mut energy.viscous_j };
const FRICTION: Part = Part { coefficient: Layer::static_friction_n_per_m, entry: |energy| &mut energy.friction_j };

const LATERAL: Part = Part { coefficient: |_| 1.0, entry: |energy| &mut energy.lateral_j };

/// Books lateral work, in J, on the layers in proportion to the inserted lengths of the step just
/// made.
pub(crate) fn book_lateral(params: &AxialParams, state: &mut AxialState, scratch: &AxialScratch, work_j: f64) {
    let depth_m = state.last_output().depth_m;
    let path = Path::new(params.spec(), &scratch.boundaries_m, scratch.incidence);
    book_share(&mut state.ledger, &path, &Share { depth_m, total_j: work_j, part: LATERAL });
}

/// Books a share; returns false if no layer has a weight.
fn book_share(ledger: &mut Ledger, path: &Path<'_>, share: &Share) -> bool {
    let weight = |(layer, inserted_m): (&Layer, f64)| (share.part.coefficient)(layer) * inserted_m;
    let total: f64 = path.inserted(share.depth_m).map(weight).sum();
    if total <= 0.0 {
        return false;
    }
    for (entry, inserted) in ledger.layers.iter_mut().zip(path.inserted(share.depth_m)) {
        *(share.part.entry)(entry) += share.total_j * (weight(inserted) / total);
    }
    true
}
