//! ARCHITECTURE.md describes the tree that is here, and SECURITY.md what shows that it holds. Fails when one names a path or an attack
//! that is gone, or misses a member.

use tests::root;

fn architecture() -> String {
    std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md")
}

/// Words in backticks that look like paths of the tree.
fn named_paths(text: &str) -> Vec<&str> {
    let top = ["sim/", "web-admin/", "migrations", "curricula", "tests/", "deploy/", ".ci/", "docs/"];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|word| top.iter().any(|t| word.starts_with(t)) && !word.contains([' ', '*', '<', '{'])).collect()
}

#[test]
fn every_path_it_names_exists() {
    let text = architecture();
    let paths = named_paths(&text);
    assert!(paths.len() > 20, "only {} paths were found in ARCHITECTURE.md", paths.len());
    let gone: Vec<_> = paths.iter().filter(|p| !root().join(p).exists()).collect();
    assert!(gone.is_empty(), "ARCHITECTURE.md names what is gone: {gone:?}");
}

#[test]
fn every_member_and_dependency_is_named() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    let text = architecture();
    let members =
        manifest.lines().skip_while(|l| !l.starts_with("members")).skip(1).take_while(|l| !l.starts_with(']'));
    for member in members.map(|l| l.trim().trim_matches([',', '"'])) {
        assert!(text.contains(&format!("`{member}")), "ARCHITECTURE.md misses the member {member}");
    }
    let section = manifest.split("[workspace.dependencies]").nth(1).and_then(|s| s.split("\n[").next());
    let ours = |name: &str| ["sim", "tests"].iter().any(|folder| root().join(folder).join(name).is_dir());
    for line in section.unwrap_or_default().lines().filter(|l| l.contains(" = ")) {
        let name = line.split(" = ").next().unwrap_or_default();
        let known = ours(name)
            || name == "web-admin"
            || text.contains(&format!("| {name} |"))
            || text.contains(&format!("`{name}`"));
        assert!(known, "ARCHITECTURE.md does not say why {name} is a dependency");
    }
}

/// The attacks of the families in tests/attack, as `family/attack`.
fn attacks() -> Vec<String> {
    let families = std::fs::read_dir(root().join("tests/attack/attacks")).expect("families of attacks");
    let scripts =
        families.flatten().map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "py"));
    let mut found = Vec::new();
    for path in scripts {
        let family = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("a readable script");
        let named = text.lines().filter_map(|line| line.strip_prefix("def attack_")?.split('(').next());
        found.extend(named.map(|attack| format!("{family}/{attack}")));
    }
    found
}

#[test]
fn what_is_said_of_security_names_attacks_and_files_that_exist() {
    let text = std::fs::read_to_string(root().join("SECURITY.md")).expect("SECURITY.md");
    let attacks = attacks();
    let families: Vec<_> = attacks.iter().filter_map(|attack| attack.split('/').next()).collect();
    let is_attack = |word: &&str| word.split_once('/').is_some_and(|(family, _)| families.contains(&family));
    let named: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_attack).collect();
    assert!(named.len() > 40, "only {} attacks are named", named.len());
    let gone: Vec<_> = named.iter().filter(|name| attacks.iter().all(|attack| attack != *name)).collect();
    assert!(gone.is_empty(), "SECURITY.md names attacks that are gone: {gone:?}");
    let paths = named_paths(&text);
    assert!(paths.len() > 20, "only {} paths were found in SECURITY.md", paths.len());
    let gone: Vec<_> = paths.iter().filter(|path| !root().join(path).exists()).collect();
    assert!(gone.is_empty(), "SECURITY.md names what is gone: {gone:?}");
    for chapter in 1..=17 {
        assert!(text.contains(&format!("\n| V{chapter} ")), "SECURITY.md says nothing of chapter V{chapter} of ASVS");
    }
}
