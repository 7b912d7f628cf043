//! Each metric of depth, force, time and rupture on motions whose answer is known in closed form.
//! Fails when a definition, a unit or a domain is implemented otherwise than the catalogue says.

use documents::{Shape, StructureKind};
use recording::{CArmControls, EventKind, FluoroscopyPulse};

use crate::support::{
    Pose, bundle, c_arm, decimate, down, expect, expect_absent, judge, ledger, line, mark, plunge, press, pull, record,
    structure,
};

const PI: f64 = std::f64::consts::PI;

#[test]
fn a_straight_insertion_has_its_lengths_and_times() {
    let assessment = judge(&plunge(21.9), &bundle());
    expect(&assessment, "depth_error_mm", 1.9, 1e-6);
    expect(&assessment, "overshoot_mm", 1.9, 1e-6);
    expect(&assessment, "tip_error_mm", 1.9, 1e-6);
    expect(&assessment, "entry_error_mm", 0.0, 0.01);
    expect(&assessment, "angle_error_deg", 0.0, 1e-6);
    expect(&assessment, "time_total_s", 14.45, 1e-9);
    expect(&assessment, "time_in_tissue_s", 11.95, 2e-3);
    expect(&assessment, "path_length_mm", 26.9, 0.02);
    expect(&assessment, "path_in_tissue_mm", 21.9, 0.03);
    expect(&assessment, "axis_travel_mm", 26.9, 0.02);
    expect(&assessment, "path_deviation_sd_mm", 0.0, 1e-9);
    expect(&assessment, "sweep_area_mm2", 0.0, 1e-6);
    expect(&assessment, "idle_fraction", 1.0 / 11.95, 0.003);
    expect(&assessment, "skin_entries", 1.0, 0.0);
    expect(&assessment, "redirections", 0.0, 0.0);
    expect(&assessment, "translational_actions", 0.0, 0.0);
}

#[test]
fn depth_is_taken_at_the_confirm_and_not_later() {
    let mut recording = plunge(30.0);
    mark(&mut recording, 11.5, EventKind::Confirm, None);
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "depth_error_mm", -2.0, 1e-6);
    expect(&assessment, "overshoot_mm", 10.0, 1e-6);
}

#[test]
fn a_confirm_in_the_air_confirms_no_position() {
    let mut recording = plunge(30.0);
    mark(&mut recording, 0.1, EventKind::Confirm, None);
    expect(&judge(&recording, &bundle()), "depth_error_mm", 10.0, 1e-6);
    mark(&mut recording, 11.5, EventKind::Confirm, None);
    expect(&judge(&recording, &bundle()), "depth_error_mm", -2.0, 1e-6);
}

#[test]
fn without_a_confirm_the_deepest_moment_counts() {
    let assessment = judge(&record(1000.0, 20.0, |t_s| down(0.0, 0.0, 18.0 - 0.2 * (t_s - 10.0).powi(2))), &bundle());
    expect(&assessment, "depth_error_mm", -2.0, 1e-6);
    expect(&assessment, "overshoot_mm", 0.0, 0.0);
}

#[test]
fn an_oblique_attempt_is_measured_along_its_own_axis() {
    let mut bundle = bundle();
    bundle.exercise.angle_deg = 30.0;
    bundle.exercise.entry_mm = [3.0, 4.0];
    let axis = bundle.exercise.axis();
    // Enters at the origin instead of 5 mm away, in the planned direction.
    let recording = record(1000.0, 12.0, |t_s| {
        let tip = axis * (2.0 * t_s - 2.0);
        Pose { tip_mm: [tip.x, tip.y, tip.z], axis }
    });
    let assessment = judge(&recording, &bundle);
    expect(&assessment, "entry_error_mm", 5.0, 0.01);
    expect(&assessment, "angle_error_deg", 0.0, 1e-6);
    expect(&assessment, "depth_error_mm", 2.0, 1e-6);
    expect(&assessment, "axis_travel_mm", 24.0, 0.01);
    expect(
        &assessment,
        "tip_error_mm",
        (25.0_f64 + 4.0 - 4.0 * nalgebra::Vector3::new(3.0, 4.0, 0.0).dot(&axis)).sqrt(),
        1e-3,
    );
}

