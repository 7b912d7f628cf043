//! A scene that names an anatomy: what a needle meets on its way, and what a recording carries of it.
//!
//! Would fail if layers came in another order than a body has them, if bone let a needle through, if two readings differed, or if a recording
//! needed the body again.

use documents::{ExerciseBundle, Patient, Scene};
use nalgebra::Point3;
use trials::needle::DrivenNeedle;

use crate::support::{curricula, folder, read_text, write};

const BODY: &str = r#"id = "body"
law = 3
title = "Body"

[anatomy]
interspace = "L3/4"
posture = "sitting"
seed = 6
weight_kg = 70
age_years = 35

[needle]
kind = "needle"
diameter_mm = 1.27
tip = "bevel"
length_mm = 90
"#;

fn exercise(name: &str) -> ExerciseBundle {
    ExerciseBundle::read(&curricula().join("lumbar-epidural-on-a-body").join(name)).unwrap()
}

fn layers(scene: &Scene) -> Vec<&str> {
    scene.layers.iter().map(|layer| layer.name.as_str()).collect()
}

/// A reader of recordings would pay seconds for each.
#[test]
fn a_recording_carries_what_came_of_a_body_and_no_body() {
    let bundle = exercise("1-midline.toml");
    assert!(ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, &bundle.meshes).is_ok());
    let refused =
        ExerciseBundle::from_parts(&bundle.exercise_bytes, BODY.as_bytes(), &[]).expect_err("a body").to_string();
    assert!(refused.contains("attached scene:5:2") && refused.contains("anatomy: a body"), "{refused}");
}

#[test]
fn the_midline_leads_through_the_ligaments_in_their_order() {
    let scene = crate::support::scene(BODY);
    let order = [
        "skin",
        "fat",
        "supraspinous ligament",
        "interspinous ligament",
        "ligamentum flavum",
        "epidural space",
        "dura",
        "cerebrospinal fluid",
    ];
    assert_eq!(layers(&scene), order);
    let names: Vec<&str> = scene.structures.iter().map(|s| s.spec.name.as_str()).collect();
    assert!(["vertebra L3", "vertebra L4", "dural sac"].iter().all(|name| names.contains(name)), "{names:?}");
    assert!(!names.contains(&"kidney left"), "out of the needle's reach");
}

#[test]
fn second_scaling_passes_the_sac_and_starts_below_an_introducer() {
    let scaled = BODY.replace("law = 3", "law = 5\nscaling = 2");
    let whole = crate::support::scene(&scaled);
    let behind = ["cerebrospinal fluid", "dura 2", "anterior epidural space", "ligament"];
    let met = layers(&whole);
    let at = met.iter().position(|name| *name == behind[0]).unwrap();
    assert_eq!(met[at..(at + 2)], behind[..2]);
    assert!(met[(at + 2)..].iter().any(|name| behind[2..].contains(name)), "{met:?}");
    let introduced = crate::support::scene(&scaled.replace("[needle]", "introducer_mm = 35\n\n[needle]"));
    let first: Vec<_> = introduced.layers.iter().take(2).map(|layer| layer.name.as_str()).collect();
    assert_eq!(first, ["introducer", "interspinous ligament"]);
    let depth_mm = |scene: &Scene| -> f64 {
        let above = scene.layers.iter().take_while(|layer| layer.name != "dura");
        above.map(|layer| layer.thickness_mm).sum()
    };
    assert!((depth_mm(&whole) - depth_mm(&introduced)).abs() < 0.05, "{} mm", depth_mm(&introduced));
    says(&BODY.replace("[needle]", "introducer_mm = 35\n\n[needle]"), &["anatomy.introducer_mm: 35 mm", "scaling = 2"]);
}

