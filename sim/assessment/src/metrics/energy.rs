//! The parts of the energy ledger, from its last entry in the recording.

use super::MetricSheet;
use crate::absent::Absent;
use crate::attempt::{Attempt, Outcome};

pub(super) fn measure_energy(attempt: &Attempt, sheet: &mut MetricSheet) {
    put_energy(attempt, sheet, "rupture_energy_mj", 0);
    put_energy(attempt, sheet, "cutting_energy_mj", 1);
    put_energy(attempt, sheet, "friction_energy_mj", 2);
    put_energy(attempt, sheet, "lateral_work_mj", 3);
}

/// Records one of the parts of [`layer_works_mj`]: the sum over the layers, and the value of each.
fn put_energy(attempt: &Attempt, sheet: &mut MetricSheet, id: &str, part: usize) {
    let parts = layer_works_mj(attempt);
    let part_of = |layer: Option<usize>| -> Outcome {
        let parts = parts.as_ref().map_err(|absent| *absent)?;
        Ok(parts.iter().enumerate().filter(|(i, _)| layer.is_none_or(|l| l == *i)).map(|(_, p)| p[part]).sum())
    };
    sheet.put(id, part_of(None));
    for (i, layer) in attempt.bundle.scene.layers.iter().enumerate() {
        sheet.put_for(id, &layer.name, part_of(Some(i)));
    }
}

/// Returns rupture, cutting, friction and lateral work of each layer, in mJ.
fn layer_works_mj(attempt: &Attempt) -> Result<Vec<[f64; 4]>, Absent> {
    attempt.touched()?;
    let energy = attempt.recording.energies.last().ok_or(Absent::NoLedger)?;
    if energy.ledger.layers.len() != attempt.bundle.scene.layers.len() {
        return Err(Absent::NoLedger);
    }
    let parts = energy.ledger.layers.iter();
    Ok(parts.map(|e| [e.rupture_j, e.cutting_j, e.friction_j, e.lateral_j].map(|j| j * 1e3)).collect())
}
