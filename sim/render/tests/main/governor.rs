//! The governor goes down a step when frames take too long, and up only after a long calm.
//!
//! It would fail on a picture that keeps stuttering, one that flickers between two qualities, and one that a single stall ruins.

use render::{Governor, Quality};

const BUDGET_S: f32 = 1.0 / 60.0;

/// Frames until the quality changes, or none within a minute.
fn frames_until_change(governor: &mut Governor, frame_s: f32) -> Option<(u32, Quality)> {
    (1..3600).find_map(|frame| governor.took(frame_s).map(|quality| (frame, quality)))
}

#[test]
fn slow_frames_lower_the_quality_to_the_least_and_no_farther() {
    let mut governor = Governor::new(Quality::Full, BUDGET_S);
    for expected in [Quality::High, Quality::Medium, Quality::Low, Quality::Least] {
        let (frames, quality) = frames_until_change(&mut governor, 2.0 * BUDGET_S).expect("a step down");
        assert_eq!(quality, expected);
        assert!(frames <= 15, "within a quarter of a second at 60 Hz: {frames} frames");
    }
    assert_eq!(frames_until_change(&mut governor, 2.0 * BUDGET_S), None);
}

#[test]
fn quick_frames_raise_it_slowly_and_not_above_the_best() {
    let mut governor = Governor::new(Quality::High, BUDGET_S);
    frames_until_change(&mut governor, 2.0 * BUDGET_S).expect("a step down");
    let (frames, quality) = frames_until_change(&mut governor, 0.2 * BUDGET_S).expect("a step up");
    assert_eq!(quality, Quality::High);
    assert!(frames > 120, "after seconds of calm: {frames} frames");
    assert_eq!(frames_until_change(&mut governor, 0.2 * BUDGET_S), None, "High was the best to begin with");
}

#[test]
fn it_does_not_swing() {
    let mut governor = Governor::new(Quality::Full, BUDGET_S);
    // A step down halves the time; the step up would double it again.
    let mut changes = 0;
    for _ in 0..36_000 {
        let frame_s = if governor.quality() == Quality::Full { 1.2 } else { 0.6 } * BUDGET_S;
        changes += u32::from(governor.took(frame_s).is_some());
    }
    assert_eq!(changes, 1, "ten minutes of frames");
}

#[test]
fn one_stall_or_a_time_that_is_none_changes_nothing() {
    let mut governor = Governor::new(Quality::Full, BUDGET_S);
    for frame in 0..600 {
        let frame_s = match frame % 60 {
            0 => 1.0,
            1 => f32::NAN,
            2 => -1.0,
            _ => 0.6 * BUDGET_S,
        };
        assert_eq!(governor.took(frame_s), None, "frame {frame}");
    }
}

#[test]
fn every_step_is_less_work_and_says_what_it_is() {
    for pair in Quality::ALL.windows(2) {
        let work = |quality: Quality| {
            quality.samples() as f32 * quality.resolution() + quality.shadow_texels() as f32 / 4096.0
        };
        assert!(work(pair[1]) < work(pair[0]), "{pair:?}");
        assert_eq!(pair[0].lower(), Some(pair[1]));
        assert_eq!(pair[1].higher(), Some(pair[0]));
    }
    assert_eq!(Quality::Medium.in_words(), "shadows of 1024², 1 sample per pixel, 100 % of the resolution");
}