#[test]
fn paramedian_path_meets_muscle_and_no_ligament_before_flavum() {
    let bundle = exercise("3-paramedian.toml");
    let met = layers(&bundle.scene);
    assert!(met.contains(&"muscle") && met.contains(&"ligamentum flavum"), "{met:?}");
    assert!(!met.contains(&"interspinous ligament") && !met.contains(&"supraspinous ligament"), "{met:?}");
}

#[test]
fn straight_needle_stops_on_the_lamina_and_a_tilted_one_passes() {
    let bundle = exercise("2-off-the-bone.toml");
    let spec = bundle.scene.puncture_spec(&Patient::nominal(&bundle.scene));
    let push = |angle_deg: f64| {
        let mut needle = DrivenNeedle::new(spec.axial.clone(), spec.structures.clone()).unwrap();
        let (sin, cos) = libm::sincos(f64::to_radians(angle_deg));
        let axis = nalgebra::Vector3::new(0.0, sin, -cos);
        // 47 mm along the needle, before the flavum gives way.
        let ticks = needle.travel(axis, Point3::origin() - axis * 2e-3, Point3::origin() + axis * 47e-3);
        ticks.iter().map(|tick| tick.output.structures_n.norm()).fold(0.0, f64::max)
    };
    assert!(push(0.0) > 5.0, "straight in is bone: {} N", push(0.0));
    assert!(push(bundle.exercise.angle_deg) == 0.0, "the planned way is free: {} N", push(bundle.exercise.angle_deg));
}

#[test]
fn a_recording_carries_what_the_anatomy_became() {
    let bundle = exercise("1-midline.toml");
    assert!(!String::from_utf8_lossy(&bundle.scene_bytes).contains("[anatomy]"));
    assert_eq!(exercise("1-midline.toml"), bundle, "two readings differ");
    let rebuilt = ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, &bundle.meshes).unwrap();
    assert_eq!(rebuilt, bundle);
    let bytes: usize = bundle.meshes.iter().map(|(_, bytes)| bytes.len()).sum();
    assert!(bytes < 1_000_000, "{bytes} bytes of meshes in every recording");
}

fn says(text: &str, parts: &[&str]) {
    let refused = read_text(&folder(), text).expect_err("refused").to_string();
    assert!(parts.iter().all(|part| refused.contains(part)), "{refused}");
}

#[test]
fn what_no_body_has_is_refused_at_its_key() {
    says(&BODY.replace("= 70", "= 20"), &["anatomy.weight_kg: 20 kg", "from 40 to 160 kg"]);
    says(&BODY.replace("L3/4", "L6/7"), &["anatomy.interspace: \"L6/7\"", "L1/2, L2/3, L3/4, L4/5, L5/S1"]);
    says(
        &BODY.replace("seed = 6", "parts = [\"wings\"]"),
        &["anatomy.parts: \"wings\"", "bones, dura, vessels, kidneys"],
    );
    let layered =
        format!("{BODY}[[layer]]\nname = \"a\"\nthickness_mm = 1\nstiffness_n_per_m = 1\ntip_rupture_n = 1\n");
    says(&layered, &["layer: together with anatomy", "come from the anatomy"]);
    says(&BODY.replace("[anatomy]", "[tissue]\n[needle_]"), &["layer: missing"]);
}

#[test]
fn an_exercise_enters_as_the_anatomy_was_met() {
    let folder = folder();
    write(&folder, "scene.toml", BODY);
    let exercise =
        crate::support::EXERCISE.replace("[target]", "[entry]\npoint_mm = [3, 0]\nangle_deg = 10\n\n[target]");
    let refused = ExerciseBundle::read(&write(&folder, "e.toml", exercise)).expect_err("refused").to_string();
    assert!(refused.contains("entry.angle_deg: 10 °; allowed: 0°"), "{refused}");
    assert!(refused.contains("entry.point_mm: [3, 0]; allowed: [0, 0]"), "{refused}");
}

