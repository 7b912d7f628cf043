//! The tissue's field, which follows the needle.

use law::puncture::{PunctureParams, PunctureScratch, PunctureState, held_incidence, measure_intrusion, write_loads};
use law::stance::settle_dents;
use recording::rate::{Ticker, nanoseconds};
use recording::{Follows, Tent};
use tissue::Specimen;
use tissue::follow::{self, FIELD_HZ, Field, FollowState, Responses, press_loads};

/// The field behind a force law: updated from the law's latest state, [`FIELD_HZ`] times a second.
#[derive(Debug)]
pub struct FieldFollower<'a> {
    law: &'a PunctureParams,
    field: &'a Field,
    /// Responses at the angle of the last insertion; before the first one, at that of the exercise.
    on_axis: Responses,
    /// Cosine of that angle to the normal; `None` before the first insertion.
    cosine: Option<f64>,
    follows: Follows,
    state: FollowState,
    /// Loads of the law at the last step, in N.
    latest_n: Vec<f64>,
    /// Displacement of each boundary at the last step, in m.
    dents_m: Vec<f64>,
    steps: Ticker,
    /// Time of the last step, in s.
    last_s: f64,
}

impl<'a> FieldFollower<'a> {
    /// Untouched tissue; `None` if the scene has no field.
    pub fn new(specimen: &'a Specimen, follows: Follows) -> Option<Self> {
        let (law, field) = (specimen.law(), specimen.field()?);
        let state = FollowState::new(field.follow());
        let latest_n = vec![0.0; state.loads_n.len()];
        let dents_m = vec![0.0; state.loads_n.len() / 2];
        let on_axis = field.planned().clone();
        Some(Self {
            law,
            field,
            on_axis,
            cosine: None,
            follows,
            state,
            latest_n,
            dents_m,
            steps: Ticker::new(FIELD_HZ, 0),
            last_s: 0.0,
        })
    }

    /// Follows a tick of the force law at a time in s; returns the tent if a step of the field is
    /// due.
    pub fn tick(&mut self, t_s: f64, state: &PunctureState, scratch: &PunctureScratch) -> Option<Tent> {
        if !self.steps.due(nanoseconds(t_s)) {
            return None;
        }
        self.lean(state);
        write_loads(self.law, state, scratch, &mut self.latest_n);
        let needle = measure_intrusion(self.law, state).filter(|_| self.follows == Follows::Needle);
        let rest_m = scratch.boundaries_m();
        if self.follows == Follows::Needle {
            // The contactors' loads are computed below, from the displacements that they impose.
            self.latest_n[..self.dents_m.len()].fill(0.0);
        }
        follow::step(self.field.follow(), &mut self.state, t_s - self.last_s, &self.latest_n);
        self.last_s = t_s;
        if let Some(needle) = &needle {
            press_loads(&self.on_axis, &needle.pressed(rest_m), &mut self.state.loads_n);
        }
        for (boundary, dent_m) in self.dents_m.iter_mut().enumerate() {
            *dent_m = self.on_axis.axial_m(boundary, &self.state.loads_n);
        }
        if self.follows == Follows::Needle {
            settle_dents(needle.as_ref(), rest_m, &mut self.dents_m);
        }
        Some(self.tent(t_s))
    }

    /// Updates the responses to the angle at which tissue holds the needle to its line.
    fn lean(&mut self, state: &PunctureState) {
        let cosine = held_incidence(state).map(|incidence| incidence.cosine());
        if cosine.is_some() && cosine != self.cosine {
            self.cosine = cosine;
            self.field.on_axis().write_at(cosine.unwrap_or(1.0), &mut self.on_axis);
        }
    }

    fn tent(&self, t_s: f64) -> Tent {
        let (contactors, drags) = self.state.loads_n.split_at(self.dents_m.len());
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        Tent {
            t_s,
            tent_m: single(&self.dents_m),
            contactor_n: single(contactors),
            drag_n: single(drags),
            follows: self.follows,
        }
    }
}
