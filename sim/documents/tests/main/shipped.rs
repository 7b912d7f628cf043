//! The shipped documents: they read, they are sound, and the paper's scene holds the paper's numbers.
//!
//! Would fail if a document were edited into something that its own reader, or physics, refuses.

use documents::load::read_document;
use documents::{Curriculum, Document, ExerciseBundle, MasteryRule, Patient, Scene, check_documents};
use law::puncture::PunctureEvent;
use nalgebra::{Point3, Vector3};
use trials::needle::DrivenNeedle;

use crate::support::{curricula, shipped};

fn shipped_scene(name: &str) -> Scene {
    match read_document(&curricula().join("scenes").join(name)).unwrap() {
        Document::Scene(scene) => *scene,
        other => panic!("not a scene: {other:?}"),
    }
}

fn course() -> (Curriculum, Vec<ExerciseBundle>) {
    match read_document(&curricula().join("lower-back-basics/course.toml")).unwrap() {
        Document::Curriculum(course, exercises) => (*course, exercises),
        other => panic!("not a curriculum: {other:?}"),
    }
}

#[test]
fn every_shipped_document_passes_the_check() {
    let documents = shipped();
    assert!(documents.len() >= 13, "documents are missing: {documents:?}");
    for path in documents {
        if let Err(error) = check_documents(&path) {
            panic!("{error}");
        }
    }
}

#[test]
fn drawn_patients_are_sound_too() {
    for path in shipped() {
        let Ok(Document::Scene(scene)) = read_document(&path) else { continue };
        for seed in 0..200 {
            let spec = scene.axial_spec(&Patient::draw(&scene, seed));
            let unsound = law::soundness::find_unsound_ruptures(&spec);
            assert!(unsound.is_empty(), "{} with seed {seed}: {unsound:?}", scene.id);
        }
    }
}

#[test]
fn no_shipped_needle_goes_in_farther_than_it_is_long() {
    for path in shipped() {
        let Ok(Document::Scene(scene)) = read_document(&path) else { continue };
        let spec = scene.puncture_spec(&Patient::nominal(&scene));
        // The paper's scene reproduces its Table I, and nothing that the paper does not have.
        if scene.id == "lower-back-paper" {
            assert_eq!(spec.hub_stiffness_n_per_m, None);
            continue;
        }
        let length_m = spec.needle_length_m;
        let mut needle = DrivenNeedle::held_over(spec).unwrap();
        let to = |depth_m: f64| Point3::new(0.0, 0.0, -depth_m);
        let ticks = needle.travel(-Vector3::z(), to(-0.001), to(length_m + 0.004));
        let contacts = ticks.iter().flat_map(|tick| &tick.events).filter(|e| **e == PunctureEvent::HubContact).count();
        assert_eq!(contacts, 1, "{}", scene.id);
        let last = ticks.last().unwrap().output;
        assert!(last.hub_n >= 10.0, "{}: {} N stop it 4 mm beyond its end", scene.id, last.hub_n);
        assert!(last.hand_n - last.hub_n - last.axial.total_n() >= -1e-9, "{}: structures push outwards", scene.id);
    }
}

#[test]
fn the_papers_scene_is_table_i_without_friction_or_cutting() {
    let scene = shipped_scene("lower-back-paper.toml");
    let printed: Vec<_> = scene
        .layers
        .iter()
        .map(|l| (l.name.as_str(), l.thickness_mm, l.stiffness_n_per_m, l.damping_n_s_per_m2, l.thickness_spread_mm))
        .collect();
    assert_eq!(
        printed,
        [("skin", 0.8, 331.0, 3.0, 0.1), ("fat", 8.4, 83.0, 1.0, 0.1), ("muscle", 39.0, 497.0, 3.0, 0.1)]
    );
    assert!(scene.layers.iter().all(|l| l.friction_n_per_m == 0.0 && l.cutting_n == 0.0));
}

#[test]
fn the_papers_scene_ruptures_where_the_specification_says() {
    let scene = shipped_scene("lower-back-paper.toml");
    let spec = scene.axial_spec(&Patient::nominal(&scene));
    let ruptures = law::closed_form::predict_ruptures(&spec);
    let places_mm: Vec<_> = ruptures.iter().map(|r| (r.x_m * 1e6).round() / 1e3).collect();
    assert_eq!(places_mm, [3.021, 5.927, 6.824, 10.029, 12.218, 15.023]);
}

#[test]
fn the_training_scene_adds_friction_cutting_and_a_fascia() {
    let scene = shipped_scene("lower-back-training.toml");
    let names: Vec<_> = scene.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["skin", "fat", "fascia", "muscle"]);
    assert!(scene.layers.iter().all(|l| l.friction_n_per_m > 0.0 && l.cutting_n > 0.0));
}

