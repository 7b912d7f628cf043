//! A scene scaled to a device: one factor on every force, a lesser one at boundaries too stiff for it, and the words for both.

use std::fmt;

use law::axial::{AxialSpec, Contactor, Layer};
use law::closed_form;
use law::puncture::{PunctureOutput, PunctureState};
use law::soundness::{find_unsound_ruptures, turned_specs};
use nalgebra::Vector3;
use phrase::{Phrase, phrase};

use crate::device::DeviceInfo;

/// A pop below this is lost in the friction of an arm, in N: a Phantom Omni has 0.26 N.
pub const FELT_POP_N: f64 = 0.3;

/// The springs of friction and cutting together are at most so many times as stiff as what the device can show (choice): they give way
/// after a few tenths of a millimetre, and store little. `tests/main/passivity.rs` holds a free handle to that.
const MOST_SLIDING: f64 = 2.5;

/// The limit that a device sets to a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// None.
    None,
    /// Its largest force.
    Force,
    /// It has no motors.
    NoMotors,
}

/// The forces of a scene on a device. Motion is never scaled, and boundaries give way where they do: each is as stiff as the device
/// can show, and what is felt of its force goes down with that.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// Force on the handle per force of the scene, from 0 to 1, of everything but boundaries, friction and cutting.
    pub factor: f64,
    /// The same of friction and cutting, which hold a spring each: less where the two are far stiffer than the device can show.
    pub sliding_factor: f64,
    /// Why `factor` is less than 1.
    pub limit: Limit,
    /// Largest axial force on the way to the target, in N, unscaled.
    pub peak_n: f64,
    /// The same as the device shows it, in N.
    pub scaled_peak_n: f64,
    /// Every boundary, from the skin down.
    pub boundaries: Vec<ScaledBoundary>,
    /// Softest boundary on the way to the target, in N/m, as the device shows it.
    pub scaled_softest_n_per_m: f64,
}

/// A boundary on a device.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaledBoundary {
    /// The layer's name.
    pub name: String,
    /// Force on the handle per force of the boundary, from 0 to 1; less than that of the scene where the boundary is too stiff.
    pub factor: f64,
    /// How far the force falls when the tip opens it slowly, in N, as the device shows it; none of a boundary beyond the target.
    pub pop_n: Option<f64>,
}

impl Scaling {
    /// Fits a scene to a device. `target_x_m` is the axial displacement that the exercise asks for, in m: force is scaled for the
    /// boundaries up to there alone. Bone does not count: it is a wall for any device, and the safety chain limits its force.
    #[must_use]
    pub fn new(spec: &AxialSpec, target_x_m: f64, info: &DeviceInfo) -> Self {
        let met = count_met(spec, target_x_m);
        let peak_n = peak_n(spec, met);
        let by_force = info.max_force_n / peak_n.max(f64::MIN_POSITIVE);
        let (factor, limit) = match by_force {
            _ if info.max_force_n <= 0.0 => (0.0, Limit::NoMotors),
            least if least >= 1.0 => (1.0, Limit::None),
            least => (least, Limit::Force),
        };
        let factors = boundary_factors(spec, factor, info.max_stiffness_n_per_m);
        let springs_n_per_m = 2.0 * spec.presliding_stiffness_n_per_m.max(f64::MIN_POSITIVE);
        let sliding_factor = factor.min(MOST_SLIDING * info.max_stiffness_n_per_m.max(0.0) / springs_n_per_m);
        let shown = scale_spec(spec, sliding_factor, &factors);
        let pops_n = tip_pops_n(&shown);
        let boundaries = shown.layers.iter().zip(&factors).enumerate().map(|(at, (layer, &factor))| ScaledBoundary {
            name: layer.name.clone(),
            factor,
            pop_n: pops_n.get(at).copied().filter(|_| at < met),
        });
        let softest = shown.layers.iter().take(met).map(|layer| layer.stiffness_n_per_m);
        Self {
            factor,
            sliding_factor,
            limit,
            peak_n,
            scaled_peak_n: self::peak_n(&shown, met),
            boundaries: boundaries.collect(),
            scaled_softest_n_per_m: softest.fold(f64::INFINITY, f64::min),
        }
    }

