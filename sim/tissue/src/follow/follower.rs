//! The field that follows a needle in a tissue, step by step.

use law::puncture::{PunctureParams, PunctureScratch, PunctureState, held_incidence, measure_intrusion, write_loads};
use law::stance::{Follows, Intrusion, settle_dents};

use super::field::Field;
use super::press::press_loads;
use super::responses::Responses;
use super::secant::DragDents;
use super::state::{FollowState, step};

/// The field behind a force law, updated from the law's latest state.
#[derive(Debug)]
pub struct Follower<'a> {
    law: &'a PunctureParams,
    field: &'a Field,
    /// Responses at the angle of the last insertion; before the first one, at that of the exercise.
    on_axis: Responses,
    /// Cosine of that angle to the normal; `None` before the first insertion.
    cosine: Option<f64>,
    follows: Follows,
    /// Loads of the law that the tissue bears.
    borne: FollowState,
    /// Loads of the linear field with the same displacement.
    linear: FollowState,
    drags: DragDents,
    /// Loads of the law at the last step, in N.
    latest_n: Vec<f64>,
    /// Displacement of each boundary at the last step, in m.
    dents_m: Vec<f64>,
    /// Needle at the last step; `None` in the air.
    needle: Option<Intrusion>,
}

impl<'a> Follower<'a> {
    /// Untouched tissue.
    #[must_use]
    pub fn new(law: &'a PunctureParams, field: &'a Field, follows: Follows) -> Self {
        let state = FollowState::new(field.follow());
        let layers = state.loads_n.len() / 2;
        Self {
            law,
            field,
            on_axis: field.planned().clone(),
            cosine: None,
            follows,
            borne: state.clone(),
            drags: DragDents::new(layers),
            latest_n: vec![0.0; state.loads_n.len()],
            linear: state,
            dents_m: vec![0.0; layers],
            needle: None,
        }
    }

    /// Advances by `dt_s`, to the state of the law after its last step. Never allocates.
    pub fn step(&mut self, dt_s: f64, state: &PunctureState, scratch: &PunctureScratch) {
        self.lean(state);
        write_loads(self.law, state, scratch, &mut self.latest_n);
        step(self.field.follow(), &mut self.borne, dt_s, &self.latest_n);
        let layers = self.dents_m.len();
        if self.follows >= Follows::Secant {
            self.drags.linearise(&self.law.spec().axial, dt_s, &mut self.latest_n[layers..]);
        }
        if self.follows >= Follows::Needle {
            // The contactors' loads are computed below, from the displacements that they impose.
            self.latest_n[..layers].fill(0.0);
        }
        step(self.field.follow(), &mut self.linear, dt_s, &self.latest_n);
        let rest_m = scratch.boundaries_m();
        self.needle = measure_intrusion(self.law, state);
        if let Some(needle) = self.needle.filter(|_| self.follows >= Follows::Needle) {
            press_loads(&self.on_axis, &needle.pressed(rest_m), &mut self.linear.loads_n);
        }
        for (boundary, dent_m) in self.dents_m.iter_mut().enumerate() {
            *dent_m = self.on_axis.axial_m(boundary, &self.linear.loads_n);
        }
        if self.follows >= Follows::Needle {
            settle_dents(self.follows, self.needle.as_ref(), rest_m, &mut self.dents_m);
        }
    }

    /// Updates the responses to the angle at which tissue holds the needle to its line.
    fn lean(&mut self, state: &PunctureState) {
        let cosine = held_incidence(state).map(|incidence| incidence.cosine());
        if cosine.is_some() && cosine != self.cosine {
            self.cosine = cosine;
            self.field.on_axis().write_at(cosine.unwrap_or(1.0), &mut self.on_axis);
        }
    }

    /// Loads that the tissue bears after the last step, in N: contactors, then drags. From
    /// [`Follows::Secant`] on they are those of the law, with recoil; before, those of the linear
    /// field.
    #[must_use]
    pub fn loads_n(&self) -> &[f64] {
        if self.follows >= Follows::Secant { &self.borne.loads_n } else { &self.linear.loads_n }
    }

    /// Loads that displace the linear field as far, in N, in the same order.
    #[must_use]
    pub fn linear_n(&self) -> &[f64] {
        &self.linear.loads_n
    }

    /// Displacement of each boundary along the needle, in m.
    #[must_use]
    pub fn dents_m(&self) -> &[f64] {
        &self.dents_m
    }

    /// Position of the needle at the last step; `None` in the air.
    #[must_use]
    pub fn needle(&self) -> Option<&Intrusion> {
        self.needle.as_ref()
    }
}
