//! The invariants of ARCHITECTURE.md, most of them absences. Each fails when somebody opens a door that was kept shut:
//! an import across a boundary, SQL outside the storage, a second reader of the clock, a file that became two rooms.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use cargo_metadata::{DependencyKind, Metadata};
use tests::{metadata, metadata_with, root};

/// Which of our crates a crate may use. A crate that is not listed here may use none.
const ALLOWED: &[(&str, &[&str])] = &[
    ("phrase", &[]),
    ("law", &["phrase"]),
    ("tissue", &["law", "phrase"]),
    ("anatomy", &["law", "phrase"]),
    ("guidance", &["anatomy", "law", "phrase"]),
    ("trials", &["law", "tissue"]),
    ("documents", &["anatomy", "law", "phrase", "tissue"]),
    ("recording", &["law"]),
    ("columnar", &["recording"]),
    ("attempt", &["anatomy", "documents", "guidance", "law", "phrase", "recording", "tissue"]),
    ("assessment", &["attempt", "documents", "law", "phrase", "recording", "tissue"]),
    ("dossier", &["documents", "law", "phrase"]),
    (
        "bench",
        &[
            "anatomy",
            "assessment",
            "attempt",
            "documents",
            "dossier",
            "haptics",
            "law",
            "phrase",
            "recording",
            "render",
            "tissue",
            "trials",
        ],
    ),
    ("haptics", &["law", "phrase"]),
    ("render", &["phrase"]),
    (
        "stylet",
        &[
            "anatomy",
            "assessment",
            "attempt",
            "bench",
            "columnar",
            "documents",
            "dossier",
            "guidance",
            "haptics",
            "law",
            "phrase",
            "recording",
            "render",
            "tissue",
            "words",
        ],
    ),
    ("python", &["assessment", "attempt", "documents", "recording", "tissue"]),
    ("words", &["phrase"]),
    ("model", &["assessment", "attempt", "documents", "law", "phrase", "recording", "tissue", "words"]),
    ("store", &["assessment", "attempt", "documents", "model", "recording", "words"]),
    ("platform", &["model", "store"]),
    (
        "acts",
        &[
            "assessment",
            "attempt",
            "documents",
            "law",
            "model",
            "phrase",
            "platform",
            "recording",
            "store",
            "tissue",
            "words",
        ],
    ),
    (
        "pages",
        &["assessment", "attempt", "documents", "dossier", "law", "model", "phrase", "recording", "tissue", "words"],
    ),
    ("routes-base", &["acts", "documents", "model", "pages", "platform", "store", "words"]),
    ("routes-people", &["acts", "model", "pages", "platform", "routes-base", "store", "words"]),
    (
        "routes-training",
        &["acts", "assessment", "documents", "dossier", "model", "pages", "routes-base", "store", "words"],
    ),
    (
        "routes-scoring",
        &[
            "acts",
            "assessment",
            "attempt",
            "documents",
            "law",
            "model",
            "pages",
            "platform",
            "routes-base",
            "store",
            "words",
        ],
    ),
    ("routes-surveys", &["acts", "assessment", "documents", "model", "pages", "routes-base", "store", "words"]),
    ("routes-api", &["acts", "assessment", "documents", "model", "platform", "routes-base", "store"]),
    ("worker", &["acts", "model", "pages", "platform", "routes-base", "store", "words"]),
    (
        "demo",
        &[
            "acts",
            "assessment",
            "attempt",
            "documents",
            "law",
            "model",
            "platform",
            "recording",
            "routes-base",
            "store",
            "tissue",
            "worker",
        ],
    ),
    (
        "web-admin",
        &[
            "acts",
            "attempt",
            "columnar",
            "demo",
            "model",
            "pages",
            "platform",
            "recording",
            "routes-api",
            "routes-base",
            "routes-people",
            "routes-scoring",
            "routes-surveys",
            "routes-training",
            "store",
            "worker",
        ],
    ),
    (
        "tests",
        &[
            "acts",
            "assessment",
            "attempt",
            "documents",
            "law",
            "model",
            "platform",
            "recording",
            "store",
            "stylet",
            "web-admin",
            "xtask",
        ],
    ),
];

