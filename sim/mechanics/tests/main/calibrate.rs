//! The fit of layers to a force–depth curve: it finds again what a curve was made from, is never worse than its start,
//! never unsound, and says what a curve does not tell.
//!
//! Would fail on a wrong place of a rupture, a wrong derivative, a bound that is not kept, a constraint that is forgotten, or
//! a standard error that does not cover the truth.

use mechanics::axial::{AxialSpec, Layer};
use mechanics::calibrate::{CalibrateError, Curve, Fit, Fresh, Quantity, Standing, Start, fit, residual_rms_n};
use mechanics::soundness;
use proptest::prelude::*;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::scenes::{Run, layer, training};

/// A needle without a rim through skin, fat and muscle whose boundaries all give way within 30 mm.
fn needle() -> AxialSpec {
    AxialSpec {
        layers: vec![
            layer("skin", [3.0, 400.0, 0.0, 2.0, 0.0, 60.0, 0.3]),
            layer("fat", [12.0, 300.0, 0.0, 1.2, 0.0, 15.0, 0.1]),
            layer("muscle", [30.0, 600.0, 0.0, 3.0, 0.0, 40.0, 0.3]),
        ],
        tip_to_rim_m: 0.0,
        presliding_stiffness_n_per_m: 2000.0,
        rate: None,
    }
}

/// A sample every 0.05 mm: in to `deepest_mm`, and back out to `back_mm`.
fn track(deepest_mm: f64, back_mm: f64) -> Vec<f64> {
    let steps = |mm: f64| (mm / 0.05).round() as u32;
    let inwards = (0..=steps(deepest_mm)).map(|n| f64::from(n) * 0.05e-3);
    let outwards = (1..=steps(deepest_mm - back_mm)).map(|n| deepest_mm * 1e-3 - f64::from(n) * 0.05e-3);
    inwards.chain(outwards).collect()
}

/// The law's forces along a track, slowly, with white noise of a deviation.
fn measured(spec: &AxialSpec, track: &[f64], noise_n: f64) -> Vec<(f64, f64)> {
    let mut slow = spec.clone();
    slow.layers.iter_mut().for_each(|layer| layer.damping_n_s_per_m2 = 0.0);
    let mut run = Run::new(slow);
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut noise = || {
        let uniform: f64 = (0..12).map(|_| f64::from(random.next_u32()) / f64::from(u32::MAX)).sum();
        noise_n * (uniform - 6.0)
    };
    track.iter().enumerate().map(|(n, &x)| (x, run.step(n as f64, x).total_n() + noise())).collect()
}

fn curve(samples: &[(f64, f64)]) -> Curve {
    Curve::new(samples).expect("a curve")
}

fn quietly(curve: &Curve, start: Start<'_>) -> Fit {
    fit(curve, start, &mut |_| ()).expect("a fit")
}

fn fresh(layers: Option<usize>) -> Start<'static> {
    Start::Fresh(Fresh { layers, tip_to_rim_m: 0.0 })
}

/// A layer's number and the standard error of it.
fn estimate(fit: &Fit, layer: usize, quantity: Quantity) -> (f64, Option<f64>) {
    let found = fit.estimates.iter().find(|e| e.layer == layer && e.quantity == quantity).expect("an estimate");
    (found.value, found.standard_error)
}

fn near(value: f64, truth: f64, relative: f64) -> bool {
    (value - truth).abs() <= relative * truth.abs()
}

#[test]
fn a_clean_curve_gives_back_what_it_was_made_from() {
    let truth = needle();
    let fit = quietly(&curve(&measured(&truth, &track(32.0, 32.0), 0.0)), fresh(None));
    eprintln!("{fit:#?}");
    assert_eq!(fit.spec.layers.len(), 3);
    assert!(fit.rms_n < 2e-3, "{} N", fit.rms_n);
    for (found, truth) in fit.spec.layers.iter().zip(&truth.layers) {
        assert!(near(found.stiffness_n_per_m, truth.stiffness_n_per_m, 0.01), "{found:?}");
        // A sample every 0.05 mm leaves the place, and so the threshold, open by 25 µm · k.
        let place_n = 25e-6 * truth.stiffness_n_per_m + 1e-3;
        assert!((found.tip_rupture_n - truth.tip_rupture_n).abs() < place_n, "{found:?}");
    }
}