#[test]
fn parts_that_are_not_named_do_not_exist() {
    let scene = crate::support::scene(&BODY.replace("seed = 6", "seed = 6\nparts = [\"bones\"]"));
    assert!(!scene.structures.is_empty());
    assert!(scene.structures.iter().all(|s| s.kind() == documents::StructureKind::Bone));
}

/// The drawn skin is at the plane that the forces know, to what a hand would notice, wherever one enters instead of the planned place.
#[test]
fn a_shipped_bodys_skin_is_as_flat_as_the_forces_take_it() {
    const ABOUT_M: f64 = 25e-3;
    const OFF_M: f64 = 1.5e-3;
    let folders = ["lumbar-epidural-on-a-body", "lumbar-puncture", "percutaneous-kidney-access"];
    let files = folders.iter().flat_map(|name| std::fs::read_dir(curricula().join(name)).unwrap().flatten());
    let bundles: Vec<ExerciseBundle> = files.filter_map(|file| ExerciseBundle::read(&file.path()).ok()).collect();
    assert!(bundles.len() >= 5, "{}", bundles.len());
    for bundle in bundles {
        let skin = bundle.scene.skin.expect("a body has one");
        let corners = |three: &[u32; 3]| three.map(|corner| skin.vertices_m[corner as usize].coords);
        let places = skin.triangles.iter().flat_map(|three| {
            let [a, b, c] = corners(three);
            [a, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
        });
        // Above the bed.
        let about = places.filter(|place| place.xy().norm() < ABOUT_M && place.z > -ABOUT_M);
        let off_m: Vec<f64> = about.map(|place| place.z.abs()).collect();
        let most_m = off_m.iter().copied().fold(0.0, f64::max);
        assert!(off_m.len() >= 20 && most_m < OFF_M, "{}: {} m at {} places", bundle.exercise.id, most_m, off_m.len());
    }
}

/// The epidural exercise in the midline on another body.
fn on_another_body(posture: &str, seed: u32, weight_kg: u32) -> String {
    let read = |path: &str| std::fs::read_to_string(curricula().join(path)).unwrap();
    let scene = read("scenes/epidural-midline.toml");
    let scene = scene.replace("\"sitting\"", &format!("\"{posture}\"")).replace("seed = 6", &format!("seed = {seed}"));
    let scene = scene.replace("weight_kg = 70", &format!("weight_kg = {weight_kg}"));
    let exercise = read("lumbar-epidural-on-a-body/1-midline.toml");
    let bundle = ExerciseBundle::from_texts(&exercise, &scene).unwrap();
    bundle.unsound().unwrap().iter().map(|issue| format!("{}: {}", issue.field, issue.found)).collect()
}

#[test]
fn blocked_path_is_reported_with_the_bone_and_the_depth() {
    assert_eq!(on_another_body("sitting", 6, 70), "", "the shipped one is free");
    let found = on_another_body("side", 3, 115);
    assert!(found.starts_with("entry.angle_deg: the planned needle meets vertebra L4 at 49."), "{found}");
    let found = on_another_body("sitting", 5, 45);
    assert!(found.starts_with("entry.angle_deg: the planned needle meets vertebra L4 at 38."), "{found}");
}

#[test]
fn scene_blocked_by_bone_is_rejected_with_nearest_free_angle() {
    let folder = folder();
    let path = write(&folder, "scene.toml", BODY.replace("seed = 6", "seed = 5").replace("= 70", "= 45"));
    let refused = documents::check_documents(&path).expect_err("bone is in the way").to_string();
    assert!(refused.contains("meets vertebra L4") && refused.contains("the nearest at"), "{refused}");
    assert!(documents::check_documents(&write(&folder, "free.toml", BODY)).is_ok());
    let lost = BODY.replace("age_years = 35", "age_years = 35\ngoal = \"calyx\"");
    let refused =
        documents::check_documents(&write(&folder, "lost.toml", lost)).expect_err("no such layer").to_string();
    assert!(refused.contains("anatomy.goal") && refused.contains("epidural space"), "{refused}");
}
