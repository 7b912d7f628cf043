//! Coaching speaks once when a limit is passed and again only after the needle has come back below it: it would fail if a
//! message repeated each tick, came from a tremor, or came in the wrong unit or outside the body.

use assessment::Coach;
use documents::CoachingRule;
use nalgebra::Vector3;
use recording::Recording;

use super::support::{Pose, bundle, down, press, record};

fn rule(quantity: &str, above: f64, rearm_below: f64) -> CoachingRule {
    CoachingRule { quantity: quantity.into(), above, rearm_below, message: quantity.into() }
}

/// Times at which something is said.
fn said_s(recording: &Recording, rule: CoachingRule) -> Vec<f64> {
    let mut exercise = bundle().exercise;
    exercise.coaching = vec![rule];
    let mut coach = Coach::new(&exercise);
    let samples = recording.samples.iter();
    samples.filter(|sample| !coach.watch(sample, sample.axial_n()).is_empty()).map(|sample| sample.t_s).collect()
}

#[track_caller]
fn expect_times(found_s: &[f64], expected_s: &[f64]) {
    let near = found_s.len() == expected_s.len() && found_s.iter().zip(expected_s).all(|(a, b)| (a - b).abs() < 5e-3);
    assert!(near, "said at {found_s:?} s, not at {expected_s:?} s");
}

/// Down at 2 mm/s to 10 mm, up to `back_mm`, down again.
fn twice(back_mm: f64) -> Recording {
    record(1000.0, 14.0, |t_s| {
        let depth = if t_s < 5.0 { 2.0 * t_s } else { back_mm + (2.0 * (t_s - 5.0) - (10.0 - back_mm)).abs() };
        down(0.0, 0.0, depth.min(10.0))
    })
}

#[test]
fn a_rule_speaks_again_only_after_it_was_armed_again() {
    expect_times(&said_s(&twice(4.0), rule("depth_mm", 8.0, 5.0)), &[4.0, 10.0]);
    expect_times(&said_s(&twice(6.0), rule("depth_mm", 8.0, 5.0)), &[4.0]);
}

#[test]
fn force_is_in_newtons_whichever_way_it_pulls() {
    let mut recording = twice(4.0);
    press(&mut recording, 1.0..2.0, |_| 4.0);
    press(&mut recording, 3.0..4.0, |_| -4.0);
    expect_times(&said_s(&recording, rule("force_n", 3.0, 2.0)), &[1.0, 3.0]);
}

#[test]
fn a_tremor_is_no_haste_but_haste_is() {
    // 0.15 mm at 10 Hz reaches 9.4 mm/s for moments.
    let moved = |speed_mm_s: f64| {
        let mut recording = record(1000.0, 2.0, |t_s| {
            down(0.0, 0.0, 1.0 + speed_mm_s * t_s + 0.15 * libm::sin(std::f64::consts::TAU * 10.0 * t_s))
        });
        let positions: Vec<_> = recording.samples.iter().map(|sample| Vector3::from(sample.position_m)).collect();
        for (sample, pair) in recording.samples.iter_mut().skip(1).zip(positions.windows(2)) {
            sample.velocity_m_per_s = ((pair[1] - pair[0]) * 1000.0).cast::<f32>().into();
        }
        said_s(&recording, rule("speed_mm_per_s", 15.0, 8.0)).len()
    };
    assert_eq!(moved(2.0), 0);
    assert!(moved(20.0) >= 1);
}

#[test]
fn the_angle_is_judged_inside_the_body_only() {
    let leaning = Vector3::new(0.2, 0.0, -1.0).normalize();
    let recording = record(1000.0, 4.0, |t_s| Pose { axis: leaning, ..down(0.0, 0.0, 2.0 * t_s - 4.0) });
    expect_times(&said_s(&recording, rule("angle_error_deg", 10.0, 8.0)), &[2.0]);
    expect_times(&said_s(&recording, rule("angle_error_deg", 12.0, 8.0)), &[]);
}
