//! Patients drawn from the spread: the same for a seed, within the spread, each layer on its own.
//!
//! Would fail if one layer's draw moved another's, if the draw were not uniform, or if a thickness went negative.

use documents::{Patient, Scene};
use proptest::prelude::*;

use crate::support::{SCENE, scene};

fn varied() -> Scene {
    scene(&SCENE.replace("thickness_mm = 8.4", "thickness_mm = 8.4\nthickness_spread_mm = 2"))
}

#[test]
fn a_seed_draws_one_patient_and_another_seed_another() {
    let scene = varied();
    assert_eq!(Patient::draw(&scene, 7), Patient::draw(&scene, 7));
    assert_ne!(Patient::draw(&scene, 7), Patient::draw(&scene, 8));
}

#[test]
fn a_draw_stays_what_it_was() {
    // Recordings keep their patient, but a published seed must go on meaning the same one.
    let fat_mm = Patient::draw(&varied(), 42).thickness_mm[1];
    assert!((fat_mm - FAT_OF_SEED_42_MM).abs() < 1e-12, "{fat_mm}");
}

const FAT_OF_SEED_42_MM: f64 = 9.086_284_477_020_074;

#[test]
fn a_layer_without_spread_is_the_same_in_everyone() {
    let scene = varied();
    for seed in 0..50 {
        assert_eq!(Patient::draw(&scene, seed).thickness_mm[0], 0.8);
    }
}

#[test]
fn draws_fill_the_spread_evenly() {
    let scene = varied();
    let mut quarters = [0; 4];
    for seed in 0..4000 {
        let fat = Patient::draw(&scene, seed).thickness_mm[1];
        quarters[(fat - 6.4).floor() as usize] += 1;
    }
    // A quarter of 4000 draws has a standard deviation of 27.
    assert!(quarters.iter().all(|n| (870..1130).contains(n)), "{quarters:?}");
}

#[test]
fn layers_vary_independently_of_each_other() {
    let mut scene = varied();
    scene.layers[0].thickness_spread_mm = 0.5;
    let side = |seed| {
        let patient = Patient::draw(&scene, seed);
        (patient.thickness_mm[0] > 0.8) == (patient.thickness_mm[1] > 8.4)
    };
    let same = (0..4000).filter(|&seed| side(seed)).count();
    // The standard deviation of the count is 32.
    assert!((1850..2150).contains(&same), "{same} of 4000 on the same side");
}

#[test]
fn adding_a_layer_leaves_the_others_as_they_were() {
    let before = varied();
    let mut after = before.clone();
    let mut fascia = before.layers[1].clone();
    fascia.name = "fascia".to_owned();
    after.layers.insert(0, fascia);
    for seed in 0..50 {
        assert_eq!(Patient::draw(&after, seed).thickness_mm[1..], Patient::draw(&before, seed).thickness_mm);
    }
}

proptest! {
    #[test]
    fn a_thickness_is_within_its_spread_and_never_negative(seed: u64, nominal in 0.0..50.0, spread in 0.0..100.0) {
        let mut scene = varied();
        scene.layers[1].thickness_mm = nominal;
        scene.layers[1].thickness_spread_mm = spread;
        let drawn = Patient::draw(&scene, seed).thickness_mm[1];
        prop_assert!(drawn >= 0.0 && (drawn - nominal).abs() <= spread);
    }
}
