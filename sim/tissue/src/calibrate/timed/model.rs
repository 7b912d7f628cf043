//! The variables fitted to a timed curve, and the law's force for them, from stepping the law
//! itself.
//!
//! As without times, a threshold is not a variable, but the position at which its boundary ruptures
//! is. The law is run with the boundary shut until the needle reaches that position: the threshold
//! is then the force that the tent and its branches hold. The length at which static friction gives
//! way is not a variable either: it determines the sample at which the force falls, which no
//! derivative represents. It is held, and other lengths are tried.

use law::Incidence;
use law::axial::{AxialInput, AxialOutput, AxialParams, AxialScratch, AxialSpec, AxialState, ForceLaw, step};
use law::closed_form::predict_held_ruptures;
use nalgebra::DMatrix;

use super::curve::{TimedCurve, TimedSample};
use crate::calibrate::descent::{LeastSquares, Lowest};
use crate::calibrate::drops::Front;
use crate::calibrate::model::{EDGE, Quantity, UNSOUND_WEIGHT, excess_n};
use crate::calibrate::profile::Profiled;

/// A threshold that no force reaches, in N.
const SHUT_N: f64 = 1e9;
/// Distance behind a place at which its boundary has opened, in m: the law opens it in a step of
/// its own.
const BEHIND_M: f64 = 1e-9;
/// Margin of a shut boundary's threshold over its largest load on the curve, if the start's is
/// lower.
const ABOVE: f64 = 1.05;
/// Fractions of the branches' force, for the speeds at which soundness is checked during the fit.
const HELD_PARTS: [f64; 3] = [0.0, 0.5, 1.0];
/// Longest step of the needle when a specification is run without fitting, in m.
const STRIDE_M: f64 = 2e-5;

/// A variable: a quantity of a layer, or of the needle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TimedSlot {
    /// Index from 0; the number of layers for the needle.
    pub layer: usize,
    pub quantity: Quantity,
}

/// A curve, a start, and the gap of the front in which each boundary ruptures; `None` for one that
/// stays shut.
#[derive(Clone)]
pub(super) struct TimedModel<'c> {
    pub curve: &'c TimedCurve,
    pub front: &'c Front,
    pub start: &'c AxialSpec,
    pub slots: &'c [TimedSlot],
    pub places: Vec<Option<usize>>,
    /// Slid length at which static friction gives way, in m; `None` if the start has none.
    pub slid_m: Option<f64>,
}

/// Result of running the law along a curve.
pub(super) struct CurveForces {
    /// Force at every sample, in N.
    pub forces_n: Vec<f64>,
    /// The force on each boundary at its rupture, in N; the maximum for one that stayed shut.
    pub held_n: Vec<f64>,
    /// The total force just before, in N.
    pub before_n: Vec<f64>,
}

/// All variables of a start: options only if the start names them.
pub(super) fn find_slots(start: &AxialSpec, places: &[Option<usize>]) -> Vec<TimedSlot> {
    let mut slots = Vec::new();
    for (at, layer) in start.layers.iter().enumerate() {
        let mut quantities = vec![Quantity::Thickness, Quantity::Stiffness, Quantity::Friction];
        // Directly after friction, on which it builds.
        quantities.extend(layer.options.static_friction_n_per_m.map(|_| Quantity::StaticFriction));
        quantities.push(Quantity::Cutting);
        quantities.extend(places[at].map(|_| Quantity::TipThreshold));
        quantities.extend((layer.damping_n_s_per_m2 > 0.0).then_some(Quantity::Damping));
        quantities.extend((layer.options.stiffening_n_per_m2 > 0.0).then_some(Quantity::Stiffening));
        for branch in 0..layer.options.branches.len() {
            quantities.extend([Quantity::BranchShare(branch), Quantity::BranchTime(branch)]);
        }
        slots.extend(quantities.into_iter().map(|quantity| TimedSlot { layer: at, quantity }));
    }
    slots.push(TimedSlot { layer: start.layers.len(), quantity: Quantity::Presliding });
    slots
}

