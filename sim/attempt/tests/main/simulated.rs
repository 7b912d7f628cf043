//! A simulated attempt says what the force law said, and re-simulates to the bit. It would fail where the loop and the
//! verification take different paths, a number is rounded before it is used, or a tampered file passes.

use std::f64::consts::{PI, TAU};

use attempt::simulate::{Clock, MotionSource, Simulated, rehearse, simulate};
use attempt::verify::{Verification, verify_recording};
use law::axial::{AxialSpec, ForceLaw};
use law::closed_form::predict_ruptures;
use law::operator::{Felt, Motion, Operator, Plan, Skill};
use law::puncture::PunctureSpec;
use law::structures::{Shape, StructureKind, StructureSpec};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use recording::recover::recover;
use recording::sample::flags;
use recording::{EventKind, Recording, Session};
use tissue::{Specimen, SpecimenSpec};
use trials::scenes::{OPTION_SETS, training_axial_spec, with_options};

use crate::support::{file, read, writer, writer_under};

const CLOCK: Clock = Clock { tick_hz: 1000.0, time_limit_s: 60.0 };

/// The training lower back under a trocar, with a vessel 30 mm deep.
pub fn specimen() -> Specimen {
    make_specimen(training_axial_spec(), None)
}

/// The same with other layers, under a needle of a bending stiffness, in N·m², or a rigid one.
fn make_specimen(axial: AxialSpec, needle_bending_n_m2: Option<f64>) -> Specimen {
    let vessel = StructureSpec {
        name: "artery".to_owned(),
        kind: StructureKind::Vessel,
        shape: Shape::Sphere { radius_m: 0.003 },
        position_m: Point3::new(0.0, 0.0, -0.03),
        wall: None,
    };
    let puncture = PunctureSpec {
        axial,
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: 0.1,
        hub_stiffness_n_per_m: None,
        needle_bending_n_m2,
        skin: law::Skin::Flat,
        structures: vec![vessel],
    };
    Specimen::new(SpecimenSpec { puncture, tissue: None }).unwrap()
}

/// A hand that goes in to 35 mm, confirms, comes out and goes in again, trembling sideways, and keeps what it felt.
#[derive(Default)]
struct Script {
    t_s: f64,
    felt_n: Vec<Vector3<f64>>,
    /// Calls in which it sends nonsense.
    bad: std::ops::Range<usize>,
}

impl MotionSource for Script {
    fn step(&mut self, dt_s: f64, felt: &Felt) -> Motion {
        self.t_s += dt_s;
        let phase = self.t_s / 4.0;
        let depth_m = 0.015 - 0.02 * libm::cos(TAU * phase);
        let sideways_m = 2e-4 * libm::sin(9.0 * TAU * self.t_s);
        let z_m = if self.bad.contains(&self.felt_n.len()) { f64::NAN } else { -depth_m };
        self.felt_n.push(felt.force_n);
        let tilt = UnitQuaternion::from_euler_angles(PI - 0.1, 0.05, 0.0);
        Motion {
            patient_from_needle: Isometry3::from_parts(Translation3::new(sideways_m, -0.0, z_m), tilt),
            confirm: (1.4995..1.6995).contains(&self.t_s),
            done: self.t_s > 6.9995,
        }
    }
}

fn attempt(source: &mut dyn MotionSource, clock: &Clock) -> (Simulated, Vec<u8>) {
    let mut writer = writer();
    let simulated = simulate(&specimen(), source, &mut writer, clock).unwrap();
    (simulated, writer.finish().unwrap())
}

fn straight() -> Operator {
    let plan = Plan {
        entry_m: Point3::origin(),
        skin: law::Skin::Flat,
        axis: -Vector3::z(),
        target_x_m: 0.02,
        approach_m: 0.001,
        hold_s: 0.1,
        reach_m: 0.15,
    };
    Operator::constant(0.002, &plan)
}

