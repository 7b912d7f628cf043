//! The lattice does what its derivation says: its moduli, its rotations, its integrators, against closed forms.
//!
//! It would fail on a spring constant that is off, a share counted twice at a face between layers, an elongation that
//! cancels, a plane of symmetry that cuts a spring in the wrong half, or a bound of the stable step that is too wide.

use tissue::mass_spring::explicit::{self, ExplicitScratch};
use tissue::mass_spring::implicit::{self, ImplicitScratch};
use tissue::mass_spring::{Damping, Lattice, LatticeMotion, LatticePatch, LatticeSymmetry, MassSpring, NodalLoad};
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Problem, Slab};

pub(crate) fn layer(thickness_m: f64, youngs_modulus_pa: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio: 0.25, density_kg_per_m3: 1000.0 }
}

pub(crate) fn slab(layers: &[ElasticLayer]) -> Slab {
    Slab { layers: layers.to_vec(), radius_m: 0.05 }
}

pub(crate) fn patch(spacing_m: f64, radius_m: f64, depth_m: f64, symmetry: LatticeSymmetry) -> LatticePatch {
    LatticePatch { spacing_m, radius_m, depth_m, symmetry }
}

pub(crate) fn contactor(depth_m: f64) -> Load {
    Load { kind: LoadKind::Contactor { depth_m }, radius_m: 0.001 }
}

/// Three layers whose cells are higher, lower and as high as wide.
fn uneven() -> Slab {
    slab(&[layer(0.0024, 1e5), layer(0.0016, 3e4), layer(0.006, 2e5)])
}

/// One node that moves, in the middle of the skin.
pub(crate) struct Oscillator {
    pub(crate) lattice: Lattice,
    pub(crate) motion: LatticeMotion,
}

impl Oscillator {
    /// The node's springs resist a vertical displacement with k_z + 4 k_xz/2 = 3μh, and it weighs half a cell.
    /// With h = 10 mm, 100 N/m and 10 g follow from μ = E/2.5 = 100/(3h) and ρ = 2 · 0.01/h³.
    pub(crate) fn new(amplitude_m: f64) -> Self {
        let h = 0.01;
        let part = ElasticLayer {
            thickness_m: h,
            youngs_modulus_pa: 2.5 * 100.0 / (3.0 * h),
            poisson_ratio: 0.25,
            density_kg_per_m3: 2.0 * 0.01 / (h * h * h),
        };
        let lattice =
            Lattice::new(&slab(&[part]), &patch(h, h, h, LatticeSymmetry::Full), Damping::default()).expect("a cube");
        let mut motion = LatticeMotion::new(&lattice, NodalLoad::default());
        motion.displace(&lattice, |_| [0.0, 0.0, amplitude_m]);
        Self { lattice, motion }
    }

    fn height_m(&self) -> f64 {
        self.motion.displacement_m(&self.lattice, [0.0; 3])[2]
    }
}

const OSCILLATOR_HZ: f64 = 15.915_494_309_189_533;

#[test]
fn uniform_strain_energy_is_that_of_a_poisson_quarter_solid() {
    for (height_m, mu) in [(0.8e-3, 0.4e5), (1e-3, 0.4e5), (1.2e-3, 0.4e5)] {
        let slab = slab(&[layer(5.0 * height_m, 1e5)]);
        let patch = patch(1e-3, 4e-3, 5.0 * height_m, LatticeSymmetry::Full);
        let lattice = Lattice::new(&slab, &patch, Damping::default()).expect("near cubes");
        for strain in strains() {
            let trace: f64 = (0..3).map(|i| strain[i][i]).sum();
            let squares: f64 = strain.iter().flatten().map(|e| e * e).sum();
            let exact_j = 0.5 * (mu * trace * trace + 2.0 * mu * squares) * lattice.volume_m3();
            let response = lattice.respond(|x| times(&strain, x));
            let error = (response.linear_energy_j / exact_j - 1.0).abs();
            // Spring constants are kept in single precision.
            assert!(error < 2e-7, "{strain:?} at height {height_m}: {error}");
            let inner = response.nodes.iter().filter(|node| node.moves && node.position_m[2] < 0.0);
            let worst = inner.flat_map(|node| node.linear_force_n).fold(0.0_f64, |worst, f| worst.max(f.abs()));
            assert!(worst < 2e-6 * mu * 1e-6, "a uniform strain must be at rest: {worst} N");
        }
    }
}

