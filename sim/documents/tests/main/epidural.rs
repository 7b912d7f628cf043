//! The shipped epidural scene against the profile of the literature that it is fitted to (a patient of 71 kg, a Tuohy needle).
//!
//! Would fail if an edit of the scene, or of what a needle makes of its numbers, moved a peak by 1 mm or 10 %.

use documents::load::read_document;
use documents::{Document, Patient, Scene};
use law::soundness;
use trials::scenes::AxialRun;

use crate::support::curricula;

/// Depth of the tip in mm, force before and after in N, of every drop: skin, supraspinous ligament, interspinous ligament (a
/// plateau), ligamentum flavum, loss of resistance. The depths of the ligaments are chosen; the literature gives none.
const DROPS: [(f64, f64, f64); 5] =
    [(13.92, 6.04, 1.98), (22.0, 4.35, 3.05), (41.0, 7.46, 7.47), (47.5, 12.13, 9.3), (48.38, 10.01, 0.0)];
/// Where the dura lies, in mm.
const DURA_MM: f64 = 56.98;

fn epidural() -> Scene {
    match read_document(&curricula().join("scenes/epidural-71kg.toml")).unwrap() {
        Document::Scene(scene) => *scene,
        other => panic!("not a scene: {other:?}"),
    }
}

/// Depth of the tip in mm, force before and after in N, wherever a boundary gives way on the way to a depth, at 1 mm/s and 1 kHz.
fn drops(scene: &Scene, to_mm: f64) -> Vec<(f64, f64, f64)> {
    let mut run = AxialRun::new(scene.axial_spec(&Patient::nominal(scene))).unwrap();
    let (mut drops, mut before_n) = (Vec::new(), 0.0);
    for tick in 0..=(to_mm * 1e3) as u32 {
        let force_n = run.step(f64::from(tick) * 1e-3, f64::from(tick) * 1e-6).total_n();
        if !run.ruptures().is_empty() {
            drops.push((f64::from(tick) * 1e-3, before_n, force_n));
        }
        before_n = force_n;
    }
    drops
}

#[test]
fn every_peak_is_within_a_millimetre_and_a_tenth_of_its_force() {
    let drops = drops(&epidural(), DURA_MM);
    assert_eq!(drops.len(), DROPS.len(), "{drops:?}");
    for (found, wanted) in drops.iter().zip(DROPS) {
        assert!((found.0 - wanted.0).abs() <= 1.0, "{found:?} instead of {wanted:?}");
        assert!((found.1 / wanted.1 - 1.0).abs() <= 0.1, "{found:?} instead of {wanted:?}");
        assert!((found.2 - wanted.2).abs() <= 0.1 * wanted.1, "{found:?} instead of {wanted:?}");
    }
}

#[test]
fn the_space_is_without_resistance_and_ends_at_the_dura() {
    let scene = epidural();
    let (last_mm, _, _) = drops(&scene, DURA_MM)[4];
    let mut run = AxialRun::new(scene.axial_spec(&Patient::nominal(&scene))).unwrap();
    let mut force_n = |mm: f64| run.step(mm, mm * 1e-3).total_n();
    let walk: Vec<f64> = (0..580).map(|at| force_n(f64::from(at) * 0.1)).collect();
    let in_space = (last_mm * 10.0).ceil() as usize..=569;
    // Nothing but the shaft's own friction, 7 % of what was lost.
    assert!(walk[in_space].iter().all(|force_n| (0.55..0.75).contains(force_n)), "{walk:?}");
    assert!(walk[572] > 1.0, "the dura is not felt at 57.2 mm: {} N", walk[572]);
}

#[test]
fn it_is_sound_with_a_single_contactor() {
    let scene = epidural();
    let spec = scene.axial_spec(&Patient::nominal(&scene));
    assert!(spec.tip_to_rim_m == 0.0 && scene.needle.tip_to_rim_mm == 0.0);
    assert!(soundness::find_unsound_ruptures(&spec).is_empty());
}

#[test]
fn the_shaft_is_felt_all_the_way_out() {
    let scene = epidural();
    let mut run = AxialRun::new(scene.axial_spec(&Patient::nominal(&scene))).unwrap();
    let mut force_n = |tick: u32, mm: f64| run.step(f64::from(tick) * 1e-2, mm * 1e-3).total_n();
    (0..=500).for_each(|tick| {
        force_n(tick, f64::from(tick) * 0.1);
    });
    let out: Vec<f64> = (501..=990).map(|tick| force_n(tick, f64::from(1000 - tick) * 0.1)).collect();
    // It takes half a millimetre until friction has turned about; from there on it holds the needle back, less and less.
    assert!(out[10..].iter().all(|force_n| *force_n < 0.0), "{out:?}");
    assert!(out[10] < -0.5 && out[400] > -0.3, "{} N and {} N", out[10], out[400]);
}