/// What must stay out of a crate, however it comes in.
const NEVER: &[(&str, &[&str])] = &[
    ("law", &["tokio", "axum", "sqlx", "wgpu", "winit", "mcap", "tracing", "time"]),
    ("tissue", &["tokio", "axum", "sqlx", "wgpu", "winit", "mcap", "tracing", "time"]),
    ("anatomy", &["tokio", "axum", "sqlx", "wgpu", "winit", "mcap", "tracing", "time"]),
    ("xtask", &["tokio", "axum", "sqlx", "wgpu", "winit"]),
    ("trials", &["tokio", "axum", "sqlx", "wgpu", "winit", "mcap", "tracing", "time"]),
    ("bench", &["tokio", "axum", "sqlx", "winit", "egui"]),
    ("documents", &["tokio", "axum", "sqlx", "wgpu", "winit", "mcap"]),
    ("recording", &["axum", "sqlx", "wgpu", "winit"]),
    ("attempt", &["axum", "sqlx", "wgpu", "winit", "tokio"]),
    ("assessment", &["axum", "sqlx", "wgpu", "winit"]),
    ("haptics", &["axum", "sqlx", "wgpu", "winit", "mcap", "tokio"]),
    ("render", &["axum", "sqlx", "mcap", "winit", "egui", "tokio"]),
    ("python", &["axum", "sqlx", "wgpu", "winit", "egui", "tokio"]),
    ("words", &["axum", "sqlx", "askama", "tokio"]),
    ("store", &["axum", "askama", "tower-sessions"]),
    ("platform", &["axum", "askama", "tower-sessions", "wgpu"]),
    ("acts", &["axum", "askama", "wgpu"]),
    // Cargo joins features: where the store is built, too, the model has its columns, and so has whoever uses it.
    ("pages", &["store", "acts"]),
    ("web-admin", &["wgpu", "winit", "egui"]),
    ("stylet", &["axum", "sqlx"]),
];

/// The normal dependencies of every package, by name.
pub(crate) fn edges(metadata: &Metadata) -> BTreeMap<String, BTreeSet<String>> {
    let graph = metadata.resolve.as_ref().expect("a resolved graph");
    let mut edges = BTreeMap::new();
    for node in &graph.nodes {
        let normal = node.deps.iter().filter(|d| d.dep_kinds.iter().any(|k| k.kind == DependencyKind::Normal));
        let names: BTreeSet<_> = normal.map(|d| metadata[&d.pkg].name.to_string()).collect();
        edges.entry(metadata[&node.id].name.to_string()).or_insert_with(BTreeSet::new).extend(names);
    }
    edges
}

/// Every package that one depends on, directly or indirectly.
pub(crate) fn reachable(from: &str, edges: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from.to_owned()];
    while let Some(name) = open.pop() {
        for next in edges.get(&name).into_iter().flatten() {
            if seen.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    seen
}

#[test]
fn crates_use_only_the_crates_they_may() {
    let metadata = metadata_with("stylet/reports");
    let members: BTreeSet<_> = metadata.workspace_packages().iter().map(|p| p.name.to_string()).collect();
    let allowed: BTreeMap<_, _> = ALLOWED.iter().map(|(name, may)| (*name, *may)).collect();
    for (name, used) in edges(&metadata).iter().filter(|(name, _)| members.contains(*name)) {
        let may = allowed.get(name.as_str()).copied().unwrap_or_default();
        let forbidden: Vec<_> = used.iter().filter(|u| members.contains(*u) && !may.contains(&u.as_str())).collect();
        assert!(forbidden.is_empty(), "{name} may not use {forbidden:?}");
    }
}

#[test]
fn nothing_forbidden_comes_in_by_the_back_door() {
    let edges = edges(&metadata_with("stylet/reports"));
    for (name, never) in NEVER {
        let reached = reachable(name, &edges);
        let forbidden: Vec<_> = never.iter().filter(|n| reached.contains(**n)).collect();
        assert!(forbidden.is_empty(), "{name} must never see {forbidden:?}");
    }
}

/// Every package that Cargo compiles for `what`, as `name version`. `cargo metadata` also lists optional packages that no feature enables.
fn compiled(what: &[&str]) -> BTreeSet<String> {
    let arguments = [&["tree", "--locked", "--prefix=none", "--format={p}"], what].concat();
    let output = Command::new(env!("CARGO")).args(&arguments).current_dir(root()).output().expect("cargo tree runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let words = |line: &str| line.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
    String::from_utf8_lossy(&output.stdout).lines().map(words).collect()
}

#[test]
fn heavy_dependencies_exist_once() {
    let compiled = compiled(&["--workspace", "--edges=normal,build"]);
    for name in ["nalgebra", "glam", "parry3d-f64", "axum", "sqlx-core", "tower-sessions", "mcap", "prost", "tokio"] {
        let copies: Vec<_> = compiled.iter().filter(|c| c.starts_with(&format!("{name} "))).collect();
        assert_eq!(copies.len(), 1, "one copy of {name} is wanted: {copies:?}");
    }
}

/// The most packages that Cargo compiles for the tests of a crate. Raise a number only with a reason in the commit.
const MOST_PACKAGES: &[(&str, usize)] = &[("law", 100), ("tissue", 100), ("recording", 120), ("documents", 150)];

#[test]
fn tests_below_the_client_compile_little_and_no_window() {
    for (name, most) in MOST_PACKAGES {
        let compiled = compiled(&["--package", name, "--edges=normal,build,dev"]);
        assert!(
            compiled.len() <= *most,
            "the tests of {name} need {} packages, at most {most}: {compiled:?}",
            compiled.len()
        );
        let drawing = ["wgpu ", "render ", "winit ", "egui "];
        let drawn: Vec<_> = compiled.iter().filter(|c| drawing.iter().any(|d| c.starts_with(d))).collect();
        assert!(drawn.is_empty(), "the tests of {name} compile {drawn:?}");
    }
}

/// Every Rust source of the workspace, with its path from the root.
pub(crate) fn sources() -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for folder in ["sim", "web-admin", "xtask", "tests"] {
        collect(&root().join(folder), &mut found);
    }
    assert!(found.len() > 20, "the walk found only {} sources", found.len());
    found
}

fn collect(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let text = std::fs::read_to_string(&path).expect("a readable source");
            found.push((path.strip_prefix(root()).expect("below the root").to_path_buf(), text));
        }
    }
}

