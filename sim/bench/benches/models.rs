//! Durations of the tissue models. Axisymmetric: set-up to a tolerance, re-solve, superposed result
//! at 108 points.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use tissue::axisymmetric::{Axisymmetric, FittedAxisymmetric, MeshSpec, Superposed, fit};
use tissue::{FieldModel, Problem};
use trials::slabs::{ask_contactor, make_elastic_layer};

/// The contactors of lower_back and of stiff_skin_soft_fat, sampled at the boundaries.
fn problems() -> Vec<(String, Problem)> {
    let lower_back = vec![
        make_elastic_layer(0.0008, 132e3, 0.45),
        make_elastic_layer(0.0084, 33.1e3, 0.45),
        make_elastic_layer(0.039, 198e3, 0.45),
    ];
    let stiff_skin = vec![
        make_elastic_layer(0.002, 1e6, 0.48),
        make_elastic_layer(0.02, 5e3, 0.48),
        make_elastic_layer(0.03, 60e3, 0.48),
    ];
    let at = |name: &str, layers: &[_], depth_m: f64| {
        (format!("{name} at {} mm", 1e3 * depth_m), ask_contactor(layers.to_vec(), depth_m))
    };
    let backs = [0.0, 0.0008, 0.0092].map(|depth_m| at("lower_back", &lower_back, depth_m));
    let skins = [0.0, 0.002].map(|depth_m| at("stiff_skin_soft_fat", &stiff_skin, depth_m));
    backs.into_iter().chain(skins).collect()
}

fn axisymmetric(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("axisymmetric");
    group.sample_size(10);
    for tolerance in [1e-2, 1e-3] {
        for (name, problem) in problems() {
            let id = |what: &str| BenchmarkId::new(format!("{what}, tolerance {tolerance}"), &name);
            group.bench_function(id("set-up"), |bencher| bencher.iter(|| fit(black_box(&problem), tolerance)));
            let Ok(FittedAxisymmetric { mut model, .. }) = fit(&problem, tolerance) else { continue };
            group.bench_function(id("re-solve"), |bencher| bencher.iter(|| model.solve(black_box(0.05))));
        }
    }
    group.finish();
}

fn superposed(criterion: &mut Criterion) {
    let points: Vec<[f64; 2]> = (0..108).map(|at| [2e-4 * f64::from(at % 36), 3e-4 * f64::from(at / 36)]).collect();
    let fitted = problems().into_iter().take(3).filter_map(|(_, problem)| Some(fit(&problem, 1e-2).ok()?.model));
    let mut models: Vec<Axisymmetric> = fitted.collect();
    let mut loads: Vec<&mut dyn FieldModel> = models.iter_mut().map(|model| model as _).collect();
    let responses = Superposed::new(&mut loads, &points);
    let mut answer = vec![[0.0; 2]; points.len()];
    criterion.bench_function("axisymmetric/superposed, three loads, 108 points", |bencher| {
        bencher.iter(|| responses.answer(black_box(&[0.5, 1.0, 0.2]), &mut answer));
    });
}

/// Set-up and re-solve against the number of unknowns: one problem on each mesh of the ladder.
fn growth(criterion: &mut Criterion) {
    let Some((_, problem)) = problems().into_iter().next() else { return };
    let mut group = criterion.benchmark_group("axisymmetric growth");
    group.sample_size(10);
    for mesh in MeshSpec::ladder(&problem) {
        let Ok(mut model) = Axisymmetric::new(&problem, &mesh) else { continue };
        let id = |what| BenchmarkId::new(what, model.unknowns());
        let (set_up, re_solve) = (id("set-up"), id("re-solve"));
        group.bench_function(set_up, |bencher| bencher.iter(|| Axisymmetric::new(black_box(&problem), &mesh)));
        group.bench_function(re_solve, |bencher| bencher.iter(|| model.solve(black_box(0.05))));
    }
    group.finish();
}

criterion_group!(benches, axisymmetric, superposed, growth);
criterion_main!(benches);
