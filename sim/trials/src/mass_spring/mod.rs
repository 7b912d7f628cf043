//! The mass-spring lattice in the hard cases that concern it.
//!
//! The trials detect a lattice that is stepped beyond its stability limit, gains energy when
//! inverted, creeps under a constant force, trusts an invalid sample, or hides its accuracy limit.

mod motion;
mod moved;
mod statics;

use motion::{
    bad_samples, hold_creep, inverted_energy, inverted_rest, long_step_refused, no_time, rates_displacement,
    release_explicit, release_growth, release_implicit, release_rest, slow_tissue_energy, slow_tissue_rest,
    stab_energy, teleport_explicit, teleport_implicit,
};
use statics::{
    coincident_answer, contrast_error, incompressible_estimate, incompressible_met, sliver_refused, thin_skin_error,
    thin_skin_refused,
};
use tissue::mass_spring::{LatticePatch, LatticeSymmetry};
use tissue::{ElasticLayer, Load, LoadKind, Problem, Slab};

use super::case;
use super::slabs::make_elastic_layer;

super::trials! { "mass-spring":
    contrast_error, case::RATIOS, "largest distance from elements of ν = 1/4; bound: that of cells of half a footprint", <= 0.1 "";
    thin_skin_refused, case::THIN_SKIN, "a spacing that no skin can have, accepted, or refused without the nearest", <= 0.0 "";
    thin_skin_error, case::THIN_SKIN, "distance from elements of ν = 1/4; bound: that of two cells across the skin", <= 0.05 "";
    incompressible_estimate, case::INCOMPRESSIBLE, "error over the estimate, which has the floor of ν = 1/4", <= 1.0 "";
    incompressible_met, case::INCOMPRESSIBLE, "tolerances below the floor that are said to be met", <= 0.0 "";
    sliver_refused, case::SLIVERS, "layers too thin for their cells, accepted", <= 0.0 "";
    inverted_energy, case::SLIVERS, "most energy of explicit steps from inverted cells over that at the start; bound: the integrator's ½ ω h", <= 1.2 "";
    inverted_rest, case::SLIVERS, "displacement left at rest over that at the start, by implicit steps", <= 1e-6 "";
    long_step_refused, case::LONG_STEP, "steps taken, not named, or that moved something", <= 0.0 "";
    stab_energy, case::STAB, "most energy over the most work done, by explicit steps; bound: ½ ω h", <= 1.2 "";
    teleport_explicit, case::TELEPORT, "most energy over the most work done, by explicit steps; bound: ½ ω h", <= 1.2 "";
    teleport_implicit, case::TELEPORT, "most energy over the most work done, by implicit steps", <= 1.000001 "";
    bad_samples, case::BAD_SAMPLES, "bad forces and times that changed anything", <= 0.0 "";
    no_time, case::NO_TIME, "steps of no time that changed anything", <= 0.0 "";
    release_explicit, case::RELEASED, "most energy over what was stored, by explicit steps; bound: ½ ω h", <= 1.2 "";
    release_growth, case::RELEASED, "most energy of the second half over the first, by explicit steps", <= 1.02 "";
    release_implicit, case::RELEASED, "most energy over what was stored, by implicit steps", <= 1.000001 "";
    release_rest, case::RELEASED, "displacement left after 0.2 s, over that held", <= 1e-3 "";
    hold_creep, case::HOLD, "change of the displacement after ten seconds, relative", <= 1e-9 "";
    coincident_answer, case::COINCIDENT, "change of the answer by sheets and by halving a layer, relative", <= 1e-9 "";
    slow_tissue_energy, case::FIELD_RATE, "most energy over the most work done", <= 1.000001 "";
    slow_tissue_rest, case::FIELD_RATE, "distance from rest after the ramp, relative", <= 1e-3 "";
    rates_displacement, case::RATES, "largest difference of the displacement, relative; bound: a tick of the ramp", <= 0.02 "";
}

/// Half the width of the moving lattices, in m: 8 footprints.
const RADIUS_M: f64 = 0.008;

/// A problem with layers 16 footprints wide, sampled on the skin and below it.
fn problem(layers: Vec<ElasticLayer>) -> Problem {
    Problem {
        slab: Slab { layers, radius_m: RADIUS_M },
        load: Load { kind: LoadKind::Contactor { depth_m: 0.0 }, radius_m: 1e-3 },
        sample_r_m: (0..8).map(|step| f64::from(step) * 0.5e-3).collect(),
        sample_depth_m: vec![0.0, 1e-3],
    }
}

/// The lower back of physics section 2.
fn lower_back() -> Vec<ElasticLayer> {
    vec![
        make_elastic_layer(0.8e-3, 132e3, 0.45),
        make_elastic_layer(8.4e-3, 33.1e3, 0.45),
        make_elastic_layer(39e-3, 198e3, 0.45),
    ]
}

fn patch(spacing_m: f64, depth_m: f64) -> LatticePatch {
    LatticePatch { spacing_m, radius_m: RADIUS_M, depth_m, symmetry: LatticeSymmetry::Quarter }
}
