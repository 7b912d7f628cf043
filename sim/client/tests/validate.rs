//! `stylet validate`: the committed dossier and the comparison in docs/measurements.md are the output of the command. Fails when a scene or a
//! figure changes and the documents do not, and when a file that is no scene is taken for one.
//! `STYLET_UPDATE_DOCS=1` writes the committed dossier anew.

use std::fs;

use dossier::{list_comparison_lines, make_dossiers, read_shipped_scenes};
use tempfile::TempDir;

use crate::{repository, stylet, text};

const FILES: [&str; 3] = ["dossier.md", "dossier.csv", "dossier.svg"];

#[test]
fn the_committed_dossier_is_what_the_command_says() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().join("made");
    stylet(&["validate", "--out", text(&out)]).ends(0);
    let committed = repository("docs/dossier");
    for file in FILES {
        let made = fs::read_to_string(out.join(file)).expect("it is written");
        if std::env::var_os("STYLET_UPDATE_DOCS").is_some() {
            fs::write(committed.join(file), &made).expect("it can be written");
        }
        let kept = fs::read_to_string(committed.join(file)).expect("it is committed");
        assert!(kept == made, "{file} is of another day: STYLET_UPDATE_DOCS=1 makes it anew");
    }
}

#[test]
fn the_measurements_have_the_six_lines_of_the_comparison() {
    let lines = list_comparison_lines(&make_dossiers(&read_shipped_scenes().expect("the shipped scenes are sound")));
    assert_eq!(lines.len(), 6);
    let page = fs::read_to_string(repository("docs/measurements.md")).expect("docs/measurements.md");
    for line in lines {
        assert!(page.contains(&line), "docs/measurements.md lacks\n{line}");
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
