//! The field in recordings of the shipped exercises, from the document to the file: each boundary tents twice, and a withdrawal
//! pulls. It would fail where a scene's tissue is not that of its document, a load is put at another boundary, or a pop is not seen.

use std::path::{Path, PathBuf};

use attempt::simulate::{Clock, simulate};
use attempt::verify::verify_recording;
use documents::{Document, ExerciseBundle, Patient};
use law::closed_form;
use law::operator::{Operator, Plan};
use recording::{Event, EventKind, Recording, Tent, Writer};
use tissue::Specimen;

use crate::support::{empty, session_of};

const CLOCK: Clock = Clock { tick_hz: 1000.0, time_limit_s: 60.0 };

/// Every shipped exercise.
fn exercises() -> Vec<ExerciseBundle> {
    let curricula = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
    let folders = std::fs::read_dir(curricula).expect("the shipped documents");
    let files = folders.flat_map(|folder| std::fs::read_dir(folder.expect("a folder").path()).expect("its files"));
    let mut paths: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
    paths.sort();
    let exercise = |path: PathBuf| match documents::load::read_document(&path) {
        Ok(Document::Exercise(bundle)) => Some(*bundle),
        _ => None,
    };
    let found: Vec<ExerciseBundle> = paths.into_iter().filter_map(exercise).collect();
    assert!(found.len() >= 8, "{} exercises", found.len());
    found
}

/// In past every rupture of the nominal patient at 5 mm/s, and out.
fn insertion(bundle: &ExerciseBundle, specimen: &Specimen) -> Recording {
    let exercise = &bundle.exercise;
    let path = documents::spec_along_path(specimen.spec().axial.clone(), &exercise.incidence());
    let last_m = closed_form::predict_ruptures(&path).last().expect("a rupture").x_m;
    let plan = Plan { target_x_m: last_m + 0.004, approach_m: 0.001, hold_s: 0.3, ..exercise.plan() };
    let session = session_of(bundle, empty().session);
    let mut writer = Writer::create(Vec::new(), &session, &assessment::attachments(bundle), &Default::default())
        .expect("memory does not refuse");
    simulate(specimen, &mut Operator::constant(0.005, &plan), &mut writer, &CLOCK).expect("memory does not refuse");
    Recording::read(writer.finish().expect("memory does not refuse").as_slice()).expect("just written")
}

fn ruptures(recording: &Recording, kind: EventKind, boundary: usize) -> &Event {
    let is_it = |event: &&Event| event.kind == kind && event.boundary == u32::try_from(boundary).ok();
    recording.events.iter().find(is_it).expect("a slow insertion opens every boundary")
}

/// Largest and least value of the steps between two times, in s.
fn range(tents: &[Tent], (from_s, to_s): (f64, f64), value: impl Fn(&Tent) -> f32) -> (f32, f32) {
    let within = tents.iter().filter(|tent| tent.t_s > from_s && tent.t_s <= to_s).map(value);
    within.fold((f32::NEG_INFINITY, f32::INFINITY), |(most, least), value| (most.max(value), least.min(value)))
}