/// The six unit strains, and one of all together.
fn strains() -> Vec<[[f64; 3]; 3]> {
    let mut strains = vec![[[0.3, -0.2, 0.7], [-0.2, -0.9, 0.4], [0.7, 0.4, 0.5]]];
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let mut strain = [[0.0; 3]; 3];
        (strain[i][j], strain[j][i]) = (1.0, 1.0);
        strains.push(strain);
    }
    strains
}

fn times(matrix: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

#[test]
fn a_confined_column_gives_by_the_sum_of_its_layers() {
    let slab = uneven();
    let lattice =
        Lattice::new(&slab, &patch(1e-3, 4e-3, 0.01, LatticeSymmetry::Full), Damping::default()).expect("near cubes");
    // Under the pressure p every layer is strained by −p/M with M = λ + 2μ = 1.2 E; from the base up they add up.
    let (pressure_pa, boundaries_m) = (1.0, slab.boundaries_m());
    let sinking_m = |z_m: f64| -> f64 {
        let below = slab
            .layers
            .iter()
            .zip(boundaries_m.windows(2))
            .map(|(layer, ends)| (ends[1] - ends[0].max(-z_m).min(ends[1])) / (1.2 * layer.youngs_modulus_pa));
        pressure_pa * below.sum::<f64>()
    };
    let response = lattice.respond(|[.., z_m]| [0.0, 0.0, -sinking_m(z_m)]);
    for node in response.nodes.iter().filter(|node| node.moves) {
        let pushed_n = if node.position_m[2] < 0.0 { 0.0 } else { pressure_pa * 1e-6 };
        let error_n = (node.linear_force_n[2] - pushed_n).abs();
        assert!(error_n < 1e-6 * pressure_pa * 1e-6, "at {:?}: {error_n} N", node.position_m);
    }
}

#[test]
fn a_rotation_by_a_right_angle_costs_nothing() {
    let patch = patch(1e-3, 4e-3, 0.01, LatticeSymmetry::Full);
    let lattice = Lattice::new(&uneven(), &patch, Damping::default()).expect("near cubes");
    let response = lattice.respond(|[x, y, z]| [z - x, 0.0 * y, -x - z]);
    let worst_n = response.nodes.iter().flat_map(|node| node.force_n).fold(0.0_f64, |worst, f| worst.max(f.abs()));
    // The stiffest spring is k = 0.4 E h = 80 N/m: a stretch by its own length would be 0.08 N.
    assert!(worst_n < 1e-15, "{worst_n} N");
    assert!(response.energy_j < 1e-30, "{} J", response.energy_j);
}

#[test]
fn a_quarter_moves_as_the_whole() {
    let problem = Problem { slab: uneven(), load: contactor(0.0024), sample_r_m: vec![], sample_depth_m: vec![] };
    let answers = [LatticeSymmetry::Quarter, LatticeSymmetry::Full].map(|symmetry| {
        let mut model = MassSpring::new(&problem, &patch(1e-3, 6e-3, 0.01, symmetry)).expect("near cubes");
        model.solve(0.01);
        [0.0, 0.0013, 0.003].map(|r_m| model.displacement_m(r_m, 0.003))
    });
    let scale_m = answers[1][0][0].abs();
    for (quarter, whole) in answers[0].iter().flatten().zip(answers[1].iter().flatten()) {
        assert!((quarter - whole).abs() < 1e-5 * scale_m, "{quarter} for {whole}");
    }
}

#[test]
fn spring_of_100_n_per_m_swings_10_grams_at_15_9_hertz() {
    let mut one = Oscillator::new(1e-6);
    let mut scratch = ExplicitScratch::new(&one.lattice);
    let step_s = 1e-4;
    assert!(step_s < one.lattice.stable_step_s(), "{}", one.lattice.stable_step_s());
    let (mut before_m, mut crossings_s) = (one.height_m(), Vec::new());
    for tick in 1..=20_000 {
        explicit::step(&one.lattice, &mut one.motion, &mut scratch, step_s).expect("stable");
        let now_m = one.height_m();
        if before_m < 0.0 && now_m >= 0.0 {
            crossings_s.push(step_s * (f64::from(tick) - now_m / (now_m - before_m)));
        }
        before_m = now_m;
    }
    let periods = (crossings_s.len() - 1) as f64;
    let hertz = periods / (crossings_s[crossings_s.len() - 1] - crossings_s[0]);
    // Symplectic Euler swings (ωh)²/24 = 4e-6 too fast.
    assert!((hertz / OSCILLATOR_HZ - 1.0).abs() < 1e-5, "{hertz} Hz");
}

#[test]
fn backward_euler_decays_by_its_own_law() {
    let mut one = Oscillator::new(1e-6);
    let mut scratch = ImplicitScratch::new(&one.lattice);
    let (rad_per_s, step_s) = (100.0, 1e-3);
    let amplitude_m = |one: &Oscillator| {
        let energy_j = one.lattice.elastic_energy_j(&one.motion) + one.lattice.kinetic_energy_j(&one.motion);
        (2.0 * energy_j / 100.0).sqrt()
    };
    let first_m = amplitude_m(&one);
    let steps = 628_u32;
    for _ in 0..steps {
        implicit::step(&one.lattice, &mut one.motion, &mut scratch, step_s).expect("a number");
    }
    // Each step multiplies the amplitude by (1 + (ωh)²)^(−½): after 2π/ω it is 0.7315 of what it was.
    let periods = f64::from(steps) * step_s * rad_per_s / (2.0 * std::f64::consts::PI);
    let per_period = libm::pow(amplitude_m(&one) / first_m, 1.0 / periods);
    assert!((per_period - 0.7315).abs() < 1e-4, "{per_period}");
}

#[test]
fn energy_stays_bounded_over_a_hundred_thousand_explicit_steps() {
    let slab = slab(&[layer(0.004, 1e5)]);
    let lattice =
        Lattice::new(&slab, &patch(1e-3, 3e-3, 0.004, LatticeSymmetry::Quarter), Damping::default()).expect("cubes");
    let mut motion = LatticeMotion::new(&lattice, NodalLoad::default());
    motion.displace(&lattice, |[x, y, z]| [0.02 * x * z / 0.004, 0.01 * y, 1e-4 * (z + 0.004) / 0.004]);
    let mut scratch = ExplicitScratch::new(&lattice);
    let energy_j = |motion: &LatticeMotion| lattice.elastic_energy_j(motion) + lattice.kinetic_energy_j(motion);
    let first_j = energy_j(&motion);
    let step_s = 0.2 * lattice.stable_step_s();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for _ in 0..100_000 {
        explicit::step(&lattice, &mut motion, &mut scratch, step_s).expect("stable");
        let ratio = energy_j(&motion) / first_j;
        (least, most) = (least.min(ratio), most.max(ratio));
    }
    assert!(least > 0.9 && most < 1.1, "{least} to {most} of the first energy");
}

#[test]
fn explicit_and_implicit_rest_at_the_same_place() {
    let slab = slab(&[layer(0.003, 1e5), layer(0.006, 5e4)]);
    let damping = Damping { mass_per_s: 3000.0, stiffness_s: 0.0 };
    let lattice = Lattice::new(&slab, &patch(1.5e-3, 9e-3, 9e-3, LatticeSymmetry::Quarter), damping).expect("cubes");
    let load = NodalLoad::new(&lattice, &contactor(0.0)).expect("in the lattice");
    let rest_m = |step: &dyn Fn(&mut LatticeMotion)| {
        let mut motion = LatticeMotion::new(&lattice, load.clone());
        motion.push(0.05);
        step(&mut motion);
        motion.displacement_m(&lattice, [0.0; 3])[2]
    };
    let explicit_m = rest_m(&|motion| {
        explicit::advance(&lattice, motion, &mut ExplicitScratch::new(&lattice), 0.1).expect("a short time");
    });
    let implicit_m = rest_m(&|motion| {
        let mut scratch = ImplicitScratch::new(&lattice);
        (0..3).for_each(|_| implicit::step(&lattice, motion, &mut scratch, f64::INFINITY).expect("a number"));
    });
    assert!(implicit_m < -1e-4, "{implicit_m} m");
    assert!((explicit_m / implicit_m - 1.0).abs() < 1e-4, "{explicit_m} m and {implicit_m} m");
}
