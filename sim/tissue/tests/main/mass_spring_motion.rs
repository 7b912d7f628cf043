//! How a lattice moves: it recoils in a time that goes with the square root of density, opens where a needle went, and
//! its steps never touch the heap.
//!
//! It would fail on a mass that is lumped wrongly, on springs that still pull across a hole or whose energy is lost
//! track of, and on a step that makes a vector.

use allocation_counter::measure;
use tissue::mass_spring::explicit::{self, ExplicitScratch};
use tissue::mass_spring::implicit::{self, ImplicitScratch};
use tissue::mass_spring::{
    Damping, Lattice, LatticeError, LatticeMotion, LatticePuncture, LatticeSymmetry, MassSpring, NodalLoad,
};
use tissue::{FieldModel, Problem, Slab};

use crate::mass_spring::{contactor, layer, patch, slab};

/// Skin on fat, as a lattice of 1 mm cells that is pushed by 0.05 N and rests.
fn pushed(slab: &Slab, symmetry: LatticeSymmetry) -> (Lattice, LatticeMotion) {
    let lattice = Lattice::new(slab, &patch(1e-3, 6e-3, 6e-3, symmetry), Damping::default()).expect("near cubes");
    let mut motion = LatticeMotion::new(&lattice, NodalLoad::new(&lattice, &contactor(0.0)).expect("a load"));
    motion.push(0.05);
    let mut scratch = ImplicitScratch::new(&lattice);
    (0..3).for_each(|_| implicit::step(&lattice, &mut motion, &mut scratch, f64::INFINITY).expect("a number"));
    (lattice, motion)
}

fn skin_on_fat(density_kg_per_m3: f64) -> Slab {
    let mut slab = slab(&[layer(0.001, 1e5), layer(0.005, 3e4)]);
    slab.layers.iter_mut().for_each(|layer| layer.density_kg_per_m3 = density_kg_per_m3);
    slab
}

/// How long after it is let go the skin is first where it is without a force, in s.
fn recoil_s(density_kg_per_m3: f64) -> f64 {
    let (lattice, mut motion) = pushed(&skin_on_fat(density_kg_per_m3), LatticeSymmetry::Quarter);
    motion.push(0.0);
    let mut scratch = ExplicitScratch::new(&lattice);
    let (tick_s, mut before_m) = (2e-6, f64::NEG_INFINITY);
    for tick in 1..=10_000 {
        explicit::advance(&lattice, &mut motion, &mut scratch, tick_s).expect("a short time");
        let now_m = motion.displacement_m(&lattice, [0.0; 3])[2];
        if now_m >= 0.0 {
            return tick_s * (f64::from(tick) - now_m / (now_m - before_m));
        }
        before_m = now_m;
    }
    f64::NAN
}

#[test]
fn recoil_time_grows_with_the_square_root_of_density() {
    let [light_s, dense_s, densest_s] = [950.0, 4.0 * 950.0, 9.0 * 950.0].map(recoil_s);
    assert!((1e-4..1e-2).contains(&light_s), "{light_s} s");
    for (heavier_s, ratio) in [(dense_s, 2.0), (densest_s, 3.0)] {
        assert!((heavier_s / light_s / ratio - 1.0).abs() < 0.01, "{heavier_s} s for {ratio} × {light_s} s");
    }
}

#[test]
fn punctured_springs_open_and_the_skin_around_them_recoils() {
    let (mut lattice, mut motion) = pushed(&skin_on_fat(1000.0), LatticeSymmetry::Full);
    let beside_m = |motion: &LatticeMotion, lattice: &Lattice| motion.displacement_m(lattice, [1e-3, 0.0, 0.0])[2];
    let (held_j, held_m) = (lattice.elastic_energy_j(&motion), beside_m(&motion, &lattice));
    let hole = LatticePuncture { at_m: [0.0; 2], depth_m: 0.0, radius_m: 0.4e-3 };
    let opened = lattice.open(&motion, &hole);
    // Four edges and four diagonals in the skin, one edge and four diagonals below it.
    assert_eq!(opened.springs, 13);
    let left_j = lattice.elastic_energy_j(&motion);
    assert!(opened.energy_j > 0.1 * held_j, "{} J of {held_j} J", opened.energy_j);
    assert!((held_j - opened.energy_j - left_j).abs() < 1e-9 * held_j, "{held_j} J, {left_j} J");
    let mut scratch = ImplicitScratch::new(&lattice);
    (0..3).for_each(|_| implicit::step(&lattice, &mut motion, &mut scratch, f64::INFINITY).expect("a number"));
    assert!(beside_m(&motion, &lattice) > 0.9 * held_m, "{} m of {held_m} m", beside_m(&motion, &lattice));
    assert!(lattice.elastic_energy_j(&motion) < left_j);
    assert_eq!(lattice.open(&motion, &hole).springs, 0);
}

#[test]
fn a_step_too_long_is_refused_with_the_stable_one_named() {
    let (lattice, mut motion) = pushed(&skin_on_fat(1000.0), LatticeSymmetry::Quarter);
    let (before, mut scratch) = (motion.clone(), ExplicitScratch::new(&lattice));
    let stable_s = lattice.stable_step_s();
    for step_s in [4.0 * stable_s, stable_s.next_up(), -stable_s, f64::NAN, f64::INFINITY] {
        let refusal = explicit::step(&lattice, &mut motion, &mut scratch, step_s);
        assert!(
            matches!(refusal, Err(LatticeError::Step { stable_s: named, .. }) if named.to_bits() == stable_s.to_bits()),
            "{refusal:?}"
        );
        assert_eq!(motion, before);
    }
    explicit::step(&lattice, &mut motion, &mut scratch, stable_s).expect("the stable step itself");
}

#[test]
fn no_step_and_no_answer_allocates() {
    let (lattice, mut motion) = pushed(&skin_on_fat(1000.0), LatticeSymmetry::Quarter);
    let (mut explicit, mut implicit) = (ExplicitScratch::new(&lattice), ImplicitScratch::new(&lattice));
    let problem =
        Problem { slab: skin_on_fat(1000.0), load: contactor(0.0), sample_r_m: vec![0.0], sample_depth_m: vec![0.0] };
    let mut model = MassSpring::new(&problem, &patch(1e-3, 6e-3, 6e-3, LatticeSymmetry::Quarter)).expect("a lattice");
    let counted = measure(|| {
        for tick in 0..20 {
            motion.push(0.01 * f64::from(tick));
            explicit::advance(&lattice, &mut motion, &mut explicit, 1e-3).expect("a short time");
            implicit::step(&lattice, &mut motion, &mut implicit, 1e-3).expect("a number");
            model.solve(0.01 * f64::from(tick));
            assert!(model.displacement_m(1e-3, 1e-3)[0].is_finite());
        }
    });
    assert_eq!(counted.count_total, 0);
}
