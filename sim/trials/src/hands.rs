//! Results of a virtual hand's attempt, in the quantities that published studies report.

use super::needle::DT;
use law::axial::Contactor;
use law::operator::{Felt, Operator};
use law::puncture::{
    PunctureEvent, PunctureInput, PunctureOutput, PunctureParams, PunctureScratch, PunctureState, step,
};

/// Time after a rupture in which the advance counts as overshoot, in s, as in the metric
/// `over_insertion_mm`.
const AFTER_S: f64 = 1.0;

/// The advance of the tip after a rupture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lunge {
    /// Index of the boundary, 0 is the skin.
    pub boundary: usize,
    /// The contactor that opened it.
    pub contactor: Contactor,
    /// Displacement at the rupture, in m.
    pub from_m: f64,
    /// Furthest advance beyond it in the following second, in m.
    pub overshoot_m: f64,
    /// Tick of the rupture.
    tick: u32,
}

/// Results of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct Performance {
    /// Largest axial force on the hand, in N; 0 if the needle never touched the skin.
    pub peak_n: f64,
    /// A lunge for each rupture, in order.
    pub lunges: Vec<Lunge>,
    /// Largest displacement of the tip along the needle, in m.
    pub furthest_m: f64,
    /// Displacement at which the position was confirmed, in m.
    pub confirmed_m: Option<f64>,
    /// Time until the operator was done or the limit was reached, in s.
    pub duration_s: f64,
}

impl Performance {
    /// Returns the overshoot after a contactor opened a boundary, in m; `None` if it did not.
    #[must_use]
    pub fn overshoot_m(&self, boundary: usize, contactor: Contactor) -> Option<f64> {
        let lunge = self.lunges.iter().find(|lunge| lunge.boundary == boundary && lunge.contactor == contactor);
        lunge.map(|lunge| lunge.overshoot_m)
    }

    fn see(&mut self, tick: u32, output: &PunctureOutput, events: &[PunctureEvent]) {
        self.duration_s = f64::from(tick) * DT;
        self.peak_n = self.peak_n.max(output.axial.total_n());
        self.furthest_m = self.furthest_m.max(output.x_m);
        let ruptures = events.iter().filter_map(|event| match event {
            PunctureEvent::Rupture(rupture) => Some(rupture),
            _ => None,
        });
        self.lunges.extend(ruptures.map(|rupture| Lunge {
            boundary: rupture.boundary,
            contactor: rupture.contactor,
            from_m: rupture.x_m,
            overshoot_m: 0.0,
            tick,
        }));
        for lunge in self.lunges.iter_mut().filter(|lunge| f64::from(tick - lunge.tick) * DT <= AFTER_S) {
            lunge.overshoot_m = lunge.overshoot_m.max(output.x_m - lunge.from_m);
        }
    }
}

/// Simulates an operator at 1 kHz until it is done or a time limit in s is reached.
#[must_use]
pub fn perform(params: &PunctureParams, operator: &mut Operator, limit_s: f64) -> Performance {
    let (mut state, mut scratch) = (PunctureState::new(params), PunctureScratch::new(params));
    let mut felt = Felt::default();
    let mut performance =
        Performance { peak_n: 0.0, lunges: Vec::new(), furthest_m: f64::MIN, confirmed_m: None, duration_s: 0.0 };
    for tick in 0..(limit_s / DT) as u32 {
        let motion = operator.step(if tick == 0 { 0.0 } else { DT }, &felt);
        let input = PunctureInput { t_s: f64::from(tick) * DT, patient_from_needle: motion.patient_from_needle };
        let output = step(params, &mut state, &mut scratch, &input);
        felt = Felt::from(&output);
        performance.see(tick, &output, &scratch.events);
        if motion.confirm {
            performance.confirmed_m = Some(output.x_m);
        }
        if motion.done {
            break;
        }
    }
    performance
}
