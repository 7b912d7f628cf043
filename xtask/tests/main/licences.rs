//! Every dependency may be shipped under MIT OR Apache-2.0, and its licence travels with the programs. Fails when a copyleft or
//! unlicensed crate slips into the graph, when a licence is accepted that nobody has, or when a text is missing.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

use cargo_metadata::Metadata;
use xtask::licences::{ACCEPTED, ACCEPTED_FOR_ONE, may_ship, named};
use xtask::{notices, read_metadata, root};

const PROGRAMS: [&str; 2] = ["stylet", "web-admin"];

fn metadata() -> Metadata {
    read_metadata("").expect("cargo metadata reads the workspace")
}

#[test]
fn every_dependency_may_be_shipped() {
    let refused: Vec<_> = metadata()
        .packages
        .iter()
        .filter(|p| !p.license.as_deref().is_some_and(|licence| may_ship(&p.name, licence)))
        .map(|p| format!("{} {}: {:?}", p.name, p.version, p.license))
        .collect();
    assert!(refused.is_empty(), "not accepted: {refused:#?}");
}

#[test]
fn the_check_reads_brackets_and_binds_and_before_or() {
    for refused in [
        "GPL-3.0-only",
        "MIT AND GPL-2.0",
        "(MIT OR Apache-2.0) AND GPL-3.0-only",
        "GPL-3.0-only AND (MIT OR Apache-2.0)",
        "GPL-3.0-only AND MIT OR AGPL-3.0-only",
        "GPL-2.0-only WITH Classpath-exception-2.0",
        "Apache-2.0 WITH Classpath-exception-2.0",
        "LGPL-3.0-or-later",
        "LicenseRef-ours-alone",
        "MIT OR",
        "",
    ] {
        assert!(!may_ship("some-crate", refused), "{refused}");
    }
    for accepted in [
        "MIT OR GPL-2.0",
        "GPL-3.0-only AND AGPL-3.0-only OR MIT",
        "(MIT OR Apache-2.0) AND Unicode-3.0",
        "Apache-2.0 / MIT",
        "Unlicense/MIT",
        "Apache-2.0 WITH LLVM-exception OR GPL-3.0-only",
    ] {
        assert!(may_ship("some-crate", accepted), "{accepted}");
    }
}

#[test]
fn fonts_are_accepted_where_they_are_meant_to_be() {
    let fonts = "(MIT OR Apache-2.0) AND OFL-1.1 AND Ubuntu-font-1.0";
    assert!(may_ship("epaint_default_fonts", fonts));
    assert!(!may_ship("other-fonts", fonts));
    assert!(!may_ship("epaint_default_fonts", "OFL-1.1 AND GPL-3.0-only"));
}

#[test]
fn nothing_is_accepted_that_nobody_has() {
    let metadata = metadata();
    let had: BTreeSet<(String, String)> = metadata
        .packages
        .iter()
        .flat_map(|p| named(p.license.as_deref().unwrap_or_default()).into_iter().map(|l| (p.name.to_string(), l)))
        .collect();
    for (licence, why) in ACCEPTED {
        assert!(had.iter().any(|(_, one)| one == licence), "no dependency has {licence} ({why})");
    }
    for (package, licence, why) in ACCEPTED_FOR_ONE {
        assert!(had.contains(&((*package).to_owned(), (*licence).to_owned())), "{package}: {licence} ({why})");
    }
}

#[test]
fn notices_hold_a_text_of_everything_that_is_linked() {
    let metadata = metadata();
    let text = notices::notices(&metadata, &PROGRAMS).expect("notices");
    let (list, texts) = text.split_once("====").expect("a list, then texts");
    let packages = notices::shipped(&metadata, &PROGRAMS);
    assert!(packages.len() > 300, "only {} packages", packages.len());
    for package in packages {
        let name = format!("{} {}", package.name, package.version);
        assert!(list.contains(&format!("\n{name}: ")), "{name} is not listed");
        assert!(texts.contains(&name), "{name} has no text");
    }
    assert!(texts.contains("recording (proto/foxglove)"), "the schemas of viewers have no text");
    for part in ["SIL OPEN FONT LICENSE", "UBUNTU FONT LICENCE", "Mozilla Public License", "Facebook", "Unicode, Inc."]
    {
        assert!(texts.contains(part), "{part} is missing");
    }
    assert!(!list.contains("\nfantoccini ") && !list.contains("\nproptest "), "what only tests use is not shipped");
    let service = notices::notices(&metadata, &PROGRAMS[1..]).expect("notices");
    assert!(service.contains("\naxum ") && !service.contains("\nwgpu "), "each program has its own");
    assert!(notices::notices(&metadata, &["nobody"]).is_err());
}

#[test]
fn notices_are_written_for_a_program() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("THIRD-PARTY.txt");
    let write = |program: &str| -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command.arg("notices").arg(&out).arg(program).current_dir(root()).output().expect("it starts")
    };
    let output = write("web-admin");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&out).expect("notices");
    assert!(text.contains("\naxum ") && text.contains("Permission is hereby granted"));
    let output = write("nobody");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("nobody"));
}

/// The notices say that browsers get no code but our own. A library would be fetched from elsewhere, or bring its notice.
#[test]
fn browsers_get_our_own_code_alone() {
    let assets = root().join("web-admin/pages/assets");
    let scripts: Vec<_> = std::fs::read_dir(assets).expect("assets").flatten().map(|entry| entry.path()).collect();
    let is_script = |path: &&Path| path.extension().is_some_and(|ending| ending == "js" || ending == "css");
    let mut seen = 0;
    for path in scripts.iter().map(std::path::PathBuf::as_path).filter(is_script) {
        let text = std::fs::read_to_string(path).expect("a text");
        let lower = text.to_lowercase();
        for foreign in ["@license", "@preserve", "copyright (c)", "sourcemappingurl", "cdn."] {
            assert!(!lower.contains(foreign), "{} contains {foreign:?}", path.display());
        }
        for import in text.lines().filter(|line| line.trim_start().starts_with("import ")) {
            assert!(import.contains("'./"), "{}: {import}", path.display());
        }
        seen += 1;
    }
    assert!(seen > 10, "only {seen} scripts and styles");
}
