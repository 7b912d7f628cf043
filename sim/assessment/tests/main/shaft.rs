//! Each metric of the path, of turning and of structures on motions whose answer is known in closed form.
//! Fails when an area, a distance or a count is taken of something else than the catalogue says.

use assessment::Direction;
use documents::{Shape, StructureKind};
use nalgebra::Vector3;
use recording::EventKind;

use crate::support::{Pose, bundle, down, expect, expect_anew, judge, mark, orientation, plunge, record, structure};

const PI: f64 = std::f64::consts::PI;

#[test]
fn a_sideways_shift_sweeps_a_rectangle_and_a_tilt_a_triangle() {
    let shift = record(1000.0, 4.0, |t_s| down(2.0 * (t_s - 1.0).clamp(0.0, 2.0), 0.0, 10.0));
    expect(&judge(&shift, &bundle()), "sweep_area_mm2", 40.0, 0.2);
    let tilt = record(1000.0, 4.0, |t_s| {
        let angle = (0.1 * (t_s - 1.0)).clamp(0.0, 0.2);
        let axis = Vector3::new(libm::sin(angle), 0.0, -libm::cos(angle));
        let tip = axis * 10.0 / libm::cos(angle);
        Pose { tip_mm: [tip.x, tip.y, tip.z], axis }
    });
    let assessment = judge(&tilt, &bundle());
    expect(&assessment, "sweep_area_mm2", 50.0 * libm::tan(0.2), 0.2);
    expect(&assessment, "redirections", 1.0, 0.0);
}

#[test]
fn a_circle_about_the_line_has_its_length_and_no_spread() {
    let turn = |t_s: f64| (2.0 * libm::cos(2.0 * PI * t_s), 2.0 * libm::sin(2.0 * PI * t_s));
    let circle = record(1000.0, 10.0, |t_s| down(turn(t_s).0, turn(t_s).1, 10.0));
    let assessment = judge(&circle, &bundle());
    expect(&assessment, "path_length_mm", 40.0 * PI, 0.1);
    expect(&assessment, "path_deviation_sd_mm", 0.0, 1e-6);
    expect(&assessment, "axis_travel_mm", 0.0, 1e-6);
    expect(&assessment, "translational_actions", 1.0, 0.0);
    // A line through the plan: |2 sin| has the mean 4/π and the mean square 2.
    let swing = record(1000.0, 10.0, |t_s| down(turn(t_s).1, 0.0, 10.0));
    expect(&judge(&swing, &bundle()), "path_deviation_sd_mm", (2.0 - 16.0 / (PI * PI)).sqrt(), 1e-3);
}

#[test]
fn quick_turn_is_one_action_for_either_quaternion_sign() {
    let mut recording = record(1000.0, 3.0, |t_s| {
        let angle = (t_s - 1.0).clamp(0.0, 0.5) * 2.0;
        Pose { tip_mm: [0.0, 0.0, -10.0], axis: Vector3::new(libm::sin(angle), 0.0, -libm::cos(angle)) }
    });
    recording.samples.iter_mut().step_by(3).for_each(|s| s.orientation = s.orientation.map(|q| -q));
    expect(&judge(&recording, &bundle()), "rotational_actions", 1.0, 0.0);
    recording.samples.iter_mut().for_each(|s| s.orientation = orientation(&-Vector3::z()));
    expect(&judge(&recording, &bundle()), "rotational_actions", 0.0, 0.0);
}

#[test]
fn smoothness_of_a_sine_is_its_closed_form() {
    // v = A ω cos ωt, j = −A ω³ cos ωt: T³/v² ∫j² dt = T³ ω⁴ T/2 over whole periods.
    let (omega, duration_s) = (2.0 * PI * 0.5, 20.0_f64);
    let sine = record(1000.0, duration_s, |t_s| down(0.0, 0.0, 10.0 + 3.0 * libm::sin(omega * t_s)));
    let expected = -libm::log(duration_s.powi(4) * omega.powi(4) / 2.0);
    expect(&judge(&sine, &bundle()), "smoothness_ldlj", expected, 0.02);
}

