//! The field of the tissue as it follows the needle, topic `/tissue/tent`.

use mechanics::puncture::{PunctureParams, PunctureScratch, PunctureState, loads};
use mechanics::tissue::follow::{self, FIELD_HZ, Field, FollowState};

use crate::summary::{Ticker, nanoseconds};

/// How the tissue stands at a moment. All along the needle, where one at the exercise's angle meets them, boundaries and layers from the surface
/// down, positive into the body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tent {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Displacement of each boundary, in m.
    pub tent_m: Vec<f32>,
    /// Load that the field carries at each boundary, in N.
    pub contactor_n: Vec<f32>,
    /// Drag of the shaft along each layer, in N; negative on withdrawal.
    pub drag_n: Vec<f32>,
}

/// The field behind a force law: takes its latest loads, [`FIELD_HZ`] times a second.
#[derive(Debug)]
pub(crate) struct Follower<'a> {
    field: &'a Field,
    state: FollowState,
    /// Loads of the law at the last step, in N.
    latest_n: Vec<f64>,
    steps: Ticker,
    /// Time of the last step, in s.
    last_s: f64,
}

impl<'a> Follower<'a> {
    /// Tissue that nothing has touched; none where the scene has no field.
    pub(crate) fn new(params: &'a PunctureParams) -> Option<Self> {
        let field = params.field()?;
        let state = FollowState::new(field.follow());
        let latest_n = vec![0.0; state.loads_n.len()];
        Some(Self { field, state, latest_n, steps: Ticker::new(FIELD_HZ, 0), last_s: 0.0 })
    }

    /// Follows a tick of the force law at a time in s; the tent, where a step of the field is due.
    pub(crate) fn tick(&mut self, t_s: f64, law: (&PunctureParams, &PunctureState, &PunctureScratch)) -> Option<Tent> {
        if !self.steps.due(nanoseconds(t_s)) {
            return None;
        }
        let (params, state, scratch) = law;
        loads(params, state, scratch, &mut self.latest_n);
        follow::step(self.field.follow(), &mut self.state, t_s - self.last_s, &self.latest_n);
        self.last_s = t_s;
        Some(self.tent(t_s))
    }

    fn tent(&self, t_s: f64) -> Tent {
        let loads_n = &self.state.loads_n;
        let (contactors, drags) = loads_n.split_at(loads_n.len() / 2);
        let single = |values: &[f64]| values.iter().map(|&value| value as f32).collect();
        let tent_m = (0..contactors.len()).map(|boundary| self.field.on_axis().axial_m(boundary, loads_n) as f32);
        Tent { t_s, tent_m: tent_m.collect(), contactor_n: single(contactors), drag_n: single(drags) }
    }
}
