//! The volumetric model in time and at large loads: integrators by their closed form, recoil by its similarity, and what
//! is said when no equilibrium is found. It could fail on a mass that is counted twice, a step that is not backward
//! Euler's, or an answer that is given for a load that it is not for.

use nalgebra::Vector3;
use tissue::FieldModel;
use tissue::volumetric::{Body, Corotational, Effort, HexMesh, Material, Patch, Problem3, Symmetry, TissueMotion};

use crate::volumetric_reference::{Reference, graded};

/// One mass of 10 g on a spring of 100 N/m: an element of which one node may move, along one direction.
fn oscillator() -> Body {
    let one = |youngs_modulus_pa: f64, density_kg_per_m3: f64| {
        let mesh = HexMesh::cuboid(2, [0.01; 3], [1, 1, 1]);
        let middle: Vec<bool> =
            mesh.nodes_m.iter().map(|node| (node.coords - Vector3::repeat(0.005)).norm() < 1e-9).collect();
        let material = Material { youngs_modulus_pa, poisson_ratio: 0.0, density_kg_per_m3 };
        Body::new(mesh, |_, _| material, |node| [true, true, !middle[node]]).expect("a body")
    };
    let unit = one(1.0, 1.0);
    let stiffness = 2.0 * unit.linear_energy_j(&[1.0], &mut [0.0]);
    one(100.0 / stiffness, 0.01 / unit.mass_kg()[0])
}

/// Displacements of the oscillator let go at 1 µm, a length in s after another.
fn swing(step_s: f64, steps: usize) -> Vec<f64> {
    let body = oscillator();
    assert_eq!(body.unknowns(), 1);
    let mut motion = TissueMotion::new(&body, Some(step_s), Effort { iterations: 50, tolerance: 1e-12 }).expect("held");
    motion.displace(&[1e-6]);
    let swing = (0..steps).map(|_| {
        motion.step(&body, &[0.0]);
        motion.u_m()[0]
    });
    swing.collect()
}

#[test]
fn ten_grams_on_100_newtons_a_metre_swing_at_15_915_hertz() {
    let step_s = 1e-5;
    let u = swing(step_s, 20_000);
    let up: Vec<f64> = (1..u.len())
        .filter(|&at| u[at - 1] < 0.0 && u[at] >= 0.0)
        .map(|at| step_s * (at as f64 - u[at] / (u[at] - u[at - 1])))
        .collect();
    let hertz = (up.len() - 1) as f64 / (up[up.len() - 1] - up[0]);
    assert!(up.len() > 2 && (hertz - 15.915).abs() < 0.002, "{hertz} Hz");
}

#[test]
fn backward_euler_decays_to_0_7315_per_turn_in_tenth_steps() {
    // u of a step is 1/(1 ± 0.1 i) of that before: its size falls by 1/√1.01, and it turns by atan 0.1.
    let u = swing(1e-3, 63);
    let angle = libm::atan(0.1);
    for (at, &found) in u.iter().enumerate() {
        let steps = at as f64 + 1.0;
        let wanted = 1e-6 * libm::pow(1.01, -0.5 * steps) * libm::cos(angle * steps);
        assert!((found - wanted).abs() < 1e-7 * 1e-6, "step {steps}: {found} m, where {wanted} m was wanted");
    }
    let turn = libm::pow(1.01, -0.5 * std::f64::consts::TAU / 0.1);
    assert!((turn - 0.7315).abs() < 5e-5, "{turn}");
}

/// Time, in s, in which the skin comes half back when 10 mN are let go.
fn recoil_s(density_kg_per_m3: f64) -> f64 {
    let mut problem = Reference::lower_back().problem;
    problem.slab.layers.iter_mut().for_each(|layer| layer.density_kg_per_m3 = density_kg_per_m3);
    let spec = graded(Symmetry::Quarter, 2, [[1.5, 1.5], [0.8, 2.0]]);
    let patch = Patch::new(&Problem3::flat(&problem), &spec).expect("a patch");
    let effort = Effort { iterations: 30, tolerance: 1e-6 };
    let mut still = Corotational::new(patch.clone(), None, effort).expect("held");
    still.solve(0.01);
    let step_s = 2e-5;
    let mut tissue = Corotational::new(patch, Some(step_s), effort).expect("held");
    tissue.motion_mut().displace(still.motion().u_m());
    let sink = |tissue: &Corotational| tissue.displacement_m(0.0, 0.0)[0];
    let half = 0.5 * sink(&tissue);
    let mut before = sink(&tissue);
    for at in 0..2000 {
        tissue.solve(0.0);
        let now = sink(&tissue);
        if now > half {
            return step_s * (f64::from(at) + (half - before) / (now - before));
        }
        before = now;
    }
    panic!("no recoil");
}

#[test]
fn recoil_takes_twice_as_long_at_four_times_the_density() {
    let (light, heavy) = (recoil_s(1000.0), recoil_s(4000.0));
    assert!((heavy / light - 2.0).abs() < 0.04, "{light} s and {heavy} s");
}

#[test]
fn overload_is_rejected_with_the_nearest_load_in_equilibrium() {
    let problem = Problem3::flat(&Reference::lower_back().problem);
    let patch = Patch::new(&problem, &graded(Symmetry::Quarter, 2, [[1.5, 1.5], [0.8, 2.0]])).expect("a patch");
    let mut tissue = Corotational::new(patch, None, Effort { iterations: 12, tolerance: 1e-3 }).expect("held");
    tissue.solve(20.0);
    let refused = tissue.check().expect_err("20 N crush the tissue under a needle of 1 mm");
    assert!(refused.held_n > 0.05 && refused.held_n < 20.0, "{refused}");
    let words = refused.to_string();
    assert!(words.starts_with("force_n = 20 N: no equilibrium was found"), "{words}");
    let held = tissue.motion().u_m().to_vec();
    tissue.solve(refused.held_n);
    assert!(tissue.check().is_ok() && tissue.motion().u_m() == held, "what is said to be held is");
    tissue.solve(0.0);
    let left_j = tissue.energies().elastic_j;
    assert!(tissue.check().is_ok() && left_j < 1e-8, "{left_j} J are left when it is let go");
}
