//! The notices that must travel with our programs: the licence of everything that is linked into them.
//!
//! Texts are taken from the packages themselves, the same text once. A package that names a licence and ships no text gets
//! SPDX's own. Build scripts and tools are not linked and not listed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use cargo_metadata::{DependencyKind, Metadata, Package, PackageId};

use crate::licences;

/// How deep below a package licences are looked for: of fonts, or of a C library it brings.
const DEPTH: usize = 3;

const HEAD: &str = "\
Third-party software in Stylet

Stylet itself is licensed under MIT OR Apache-2.0, see LICENSE-MIT and LICENSE-APACHE. Its programs contain the packages below,
in the versions that Cargo.lock names, unchanged; their sources are at the addresses given and on crates.io. Files of others in our own
packages are named with their licences below the list. The pages that
the service sends to browsers contain no code but Stylet's own. The Rust standard library is contained under
MIT OR Apache-2.0 (https://github.com/rust-lang/rust). SQLite, within libsqlite3-sys, is in the public domain.
";

/// The packages of others that are linked into some of our programs, by name and version.
#[must_use]
pub fn shipped<'a>(metadata: &'a Metadata, programs: &[&str]) -> Vec<&'a Package> {
    linked(metadata, programs).into_iter().filter(|package| package.source.is_some()).collect()
}

/// The packages that are linked into some of our programs, ours among them, by name and version.
fn linked<'a>(metadata: &'a Metadata, programs: &[&str]) -> Vec<&'a Package> {
    let ours = metadata.workspace_packages();
    let mut open: Vec<&PackageId> =
        ours.iter().filter(|package| programs.contains(&package.name.as_str())).map(|package| &package.id).collect();
    let mut seen: BTreeSet<&PackageId> = open.iter().copied().collect();
    let nodes = metadata.resolve.iter().flat_map(|graph| &graph.nodes);
    let nodes: BTreeMap<&PackageId, _> = nodes.map(|node| (&node.id, node)).collect();
    while let Some(id) = open.pop() {
        let linked = nodes.get(id).into_iter().flat_map(|node| &node.deps);
        let linked = linked.filter(|dep| dep.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal));
        open.extend(linked.map(|dep| &dep.pkg).filter(|package| seen.insert(package)));
    }
    let mut found: Vec<_> = seen.into_iter().map(|id| &metadata[id]).collect();
    found.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    found
}

/// The notices of some of our programs.
///
/// # Errors
/// When a package has no licence that may be shipped, or no text can be found for it.
pub fn notices(metadata: &Metadata, programs: &[&str]) -> Result<String, String> {
    let packages = shipped(metadata, programs);
    if packages.is_empty() {
        return Err(format!("no package is linked into {}", programs.join(" and ")));
    }
    let mut text = HEAD.to_owned();
    let mut licences = Licences::default();
    for package in packages {
        let licence = package.license.as_deref().unwrap_or_default();
        if !licences::may_ship(&package.name, licence) {
            return Err(format!("{} {}: {licence:?} may not be shipped", package.name, package.version));
        }
        let source = package.repository.as_deref().unwrap_or("https://crates.io");
        // Writing to a text cannot fail.
        let _ = write!(text, "\n{} {}: {licence}, {source}", package.name, package.version);
        licences.add(package)?;
    }
    text.push('\n');
    for package in linked(metadata, programs).into_iter().filter(|package| package.source.is_none()) {
        licences.add_vendored(package)?;
    }
    licences.print(&mut text);
    Ok(text)
}

/// Texts of licences, each once, with those it is from. Two that differ in white space alone are the same.
#[derive(Default)]
struct Licences {
    by_words: BTreeMap<String, (String, Vec<String>)>,
}

impl Licences {
    fn add(&mut self, package: &Package) -> Result<(), String> {
        let name = format!("{} {}", package.name, package.version);
        let folder = package.manifest_path.parent().map(|folder| folder.as_std_path().to_owned()).unwrap_or_default();
        let mut files = Vec::new();
        find(&folder, DEPTH, &mut files);
        files.extend(package.license_file().map(|file| file.into_std_path_buf()).filter(|file| !files.contains(file)));
        files.sort();
        for file in &files {
            self.add_text(&name, &read_text(file)?);
        }
        if files.is_empty() { self.add_standard(&name, package) } else { Ok(()) }
    }

    /// Adds the licences of files of others in a package of ours: those in its subfolders.
    fn add_vendored(&mut self, package: &Package) -> Result<(), String> {
        let folder = package.manifest_path.parent().map(|folder| folder.as_std_path()).unwrap_or(Path::new("."));
        let mut files = Vec::new();
        find(folder, DEPTH, &mut files);
        for file in files.iter().filter(|file| file.parent() != Some(folder)) {
            let place = file.parent().and_then(|place| place.strip_prefix(folder).ok()).unwrap_or(file);
            self.add_text(&format!("{} ({})", package.name, place.display()), &read_text(file)?);
        }
        Ok(())
    }

    fn add_standard(&mut self, name: &str, package: &Package) -> Result<(), String> {
        let licence = package.license.as_deref().unwrap_or_default();
        let texts: Vec<_> = licences::named(licence).iter().filter_map(|id| spdx::license_id(id)).collect();
        if texts.is_empty() {
            return Err(format!("{name}: no text is known of {licence:?}"));
        }
        for id in texts {
            self.add_text(&format!("{name} (by {}; SPDX's text)", package.authors.join(", ")), id.text());
        }
        Ok(())
    }

    fn add_text(&mut self, name: &str, text: &str) {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let (_, from) = self.by_words.entry(words).or_insert_with(|| (text.replace('\r', ""), Vec::new()));
        if from.last().is_none_or(|last| last != name) {
            from.push(name.to_owned());
        }
    }

    fn print(&self, out: &mut String) {
        for (text, from) in self.by_words.values() {
            let _ =
                write!(out, "\n{}\n{}\n\n{}\n", "=".repeat(80), from.join(", "), text.trim_matches('\n').trim_end());
        }
    }
}

fn read_text(file: &Path) -> Result<String, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Files below a folder that look like a licence or a notice.
fn find(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().to_lowercase());
        if path.is_dir() && depth > 1 && name != "tests" && name != "benches" {
            find(&path, depth - 1, files);
        } else if path.is_file() && is_licence(&name) {
            files.push(path);
        }
    }
}

fn is_licence(name: &str) -> bool {
    let begins = ["license", "licence", "copying", "copyright", "notice", "unlicense", "ofl", "ufl"];
    let source = [".rs", ".c", ".h", ".toml", ".json"];
    begins.iter().any(|word| name.starts_with(word)) && !source.iter().any(|ending| name.ends_with(ending))
}
