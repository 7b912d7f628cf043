//! The dossier: figures that others have published, and what each scene gives beside them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use documents::Scene;
use dossier::{
    Agreement, DossierLine, FIGURES, Incomparable, MeasuredQuantity, PublishedFigure, PublishedRange, TOLD_APART,
    compare_scene,
};
use plotters::prelude::*;

use super::chart::{Drawn, FONT, INK, colour};
use super::sheet::{ReportSheet, write_text};
use super::specimen;
use crate::error::BenchError;

/// The scenes and figures of the README's six lines.
const README_SCENES: [&str; 2] = ["lower-back-training", "epidural-71kg"];
const README_FIGURES: [&str; 6] =
    ["skin_opening_force", "overall_slope", "veress_peak", "flavum_speed", "tearing_share", "friction_share"];
const HEIGHT_OF_ROW: u32 = 44;
const WIDTH: u32 = 960;
/// Room for the names of figures.
const NAMES: u32 = 380;
/// Least and greatest ratio that is drawn.
const SHOWN: (f64, f64) = (0.05, 20.0);

/// A scene beside every figure.
#[derive(Clone, Debug)]
pub struct SceneDossier {
    /// The scene's id.
    pub scene: String,
    /// A line for each figure, in their order.
    pub lines: Vec<DossierLine>,
}

/// Holds scenes beside every figure.
#[must_use]
pub fn make_dossiers(scenes: &[Scene]) -> Vec<SceneDossier> {
    scenes.iter().map(|scene| SceneDossier { scene: scene.id.clone(), lines: compare_scene(scene) }).collect()
}

/// Holds every shipped scene beside every figure.
///
/// # Errors
/// When the documents built in are refused, which a test would have shown.
pub fn make_shipped_dossiers() -> Result<Vec<SceneDossier>, BenchError> {
    Ok(make_dossiers(&specimen::read_shipped_scenes()?))
}

/// Writes `dossier.{md,csv,svg}` into a folder, and returns the files written.
///
/// # Errors
/// When the disk refuses.
pub fn write_dossiers(dossiers: &[SceneDossier], folder: &Path) -> Result<Vec<PathBuf>, BenchError> {
    let table = folder.join("dossier.csv");
    make_sheet(dossiers).write_csv(&table)?;
    let picture = folder.join("dossier.svg");
    draw(dossiers, &picture).map_err(|error| BenchError::work(format_args!("{}: {error}", picture.display())))?;
    let text = write_text(folder.join("dossier.md"), &format!("{}\n![](dossier.svg)\n", write_dossier_text(dossiers)))?;
    Ok(vec![text, table, picture])
}

/// The six lines of the README: what was published beside two scenes.
#[must_use]
pub fn list_readme_lines(dossiers: &[SceneDossier]) -> Vec<String> {
    let line = |id: &&str| {
        let figure = FIGURES.iter().find(|figure| figure.id == *id)?;
        let scenes = README_SCENES.iter().filter_map(|scene| dossiers.iter().find(|dossier| dossier.scene == *scene));
        let cells: Vec<String> = scenes
            .filter_map(|dossier| dossier.lines.iter().find(|line| line.figure.id == *id))
            .map(say_agreement)
            .collect();
        Some(format!("| {} | {} | {} |", figure.title, say_range(figure), cells.join(" | ")))
    };
    README_FIGURES.iter().filter_map(line).collect()
}

fn make_sheet(dossiers: &[SceneDossier]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
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
    ]);
    for dossier in dossiers {
        for line in &dossier.lines {
            sheet.row(row_of_line(&dossier.scene, line));
        }
    }
    sheet
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

