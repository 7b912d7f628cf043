//! The dossier in Markdown: published figures, each with the value of every scene.

use std::fmt::Write as _;

use crate::compare::{Agreement, DossierLine, SceneDossier};
use crate::figures::{FIGURES, PublishedFigure};
use crate::words::{first_upper, say_range, say_value, say_verdict, say_why};

/// The scenes and figures of the comparison in docs/measurements.md.
const COMPARISON_SCENES: [&str; 2] = ["lower-back-training", "epidural-71kg"];
const COMPARISON_FIGURES: [&str; 6] =
    ["skin_opening_force", "overall_slope", "veress_peak", "flavum_speed", "tearing_share", "friction_share"];

/// Lists the six lines of the comparison in docs/measurements.md: published figures next to those of two scenes.
#[must_use]
pub fn list_comparison_lines(dossiers: &[SceneDossier]) -> Vec<String> {
    let line = |id: &&str| {
        let figure = FIGURES.iter().find(|figure| figure.id == *id)?;
        let scenes =
            COMPARISON_SCENES.iter().filter_map(|scene| dossiers.iter().find(|dossier| dossier.scene == *scene));
        let cells: Vec<String> = scenes
            .filter_map(|dossier| dossier.lines.iter().find(|line| line.figure.id == *id))
            .map(say_agreement)
            .collect();
        Some(format!("| {} | {} | {} |", figure.title, say_range(figure), cells.join(" | ")))
    };
    COMPARISON_FIGURES.iter().filter_map(line).collect()
}

/// Writes the dossier in Markdown, without its picture.
#[must_use]
pub fn write_dossier_text(dossiers: &[SceneDossier]) -> String {
    let mut text = format!(
        "# Comparison with published measurements\n\nMade by `stylet validate --out DIR` with stylet {}.\n\n\
         Published measurements, and the value of each scene: a needle enters straight at 5 mm/s, with the layers alone. No parameter was tuned to \
         agree, except where a scene was fitted to a figure; this is marked and proves nothing. For a single value without a spread, the ratio is \
         given. *Clearly above*: a test separated two means, and the size of the difference was not published; a scene must be a twentieth above, \
         which such a test would detect (our choice). *Read*: the abstract of the source was read; *recalled*: the figure was taken over without it.\n\n",
        env!("CARGO_PKG_VERSION")
    );
    let counts = dossiers.iter().map(|dossier| {
        let count =
            |of: fn(&Agreement) -> bool| dossier.lines.iter().filter(|line| of(&line.agreement)).count().to_string();
        [
            dossier.scene.clone(),
            count(|agreement| *agreement == Agreement::Inside),
            count(|agreement| *agreement == Agreement::Outside),
            count(|agreement| matches!(agreement, Agreement::Beside { .. })),
            count(|agreement| matches!(agreement, Agreement::Incomparable(_))),
        ]
    });
    let names = ["scene", "inside", "outside", "next to a single value", "not comparable"];
    text.push_str(&markdown_table(names, &counts.collect::<Vec<_>>()));
    for (place, figure) in FIGURES.iter().enumerate() {
        write_figure(&mut text, figure, dossiers.iter().map(|dossier| (dossier.scene.as_str(), &dossier.lines[place])));
    }
    text
}

/// Writes a figure and the scenes' values; scenes that are not comparable for the same reason share
/// a line.
fn write_figure<'a>(
    text: &mut String,
    figure: &PublishedFigure,
    scenes: impl Iterator<Item = (&'a str, &'a DossierLine)>,
) {
    let source = figure.source;
    let doi = if source.doi.is_empty() { String::new() } else { format!(" DOI {}.", source.doi) };
    let _ = write!(
        text,
        "\n## {}: {}\n\n{}. {}.{doi} *{}.*\n\n",
        figure.title,
        say_range(figure),
        first_upper(figure.conditions),
        source.citation,
        first_upper(source.known.words())
    );
    let (mut compared, mut others) = (Vec::new(), Vec::<(String, Vec<&str>)>::new());
    for (scene, line) in scenes {
        if let Agreement::Incomparable(why) = line.agreement {
            let why = say_why(why);
            match others.iter_mut().find(|(known, _)| *known == why) {
                Some((_, scenes)) => scenes.push(scene),
                None => others.push((why, vec![scene])),
            }
        } else {
            let value = line.value.map_or_else(String::new, |value| say_value(&figure.quantity, value));
            compared.push([scene.to_owned(), value, say_verdict(line)]);
        }
    }
    if !compared.is_empty() {
        text.push_str(&markdown_table(["scene", "value", "published"], &compared));
    }
    for (why, scenes) in others {
        let _ = write!(text, "\nNot compared: {}: {why}.\n", scenes.join(", "));
    }
}

fn say_agreement(line: &DossierLine) -> String {
    let Some(value) = line.value else { return "–".to_owned() };
    format!("{}, {}", say_value(&line.figure.quantity, value), say_verdict(line))
}

fn markdown_row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

fn markdown_table<const COLUMNS: usize>(names: [&str; COLUMNS], rows: &[[String; COLUMNS]]) -> String {
    let head = markdown_row(&names.map(str::to_owned));
    let rows: String = rows.iter().map(|row| markdown_row(row)).collect();
    format!("{head}|{}\n{rows}", "---|".repeat(COLUMNS))
}
