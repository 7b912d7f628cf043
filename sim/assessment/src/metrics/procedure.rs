//! Steps of the procedure: reached, confirmed, withdrawn.

use ::attempt::is_inserted;
use recording::Contactor;

use super::MetricSheet;
use crate::attempt::{Attempt, Outcome};

pub(super) fn measure_procedure(attempt: &Attempt, sheet: &mut MetricSheet) {
    for (i, layer) in attempt.bundle.scene.layers.iter().enumerate() {
        let opened = attempt.ruptures.iter().any(|r| r.boundary == i && r.contactor == Contactor::Tip);
        sheet.put_for("reached", &layer.name, attempt.touched().map(|_| one_if(opened)));
    }
    sheet.put("confirmed", attempt.touched().map(|_| one_if(attempt.first_confirm_s().is_some())));
    sheet.put("withdrawn", was_withdrawn(attempt));
}

fn one_if(happened: bool) -> f64 {
    f64::from(u8::from(happened))
}

fn was_withdrawn(attempt: &Attempt) -> Outcome {
    attempt.inside()?;
    Ok(one_if(attempt.timeline.samples().last().is_some_and(|last| !is_inserted(last))))
}