    /// No force at all, for an exercise that gives none.
    #[must_use]
    pub fn silent(self) -> Self {
        let silent = |boundary| ScaledBoundary { factor: 0.0, ..boundary };
        let boundaries = self.boundaries.into_iter().map(silent).collect();
        Self { factor: 0.0, sliding_factor: 0.0, scaled_peak_n: 0.0, boundaries, ..self }
    }

    /// The force of a tick on this device, in the patient frame, in N. Never allocates.
    #[must_use]
    pub fn apply(&self, state: &PunctureState, output: &PunctureOutput) -> Vector3<f64> {
        let less = |boundary: usize| self.boundaries.get(boundary).map_or(0.0, |b| self.factor - b.factor);
        let softened_n =
            less(state.axial.tip_open) * output.axial.tip_n + less(state.axial.rim_open) * output.axial.rim_n;
        let sliding_n = (self.factor - self.sliding_factor) * (output.axial.friction_n + output.axial.cutting_n);
        output.force_n * self.factor + state.latched_axis().unwrap_or_default() * (softened_n + sliding_n)
    }

    /// The boundaries up to the target that the device cannot show as stiff as they are.
    pub fn softened(&self) -> impl Iterator<Item = &ScaledBoundary> {
        self.boundaries.iter().filter(|boundary| boundary.pop_n.is_some() && boundary.factor < self.factor)
    }

    /// The boundaries up to the target whose pop is below [`FELT_POP_N`] on this device.
    pub fn unfelt(&self) -> impl Iterator<Item = &ScaledBoundary> {
        let has_force = self.factor > 0.0;
        self.boundaries
            .iter()
            .filter(move |boundary| has_force && boundary.pop_n.is_some_and(|pop_n| pop_n < FELT_POP_N))
    }

    /// What the device makes of the forces, as a sentence.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        let peak = Phrase::number(self.peak_n, 1);
        let scaled = Phrase::number(self.scaled_peak_n, 1);
        match self.limit {
            Limit::None => phrase!("forces unscaled: up to {peak} N", peak = peak),
            Limit::Force => phrase!("scaled to this device: {peak} N → {scaled} N", peak = peak, scaled = scaled),
            Limit::NoMotors => phrase!("this device has no force feedback: {peak} N on the gauge only", peak = peak),
        }
    }
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.phrase().fmt(f)
    }
}

/// How many boundaries lie within a displacement in m; the first in any case.
fn count_met(spec: &AxialSpec, reach_m: f64) -> usize {
    let mut depth_m = 0.0;
    let beyond = spec.layers.iter().skip(1).zip(&spec.layers).position(|(_, above)| {
        depth_m += above.thickness_m;
        depth_m > reach_m
    });
    beyond.map_or(spec.layers.len(), |index| index + 1)
}

/// The factor of each boundary: at most that of the scene, and so small that the boundary is no stiffer than the device can show.
///
/// Where that would let a rupture raise force or energy, since a softened boundary gives way to one that is not, those behind it are
/// softened as much. Factors that only fall keep a sound scene sound, so this ends.
fn boundary_factors(spec: &AxialSpec, factor: f64, device_n_per_m: f64) -> Vec<f64> {
    let has_rim = spec.tip_to_rim_m > 0.0;
    let softened = |layer: &Layer| {
        factor.min(device_n_per_m.max(0.0) / layer.greatest_stiffness_n_per_m(has_rim).max(f64::MIN_POSITIVE))
    };
    let mut factors: Vec<f64> = spec.layers.iter().map(softened).collect();
    for _ in 0..factors.len() {
        let unsound = find_unsound_ruptures(&scale_spec(spec, factor, &factors));
        let Some(first) = unsound.iter().map(|unsound| unsound.boundary).min() else { break };
        let most = factors.get(first).copied().unwrap_or(factor);
        factors.iter_mut().skip(first + 1).for_each(|factor| *factor = factor.min(most));
    }
    factors
}

