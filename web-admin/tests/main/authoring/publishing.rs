//! Publishing. Fails when the same bytes make a second revision, when changed ones do not, or when going back to
//! earlier bytes does not bring the earlier revision back.

use std::fs;
use std::path::Path;

use acts::authoring::publishing;
use acts::authoring::publishing::CourseRefused;
use acts::training::assignments;
use model::Role;
use store::authoring::exercises;

use crate::support::{App, course_folder};

#[tokio::test]
async fn the_same_bytes_are_published_once() {
    let app = App::new().await;
    let school = app.school("North").await;
    let first = app.publish(school).await;
    assert_eq!(first.iter().map(|p| p.kind).filter(|kind| *kind == "exercise").count(), 7);
    assert!(first.iter().all(|published| published.new));
    assert!(app.publish(school).await.iter().all(|published| !published.new));
    let taught = assignments::taught_curricula(&app.state, school).await.unwrap();
    assert_eq!(taught.len(), 1);
    let course = &taught[0].1;
    assert_eq!(course.steps.len(), 7);
    assert_eq!(course.steps[1].prerequisites, ["feel-the-layers"]);
}

/// A copy of the shipped course and its scenes that may be changed.
fn copy_course(to: &Path) {
    for folder in ["lower-back-basics", "scenes"] {
        fs::create_dir_all(to.join(folder)).unwrap();
        for entry in fs::read_dir(course_folder().parent().unwrap().join(folder)).unwrap() {
            let from = entry.unwrap().path();
            fs::copy(&from, to.join(folder).join(from.file_name().unwrap())).unwrap();
        }
    }
}

#[tokio::test]
async fn changed_scene_adds_a_revision_and_a_revert_restores_the_old() {
    let app = App::new().await;
    let school = app.school("North").await;
    let folder = tempfile::tempdir().unwrap();
    copy_course(folder.path());
    let courses = publishing::courses_in(folder.path()).unwrap();
    let now = app.state.clock.now();
    let publish = async || app.write(async |tx| publishing::course(tx, school, &courses[0], now).await.unwrap()).await;
    let current = async || {
        exercises::find_current_revision(app.state.db.reader(), school, "feel-the-layers").await.unwrap().unwrap()
    };
    publish().await;
    let first = current().await;
    let scene = folder.path().join("scenes/lower-back-training.toml");
    let original = fs::read(&scene).unwrap();
    fs::write(&scene, [original.as_slice(), b"\n# another patient\n"].concat()).unwrap();
    let published = publish().await;
    assert!(published.iter().any(|p| p.new && p.id == "feel-the-layers"), "{published:?}");
    assert!(published.iter().any(|p| !p.new && p.kind == "course"), "{published:?}");
    let second = current().await;
    assert_eq!(first.exercise_sha256, second.exercise_sha256);
    assert_ne!((first.id, &first.scene_sha256), (second.id, &second.scene_sha256));
    fs::write(&scene, original).unwrap();
    assert!(publish().await.iter().all(|published| !published.new));
    assert_eq!(current().await, first);
}

#[tokio::test]
async fn a_wrong_document_is_refused_whole() {
    let app = App::new().await;
    let school = app.school("North").await;
    let folder = tempfile::tempdir().unwrap();
    copy_course(folder.path());
    let last = folder.path().join("lower-back-basics/7-thick-fat.toml");
    fs::write(&last, fs::read_to_string(&last).unwrap().replace("pass_mark", "pass_mrk")).unwrap();
    let mut tx = app.state.db.write().await.unwrap();
    let course = folder.path().join("lower-back-basics/course.toml");
    let refused = publishing::course(&mut tx, school, &course, app.state.clock.now()).await.unwrap_err();
    assert!(matches!(&refused, CourseRefused::Document(words) if words.contains("pass_mrk")), "{refused:?}");
    drop(tx);
    assert!(assignments::taught_curricula(&app.state, school).await.unwrap().is_empty());
    app.member(school, Role::Trainee, "ada@example.org").await;
}
