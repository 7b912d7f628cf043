//! The metrics: whether they tell experts from novices, agree with themselves, and what tremor and rate do to them.

mod crowd;
mod figures;

use std::path::{Path, PathBuf};

use assessment::catalogue::{DEFINITIONS, Definition};

use super::sheet::{self, Sheet};
use super::{What, measured_on};
use crate::exit::Failure;
use crowd::{Crowd, Size, crowds};
use figures::{Figures, LEAST_AGREEMENT, Pooled, Reading, SCORE};

/// Measures, and writes `metrics.{csv,md}`; returns the files written.
///
/// # Errors
/// When the disk refuses, or a shipped document is refused.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, Failure> {
    let size = if quick { Size::QUICK } else { Size::FULL };
    let crowds = crowds(size)?;
    let sheet = table(&crowds);
    let path = out.join("metrics.csv");
    sheet.write_csv(&path)?;
    let text = format!(
        "# Metrics\n\n{}\n\nVirtual hands, not people: {} novices and as many experts with an attempt each, and {} \
         people between the two with {} attempts each, at each of {} shipped exercises, every attempt on a patient of its own.\n\n\
         *Separation* is how often an expert's value is better than a novice's (area under the receiver's curve): 0.5 is chance, less \
         is the wrong way. *Agreement* is ICC(2,1) of a person's attempts. Both are means over exercises with 95 % intervals. *Tremor* \
         is what it changes of a value, the median over people; *rate* what a recording at 250 Hz in place of 1 kHz changes, the \
         largest; of a value next to 0 a little is a large share. A metric is not offered for rubrics where its whole interval of separation lies below 0.5, or that of agreement \
         below {LEAST_AGREEMENT}, and where a later version mends what the tremor does to it.\n\n{}",
        measured_on(What::Metrics, quick),
        size.group,
        size.people,
        size.attempts,
        size.exercises,
        sheet.markdown()
    );
    Ok(vec![path, sheet::write_text(out.join("metrics.md"), &text)?])
}

fn table(crowds: &[Crowd]) -> Sheet {
    let mut sheet = Sheet::new([
        "metric",
        "version",
        "separation",
        "separation_low",
        "separation_high",
        "agreement",
        "agreement_low",
        "agreement_high",
        "tremor_percent",
        "rate_percent",
        "found",
        "offered",
    ]);
    let scores = Figures::of(&Reading::of_scores(crowds));
    row(&mut sheet, (SCORE, 1), &scores, None);
    for definition in DEFINITIONS {
        let figures = Figures::of(&Reading::of(definition, crowds));
        row(&mut sheet, (definition.id, definition.version), &figures, Some(definition));
    }
    sheet
}

fn row(sheet: &mut Sheet, (id, version): (&str, u32), figures: &Figures, definition: Option<&Definition>) {
    let interval = |of: Option<Pooled>| {
        of.map_or_else(Default::default, |p| [p.value, p.low, p.high].map(|value| format!("{value:.2}")))
    };
    let percent = |share: Option<f64>| share.map_or_else(String::new, |share| format!("{:.1}", 1e2 * share));
    let found = match (figures.wrong_way(), figures.disagrees()) {
        (true, true) => "wrong way, does not agree",
        (true, false) => "wrong way",
        (false, true) => "does not agree",
        (false, false) => "",
    };
    let offered = definition.map_or("", |d| if d.unoffered.is_empty() { "yes" } else { "no" });
    let mut cells = vec![id.to_owned(), version.to_string()];
    cells.extend(interval(figures.separation));
    cells.extend(interval(figures.agreement));
    cells.extend([percent(figures.tremor), percent(figures.rate), found.to_owned(), offered.to_owned()]);
    sheet.row(cells);
}
