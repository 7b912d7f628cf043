//! Catalogues of outcomes: CSV with the columns code, title and description, or a package of
//! 1EdTech CASE 1.1 (`CFPackage`) as JSON.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{LONGEST_DESCRIPTION, LONGEST_TITLE, MOST_OUTCOMES, OutcomeText};
use crate::people::roster::{Unreadable, read_csv};

/// A package of CASE 1.1. Only its items are read.
#[derive(Deserialize)]
struct CasePackage {
    #[serde(rename = "CFItems")]
    items: Vec<CaseItem>,
}

/// An item of a package. CASE requires the identifier and the statement alone.
#[derive(Deserialize)]
struct CaseItem {
    identifier: String,
    #[serde(rename = "humanCodingScheme")]
    code: Option<String>,
    #[serde(rename = "fullStatement")]
    statement: String,
    #[serde(rename = "abbreviatedStatement")]
    short_statement: Option<String>,
}

/// Reads a catalogue.
///
/// # Errors
/// If it is neither CSV with the columns nor a package of CASE, has no or too many outcomes, or one
/// of them is refused or occurs twice; as a message that names the line or the item.
pub fn read_catalogue(file: &[u8]) -> Result<Vec<OutcomeText>, String> {
    let text = std::str::from_utf8(file).unwrap_or_default();
    let read = match text.trim_start_matches('\u{feff}').trim_start() {
        json if json.starts_with('{') => read_case(json)?,
        _ => read_table(file)?,
    };
    if read.is_empty() {
        return Err(tr!("the file contains no outcomes").to_owned());
    }
    if read.len() > MOST_OUTCOMES {
        return Err(tr!("the file has {count} outcomes; allowed: {most}", count = read.len(), most = MOST_OUTCOMES));
    }
    let mut seen = BTreeMap::new();
    let mut checked = Vec::with_capacity(read.len());
    for (place, text) in read {
        let text = text.checked().map_err(|why| format!("{place}: {why}"))?;
        if let Some(first) = seen.insert(text.code.clone(), place.clone()) {
            return Err(tr!(
                "{place}: the code “{code}” is already in {first}",
                place = place,
                code = text.code,
                first = first
            ));
        }
        checked.push(text);
    }
    Ok(checked)
}

/// Outcomes with their places in the file.
type Placed = Vec<(String, OutcomeText)>;

fn read_case(json: &str) -> Result<Placed, String> {
    let package: CasePackage = serde_json::from_str(json)
        .map_err(|error| tr!("this is not a package of CASE 1.1 (CFPackage): {error}", error = error))?;
    let outcome = |(at, item): (usize, CaseItem)| {
        let place = tr!("item {number}", number = at + 1);
        let code = item.code.map(|code| code.trim().to_owned()).filter(|code| !code.is_empty());
        let (title, description) = split_statement(item.statement, item.short_statement);
        let code = code.unwrap_or_else(|| item.identifier.chars().take(8).collect());
        (place, OutcomeText { code, title, description, source: item.identifier })
    };
    Ok(package.items.into_iter().enumerate().map(outcome).collect())
}

/// Makes title and description of a statement and its short form.
fn split_statement(full: String, short: Option<String>) -> (String, String) {
    let full = full.split_whitespace().collect::<Vec<_>>().join(" ");
    let short = short.map(|short| short.split_whitespace().collect::<Vec<_>>().join(" "));
    let short = short.filter(|short| !short.is_empty() && *short != full);
    let cut = |text: &str, most: usize| match text.chars().count() > most {
        true => text.chars().take(most - 1).chain(['…']).collect(),
        false => text.to_owned(),
    };
    match short {
        Some(short) => (cut(&short, LONGEST_TITLE), cut(&full, LONGEST_DESCRIPTION)),
        None if full.chars().count() > LONGEST_TITLE => (cut(&full, LONGEST_TITLE), cut(&full, LONGEST_DESCRIPTION)),
        None => (full, String::new()),
    }
}

/// Names of the columns in English and German.
const COLUMNS: [&[&str]; 3] = [&["code", "kürzel", "kuerzel"], &["title", "titel"], &["description", "beschreibung"]];

