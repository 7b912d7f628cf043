//! scratch

use mechanics::tissue::axisymmetric::{Axisymmetric, MeshSpec, fit};
use mechanics::tissue::{FieldModel, relative_distance};
use mechanics::trials::estimates::{draw, truth};

#[test]
#[ignore]
fn explore() {
    let from: u32 = std::env::var("FROM").map_or(0, |v| v.parse().unwrap());
    let to: u32 = std::env::var("TO").map_or(40, |v| v.parse().unwrap());
    for number in from..to {
        let d = draw(number);
        let p = &d.problem;
        let t0 = std::time::Instant::now();
        let t = truth(p).unwrap();
        let truth_s = t0.elapsed().as_secs_f64();
        let t0 = std::time::Instant::now();
        let f = fit(p, d.tolerance).unwrap();
        let fit_s = t0.elapsed().as_secs_f64();
        let e = |s: &mechanics::tissue::Sampled| (relative_distance(&s.axial_m, &t.axial_m), relative_distance(&s.radial_m, &t.radial_m));
        let (a, r) = e(&p.sampled(&f.model));
        print!("{number} tol {} met {} est {:.2e} ax {a:.2e} rad {r:.2e} x{:.1} n {} fit {:.1}ms truth {:.0}ms |", d.tolerance, f.met, f.estimated_relative_error, a / f.estimated_relative_error, f.model.unknowns(), fit_s * 1e3, truth_s * 1e3);
        for (order, size) in [(5, 1.0), (7, 1.0), (6, 1.4), (9, 1.0)] {
            let t0 = std::time::Instant::now();
            let m = Axisymmetric::new(p, &MeshSpec::even(p, order, size)).unwrap();
            let s = t0.elapsed().as_secs_f64();
            let (a, r) = e(&p.sampled(&m));
            print!(" J{order}/{size} {a:.1e} {r:.1e} {:.0}ms n{} |", s * 1e3, m.unknowns());
        }
        println!(" layers {} load {:?} a {:.1e} R {:.1e} ns {}x{}", p.slab.layers.len(), p.load.kind, p.load.radius_m, p.slab.radius_m, p.sample_r_m.len(), p.sample_depth_m.len());
    }
}