/// The boundaries of a scene as the device shows them, each by its own factor, with friction and cutting by theirs.
fn scale_spec(spec: &AxialSpec, sliding_factor: f64, factors: &[f64]) -> AxialSpec {
    let scale = |(layer, own): (&Layer, &f64)| {
        let mut shown = layer.clone();
        for force in [
            &mut shown.stiffness_n_per_m,
            &mut shown.tip_rupture_n,
            &mut shown.rim_rupture_n,
            &mut shown.options.stiffening_n_per_m2,
        ] {
            *force *= own;
        }
        for force in [&mut shown.friction_n_per_m, &mut shown.cutting_n] {
            *force *= sliding_factor;
        }
        shown.options.static_friction_n_per_m = shown.options.static_friction_n_per_m.map(|n| n * sliding_factor);
        shown
    };
    AxialSpec { layers: spec.layers.iter().zip(factors).map(scale).collect(), ..spec.clone() }
}

/// How far the elastic force falls when the tip slowly opens each boundary, in N.
fn tip_pops_n(spec: &AxialSpec) -> Vec<f64> {
    let mut pops_n = vec![0.0; spec.layers.len()];
    for rupture in closed_form::predict_ruptures(spec) {
        if let (Contactor::Tip, Some(pop_n)) = (rupture.contactor, pops_n.get_mut(rupture.boundary)) {
            *pop_n = rupture.force_before_n - rupture.force_after_n;
        }
    }
    pops_n
}

/// Largest elastic force at which one of the first boundaries ruptures, plus the friction on the
/// shaft at that point, in N.
///
/// Counts the terms at the peak of a tent: no cutting, and viscosity is small at the speeds of a
/// puncture. Tents that relax rupture at other displacements for a slow needle than for a fast one,
/// and fibrous sheets for a rotated one: the largest force counts.
fn peak_n(spec: &AxialSpec, boundaries: usize) -> f64 {
    let speeds: &[f64] = if spec.relaxes() { &[0.0, 1.0] } else { &[0.0] };
    let at_speeds = |turned: AxialSpec| -> Vec<_> {
        speeds.iter().flat_map(|&held| closed_form::predict_held_ruptures(&turned, held)).collect()
    };
    let ruptures = turned_specs(spec).flat_map(at_speeds);
    let met = ruptures.filter(|rupture| rupture.boundary < boundaries);
    met.map(|rupture| rupture.force_before_n + friction_n(&spec.layers, rupture.boundary)).fold(0.0, f64::max)
}

/// Breakaway friction of a shaft that has passed the layers above a boundary, in N.
fn friction_n(layers: &[Layer], boundary: usize) -> f64 {
    layers.iter().take(boundary).map(|layer| layer.static_friction_n_per_m() * layer.thickness_m).sum()
}

#[cfg(test)]
mod tests {
    //! The factor must bring the forces on the whole way to the target within the device's limits,
    //! and the description must match the documented text.

    use law::axial::{ForceLaw, LayerOptions};

    use super::*;

    fn layer(name: &str, thickness_m: f64, stiffness_n_per_m: f64, tip_rupture_n: f64) -> Layer {
        Layer {
            name: name.to_owned(),
            thickness_m,
            stiffness_n_per_m,
            damping_n_s_per_m2: 0.0,
            tip_rupture_n,
            rim_rupture_n: 0.0,
            friction_n_per_m: 0.0,
            cutting_n: 0.0,
            options: LayerOptions::default(),
        }
    }

    /// A ligamentum flavum of 12.1 N at 970 N/m over a dura of 4000 N/m.
    fn epidural() -> AxialSpec {
        AxialSpec {
            law: ForceLaw::Version2,
            layers: vec![
                layer("skin", 0.034, 543.0, 6.0),
                layer("flavum", 0.022, 970.0, 12.1),
                layer("dura", 0.002, 4000.0, 3.0),
            ],
            tip_to_rim_m: 0.0,
            presliding_stiffness_n_per_m: 2000.0,
            speed_window_s: 0.0,
            damping_time_s: 0.0,
            rate: None,
            breakaway: None,
        }
    }

    fn device(max_force_n: f64, max_stiffness_n_per_m: f64) -> DeviceInfo {
        DeviceInfo {
            name: String::new(),
            serial: None,
            max_force_n,
            continuous_force_n: 0.88,
            max_stiffness_n_per_m,
            workspace_m: [0.16, 0.12, 0.07],
            measures_orientation: true,
            is_virtual: false,
        }
    }