#[test]
fn the_first_sample_is_the_start_and_time_is_counted_in_ticks() {
    let clock = Clock { tick_hz: 300.0, time_limit_s: 1.0 };
    let (simulated, bytes) = attempt(&mut Script::default(), &clock);
    let Recording { samples, events, .. } = read(&bytes);
    let ruptures = events.iter().filter(|e| e.kind.contactor().is_some()).count() as u64;
    assert_eq!(simulated, Simulated { duration_s: 1.0, ticks: 301, ruptures });
    for (n, sample) in samples.iter().enumerate() {
        assert_eq!(sample.t_s, n as f64 / 300.0);
    }
    assert_eq!(samples[0].position_m, [0.0, 0.0, 0.02 - 0.015]);
    assert_eq!(samples[0].velocity_m_per_s, [0.0; 3]);
    let speed = (samples[9].position_m[2] - samples[8].position_m[2]) / (samples[9].t_s - samples[8].t_s);
    assert_eq!(samples[9].velocity_m_per_s[2], speed as f32);
}

#[test]
fn the_attempt_ends_when_its_source_is_done() {
    let (simulated, bytes) = attempt(&mut Script::default(), &CLOCK);
    assert_eq!(simulated.ticks, 7001);
    assert_eq!(read(&bytes).samples.len(), 7001);
}

#[test]
fn invalid_tick_rate_is_rejected_and_a_nan_limit_ends_at_once() {
    let run = |clock| simulate(&specimen(), &mut Script::default(), &mut writer(), &clock);
    for tick_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(run(Clock { tick_hz, ..CLOCK }).unwrap_err().to_string().contains("tick_hz"));
    }
    assert_eq!(run(Clock { time_limit_s: f64::NAN, ..CLOCK }).unwrap().ticks, 0);
}

#[test]
fn an_attempt_in_memory_is_the_one_that_a_file_holds() {
    let (_, bytes) = attempt(&mut Script::default(), &CLOCK);
    let kept = read(&bytes);
    let specimen = specimen();
    let in_memory = |tick_hz| {
        let session = Session { tick_hz, ..Session::in_memory(kept.session.law, Vec::new()) };
        rehearse(&specimen, &mut Script::default(), session, CLOCK.time_limit_s)
    };
    let rehearsed = in_memory(CLOCK.tick_hz);
    assert_eq!(rehearsed.samples, kept.samples);
    assert_eq!(rehearsed.events, kept.events);
    assert_eq!(rehearsed.energies.last(), kept.energies.last());
    let nothing = in_memory(0.0);
    assert!(nothing.samples.is_empty() && nothing.energies.is_empty());
}

#[test]
fn the_hand_feels_the_force_of_the_tick_before() {
    let mut script = Script::default();
    let (_, bytes) = attempt(&mut script, &CLOCK);
    let samples = read(&bytes).samples;
    assert_eq!(script.felt_n[0], Vector3::zeros());
    for (felt_n, before) in script.felt_n[1..].iter().zip(&samples) {
        assert_eq!(felt_n.map(|c| c as f32).as_slice(), before.force_n);
        assert_eq!(before.force_n, before.device_n);
    }
}

#[test]
fn ruptures_are_where_the_closed_form_puts_them() {
    let (_, bytes) = attempt(&mut straight(), &CLOCK);
    let recording = read(&bytes);
    let found: Vec<_> = recording.events.iter().filter(|e| e.kind.contactor().is_some()).collect();
    let predicted = predict_ruptures(&specimen().spec().axial);
    assert_eq!(found.len(), 6);
    for (event, expected) in found.iter().zip(&predicted) {
        assert_eq!(event.kind.contactor(), Some(expected.contactor));
        assert_eq!(event.boundary, u32::try_from(expected.boundary).ok());
        assert_eq!(event.text, ["skin", "fat", "muscle"][expected.boundary]);
        // Late by one tick of 2 µm at most.
        let late_m = event.x_m - expected.x_m;
        assert!((-1e-9..2.001e-6).contains(&late_m), "{late_m} m late");
    }
    assert_eq!(recording.events[0].kind, EventKind::Contact);
    assert_eq!(recording.events[0].track, Some(0));
}

