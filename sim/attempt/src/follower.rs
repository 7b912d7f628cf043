//! The tissue's field, which follows the needle.

use law::puncture::{PunctureScratch, PunctureState};
use recording::rate::{Ticker, nanoseconds};
use recording::{Follows, Tent};
use tissue::Specimen;
use tissue::follow::{FIELD_HZ, Follower};

/// The field behind a force law: updated from the law's latest state, [`FIELD_HZ`] times a second.
#[derive(Debug)]
pub struct FieldFollower<'a> {
    follower: Follower<'a>,
    follows: Follows,
    steps: Ticker,
    /// Time of the last step, in s.
    last_s: f64,
}

impl<'a> FieldFollower<'a> {
    /// Untouched tissue; `None` if the scene has no field.
    pub fn new(specimen: &'a Specimen, follows: Follows) -> Option<Self> {
        let follower = Follower::new(specimen.law(), specimen.field()?, follows);
        Some(Self { follower, follows, steps: Ticker::new(FIELD_HZ, 0), last_s: 0.0 })
    }

    /// Follows a tick of the force law at a time in s; returns the tent if a step of the field is
    /// due.
    pub fn tick(&mut self, t_s: f64, state: &PunctureState, scratch: &PunctureScratch) -> Option<Tent> {
        if !self.steps.due(nanoseconds(t_s)) {
            return None;
        }
        self.follower.step(t_s - self.last_s, state, scratch);
        self.last_s = t_s;
        Some(self.tent(t_s))
    }

    fn tent(&self, t_s: f64) -> Tent {
        let dents_m = self.follower.dents_m();
        let (contactors, drags) = self.follower.loads_n().split_at(dents_m.len());
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        let linear_n = if self.follows >= Follows::Secant { self.follower.linear_n() } else { &[] };
        Tent {
            t_s,
            tent_m: single(dents_m),
            contactor_n: single(contactors),
            drag_n: single(drags),
            linear_n: single(linear_n),
            follows: self.follows,
        }
    }
}
