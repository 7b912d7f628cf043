//! `docs/recordings.md` and what is shipped for viewers name what recordings hold. The tables of fields are made from
//! `proto/stylet.proto`; fails when they are not those of today (`STYLET_UPDATE_DOCS=1 cargo test -p recording --test main
//! handbook` writes them), when a unit in words is not the one in the field's name, or when a topic is not told of.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use recording::tables::UNITS;

use crate::support::file;

/// What stands before and behind the tables that are made.
const BEGIN: &str = "<!-- made from sim/recording/proto/stylet.proto -->\n";
const END: &str = "<!-- until here -->\n";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A message or an enumeration of the `.proto` file, with what its comments say.
#[derive(Default)]
struct Block {
    name: String,
    words: String,
    fields: Vec<Field>,
}

struct Field {
    name: String,
    kind: String,
    words: String,
}

/// The messages of the file in their order; an enumeration within a message comes before it.
fn blocks(proto: &str) -> Vec<Block> {
    let (mut done, mut open, mut words) = (Vec::new(), Vec::<Block>::new(), Vec::new());
    for line in proto.lines().map(str::trim) {
        if let Some(comment) = line.strip_prefix("//") {
            words.push(comment.trim());
            continue;
        }
        let said = std::mem::take(&mut words).join(" ");
        if let Some(name) = line.strip_suffix('{').and_then(|head| head.split_whitespace().nth(1)) {
            open.push(Block { name: name.to_owned(), words: said, fields: Vec::new() });
        } else if line == "}" {
            done.extend(open.pop());
        } else if let (Some((head, _)), Some(block)) = (line.split_once(" = "), open.last_mut()) {
            let (kind, name) = head.rsplit_once(' ').unwrap_or(("", head));
            block.fields.push(Field { name: name.to_owned(), kind: kind.to_owned(), words: said });
        }
    }
    done
}

fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(_, unit)| *unit)
}

/// The tables of the document.
fn tables(proto: &str) -> String {
    let mut text = String::new();
    for Block { name, words, fields } in blocks(proto) {
        write!(text, "\n### {name}\n\n").unwrap();
        if !words.is_empty() {
            write!(text, "{words}\n\n").unwrap();
        }
        text += "| field | type | unit | meaning |\n|---|---|---|---|\n";
        for Field { name, kind, words } in fields {
            let kind = if kind.is_empty() { "value" } else { &kind };
            writeln!(text, "| `{name}` | {kind} | {} | {words} |", unit(&name)).unwrap();
        }
    }
    text.push('\n');
    text
}

fn proto() -> String {
    fs::read_to_string(root().join("sim/recording/proto/stylet.proto")).unwrap()
}

#[test]
fn its_tables_are_those_of_the_messages() {
    let path = root().join("docs/recordings.md");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(BEGIN).expect("the mark where tables begin");
    let (found, after) = rest.split_once(END).expect("the mark where tables end");
    let made = tables(&proto());
    if std::env::var_os("STYLET_UPDATE_DOCS").is_some() {
        fs::write(&path, [before, BEGIN, &made, END, after].concat()).unwrap();
    } else {
        assert!(
            found == made,
            "docs/recordings.md is not of today: STYLET_UPDATE_DOCS=1 cargo test -p recording handbook"
        );
    }
}

#[test]
fn every_field_says_what_it_is_in_the_unit_of_its_name() {
    let blocks = blocks(&proto());
    assert!(blocks.len() > 10 && blocks.iter().map(|b| b.fields.len()).sum::<usize>() > 60, "the file is read");
    let plain = ["Vector3", "Vector3f", "Quaternion", "Range"];
    for Block { name, fields, .. } in blocks.iter().filter(|block| !plain.contains(&block.name.as_str())) {
        for field in fields.iter().filter(|field| field.name != "unspecified") {
            assert!(!field.words.is_empty(), "{name}.{} has no comment", field.name);
        }
    }
    // "in m/s" and the like, wherever a comment names a unit.
    let units: Vec<&str> = UNITS.iter().map(|(_, unit)| *unit).collect();
    for Block { name, fields, .. } in &blocks {
        for field in fields {
            let mut words = field.words.split([' ', ',', '.', ';', ':']);
            let said = std::iter::from_fn(|| words.by_ref().find(|w| *w == "in").and_then(|_| words.next()));
            for said in said.filter(|word| units.contains(word)) {
                assert_eq!(said, unit(&field.name), "{name}.{}: {}", field.name, field.words);
            }
        }
    }
}

/// Tables leave out fields of any other kind.
#[test]
fn every_field_is_of_a_kind_that_tables_know() {
    let blocks = blocks(&proto());
    let known = ["double", "float", "int32", "int64", "uint32", "fixed32", "bool", "string"];
    for Block { name, fields, .. } in &blocks {
        for Field { name: field, kind, .. } in fields.iter().filter(|field| !field.kind.is_empty()) {
            let kind = kind.trim_start_matches("repeated ").trim_start_matches("optional ");
            assert!(known.contains(&kind) || blocks.iter().any(|b| b.name == kind), "{name}.{field} is a {kind}");
        }
    }
}

#[test]
fn every_topic_of_a_recording_is_told_of() {
    let text = fs::read_to_string(root().join("docs/recordings.md")).unwrap();
    let summary = mcap::Summary::read(&file(10)).unwrap().unwrap();
    for channel in summary.channels.values() {
        let schema = &channel.schema.as_ref().unwrap().name;
        let row = format!("| `{}` | `{schema}` |", channel.topic);
        assert!(text.contains(&row), "{row} is missing");
    }
    assert!(text.contains("| `/tissue/tent` | `stylet.TissueTent` |"));
    let bytes = file(10);
    let session = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    for key in session.metadata.keys() {
        assert!(text.contains(&format!("`{key}`")), "the metadata's {key} is missing");
    }
}
