//! Comparison of a scene with published measurements.

use documents::Scene;
use dossier::{Agreement, CURVE_AXES, CurveWords, DossierLine, MeasuredQuantity, PublishedRange, draw_force_curve};

use crate::{anatomy, format};

/// A published figure, and the scene's value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeasuredLine {
    /// Name of the measured quantity.
    pub title: &'static str,
    /// Specimen and method.
    pub conditions: &'static str,
    /// Published value or range.
    pub published: String,
    /// Value of the scene.
    pub value: String,
    /// Agreement of the two.
    pub verdict: String,
    /// Citation of the publication.
    pub citation: &'static str,
    /// Address of the publication; `None` without a DOI.
    pub href: Option<String>,
    /// Provenance: whether the publication was read or is recalled.
    pub known: &'static str,
}

/// Returns the figures with which a scene can be compared, in the order of the dossier.
#[must_use]
pub fn list_measured_lines(lines: &[DossierLine]) -> Vec<MeasuredLine> {
    lines.iter().filter_map(make_measured_line).collect()
}

/// Draws the force of a scene's layers against depth, with the published ranges, in the reader's
/// language. `lines` is the scene's comparison.
#[must_use]
pub fn draw_scene_curve(scene: &Scene, lines: &[DossierLine]) -> String {
    let axes = CURVE_AXES.map(words::say);
    draw_force_curve(scene, lines, &CurveWords { axes, name_layer: &anatomy::say_structure, describe: &describe_line })
}

/// Describes a line in the reader's language.
fn describe_line(line: &DossierLine) -> String {
    let figure = line.figure;
    let value = say_value(&figure.quantity, line.value.unwrap_or_default());
    format!("{}: {value} ({})", words::say(figure.title), say_range(&figure.quantity, &figure.range))
}

fn make_measured_line(line: &DossierLine) -> Option<MeasuredLine> {
    let (figure, value) = (line.figure, line.value?);
    let source = figure.source;
    Some(MeasuredLine {
        title: words::say(figure.title),
        conditions: words::say(figure.conditions),
        published: say_range(&figure.quantity, &figure.range),
        value: say_value(&figure.quantity, value),
        verdict: say_verdict(line),
        citation: source.citation,
        href: (!source.doi.is_empty()).then(|| format!("https://doi.org/{}", source.doi)),
        known: words::say(source.known.words()),
    })
}

fn say_verdict(line: &DossierLine) -> String {
    let verdict = match line.agreement {
        Agreement::Inside => tr!("inside").to_owned(),
        Agreement::Outside => match line.excepted {
            Some(why) => format!("{}: {}", tr!("outside"), words::say(why)),
            None => tr!("outside").to_owned(),
        },
        Agreement::SingleValue { ratio } => tr!("{ratio} times the value", ratio = format::format_fixed(ratio, 2)),
        Agreement::Incomparable(_) => tr!("not comparable").to_owned(),
    };
    if line.fitted { tr!("{verdict}; the scene was fitted to it", verdict = verdict) } else { verdict }
}

fn say_range(quantity: &MeasuredQuantity, range: &PublishedRange) -> String {
    let say = |value: f64| say_value(quantity, value);
    match *range {
        PublishedRange::Between { low, high } => tr!("{low} to {high}", low = say(low), high = say(high)),
        PublishedRange::Means { low, high } if low < high => {
            tr!("means {low} to {high}, ± 25 %", low = say(low), high = say(high))
        }
        PublishedRange::Means { low, .. } => tr!("mean {low}, ± 25 %", low = say(low)),
        PublishedRange::Spread { mean, deviation } => {
            tr!("{mean} ± 2 × {deviation}", mean = say(mean), deviation = say(deviation))
        }
        PublishedRange::Above(low) => tr!("above {low}", low = say(low)),
        PublishedRange::Distinguishable(low) => tr!("clearly above {low}", low = say(low)),
        PublishedRange::Single(value) => say(value),
        PublishedRange::Unstated => tr!("no values").to_owned(),
    }
}

fn say_value(quantity: &MeasuredQuantity, value: f64) -> String {
    match quantity.unit() {
        "m" => format::format_quantity(value * 1e3, "mm"),
        "" if quantity.is_share() => format::format_percent(value),
        "" => format::format_fixed(value, 3),
        unit => format::format_quantity(value, unit),
    }
}

#[cfg(test)]
mod tests {
    //! Each figure must keep its unit, its source and its agreement with the scene.

    use dossier::FIGURES;

    use super::*;

    #[test]
    fn measured_line_shows_the_published_value_and_the_verdict() {
        let line = |id: &str, value: f64, agreement: Agreement| {
            let figure = FIGURES.iter().find(|figure| figure.id == id).expect("it is published");
            DossierLine { figure, value: Some(value), agreement, fitted: id == "epidural_skin_depth", excepted: None }
        };
        let said = list_measured_lines(&[
            line("skin_peak", 1.0, Agreement::Outside),
            line("epidural_skin_depth", 13.9e-3, Agreement::SingleValue { ratio: 0.998 }),
            line("tearing_share", 0.81, Agreement::SingleValue { ratio: 1.33 }),
        ]);
        let cells: Vec<_> = said.iter().map(|line| [&*line.published, &*line.value, &*line.verdict]).collect();
        assert_eq!(cells[0], ["means 2.75\u{a0}N to 2.80\u{a0}N, ± 25 %", "1.00\u{a0}N", "outside"]);
        assert_eq!(cells[1], ["13.9\u{a0}mm", "13.9\u{a0}mm", "1.00 times the value; the scene was fitted to it"]);
        assert_eq!(cells[2][1..], ["81\u{a0}%", "1.33 times the value"]);
        assert_eq!(said[0].href.as_deref(), Some("https://doi.org/10.1089/end.2016.0342"));
        let silent = DossierLine { value: None, ..line("skin_peak", 1.0, Agreement::Outside) };
        assert!(list_measured_lines(&[silent]).is_empty(), "what cannot be compared is not shown");
    }
}
