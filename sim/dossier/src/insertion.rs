//! Simulates a needle inserted perpendicularly at a constant speed and records the force on the
//! hand.

use documents::{NeedleFamily, Patient, Scene};
use law::axial::{Contactor, ParamError};
use law::ledger::Ledger;
use law::operator::needle_pose;
use law::puncture::{PunctureEvent, PunctureInput, PunctureParams, PunctureScratch, PunctureState, step};
use nalgebra::{Point3, Vector3};

/// Shortest duration of a tick, in s.
const DT: f64 = 1e-3;
/// Smallest displacement per tick, in m: a slow insertion has longer ticks.
const WAY_M: f64 = 5e-6;
/// Largest travel beyond the last boundary, in m: boundaries tent before they open.
const BEYOND_M: f64 = 0.04;
/// Thickness that the last layer gets, in m: a way may be longer than the layers of a scene.
const ENDLESS_M: f64 = 1.0;

/// One tick of an insertion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeMoment {
    /// Displacement of the tip, in m.
    pub x_m: f64,
    /// Axial force on the hand, in N.
    pub force_n: f64,
}

/// An insertion until every boundary was open or the needle's length was used up.
#[derive(Clone, Debug)]
pub struct ProbeInsertion {
    /// Ticks in order, starting at contact.
    pub moments: Vec<ProbeMoment>,
    /// For each boundary, the index in `moments` at which the tip opened it.
    pub opened: Vec<Option<usize>>,
    /// For each boundary, the index at which the last contactor was through it.
    pub through: Vec<Option<usize>>,
    /// Energy ledger.
    pub ledger: Ledger,
}

/// Returns the speed of the insertion that is compared, in m/s: 1.5 mm/s for a Tuohy needle, which is
/// advanced in small steps, else 5 mm/s.
#[must_use]
pub fn insertion_speed_m_per_s(scene: &Scene) -> f64 {
    if scene.needle.family == Some(NeedleFamily::Tuohy) { 1.5e-3 } else { 5e-3 }
}

/// Returns the law for a scene's layers without its structures, which a study's needle did not hit.
///
/// # Errors
/// If the law refuses the scene; reading the scene has checked this.
pub fn layers_alone(scene: &Scene) -> Result<PunctureParams, ParamError> {
    let mut spec = scene.puncture_spec(&Patient::nominal(scene));
    spec.structures.clear();
    spec.hub_stiffness_n_per_m = None;
    PunctureParams::new(spec)
}

/// A needle that moves along the normal of the skin.
struct Probe<'a> {
    params: &'a PunctureParams,
    state: PunctureState,
    scratch: PunctureScratch,
    t_s: f64,
}

impl<'a> Probe<'a> {
    fn new(params: &'a PunctureParams) -> Self {
        Self { params, state: PunctureState::new(params), scratch: PunctureScratch::new(params), t_s: 0.0 }
    }

    /// Moves to a displacement and returns the axial force, in N.
    fn go(&mut self, x_m: f64, dt_s: f64) -> f64 {
        self.t_s += dt_s;
        let patient_from_needle = needle_pose(&Point3::new(0.0, 0.0, -x_m), &-Vector3::z());
        let input = PunctureInput { t_s: self.t_s, patient_from_needle };
        step(self.params, &mut self.state, &mut self.scratch, &input).axial.total_n()
    }

    /// Returns the boundaries that a contactor opened in the last step.
    fn opened(&self, by: Contactor) -> impl Iterator<Item = usize> + '_ {
        self.scratch.events.iter().filter_map(move |event| match event {
            PunctureEvent::Rupture(rupture) if rupture.contactor == by => Some(rupture.boundary),
            _ => None,
        })
    }
}

/// Inserts at a speed in m/s until every boundary is open or the needle's length is used up.
#[must_use]
pub fn insert_at(params: &PunctureParams, speed_m_per_s: f64) -> ProbeInsertion {
    let layers = &params.spec().axial.layers;
    let deepest_m: f64 = layers.iter().rev().skip(1).map(|layer| layer.thickness_m).sum();
    let end_m = (deepest_m + BEYOND_M).min(params.spec().needle_length_m);
    insert_until(params, speed_m_per_s, end_m, |opened| opened.iter().all(Option::is_some))
}