#[test]
fn every_kind_of_event_finds_its_way() {
    let (_, bytes) = attempt(&mut Script { bad: 900..903, ..Script::default() }, &CLOCK);
    let recording = read(&bytes);
    let of = |kind| recording.events.iter().filter(move |e| e.kind == kind).collect::<Vec<_>>();
    assert_eq!(of(EventKind::Confirm).len(), 1, "a button held down confirms once");
    assert_eq!(of(EventKind::Confirm)[0].t_s, 1.5);
    assert!(of(EventKind::StructureHit).iter().all(|e| e.structure == Some(0) && e.text == "artery"));
    assert!(!of(EventKind::StructureHit).is_empty());
    assert!(!of(EventKind::SkinExit).is_empty());
    assert_eq!(of(EventKind::Contact).len(), 2);
    assert_eq!(of(EventKind::Contact)[1].text, "re-entry");
    assert_eq!(of(EventKind::Fault).len(), 3);
    let held = recording.samples.iter().filter(|s| s.flags & flags::HELD != 0).count();
    assert_eq!(held, 3);
    let pressed = recording.samples.iter().filter(|s| s.flags & flags::CONFIRM != 0).count();
    assert_eq!(pressed, 200);
}

#[test]
fn ledger_is_recorded_at_10_hz_at_ruptures_and_at_the_end() {
    let (simulated, bytes) = attempt(&mut straight(), &CLOCK);
    let recording = read(&bytes);
    let times: Vec<f64> = recording.energies.iter().map(|e| e.t_s).collect();
    assert!(times.is_sorted_by(|a, b| a < b), "no moment twice");
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] < 0.1001));
    for rupture in recording.events.iter().filter(|e| e.kind.contactor().is_some()) {
        assert!(times.contains(&rupture.t_s));
    }
    assert_eq!(times.last(), Some(&simulated.duration_s));
    let ruptured = |e: &recording::Energy| e.ledger.layers.iter().map(|l| l.rupture_j).sum::<f64>();
    let dissipated: f64 = recording.events.iter().map(|e| e.dissipated_j).sum();
    assert!((ruptured(&recording.energies[recording.energies.len() - 1]) - dissipated).abs() < 1e-12);
}

fn verified(recording: &Recording) -> Verification {
    verify_recording(recording, &specimen())
}

#[test]
fn a_simulated_recording_re_simulates_to_the_bit() {
    let plan = Plan {
        entry_m: Point3::new(0.001, 0.002, 0.0),
        skin: law::Skin::Flat,
        axis: Vector3::new(0.2, 0.1, -1.0).normalize(),
        target_x_m: 0.03,
        approach_m: 0.004,
        hold_s: 0.5,
        reach_m: 0.15,
    };
    let sources = || -> [Box<dyn MotionSource>; 4] {
        [
            Box::new(Script::default()),
            Box::new(Script { bad: 200..220, ..Script::default() }),
            Box::new(straight()),
            Box::new(Operator::skilled(&Skill::novice(), &plan, 7)),
        ]
    };
    for tick_hz in [1000.0, 333.0] {
        for mut source in sources() {
            let (simulated, bytes) = attempt(source.as_mut(), &Clock { tick_hz, ..CLOCK });
            let verification = verified(&read(&bytes));
            assert!(verification.exact(), "{verification:?}");
            assert_eq!(verification.ticks, simulated.ticks);
            assert!(simulated.duration_s > 6.0);
        }
    }
}

#[test]
fn bent_needle_resimulates_bit_for_bit_and_differs_from_rigid() {
    let bent = make_specimen(training_axial_spec(), Some(2e-3));
    let mut writer = writer();
    simulate(&bent, &mut Script::default(), &mut writer, &CLOCK).unwrap();
    let recording = read(&writer.finish().unwrap());
    assert!(verify_recording(&recording, &bent).exact());
    assert!(recording.samples.iter().any(|s| s.bend_m[0].abs() > 1e-4), "it must have bent");
    let as_rigid = verified(&recording);
    assert!(as_rigid.largest_deviation_n > 1e-3 && as_rigid.largest_depth_deviation_m > 1e-4, "{as_rigid:?}");
    let mut moved = recording.clone();
    moved.samples[1300].bend_m[1] += 1e-4;
    assert!(verify_recording(&moved, &bent).largest_depth_deviation_m > 0.9e-4);
}

