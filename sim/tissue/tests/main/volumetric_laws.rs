//! What only the volumetric model can be asked, by law: tilted needles, curved skins, inclusions. It could fail on a
//! load that leans the wrong way, a plane of symmetry that is none, a map of a bent element, or a material that is
//! looked up in the wrong place.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use tissue::volumetric::{
    Body, Inclusion, InclusionShape, Material, MeshSpec3, Patch, Problem3, Skin, Symmetry, Volumetric, fit,
};
use tissue::{FieldModel, LoadKind};

use crate::volumetric::SOFT;
use crate::volumetric_reference::{COARSE, Reference, graded};

const PLACES: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [0.002, 0.001, 0.0], [-0.004, 0.003, -0.002], [0.005, -0.002, -0.009], [0.0, 0.006, -0.02]];

fn flat() -> Problem3 {
    Problem3::flat(&Reference::lower_back().problem)
}

fn solved(problem: &Problem3, symmetry: Symmetry) -> Volumetric {
    let mut model = Volumetric::new(problem, &graded(symmetry, 2, COARSE)).expect("a model");
    model.solve(1.0);
    model
}

/// Largest difference of two answers at the places, of the first's at the origin.
fn difference(a: &Volumetric, b: &Volumetric) -> f64 {
    let size = a.displacement_at(&Point3::origin()).norm();
    let apart = PLACES.map(|place| (a.displacement_at(&place.into()) - b.displacement_at(&place.into())).norm());
    apart.into_iter().fold(0.0, f64::max) / size
}

#[test]
fn leaning_the_other_way_mirrors_the_answer() {
    let mut problem = flat();
    problem.flat.load.kind = LoadKind::Contactor { depth_m: 0.0092 };
    let [one, other] = [0.7, -0.7].map(|tilt_rad| solved(&Problem3 { tilt_rad, ..problem.clone() }, Symmetry::Half));
    let mirror = Vector3::new(-1.0, 1.0, 1.0);
    for place in PLACES.map(Point3::from) {
        let here = one.displacement_at(&place);
        let there = other.displacement_at(&place.coords.component_mul(&mirror).into()).component_mul(&mirror);
        assert!((here - there).norm() < 1e-9 * here.norm(), "{here} against {there}");
    }
    let sideways = one.displacement_at(&Point3::new(0.0092 * libm::tan(0.7), 0.0, -0.0092)).x;
    assert!(sideways > 0.0, "the needle leans towards +x and must push there: {sideways}");
}

#[test]
fn betti_reciprocity_holds_between_two_loads() {
    let [one, other] = [0.9, -0.4].map(|tilt_rad| solved(&Problem3 { tilt_rad, ..flat() }, Symmetry::Half));
    let work = |load: &Volumetric, way: &Volumetric| -> f64 {
        load.patch().load().iter().zip(way.unknowns_m()).map(|(load, u)| load * u).sum()
    };
    let (there, back) = (work(&one, &other), work(&other, &one));
    assert!((there - back).abs() < 1e-10 * there.abs(), "Betti: {there} against {back}");
}

#[test]
fn a_needle_that_hardly_leans_is_a_perpendicular_one() {
    let mut problem = flat();
    problem.flat.load.kind = LoadKind::Contactor { depth_m: 0.0092 };
    let upright = solved(&problem, Symmetry::Quarter);
    let leaning =
        |tilt_rad: f64| difference(&upright, &solved(&Problem3 { tilt_rad, ..problem.clone() }, Symmetry::Half));
    let (little, more) = (leaning(1e-5), leaning(1e-4));
    assert!(little < 1e-3, "{little}");
    assert!((more / little - 10.0).abs() < 0.1, "the change must be in proportion to the angle: {little}, {more}");
}

