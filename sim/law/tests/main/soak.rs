//! Random needle motion on a scene with structures: no bound is exceeded, and the same seed moves the same needle.
//!
//! It would fail if any sequence of motions made a force without end, lost or made energy, or if the motion met nothing.

use law::puncture::PunctureParams;
use trials::needle::DrivenNeedle;
use trials::scenes::training_axial_spec;
use trials::soak;

use crate::structures::one_of_each;

const TICKS: u32 = 120_000;

fn scene() -> PunctureParams {
    DrivenNeedle::new(training_axial_spec(), one_of_each()).expect("a valid scene").params
}

#[test]
fn nothing_that_a_hand_can_do_exceeds_a_bound() {
    for seed in 0..4 {
        let seen = soak(&scene(), None, TICKS, seed);
        assert!(seen.passes(), "seed {seed}: {seen:?}");
        assert!(seen.tracks > 10 && seen.ruptures > 30, "seed {seed} moves too little: {seen:?}");
    }
}

#[test]
fn a_seed_moves_the_same_needle() {
    assert_eq!(soak(&scene(), None, 5000, 7), soak(&scene(), None, 5000, 7));
    assert_ne!(soak(&scene(), None, 5000, 7), soak(&scene(), None, 5000, 8));
}
