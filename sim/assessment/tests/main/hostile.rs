//! No recording makes the assessment panic, or hand out a number that is none.
//! Fails when a metric divides by an empty span, indexes past a short column or lets NaN through.

use assessment::{AssessError, assess};
use documents::{Shape, StructureKind};
use proptest::prelude::*;
use recording::{Event, EventKind, Recording, Sample};

use crate::support::{bundle, down, empty, event, ledger, limit, line, record, structure};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -0.1..0.1_f64,
        1 => Just(0.0),
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX), Just(-1e200), Just(1e-300)],
    ]
}

fn time_s() -> impl Strategy<Value = f64> {
    prop_oneof![8 => 0.0..2.0_f64, 1 => Just(1.0), 1 => number()]
}

fn sample() -> impl Strategy<Value = Sample> {
    let numbers = prop::array::uniform12(number());
    (time_s(), numbers, any::<bool>(), any::<u32>()).prop_map(|(t_s, n, unit, flags)| Sample {
        t_s,
        position_m: [n[0], n[1], n[2]],
        orientation: if unit { [1.0, 0.0, 0.0, 0.0] } else { [n[3], n[4], n[5], 1.0] },
        x_m: n[6],
        depth_m: n[7] as f32,
        force_n: [n[8] as f32, n[9] as f32, n[10] as f32],
        tip_n: n[11] as f32,
        flags,
        ..Sample::default()
    })
}

fn happening() -> impl Strategy<Value = Event> {
    let kinds = [
        EventKind::Contact,
        EventKind::TipRupture,
        EventKind::RimRupture,
        EventKind::StructureHit,
        EventKind::HubContact,
        EventKind::SkinExit,
        EventKind::Confirm,
    ];
    let index = prop::option::of(prop_oneof![0..5_u32, Just(u32::MAX)]);
    (prop::sample::select(kinds.to_vec()), sample(), index).prop_map(|(kind, sample, index)| {
        let event = event(kind, &sample, index);
        Event { structure: index, track: index, force_n: sample.x_m, ..event }
    })
}

fn recording() -> impl Strategy<Value = Recording> {
    let samples = prop::collection::vec(sample(), 0..80);
    let events = prop::collection::vec(happening(), 0..12);
    (samples, events, any::<bool>(), number()).prop_map(|(mut samples, events, sorted, joule)| {
        if sorted {
            samples.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        }
        let mut recording = Recording { samples, events, ..empty() };
        ledger(&mut recording, [joule, 0.0, 1e-3]);
        recording
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn nothing_panics_and_every_number_is_finite(recording in recording()) {
        let mut bundle = bundle();
        let triangle = [[0.0, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]].map(Into::into).to_vec();
        bundle.scene.structures = vec![
            structure("a", StructureKind::Vessel, Shape::Sphere { radius_m: 0.01 }, [0.0; 3]),
            structure("b", StructureKind::Target, Shape::Mesh { vertices_m: triangle, triangles: vec![[0, 1, 2], [0, 0, 9]] }, [1.0; 3]),
            structure("c", StructureKind::Bone, Shape::Box { half_extents_m: [0.01, 0.0, 0.02].into() }, [0.0, 5.0, -9.0]),
        ];
        bundle.exercise.rubric.push(line("smoothness_ldlj", -5.0, -20.0, 2.0));
        bundle.exercise.hard_fails.push(limit("peak_force_n", 0.05, "Too hard."));
        if let Ok(assessment) = assess(&recording, &bundle) {
            prop_assert!((0.0..=100.0).contains(&assessment.score), "{}", assessment.score);
            prop_assert!(assessment.deductions.iter().all(|d| d.points.is_finite() && d.points >= 0.0));
            for metric in &assessment.metrics {
                prop_assert_eq!(metric.value.is_some(), metric.applies);
                prop_assert!(metric.value.is_none_or(f64::is_finite), "{:?}", metric);
            }
            let json = serde_json::to_string(&assessment).expect("plain data");
            let back: assessment::Assessment = serde_json::from_str(&json).expect("reads back");
            prop_assert_eq!(back.metrics.len(), assessment.metrics.len());
        }
    }
}

#[test]
fn nothing_to_score_is_an_error() {
    assert!(matches!(assess(&empty(), &bundle()), Err(AssessError::NoSamples)));
    let mut lost = record(1000.0, 1.0, |_| down(0.0, 0.0, 1.0));
    lost.samples.iter_mut().for_each(|s| s.position_m[1] = f64::NAN);
    assert!(matches!(assess(&lost, &bundle()), Err(AssessError::NoSamples)));
}

#[test]
fn implausible_timestamp_is_rejected_before_it_allocates() {
    let mut recording = record(1000.0, 1.0, |_| down(0.0, 0.0, 1.0));
    recording.samples[1000].t_s = 1e12;
    let error = assess(&recording, &bundle()).map(|_| ()).expect_err("a column of that length does not fit");
    assert!(error.to_string().contains("3600 s"), "{error}");
}

#[test]
fn a_dropped_sample_is_bridged() {
    let whole = record(1000.0, 8.0, |t_s| down(0.0, 0.0, 2.0 * t_s - 1.0));
    let mut holed = whole.clone();
    holed.samples[4000].position_m[2] = f64::NAN;
    holed.samples[5000].t_s = holed.samples[4990].t_s;
    let (whole, holed) = (assess(&whole, &bundle()), assess(&holed, &bundle()));
    let (whole, holed) = (whole.expect("scored"), holed.expect("scored"));
    for (a, b) in whole.metrics.iter().zip(&holed.metrics) {
        let near = a.value.zip(b.value).is_none_or(|(x, y)| (x - y).abs() <= 1e-6 * x.abs().max(1.0));
        assert!(near, "{}: {:?} became {:?}", a.id, a.value, b.value);
    }
}
