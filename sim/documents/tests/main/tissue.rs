//! A scene's tissue: what it is made of, where there is none, and a law that takes its stiffness from the field.
//!
//! Would fail if a modulus depended on the needle, a stated number were not used, a scene that wants no field got one, or a coupled
//! scene were judged by stiffnesses that it does not use.

use std::path::Path;

use documents::load::read_document;
use documents::{Document, Patient, Scene, check_documents};
use tissue::follow::Field;
use tissue::planner::cut_patch;
use tissue::volumetric::{self, Problem3, VolumetricError};
use tissue::{Model, Problem, Specimen};

use crate::support::{SCENE, curricula, folder, scene, write};

fn with(tissue: &str) -> Scene {
    scene(&SCENE.replace("[needle]", &format!("[tissue]\n{tissue}\n[needle]")))
}

#[test]
fn modulus_is_that_of_a_2_mm_punch_for_every_needle_diameter() {
    for diameter in ["0.5", "2.0", "3.0"] {
        let scene = scene(&SCENE.replace("diameter_mm = 2.0", &format!("diameter_mm = {diameter}")));
        let tissue = scene.tissue_spec(&Patient::nominal(&scene), 0.0).unwrap();
        let moduli: Vec<f64> = tissue.slab.layers.iter().map(|layer| layer.youngs_modulus_pa).collect();
        for (found, k) in moduli.iter().zip([331.0, 83.0]) {
            assert!((found / (k * (1.0 - 0.45 * 0.45) / 0.002) - 1.0).abs() < 1e-12, "{found} Pa at {diameter} mm");
        }
        assert_eq!(tissue.boundaries_m.len(), 3);
        assert!((tissue.load_radius_m - 0.5e-3 * diameter.parse::<f64>().unwrap()).abs() < 1e-15);
    }
}

#[test]
fn what_a_scene_states_is_used_and_the_patient_is_the_one_drawn() {
    let stated = "recoil_time_s = 0.07\nyoungs_modulus_pa = 5e4\ndensity_kg_per_m3 = 1090\nthickness_mm = 0.8";
    let scene = scene(&SCENE.replace("thickness_mm = 0.8", stated));
    let tissue = scene.tissue_spec(&Patient { thickness_mm: vec![1.5, 8.0] }, 0.0).unwrap();
    assert!((tissue.recoil_time_s[0] - 0.07).abs() < 1e-15);
    let skin = tissue.slab.layers[0];
    assert_eq!([skin.youngs_modulus_pa, skin.density_kg_per_m3, skin.thickness_m], [5e4, 1090.0, 1.5e-3]);
    // Fat states no recoil: a wave crosses 8 mm of it.
    let fat = tissue.slab.layers[1];
    let crossing_s = 8e-3 * (fat.density_kg_per_m3 / fat.youngs_modulus_pa).sqrt();
    assert!((tissue.recoil_time_s[1] - crossing_s).abs() < 1e-15);
}

#[test]
fn scene_has_a_field_unless_it_opts_out_or_has_no_thickness() {
    let model = |scene: &Scene| scene.tissue_spec(&Patient::nominal(scene), 0.0).map(|tissue| tissue.model);
    assert_eq!(model(&scene(SCENE)), Some(None), "auto, the default, leaves it to the planner");
    assert_eq!(model(&with("model = \"none\"")), None);
    assert_eq!(model(&with("model = \"mass-spring\"")), Some(Some(Model::MassSpring)));
    assert_eq!(model(&with("model = \"volumetric\"")), Some(Some(Model::Volumetric)));
    let thin =
        SCENE.replace("thickness_mm = 0.8", "thickness_mm = 0").replace("thickness_mm = 8.4", "thickness_mm = 0");
    assert_eq!(model(&scene(&thin)), None);
    let fascia = scene(&SCENE.replace("thickness_mm = 0.8", "thickness_mm = 0"));
    let tissue = fascia.tissue_spec(&Patient::nominal(&fascia), 0.0).unwrap();
    assert_eq!((tissue.slab.layers.len(), tissue.boundaries_m), (1, vec![0.0, 0.0, 8.4 / 1e3]));
}