/// What has no unit tests is not compiled once more for them, and what has no examples is not read once more for those.
#[test]
fn no_unit_test_or_example_is_left_out() {
    let (metadata, sources) = (metadata(), sources());
    let targets = metadata.workspace_packages().into_iter().flat_map(|package| &package.targets);
    let libraries: Vec<_> = targets.filter(|target| target.is_lib() || target.is_cdylib()).collect();
    assert!(libraries.iter().filter(|library| !library.test).count() >= 4, "{libraries:?}");
    for library in libraries {
        let folder = library.src_path.parent().expect("a folder");
        for (path, text) in sources.iter().filter(|(path, _)| root().join(path).starts_with(folder)) {
            let path = path.display();
            assert!(library.test || !text.contains("#[test]"), "{path} is never run: its library has `test = false`");
            assert!(library.doctest || !has_example(text), "{path}: an example is never run: `doctest = false`");
        }
    }
}

/// Whether the documentation in a source holds a block of Rust: one that does not say that it is something else.
fn has_example(source: &str) -> bool {
    let lines = source.lines().map(str::trim_start);
    let documentation = lines.filter_map(|line| line.strip_prefix("/// ").or_else(|| line.strip_prefix("//! ")));
    // One fence opens a block, the next closes it.
    let mut blocks = documentation.filter_map(|line| line.strip_prefix("```")).step_by(2);
    blocks.any(|kind| kind.is_empty() || kind.starts_with("rust"))
}

/// Sources of a crate's library or program, without its tests, below `folder`.
fn shipped(folder: &str) -> impl Iterator<Item = (PathBuf, String)> {
    let sources = sources().into_iter();
    let below: Vec<_> = sources.filter(|(path, _)| path.starts_with(folder)).collect();
    assert!(!below.is_empty(), "{folder} holds no sources");
    below.into_iter()
}

/// The crates of the service, but for the one that is named.
pub(crate) fn service_but(crate_name: &str) -> Vec<(PathBuf, String)> {
    let sources = shipped("web-admin").filter(|(path, _)| path.components().any(|part| part.as_os_str() == "src"));
    sources.filter(|(path, _)| !path.starts_with(Path::new("web-admin").join(crate_name))).collect()
}

#[test]
fn only_the_store_speaks_sql() {
    for (path, text) in service_but("store") {
        for word in ["SELECT ", "INSERT INTO", "UPDATE ", "DELETE FROM", "sqlx::query"] {
            assert!(!text.contains(word), "{} contains {word:?}: SQL belongs in the store", path.display());
        }
    }
}

#[test]
fn only_acts_open_a_write_transaction() {
    for (path, text) in service_but("acts") {
        let opens = text.contains("db.write()") || text.contains(".write().await");
        let is_store = path.starts_with("web-admin/store");
        assert!(!opens || is_store, "{} opens a write transaction: that is an act", path.display());
    }
}

#[test]
fn only_the_clock_reads_the_clock() {
    for (path, text) in sources() {
        let name = path.file_name().unwrap_or_default();
        let measures = path.components().any(|c| ["benches", "tests", "system"].iter().any(|m| c.as_os_str() == *m));
        if name == "clock.rs" || measures || path == Path::new("tests/system/house.rs") {
            continue;
        }
        for call in ["SystemTime::now", "Instant::now", "now_utc()", "now_v7()"] {
            assert!(!text.contains(call), "{} calls {call}: the clock is a parameter", path.display());
        }
    }
}

#[test]
fn mechanics_start_no_thread() {
    for (path, text) in
        ["sim/law/src", "sim/tissue/src", "sim/anatomy/src", "sim/guidance/src"].into_iter().flat_map(shipped)
    {
        assert!(!text.contains("thread::"), "{} starts a thread: its callers may", path.display());
    }
}

