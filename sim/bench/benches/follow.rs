//! Duration of one step of a puncture whose law is coupled to the field, and of one step of the
//! field.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use law::Judging;
use law::axial::{AxialSpec, Layer};
use law::operator::needle_pose;
use law::puncture::{PunctureInput, PunctureScratch, PunctureSpec, PunctureState};
use nalgebra::{Point3, Vector3};
use tissue::follow::{Field, FollowState, TissueSpec, recoil_time_s};
use tissue::{ElasticLayer, Slab, Specimen, SpecimenSpec};
use trials::scenes::training_axial_spec;

/// Strokes of 30 mm, 4 s each way at 1 kHz: every stage and both directions.
fn displacement_m(tick: u32) -> f64 {
    let phase = tick % 8000;
    let part = if phase < 4000 { phase } else { 8000 - phase };
    f64::from(part) * 7.5e-6 - 0.001
}

/// The tissue of the training lower back under a needle of 1 mm radius, with its stiffnesses
/// coupled to the law.
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
        skin: law::Skin::Flat,
        inclusions: Vec::new(),
        model: None,
        tolerance: 0.05,
        judging: Judging::default(),
        coupled: true,
    }
}

/// A law coupled to the field, and the field that follows it.
fn coupled(criterion: &mut Criterion) {
    let puncture = PunctureSpec {
        axial: training_axial_spec(),
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.15,
        hub_stiffness_n_per_m: None,
        needle_bending_n_m2: None,
        skin: law::Skin::Flat,
        structures: vec![],
    };
    let spec = SpecimenSpec { tissue: Some(tissue(&puncture.axial)), puncture };
    let Ok(specimen) = Specimen::new(spec) else { return };
    let params = specimen.law();
    let (mut state, mut scratch) = (PunctureState::new(params), PunctureScratch::new(params));
    let mut tick = 0;
    criterion.bench_function("puncture step, coupled to the field", |bencher| {
        bencher.iter(|| {
            let tip_m = Point3::new(1e-4, 0.0, -displacement_m(tick));
            let patient_from_needle = needle_pose(&tip_m, &-Vector3::z());
            let input = PunctureInput { t_s: f64::from(tick) * 1e-3, patient_from_needle };
            tick += 1;
            law::puncture::step(black_box(params), &mut state, &mut scratch, black_box(&input))
        });
    });
    if let Some(field) = specimen.field() {
        follow(criterion, field, |loads_n| law::puncture::write_loads(params, &state, &scratch, loads_n));
    }
}

/// One step of the field: read the law's loads, follow, and compute the tent of every boundary.
fn follow(criterion: &mut Criterion, field: &Field, take: impl Fn(&mut [f64])) {
    let mut followed = FollowState::new(field.follow());
    let mut latest_n = followed.loads_n.clone();
    criterion.bench_function("field step, three layers", |bencher| {
        bencher.iter(|| {
            take(&mut latest_n);
            tissue::follow::step(field.follow(), &mut followed, 1.0 / 120.0, black_box(&latest_n));
            (0..3).map(|boundary| field.planned().axial_m(boundary, &followed.loads_n)).sum::<f64>()
        });
    });
}

criterion_group!(benches, coupled);
criterion_main!(benches);