#[test]
fn an_oblique_answer_is_within_its_tolerance_of_a_finer_one() {
    let problem = Problem3 { tilt_rad: 0.8, ..flat() };
    let fitted = fit(&problem, 0.05).expect("a fit");
    let mut finer = Volumetric::new(&problem, &MeshSpec3::ladder(&problem)[5]).expect("a model");
    finer.solve(1.0);
    let (sine, cosine) = (libm::sin(0.8), libm::cos(0.8));
    let across = |x: f64, y: f64| Vector3::new(x * cosine, y, x * sine);
    let [mut wrong, mut whole] = [[0.0; 2]; 2];
    for &r in &problem.flat.sample_r_m {
        for [x, y] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]] {
            let point = Point3::new(r * x, r * y, 0.0);
            for (part, way) in [Vector3::new(sine, 0.0, -cosine), across(x, y)].into_iter().enumerate() {
                let better = finer.displacement_at(&point).dot(&way);
                let apart = fitted.model.displacement_at(&point).dot(&way) - better;
                wrong[part] += apart * apart;
                whole[part] += better * better;
            }
        }
    }
    let found = libm::sqrt(f64::max(wrong[0] / whole[0], wrong[1] / whole[1]));
    let ratio = fitted.estimated_relative_error / found;
    assert!(fitted.met && found < 0.05 && (0.33..3.0).contains(&ratio), "{found}, the estimate times {ratio}");
}

#[test]
fn a_skin_of_large_radius_is_flat() {
    let upright = solved(&flat(), Symmetry::Quarter);
    for skin in [|radius_m| Skin::Sphere { radius_m }, Skin::cylinder_along_y] {
        let bent =
            |radius_m| difference(&upright, &solved(&Problem3 { skin: skin(radius_m), ..flat() }, Symmetry::Quarter));
        let (far, near) = (bent(1e4), bent(1e3));
        assert!(far < 1e-5 && (near / far - 10.0).abs() < 0.5, "the change must be as the curvature: {far}, {near}");
    }
}

#[test]
fn bent_elements_ignore_rotation_and_store_uniform_strain() {
    let problem = Problem3 { tilt_rad: 0.5, skin: Skin::Sphere { radius_m: 0.08 }, ..flat() };
    let patch = Patch::new(&problem, &graded(Symmetry::Half, 3, [[1.5, 1.5], [1.5, 1.5]])).expect("a patch");
    let body = Body::new(patch.body().mesh().clone(), |_, _| SOFT, |_| [false; 3]).expect("a body");
    let gradient = Matrix3::new(1e-3, 2e-3, -1e-3, 5e-4, -2e-3, 1e-3, 3e-3, -1e-3, 2e-3);
    let mut force = vec![0.0; body.unknowns()];
    let stored_j = body.linear_energy_j(&body.interpolate_m(|point| gradient * point.coords), &mut force);
    let strain = (gradient + gradient.transpose()) * 0.5;
    let (lambda, mu) = SOFT.lame_pa();
    let volume_m3 = body.mass_kg().iter().sum::<f64>() / 3.0 / SOFT.density_kg_per_m3;
    let wanted_j = volume_m3 * (mu * strain.norm_squared() + 0.5 * lambda * strain.trace() * strain.trace());
    assert!((stored_j / wanted_j - 1.0).abs() < 1e-11, "{stored_j} J, where {wanted_j} J was wanted");
    let turn = Rotation3::from_scaled_axis(Vector3::new(1.0, -2.0, 0.5).normalize() * std::f64::consts::FRAC_PI_2);
    let turned = body.interpolate_m(|point| turn * point.coords - point.coords);
    let turning_j = body.energy_j(&turned, &mut vec![0.0; body.unknowns()]);
    assert!(turning_j < 1e-20 * body.linear_energy_j(&turned, &mut force), "{turning_j} J");
}

fn ball(material: Material) -> Inclusion {
    let shape = InclusionShape::Sphere { centre_m: Point3::new(0.001, 0.0, -0.006), radius_m: 0.003 };
    Inclusion { shape, material }
}

#[test]
fn an_inclusion_of_the_layers_own_material_changes_nothing() {
    let fat = Material::from(&flat().flat.slab.layers[1]);
    let with = Problem3 { inclusions: vec![ball(fat)], ..flat() };
    let [with, without] = [with, flat()].map(|problem| solved(&problem, Symmetry::Half));
    assert_eq!(with.unknowns_m(), without.unknowns_m());
}

#[test]
fn the_stiffer_an_inclusion_the_less_gives_way() {
    let fat = Material::from(&flat().flat.slab.layers[1]);
    let sinks_m = [0.1, 1.0, 10.0, 100.0, 1000.0].map(|times| {
        let stiff = Material { youngs_modulus_pa: times * fat.youngs_modulus_pa, ..fat };
        let problem = Problem3 { inclusions: vec![ball(stiff)], ..flat() };
        -solved(&problem, Symmetry::Half).displacement_m(0.0, 0.0)[0]
    });
    assert!(sinks_m.is_sorted_by(|softer, stiffer| stiffer < softer), "{sinks_m:?} m");
}