fn read_table(file: &[u8]) -> Result<Placed, String> {
    let refused = |why| match why {
        Unreadable::TooLong => tr!("the file has more than {most} outcomes", most = MOST_OUTCOMES),
        other => other.to_string(),
    };
    let mut rows = read_csv(file).map_err(refused)?.into_iter();
    let (_, headings) = rows.next().ok_or_else(|| tr!("the file contains no outcomes").to_owned())?;
    let column = |names: &[&str]| headings.iter().position(|heading| names.contains(&heading.to_lowercase().as_str()));
    let [code, title, description] = COLUMNS.map(column);
    let (Some(code), Some(title)) = (code, title) else {
        let found: String = headings.iter().collect::<Vec<_>>().join(", ").chars().take(200).collect();
        return Err(tr!("the columns “code” and “title” are required; found: {found}", found = found));
    };
    let outcome = |(line, row): (u64, csv::StringRecord)| {
        let cell = |at: Option<usize>| at.and_then(|at| row.get(at)).unwrap_or_default().to_owned();
        let (code, title, description) = (cell(Some(code)), cell(Some(title)), cell(description));
        (tr!("line {line}", line = line), OutcomeText { code, title, description, source: String::new() })
    };
    Ok(rows.map(outcome).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(file: &str) -> Result<Vec<String>, String> {
        Ok(read_catalogue(file.as_bytes())?.into_iter().map(|outcome| outcome.code).collect())
    }

    #[test]
    fn tables_have_a_code_and_a_title_in_any_order() {
        assert_eq!(
            codes("Titel;Kürzel\r\nPunktion;EPA 1\r\nAufklärung;EPA 2\r\n"),
            Ok(vec!["EPA 1".into(), "EPA 2".into()])
        );
        let one = &read_catalogue(b"code,title,description\n1,\"A, b\",Long\n").unwrap()[0];
        assert_eq!((one.title.as_str(), one.description.as_str()), ("A, b", "Long"));
        for (file, place) in [
            ("name,text\na,b\n", "found: name, text"),
            ("code,title\n1,a\n1,b\n", "line 3"),
            ("code,title\n1,a\n2,\n", "line 3"),
            ("code,title\n", "no outcomes"),
            ("", "no outcomes"),
        ] {
            assert!(codes(file).unwrap_err().contains(place), "{file:?}: {:?}", codes(file));
        }
    }

    #[test]
    fn packages_of_case_are_read_by_their_items() {
        let item = |rest: &str| format!(r#"{{"identifier":"0a1b2c3d-4e5f","uri":"https://x",{rest}}}"#);
        let package =
            |items: &str| format!(r#"{{"CFDocument":{{"title":"NKLM"}},"CFItems":[{items}],"CFRubrics":[]}}"#);
        let full = "Performs a lumbar\n puncture";
        let file = package(&item(r#""humanCodingScheme":"VIII.7","fullStatement":"Performs a lumbar\n puncture""#));
        let one = &read_catalogue(file.as_bytes()).unwrap()[0];
        assert_eq!((one.code.as_str(), one.title.as_str()), ("VIII.7", full.replace('\n', "").as_str()));
        let file = package(&item(r#""abbreviatedStatement":"Puncture","fullStatement":"Performs a puncture""#));
        let one = &read_catalogue(file.as_bytes()).unwrap()[0];
        assert_eq!([&one.code, &one.title, &one.description], ["0a1b2c3d", "Puncture", "Performs a puncture"]);
        for (file, place) in [
            (package(&item(r#""fullStatement":"""#)), "item 1"),
            (package(&item(r#""fullStatement":7"#)), "CFPackage"),
            ("{}".to_owned(), "CFPackage"),
            ("[".repeat(100_000).replacen('[', "{", 1), "CFPackage"),
            (package(""), "no outcomes"),
        ] {
            assert!(codes(&file).unwrap_err().contains(place), "{:?}", codes(&file));
        }
    }

    #[test]
    fn long_statements_are_cut_in_the_title_alone() {
        let (title, description) = split_statement("ä".repeat(500), None);
        assert_eq!((title.chars().count(), description.chars().count()), (LONGEST_TITLE, 500));
        assert!(title.ends_with('…'));
    }
}