    #[test]
    fn the_words_are_those_that_people_are_promised() {
        let words = |device| Scaling::new(&epidural(), 0.048, &device).to_string();
        assert_eq!(words(device(3.3, 400.0)), "scaled to this device: 12.1 N → 3.3 N");
        assert_eq!(words(device(10.0, 400.0)), "scaled to this device: 12.1 N → 5.0 N");
        assert_eq!(words(device(40.0, 1e4)), "forces unscaled: up to 12.1 N");
        assert_eq!(words(device(0.0, 0.0)), "this device has no force feedback: 12.1 N on the gauge only");
    }

    #[test]
    fn a_stiff_boundary_weakens_itself_alone() {
        let scaling = Scaling::new(&epidural(), 0.056, &device(3.3, 400.0));
        let [skin, flavum, dura] = [0, 1, 2].map(|at| scaling.boundaries[at].factor);
        let by_force = 3.3 / 12.1;
        assert!((scaling.factor - by_force).abs() < 1e-12 && (skin - by_force).abs() < 1e-12, "{scaling:?}");
        assert!((flavum - by_force).abs() < 1e-12, "970 N/m scaled by force are 265 N/m");
        assert!((dura - 0.1).abs() < 1e-12, "4000 N/m would be 1091 N/m");
        let names: Vec<&str> = scaling.softened().map(|boundary| boundary.name.as_str()).collect();
        assert_eq!((names, scaling.unfelt().count()), (vec!["dura"], 0), "its 3 N fall to 0.3 N");
        let near = Scaling::new(&epidural(), 0.048, &device(3.3, 400.0));
        assert_eq!(near.softened().count(), 0, "the dura lies beyond the target");
        let shallow = Scaling::new(&epidural(), 0.0, &device(10.0, 1000.0));
        assert_eq!((shallow.factor, shallow.limit), (1.0, Limit::None), "6 N of skin are no more than the device has");
    }

    #[test]
    fn a_pop_that_is_lost_in_the_arm_is_named() {
        let mut spec = epidural();
        spec.layers[2].tip_rupture_n = 1.0;
        let scaling = Scaling::new(&spec, 0.056, &device(3.3, 400.0));
        let unfelt: Vec<&str> = scaling.unfelt().map(|boundary| boundary.name.as_str()).collect();
        assert_eq!(unfelt, ["dura"], "{scaling:?}");
        assert_eq!(Scaling::new(&spec, 0.056, &device(0.0, 0.0)).unfelt().count(), 0, "without motors nothing is felt");
    }

    #[test]
    fn the_scaled_scene_fits_the_device_and_stays_sound() {
        let mut steep = epidural();
        // A stiff boundary just before a soft one that is deep in its tent by then.
        steep.layers[1] = Layer { thickness_m: 1e-4, ..layer("flavum", 0.022, 4000.0, 12.1) };
        steep.layers[2] = layer("dura", 0.002, 900.0, 3.0);
        for spec in [epidural(), steep] {
            for (force_n, stiffness) in [(3.3, 400.0), (3.3, 700.0), (7.9, 1000.0), (10.0, 1000.0)] {
                let scaling = Scaling::new(&spec, 0.048, &device(force_n, stiffness));
                assert!(scaling.scaled_peak_n <= force_n * (1.0 + 1e-12));
                let factors: Vec<f64> = scaling.boundaries.iter().map(|boundary| boundary.factor).collect();
                let shown = scale_spec(&spec, scaling.sliding_factor, &factors);
                assert!(shown.layers.iter().all(|l| l.stiffness_n_per_m <= stiffness * (1.0 + 1e-12)));
                assert_eq!(find_unsound_ruptures(&shown), [], "on {force_n} N, {stiffness} N/m");
            }
        }
    }

    #[test]
    fn friction_adds_to_the_peak() {
        let mut spec = epidural();
        spec.layers[0].friction_n_per_m = 10.0;
        let scaling = Scaling::new(&spec, 0.048, &device(3.3, 400.0));
        assert!((scaling.peak_n - 12.44).abs() < 1e-9, "{}", scaling.peak_n);
    }
}
