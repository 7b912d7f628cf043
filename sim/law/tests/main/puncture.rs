//! The needle in space: contact, tracks, oblique paths, the lateral foundation, and save-and-continue.
//!
//! It would fail if the axial law were fed anything but the latched displacement, if a track's boundaries healed or leaked into
//! another's, or if any part of the state were left out of a save.

use law::Incidence;
use law::axial::{AxialInput, AxialParams, AxialScratch, AxialState, PiercingStage};
use law::operator::needle_pose;
use law::puncture::{PunctureEvent, PunctureInput, PunctureOutput, PunctureScratch, step};
use nalgebra::{Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use trials::needle::{DT, DrivenNeedle};
use trials::scenes::{paper_axial_spec, training_axial_spec};

fn above(x_mm: f64) -> Point3<f64> {
    Point3::new(x_mm * 1e-3, 0.0, 0.003)
}

fn below(x_mm: f64) -> Point3<f64> {
    Point3::new(x_mm * 1e-3, 0.0, -0.03)
}

#[test]
fn a_perpendicular_path_gives_the_bits_of_the_axial_law() {
    let axial_params = AxialParams::new(training_axial_spec()).expect("a valid scene");
    let mut axial_state = AxialState::new(&axial_params);
    let mut axial_scratch = AxialScratch::new(&axial_params);
    let mut needle = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
    for tick in 0..8000_u32 {
        let x_m = 0.035 * libm::sin(f64::from(tick) * 1e-3) - 0.004 + 3e-4 * libm::sin(f64::from(tick) * 0.06);
        let input = AxialInput { t_s: f64::from(tick) * DT, x_m, incidence: Incidence::UPRIGHT };
        let wanted = law::axial::step(&axial_params, &mut axial_state, &mut axial_scratch, &input);
        let found = needle.down(0.0123, -0.0045, -x_m);
        assert_eq!(found.axial, wanted, "tick {tick}");
        assert_eq!(found.x_m.to_bits(), x_m.to_bits(), "tick {tick}");
        if found.inside {
            assert_eq!(found.force_n, Vector3::z() * wanted.total_n());
        }
    }
    assert_eq!(needle.state.ledger(), &axial_state.ledger);
    assert_eq!((axial_state.tip_open, axial_state.rim_open), (3, 3), "the path must have opened everything");
}

#[test]
fn an_old_track_does_not_cut_twice_but_cuts_beyond_its_front() {
    // The front lies behind the deepest point by what the presliding spring was stretched: f/k.
    let front_m = 0.03 - 0.3 / 2000.0;
    let mut needle = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
    needle.travel(-Vector3::z(), above(0.0), below(0.0));
    needle.travel(-Vector3::z(), below(0.0), above(0.0));
    let again = needle.travel(-Vector3::z(), above(0.0), Point3::new(0.0, 0.0, -0.035));
    for tick in &again {
        let cuts = tick.output.axial.cutting_n > 0.0;
        assert_eq!(cuts, tick.tip_m.z < -front_m - 1e-12, "at {} m", tick.tip_m.z);
    }
}

#[test]
fn full_track_list_reuses_the_nearest_track() {
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![]).expect("a valid scene");
    for hole in 0..70 {
        let x_mm = f64::from(hole) * 3.0;
        needle.down(x_mm * 1e-3, 0.0, 0.001);
        needle.down(x_mm * 1e-3, 0.0, -0.001);
        let wanted = if hole < 64 { (hole as usize, false) } else { (63, true) };
        let found = needle.scratch.events.iter().find_map(|event| match event {
            PunctureEvent::Contact { track, reused, .. } => Some((*track, *reused)),
            _ => None,
        });
        assert_eq!(found, Some(wanted));
        needle.down(x_mm * 1e-3, 0.0, 0.001);
    }
    assert_eq!(needle.state.tracks(), 64);
}

#[test]
fn an_oblique_needle_on_its_own_line_is_pushed_back_along_it() {
    let axis = Vector3::new(0.6, 0.0, -0.8);
    let entry = Point3::new(0.01, 0.02, 0.0);
    let mut oblique = DrivenNeedle::new(paper_axial_spec(), vec![]).expect("a valid scene");
    let ticks = oblique.travel(axis, entry - axis * 0.002, entry + axis * 0.05);
    let last = ticks.last().expect("ticks");
    assert!(last.output.lateral_n.norm() < 1e-12, "on its own line nothing pushes sideways");
    assert!((last.output.force_n + axis * last.output.axial.total_n()).norm() < 1e-12);
}

#[test]
fn lateral_force_is_stiffness_times_depth_and_books_its_work() {
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![]).expect("a valid scene");
    needle.travel(-Vector3::z(), above(0.0), below(0.0));
    let before = needle.state.ledger().lateral_j();
    let ticks = needle.travel(-Vector3::z(), below(0.0), below(2.0));
    let last = ticks.last().expect("ticks").output;
    // k_lat · s · δ = 10 000 N/m² · 30 mm · 2 mm = 0.6 N, and the work is ½ · 300 N/m · (2 mm)².
    assert!((last.lateral_n - Vector3::new(-0.6, 0.0, 0.0)).norm() < 1e-12);
    let work_j = needle.state.ledger().lateral_j() - before;
    assert!((work_j - 0.6e-3).abs() < 0.02 * 0.6e-3, "{work_j}");
    assert!((last.x_m - 0.03).abs() < 1e-15, "the latched displacement is along the axis");
}

