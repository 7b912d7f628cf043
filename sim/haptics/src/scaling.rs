//! Scales the forces of a scene to a device by a single factor, and describes the result.

use std::fmt;

use law::axial::{AxialSpec, Layer};
use law::closed_form;
use law::soundness::turned_specs;
use phrase::{Phrase, phrase};

use crate::device::DeviceInfo;

/// Expected overshoot of the target, in m (choice): deeper boundaries do not weaken the forces on
/// the way to it. If the needle does reach them, the safety chain limits the force.
const OVERSHOOT_M: f64 = 0.005;

/// The property of a device that limits a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// No limit applies.
    None,
    /// The device's maximum force.
    Force,
    /// The device's maximum stiffness.
    Stiffness,
    /// The device has no motors.
    NoMotors,
}

/// The factor for all forces of an attempt. Motion is never scaled, so stiffness scales with force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Force on the handle divided by force in the scene, from 0 to 1.
    pub factor: f64,
    /// The limit that determined the factor.
    pub limit: Limit,
    /// Largest axial force on the way to the target, in N, unscaled.
    pub peak_n: f64,
    /// Stiffest boundary on that way, in N/m, unscaled.
    pub stiffest_n_per_m: f64,
    /// Softest boundary on that way, in N/m, unscaled.
    pub softest_n_per_m: f64,
    /// Maximum stiffness of the device, in N/m.
    pub device_n_per_m: f64,
}

impl Scaling {
    /// Fits a scene to a device. `target_x_m` is the axial displacement that the exercise requires,
    /// in m: only boundaries up to it are counted. Bone is not counted: it is a wall on any device,
    /// and the device's force limit caps it.
    #[must_use]
    pub fn new(spec: &AxialSpec, target_x_m: f64, info: &DeviceInfo) -> Self {
        let met = met(spec, target_x_m + OVERSHOOT_M);
        let has_rim = spec.tip_to_rim_m > 0.0;
        let stiffest_n_per_m = met.iter().map(|layer| layer.greatest_stiffness_n_per_m(has_rim)).fold(0.0, f64::max);
        let softest_n_per_m = met.iter().map(|layer| layer.stiffness_n_per_m).fold(f64::INFINITY, f64::min);
        let peak_n = peak_n(spec, met.len());
        let by_force = info.max_force_n / peak_n.max(f64::MIN_POSITIVE);
        let by_stiffness = info.max_stiffness_n_per_m / stiffest_n_per_m.max(f64::MIN_POSITIVE);
        let (factor, limit) = match by_force.min(by_stiffness) {
            _ if info.max_force_n <= 0.0 => (0.0, Limit::NoMotors),
            least if least >= 1.0 => (1.0, Limit::None),
            least if by_force <= by_stiffness => (least, Limit::Force),
            least => (least, Limit::Stiffness),
        };
        let device_n_per_m = info.max_stiffness_n_per_m;
        Self { factor, limit, peak_n, stiffest_n_per_m, softest_n_per_m, device_n_per_m }
    }

    /// Largest scaled force on the way to the target, in N.
    #[must_use]
    pub fn scaled_peak_n(&self) -> f64 {
        self.peak_n * self.factor
    }

    /// Describes the scaling as a translatable phrase.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        let peak = Phrase::number(self.peak_n, 1);
        let scaled = Phrase::number(self.scaled_peak_n(), 1);
        match self.limit {
            Limit::None => phrase!("forces as they are: up to {peak} N", peak = peak),
            Limit::Force => phrase!("scaled to this device: {peak} N → {scaled} N", peak = peak, scaled = scaled),
            Limit::Stiffness => phrase!(
                "scaled to this device: {peak} N → {scaled} N ({stiffest} N/m → {device} N/m)",
                peak = peak,
                scaled = scaled,
                stiffest = Phrase::number(self.stiffest_n_per_m, 0),
                device = Phrase::number(self.device_n_per_m, 0)
            ),
            Limit::NoMotors => phrase!("this device shows no force: {peak} N on the gauge only", peak = peak),
        }
    }

    /// Softest scaled boundary, in N/m.
    #[must_use]
    pub fn scaled_softest_n_per_m(&self) -> f64 {
        self.softest_n_per_m * self.factor
    }
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.phrase().fmt(f)
    }
}

/// The layers whose boundary lies within `reach_m`, in m; always includes the first one.
fn met(spec: &AxialSpec, reach_m: f64) -> &[Layer] {
    let mut depth_m = 0.0;
    let beyond = spec.layers.iter().skip(1).zip(&spec.layers).position(|(_, above)| {
        depth_m += above.thickness_m;
        depth_m > reach_m
    });
    spec.layers.get(..beyond.map_or(spec.layers.len(), |index| index + 1)).unwrap_or_default()
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

    fn layer(thickness_m: f64, stiffness_n_per_m: f64, tip_rupture_n: f64) -> Layer {
        Layer {
            name: String::new(),
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
            layers: vec![layer(0.034, 543.0, 6.0), layer(0.022, 970.0, 12.1), layer(0.002, 4000.0, 3.0)],
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
        assert_eq!(words(device(10.0, 400.0)), "scaled to this device: 12.1 N → 5.0 N (970 N/m → 400 N/m)");
        assert_eq!(words(device(40.0, 1e4)), "forces as they are: up to 12.1 N");
        assert_eq!(words(device(0.0, 0.0)), "this device shows no force: 12.1 N on the gauge only");
    }

    #[test]
    fn what_lies_beyond_the_target_does_not_weaken_the_way_there() {
        let near = Scaling::new(&epidural(), 0.048, &device(10.0, 1000.0));
        assert_eq!((near.stiffest_n_per_m, near.limit), (970.0, Limit::Force));
        let deep = Scaling::new(&epidural(), 0.056, &device(10.0, 1000.0));
        assert_eq!((deep.stiffest_n_per_m, deep.limit), (4000.0, Limit::Stiffness));
        let shallow = Scaling::new(&epidural(), 0.0, &device(10.0, 1000.0));
        assert_eq!((shallow.stiffest_n_per_m, shallow.factor), (543.0, 1.0));
    }

    #[test]
    fn the_scaled_scene_fits_the_device() {
        for (force_n, stiffness) in [(3.3, 400.0), (3.3, 700.0), (7.9, 1000.0), (10.0, 1000.0)] {
            let scaling = Scaling::new(&epidural(), 0.048, &device(force_n, stiffness));
            assert!(scaling.scaled_peak_n() <= force_n * (1.0 + 1e-12));
            assert!(scaling.stiffest_n_per_m * scaling.factor <= stiffness * (1.0 + 1e-12));
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