/// Trembling, held, drawn out and pushed in again through the same track, under each option of version 3 and under all.
#[test]
fn law_options_resimulate_bit_for_bit_and_change_the_forces() {
    for options in OPTION_SETS {
        let optioned = make_specimen(with_options(training_axial_spec(), options), None);
        let mut writer = writer_under(ForceLaw::Version3);
        simulate(&optioned, &mut Script { bad: 200..220, ..Script::default() }, &mut writer, &CLOCK).unwrap();
        let recording = read(&writer.finish().unwrap());
        assert_eq!(recording.session.law, ForceLaw::Version3);
        let verification = verify_recording(&recording, &optioned);
        assert!(verification.exact(), "{options:?}: {verification:?}");
        assert_eq!((verification.ticks, verification.largest_deviation_n), (7001, 0.0));
        assert!(verified(&recording).largest_deviation_n > 0.03, "{options:?}: {:?}", verified(&recording));
    }
}

#[test]
fn a_cut_recording_re_simulates_to_the_bit_as_far_as_it_goes() {
    let (_, bytes) = attempt(&mut Script::default(), &CLOCK);
    for tenth in 2..10 {
        let cut = &bytes[..bytes.len() * tenth / 10];
        assert!(verified(&read(cut)).exact());
        let mut sink = std::io::Cursor::new(Vec::new());
        recover(cut, &mut sink).unwrap();
        assert!(verified(&read(sink.get_ref())).exact());
    }
}

#[test]
fn tampering_is_found() {
    let (_, bytes) = attempt(&mut Script::default(), &CLOCK);
    let honest = read(&bytes);
    let tampered = |change: &dyn Fn(&mut Recording)| {
        let mut recording = honest.clone();
        change(&mut recording);
        let verification = verified(&recording);
        assert!(!verification.exact());
        verification
    };
    let milder = tampered(&|r| r.samples[1300].friction_n -= 0.25);
    assert_eq!((milder.channel.as_str(), milder.at_s), ("friction_n", 1.3));
    assert!((milder.largest_deviation_n - 0.25).abs() < 1e-6);
    assert_eq!(tampered(&|r| r.samples[1300].lateral_n[1] += 1e-6).channel, "lateral_n.y");
    assert_eq!(tampered(&|r| r.samples[1300].device_n[2] *= 0.5).channel, "device_n.z");
    assert_eq!(tampered(&|r| r.samples[1300].tip_n = f32::NAN).largest_deviation_n, f64::MAX);
    assert!(tampered(&|r| r.samples[1300].depth_m *= 0.9).largest_depth_deviation_m > 1e-3);
    assert!(tampered(&|r| r.samples[1300].x_m += 1e-6).largest_depth_deviation_m > 0.9e-6);
    assert_eq!(tampered(&|r| drop(r.events.remove(3))).event_differences, 1);
    assert_eq!(tampered(&|r| r.events.push(r.events[3].clone())).event_differences, 1);
    assert_eq!(tampered(&|r| r.events[3].dissipated_j *= 2.0).event_differences, 2);
    // A moved needle does not make the forces that were recorded.
    assert!(tampered(&|r| r.samples.iter_mut().for_each(|s| s.position_m[2] += 1e-3)).largest_deviation_n > 0.1);
}

#[test]
fn a_device_that_scales_forces_is_not_held_to_them() {
    let (_, bytes) = attempt(&mut Script::default(), &CLOCK);
    let mut recording = read(&bytes);
    recording.session.device_max_force_n = 3.3;
    recording.samples.iter_mut().for_each(|s| s.device_n = s.device_n.map(|c| 0.5 * c));
    assert!(verified(&recording).exact());
}

#[test]
fn invented_samples_do_not_verify() {
    assert!(!verified(&read(&file(2000))).exact());
}

#[test]
fn the_same_seed_makes_the_same_file() {
    assert!(attempt(&mut straight(), &CLOCK).1 == attempt(&mut straight(), &CLOCK).1);
}