#[test]
fn forces_are_split_by_the_layer_that_the_tip_tents_or_is_in() {
    let mut recording = plunge(18.0);
    // Fat begins at 2 mm and ruptures at 3 mm, muscle at 12 mm and ruptures at 14 mm.
    mark(&mut recording, 4.0, EventKind::TipRupture, Some(1));
    mark(&mut recording, 9.5, EventKind::TipRupture, Some(2));
    press(&mut recording, 3.0..4.0, |_| 1.0);
    press(&mut recording, 8.0..9.5, |_| 3.0);
    press(&mut recording, 10.0..11.0, |_| 2.0);
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "peak_force_n", 3.0, 1e-6);
    expect(&assessment, "peak_force_layer_n.skin", 0.0, 1e-6);
    expect(&assessment, "peak_force_layer_n.fat", 1.0, 1e-6);
    expect(&assessment, "peak_force_layer_n.muscle", 3.0, 1e-6);
    expect(&assessment, "force_impulse_ns", 1.0 + 4.5 + 2.0, 0.02);
}

#[test]
fn sideways_forces_are_split_by_layer_too() {
    let mut recording = plunge(18.0);
    mark(&mut recording, 4.0, EventKind::TipRupture, Some(1));
    mark(&mut recording, 9.5, EventKind::TipRupture, Some(2));
    press(&mut recording, 3.0..4.0, |_| 1.0);
    press(&mut recording, 8.0..9.5, |_| 3.0);
    pull(&mut recording, 3.2..3.8, [0.3, -0.4, 0.0]);
    pull(&mut recording, 9.0..9.2, [0.0, 1.25, 0.0]);
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "max_lateral_force_n.skin", 0.0, 1e-6);
    expect(&assessment, "max_lateral_force_n.fat", 0.5, 1e-6);
    expect(&assessment, "max_lateral_force_n.muscle", 1.25, 1e-6);
    expect(&assessment, "lateral_peak_n", 1.25, 1e-6);
}

#[test]
fn peak_before_a_rupture_ignores_the_last_sample_before_it() {
    let mut recording = plunge(18.0);
    // 20 N/s up to 3 N, which is met between two samples of 250 Hz.
    mark(&mut recording, 6.003, EventKind::TipRupture, Some(1));
    recording.events.iter_mut().filter(|e| e.boundary == Some(1)).for_each(|e| e.force_n = 3.0);
    press(&mut recording, 5.853..6.003, |t_s| 20.0 * (t_s - 5.853));
    for recording in [decimate(&recording, 0), recording] {
        let assessment = judge(&recording, &bundle());
        expect(&assessment, "peak_force_n", 3.0, 1e-6);
        expect(&assessment, "peak_force_layer_n.fat", 3.0, 1e-6);
    }
}

#[test]
fn bone_is_felt_in_the_peak_force() {
    let mut recording = plunge(18.0);
    recording.samples[9000].force_n = [0.0, 0.0, 12.5];
    recording.samples[9000].lateral_n = [0.0, 0.25, 0.0];
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "peak_force_n", 12.5, 1e-6);
    expect(&assessment, "lateral_peak_n", 0.25, 1e-9);
}

#[test]
fn the_force_rate_leaves_the_fall_at_a_rupture_out() {
    let mut recording = plunge(18.0);
    mark(&mut recording, 6.0, EventKind::TipRupture, Some(1));
    press(&mut recording, 4.0..6.0, |t_s| 1.5 * (t_s - 4.0));
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "force_rate_peak_n_per_s", 1.5, 0.1);
    let mut unmarked = recording;
    unmarked.events.retain(|e| e.boundary != Some(1));
    unmarked.samples.iter_mut().for_each(|s| s.force_n = s.force_n.map(|n| -n));
    let rate = judge(&unmarked, &bundle()).value("force_rate_peak_n_per_s").unwrap_or(0.0);
    assert!(rate > 50.0, "a sudden rise that is no rupture's fall is seen: {rate}");
}