/// The dossier in Markdown, without its picture.
#[must_use]
pub fn write_dossier_text(dossiers: &[SceneDossier]) -> String {
    let mut text = format!(
        "# Beside measurements\n\nMade by `stylet validate --out DIR` with stylet {}.\n\nWhat others have published, and what each scene gives \
         beside it: a needle goes straight into the layers alone at 5 mm/s. Nothing was tuned to agree, but where a scene was fitted to a \
         figure, which is said and proves nothing. A value without a spread is nothing to be inside of: its ratio is given. *Clearly above*: a \
         test told two means apart, and by how much was not published; a scene must be a twentieth above, which such a test would show (our choice). *Read* tells \
         whether the source's abstract was read here, or the figure was handed down without it.\n\n",
        env!("CARGO_PKG_VERSION")
    );
    let mut counts = ReportSheet::new(["scene", "inside", "outside", "beside a single value", "not comparable"]);
    for dossier in dossiers {
        let count =
            |of: fn(&Agreement) -> bool| dossier.lines.iter().filter(|line| of(&line.agreement)).count().to_string();
        counts.row([
            dossier.scene.clone(),
            count(|agreement| *agreement == Agreement::Inside),
            count(|agreement| *agreement == Agreement::Outside),
            count(|agreement| matches!(agreement, Agreement::Beside { .. })),
            count(|agreement| matches!(agreement, Agreement::Incomparable(_))),
        ]);
    }
    text.push_str(&counts.markdown());
    for (place, figure) in FIGURES.iter().enumerate() {
        write_figure(&mut text, figure, dossiers.iter().map(|dossier| (dossier.scene.as_str(), &dossier.lines[place])));
    }
    text
}

/// A figure, and the scenes beside it; scenes that are not comparable for the same reason in one line.
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
    let mut sheet = ReportSheet::new(["scene", "value", "published"]);
    let (mut compared, mut others) = (0, Vec::<(String, Vec<&str>)>::new());
    for (scene, line) in scenes {
        if let Agreement::Incomparable(why) = line.agreement {
            let why = say_why(why);
            match others.iter_mut().find(|(known, _)| *known == why) {
                Some((_, scenes)) => scenes.push(scene),
                None => others.push((why, vec![scene])),
            }
        } else {
            compared += 1;
            let value = line.value.map_or_else(String::new, |value| say_value(&figure.quantity, value));
            sheet.row([scene.to_owned(), value, say_verdict(line)]);
        }
    }
    if compared > 0 {
        text.push_str(&sheet.markdown());
    }
    for (why, scenes) in others {
        let _ = write!(text, "\nNot compared: {}: {why}.\n", scenes.join(", "));
    }
}

