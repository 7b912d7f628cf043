//! The last table of `docs/documents.md` lists the metrics that a rubric may name. It is made from the catalogue; fails when it is not that
//! of today (`STYLET_UPDATE_DOCS=1 cargo test --workspace --test system metrics` writes it).

use std::fmt::Write;

use assessment::Direction;
use assessment::catalogue::{DEFINITIONS, Definition, Split};
use tests::root;

/// What stands before and behind the table.
const BEGIN: &str = "<!-- made from the catalogue of metrics -->\n";
const END: &str = "<!-- until here -->\n";

/// How a rubric names a metric.
fn ids(definition: &Definition) -> String {
    let suffix = definition.split.map(|split| match split {
        Split::Layer => "LAYER",
        Split::Boundary => "LAYER.tip`, `….rim",
        Split::Kind => "KIND",
        Split::Structure => "STRUCTURE",
    });
    let split = suffix.map(|suffix| format!("`{}.{suffix}`", definition.id));
    let plain = definition.plain.then(|| format!("`{}`", definition.id));
    plain.into_iter().chain(split).collect::<Vec<_>>().join(", ")
}

fn metrics_table() -> String {
    let mut text =
        String::from("\n| metric | version | unit | better | definition | offered |\n|---|---|---|---|---|---|\n");
    for metric in DEFINITIONS {
        let better = match metric.direction {
            Direction::Lower => "lower",
            Direction::Higher => "higher",
            Direction::Range => "near 0",
        };
        let offered = if metric.unoffered.is_empty() { "yes".to_owned() } else { format!("no: {}", metric.unoffered) };
        let Definition { version, unit, definition, .. } = metric;
        writeln!(text, "| {} | {version} | {unit} | {better} | {definition} | {offered} |", ids(metric))
            .expect("a text grows");
    }
    text + "\n"
}

#[test]
fn its_table_is_that_of_the_catalogue() {
    let path = root().join("docs/documents.md");
    let text = std::fs::read_to_string(&path).expect("docs/documents.md");
    let (before, rest) = text.split_once(BEGIN).expect("the mark where the table begins");
    let (found, after) = rest.split_once(END).expect("the mark where the table ends");
    let made = metrics_table();
    if std::env::var_os("STYLET_UPDATE_DOCS").is_some() {
        std::fs::write(&path, [before, BEGIN, &made, END, after].concat()).expect("docs/documents.md");
    } else {
        let how = "STYLET_UPDATE_DOCS=1 cargo test --workspace --test system metrics";
        assert!(found == made, "docs/documents.md is not of today: {how}");
    }
}