#[test]
fn a_coupled_scene_is_judged_by_the_fields_stiffnesses() {
    let own = scene(SCENE);
    let coupled = with("coupling = \"field\"");
    let nominal = Patient::nominal(&own);
    let stiffnesses_at = |scene: &Scene, angle_deg: f64| -> Vec<f64> {
        scene.coupled_spec(&nominal, angle_deg).unwrap().layers.iter().map(|layer| layer.stiffness_n_per_m).collect()
    };
    let field_at = |angle_deg: f64| {
        let tissue = coupled.tissue_spec(&nominal, angle_deg).unwrap();
        Field::new(&tissue).unwrap().planned().stiffnesses_n_per_m()
    };
    let stiffnesses = |scene: &Scene| stiffnesses_at(scene, 0.0);
    assert_eq!(stiffnesses(&own), [331.0, 83.0]);
    assert_eq!(stiffnesses(&coupled), field_at(0.0));
    assert_eq!(stiffnesses_at(&coupled, 25.0), field_at(25.0), "of the angle that it is judged at");
    assert!(coupled.soundness(0.0).unwrap().is_empty());

    // Tough fat, stiff in the field alone: what its own stiffness makes sound is unsound with the field's.
    let tough =
        SCENE.replace("tip_rupture_n = 0.5", "youngs_modulus_pa = 2e6\ntip_rupture_n = 9").replace("= 0.6", "= 10");
    assert!(scene(&tough).soundness(0.0).unwrap().is_empty());
    let text = tough.replace("[needle]", "[tissue]\ncoupling = \"field\"\n[needle]");
    let error = check_documents(&write(&folder(), "scene.toml", text)).unwrap_err().to_string();
    for part in ["layer[0].tip_rupture_n", "unsound with the field's stiffnesses", "boundary 0 (skin)"] {
        assert!(error.contains(part), "{part:?} is not said by:\n{error}");
    }
}

/// Every shipped scene.
fn shipped() -> Vec<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/scenes");
    let scenes = std::fs::read_dir(folder).unwrap().map(|file| match read_document(&file.unwrap().path()).unwrap() {
        Document::Scene(scene) => *scene,
        other => panic!("no scene: {other:?}"),
    });
    scenes.collect()
}

/// How many of a scene's loads the volumetric model takes: each but one on a patch that a leaning needle leaves.
fn count_taken_loads(scene: &Scene) -> usize {
    let mut taken = 0;
    for (angle_deg, footprints) in [(0.0, 10.0), (0.0, 20.0), (0.0, 80.0), (25.0, 40.0)] {
        let tissue = scene.tissue_spec(&Patient::nominal(scene), angle_deg).unwrap();
        let deepest_m = tissue.boundaries_m[tissue.layers() - 1];
        let slab = cut_patch(&tissue.slab.layers, deepest_m, footprints * tissue.load_radius_m);
        for load in tissue.loads().into_iter().flatten().filter(|load| load.ends_m()[1] <= deepest_m) {
            let depth_m = load.ends_m()[1];
            let flat = Problem { slab: slab.clone(), load, sample_r_m: vec![0.0], sample_depth_m: vec![depth_m] };
            let problem = Problem3 { tilt_rad: tissue.tilt_rad, ..Problem3::flat(&flat) };
            match volumetric::fit_rung(&problem, 0).unwrap() {
                Ok(mut model) => {
                    tissue::FieldModel::solve(&mut model, 1.0);
                    let give_m = problem.along_needle_m(&model, 0.0, depth_m);
                    assert!(give_m > 0.0 && give_m.is_finite(), "{} at {angle_deg}°: {give_m} m", scene.id);
                    taken += 1;
                }
                // A needle that leans out of a patch has no mesh on it.
                Err(VolumetricError::Param(why)) => assert!(why.field == "tilt_rad" && angle_deg > 0.0, "{why}"),
                Err(why) => panic!("{} at {angle_deg}°: {why}", scene.id),
            }
        }
    }
    taken
}

#[test]
fn the_volumetric_model_takes_every_load_of_every_shipped_scene() {
    let scenes = shipped();
    // It is the last test to end, and would be alone.
    let taken: usize = std::thread::scope(|scope| {
        let counts: Vec<_> = scenes.iter().map(|scene| scope.spawn(|| count_taken_loads(scene))).collect();
        counts.into_iter().map(|count| count.join().unwrap()).sum()
    });
    assert!(taken > 100, "{taken} loads");
}

#[test]
fn random_motion_keeps_tents_of_shipped_scenes_in_the_body() {
    let mut fields = 0;
    for scene in shipped_scenes() {
        let specimen = Specimen::new(scene.specimen_spec(&Patient::nominal(&scene), 0.0)).unwrap();
        let seen = trials::soak(specimen.law(), specimen.field(), 30_000, 5);
        assert!(seen.passes(), "{}: {seen:?}", scene.id);
        fields += u32::from(seen.tent_m > 1e-3);
    }
    assert!(fields >= 12, "{fields} fields");
}

fn shipped_scenes() -> Vec<Scene> {
    let folder = std::fs::read_dir(curricula().join("scenes")).unwrap().map(|entry| entry.unwrap().path());
    let scene = |path: std::path::PathBuf| match read_document(&path).unwrap() {
        Document::Scene(scene) => *scene,
        other => panic!("not a scene: {other:?}"),
    };
    folder.filter(|path| path.extension().is_some_and(|end| end == "toml")).map(scene).collect()
}
