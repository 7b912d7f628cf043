//! The shipped epidural scene against the profile that it is fitted to: the model of a patient of 71.1 kg in a public simulator.
//!
//! Would fail if an edit of the scene, or of what a needle makes of its numbers, moved the curve away from the profile, or gave a
//! second loss of resistance.

use documents::load::read_document;
use documents::{Document, Patient, Scene};
use law::soundness;
use trials::scenes::AxialRun;

use crate::support::curricula;

/// The profile: depth in m, force in N.
const PROFILE: &str = include_str!("../../../../tests/data/calibrate/epidural-71kg.csv");
/// Where resistance is lost, in mm.
const LOSS_MM: f64 = 48.38;

fn epidural() -> Scene {
    match read_document(&curricula().join("scenes/epidural-71kg.toml")).unwrap() {
        Document::Scene(scene) => *scene,
        other => panic!("not a scene: {other:?}"),
    }
}

/// The force at every 10 µm to a depth, at 1 mm/s.
fn walk(scene: &Scene, to_mm: f64) -> Vec<f64> {
    let mut run = AxialRun::new(scene.axial_spec(&Patient::nominal(scene))).unwrap();
    (0..=(to_mm * 1e2) as u32).map(|tick| run.step(f64::from(tick) * 1e-2, f64::from(tick) * 1e-5).total_n()).collect()
}

#[test]
fn curve_follows_the_profile() {
    let walk = walk(&epidural(), LOSS_MM - 0.5);
    let rows = PROFILE.lines().filter_map(|line| line.split_once(','));
    let samples = rows.filter_map(|(m, n)| Some((m.parse::<f64>().ok()? * 1e3, n.parse::<f64>().ok()?)));
    let off: Vec<f64> = samples
        .filter(|(mm, _)| *mm < LOSS_MM - 0.5)
        .map(|(mm, profile_n)| (walk[(mm * 1e2).round() as usize] - profile_n).abs())
        .collect();
    let mean_n = off.iter().sum::<f64>() / off.len() as f64;
    // What differs is where a boundary gives way: the law drops at once, the profile over some millimetres.
    assert!(mean_n < 1.0, "{mean_n} N on average");
    let far = off.iter().filter(|off_n| **off_n > 1.3).count();
    assert!(far < off.len() / 3, "{far} of {} samples are more than 1.3 N off", off.len());
}

#[test]
fn resistance_is_lost_once() {
    let scene = epidural();
    assert!(scene.remark_early_loss().is_none());
    let falls = scene.list_falls_n();
    let most = falls.iter().copied().max_by(|one, other| one.1.total_cmp(&other.1)).unwrap();
    assert_eq!(scene.layers[most.0].name, "epidural space", "{falls:?}");
    let mut tough = scene;
    tough.layers[2].tip_rupture_n *= 3.0;
    let remark = tough.remark_early_loss().expect("the supraspinous ligament now loses as much");
    assert!(remark.found.to_string().contains("supraspinous ligament"), "{remark:?}");
}

#[test]
fn the_space_is_without_resistance_and_ends_at_the_dura() {
    let scene = epidural();
    let last_mm = LOSS_MM + 0.2;
    let mut run = AxialRun::new(scene.axial_spec(&Patient::nominal(&scene))).unwrap();
    let mut force_n = |mm: f64| run.step(mm, mm * 1e-3).total_n();
    let walk: Vec<f64> = (0..600).map(|at| force_n(f64::from(at) * 0.1)).collect();
    let in_space = (last_mm * 10.0).ceil() as usize..=569;
    // Nothing but the shaft's own friction, 7 % of what was lost.
    assert!(walk[in_space].iter().all(|force_n| (0.55..0.75).contains(force_n)), "{walk:?}");
    assert!(walk[595] > 1.5, "the dura is not felt at 59.5 mm: {} N", walk[595]);
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