impl TimedModel<'_> {
    /// The variables of a specification. Places are in the middle of their gaps.
    pub fn variables(&self, spec: &AxialSpec) -> Vec<f64> {
        let of = |slot: &TimedSlot| match (slot.quantity, spec.layers.get(slot.layer)) {
            (_, None) => spec.presliding_stiffness_n_per_m,
            (Quantity::TipThreshold, _) => self.front.middle_m(self.places[slot.layer].unwrap_or(0)),
            (Quantity::StaticFriction, Some(layer)) => layer.static_friction_n_per_m() - layer.friction_n_per_m,
            (quantity, Some(layer)) => quantity.get(layer),
        };
        self.slots.iter().map(of).collect()
    }

    /// The specification for given variables, with every boundary shut, and the opening positions
    /// of those with a place, in m.
    fn shut(&self, variables: &[f64]) -> (AxialSpec, Vec<Option<f64>>) {
        let mut spec = AxialSpec { speed_window_s: 0.0, rate: None, ..self.start.clone() };
        let mut opens_m = vec![None; spec.layers.len()];
        for (slot, &value) in self.slots.iter().zip(variables) {
            let Some(layer) = spec.layers.get_mut(slot.layer) else {
                spec.presliding_stiffness_n_per_m = value;
                continue;
            };
            match slot.quantity {
                Quantity::TipThreshold => opens_m[slot.layer] = Some(value),
                Quantity::StaticFriction => slot.quantity.set(layer, layer.friction_n_per_m + value),
                quantity => quantity.set(layer, value),
            }
        }
        spec.layers.iter_mut().for_each(|layer| layer.tip_rupture_n = SHUT_N);
        if let (Some(breakaway), Some(slid_m)) = (&mut spec.breakaway, self.slid_m) {
            breakaway.slid_m = slid_m;
        }
        (spec, opens_m)
    }

    /// Runs the law along the curve.
    pub fn walk(&self, variables: &[f64]) -> CurveForces {
        let (spec, opens_m) = self.shut(variables);
        let layers = spec.layers.len();
        let mut walk = LawWalk::new(spec);
        let mut walked = CurveForces {
            forces_n: Vec::with_capacity(self.curve.len()),
            held_n: vec![0.0; layers],
            before_n: vec![0.0; layers],
        };
        for &sample in &self.curve.samples {
            while let Some(open_m) = opens_m.get(walk.open()).copied().flatten().filter(|m| *m < sample.depth_m) {
                let (boundary, before) = (walk.open(), walk.go_part(sample, open_m));
                walked.held_n[boundary] = before.tip_n;
                walked.before_n[boundary] = before.total_n();
                walk.give_way(boundary, before.tip_n);
                walk.go_part(sample, (open_m + BEHIND_M).min(sample.depth_m));
                if walk.open() == boundary {
                    // Not dented yet: it ruptures at first contact.
                    break;
                }
            }
            let output = walk.go(sample);
            if let Some(held_n) = walked.held_n.get_mut(walk.open()) {
                *held_n = held_n.max(output.tip_n);
            }
            walked.forces_n.push(output.total_n());
        }
        walked
    }

    /// The specification for given variables, with its thresholds and the unfitted values of the
    /// start.
    pub fn spec(&self, variables: &[f64]) -> AxialSpec {
        let walked = self.walk(variables);
        let (mut spec, opens_m) = self.shut(variables);
        for (at, layer) in spec.layers.iter_mut().enumerate() {
            layer.tip_rupture_n = match opens_m[at] {
                Some(_) => walked.held_n[at],
                None => self.start.layers[at].tip_rupture_n.max(ABOVE * walked.held_n[at]),
            };
        }
        AxialSpec { speed_window_s: self.start.speed_window_s, rate: self.start.rate, ..spec }
    }

    /// Law minus data at every sample, in N. Damping depends on the speed, which is unknown if the
    /// needle stops or reverses between two samples: with damping these do not count.
    pub fn misfit(&self, variables: &[f64]) -> Vec<f64> {
        let is_damped = self.slots.iter().any(|slot| slot.quantity == Quantity::Damping);
        let forces_n = self.walk(variables).forces_n;
        let samples = self.curve.samples.iter().zip(&self.curve.turns);
        let of = |(law_n, (sample, &turns)): (f64, (&TimedSample, &bool))| match is_damped && turns {
            true => 0.0,
            false => law_n - sample.force_n,
        };
        forces_n.into_iter().zip(samples).map(of).collect()
    }

    /// Weighted excess of force or energy after ruptures within the curve.
    fn unsound(&self, variables: &[f64]) -> Vec<f64> {
        let weight = UNSOUND_WEIGHT * (self.curve.len() as f64).sqrt();
        let spec = self.spec(variables);
        let parts = if spec.relaxes() { &HELD_PARTS[..] } else { &HELD_PARTS[..1] };
        let of = |&held: &f64| {
            let mut excess = vec![0.0; spec.layers.len()];
            let within = predict_held_ruptures(&spec, held).into_iter().filter(|r| self.places[r.boundary].is_some());
            within.for_each(|rupture| excess[rupture.boundary] = weight * excess_n(&rupture));
            excess
        };
        parts.iter().flat_map(of).collect()
    }

    /// Descends from variables with the places held.
    pub fn descend(&self, from: &[f64], most: u32) -> Lowest {
        let residuals = |variables: &[f64]| self.residuals(variables);
        let ((lower, upper), step) = (self.bounds(), self.steps());
        let enough = (1e-6 * self.curve.peak_n()).powi(2) * self.curve.len() as f64;
        let problem = LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough };
        problem.descend(from, most)
    }

    /// ∂(law)/∂(variables), in N per unit of each.
    pub fn sensitivity(&self, at: &[f64]) -> DMatrix<f64> {
        let residuals = |variables: &[f64]| self.misfit(variables);
        let ((lower, upper), step) = (self.bounds(), self.steps());
        let problem = LeastSquares { residuals: &residuals, lower: &lower, upper: &upper, step: &step, enough: 0.0 };
        problem.jacobian(at, &residuals(at))
    }
}

