//! Time of one step of the force law: three layers, two contactors. The bar is a median of 500 ns.

use std::hint::black_box;

use bench::scenes::training;
use criterion::{Criterion, criterion_group, criterion_main};
use mechanics::axial::{AxialInput, AxialParams, AxialScratch, AxialSpec, AxialState, Layer, step};
use mechanics::operator::needle_pose;
use mechanics::puncture::{PunctureInput, PunctureParams, PunctureScratch, PunctureSpec, PunctureState};
use mechanics::tissue::follow::{Field, FollowState, TissueSpec, recoil_time_s};
use mechanics::tissue::{ElasticLayer, Judging, Slab};
use nalgebra::{Point3, Vector3};

/// Strokes of 30 mm, 4 s each way at 1 kHz: every stage and both directions.
fn displacement_m(tick: u32) -> f64 {
    let phase = tick % 8000;
    let part = if phase < 4000 { phase } else { 8000 - phase };
    f64::from(part) * 7.5e-6 - 0.001
}

fn force(criterion: &mut Criterion) {
    let Ok(params) = AxialParams::new(training()) else { return };
    let mut scratch = AxialScratch::new(&params);
    let mut state = AxialState::new(&params);
    let mut tick = 0;
    criterion.bench_function("axial step, three layers, two contactors", |bencher| {
        bencher.iter(|| {
            if tick % 8000 == 0 {
                (state.tip_open, state.rim_open, state.deepest_m) = (0, 0, 0.0);
            }
            let input = AxialInput { t_s: f64::from(tick) * 1e-3, x_m: displacement_m(tick), path_factor: 1.0 };
            tick += 1;
            step(black_box(&params), &mut state, &mut scratch, black_box(&input))
        });
    });
}

/// The tissue of the training lower back under a needle of 1 mm radius, its stiffnesses feeding the law.
fn tissue(axial: &AxialSpec) -> TissueSpec {
    let elastic = |layer: &Layer| ElasticLayer {
        thickness_m: layer.thickness_m,
        youngs_modulus_pa: layer.stiffness_n_per_m * (1.0 - 0.45 * 0.45) / 0.002,
        poisson_ratio: 0.45,
        density_kg_per_m3: 1050.0,
    };
    let slab = Slab { layers: axial.layers.iter().map(elastic).collect(), radius_m: 0.1 };
    TissueSpec {
        boundaries_m: slab.boundaries_m(),
        recoil_time_s: slab.layers.iter().map(|layer| recoil_time_s(layer, 0.001)).collect(),
        slab,
        load_radius_m: 0.001,
        tilt_rad: 0.0,
        model: None,
        tolerance: 0.05,
        judging: Judging::default(),
        coupled: true,
    }
}

/// What a needle that bends, and a law coupled to the field, add to a step of the puncture.
fn puncture(criterion: &mut Criterion) {
    let plain = || PunctureSpec {
        axial: training(),
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.15,
        needle_bending_n_m2: None,
        structures: vec![],
        tissue: None,
    };
    let cases = [
        ("puncture step, three layers, two contactors", plain()),
        ("puncture step, a needle that bends", PunctureSpec { needle_bending_n_m2: Some(2e-3), ..plain() }),
        ("puncture step, coupled to the field", PunctureSpec { tissue: Some(tissue(&training())), ..plain() }),
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
                mechanics::puncture::step(black_box(&params), &mut state, &mut scratch, black_box(&input))
            });
        });
        if let Some(field) = params.field() {
            follow(criterion, field, |loads_n| mechanics::puncture::loads(&params, &state, &scratch, loads_n));
        }
    }
}

/// One step of the field: take the law's loads, follow, and tent every boundary.
fn follow(criterion: &mut Criterion, field: &Field, take: impl Fn(&mut [f64])) {
    let mut followed = FollowState::new(field.follow());
    let mut latest_n = followed.loads_n.clone();
    criterion.bench_function("field step, three layers", |bencher| {
        bencher.iter(|| {
            take(&mut latest_n);
            mechanics::tissue::follow::step(field.follow(), &mut followed, 1.0 / 120.0, black_box(&latest_n));
            (0..3).map(|boundary| field.on_axis().axial_m(boundary, &followed.loads_n)).sum::<f64>()
        });
    });
}

criterion_group!(benches, force, puncture);
criterion_main!(benches);
