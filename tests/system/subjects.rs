//! The address of a line is its layer and its subject: `store/src/surveys` holds the statements of surveys, `pages/src/surveys` their
//! pages. Fails when a folder of a layer is no subject, or when so much lies beside the folders that nobody finds anything there.
//! That subjects do not use each other in a circle is checked in `style.rs`, with all modules at the top of a crate.

use std::path::Path;

use tests::root;

/// The folders of every layer.
const SUBJECTS: [&str; 13] = [
    "people",
    "auth",
    "stations",
    "recordings",
    "scoring",
    "training",
    "authoring",
    "surveys",
    "studies",
    "privacy",
    "letters",
    "audit",
    "operations",
];

/// The layers, and in each the folders that all subjects share. Add none without a reason in the commit.
const LAYERS: &[(&str, &[&str])] = &[
    ("web-admin/model/src", &[]),
    // The driver for both databases.
    ("web-admin/store/src", &["engine"]),
    // The jobs of the sandboxed helper process.
    ("web-admin/acts/src", &["sandbox_jobs"]),
    ("web-admin/pages/src", &["charts", "samples"]),
    ("web-admin/pages/templates", &["parts"]),
    ("web-admin/routes/base/src", &[]),
    ("web-admin/routes/people/src", &[]),
    ("web-admin/routes/training/src", &[]),
    ("web-admin/routes/scoring/src", &[]),
    ("web-admin/routes/surveys/src", &[]),
    ("web-admin/routes/api/src", &[]),
    ("web-admin/tests/main", &["support"]),
];

/// The most files at the top of a layer.
const MOST_FLAT: usize = 12;

/// The names of the folders and of the files in a folder.
fn entries(folder: &Path) -> [Vec<String>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for entry in std::fs::read_dir(folder).expect("a readable folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        found[usize::from(!entry.path().is_dir())].push(name);
    }
    found
}

#[test]
fn every_layer_has_the_same_subject_folders() {
    for (layer, shared) in LAYERS {
        let [folders, _] = entries(&root().join(layer));
        let other: Vec<_> =
            folders.iter().filter(|f| !SUBJECTS.contains(&f.as_str()) && !shared.contains(&f.as_str())).collect();
        assert!(other.is_empty(), "{layer}: {other:?} are no subjects; these are: {SUBJECTS:?}");
        let unused: Vec<_> = shared.iter().filter(|name| !folders.iter().any(|f| f == *name)).collect();
        assert!(unused.is_empty(), "{layer} has no folders {unused:?}: remove them from the list");
    }
}

#[test]
fn few_files_lie_beside_the_subject_folders() {
    for (layer, _) in LAYERS {
        let [_, files] = entries(&root().join(layer));
        let flat = files.len();
        assert!(flat <= MOST_FLAT, "{layer} has {flat} files beside its folders, at most {MOST_FLAT}: {files:?}");
    }
}

#[test]
fn no_subject_is_known_to_one_layer_alone() {
    for subject in SUBJECTS {
        let layers: Vec<_> = LAYERS.iter().filter(|(layer, _)| root().join(layer).join(subject).is_dir()).collect();
        assert!(layers.len() > 1, "{subject} is a folder of {layers:?} alone");
    }
}
