//! No heap in the tick: a counting allocator sees nothing while steps run, whatever happens in them.
//!
//! It would fail on a vector that grows with events or tracks, and on a query of a shape that builds a heap.

use allocation_counter::measure;
use law::axial::AxialSpec;
use law::operator::{Felt, Operator, Plan, Skill, needle_pose};
use law::puncture::{PunctureInput, step};
use nalgebra::{Point3, Vector3};
use trials::needle::DrivenNeedle;
use trials::scenes::{AxialRun, in_hold_out_in, optioned_axial_spec, training_axial_spec};

use crate::structures::one_of_each;

#[test]
fn the_axial_law_never_allocates() {
    for spec in [training_axial_spec(), optioned_axial_spec()] {
        count_allocations(spec);
    }
}

fn count_allocations(spec: AxialSpec) {
    let mut run = AxialRun::new(spec).expect("a valid scene");
    let counted = measure(|| {
        for leg in in_hold_out_in() {
            run.travel(&leg, |_, _, _| ());
        }
        run.step(f64::NAN, 0.0);
        run.step(100.0, 0.05);
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(run.state.tip_open, 3);
}

#[test]
fn puncture_never_allocates_with_events_tracks_or_any_shape() {
    let mut needle = DrivenNeedle::new(training_axial_spec(), one_of_each()).expect("a valid scene");
    let axis = Vector3::new(0.1, 0.0, -1.0).normalize();
    let mut events = 0;
    let counted = measure(|| {
        for tick in 0..20_000_u32 {
            let t_s = f64::from(tick) * 1e-3;
            let depth_m = 0.03 * libm::sin(3.0 * t_s);
            let tip = Point3::new(0.05 * libm::sin(0.37 * t_s), 0.04 * libm::cos(0.23 * t_s), -depth_m);
            let input = PunctureInput { t_s, patient_from_needle: needle_pose(&tip, &axis) };
            step(&needle.params, &mut needle.state, &mut needle.scratch, &input);
            events += needle.scratch.events.len();
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(events > 50 && needle.state.tracks() > 5, "the path must have been eventful: {events} events");
}

#[test]
fn an_operator_never_allocates() {
    let plan = Plan {
        entry_m: Point3::origin(),
        skin: law::Skin::Flat,
        axis: -Vector3::z(),
        target_x_m: 0.02,
        approach_m: 0.01,
        hold_s: 0.5,
        reach_m: 0.15,
    };
    let mut operator = Operator::skilled(&Skill::novice(), &plan, 1);
    let counted = measure(|| {
        for _ in 0..2000 {
            operator.step(1e-3, &Felt::from(Vector3::new(0.0, 0.0, 0.3)));
        }
    });
    assert_eq!(counted.count_total, 0);
}
