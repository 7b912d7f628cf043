//! Finds text on a page that is not translated.
//!
//! A sample is rendered again in a pseudo-language that puts every translated text in brackets.
//! Text outside brackets must be sample data, a unit or a name; otherwise its translation was
//! forgotten.

use std::fmt::Debug;

use words::{Language, within};

/// Units and proper names that need no translation.
const NAMES: [&str; 23] = [
    "CSV",
    "CUSUM",
    "Canvas",
    "English",
    "Deutsch",
    "Foxglove",
    "GB",
    "GmbH",
    "JSON",
    "LC",
    "Lichtblick",
    "MB",
    "Rerun",
    "Stylet",
    "TOML",
    "UTC",
    "kB",
    "mJ",
    "min",
    "mm",
    "ms",
    "vs",
    "px",
];

/// Attributes whose values are displayed or read out.
const READ: [&str; 6] = ["title", "aria-label", "placeholder", "alt", "data-label", "data-failed"];

/// Checks a page.
pub(crate) fn check_page(name: &str, page: &(impl askama::Template + Debug)) {
    let html = within(Language::PSEUDO, || page.render()).expect("the page renders");
    all_is_said(name, &html, page);
}

/// Checks a drawing. Pages contain finished drawings, in which text would pass as data of the page.
pub(crate) fn check_drawing(name: &str, data: &impl Debug, draw: impl Fn() -> String) {
    all_is_said(name, &within(Language::PSEUDO, draw), data);
}

/// Fails if text outside brackets is not part of the data.
fn all_is_said(name: &str, html: &str, data: &impl Debug) {
    let data = strings(&format!("{data:?}").replace("\\u{a0}", " "));
    let forgotten: Vec<String> =
        texts(html).iter().flat_map(|text| outside(text)).filter(|text| !is_data(text, &data)).collect();
    assert!(forgotten.is_empty(), "{name} says these in English only: {forgotten:#?}");
}

/// Returns the strings in a debug output in lower case, one per line.
fn strings(debug: &str) -> String {
    let mut strings = String::new();
    let (mut inside, mut escaped) = (false, false);
    for c in debug.chars() {
        match c {
            '\\' if inside && !escaped => escaped = true,
            '"' if !escaped => {
                inside = !inside;
                strings.push('\n');
            }
            c if inside => {
                strings.push(c);
                escaped = false;
            }
            _ => {}
        }
    }
    strings.to_lowercase()
}

/// Returns the texts and attribute values that a reader sees, with entities decoded.
fn texts(html: &str) -> Vec<String> {
    let mut texts = Vec::new();
    let mut rest = html;
    while let Some((text, after)) = rest.split_once('<') {
        texts.push(plain(text));
        let (tag, after) = after.split_once('>').unwrap_or((after, ""));
        for attribute in READ {
            let value = tag.split(&format!(" {attribute}=\"")).nth(1).and_then(|value| value.split('"').next());
            texts.extend(value.map(plain));
        }
        let unread =
            ["code", "kbd", "style", "script"].into_iter().find(|unread| tag.split(' ').next() == Some(unread));
        rest = unread.and_then(|tag| after.split_once(&format!("</{tag}>"))).map_or(after, |(_, after)| after);
    }
    texts
}

fn plain(text: &str) -> String {
    let entities = [
        ("&#60;", "<"),
        ("&#62;", ">"),
        ("&#34;", "\""),
        ("&#39;", "'"),
        ("&quot;", "\""),
        ("&nbsp;", " "),
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&#38;", "&"),
        ("&amp;", "&"),
    ];
    let text = text.replace('\u{a0}', " ");
    entities.iter().fold(text, |text, (entity, plain)| text.replace(entity, plain))
}

/// Returns the parts of a text outside brackets.
fn outside(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut depth = 0_usize;
    for c in text.chars() {
        match c {
            '⟦' => depth += 1,
            '⟧' => {
                depth = depth.saturating_sub(1);
                parts.push(String::new());
            }
            c if depth == 0 => parts.last_mut().expect("a part").push(c),
            _ => {}
        }
    }
    parts.into_iter().map(|part| part.trim_matches(|c: char| !c.is_alphabetic()).to_owned()).collect()
}

/// Returns whether a part has no words, or consists of names and sample data.
fn is_data(part: &str, data: &str) -> bool {
    let pieces = part.split([',', ':', ';', '.', '·', '–', '…', '(', ')', '/', '<', '>', '×']);
    let mut pieces = pieces.map(|piece| piece.trim_matches(|c: char| !c.is_alphabetic()));
    pieces.all(|piece| is_name(piece) || data.contains(&piece.to_lowercase()))
}

fn is_name(piece: &str) -> bool {
    let mut words = piece.split(|c: char| !c.is_alphabetic()).filter(|word| word.chars().count() > 1);
    words.all(|word| NAMES.contains(&word))
}

#[cfg(test)]
mod tests {
    //! The check must find untranslated text, and accept data.

    use super::*;

    #[test]
    fn a_forgotten_sentence_is_found_and_data_is_not() {
        let html = r#"<p title="Forgotten">⟦Hello ⟦Ana⟧⟧ Ana Ek, 3 mm<code>no words</code> <b aria-label="⟦x⟧">and &#39;this&#39;</b></p>"#;
        let found: Vec<String> = texts(html).iter().flat_map(|text| outside(text)).collect();
        let data = strings(r#"Page { name: "Ana Ek", and: 3 }"#);
        let left: Vec<&String> = found.iter().filter(|text| !is_data(text, &data)).collect();
        assert_eq!(left, ["Forgotten", "and 'this"]);
    }
}
