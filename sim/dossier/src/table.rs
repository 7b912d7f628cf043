//! The dossier as a machine-readable table.

use crate::compare::{Agreement, DossierLine, SceneDossier};
use crate::figures::PublishedRange;
use crate::words::say_why;

const COLUMNS: [&str; 14] = [
    "figure",
    "title",
    "conditions",
    "unit",
    "published_low",
    "published_high",
    "scene",
    "value",
    "agreement",
    "why",
    "fitted",
    "source",
    "doi",
    "known",
];

/// Writes the dossier as CSV, a row for each scene and figure.
///
/// # Errors
/// Only if writing to memory fails.
pub fn write_dossier_table(dossiers: &[SceneDossier]) -> csv::Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for dossier in dossiers {
        for line in &dossier.lines {
            table.write_record(row_of_line(&dossier.scene, line))?;
        }
    }
    table.into_inner().map_err(|error| error.into_error().into())
}

fn row_of_line(scene: &str, line: &DossierLine) -> Vec<String> {
    let figure = line.figure;
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    let (low, high) = match figure.range {
        PublishedRange::Between { low, high } => (Some(low), Some(high)),
        PublishedRange::Above(low) | PublishedRange::ToldApart(low) => (Some(low), None),
        PublishedRange::Single(value) => (Some(value), Some(value)),
        PublishedRange::Unstated => (None, None),
    };
    let (agreement, why) = match line.agreement {
        Agreement::Inside => ("inside", String::new()),
        Agreement::Outside => ("outside", String::new()),
        Agreement::Beside { ratio } => ("no spread published", format!("{ratio:.3} times the published value")),
        Agreement::Incomparable(why) => ("not comparable", say_why(why)),
    };
    let texts = [figure.id, figure.title, figure.conditions, figure.quantity.unit()].map(str::to_owned);
    let fitted = if line.fitted { "yes" } else { "no" };
    let source = [figure.source.citation, figure.source.doi, figure.source.known.words()].map(str::to_owned);
    let measured = [number(low), number(high), scene.to_owned(), number(line.value), agreement.to_owned(), why];
    [&texts[..], &measured, &[fitted.to_owned()], &source].concat()
}
