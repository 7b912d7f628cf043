//! An attempt that tells nothing of whoever made it is void, with the reason; any other is judged as before.
//!
//! It would fail on a lost device that is judged as a needle too shallow, and on a hiccup that voids an attempt it hardly touched.

use assessment::void::{MOST_UNFELT, find_void_reason};
use assessment::{AssessError, Void, assess};
use recording::sample::flags;
use recording::{EventKind, Recording};

use crate::support::{bundle, down, event, record};

/// Two seconds in the body, of which a part goes unfelt.
fn unfelt(part: f64) -> Recording {
    let mut recording = record(1000.0, 2.0, |t_s| down(0.0, 0.0, 10.0 * t_s));
    let count = recording.samples.len() as f64;
    for (at, sample) in recording.samples.iter_mut().enumerate() {
        sample.flags |= flags::INSIDE | if (at as f64) < part * count { flags::UNFELT } else { 0 };
    }
    recording
}

#[test]
fn a_lost_device_is_not_the_trainees_failure() {
    let mut recording = unfelt(0.0);
    assert_eq!(find_void_reason(&recording), None);
    let last = *recording.samples.last().expect("samples");
    let mut lost = event(EventKind::Interrupted, &last, None);
    "device lost: the device is gone".clone_into(&mut lost.text);
    recording.events.push(lost);
    let error = assess(&recording, &bundle()).expect_err("it is not judged");
    assert!(matches!(&error, AssessError::Void(Void::Interrupted { t_s, .. }) if *t_s > 1.9), "{error}");
    assert!(error.to_string().starts_with("void: ended after 2.0 s: device lost"), "{error}");
}

#[test]
fn what_was_not_felt_for_too_long_is_not_judged() {
    assert!(assess(&unfelt(MOST_UNFELT - 0.01), &bundle()).is_ok());
    let error = assess(&unfelt(MOST_UNFELT + 0.01), &bundle()).expect_err("it is not judged");
    let AssessError::Void(Void::Unfelt { unfelt_s, inside_s }) = error else { panic!("{error}") };
    assert!((unfelt_s - 0.22).abs() < 0.01 && (inside_s - 2.0).abs() < 0.01, "{unfelt_s} s of {inside_s} s");
    let mut outside = unfelt(1.0);
    outside.samples.iter_mut().for_each(|sample| sample.flags &= !flags::INSIDE);
    assert_eq!(find_void_reason(&outside), None, "in the air there is nothing to feel");
}
