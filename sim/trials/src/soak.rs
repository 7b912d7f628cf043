//! Soak test: a scene under random needle motion, checked at every tick.
//!
//! Slow insertions and withdrawals, stabs at 1 m/s, teleports, oblique re-entries, rests, and NaN
//! or repeated samples, in an order drawn from a seed. For every motion, forces stay finite and
//! below the scene's bound, the ledger closes, dissipated energy never decreases, and the field
//! stays finite, dented no farther than the law or half of the body.

use law::ledger::Ledger;
use law::operator::{Draw, needle_pose};
use law::puncture::{
    PunctureEvent, PunctureInput, PunctureOutput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState, step,
};
use law::stance::Follows;
use nalgebra::{Point3, Vector3};
use tissue::follow::{Field, Follower};

use super::needle::DT;

/// The steepest path, in degrees: the steepest oblique of physics section 8.
const STEEPEST_DEG: f64 = 60.0;

/// Lateral offset of a target, in m: three standard deviations.
const ASIDE_M: f64 = 0.004;

/// The deepest target of a teleport, in m.
const TELEPORT_M: f64 = 0.05;

/// Results of a soak test. Every figure is the maximum over all ticks; none may be NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Soaked {
    /// Ticks of 1 ms.
    pub ticks: u32,
    /// Number of tracks.
    pub tracks: usize,
    /// Number of ruptures.
    pub ruptures: usize,
    /// Largest elastic, friction and cutting force, in N.
    pub force_n: f64,
    /// Upper bound of that force in this scene, in N.
    pub force_bound_n: f64,
    /// Largest imbalance of the ledger, relative to the input.
    pub closure: f64,
    /// Largest decrease of the dissipated energy in a tick, in J.
    pub undone_j: f64,
    /// Largest displacement of a boundary by the field that follows the needle, in m; 0 without a
    /// field.
    pub tent_m: f64,
    /// Largest ratio of a displacement to its bound: the larger of the law's own dents under tip
    /// and rim, and of half of the body's depth along the needle.
    pub tent_share: f64,
    /// Largest distance of a boundary below the base, or below the tip if that is deeper, in m.
    pub beyond_m: f64,
    /// Number of steps of the field in which an opened boundary was drawn at the tip.
    pub at_tip: usize,
    /// Number of ticks in which the force on the hand or the field was not finite.
    pub not_finite: usize,
}

impl Soaked {
    /// Returns whether every bound holds.
    #[must_use]
    pub fn passes(&self) -> bool {
        let is_sound = self.not_finite == 0 && self.closure <= 1e-3 && self.undone_j <= 0.0;
        let is_inside = self.tent_share <= 1.0 + ROUND_OFF && self.beyond_m <= ROUND_OFF && self.at_tip == 0;
        is_sound && is_inside && self.force_n <= self.force_bound_n
    }
}

/// Rounding error of a sum, of energies relative to the sum, of lengths in m.
const ROUND_OFF: f64 = 1e-12;

/// Moves a needle at random through a scene for `ticks` ticks of 1 ms, with the field, if there is
/// one.
#[must_use]
pub fn soak(params: &PunctureParams, field: Option<&Field>, ticks: u32, seed: u64) -> Soaked {
    let (mut state, mut scratch) = (PunctureState::new(params), PunctureScratch::new(params));
    let mut hand = SeededHand::new(params.spec(), seed);
    let mut seen = Soaked { ticks, force_bound_n: force_bound_n(params.spec()), ..Soaked::default() };
    let mut follower = field.map(|field| Follower::new(params, field, Follows::Secant));
    let mut dissipated_j = 0.0;
    for tick in 0..ticks {
        let input = hand.sample(f64::from(tick) * DT);
        let output = step(params, &mut state, &mut scratch, &input);
        seen.tick(&output, state.ledger(), &mut dissipated_j);
        if let Some(follower) = follower.as_mut().filter(|_| tick % FIELD_TICKS == 0) {
            follower.step(f64::from(FIELD_TICKS) * DT, &state, &scratch);
            seen.tents(follower, scratch.boundaries_m());
        }
        seen.ruptures += scratch.events.iter().filter(|event| matches!(event, PunctureEvent::Rupture(_))).count();
    }
    seen.tracks = state.tracks();
    seen
}

/// Ticks per step of the field: 125 Hz.
const FIELD_TICKS: u32 = 8;

impl Soaked {
    /// Adds the dents of a field, with the resting positions of the boundaries and of the base along
    /// the needle.
    fn tents(&mut self, follower: &Follower<'_>, rest_m: &[f64]) {
        let base_m = rest_m.last().copied().unwrap_or(f64::INFINITY);
        let (pressed, tip_m, tip_open) = follower.needle().map_or(([None; 2], f64::NEG_INFINITY, 0), |needle| {
            (needle.pressed(rest_m), needle.tip_m, needle.tip_open)
        });
        let bound_m = pressed.iter().flatten().map(|pressed| pressed.dent_m).fold(0.5 * base_m, f64::max);
        for (boundary, (&tent_m, rest_m)) in follower.dents_m().iter().zip(rest_m).enumerate() {
            self.not_finite += usize::from(!tent_m.is_finite());
            self.tent_m = libm::fmaximum(self.tent_m, tent_m.abs());
            self.tent_share = libm::fmaximum(self.tent_share, tent_m.abs() / bound_m);
            self.beyond_m = libm::fmaximum(self.beyond_m, rest_m + tent_m - base_m.max(tip_m));
            let is_at_tip = (rest_m + tent_m - tip_m).abs() < 1e-3 * (tip_m - rest_m).abs();
            let is_pressed = pressed.iter().flatten().any(|pressed| pressed.boundary == boundary);
            self.at_tip += usize::from(boundary < tip_open && is_at_tip && !is_pressed);
        }
    }

