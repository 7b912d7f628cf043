//! The volumetric model in the hard cases that concern it.
//!
//! The trials detect locking elements, a factorisation that loses digits, a minimisation that goes
//! uphill, a step that adds energy, and a load that is accepted although it cannot be balanced.

mod motion;
mod statics;

use motion::{
    hold_moving, inverted_growth, inverted_left, rate_growth, rate_left, release_growth, release_left, stab_growth,
    teleport_growth, teleport_refused,
};
use statics::{
    bad_forces, duplicate_change, hold_still, incompressible_error, oblique_error, ratio_error, sliver_energy,
    thin_skin_error, zero_thickness_change,
};
use tissue::volumetric::{Body, HexMesh, Material, MeshSpec3, Problem3, VolumetricError};
use tissue::{ElasticLayer, Load, LoadKind, Problem, Slab};

use super::case;

super::trials! { "volumetric":
    ratio_error, case::RATIOS, "largest error of a fit to 10 %, against the axisymmetric model", <= 0.1 "";
    thin_skin_error, case::THIN_SKIN, "error of a fit to 5 %, against the axisymmetric model", <= 0.05 "";
    incompressible_error, case::INCOMPRESSIBLE, "error of a fit to 5 %, against the axisymmetric model", <= 0.05 "";
    sliver_energy, case::SLIVERS, "error of the energy of a uniform strain in elements of 1 : 100", <= 1e-10 "";
    inverted_left, case::SLIVERS, "share of its energy that an inverted block keeps when it is let go", <= 1e-6 "";
    inverted_growth, case::SLIVERS, "largest growth of its energy in a step on the way", <= 1e-12 "";
    stab_growth, case::STAB, "largest growth in a step of the energy less the load's work, of the most", <= 1e-12 "";
    teleport_growth, case::TELEPORT, "largest growth in a step of the energy less the load's work, of the most", <= 1e-12 "";
    teleport_refused, case::TELEPORT, "whether 20 N in one step is neither held nor refused with what is", <= 0.0 "";
    bad_forces, case::BAD_SAMPLES, "forces without an answer that changed anything", <= 0.0 "";
    release_growth, case::RELEASED, "largest growth of the energy in a step, of the most", <= 1e-12 "";
    release_left, case::RELEASED, "share of the energy left after 0.2 s", <= 1e-3 "";
    hold_still, case::HOLD, "change of the displacement in equilibrium, step after step at 5 Hz", <= 0.0 "m";
    hold_moving, case::HOLD, "the same, steps in time once it has come to rest", <= 0.0 "m";
    oblique_error, case::OBLIQUE, "estimated error of a fit to 5 %", <= 0.05 "";
    zero_thickness_change, case::COINCIDENT, "change by three sheets without thickness", <= 0.0 "m";
    duplicate_change, case::COINCIDENT, "change by every layer made of two, of the largest displacement", <= 0.02 "";
    rate_growth, case::FIELD_RATE, "largest growth in a step of the energy less the load's work, of the most", <= 1e-12 "";
    rate_left, case::FIELD_RATE, "distance to equilibrium 1 s after the load has come to rest, of its size", <= 1e-3 "";
}

/// Creates a layer from its thickness in m, modulus in Pa and Poisson ratio.
fn layer(thickness_m: f64, youngs_modulus_pa: f64, poisson_ratio: f64) -> ElasticLayer {
    ElasticLayer { thickness_m, youngs_modulus_pa, poisson_ratio, density_kg_per_m3: 1000.0 }
}

/// Skin, fat and muscle of the paper.
fn lower_back() -> Vec<ElasticLayer> {
    vec![layer(0.0008, 132e3, 0.45), layer(0.0084, 33.1e3, 0.45), layer(0.039, 198e3, 0.45)]
}

/// Layers under a needle of 1 mm at their surface, sampled there and at 3 mm.
fn problem(layers: Vec<ElasticLayer>) -> Problem {
    Problem {
        slab: Slab { layers, radius_m: 0.05 },
        load: Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: 1e-3 },
        sample_r_m: (0..20).map(|at| 5e-4 * f64::from(at)).collect(),
        sample_depth_m: vec![0.0, 0.003],
    }
}

/// Returns the coarsest mesh of a problem: hard cases are no harder on a fine one.
fn coarse(problem: &Problem3) -> MeshSpec3 {
    MeshSpec3::ladder(problem)[0]
}

/// A block of eight distorted elements, optionally fixed at its base.
fn block(size_m: [f64; 3], held: bool) -> Result<Body, VolumetricError> {
    let material = Material { youngs_modulus_pa: 1e5, poisson_ratio: 0.45, density_kg_per_m3: 1000.0 };
    let mut mesh = HexMesh::cuboid(2, size_m, [2, 2, 2]);
    for node in &mut mesh.nodes_m {
        let bump = |axis: usize| node[axis] * (size_m[axis] - node[axis]) / (size_m[axis] * size_m[axis]);
        let share = 64.0 * bump(0) * bump(1) * bump(2);
        for (axis, way) in [0.06, -0.05, 0.08].into_iter().enumerate() {
            node[axis] += way * size_m[axis] * share;
        }
    }
    let base: Vec<bool> = mesh.nodes_m.iter().map(|node| held && node.z <= 0.0).collect();
    Body::new(mesh, |_, _| material, |node| [base[node]; 3])
}
