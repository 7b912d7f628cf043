//! No heap in a solve: a counting allocator sees nothing while models that are made answer, whatever the load.
//!
//! It would fail on a vector that grows with the answers, and on a solver that makes its scratch anew.

use allocation_counter::measure;
use tissue::FieldModel;
use tissue::axisymmetric::{Superposed, fit};
use tissue::volumetric::{Corotational, Effort, MeshSpec3, Patch, Problem3, Volumetric};
use trials::slabs::{ask_contactor, make_elastic_layer};

#[test]
fn the_axisymmetric_model_never_allocates_once_it_is_made() {
    let problem = ask_contactor(vec![make_elastic_layer(0.002, 1e5, 0.45), make_elastic_layer(0.04, 2e4, 0.45)], 0.0);
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
    let problem = Problem3::flat(&ask_contactor(
        vec![make_elastic_layer(0.002, 1e5, 0.45), make_elastic_layer(0.04, 2e4, 0.45)],
        0.0,
    ));
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
