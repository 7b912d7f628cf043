//! Duration of one step of the force law: three layers, two contactors. The target is a median of
//! 500 ns.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use law::Incidence;
use law::axial::{AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState, step};
use law::operator::needle_pose;
use law::puncture::{PunctureInput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState};
use nalgebra::{Point3, Vector3};
use trials::scenes::{optioned_axial_spec, training_axial_spec};

/// Strokes of 30 mm, 4 s each way at 1 kHz: every stage and both directions.
fn displacement_m(tick: u32) -> f64 {
    let phase = tick % 8000;
    let part = if phase < 4000 { phase } else { 8000 - phase };
    f64::from(part) * 7.5e-6 - 0.001
}

fn force(criterion: &mut Criterion) {
    time_steps(criterion, "axial step, three layers, two contactors", training_axial_spec());
    time_steps(criterion, "axial step, every option of version 3", optioned_axial_spec());
}

fn time_steps(criterion: &mut Criterion, name: &str, spec: AxialSpec) {
    let Ok(params) = AxialParams::new(spec) else { return };
    let mut scratch = AxialScratch::new(&params);
    let mut state = AxialState::new(&params);
    let mut tick = 0;
    criterion.bench_function(name, |bencher| {
        bencher.iter(|| {
            if tick % 8000 == 0 {
                (state.tip_open, state.rim_open, state.deepest_m) = (0, 0, 0.0);
            }
            let input =
                AxialInput { t_s: f64::from(tick) * 1e-3, x_m: displacement_m(tick), incidence: Incidence::UPRIGHT };
            tick += 1;
            step(black_box(&params), &mut state, &mut scratch, black_box(&input))
        });
    });
}

/// Cost of a flexible needle in a step of the puncture.
fn puncture(criterion: &mut Criterion) {
    let plain = || PunctureSpec {
        axial: training_axial_spec(),
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.15,
        hub_stiffness_n_per_m: None,
        needle_bending_n_m2: None,
        skin: law::Skin::Flat,
        structures: vec![],
    };
    let cases = [
        ("puncture step, three layers, two contactors", plain()),
        ("puncture step, a needle that bends", PunctureSpec { needle_bending_n_m2: Some(2e-3), ..plain() }),
    ];
    for (name, spec) in cases {
        let Ok(params) = PunctureParams::new(spec) else { return };
        let (mut state, mut scratch) = (PunctureState::new(&params), PunctureScratch::new(&params));
        let mut tick = 0;
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                let tip_m = Point3::new(1e-4, 0.0, -displacement_m(tick));
                let patient_from_needle = needle_pose(&tip_m, &-Vector3::z());
                let input = PunctureInput { t_s: f64::from(tick) * 1e-3, patient_from_needle };
                tick += 1;
                law::puncture::step(black_box(&params), &mut state, &mut scratch, black_box(&input))
            });
        });
    }
}

criterion_group!(benches, force, puncture);
criterion_main!(benches);
