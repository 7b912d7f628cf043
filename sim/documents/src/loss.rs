//! Losses of resistance along the way of a needle with a syringe: a trainee must feel one.

use law::axial::Contactor;
use law::closed_form::predict_ruptures;
use law::quasistatic::quasistatic_forces_n;
use phrase::{Phrase, phrase};

use crate::error::Remark;
use crate::model::Scene;
use crate::patient::Patient;

/// Way behind a rupture within which the force has fallen, in m: friction and cutting give way over
/// their presliding length.
const BEHIND_M: f64 = 3e-3;
/// Distance in front of a rupture at which the force before it is taken, in m.
const JUST_M: f64 = 1e-9;
/// Distance of the samples behind a rupture, in m.
const STEP_M: f64 = 0.1e-3;
/// Share of the loss above which an earlier fall is mistaken for it.
const MISTAKEN: f64 = 0.5;

impl Scene {
    /// Returns the fall of the force behind each place at which a slow needle opens boundaries
    /// perpendicularly, in N, with the index of the first of them, in the order of the way.
    #[must_use]
    pub fn list_falls_n(&self) -> Vec<(usize, f64)> {
        let spec = self.axial_spec(&Patient::nominal(self));
        let predicted = predict_ruptures(&spec);
        let by_tip: Vec<_> = predicted.iter().filter(|rupture| rupture.contactor == Contactor::Tip).collect();
        let cascades = by_tip.chunk_by(|one, next| one.x_m.total_cmp(&next.x_m).is_eq());
        let fall = |x_m: f64| {
            let steps = (BEHIND_M / STEP_M) as u32;
            // From the skin in one step: the walk goes from event to event, and is exact at any spacing.
            let behind = (1..=steps).map(|step| x_m + f64::from(step) * STEP_M);
            let track: Vec<f64> = [0.0, x_m - JUST_M].into_iter().chain(behind).collect();
            let forces_n = &quasistatic_forces_n(&spec, &track)[1..];
            forces_n[0] - forces_n.iter().copied().fold(f64::INFINITY, f64::min)
        };
        cascades.filter_map(|cascade| cascade.first()).map(|first| (first.boundary, fall(first.x_m))).collect()
    }

    /// Returns a remark if a syringe's needle loses more than half of the greatest loss before it. The
    /// skin's fall is none that could be mistaken for it.
    #[must_use]
    pub fn remark_early_loss(&self) -> Option<Remark> {
        if self.needle.hub != "syringe" {
            return None;
        }
        let falls = self.list_falls_n();
        let most = falls.iter().copied().max_by(|one, other| one.1.total_cmp(&other.1))?;
        let (at, early_n) =
            *falls.iter().take_while(|fall| fall.0 != most.0).find(|fall| fall.0 > 0 && fall.1 > MISTAKEN * most.1)?;
        let name = |at: usize| self.layers[at].name.clone();
        Some(Remark {
            field: format!("layer[{at}]"),
            found: phrase!(
                "the force falls by {early} N at {layer}, before the loss of resistance of {most} N at {last}",
                early = Phrase::number(early_n, 1),
                layer = name(at),
                most = Phrase::number(most.1, 1),
                last = name(most.0)
            ),
            allowed: phrase!("allowed: at most half of it, or a trainee stops too early"),
        })
    }
}
