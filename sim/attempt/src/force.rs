//! What the hand felt just before an event.

use law::axial::Contactor;
use recording::{Event, Sample};

/// Axial force on the hand just before an event, in N. At a rupture the contactor counts with its own force as the event states it, and
/// the other parts as last recorded: without that a pop would be lower the slower the recording. `samples` are in order of time.
#[must_use]
pub fn axial_force_before_n(samples: &[Sample], event: &Event) -> f64 {
    let after = samples.partition_point(|sample| sample.t_s < event.t_s);
    let Some(sample) = after.checked_sub(1).and_then(|before| samples.get(before)) else { return event.force_n };
    let axial_n = sample.axial_n();
    event.kind.contactor().map_or(axial_n, |contactor| raise_to_rupture_n(axial_n, sample, contactor, event.force_n))
}

/// An axial force of the last sample before a rupture, in N, with the contactor's part as the rupture states it: `rupture_n`. As it is
/// where the contactor did not press yet: it was moved there within one tick, and no hand felt its force.
#[must_use]
pub fn raise_to_rupture_n(axial_n: f64, sample: &Sample, contactor: Contactor, rupture_n: f64) -> f64 {
    let own_n = f64::from(match contactor {
        Contactor::Tip => sample.tip_n,
        Contactor::Rim => sample.rim_n,
    });
    if own_n > 0.0 { axial_n.max(axial_n - own_n + rupture_n) } else { axial_n }
}