#[test]
fn one_module_answers_refused_forms() {
    for (path, text) in shipped("web-admin/src").chain(shipped("web-admin/routes")) {
        let inside = path.ends_with("base/src/error.rs") || path.ends_with("base/src/forms.rs");
        assert!(inside || !text.contains("UNPROCESSABLE_ENTITY"), "{}: use FormAnswer::Refused", path.display());
    }
}

#[test]
fn every_form_has_a_limit_of_fields() {
    let reads_a_form =
        |text: &str| ["extract::Form;", "extract::{Form", ", Form,", "RawForm"].iter().any(|name| text.contains(name));
    for (path, text) in shipped("web-admin/src").chain(shipped("web-admin/routes")) {
        let inside = path.ends_with("base/src/auth/csrf.rs");
        assert!(inside || !reads_a_form(&text), "{}: take CsrfForm or OpenForm", path.display());
    }
}

#[test]
fn one_module_knows_parry() {
    for (path, text) in shipped("sim/law/src").chain(shipped("sim/tissue/src")) {
        let inside = path.starts_with("sim/law/src/structures") || path.ends_with("structures.rs");
        assert!(inside || !text.contains("parry3d_f64::"), "{} names parry3d", path.display());
    }
}

/// Calls by which a program takes a text apart.
const TAKES_APART: [&str; 8] =
    ["strip_prefix", "strip_suffix", "split_once", "rsplit_once", "starts_with", "ends_with", "contains", "replacen"];

/// Texts with a word and a space in them by which some code takes another text apart.
fn sentences_read_in(code: &str) -> Vec<String> {
    let is_word = |word: &str| word.len() > 1 && word.chars().all(char::is_alphabetic);
    let literals = TAKES_APART.iter().flat_map(|call| {
        let begins = format!(".{call}(\"");
        let after: Vec<&str> = code.split(&begins).skip(1).collect();
        after.into_iter().filter_map(|rest| rest.split('"').next())
    });
    literals.filter(|text| text.contains(' ') && text.split([' ', ',', ':']).any(is_word)).map(str::to_owned).collect()
}

#[test]
fn no_code_reads_a_sentence_to_find_out_what_it_means() {
    assert_eq!(
        sentences_read_in("why.strip_suffix(\" too deep\"); id.split_once('.'); a.contains(\"x_mm\")"),
        [" too deep"]
    );
    for folder in ["sim/assessment/src", "sim/attempt/src", "sim/recording/src", "sim/documents/src", "web-admin"] {
        for (path, text) in shipped(folder) {
            let shown = path.to_string_lossy();
            // A scanner and a learning platform of other people answer in words.
            let of_others = ["platform/src/scanning.rs", "model/src/auth/grade_service.rs"];
            if ["/tests/", "tests.rs", "samples.rs", "src/cli/"]
                .iter()
                .chain(&of_others)
                .any(|excepted| shown.contains(excepted))
            {
                continue;
            }
            let found = sentences_read_in(text.split("#[cfg(test)]").next().unwrap_or_default());
            assert!(found.is_empty(), "{shown} takes sentences apart: {found:?}");
        }
    }
}

#[test]
fn nothing_impossible_becomes_a_silent_value() {
    let silent = |text: &str| {
        let one_line = text.lines().map(str::trim).collect::<String>();
        let attempts =
            ["::try_from(", ".try_into("].iter().flat_map(|name| one_line.match_indices(name).collect::<Vec<_>>());
        let is_silent = |(at, name): &(usize, &str)| {
            let (mut open, rest) = (1, &one_line[at + name.len()..]);
            let end = rest.find(|c| {
                open += i32::from(c == '(') - i32::from(c == ')');
                open == 0
            });
            end.is_some_and(|end| rest[end + 1..].starts_with(".unwrap_or"))
        };
        attempts.filter(is_silent).map(|(at, _)| one_line[at..].chars().take(60).collect()).collect::<Vec<String>>()
    };
    assert_eq!(silent("u32::try_from(f(x))\n    .unwrap_or(u32::MAX)").len(), 1);
    assert_eq!(silent("usize::try_from(x).ok().unwrap_or_default()").len(), 0);
    for folder in ["sim", "web-admin"] {
        for (path, text) in shipped(folder) {
            let found = silent(text.split("#[cfg(test)]").next().unwrap_or_default());
            assert!(found.is_empty(), "{}: an error, or an expect with its reason: {found:?}", path.display());
        }
    }
}

#[test]
fn files_are_one_room_each() {
    for (path, text) in sources() {
        let lines = text.lines().count();
        assert!(lines <= 500, "{} has {lines} lines: probably two rooms", path.display());
    }
}