#[test]
fn every_shipped_boundary_tents_until_each_of_its_ruptures() {
    let mut tented = 0;
    for bundle in exercises() {
        let patient = Patient::nominal(&bundle.scene);
        let specimen = Specimen::new(bundle.specimen_spec(&patient)).expect("a shipped scene");
        let recording = insertion(&bundle, &specimen);
        let trocar = bundle.scene.needle.tip_to_rim_mm > 0.0;
        for boundary in 0..bundle.scene.layers.len() {
            let what = format!("boundary {boundary} of {}", bundle.exercise.id);
            let tip = ruptures(&recording, EventKind::TipRupture, boundary);
            // What opens at once, an incised skin or an introducer, is pushed by nothing.
            if specimen.spec().axial.layers[boundary].tip_rupture_n <= 0.0 {
                continue;
            }
            // What opens in the tick of a boundary above it, in a cascade, is never pushed by itself.
            let above = recording.events.iter().take_while(|event| *event != tip);
            if above.filter(|event| event.kind == EventKind::TipRupture).any(|event| event.t_s >= tip.t_s) {
                continue;
            }
            tented += 1;
            let (load_n, tent_m) = (|tent: &Tent| tent.contactor_n[boundary], |tent: &Tent| tent.tent_m[boundary]);
            let just_before = |event: &Event| (event.t_s - 1.0 / 120.0 - 1e-3, event.t_s - 1e-6);
            let (_, peak_m) = range(&recording.tents, just_before(tip), tent_m);
            let rest_m: f64 = documents::spec_along_path(specimen.spec().axial.clone(), &bundle.exercise.incidence())
                .layers[..boundary]
                .iter()
                .map(|layer| layer.thickness_m)
                .sum();
            // The last step of the field is up to 1/120 s and a tick before the pop.
            let late_m = 0.005 * (1.0 / 120.0 + 1e-3);
            let as_far =
                |found_m: f32, pressed_m: f64| (pressed_m - late_m..pressed_m + 1e-6).contains(&f64::from(found_m));
            assert!(as_far(peak_m, tip.x_m - rest_m), "{what}: {peak_m} m under a tip at {} m", tip.x_m - rest_m);
            if trocar {
                let rim = ruptures(&recording, EventKind::RimRupture, boundary);
                let (again_n, _) = range(&recording.tents, (tip.t_s, rim.t_s), load_n);
                let rim_m = rim.x_m - bundle.scene.needle.tip_to_rim_mm * 1e-3 - rest_m;
                let (_, last_m) = range(&recording.tents, just_before(rim), tent_m);
                assert!(as_far(last_m, rim_m), "{what}: {last_m} m under a rim at {rim_m} m");
                let (_, after_n) = range(&recording.tents, (rim.t_s, rim.t_s + 0.3), load_n);
                assert!(after_n <= 0.01 * again_n, "{what}: {after_n} N left of {again_n} N");
            }
            // Where the next boundary is dented too, that one holds this one.
            let below_m = rest_m + specimen.spec().axial.layers[boundary].thickness_m;
            if tip.x_m > below_m && bundle.exercise.angle_deg <= 0.0 {
                continue;
            }
            let (before_m, _) = range(&recording.tents, (tip.t_s - 0.02, tip.t_s), tent_m);
            let (_, after_m) = range(&recording.tents, (tip.t_s, tip.t_s + 0.03), tent_m);
            // The shaft's drag moves a boundary by as much as it recoils from less than a millimetre.
            assert!(before_m < 1e-3 || after_m < 0.95 * before_m, "{what}: {before_m} m, then {after_m} m");
        }
        assert!(verify_recording(&recording, &specimen).exact(), "{}", bundle.exercise.id);
        out_again(&bundle, &recording);
    }
    assert!(tented >= 30, "{tented} boundaries were tented");
}

/// On the way out the shaft drags the tissue outwards, where the layers drag at all.
fn out_again(bundle: &ExerciseBundle, recording: &Recording) {
    let confirmed =
        recording.events.iter().find(|event| event.kind == EventKind::Confirm).expect("the end of the hold");
    let exit = recording.events.iter().find(|event| event.kind == EventKind::SkinExit).expect("the needle comes out");
    let way = (confirmed.t_s + 0.7 * (exit.t_s - confirmed.t_s), confirmed.t_s + 0.8 * (exit.t_s - confirmed.t_s));
    let (most_m, _) = range(&recording.tents, way, |tent| tent.tent_m[0]);
    let (most_n, _) = range(&recording.tents, way, |tent| tent.drag_n.iter().sum());
    assert!(most_m < 0.0 && most_n < 0.0, "{}: {most_m} m under {most_n} N", bundle.exercise.id);
}
