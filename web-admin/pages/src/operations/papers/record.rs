//! The record of processing activities of the documentation, read for the page of papers: it stands
//! in one place, where tests compare it with the program.

use words::Language;

/// The record in English and German: code of the language, place in the documentation, text.
const RECORDS: [(&str, &str, &str); 2] = [
    ("en", "docs/adopt/processing.md", include_str!("../../../../../docs/adopt/processing.md")),
    ("de", "docs/adopt/verarbeitung.md", include_str!("../../../../../docs/adopt/verarbeitung.md")),
];

/// The record of processing activities in one language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProcessingRecord {
    /// Code of its language.
    pub(super) language: &'static str,
    /// Its place in the documentation.
    pub(super) place: &'static str,
    /// Its sections, in order.
    pub(super) sections: Vec<RecordSection>,
}

/// A section of the record.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct RecordSection {
    /// Heading.
    pub heading: String,
    /// Paragraphs.
    pub paragraphs: Vec<String>,
    /// The table: its header, then its rows. Empty if there is none.
    pub table: Vec<Vec<String>>,
    /// Items of the list.
    pub items: Vec<String>,
}

impl ProcessingRecord {
    /// Returns the record in a language; in English if it is not written in that.
    #[must_use]
    pub fn in_language(language: Language) -> Self {
        let known = RECORDS.iter().find(|(code, _, _)| *code == language.code());
        let (language, place, text) = *known.unwrap_or(&RECORDS[0]);
        let sections = text.split("\n## ").skip(1).map(read_section).collect();
        Self { language, place, sections }
    }
}

/// Reads a section of Markdown as the record uses it: paragraphs, one table, one list.
fn read_section(text: &str) -> RecordSection {
    let (heading, body) = text.split_once('\n').unwrap_or((text, ""));
    let mut section = RecordSection { heading: heading.to_owned(), ..RecordSection::default() };
    for block in body.split("\n\n").map(str::trim).filter(|block| !block.is_empty()) {
        if block.starts_with('|') {
            let rows = block.lines().filter(|line| !line.starts_with("|---"));
            section.table = rows.map(read_row).collect();
        } else if let Some(list) = block.strip_prefix("- ") {
            section.items.extend(list.split("\n- ").map(strip_markup));
        } else {
            section.paragraphs.push(strip_markup(block));
        }
    }
    section
}

fn read_row(line: &str) -> Vec<String> {
    line.trim_matches('|').split('|').map(|cell| strip_markup(cell.trim())).collect()
}

/// Removes the marks of code, emphasis and links, whose text stays.
fn strip_markup(text: &str) -> String {
    let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut plain = String::with_capacity(joined.len());
    let mut rest = joined.as_str();
    while let Some((before, after)) = rest.split_once('[') {
        plain.push_str(before);
        let Some((words, target)) = after.split_once("](") else {
            rest = after;
            continue;
        };
        plain.push_str(words);
        rest = target.split_once(')').map_or("", |(_, rest)| rest);
    }
    plain.push_str(rest);
    plain.replace(['`', '*'], "")
}

#[cfg(test)]
mod tests {
    //! Fails when a part of the record is not read, or its marks are shown.

    use model::privacy::recipient::Recipient;

    use super::*;

    #[test]
    fn both_languages_have_the_same_parts() {
        let [english, german] =
            ["en", "de"].map(|code| ProcessingRecord::in_language(Language::named(code).expect("a language")).sections);
        for sections in [&english, &german] {
            assert_eq!(sections.len(), 4, "activities, recipients, measures, facts");
            assert!(sections[0].table.len() > 12 && sections[0].table.iter().all(|row| row.len() == 5));
            assert!(sections[2].table.len() > 4 && sections[3].items.len() > 3);
            let shown = format!("{sections:?}");
            assert!(!shown.contains("](") && !shown.contains('`') && !shown.contains('*'), "{shown}");
        }
        let recipients = |sections: &[RecordSection]| {
            let rows = sections[1].table.iter().skip(1).map(|row| Recipient::of_row(&row[0]));
            rows.collect::<Option<Vec<_>>>().expect("each row names a recipient")
        };
        assert_eq!(recipients(&english), Recipient::ALL);
        assert_eq!(recipients(&german), Recipient::ALL);
    }
}