impl Profiled for TimedModel<'_> {
    fn residuals(&self, variables: &[f64]) -> Vec<f64> {
        let mut residuals = self.misfit(variables);
        residuals.extend(self.unsound(variables));
        residuals
    }

    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |slot: &TimedSlot| match (slot.quantity, self.places.get(slot.layer).copied().flatten()) {
            (Quantity::TipThreshold, Some(gap)) => {
                let edge_m = EDGE * self.front.width_m(gap);
                (self.front.depth_m[gap] + edge_m, self.front.depth_m[gap + 1] - edge_m)
            }
            (quantity, _) => quantity.bounds(),
        };
        self.slots.iter().map(of).unzip()
    }

    fn steps(&self) -> Vec<f64> {
        self.slots.iter().map(|slot| slot.quantity.step()).collect()
    }

    fn number(&self, variables: &[f64], which: usize) -> f64 {
        match self.slots[which].quantity {
            Quantity::TipThreshold => self.walk(variables).held_n[self.slots[which].layer],
            Quantity::StaticFriction => variables[which - 1] + variables[which],
            _ => variables[which],
        }
    }

    fn quantity(&self, which: usize) -> Quantity {
        self.slots[which].quantity
    }

    fn is_place(&self, which: usize) -> bool {
        self.slots[which].quantity == Quantity::TipThreshold
    }

    fn close_by(&self) -> Vec<Self> {
        self.with_close_lengths()
    }
}

/// The law's state along a curve.
struct LawWalk {
    params: AxialParams,
    state: AxialState,
    scratch: AxialScratch,
    last: Option<TimedSample>,
}

impl LawWalk {
    #[expect(clippy::expect_used, reason = "the start was checked, and bounds keep to what the law takes")]
    fn new(spec: AxialSpec) -> Self {
        let params = AxialParams::new(spec).expect("the start was checked, and bounds keep to what the law takes");
        let (state, scratch) = (AxialState::new(&params), AxialScratch::new(&params));
        Self { params, state, scratch, last: None }
    }

    fn open(&self) -> usize {
        self.state.tip_open
    }

    fn go(&mut self, to: TimedSample) -> AxialOutput {
        self.last = Some(to);
        let input = AxialInput { t_s: to.t_s, x_m: to.depth_m, incidence: Incidence::UPRIGHT };
        if !self.state.is_later(to.t_s) {
            return self.state.last_output();
        }
        step(&self.params, &mut self.state, &mut self.scratch, &input)
    }

    /// Advances towards a sample as far as a depth, in m.
    fn go_part(&mut self, to: TimedSample, depth_m: f64) -> AxialOutput {
        let Some(last) = self.last.filter(|last| last.depth_m < depth_m && depth_m < to.depth_m) else {
            return if self.last.is_some() { self.state.last_output() } else { self.go(to) };
        };
        let part = (depth_m - last.depth_m) / (to.depth_m - last.depth_m);
        self.go(TimedSample { t_s: last.t_s + part * (to.t_s - last.t_s), depth_m, ..to })
    }

    /// Lowers a threshold to the force that the boundary holds.
    #[expect(clippy::expect_used, reason = "a force of the law is finite, and it is made no less than 0")]
    fn give_way(&mut self, boundary: usize, held_n: f64) {
        let mut spec = self.params.spec().clone();
        spec.layers[boundary].tip_rupture_n = held_n.max(0.0);
        self.params = AxialParams::new(spec).expect("a threshold that a tent holds is one");
    }
}

/// Root mean square of law minus data over a timed curve, in N, for an unmodified specification, in
/// steps of at most 20 µm.
///
/// # Errors
/// If the law rejects the specification.
pub fn timed_residual_rms_n(spec: &AxialSpec, curve: &TimedCurve) -> Result<f64, law::axial::ParamError> {
    AxialParams::new(spec.clone())?;
    let law = spec.law.max(ForceLaw::Version3);
    let mut walk = LawWalk::new(AxialSpec { law, ..spec.clone() });
    let mut squares = 0.0;
    for &sample in &curve.samples {
        if let Some(last) = walk.last {
            let steps = ((sample.depth_m - last.depth_m).abs() / STRIDE_M).ceil().max(1.0) as u32;
            for at in 1..steps {
                let part = f64::from(at) / f64::from(steps);
                let (t_s, depth_m) =
                    (last.t_s + part * (sample.t_s - last.t_s), last.depth_m + part * (sample.depth_m - last.depth_m));
                walk.go(TimedSample { t_s, depth_m, ..sample });
            }
        }
        squares += (walk.go(sample).total_n() - sample.force_n).powi(2);
    }
    Ok((squares / curve.len() as f64).sqrt())
}
