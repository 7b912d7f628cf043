//! `docs/documents.md` lists every key of every document. Its tables are generated from the
//! reader's description ([`crate::describe`]); the test fails if they are out of date.
//! `STYLET_UPDATE_DOCS=1 cargo test --workspace --lib handbook` regenerates them.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::describe::{
    CURRICULUM, DescribedField, DescribedTable, EXERCISE, FieldKind, INSTRUMENT, Presence, SCENE, SEGMENTATION,
};

/// Markers before and after the generated tables.
const BEGIN: &str = "<!-- made from what the reader of documents knows -->\n";
const END: &str = "<!-- until here -->\n";

/// Every kind of document with its top-level table.
const KINDS: [(&str, &DescribedTable); 5] = [
    ("scene", &SCENE),
    ("exercise", &EXERCISE),
    ("curriculum", &CURRICULUM),
    ("instrument", &INSTRUMENT),
    ("labels of a segmentation", &SEGMENTATION),
];

/// Returns the headings and tables of all documents.
fn handbook_tables() -> String {
    let mut text = String::new();
    for (kind, table) in KINDS {
        let name = kind[..1].to_uppercase() + &kind[1..];
        writeln!(text, "\n## {name}").unwrap();
        let mut told = Vec::new();
        write_table(&mut text, table, "", &mut told);
    }
    text.push('\n');
    text
}

/// Writes a table and then its subtables, each once: all multilingual text fields share one
/// subtable.
fn write_table(text: &mut String, table: &'static DescribedTable, place: &str, told: &mut Vec<*const DescribedTable>) {
    write!(text, "\n{}.\n\n| key | value | left out | meaning |\n|---|---|---|---|\n", table.doc).unwrap();
    for field in table.fields {
        let (value, left_out) = (allowed_value(field), left_out(field));
        writeln!(text, "| `{}` | {value} | {left_out} | {} |", field.key, field.doc).unwrap();
    }
    for field in table.fields {
        if let Some((inner, head)) =
            inner_table(field, place).filter(|(inner, _)| !told.contains(&std::ptr::from_ref(*inner)))
        {
            told.push(inner);
            writeln!(text, "\n### `{head}`").unwrap();
            write_table(text, inner, &inner_place(field, place), told);
        }
    }
}

fn inner_place(field: &DescribedField, place: &str) -> String {
    if place.is_empty() { field.key.to_owned() } else { format!("{place}.{}", field.key) }
}

/// Returns the table that a field holds, and its heading.
fn inner_table(field: &DescribedField, place: &str) -> Option<(&'static DescribedTable, String)> {
    let path = inner_place(field, place);
    match field.kind {
        FieldKind::Table(inner) | FieldKind::Words { table: inner, .. } => Some((inner, format!("[{path}]"))),
        FieldKind::Tables { table, .. } => Some((table, format!("[[{path}]]"))),
        _ => None,
    }
}

fn allowed_value(field: &DescribedField) -> String {
    match field.kind {
        FieldKind::Choice(words) => words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "),
        FieldKind::Table(_) => "a table".to_owned(),
        FieldKind::Tables { min, max, .. } => format!("{min} to {max} tables"),
        _ => field.kind.allowed().to_string().trim_start_matches("allowed: ").to_owned(),
    }
}

fn left_out(field: &DescribedField) -> String {
    match (field.presence, field.kind) {
        (Presence::Required, _) => "**required**".to_owned(),
        (Presence::Number(number), _) => format!("{number}"),
        (Presence::Text(""), _) => "empty".to_owned(),
        (Presence::Text(text), _) => format!("`{text}`"),
        (Presence::Flag(flag), _) => format!("`{flag}`"),
        (Presence::Empty, FieldKind::Table(_)) => "its defaults".to_owned(),
        (Presence::Empty, _) => "none".to_owned(),
        (Presence::Optional, _) => "–".to_owned(),
    }
}

#[test]
fn its_tables_are_those_of_the_reader() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/documents.md");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(BEGIN).expect("the mark where tables begin");
    let (found, after) = rest.split_once(END).expect("the mark where tables end");
    let made = handbook_tables();
    assert!(made.lines().count() > 150, "the description is read");
    if std::env::var_os("STYLET_UPDATE_DOCS").is_some() {
        fs::write(&path, [before, BEGIN, &made, END, after].concat()).unwrap();
    } else {
        assert!(
            found == made,
            "docs/documents.md is not of today: STYLET_UPDATE_DOCS=1 cargo test --workspace --lib handbook"
        );
    }
}
