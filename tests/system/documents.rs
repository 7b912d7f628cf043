//! ARCHITECTURE.md describes the tree that is here. Fails when it names a path that is gone, or misses a member.

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