#[test]
fn latched_axis_ignores_turning_the_needle_inside() {
    let mut straight = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
    let mut turned = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
    straight.travel(-Vector3::z(), above(0.0), below(0.0));
    turned.travel(-Vector3::z(), above(0.0), below(0.0));
    let axis = Vector3::new(0.6, 0.0, -0.8);
    let tip = Point3::new(0.0, 0.0, -0.031);
    assert_eq!(straight.down(tip.x, tip.y, tip.z), turned.pose(needle_pose(&tip, &axis)));
}

#[test]
fn first_sample_inside_ruptures_at_once_and_enters_on_its_axis() {
    let axis = Vector3::new(0.6, 0.0, -0.8);
    let mut needle = DrivenNeedle::new(paper_axial_spec(), vec![]).expect("a valid scene");
    let output = needle.pose(needle_pose(&Point3::new(0.03, 0.0, -0.04), &axis));
    let PunctureEvent::Contact { entry_m, .. } = needle.scratch.events[0] else { panic!("no contact") };
    assert!((entry_m - Point3::origin()).norm() < 1e-15);
    assert!((output.x_m - 0.05).abs() < 1e-15);
    assert_eq!(needle.scratch.events.len(), 7, "contact and six ruptures");
    assert_eq!((output.axial.v_m_per_s, output.stage, output.boundary), (0.0, PiercingStage::RimThrough, 2));
}

#[test]
fn a_needle_flat_on_the_skin_or_pointing_out_is_bounded() {
    for axis in [Vector3::x(), Vector3::z(), Vector3::new(0.0, 1.0, -1e-9)] {
        let mut needle = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
        for z_m in [0.01, -1e-6, -0.01, -0.03, 0.001] {
            let output = needle.pose(needle_pose(&Point3::new(0.0, 0.0, z_m), &axis));
            assert!(output.force_n.iter().all(|force| force.is_finite() && force.abs() < 100.0), "{output:?}");
        }
    }
}

#[test]
fn the_stages_come_in_the_papers_order() {
    // A skin that gives way before the rim arrives: stage II is skipped wherever the tip tents deeper than the rim's 2 mm.
    let mut scene = paper_axial_spec();
    scene.layers[0].tip_rupture_n = 0.1;
    let mut needle = DrivenNeedle::new(scene, vec![]).expect("a valid scene");
    let mut seen = Vec::new();
    for tick in needle.travel(-Vector3::z(), above(0.0), Point3::new(0.0, 0.0, -0.02)) {
        let now = (tick.output.boundary, tick.output.stage);
        if seen.last() != Some(&now) {
            seen.push(now);
        }
    }
    let wanted = [
        (0, PiercingStage::Untouched),
        (0, PiercingStage::TipTents),
        (0, PiercingStage::TipThrough),
        (0, PiercingStage::RimTents),
        (1, PiercingStage::TipTents),
        (1, PiercingStage::RimTents),
        (2, PiercingStage::TipTents),
        (2, PiercingStage::RimTents),
        (2, PiercingStage::RimThrough),
    ];
    assert_eq!(seen, wanted);
}

#[test]
fn bad_sample_is_held_and_reported_and_the_next_is_accepted() {
    let mut needle = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
    needle.travel(-Vector3::z(), above(0.0), below(0.0));
    let (good, saved) = (needle.down(0.0, 0.001, -0.031), needle.state.clone());
    let at = needle_pose(&Point3::new(0.0, 0.001, -0.031), &-Vector3::z());
    let mut nan = at;
    nan.translation = Translation3::new(0.0, f64::NAN, 0.0);
    let mut far = at;
    far.translation = Translation3::new(0.0, f64::INFINITY, 0.0);
    let mut unturned = at;
    unturned.rotation = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 0.0, 0.0, 0.0));
    let now = f64::from(needle.tick) * DT;
    let last = f64::from(needle.tick - 1) * DT;
    let cases = [(now, nan), (now, far), (now, unturned), (last, at), (last - 1.0, at), (f64::NAN, at)];
    for (t_s, patient_from_needle) in cases {
        let input = PunctureInput { t_s, patient_from_needle };
        let held = step(&needle.params, &mut needle.state, &mut needle.scratch, &input);
        assert!(held.axial.held);
        assert_eq!(PunctureOutput { axial: good.axial, ..held }, good, "a held sample repeats the last good force");
        assert_eq!(needle.scratch.events, [PunctureEvent::Fault]);
        assert_eq!(needle.state, saved);
    }
    assert!(!needle.down(0.0, 0.001, -0.031).axial.held);
}

#[test]
fn saved_loaded_and_continued_gives_the_same_bits() {
    let pose_at = |tick: u32| {
        let t = f64::from(tick) * DT;
        let axis = Vector3::new(0.3, 0.1 * libm::sin(t), -1.0).normalize();
        let tip = Point3::new(0.004 * libm::sin(3.1 * t), 0.001 * t, 0.02 * libm::cos(1.7 * t) - 0.012);
        needle_pose(&tip, &axis)
    };
    for cut in [1, 700, 1501, 4000] {
        let mut whole = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
        let mut parted = DrivenNeedle::new(training_axial_spec(), vec![]).expect("a valid scene");
        for tick in 0..6000 {
            if tick == cut {
                let saved = serde_json::to_string(&parted.state).expect("a state is JSON");
                parted.state = serde_json::from_str(&saved).expect("and back");
                parted.scratch = PunctureScratch::new(&parted.params);
            }
            assert_eq!(whole.pose(pose_at(tick)), parted.pose(pose_at(tick)), "cut at {cut}, tick {tick}");
            assert_eq!(whole.scratch.events, parted.scratch.events);
        }
        assert_eq!(whole.state, parted.state);
        assert!(whole.state.tracks() > 1, "the path must re-enter elsewhere");
    }
}
