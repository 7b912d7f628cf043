//! A skin that bends and structures of another stiffness: what is read, what is refused, and in which frame a plan is measured.
//!
//! Would fail if a plan off the top were measured from z instead of the skin's normal, if the field were asked about another place than the
//! exercise's, or if a shape that the field does not know were let in.

use std::path::Path;

use documents::{Document, ExerciseBundle, Patient, PlannedNeedle, Scene, check_documents};
use law::Skin;
use nalgebra::{Point3, Vector3};
use tissue::volumetric::InclusionShape;

use crate::support::{EXERCISE, SCENE, folder, read_text, scene};

fn with(more: &str) -> String {
    format!("{SCENE}\n{more}\n")
}

const BALL: &str = "[skin]\nshape = \"sphere\"\nradius_mm = 60\n";
const LUMP: &str = "[[structure]]\nname = \"lump\"\nkind = \"target\"\nshape = \"sphere\"\nposition_mm = [12, 3, -8]\n\
                    radius_mm = 4\nyoungs_modulus_pa = 2e5\n";

fn refused(text: &str) -> String {
    read_text(&folder(), text).expect_err("it must be refused").to_string()
}

#[test]
fn a_skin_is_what_its_keys_say() {
    let shape = |more: &str| scene(&with(more)).skin_shape;
    assert_eq!(shape(""), Skin::Flat);
    assert_eq!(shape(BALL), Skin::Sphere { radius_m: 0.06 });
    let along_the_spine = shape("[skin]\nshape = \"cylinder\"\nradius_mm = 150\n");
    assert_eq!(along_the_spine, Skin::Cylinder { radius_m: 0.15, along_rad: 90_f64.to_radians() });
    let turned = shape("[skin]\nshape = \"cylinder\"\nradius_mm = 150\nalong_deg = 30\n");
    assert_eq!(turned, Skin::Cylinder { radius_m: 0.15, along_rad: 30_f64.to_radians() });
}

#[test]
fn invalid_skin_or_lump_is_rejected_with_the_allowed_values() {
    for (more, said) in [
        ("[skin]\nshape = \"sphere\"\n", "skin.radius_mm: missing; required for a sphere"),
        (
            "[skin]\nshape = \"sphere\"\nradius_mm = 20\nalong_deg = 3\n",
            "skin.along_deg: 3 °; allowed only for a cylinder",
        ),
        ("[skin]\nradius_mm = 60\n", "skin.radius_mm: 60 mm; allowed only for a curved skin"),
        ("[skin]\nalong_deg = 90\n", "skin.file: missing"),
        ("[skin]\nshape = \"sphere\"\nradius_mm = 5\n", "radius_mm"),
        (
            &LUMP
                .replace("shape = \"sphere\"", "shape = \"box\"")
                .replace("radius_mm = 4", "half_extents_mm = [1, 1, 1]"),
            "not for a box",
        ),
        (&LUMP.replace("youngs_modulus_pa = 2e5", "poisson_ratio = 0.4"), "youngs_modulus_pa: missing"),
        (&LUMP.replace("2e5", "2e99"), "youngs_modulus_pa"),
    ] {
        let error = refused(&with(more));
        assert!(error.contains(said), "{said:?} is not said by:\n{error}");
    }
    let thick =
        with("[skin]\nshape = \"sphere\"\nradius_mm = 24\n").replacen("thickness_mm = 8.4", "thickness_mm = 38", 1);
    assert!(refused(&thick).contains("allowed: at least 48.5 mm, 1.25 times the thickness"), "{}", refused(&thick));
}

#[test]
fn a_plan_is_measured_from_the_skins_normal_at_its_entry() {
    let skin = Skin::Sphere { radius_m: 0.06 };
    let off_mm = 60.0 * libm::sin(0.3);
    let planned = PlannedNeedle { entry_mm: [off_mm, 0.0], angle_deg: 20.0, azimuth_deg: 0.0 };
    let (entry_m, axis) = (planned.entry_m(&skin), planned.axis(&skin));
    assert!(skin.height_m(&entry_m).abs() < 1e-12);
    let lean = libm::acos(-axis.dot(&skin.outward(&entry_m)));
    assert!((lean.to_degrees() - 20.0).abs() < 1e-9, "it leans by {lean} rad");
    // The normal leans by 0.3 rad towards +x, and the needle by 20° more from there.
    let wanted = Vector3::new(libm::sin(20_f64.to_radians() - 0.3), 0.0, -libm::cos(20_f64.to_radians() - 0.3));
    assert!((axis - wanted).norm() < 1e-12, "{axis}");
}

#[test]
fn the_field_is_asked_in_the_frame_of_the_entry() {
    let scene: Scene = scene(&with(&format!("{BALL}{LUMP}")));
    let planned = PlannedNeedle { entry_mm: [12.0, 3.0], angle_deg: 0.0, azimuth_deg: 50.0 };
    let tissue = scene.tissue_spec(&Patient::nominal(&scene), planned).expect("a tissue");
    assert_eq!(tissue.skin, Skin::Sphere { radius_m: 0.06 });
    let InclusionShape::Sphere { centre_m, radius_m } = tissue.inclusions[0].shape else { panic!("it is round") };
    assert!((radius_m - 4e-3).abs() < 1e-15);
    let lump_m = Point3::new(12e-3, 3e-3, -8e-3);
    let deep_m = scene.skin_shape.height_m(&lump_m);
    assert!((tissue.skin.height_m(&centre_m) - deep_m).abs() < 1e-12, "as deep below the skin as in the scene");
    // The entry lies straight above it, and the skin's normal there leans away from it.
    let aside_m = libm::hypot(centre_m.x, centre_m.y);
    assert!(aside_m > 1e-3 && aside_m < 2e-3, "{centre_m}");
}

#[test]
fn an_exercise_enters_on_its_scenes_skin() {
    let exercise = EXERCISE.replace("[target]", "[entry]\npoint_mm = [12, 0]\nangle_deg = 0\n\n[target]");
    let bundle = ExerciseBundle::from_parts(exercise.as_bytes(), with(BALL).as_bytes(), &[]).expect("an exercise");
    let plan = bundle.plan();
    assert!((plan.entry_m - Skin::Sphere { radius_m: 0.06 }.above(0.012, 0.0)).norm() < 1e-15);
    assert!(plan.entry_m.z < -1e-3, "{}", plan.entry_m);
    assert!((plan.axis + bundle.scene.skin_shape.outward(&plan.entry_m)).norm() < 1e-12);
    let target_m = bundle.exercise.target_m();
    assert!((bundle.scene.skin_shape.height_m(&target_m) + 0.02).abs() < 1e-12, "20 mm deep: {target_m}");
}

#[test]
fn a_lump_under_a_slope_is_a_sound_exercise_and_is_felt() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/lump/exercise.toml");
    let Document::Exercise(bundle) = check_documents(&path).expect("a sound exercise") else { panic!("no exercise") };
    let nominal = Patient::nominal(&bundle.scene);
    let stiffness = |scene: &Scene| -> f64 {
        let spec = scene.coupled_spec(&nominal, bundle.exercise.planned_needle()).expect("a field");
        spec.layers[2].stiffness_n_per_m
    };
    let mut without = bundle.scene.clone();
    without.structures.clear();
    let (with, without) = (stiffness(&bundle.scene), stiffness(&without));
    assert!(with > 1.05 * without, "{with} N/m over the lump, {without} N/m without it");
}