#[test]
fn clearance_is_measured_from_the_whole_shaft() {
    let mut bundle = bundle();
    let sphere = Shape::Sphere { radius_m: 2e-3 };
    let capsule = Shape::Capsule { half_axis_m: Vector3::new(0.0, 20e-3, 0.0), radius_m: 1e-3 };
    let cuboid = Shape::Box { half_extents_m: Vector3::new(1e-3, 2e-3, 3e-3) };
    let corners = [[0.0, -0.05, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 0.05]];
    let mesh = Shape::Mesh { vertices_m: corners.map(Into::into).to_vec(), triangles: vec![[0, 1, 2]] };
    bundle.scene.structures = vec![
        structure("beside the shaft", StructureKind::Vessel, sphere.clone(), [5.0, 0.0, -10.0]),
        structure("below the tip", StructureKind::Target, sphere, [0.0, 0.0, -28.0]),
        structure("across", StructureKind::Nerve, capsule, [4.0, 0.0, -10.0]),
        structure("rib", StructureKind::Bone, cuboid, [4.0, 6.0, -23.0]),
        structure("wall", StructureKind::Organ, mesh, [7.0, 0.0, -30.0]),
        structure("struck", StructureKind::Organ, Shape::Sphere { radius_m: 1e-3 }, [0.5, 0.0, -12.0]),
    ];
    let assessment = judge(&plunge(20.0), &bundle);
    expect(&assessment, "structure_clearance_mm.beside the shaft", 3.0, 1e-6);
    expect(&assessment, "structure_clearance_mm.below the tip", 6.0, 1e-6);
    expect(&assessment, "structure_clearance_mm.across", 3.0, 1e-6);
    expect(&assessment, "structure_clearance_mm.rib", 5.0, 1e-6);
    expect(&assessment, "structure_clearance_mm.wall", 7.0, 0.05);
    expect(&assessment, "structure_clearance_mm.struck", 0.0, 0.0);
    let direction = |id: &str| assessment.metrics.iter().find(|m| m.id == id).map(|m| m.direction);
    assert_eq!(direction("structure_clearance_mm.rib"), Some(Direction::Higher));
    assert_eq!(direction("structure_clearance_mm.below the tip"), Some(Direction::Lower), "a target is to be reached");
}

#[test]
fn hits_are_counted_by_kind_and_targets_apart() {
    let mut bundle = bundle();
    let sphere = || Shape::Sphere { radius_m: 1e-3 };
    bundle.scene.structures = vec![
        structure("artery", StructureKind::Vessel, sphere(), [0.0, 0.0, -5.0]),
        structure("calyx", StructureKind::Target, sphere(), [0.0, 0.0, -15.0]),
    ];
    let mut recording = plunge(20.0);
    for (t_s, structure) in [(5.0, 0), (10.0, 1)] {
        mark(&mut recording, t_s, EventKind::StructureHit, None);
        let hit = recording.events.iter_mut().rfind(|e| e.kind == EventKind::StructureHit);
        hit.expect("just marked").structure = Some(structure);
    }
    let assessment = judge(&recording, &bundle);
    expect(&assessment, "structure_hits", 1.0, 0.0);
    expect(&assessment, "structure_hits.vessel", 1.0, 0.0);
    expect(&assessment, "structure_hits.target", 1.0, 0.0);
    expect(&assessment, "structure_hits.bone", 0.0, 0.0);
}

/// 4 mm above a sphere's top, then on it with a tremor of 10 Hz and 0.1 mm for 2 s, 0.2 s clear of it by 0.3 mm, on it, 0.4 s clear, on it,
/// drawn back by 0.6 mm for 0.1 s, and on it again.
fn trembling_on_bone(t_s: f64) -> f64 {
    match t_s {
        t if t < 1.0 => 6.0 * t,
        t if t < 3.0 => 10.0 + 0.1 * libm::sin(std::f64::consts::TAU * 10.0 * t),
        t if t < 3.2 => 9.7,
        t if t < 4.0 => 10.05,
        t if t < 4.4 => 9.7,
        t if t < 5.0 => 10.05,
        t if t < 5.1 => 9.4,
        _ => 10.05,
    }
}

#[test]
fn contact_spans_a_tremor_and_ends_when_the_needle_is_clear() {
    let mut bundle = bundle();
    bundle.scene.structures =
        vec![structure("rib", StructureKind::Bone, Shape::Sphere { radius_m: 2e-3 }, [0.0, 0.0, -12.0])];
    let mut recording = record(1000.0, 6.0, |t_s| down(0.0, 0.0, trembling_on_bone(t_s)));
    let is_in = |sample: &recording::Sample| sample.position_m[2] <= -10e-3;
    let entries: Vec<f64> = recording
        .samples
        .windows(2)
        .filter(|pair| !is_in(&pair[0]) && is_in(&pair[1]))
        .map(|pair| pair[1].t_s)
        .collect();
    for &t_s in &entries {
        mark(&mut recording, t_s, EventKind::StructureHit, None);
        let hit = recording.events.iter_mut().rfind(|e| e.kind == EventKind::StructureHit);
        hit.expect("just marked").structure = Some(0);
    }
    assert!(entries.len() > 20, "{} entries of the tip", entries.len());
    let assessment = judge(&recording, &bundle);
    expect(&assessment, "structure_hits.bone", entries.len() as f64, 0.0);
    for id in ["structure_hits", "structure_hits.bone"] {
        expect_anew(&assessment, id, 3.0, 0.0);
    }
    expect_anew(&assessment, "structure_hits.vessel", 0.0, 0.0);
}
