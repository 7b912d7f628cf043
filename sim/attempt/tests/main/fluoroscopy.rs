//! The use of a C-arm. Fails if a pedal gives more or fewer pulses than its rate, if the dose differs from its closed form, or if a
//! recording is accepted whose dose does not follow from its controls.

use std::path::Path;

use attempt::fluoroscopy::{Fluoroscope, count_pulse_differences, start_controls};
use attempt::run::RecordedArm;
use documents::ExerciseBundle;
use guidance::{CArm, Exposure, KermaLevel, mean_transmission};
use recording::sample::flags;
use recording::{CArmControls, Fluoroscopy, FluoroscopyPulse, Recording, Sample, Session};

fn bundle() -> ExerciseBundle {
    let file = "../../curricula/percutaneous-kidney-access/2-under-x-rays.toml";
    ExerciseBundle::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

fn arm(bundle: &ExerciseBundle) -> Fluoroscope {
    Fluoroscope::new(bundle).unwrap().unwrap()
}

fn start(bundle: &ExerciseBundle) -> CArmControls {
    start_controls(bundle.exercise.fluoroscopy.as_ref().unwrap())
}

/// The use of the C-arm in so many ticks of 1 ms, by controls at each.
fn operate(arm: &Fluoroscope, ticks: u32, controls: impl Fn(f64) -> CArmControls) -> Fluoroscopy {
    let mut arm = RecordedArm::new(arm.clone());
    let mut used = Fluoroscopy::default();
    for tick in 0..ticks {
        let t_s = f64::from(tick) * 1e-3;
        let now = arm.step(&CArmControls { t_s, ..controls(t_s) });
        used.controls.extend(now.controls);
        used.pulses.extend(now.pulse);
    }
    used
}

#[test]
fn a_minute_of_pedal_gives_450_pulses_with_their_dose() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let pressed = CArmControls { pedal: true, ..start(&bundle) };
    let used = operate(&arm, 60_000, |_| pressed);
    assert_eq!((used.controls.len(), used.pulses.len()), (1, 450));
    assert!(used.pulses.iter().zip(0..).all(|(pulse, index)| pulse.index == index && !pulse.shot));
    let body = arm.body();
    let mean = mean_transmission(&body.arm(&pressed), &body.volumes(0.0)).unwrap();
    let last = used.pulses.last().unwrap();
    assert_eq!(last.mean_transmission, mean);
    // 30 nGy at the detector, 1 m from the tube; the reference point is 0.45 m from it.
    let kerma_mgy = 450.0 * 30e-6 / mean / 0.2025;
    assert!((last.kerma_mgy / kerma_mgy - 1.0).abs() < 1e-9, "{} mGy, not {kerma_mgy}", last.kerma_mgy);
    // The field of 300 mm is 13.5 cm wide there.
    let area_gycm2 = kerma_mgy * 1e-3 * 13.5 * 13.5;
    assert!((last.kerma_area_gycm2 / area_gycm2 - 1.0).abs() < 1e-9, "{} Gy cm²", last.kerma_area_gycm2);
}

#[test]
fn single_shots_come_one_a_tick_with_the_dose_of_ten_pulses() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let used = operate(&arm, 100, |t_s| CArmControls { shots: if t_s < 0.05 { 0 } else { 2 }, ..start(&bundle) });
    let times: Vec<f64> = used.pulses.iter().map(|pulse| pulse.t_s).collect();
    assert_eq!(times, [50.0 * 1e-3, 51.0 * 1e-3]);
    let once = operate(&arm, 1, |_| CArmControls { pedal: true, ..start(&bundle) }).pulses[0];
    let [first, second] = [used.pulses[0], used.pulses[1]];
    assert!(first.shot && (first.kerma_mgy / once.kerma_mgy - 10.0).abs() < 1e-9);
    assert!((second.kerma_mgy / once.kerma_mgy - 20.0).abs() < 1e-9);
}