/// Inserts at a speed in m/s to a displacement in m; the last layer ends nowhere.
///
/// # Panics
/// Never: a checked law stays one with a thicker last layer.
#[must_use]
#[expect(clippy::expect_used, reason = "a checked law stays one with a thicker last layer")]
pub fn insert_to(params: &PunctureParams, speed_m_per_s: f64, end_m: f64) -> ProbeInsertion {
    let mut spec = params.spec().clone();
    if let Some(last) = spec.axial.layers.last_mut() {
        last.thickness_m = ENDLESS_M;
    }
    let endless = PunctureParams::new(spec).expect("a thicker last layer");
    insert_until(&endless, speed_m_per_s, end_m, |_| false)
}

fn insert_until(
    params: &PunctureParams,
    speed_m_per_s: f64,
    end_m: f64,
    is_done: impl Fn(&[Option<usize>]) -> bool,
) -> ProbeInsertion {
    let spec = &params.spec().axial;
    let dt_s = DT.max(WAY_M / speed_m_per_s);
    let mut probe = Probe::new(params);
    let mut moments = Vec::new();
    let (mut opened, mut passed) = (vec![None; spec.layers.len()], vec![None; spec.layers.len()]);
    let mut x_m = 0.0;
    while x_m < end_m && !is_done(&passed) {
        let force_n = probe.go(x_m, dt_s);
        let last = if spec.tip_to_rim_m > 0.0 { Contactor::Rim } else { Contactor::Tip };
        for (contactor, at) in [(Contactor::Tip, &mut opened), (last, &mut passed)] {
            for boundary in probe.opened(contactor) {
                at[boundary].get_or_insert(moments.len());
            }
        }
        moments.push(ProbeMoment { x_m, force_n });
        x_m += speed_m_per_s * dt_s;
    }
    ProbeInsertion { moments, opened, through: passed, ledger: probe.state.ledger().clone() }
}

/// Presses to a displacement at a speed in m/s, holds there for a time in s, and returns the
/// relative decrease of the force.
#[must_use]
pub fn hold_at(params: &PunctureParams, speed_m_per_s: f64, hold_m: f64, hold_s: f64) -> f64 {
    let dt_s = DT.max(WAY_M / speed_m_per_s);
    let mut probe = Probe::new(params);
    let (mut x_m, mut pressed_n) = (0.0, 0.0);
    while x_m < hold_m {
        pressed_n = probe.go(x_m, dt_s);
        x_m += speed_m_per_s * dt_s;
    }
    let end_s = probe.t_s + hold_s;
    let mut held_n = pressed_n;
    while probe.t_s < end_s {
        held_n = probe.go(x_m, DT);
    }
    1.0 - held_n / pressed_n
}

impl ProbeInsertion {
    /// Returns the ticks between the opening of the boundary above and that of this boundary;
    /// `None` if it never opened.
    #[must_use]
    pub fn stretch(&self, boundary: usize) -> Option<&[ProbeMoment]> {
        self.between(boundary.checked_sub(1), Some(boundary))
    }

    /// Returns the ticks from the opening of one boundary, or from contact, to that of another, or to
    /// the end; `None` if the other never opened.
    #[must_use]
    pub fn between(&self, above: Option<usize>, boundary: Option<usize>) -> Option<&[ProbeMoment]> {
        let end = match boundary {
            Some(boundary) => self.opened[boundary]?,
            None => self.moments.len(),
        };
        let above = above.and_then(|above| self.opened[above]);
        // If a lower boundary opened first, the ticks belong to both.
        let begin = above.filter(|above| *above < end).map_or(0, |above| above + 1);
        Some(&self.moments[begin.min(end.saturating_sub(1))..end])
    }
}

/// Returns the largest force of the given ticks, in N.
#[must_use]
pub fn greatest_n(moments: &[ProbeMoment]) -> f64 {
    moments.iter().map(|moment| moment.force_n).fold(0.0, f64::max)
}
