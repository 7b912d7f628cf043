//! `stylet validate`: the committed dossier and the summaries of it are the output of the command. Fails when a scene or a figure changes and
//! the documents do not, and when a file that is no scene is taken for one.
//! `STYLET_UPDATE_DOCS=1` writes the committed dossier anew.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::path::Path;

use dossier::{make_dossiers, read_shipped_scenes, summarise_dossiers};
use tempfile::TempDir;

use crate::{repository, stylet, text};

fn names(folder: &Path) -> BTreeSet<OsString> {
    fs::read_dir(folder).expect("a folder").map(|file| file.expect("a file").file_name()).collect()
}

#[test]
fn committed_dossier_is_what_the_command_writes() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("made");
    stylet(&["validate", "--out", text(&out)]).ends(0);
    let committed = repository("docs/dossier");
    if std::env::var_os("STYLET_UPDATE_DOCS").is_some() {
        fs::remove_dir_all(&committed).expect("it is committed");
        fs::create_dir(&committed).expect("it can be made");
        for name in names(&out) {
            fs::copy(out.join(&name), committed.join(&name)).expect("it can be written");
        }
    }
    assert_eq!(names(&out), names(&committed), "STYLET_UPDATE_DOCS=1 makes it anew");
    for name in names(&out) {
        let [made, kept] = [&out, &committed].map(|folder| fs::read_to_string(folder.join(&name)).expect("a text"));
        assert!(kept == made, "{} is outdated: STYLET_UPDATE_DOCS=1 makes it anew", name.display());
    }
}

#[test]
fn documents_state_the_summary_of_the_dossier() {
    let summary = summarise_dossiers(&make_dossiers(&read_shipped_scenes().expect("the shipped scenes are sound")));
    for page in ["README.md", "docs/measurements.md"] {
        let text = fs::read_to_string(repository(page)).expect(page);
        assert!(text.contains(&summary), "{page} lacks: {summary}");
    }
}

#[test]
fn one_scene_is_printed_and_what_is_no_scene_is_refused() {
    let scene = repository("curricula/scenes/epidural-71kg.toml");
    let told = stylet(&["validate", text(&scene)]).ends(0);
    assert!(told.stdout.contains("| epidural-71kg |") && !told.stdout.contains("lower-back"), "{}", told.stdout);
    let exercise = repository("curricula/lower-back-basics/1-feel-the-layers.toml");
    stylet(&["validate", text(&exercise)]).ends(2).says(&["1-feel-the-layers.toml:7:1", "scene: unknown key"]);
    stylet(&["validate", "no-such.toml"]).refused(&["no-such.toml"]);
}