fn first_upper(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn say_why(why: Incomparable) -> String {
    match why {
        Incomparable::NoLayer(layer) => format!("no layer is called {layer}"),
        Incomparable::NotReached(layer) => format!("the needle ends before {layer} opens"),
        Incomparable::NoValues => "no values are published".to_owned(),
        Incomparable::Stated(why) => why.to_owned(),
    }
}

fn say_value(quantity: &MeasuredQuantity, value: f64) -> String {
    match quantity.unit() {
        "m" => format!("{:.1} mm", value * 1e3),
        "N" => format!("{value:.2} N"),
        "" if quantity.is_share() => format!("{:.0} %", value * 1e2),
        "" => format!("{value:.3}"),
        "s" => format!("{value:.3} s"),
        unit => format!("{value:.0} {unit}"),
    }
}

fn say_range(figure: &PublishedFigure) -> String {
    let say = |value: f64| say_value(&figure.quantity, value);
    match figure.range {
        PublishedRange::Between { low, high } => format!("{} to {}", say(low), say(high)),
        PublishedRange::Above(low) => format!("above {}", say(low)),
        PublishedRange::ToldApart(low) => format!("clearly above {}", say(low)),
        PublishedRange::Single(value) => say(value),
        PublishedRange::Unstated => "no values".to_owned(),
    }
}

fn say_verdict(line: &DossierLine) -> String {
    let verdict = match line.agreement {
        Agreement::Inside => "inside".to_owned(),
        Agreement::Outside => "**outside**".to_owned(),
        Agreement::Beside { ratio } => format!("× {ratio:.2}"),
        Agreement::Incomparable(why) => say_why(why),
    };
    if line.fitted { format!("{verdict}, fitted to it") } else { verdict }
}

fn say_agreement(line: &DossierLine) -> String {
    let Some(value) = line.value else { return "–".to_owned() };
    format!("{}, {}", say_value(&line.figure.quantity, value), say_verdict(line))
}

/// What is published at least and at most, over what it is in the middle: a bar in the picture. None where it is no range of values.
fn bar_of(figure: &PublishedFigure) -> Option<(f64, f64, f64)> {
    match figure.range {
        PublishedRange::Between { low, high } => {
            let middle = f64::midpoint(low, high);
            Some((middle, low / middle, high / middle))
        }
        PublishedRange::Above(low) => Some((low, 1.0, SHOWN.1)),
        PublishedRange::ToldApart(low) => Some((low, 1.0 + TOLD_APART, SHOWN.1)),
        PublishedRange::Single(value) => Some((value, 1.0, 1.0)),
        PublishedRange::Unstated => None,
    }
}

/// A row for each figure with which some scene was compared: a bar of what is published, a point for each scene, over the published
/// middle.
fn draw(dossiers: &[SceneDossier], path: &Path) -> Drawn {
    let compared = |place: &usize| dossiers.iter().any(|dossier| dossier.lines[*place].value.is_some());
    let shown: Vec<usize> = (0..FIGURES.len()).filter(compared).collect();
    let keys = dossiers.len().div_ceil(4) as u32;
    let height = 90 + HEIGHT_OF_ROW * shown.len() as u32 + 26 * keys;
    let root = SVGBackend::new(path, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let titled = root.titled("What scenes give, over what is published", (FONT, 22))?;
    let (plot, key) = titled.split_vertically(height - 40 - 26 * keys);
    let rows = shown.len() as f64;
    let mut canvas = ChartBuilder::on(&plot)
        .margin(16)
        .x_label_area_size(30)
        .y_label_area_size(NAMES)
        .build_cartesian_2d((SHOWN.0..SHOWN.1).log_scale(), rows..0.0)?;
    canvas
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_label_formatter(&|value: &f64| format!("× {value}"))
        .label_style((FONT, 14))
        .draw()?;
    for (row, place) in shown.iter().enumerate() {
        let (figure, y) = (&FIGURES[*place], row as f64 + 0.5);
        let Some((middle, low, high)) = bar_of(figure) else { continue };
        canvas.draw_series([Rectangle::new(
            [(low * 0.985, y - 0.28), (high * 1.015, y + 0.28)],
            BLACK.mix(0.22).filled(),
        )])?;
        for (index, dossier) in dossiers.iter().enumerate() {
            let Some(value) = dossier.lines[*place].value else { continue };
            let ratio = (value / middle).clamp(SHOWN.0, SHOWN.1);
            let apart = (index as f64 - (dossiers.len() as f64 - 1.0) / 2.0) * 0.5 / dossiers.len() as f64;
            canvas.draw_series([Circle::new((ratio, y + apart), 4, colour(index).filled())])?;
        }
        let label = format!("{}: {}", figure.title, say_range(figure));
        let (_, at) = canvas.backend_coord(&(SHOWN.0, y));
        root.draw(&Text::new(label, (16, at - 8), (FONT, 13).into_font().color(&INK)))?;
    }
    for (index, dossier) in dossiers.iter().enumerate() {
        let (x, y) = (20 + 235 * (index as i32 % 4), 14 + 26 * (index as i32 / 4));
        key.draw(&Circle::new((x, y), 4, colour(index).filled()))?;
        key.draw(&Text::new(dossier.scene.clone(), (x + 10, y - 7), (FONT, 14).into_font().color(&INK)))?;
    }
    root.present()?;
    Ok(())
}
