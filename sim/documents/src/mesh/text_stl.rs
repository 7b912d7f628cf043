//! Text STL files as exporters write them: several solids, upper case, names in any code page, a
//! byte order mark.

use phrase::{Phrase, phrase};

/// Length of a binary file's header with its triangle count, and of each triangle, in bytes.
const BINARY_HEAD: usize = 84;
const BINARY_TRIANGLE: usize = 50;

/// Returns the contents of a text file. A binary file is recognised by its length, which its
/// triangle count determines, because its header may also begin with "solid".
pub(super) fn text_of(bytes: &[u8]) -> Option<String> {
    if is_binary(bytes) {
        return None;
    }
    // Names may use any code page; the parsed part is ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let begins = text.split_whitespace().next().is_some_and(|word| word.eq_ignore_ascii_case("solid"));
    let lower = text.to_ascii_lowercase();
    let is_text = begins && (lower.contains("facet") || lower.contains("endsolid"));
    is_text.then(|| lower.replace("\r\n", "\n").replace('\r', "\n"))
}

fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(80..BINARY_HEAD).and_then(|count| count.first_chunk());
    count.is_some_and(|count| {
        let triangles = u32::from_le_bytes(*count) as usize;
        triangles.checked_mul(BINARY_TRIANGLE).and_then(|size| size.checked_add(BINARY_HEAD)) == Some(bytes.len())
    })
}

/// Merges the facets of all solids into one, because the STL reader stops at the end of the first
/// solid.
///
/// # Errors
/// If a solid has no end: the file is truncated.
pub(super) fn join_solids(text: &str) -> Result<String, Phrase> {
    let mut joined = String::from("solid joined\n");
    let mut open: Option<usize> = None;
    for (at, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace().peekable();
        match words.peek().copied() {
            Some("solid") if open.is_none() => open = Some(at + 1),
            Some("endsolid") => open = None,
            Some("solid") => break,
            _ => {
                for word in words {
                    let begins = ["facet", "outer", "vertex", "endloop", "endfacet"].contains(&word);
                    joined.push(if begins { '\n' } else { ' ' });
                    joined.push_str(word);
                }
            }
        }
    }
    match open {
        None => Ok(joined + "\nendsolid\n"),
        Some(line) => Err(phrase!("line {line}: a solid that does not end with \"endsolid\"", line = line)),
    }
}
