//! Canonical N-Quads (RDFC-1.0) of a graph with at most one blank node, whose name is therefore
//! known without the algorithm of that recommendation.

use std::fmt::Write;

use anyhow::ensure;

/// Name of the only blank node of a graph.
pub(super) const BLANK: &str = "_:c14n0";
/// The property that gives the type of a node.
const TYPE: &str = "http://www.w3.org/1999/02/22-rdf-syntax-ns#type";

/// The quads of a graph.
#[derive(Debug, Default)]
pub(super) struct Quads(Vec<String>);

/// The value of a property that is neither a node nor a plain text.
#[derive(Clone, Copy, Debug)]
pub(super) struct TypedValue<'a> {
    /// Lexical form.
    pub value: &'a str,
    /// Address of the datatype.
    pub datatype: &'a str,
}

impl Quads {
    /// Adds the type of a node.
    pub(super) fn add_type(&mut self, subject: &str, object: &str) {
        self.add_node(subject, TYPE, object);
    }

    /// Adds a property whose value is a node.
    pub(super) fn add_node(&mut self, subject: &str, property: &str, object: &str) {
        self.0.push(format!("{} <{property}> {} .\n", write_node(subject), write_node(object)));
    }

    /// Adds a property whose value is a text.
    pub(super) fn add_text(&mut self, subject: &str, property: &str, text: &str) {
        self.0.push(format!("{} <{property}> \"{}\" .\n", write_node(subject), escape(text)));
    }

    /// Adds a property whose value has a datatype.
    pub(super) fn add_typed(&mut self, subject: &str, property: &str, typed: TypedValue<'_>) {
        let TypedValue { value, datatype } = typed;
        self.0.push(format!("{} <{property}> \"{}\"^^<{datatype}> .\n", write_node(subject), escape(value)));
    }

    /// Returns the canonical form: the lines in the order of their code points.
    pub(super) fn canonical(mut self) -> String {
        self.0.sort_unstable();
        self.0.concat()
    }
}

fn write_node(node: &str) -> String {
    if node == BLANK { node.to_owned() } else { format!("<{node}>") }
}

/// Escapes a text as canonical N-Quads require, and nothing else.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        let short = match c {
            '\u{8}' => "\\b",
            '\t' => "\\t",
            '\n' => "\\n",
            '\u{c}' => "\\f",
            '\r' => "\\r",
            '"' => "\\\"",
            '\\' => "\\\\",
            // The characters that XML 1.1 does not know are escaped, too.
            '\0'..='\u{1f}' | '\u{7f}' | '\u{fffe}' | '\u{ffff}' => {
                // Writing to a string does not fail.
                let _ = write!(escaped, "\\u{:04X}", u32::from(c));
                continue;
            }
            c => {
                escaped.push(c);
                continue;
            }
        };
        escaped.push_str(short);
    }
    escaped
}

/// Checks that an address can be written into N-Quads without an escape.
///
/// # Errors
/// If it is not an absolute address in ASCII.
pub(super) fn check_address(address: &str) -> anyhow::Result<()> {
    let allowed = |c: char| c.is_ascii_graphic() && !"<>\"{}|^`\\".contains(c);
    ensure!(address.contains(':') && address.chars().all(allowed), "not an absolute address in ASCII: {address:?}");
    Ok(())
}

#[cfg(test)]
mod tests {
    //! A signature covers the canonical form: a character escaped differently from other programs
    //! would make them reject the badge.

    use super::*;

    #[test]
    fn control_characters_are_escaped_as_rdfc_requires() {
        // Written by rdf-canonize 5.0.0, for each character below U+0080.
        let golden = include_str!("../../../../../tests/data/badge/escapes.nq");
        let mut quads = Quads::default();
        for code in 0..0x80_u8 {
            let subject = format!("urn:x:{code:03}");
            quads.add_text(&subject, "https://schema.org/name", &char::from(code).to_string());
        }
        assert_eq!(quads.canonical(), golden);
    }

    #[test]
    fn other_characters_are_written_unchanged() {
        let kept = "Größe „quoted“ 🩺 \u{2028}\u{2029}\u{85}\u{a0}\u{feff}\u{10ffff}";
        assert_eq!(escape(kept), kept);
        assert_eq!(escape("\u{fffe}\u{ffff}"), "\\uFFFE\\uFFFF");
    }

    #[test]
    fn addresses_are_absolute_and_plain() {
        for good in ["https://a.example/x?y#z", "urn:uuid:1", "did:web:a.example%3A80"] {
            check_address(good).expect(good);
        }
        for bad in ["", "/x", "https://a example", "https://a/<b>", "https://größe", "a:\n", "a:\"", "a:\\"] {
            assert!(check_address(bad).is_err(), "{bad:?}");
        }
    }
}
