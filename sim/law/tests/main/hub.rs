//! The hub ends the shaft: a stiff, conservative contact that is reported once.
//!
//! Would fail if a needle went in farther than it is long for nothing, if a needle without a hub were stopped, or if a hand that trembles with
//! the hub at the skin met it again and again.

use law::Skin;
use law::puncture::{PunctureEvent, PunctureOutput, PunctureSpec};
use nalgebra::{Point3, Vector3};
use trials::needle::{DrivenNeedle, NeedleTick};
use trials::scenes::training_axial_spec;

const LENGTH_M: f64 = 0.05;
const STIFFNESS_N_PER_M: f64 = 2500.0;

fn needle(hub_stiffness_n_per_m: Option<f64>) -> DrivenNeedle {
    let spec = PunctureSpec {
        axial: training_axial_spec(),
        lateral_stiffness_n_per_m2: 10_000.0,
        needle_length_m: LENGTH_M,
        hub_stiffness_n_per_m,
        needle_bending_n_m2: None,
        skin: Skin::Flat,
        structures: Vec::new(),
    };
    DrivenNeedle::held_over(spec).expect("a valid scene")
}

/// Straight down to each depth below the skin in m, one after the other.
fn drive(needle: &mut DrivenNeedle, depths_m: &[f64]) -> Vec<NeedleTick> {
    let at = |depth_m: f64| Point3::new(0.0, 0.0, -depth_m);
    let starts = std::iter::once(&-0.001).chain(depths_m);
    starts.zip(depths_m).flat_map(|(from, to)| needle.travel(-Vector3::z(), at(*from), at(*to))).collect()
}

fn hub_contacts(ticks: &[NeedleTick]) -> usize {
    ticks.iter().flat_map(|tick| &tick.events).filter(|event| **event == PunctureEvent::HubContact).count()
}

#[test]
fn the_hub_pushes_back_beyond_the_length_of_the_shaft_alone() {
    let (with, without) = (drive(&mut needle(Some(STIFFNESS_N_PER_M)), &[0.054]), drive(&mut needle(None), &[0.054]));
    for (with, without) in with.iter().zip(&without) {
        let expected_n = STIFFNESS_N_PER_M * (with.output.x_m - LENGTH_M).max(0.0);
        assert!((with.output.hub_n - expected_n).abs() < 1e-9, "{} at {}", with.output.hub_n, with.output.x_m);
        let PunctureOutput { hand_n, force_n, .. } = with.output;
        assert!((hand_n - without.output.hand_n - expected_n).abs() < 1e-9);
        assert!((force_n.z - without.output.force_n.z - expected_n).abs() < 1e-9);
        assert_eq!(with.output.axial, without.output.axial, "the layers' share knows no hub");
    }
    assert_eq!((hub_contacts(&with), hub_contacts(&without)), (1, 0));
}

#[test]
fn a_push_on_the_hub_is_given_back() {
    let mut needle = needle(Some(STIFFNESS_N_PER_M));
    let ticks = drive(&mut needle, &[0.054, 0.049]);
    let work_j: f64 = ticks
        .windows(2)
        .map(|pair| 0.5 * (pair[0].output.hub_n + pair[1].output.hub_n) * (pair[1].output.x_m - pair[0].output.x_m))
        .sum();
    assert!(work_j.abs() < 1e-9, "{work_j} J");
}

#[test]
fn a_hand_that_trembles_at_the_hub_meets_it_once() {
    let trembling: Vec<f64> = std::iter::repeat_n([0.0503, 0.0497], 20).flatten().collect();
    let mut needle = needle(Some(STIFFNESS_N_PER_M));
    assert_eq!(hub_contacts(&drive(&mut needle, &trembling)), 1);
    assert_eq!(hub_contacts(&drive(&mut needle, &[0.0494, 0.0503])), 1, "it was clear in between");
}
