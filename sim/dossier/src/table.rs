//! The dossier as a machine-readable table.

use documents::NeedleFamily;

use crate::compare::{Agreement, DossierLine, SceneDossier};
use crate::figures::PublishedRange;
use crate::words::say_why;

const COLUMNS: [&str; 15] = [
    "figure",
    "title",
    "conditions",
    "family",
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
        PublishedRange::Between { low, high } | PublishedRange::Means { low, high } => (Some(low), Some(high)),
        PublishedRange::Spread { mean, deviation } => (Some(mean - 2.0 * deviation), Some(mean + 2.0 * deviation)),
        PublishedRange::Above(low) | PublishedRange::Distinguishable(low) => (Some(low), None),
        PublishedRange::Single(value) => (Some(value), Some(value)),
        PublishedRange::Unstated => (None, None),
    };
    let (agreement, why) = match line.agreement {
        Agreement::Inside => ("inside", String::new()),
        Agreement::Outside => ("outside", String::new()),
        Agreement::SingleValue { ratio } => ("no spread published", format!("{ratio:.3} times the published value")),
        Agreement::Incomparable(why) => ("not comparable", say_why(why)),
    };
    let family = figure.family.map_or("", NeedleFamily::word);
    let texts = [figure.id, figure.title, figure.conditions, family, figure.quantity.unit()].map(str::to_owned);
    let fitted = if line.fitted { "yes" } else { "no" };
    let source = [figure.source.citation, figure.source.doi, figure.source.known.words()].map(str::to_owned);
    let measured = [number(low), number(high), scene.to_owned(), number(line.value), agreement.to_owned(), why];
    [&texts[..], &measured, &[fitted.to_owned()], &source].concat()
}
