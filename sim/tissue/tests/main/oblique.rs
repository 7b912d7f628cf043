//! An oblique needle in (r, z): two harmonics give what three dimensions do, and their error is what the estimate says.
//!
//! Would fail on a sign or a factor between the harmonics, a tissue that tears on the axis, a drag that does not lean, an error
//! that is not told, or a field of an attempt that ignores its angle.

use tissue::axisymmetric::{Axisymmetric, MeshSpec, Oblique, fit_oblique};
use tissue::follow::{Field, TissueSpec};
use tissue::volumetric::{self, Problem3};
use tissue::{ElasticLayer, FieldModel, Load, LoadKind, Model, Problem, Slab, relative_distance};

use crate::follow;

const SKIN: LoadKind = LoadKind::Contactor { depth_m: 0.0 };
const FAT: LoadKind = LoadKind::Contactor { depth_m: 0.0008 };
const MUSCLE: LoadKind = LoadKind::Contactor { depth_m: 0.0092 };
const THROUGH_FAT: LoadKind = LoadKind::Drag { from_m: 0.0008, to_m: 0.0092 };

fn lower_back(kind: LoadKind, tilt_deg: f64) -> Problem3 {
    let layer = |thickness_m, youngs_modulus_pa| ElasticLayer {
        thickness_m,
        youngs_modulus_pa,
        poisson_ratio: 0.45,
        density_kg_per_m3: 1000.0,
    };
    let layers = vec![layer(0.0008, 132e3), layer(0.0084, 33e3), layer(0.039, 198e3)];
    let flat = Problem {
        slab: Slab { layers, radius_m: 0.05 },
        load: Load { kind, radius_m: 0.001 },
        sample_r_m: vec![0.0],
        sample_depth_m: vec![0.0, 0.0008, 0.0092],
    };
    Problem3 { tilt_rad: tilt_deg.to_radians(), ..Problem3::flat(&flat) }
}

/// The displacement along the needle where it meets the boundaries, in m: what an attempt sees.
fn answer_m(question: &Problem3, model: &dyn FieldModel) -> Vec<f64> {
    question.flat.sample_depth_m.iter().map(|&depth_m| question.along_needle_m(model, 0.0, depth_m)).collect()
}

/// A mesh whose error is far below what it is compared with.
fn fine(question: &Problem3) -> Oblique {
    Oblique::new(question, &MeshSpec::graded(&question.flat, 7.0).raised(1), 6).expect("a model")
}

#[test]
fn two_harmonics_match_three_dimensions_within_the_estimate() {
    for (kind, tilt_deg) in [(SKIN, 25.0), (MUSCLE, 15.0), (THROUGH_FAT, 25.0)] {
        let question = lower_back(kind, tilt_deg);
        let mut volumetric = volumetric::fit_rung(&question, 3).expect("a rung").expect("a model");
        volumetric.solve(1.0);
        let solid = answer_m(&question, &volumetric);
        let truth = answer_m(&question, &fine(&question));
        let off = relative_distance(&solid, &truth);
        // This rung's own error on lower_back is between 0.3 and 1 % (the report of `bench field`).
        assert!(off < 0.01, "{kind:?} at {tilt_deg}°: {off} off the volumetric model");
        for tolerance in [0.025, 0.005] {
            let fitted = fit_oblique(&question, tolerance).expect("a model");
            let estimate = fitted.estimated_relative_error;
            let found = answer_m(&question, &fitted.model);
            let error = relative_distance(&found, &truth);
            assert!(fitted.met && estimate <= tolerance, "{kind:?} at {tilt_deg}°: {estimate}");
            // It covers what is across the needle, too, which may be the larger part.
            assert!((estimate / 10.0..=3.0 * estimate).contains(&error), "{kind:?}: {error}, estimated {estimate}");
            assert!(relative_distance(&found, &solid) <= 3.0 * estimate + off, "{kind:?} at {tilt_deg}°: {estimate}");
        }
    }
}

/// Along the needle and across it, to both sides of it, and not only on it.
#[test]
fn the_estimate_covers_what_is_across_the_needle_too() {
    for (kind, tilt_deg) in [(FAT, 25.0), (THROUGH_FAT, 15.0)] {
        let mut question = lower_back(kind, tilt_deg);
        question.flat.sample_r_m = vec![0.001, 0.004];
        let truth = fine(&question);
        let (sine, cosine) = (libm::sin(question.tilt_rad), libm::cos(question.tilt_rad));
        let across_m = |model: &Oblique| -> Vec<f64> {
            let places =
                question.flat.sample_depth_m.iter().flat_map(|&depth_m| [-4, -1, 1, 4].map(|mm| (mm, depth_m)));
            let at = |(mm, depth_m): (i32, f64)| {
                let x_m = f64::from(mm) * 1e-3 + depth_m * sine / cosine;
                let [out_m, along_m] = model.displacement_m(x_m, depth_m);
                cosine * along_m + sine * out_m
            };
            places.map(at).collect()
        };
        let fitted = fit_oblique(&question, 0.01).expect("a model");
        let (error, estimate) =
            (relative_distance(&across_m(&fitted.model), &across_m(&truth)), fitted.estimated_relative_error);
        assert!(fitted.met && error <= estimate.min(0.01), "{kind:?}: {error} across, estimated {estimate}");
    }
}

