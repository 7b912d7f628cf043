//! The dossier in Markdown: for each family of needles a table with a row for each published figure
//! and a column for each scene.

use std::fmt::Write as _;

use documents::NeedleFamily;

use crate::compare::{Agreement, DossierLine, Incomparable, SceneDossier, count_inside};
use crate::figures::{FIGURES, PublishedFigure};
use crate::words::{first_upper, name_family, say_range, say_value, say_verdict, say_why};

/// Families in display order.
const FAMILIES: [NeedleFamily; 6] = [
    NeedleFamily::RenalAccess,
    NeedleFamily::Tuohy,
    NeedleFamily::Spinal,
    NeedleFamily::Veress,
    NeedleFamily::Trocar,
    NeedleFamily::Organ,
];

/// Says how many of the comparisons with a published range are inside.
#[must_use]
pub fn summarise_dossiers(dossiers: &[SceneDossier]) -> String {
    let [inside, all] = count_inside(dossiers);
    format!("{inside} of {all} comparable figures inside")
}

/// Writes the dossier in Markdown, without its pictures.
#[must_use]
pub fn write_dossier_text(dossiers: &[SceneDossier]) -> String {
    let mut text = format!(
        "# Comparison with published measurements\n\nMade by `stylet validate --out DIR` with stylet {}. **{}.**\n\n\
         Published measurements, and the value of each scene: its needle enters straight at 5 mm/s, a Tuohy needle at 1.5 mm/s, with the layers alone. \
         A figure judges the family of needles that it was measured with. Accepted is the range from the least to the greatest published value; a mean ± two \
         deviations where those are published; means of groups, without a spread, ± 25 % (our choice). For a single value without a spread the ratio \
         is given. *Clearly above*: a test separated two means, and the size of the difference was not published; a scene must be a twentieth above, \
         which such a test would detect (our choice). Where a scene was fitted to a figure this is marked, and proves nothing.\n",
        env!("CARGO_PKG_VERSION"),
        summarise_dossiers(dossiers)
    );
    for family in FAMILIES {
        let scenes: Vec<&SceneDossier> = dossiers.iter().filter(|dossier| dossier.family == Some(family)).collect();
        if !scenes.is_empty() {
            let _ = write!(text, "\n## {}\n\n", first_upper(name_family(family)));
            write_family(&mut text, &scenes);
        }
    }
    write_unfamiliar(&mut text, dossiers);
    write_unjudging(&mut text, dossiers);
    write_sources(&mut text);
    text
}

/// Writes the table of the scenes of one family: the figures for which one of them has a value.
fn write_family(text: &mut String, scenes: &[&SceneDossier]) {
    let names = scenes.iter().map(|dossier| dossier.scene.clone());
    let head: Vec<String> = ["figure".to_owned(), "published".to_owned()].into_iter().chain(names).collect();
    let mut rows = Vec::new();
    let mut conditions = Vec::new();
    for (place, figure) in FIGURES.iter().enumerate() {
        let lines: Vec<&DossierLine> = scenes.iter().map(|dossier| &dossier.lines[place]).collect();
        if lines.iter().all(|line| line.value.is_none()) {
            continue;
        }
        let note = rows.len() + 1;
        let cells = lines.into_iter().map(say_agreement);
        let head = [format!("{} ({note})", figure.title), say_range(figure)];
        rows.push(head.into_iter().chain(cells).collect());
        conditions.push(format!("({note}) {}; {}.", first_upper(figure.conditions), figure.source.short()));
    }
    text.push_str(&markdown_table(&head, &rows));
    let _ = write!(text, "\n{}\n", conditions.join(" "));
}

/// Writes the scenes that name no family, and why.
fn write_unfamiliar(text: &mut String, dossiers: &[SceneDossier]) {
    let names: Vec<&str> =
        dossiers.iter().filter(|dossier| dossier.family.is_none()).map(|dossier| dossier.scene.as_str()).collect();
    if !names.is_empty() {
        let _ = write!(
            text,
            "\n## Not compared\n\n{}: the scene names no family of needles, so that no published force may judge it.\n",
            names.join(", ")
        );
    }
}

/// Writes the figures that judge no scene, with the reasons.
fn write_unjudging(text: &mut String, dossiers: &[SceneDossier]) {
    let mut rows = Vec::new();
    for (place, figure) in FIGURES.iter().enumerate() {
        let lines = || dossiers.iter().map(|dossier| &dossier.lines[place]);
        if lines().any(|line| line.value.is_some()) {
            continue;
        }
        let own = |line: &&DossierLine| {
            !matches!(line.agreement, Agreement::Incomparable(Incomparable::Family { .. } | Incomparable::NoLayer(_)))
        };
        let reason = lines().find(own).or_else(|| lines().next());
        let why = match reason.map(|line| line.agreement) {
            Some(Agreement::Incomparable(Incomparable::Family { measured, .. })) => {
                format!("no scene has a {}", name_family(measured))
            }
            Some(Agreement::Incomparable(why)) => say_why(why),
            _ => String::new(),
        };
        rows.push(vec![figure.title.to_owned(), say_range(figure), why, figure.source.short()]);
    }
    if !rows.is_empty() {
        let head = ["figure", "published", "why it judges no scene", "source"].map(str::to_owned);
        let _ = write!(text, "\n## Figures that judge no scene\n\n{}", markdown_table(&head, &rows));
    }
}

/// Writes each publication once, with what of it was read.
fn write_sources(text: &mut String) {
    let _ = write!(text, "\n## Sources\n\n");
    let mut seen: Vec<&str> = Vec::new();
    for PublishedFigure { source, .. } in FIGURES {
        if seen.contains(&source.citation) {
            continue;
        }
        seen.push(source.citation);
        let doi = if source.doi.is_empty() { String::new() } else { format!(" DOI {}.", source.doi) };
        let _ = writeln!(text, "- {}.{doi} *{}.*", source.citation, first_upper(source.known.words()));
    }
}

fn say_agreement(line: &DossierLine) -> String {
    let Some(value) = line.value else { return "–".to_owned() };
    format!("{}, {}", say_value(&line.figure.quantity, value), say_verdict(line))
}

fn markdown_row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

fn markdown_table(head: &[String], rows: &[Vec<String>]) -> String {
    let body: String = rows.iter().map(|row| markdown_row(row)).collect();
    format!("{}|{}\n{body}", markdown_row(head), "---|".repeat(head.len()))
}
