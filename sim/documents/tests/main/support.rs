//! Documents in a temporary folder, and where the shipped ones are.

use std::path::{Path, PathBuf};

use documents::load::read_document;
use documents::{Document, DocumentError, Scene};

/// What the reader of a case says when one of its words is another.
pub fn mistake<T: std::fmt::Debug>(
    parse: fn(&str, &str) -> Result<T, DocumentError>,
    case: &str,
    (from, to): (&str, &str),
) -> String {
    assert!(case.contains(from), "{from} is not in the case");
    parse("case.json", &case.replacen(from, to, 1)).unwrap_err().to_string()
}

/// A small scene that is fine as it stands.
pub const SCENE: &str = r#"id = "small"
title = "Small"

[[layer]]
name = "skin"
thickness_mm = 0.8
stiffness_n_per_m = 331
tip_rupture_n = 1.0
rim_rupture_n = 1.3

[[layer]]
name = "fat"
thickness_mm = 8.4
stiffness_n_per_m = 83
damping_n_s_per_m2 = 1
tip_rupture_n = 0.5
rim_rupture_n = 0.6

[needle]
diameter_mm = 2.0
"#;

/// An exercise in `scene.toml` that is fine as it stands.
pub const EXERCISE: &str = r#"id = "one"
title = "One"
scene = "scene.toml"

[target]
depth_mm = 20

[[rubric]]
metric = "depth_error_mm"
full = 0.5
zero = 4
"#;

/// A curriculum of `a.toml` and `b.toml` that is fine as it stands.
pub const CURRICULUM: &str = r#"id = "course"
title = "Course"

[mastery]
rule = "passes"
passes = 3
of = 5

[[exercise]]
file = "a.toml"

[[exercise]]
file = "b.toml"
prerequisites = ["a"]
"#;

/// An instrument that is fine as it stands.
pub const INSTRUMENT: &str = r#"id = "small"
title = { en = "Small", de = "Klein" }
languages = ["en", "de"]
duration_min = 1
source = "made for this test"
licence = "anybody may use it"

[[scale]]
id = "agree"
kind = "likert"
points = 5

[[scale]]
id = "yes-no"
kind = "choice"

[[scale.option]]
id = "yes"
text = { en = "Yes", de = "Ja" }

[[scale.option]]
id = "no"
text = { en = "No", de = "Nein" }

[[scale]]
id = "words"
kind = "text"
max_characters = 200

[[section]]
id = "first"
title = { en = "First", de = "Zuerst" }

[[section]]
id = "second"
title = { en = "Second", de = "Danach" }
when = { item = "again", is = ["no"] }

[[item]]
id = "easy"
section = "first"
text = { en = "It was easy.", de = "Es war leicht." }
scale = "agree"

[[item]]
id = "again"
section = "first"
text = { en = "Again?", de = "Noch einmal?" }
scale = "yes-no"

[[item]]
id = "why"
section = "second"
text = { en = "Why not?", de = "Warum nicht?" }
scale = "words"

[[score]]
id = "ease"
title = { en = "Ease", de = "Leichtigkeit" }
items = ["easy"]
combine = "sum"
"#;

/// A folder with a scene, and the exercises `a` and `b` in it.
pub fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write(&folder, "scene.toml", SCENE);
    for id in ["a", "b"] {
        write(&folder, &format!("{id}.toml"), EXERCISE.replace("\"one\"", &format!("\"{id}\"")));
    }
    folder
}

/// Writes a file of a folder, and says where.
pub fn write(folder: &tempfile::TempDir, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, contents).unwrap();
    path
}

/// Reads a text as a document of that folder.
pub fn read_text(folder: &tempfile::TempDir, text: &str) -> Result<Document, DocumentError> {
    read_document(&write(folder, "document.toml", text))
}

/// Reads a text as a scene.
pub fn scene(text: &str) -> Scene {
    match read_text(&folder(), text) {
        Ok(Document::Scene(scene)) => *scene,
        other => panic!("not a scene: {other:?}"),
    }
}

/// The folder of the shipped documents.
pub fn curricula() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula")
}

/// Every shipped TOML document, in order.
pub fn shipped() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![curricula()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
