//! The volumetric model takes what is sound: any grid of the ladder and beside it, on any layers, at any angle that meets its load
//! within the patch, makes numbers. It would fail where a node that rounds past the radius, or a disc of a block and one ring,
//! makes a NaN of the mesh.

use proptest::prelude::*;
use tissue::volumetric::{Grading, MeshSpec3, Problem3, Volumetric, VolumetricError};
use tissue::{ElasticLayer, FieldModel, LoadKind};
use trials::slabs::{ask_contactor, make_elastic_layer};

fn log(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (libm::log(low)..libm::log(high)).prop_map(libm::exp)
}

fn any_layers() -> impl Strategy<Value = Vec<ElasticLayer>> {
    let any_layer = (log(3e-4, 0.03), log(3e3, 3e6), 0.0..=0.49).prop_map(|(d, e, nu)| make_elastic_layer(d, e, nu));
    prop::collection::vec(any_layer, 1..=4)
}

/// A mesh for loads of a radius of 1 mm, of the least part of the problem.
fn spec(problem: &Problem3, (order, around): (usize, usize), sizes: [f64; 4], reach_m: f64) -> MeshSpec3 {
    let [near, growth, near_along, growth_along] = sizes;
    let grading = |near: f64, growth: f64| Grading { near_m: 1e-3 * near, growth };
    let (across, along) = (grading(near, growth), grading(near_along, growth_along));
    MeshSpec3 { symmetry: problem.symmetry(), order, around, across, along, reach_m }
}

/// What a problem comes to on a mesh: the displacement along the needle where its load begins, in m/N.
fn give_m(problem: &Problem3, spec: &MeshSpec3) -> Result<f64, VolumetricError> {
    let mut model = Volumetric::new(problem, spec)?;
    model.solve(1.0);
    Ok(problem.along_needle_m(&model, 0.0, problem.flat.load.ends_m()[0]))
}

#[test]
fn every_plain_grid_of_few_rings_makes_numbers() {
    for layers in [
        vec![make_elastic_layer(0.03, 2e4, 0.45)],
        vec![make_elastic_layer(0.002, 1e5, 0.45), make_elastic_layer(0.03, 2e4, 0.45)],
    ] {
        for radius_m in [0.005, 0.01, 0.02, 0.0333, 0.05, 0.07] {
            let mut problem = Problem3::flat(&ask_contactor(layers.clone(), 0.0));
            problem.flat.slab.radius_m = radius_m;
            problem.flat.sample_r_m.retain(|&r_m| r_m < radius_m);
            for (near, growth) in [(3.0, 1.0), (1.5, 1.5), (2.0, 3.0), (radius_m * 600.0, 0.1)] {
                let spec = spec(&problem, (2, 1), [near, growth, 1.0, 2.0], 1.0);
                let give_m = give_m(&problem, &spec).expect("a plain grid");
                assert!(give_m > 0.0 && give_m.is_finite(), "{give_m} m at {radius_m}, {near}, {growth}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_layered_grid_solves_or_rejects_the_tilt_angle(
        layers in any_layers(),
        (at, drag) in (0.0..1.0, any::<bool>()),
        tilt_deg in prop_oneof![Just(0.0), -60.0..60.0],
        wide in log(6.0, 200.0),
        shape in (2_usize..=3, 1_usize..=2),
        sizes in [log(0.8, 20.0), log(0.5, 3.0), log(0.8, 20.0), log(0.8, 3.0)],
    ) {
        let mut problem = Problem3 { tilt_rad: f64::to_radians(tilt_deg), ..Problem3::flat(&ask_contactor(layers, 0.0)) };
        problem.flat.slab.radius_m = 1e-3 * wide;
        let boundaries_m = problem.flat.slab.boundaries_m();
        let depth_m = boundaries_m[(at * (boundaries_m.len() - 1) as f64) as usize];
        problem.flat.load.kind = match drag {
            true => LoadKind::Drag { from_m: 0.0, to_m: boundaries_m[1] },
            false => LoadKind::Contactor { depth_m },
        };
        problem.flat.sample_r_m = vec![0.0];
        let spec = spec(&problem, shape, sizes, 0.1);
        match give_m(&problem, &spec) {
            Ok(give_m) => prop_assert!(give_m > 0.0 && give_m.is_finite(), "{give_m} m"),
            // A needle that leans out of the patch has no mesh.
            Err(VolumetricError::Param(why)) => prop_assert_eq!(why.field, "tilt_rad"),
            Err(why) => prop_assert!(false, "{}", why),
        }
    }
}
