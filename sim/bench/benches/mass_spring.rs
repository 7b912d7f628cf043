//! Duration of a step of the lattice. The target of the explicit step is 50 million unknowns per
//! second on one core.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tissue::mass_spring::explicit::{self, ExplicitScratch};
use tissue::mass_spring::implicit::{self, ImplicitScratch};
use tissue::mass_spring::{Damping, Lattice, LatticeMotion, LatticePatch, LatticeSymmetry, MassSpring, NodalLoad};
use tissue::{ElasticLayer, Load, LoadKind, Problem, Slab};

/// The lower back of physics section 2, 12 mm around a needle on its skin.
fn lower_back() -> Problem {
    let layer = |(thickness_m, youngs_modulus_pa)| ElasticLayer {
        thickness_m,
        youngs_modulus_pa,
        poisson_ratio: 0.45,
        density_kg_per_m3: 1050.0,
    };
    Problem {
        slab: Slab { layers: [(0.8e-3, 132e3), (8.4e-3, 33.1e3), (39e-3, 198e3)].map(layer).to_vec(), radius_m: 0.05 },
        load: Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: 1e-3 },
        sample_r_m: vec![0.0],
        sample_depth_m: vec![0.0],
    }
}

fn patch(spacing_m: f64) -> LatticePatch {
    LatticePatch { spacing_m, radius_m: 0.012, depth_m: 0.012, symmetry: LatticeSymmetry::Quarter }
}

fn lattice(criterion: &mut Criterion) {
    let problem = lower_back();
    for spacing_m in [1.1e-3, 0.56e-3, 0.28e-3] {
        let Ok(lattice) = Lattice::new(&problem.slab, &patch(spacing_m), Damping::default()) else { continue };
        let Ok(load) = NodalLoad::new(&lattice, &problem.load) else { continue };
        let mut motion = LatticeMotion::new(&lattice, load);
        motion.push(0.05);
        let unknowns = lattice.unknowns();
        let mut group = criterion.benchmark_group("lattice");
        group.throughput(Throughput::Elements(unknowns as u64));
        let mut scratch = ExplicitScratch::new(&lattice);
        let step_s = lattice.stable_step_s();
        group.bench_function(format!("explicit step, {unknowns} unknowns"), |bencher| {
            bencher.iter(|| explicit::step(&lattice, &mut motion, &mut scratch, step_s));
        });
        if unknowns < 10_000 {
            let mut scratch = ImplicitScratch::new(&lattice);
            group.bench_function(format!("implicit step of 1/120 s, {unknowns} unknowns"), |bencher| {
                bencher.iter(|| implicit::step(&lattice, &mut motion, &mut scratch, 1.0 / 120.0));
            });
        }
        if unknowns < 100_000 {
            group.bench_function(format!("to rest, {unknowns} unknowns"), |bencher| {
                bencher.iter(|| MassSpring::new(&problem, &patch(spacing_m)));
            });
        }
    }
}

criterion_group!(benches, lattice);
criterion_main!(benches);