#[test]
fn a_rupture_has_its_force_its_advance_and_its_stop() {
    // Ruptures muscle at 2 s and 4 mm, runs on at 10 mm/s for 0.3 s, then stands.
    let mut recording =
        record(1000.0, 4.0, |t_s| down(0.0, 0.0, 2.0 * t_s.min(2.0) + 10.0 * (t_s - 2.0).clamp(0.0, 0.3)));
    mark(&mut recording, 2.0, EventKind::TipRupture, Some(2));
    if let Some(rupture) = recording.events.iter_mut().find(|e| e.boundary == Some(2)) {
        rupture.force_n = 1.7;
    }
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "rupture_force_n.muscle.tip", 1.7, 1e-9);
    expect(&assessment, "rupture_force_n", 1.7, 1e-9);
    expect(&assessment, "over_insertion_mm.muscle.tip", 3.0, 1e-6);
    // The low-pass takes the corner off: 0.5 of 10 mm/s is reached a little after the hand stands.
    expect(&assessment, "stop_time_s.muscle.tip", 0.3, 0.02);
    expect(&assessment, "stop_time_s", 2.3, 0.02);
    expect_absent(&assessment, "over_insertion_mm.muscle.rim");
    expect_absent(&assessment, "rupture_force_n.fat.tip");
}

#[test]
fn a_needle_that_never_stands_still_has_no_stop_time() {
    let recording = record(1000.0, 4.0, |t_s| down(0.0, 0.0, 5.0 * t_s));
    expect_absent(&judge(&recording, &bundle()), "stop_time_s");
}

#[test]
fn energies_come_from_the_last_ledger() {
    let mut recording = plunge(10.0);
    ledger(&mut recording, [9.0, 9.0, 9.0]);
    ledger(&mut recording, [1e-3, 2e-3, 0.0]);
    let assessment = judge(&recording, &bundle());
    expect(&assessment, "rupture_energy_mj", 3.0, 1e-9);
    expect(&assessment, "rupture_energy_mj.fat", 2.0, 1e-9);
    expect(&assessment, "lateral_work_mj", 0.0, 0.0);
    assert_eq!(assessment.damage().rupture_mj, assessment.value("rupture_energy_mj"));
    expect_absent(&judge(&plunge(10.0), &bundle()), "friction_energy_mj.skin");
}

#[test]
fn a_needle_in_the_air_has_only_times_and_lengths() {
    let assessment = judge(&record(1000.0, 3.0, |t_s| down(t_s, 0.0, -5.0)), &bundle());
    expect(&assessment, "time_total_s", 3.0, 1e-9);
    expect(&assessment, "path_length_mm", 3.0, 1e-3);
    for metric in &assessment.metrics {
        let in_air =
            ["time_total_s", "path_length_mm", "axis_travel_mm", "translational_actions", "rotational_actions"];
        assert_eq!(metric.applies, in_air.contains(&metric.id.as_str()), "{metric:?}");
    }
}

#[test]
fn one_sample_has_no_speed_and_no_time() {
    let assessment = judge(&record(1000.0, 0.0, |_| down(0.0, 0.0, 20.0)), &bundle());
    expect(&assessment, "depth_error_mm", 0.0, 1e-9);
    for id in [
        "time_total_s",
        "path_length_mm",
        "smoothness_ldlj",
        "smoothness_sparc",
        "idle_fraction",
        "force_rate_peak_n_per_s",
    ] {
        expect_absent(&assessment, id);
    }
}

/// Controls that look from straight behind at first and from an angle in degrees later.
fn look_from(angle_deg: f64) -> Vec<CArmControls> {
    let field_m = 0.2;
    let first = CArmControls { field_m, ..CArmControls::default() };
    let other = CArmControls { t_s: 1.5, orbital_rad: angle_deg.to_radians(), field_m: 0.1, ..first };
    vec![first, other]
}

