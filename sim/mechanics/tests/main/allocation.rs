//! No heap in the tick: a counting allocator sees nothing while steps run, whatever happens in them.
//!
//! It would fail on a vector that grows with events or tracks, and on a query of a shape that builds a heap.

use allocation_counter::measure;
use bench::slabs::{contactor, layer};
use mechanics::operator::{Operator, Plan, Skill, needle_pose};
use mechanics::puncture::{PunctureInput, step};
use mechanics::tissue::FieldModel;
use mechanics::tissue::axisymmetric::{Superposed, fit};
use mechanics::tissue::volumetric::{Corotational, Effort, MeshSpec3, Patch, Problem3, Volumetric};
use nalgebra::{Point3, Vector3};

use crate::structures::one_of_each;
use bench::needle::Needle;
use bench::scenes::{Run, in_hold_out_in, training};

#[test]
fn the_axial_law_never_allocates() {
    let mut run = Run::new(training()).expect("a valid scene");
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
fn the_puncture_never_allocates_with_events_tracks_and_every_kind_of_shape() {
    let mut needle = Needle::new(training(), one_of_each()).expect("a valid scene");
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
        axis: -Vector3::z(),
        target_x_m: 0.02,
        approach_m: 0.01,
        hold_s: 0.5,
        reach_m: 0.15,
    };
    let mut operator = Operator::skilled(&Skill::novice(), &plan, 1);
    let counted = measure(|| {
        for _ in 0..2000 {
            operator.step(1e-3, &Vector3::new(0.0, 0.0, 0.3));
        }
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn the_axisymmetric_model_never_allocates_once_it_is_made() {
    let problem = contactor(vec![layer(0.002, 1e5, 0.45), layer(0.04, 2e4, 0.45)], 0.0);
    let mut model = fit(&problem, 1e-2).expect("a model").model;
    let points: Vec<[f64; 2]> = (0..100).map(|at| [2e-4 * f64::from(at), 3e-4 * f64::from(at)]).collect();
    let responses = Superposed::new(&mut [&mut model], &points);
    let mut answer = vec![[0.0; 2]; points.len()];
    let counted = measure(|| {
        for tick in 0..100 {
            model.solve(f64::from(tick));
            answer.iter_mut().zip(&points).for_each(|(to, &[r_m, depth_m])| *to = model.displacement_m(r_m, depth_m));
            responses.answer(&[f64::from(tick)], &mut answer);
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(answer[0][0] < 0.0);
}

#[test]
fn the_volumetric_models_never_allocate_once_they_are_made() {
    let problem = Problem3::flat(&contactor(vec![layer(0.002, 1e5, 0.45), layer(0.04, 2e4, 0.45)], 0.0));
    let mesh = MeshSpec3::ladder(&problem)[0];
    let patch = Patch::new(&problem, &mesh).expect("a patch");
    let effort = Effort { iterations: 10, tolerance: 1e-3 };
    let mut models: [Box<dyn FieldModel>; 3] = [
        Box::new(Volumetric::new(&problem, &mesh).expect("a model")),
        Box::new(Corotational::new(patch.clone(), None, effort).expect("held")),
        Box::new(Corotational::new(patch, Some(1e-3), effort).expect("held")),
    ];
    let counted = measure(|| {
        for model in &mut models {
            for force_n in [0.1, 0.2, 50.0, f64::NAN, 0.0] {
                model.solve(force_n);
                assert!(model.displacement_m(1e-3, 1e-3)[0].is_finite());
            }
        }
    });
    assert_eq!(counted.count_total, 0);
}
