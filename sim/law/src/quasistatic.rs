//! The law along a curve: quasistatic, without viscosity and without ticks.
//!
//! A measured needle does not move in steps from sample to sample: it opens a boundary somewhere
//! between two samples and drags its presliding springs from there. Between ruptures tents are
//! functions of the displacement and the springs piecewise linear in it, so stepping from event to
//! event is exact at any spacing of the samples; [`crate::axial::step`] converges to it with
//! decreasing ticks, as a test shows.
//!
//! Of version 3 it supports tents that stiffen. A tent that relaxes is treated as fully relaxed,
//! which holds for a needle so slow that every branch relaxes on the way; a sheet of fibres is met
//! by the edge [`PLAIN_EDGE`]; the peak of static friction before breakaway is ignored. Use the
//! step if these matter.

use crate::axial::{AxialSpec, Contactor, Open, PLAIN_EDGE, Path, lay_boundaries};
use crate::closed_form::{Opening, predict_positions};
use crate::skin::Incidence;

/// State of a needle along a curve.
struct Walk<'p> {
    path: Path<'p>,
    presliding_n_per_m: f64,
    open: Open,
    x_m: f64,
    friction_n: f64,
    /// Position of the cutting front; `None` before the skin is open.
    front_m: Option<f64>,
}

/// The law's force at every displacement of a track, in N. The needle starts from the skin; depths
/// in m, in the order measured.
#[must_use]
pub fn quasistatic_forces_n(spec: &AxialSpec, track_m: &[f64]) -> Vec<f64> {
    let plain = spec.has_sheets().then(|| spec.under_edge(PLAIN_EDGE));
    let spec = plain.as_ref().unwrap_or(spec);
    let mut boundaries_m = Vec::with_capacity(spec.layers.len() + 1);
    lay_boundaries(&spec.layers, &Incidence::UPRIGHT, &mut boundaries_m);
    let events = predict_positions(spec, &boundaries_m, 0.0);
    let mut ahead = events.iter().peekable();
    let mut walk = Walk {
        path: Path::new(spec, &boundaries_m, Incidence::UPRIGHT),
        presliding_n_per_m: spec.presliding_stiffness_n_per_m,
        open: Open { tip: 0, rim: 0 },
        x_m: track_m.first().map_or(0.0, |first| first.min(0.0)),
        friction_n: 0.0,
        front_m: None,
    };
    let force_n = |&x_m: &f64| {
        while let Some(event) = ahead.next_if(|event| event.x_m <= x_m) {
            walk.pass(event);
        }
        walk.go(x_m);
        walk.force_n()
    };
    track_m.iter().map(force_n).collect()
}

impl Walk<'_> {
    /// Advances to a rupture, and opens the boundary.
    fn pass(&mut self, event: &Opening) {
        if event.x_m > self.x_m {
            self.go(event.x_m);
        }
        match event.contactor {
            Contactor::Tip => self.open.tip += 1,
            Contactor::Rim => self.open.rim += 1,
        }
        self.front_m = self.front_m.or(Some(self.x_m));
    }

    /// Drags the presliding springs along. Their caps change linearly on the way, and by less than
    /// the springs' own stiffness.
    fn go(&mut self, x_m: f64) {
        let trial_n = self.friction_n + self.presliding_n_per_m * (x_m - self.x_m);
        self.x_m = x_m;
        let depth_m = self.path.depth_m(self.open, x_m);
        let cap_n: f64 = self.path.inserted(depth_m).map(|(layer, length_m)| layer.friction_n_per_m * length_m).sum();
        self.friction_n = trial_n.max(-cap_n).min(cap_n);
        let dragged_m = x_m - self.cutting_cap_n() / self.presliding_n_per_m;
        self.front_m = self.front_m.map(|front_m| front_m.max(dragged_m));
    }

    fn cutting_cap_n(&self) -> f64 {
        let layer = self.path.layer_at(self.path.depth_m(self.open, self.x_m));
        layer.and_then(|layer| self.path.layers.get(layer)).map_or(0.0, |layer| layer.cutting_n)
    }

    fn force_n(&self) -> f64 {
        let spring_n = self.front_m.map_or(0.0, |front_m| self.presliding_n_per_m * (self.x_m - front_m));
        let cutting_n = spring_n.max(0.0).min(self.cutting_cap_n());
        self.path.tip(self.open, self.x_m).force_n
            + self.path.rim(self.open, self.x_m).force_n
            + self.friction_n
            + cutting_n
    }
}