#[test]
fn fluoroscopy_counts_its_pulses_and_their_dose() {
    let mut bundle = bundle();
    bundle.exercise.fluoroscopy = Some(c_arm());
    let mut recording = plunge(20.0);
    let contact_s = 2.5;
    mark(&mut recording, contact_s, EventKind::Contact, None);
    let pulse = |index: u32, t_s: f64, shot: bool| FluoroscopyPulse {
        t_s,
        index,
        shot,
        load_mas: 0.1,
        mean_transmission: 0.01,
        kerma_mgy: f64::from(index + 1) * 0.02,
        kerma_area_gycm2: f64::from(index + 1) * 0.003,
    };
    let unseen = judge(&recording, &bundle);
    expect_absent(&unseen, "kerma_mgy");
    recording.fluoroscopy.controls = look_from(9.0);
    expect(&judge(&recording, &bundle), "fluoroscopy_time_s", 0.0, 1e-12);
    expect_absent(&judge(&recording, &bundle), "mean_field_cm2");
    let times = [0.2 * contact_s, 0.7 * contact_s, 0.8 * contact_s, contact_s + 1.0];
    recording.fluoroscopy.pulses = (0..).zip(times).map(|(index, t_s)| pulse(index, t_s, index == 2)).collect();
    let judged = judge(&recording, &bundle);
    expect(&judged, "fluoroscopy_time_s", 3.0 / 7.5, 1e-12);
    expect(&judged, "fluoroscopy_shots", 1.0, 1e-12);
    expect(&judged, "kerma_mgy", 0.08, 1e-12);
    expect(&judged, "kerma_area_gycm2", 0.012, 1e-12);
    expect(&judged, "mean_field_cm2", (400.0 + 3.0 * 100.0) / 4.0, 1e-9);
    expect(&judged, "views_before_skin", 1.0, 1e-12);
    recording.fluoroscopy.controls[1].orbital_rad = 11.0_f64.to_radians();
    expect(&judge(&recording, &bundle), "views_before_skin", 2.0, 1e-12);
}

#[test]
fn every_row_of_the_catalogue_is_measured() {
    let mut bundle = bundle();
    let sphere = Shape::Sphere { radius_m: 1e-3 };
    bundle.scene.structures = vec![structure("artery", StructureKind::Vessel, sphere, [0.0, 0.0, -5.0])];
    bundle.exercise.fluoroscopy = Some(c_arm());
    let metrics = judge(&plunge(20.0), &bundle).metrics;
    for row in assessment::catalogue::DEFINITIONS {
        let plain = metrics.iter().any(|m| m.id == row.id);
        let split = metrics.iter().any(|m| m.id.strip_prefix(row.id).is_some_and(|rest| rest.starts_with('.')));
        assert_eq!((plain, split), (row.plain, row.split.is_some()), "{}", row.id);
        assert!(
            metrics.iter().any(|m| m.id.split('.').next() == Some(row.id) && m.version == row.version),
            "{}",
            row.id
        );
    }
    assert!(metrics.iter().all(|m| !m.label.is_empty()));
}

#[test]
fn the_rate_of_the_recording_does_not_reach_a_metric() {
    let tremor = |t_s: f64| 0.1 * libm::sin(2.0 * PI * 11.0 * t_s);
    let mut fast = record(1000.0, 12.0, |t_s| down(tremor(t_s), 0.0, 2.0 * t_s.min(10.0) + tremor(t_s) - 1.0));
    press(&mut fast, 1.0..12.0, |t_s| 1.0 + libm::sin(t_s));
    mark(&mut fast, 6.0, EventKind::TipRupture, Some(1));
    let mut bundle = bundle();
    bundle.exercise.rubric = vec![line("peak_force_n", 1.0, 3.0, 1.0)];
    let (fast, slow) = (judge(&fast, &bundle), judge(&decimate(&fast, 0), &bundle));
    for (a, b) in fast.metrics.iter().zip(&slow.metrics) {
        assert_eq!((a.applies, &a.absent), (b.applies, &b.absent), "{} applies at one rate only", a.id);
        let (x, y) = (a.value.unwrap_or(0.0), b.value.unwrap_or(0.0));
        assert!((x - y).abs() <= 0.01 * x.abs().max(y.abs()) + 1e-3, "{}: {x} at 1 kHz, {y} at 250 Hz", a.id);
    }
}