#[test]
fn scene_variants_differ_from_training_as_their_titles_state() {
    let fat = |name: &str| shipped_scene(name).layers[1].thickness_mm;
    let training = fat("lower-back-training.toml");
    assert!(fat("lower-back-lean.toml") < training && training < fat("lower-back-obese.toml"));
    let thick = shipped_scene("lower-back-thick-needle.toml");
    assert_eq!(thick.layers, shipped_scene("lower-back-training.toml").layers);
    assert!(thick.needle.diameter_mm > 2.0);
}

#[test]
fn every_number_of_a_shipped_scene_says_where_it_comes_from() {
    for path in shipped() {
        let Ok(Document::Scene(scene)) = read_document(&path) else { continue };
        assert!(scene.layers.iter().all(|l| !l.source.is_empty()), "{}", scene.id);
    }
}

#[test]
fn the_course_rises_in_difficulty_and_asks_for_what_came_before() {
    let (course, exercises) = course();
    assert!(exercises.len() >= 6);
    assert!(exercises.windows(2).all(|w| w[0].exercise.difficulty <= w[1].exercise.difficulty));
    assert_eq!(course.mastery, MasteryRule::Passes { passes: 3, of: 5 });
    for (at, entry) in course.entries.iter().enumerate() {
        let earlier = |id: &String| course.entries[..at].iter().any(|e| e.exercise == *id);
        assert!(entry.prerequisites.iter().all(earlier), "{}", entry.exercise);
    }
}

#[test]
fn planned_path_reaches_the_target_and_clears_the_vessel() {
    let (_, exercises) = course();
    let bundle = exercises.iter().find(|b| b.exercise.id == "avoid-the-vessel").unwrap();
    let target = &bundle.scene.structures[0].spec;
    assert!((bundle.exercise.target_m() - target.position_m).norm() < 0.1e-3);
    // The vessel runs along y at x = 0, z = −18 mm with a radius of 2 mm.
    let axis = bundle.exercise.axis();
    let distance_mm = (18.0 * axis.x.abs()) - 2.0;
    assert!((2.0..4.0).contains(&distance_mm), "{distance_mm} mm");
}

#[test]
fn attachments_rebuild_the_same_exercise() {
    let (_, exercises) = course();
    for bundle in exercises {
        let rebuilt = ExerciseBundle::from_parts(&bundle.exercise_bytes, &bundle.scene_bytes, &bundle.meshes).unwrap();
        assert_eq!(
            rebuilt,
            ExerciseBundle { pictures: Vec::new(), ..bundle.clone() },
            "a recording carries no pictures"
        );
        let files = bundle.pictures.iter().map(|picture| (picture.name.clone(), picture.bytes.clone()));
        assert_eq!(rebuilt.with_pictures(&files.collect::<Vec<_>>()).unwrap(), bundle);
    }
}

#[test]
fn an_exercises_direction_is_a_unit_vector_into_the_body() {
    let (_, exercises) = course();
    for bundle in &exercises {
        let axis = bundle.exercise.axis();
        assert!((axis.norm() - 1.0).abs() < 1e-15 && axis.z < 0.0, "{}", bundle.exercise.id);
    }
    let oblique = exercises.iter().find(|b| b.exercise.id == "oblique-approach").unwrap().exercise.axis();
    assert!(oblique.x.abs() < 1e-15 && (oblique.y - libm::sin(25.0_f64.to_radians())).abs() < 1e-15, "{oblique}");
}

#[test]
fn rubric_hash_covers_exactly_the_keys_that_affect_the_score() {
    let (_, exercises) = course();
    let exercise = &exercises[1].exercise;
    let hash = exercise.rubric_sha256();
    let mut reworded = exercise.clone();
    reworded.briefing = format!("{} Take your time.", reworded.briefing).into();
    reworded.coaching.clear();
    reworded.time_limit_s += 1.0;
    assert_eq!(reworded.rubric_sha256(), hash);
    let changes: [fn(&mut documents::Exercise); 7] = [
        |e| e.pass_mark += 1.0,
        |e| e.rubric[0].weight += 1.0,
        |e| e.rubric.reverse(),
        |e| e.hard_fails[0].above += 1.0,
        |e| e.rubric[0].version = 2,
        |e| e.hard_fails[0].version = 2,
        |e| e.required = None,
    ];
    for change in changes {
        let mut changed = exercise.clone();
        change(&mut changed);
        assert_ne!(changed.rubric_sha256(), hash);
    }
}