    fn tick(&mut self, output: &PunctureOutput, ledger: &Ledger, dissipated_j: &mut f64) {
        let axial = &output.axial;
        self.force_n = libm::fmaximum(self.force_n, (axial.total_n() - axial.viscous_n).abs());
        self.not_finite += usize::from(!output.force_n.iter().all(|part| part.is_finite()));
        // At the first micrometre of a motion there is no input yet to compare with.
        let share = ledger.closure_error_j().abs() / ledger.input_j.max(1e-9);
        self.closure = libm::fmaximum(self.closure, share);
        // Energy that viscosity returns within the speed window is accounted for separately and
        // does not undo dissipation.
        let spent_j = ledger.dissipated_j() + ledger.lagged_j;
        self.undone_j = libm::fmaximum(self.undone_j, *dissipated_j - spent_j - ROUND_OFF * spent_j);
        *dissipated_j = spent_j;
    }
}

/// Returns the upper bound of elasticity, friction and cutting, in N: the largest pair of
/// thresholds (no boundary remains tented above its own), multiplied by the additional hold of the
/// branches at any speed; Σ c d along the steepest path; the largest cutting force.
fn force_bound_n(spec: &PunctureSpec) -> f64 {
    let largest = |of: fn(&law::axial::Layer) -> f64| spec.axial.layers.iter().map(of).fold(0.0, f64::max);
    // A rate-dependent threshold may rise to its limit at high speed.
    let rate = spec.axial.rate.as_ref().map_or(0.0, |rate| rate.p_infinity_n);
    let steepest = 1.0 / libm::cos(STEEPEST_DEG.to_radians());
    let friction_n: f64 =
        spec.axial.layers.iter().map(|layer| layer.static_friction_n_per_m() * layer.thickness_m).sum();
    largest(|l| l.tip_rupture_n * l.options.greatest_hold()).max(rate)
        + largest(|l| l.rim_rupture_n * l.options.greatest_hold()).max(rate)
        + friction_n * steepest
        + largest(|l| l.cutting_n)
}

/// A segment of the motion.
#[derive(Clone, Copy)]
enum Piece {
    /// Straight motion.
    Straight,
    /// Immediate motion to the end.
    Teleport,
    /// NaN samples; the needle does not move.
    NotANumber,
    /// Time stamps two ticks in the past; the needle does not move.
    Repeated,
}

/// A hand that draws its motion from a seed.
struct SeededHand {
    draw: Draw,
    deepest_m: f64,
    piece: Piece,
    from_m: Point3<f64>,
    to_m: Point3<f64>,
    axis: Vector3<f64>,
    ticks: u32,
    done: u32,
}

impl SeededHand {
    fn new(spec: &PunctureSpec, seed: u64) -> Self {
        let deepest_m = 0.01 + spec.axial.layers.iter().map(|layer| layer.thickness_m).sum::<f64>();
        let from_m = Point3::new(0.0, 0.0, 0.001);
        Self {
            draw: Draw::new(seed),
            deepest_m,
            piece: Piece::Straight,
            from_m,
            to_m: from_m,
            axis: -Vector3::z(),
            ticks: 1,
            done: 1,
        }
    }

    fn sample(&mut self, t_s: f64) -> PunctureInput {
        if self.done == self.ticks {
            self.next();
        }
        self.done += 1;
        let part = f64::from(self.done) / f64::from(self.ticks);
        let straight_m = self.from_m + (self.to_m - self.from_m) * part;
        let (tip_m, t_s) = match self.piece {
            Piece::Straight => (straight_m, t_s),
            Piece::Teleport => (self.to_m, t_s),
            Piece::NotANumber => (straight_m * f64::NAN, t_s),
            Piece::Repeated => (straight_m, t_s - 2.0 * DT),
        };
        PunctureInput { t_s, patient_from_needle: needle_pose(&tip_m, &self.axis) }
    }

    /// Draws the next segment.
    fn next(&mut self) {
        (self.from_m, self.done) = (self.to_m, 0);
        let depth_m = self.draw.uniform() * self.deepest_m;
        let aside_m = Vector3::new(self.draw.normal(ASIDE_M / 3.0), self.draw.normal(ASIDE_M / 3.0), 0.0);
        let (piece, to_m, speed_m_per_s) = match (8.0 * self.draw.uniform()) as u32 {
            0..=1 => (Piece::Straight, self.at(depth_m), 0.002 + 0.05 * self.draw.uniform()),
            2..=3 => (Piece::Straight, self.at(-0.002) + aside_m, 0.05),
            4 => (Piece::Straight, self.at(self.deepest_m), 1.0),
            5 => (Piece::Teleport, self.at(depth_m.min(TELEPORT_M)) + aside_m, 1.0),
            6 => (Piece::NotANumber, self.from_m, 1.0),
            _ => (Piece::Repeated, self.from_m, 1.0),
        };
        (self.piece, self.to_m) = (piece, to_m);
        let travel_s = (self.to_m - self.from_m).norm() / speed_m_per_s;
        self.ticks = 1 + (travel_s / DT) as u32 + (200.0 * self.draw.uniform()) as u32;
        if self.from_m.z > 0.0 {
            let tilt = self.draw.uniform() * STEEPEST_DEG.to_radians();
            let round = core::f64::consts::TAU * self.draw.uniform();
            let aside = libm::sin(tilt);
            self.axis = Vector3::new(aside * libm::cos(round), aside * libm::sin(round), -libm::cos(tilt));
        }
    }

    /// Returns the point of the needle's path at a depth, in m.
    fn at(&self, depth_m: f64) -> Point3<f64> {
        self.from_m + self.axis * ((depth_m + self.from_m.z) / -self.axis.z)
    }
}