#[test]
fn a_needle_that_does_not_lean_is_a_perpendicular_one() {
    for kind in [FAT, THROUGH_FAT] {
        let question = lower_back(kind, 0.0);
        let mesh = MeshSpec::graded(&question.flat, 5.0);
        let straight = Axisymmetric::new(&question.flat, &mesh).expect("a model");
        let oblique = Oblique::new(&question, &mesh, 3).expect("a model");
        for (r_m, depth_m) in [(0.0, 0.0), (0.0, 0.0092), (0.002, 0.0008), (0.01, 0.02), (0.06, 0.0)] {
            let [one, other] = [&straight as &dyn FieldModel, &oblique].map(|model| model.displacement_m(r_m, depth_m));
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            assert!(
                near(one[0], other[0]) && near(one[1], other[1]),
                "{kind:?} at {r_m}, {depth_m}: {one:?} {other:?}"
            );
        }
    }
}

/// Betti's theorem: layers do not change along the skin, so that a footprint may as well be where one looks.
#[test]
fn a_push_here_seen_there_is_a_push_there_seen_here() {
    for tilt_deg in [-25.0, 15.0, 60.0] {
        let [skin, fat] = [SKIN, FAT].map(|kind| lower_back(kind, tilt_deg));
        let there = skin.along_needle_m(&fine(&skin), 0.0, 0.0008);
        let here = fat.along_needle_m(&fine(&fat), 0.0, 0.0);
        assert!((there / here - 1.0).abs() < 1e-3, "at {tilt_deg}°: {there} and {here} m");
    }
}

#[test]
fn forces_scale_the_answer_and_a_bad_one_leaves_it() {
    let question = lower_back(THROUGH_FAT, -25.0);
    let mut model = Oblique::new(&question, &MeshSpec::graded(&question.flat, 4.0), 3).expect("a model");
    let unit = answer_m(&question, &model);
    assert!(unit.iter().all(|&along_m| along_m > 0.0), "a push moves the tissue along: {unit:?}");
    for (force_n, times) in [(-2.0, -2.0), (f64::NAN, -2.0), (f64::INFINITY, -2.0), (0.5, 0.5)] {
        model.solve(force_n);
        let found = answer_m(&question, &model);
        assert!(found.iter().zip(&unit).all(|(a, b)| (a - times * b).abs() < 1e-15), "{force_n} N: {found:?}");
    }
    assert!(model.displacement_m(1.0, 0.0).iter().all(|part_m| part_m.abs() <= 0.0), "outside nothing moves");
}

#[test]
fn an_oblique_field_meets_its_tolerance_and_says_how() {
    // Wide enough for a needle at 60°.
    const BODY_M: f64 = 0.25;
    let leaning = |tilt_deg: f64| {
        let mut tissue = TissueSpec { tilt_rad: tilt_deg.to_radians(), ..follow::lower_back() };
        tissue.slab.radius_m = BODY_M;
        tissue
    };
    let perpendicular = Field::new(&leaning(0.0)).expect("a field");
    for tilt_deg in [15.0_f64, 25.0] {
        let tissue = leaning(tilt_deg);
        let field = Field::new(&tissue).expect("a field");
        let plan = field.plan();
        assert!(plan.expected_relative_error <= tissue.tolerance, "{tilt_deg}°: {}", plan.expected_relative_error);
        assert!(
            plan.model == Model::Axisymmetric && plan.reason.to_string().contains("two harmonics"),
            "{}",
            plan.reason
        );
        for (kind, k) in [SKIN, FAT, MUSCLE].into_iter().zip(field.planned().stiffnesses_n_per_m()) {
            let mut question = lower_back(kind, tilt_deg);
            question.flat.slab.radius_m = BODY_M;
            let give_m = question.along_needle_m(&fine(&question), 0.0, question.flat.load.ends_m()[0]);
            let off = (k * give_m - 1.0).abs();
            assert!(off <= plan.expected_relative_error, "{kind:?} at {tilt_deg}°: {off} off on the whole body");
        }
        let [own, straight] = [&field, &perpendicular].map(|field| field.planned().stiffnesses_n_per_m());
        let most = own.iter().zip(&straight).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        assert!((0.005..0.2).contains(&most), "the angle is felt, and no more than that: {own:?} and {straight:?}");
    }
    let error = Field::new(&TissueSpec { tilt_rad: 1.5, ..follow::lower_back() }).expect_err("too flat").to_string();
    assert!(error.contains("tilt_rad = 1.5 rad"), "{error}");
}