#[test]
fn contrast_and_another_view_change_the_exposure() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let load =
        |controls: CArmControls| operate(&arm, 1, |_| CArmControls { pedal: true, ..controls }).pulses[0].load_mas;
    let plain = start(&bundle);
    let narrow = CArmControls { field_m: 0.06, ..plain };
    assert!(
        load(CArmControls { contrast_ml: 15.0, ..narrow }) > 1.02 * load(narrow),
        "iodine lies in the middle of the field"
    );
    assert!(load(CArmControls { orbital_rad: 0.8, ..plain }) > 1.2 * load(plain), "a longer way through the body");
}

#[test]
fn the_target_lies_in_the_collecting_system() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let (body, entry) = bundle.scene.body.as_ref().unwrap().enter().unwrap();
    let target_m = entry.origin_m + entry.to_body(&bundle.exercise.target_m().coords);
    let narrow = CArm { field_m: 0.06, ..CArm::over(target_m) };
    let through = |volumes: &[anatomy::BodyVolume]| mean_transmission(&narrow, volumes).unwrap();
    let (joined, without) =
        (through(&arm.body().volumes(20.0)), through(&body.list_volumes(anatomy::BodyQuality::Medium, None)));
    assert!(joined < 0.95 * without, "{joined} with contrast medium at the target, {without} without");
}

/// A recording with the use of its C-arm.
fn recorded(bundle: &ExerciseBundle, arm: &Fluoroscope) -> Recording {
    let controls = |t_s: f64| CArmControls {
        orbital_rad: if t_s < 1.0 { 0.0 } else { 0.4 },
        pedal: (0.2..0.9).contains(&t_s) || t_s > 1.5,
        shots: u32::from(t_s > 1.2),
        contrast_ml: if t_s < 0.5 { 0.0 } else { 5.0 },
        ..start(bundle)
    };
    let samples =
        (0..2000).map(|tick| Sample { t_s: f64::from(tick) * 1e-3, flags: flags::INSIDE, ..Sample::default() });
    let session = Session::in_memory(law::axial::ForceLaw::Version5, Vec::new());
    let (samples, fluoroscopy) = (samples.collect(), operate(arm, 2000, controls));
    Recording { samples, fluoroscopy, ..Recording::in_memory(session) }
}

#[test]
fn a_dose_that_does_not_follow_from_the_controls_is_found() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let honest = recorded(&bundle, &arm);
    assert!(honest.fluoroscopy.pulses.len() > 8 && honest.fluoroscopy.pulses.iter().any(|pulse| pulse.shot));
    let differences = |recording: &Recording| count_pulse_differences(recording, Some(arm.clone()));
    assert_eq!(differences(&honest), 0);
    let changed = |change: fn(&mut Fluoroscopy)| {
        let mut recording = honest.clone();
        change(&mut recording.fluoroscopy);
        differences(&recording)
    };
    let least = |pulse: &mut FluoroscopyPulse| pulse.kerma_mgy = pulse.kerma_mgy.next_down();
    assert_eq!(changed(|f| f.pulses.truncate(3)), honest.fluoroscopy.pulses.len() as u64 - 3);
    assert!(changed(|f| f.controls.iter_mut().for_each(|controls| controls.field_m = 0.29)) > 0);
    assert!(changed(|f| f.controls.clear()) > 0);
    let mut dosed = honest.clone();
    dosed.fluoroscopy.pulses.last_mut().into_iter().for_each(least);
    assert_eq!(differences(&dosed), 1);
    // An exercise without a C-arm has none of it.
    assert!(count_pulse_differences(&honest, None) > 0);
}

#[test]
fn exposure_control_is_the_one_of_guidance() {
    let bundle = bundle();
    let arm = arm(&bundle);
    let controls = CArmControls { pedal: true, ..start(&bundle) };
    let pulse = operate(&arm, 1, |_| controls).pulses[0];
    let expected = Exposure::control(&arm.body().arm(&controls), KermaLevel::Low, pulse.mean_transmission);
    assert_eq!(pulse.load_mas, expected.load_mas);
    assert_eq!(pulse.kerma_mgy, expected.kerma_ugy * 1e-3);
}
