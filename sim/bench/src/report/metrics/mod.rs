//! The metrics: separation of experts and novices, agreement between attempts, and effects of
//! tremor and recording rate.

mod crowd;
mod figures;

use std::path::{Path, PathBuf};

use assessment::catalogue::{DEFINITIONS, Definition};
use crowd::{Crowd, Size, crowds};
use figures::{BY_CONTENT, FAIR, Figures, JUDGED_BY, MetricReading, Pooled, SCORE, least_agreement};

use super::sheet::{self, ReportSheet};
use super::{Subject, measured_on};
use crate::error::BenchError;

/// Measures and writes `metrics.{csv,md}`; returns the files written.
///
/// # Errors
/// On an I/O error, or if a shipped document is refused.
pub fn measure(out: &Path, quick: bool) -> Result<Vec<PathBuf>, BenchError> {
    let size = if quick { Size::QUICK } else { Size::FULL };
    let crowds = crowds(size)?;
    let sheet = table(&crowds);
    let path = out.join("metrics.csv");
    sheet.write_csv(&path)?;
    let text = format!(
        "# Metrics\n\n{}\n\nVirtual hands, not people: {} novices and as many experts with an attempt each, and {} \
         people between the two with an attempt on each of {} days, at each of {} shipped exercises, every attempt on a patient of its own.\n\n\
         *Separation* is how often an expert's value is better than a novice's (area under the receiver's curve): 0.5 is chance, less \
         is the wrong way. *Agreement* is ICC(2,1) of a person's attempts. Both are means with 95 % intervals, over the exercises at which not everybody's \
         value is the same. *Tremor* is what it changes of a value, the median over people; *rate* what a recording at 250 Hz in place \
         of 1 kHz changes, the largest; of a value next to 0 a little is a large share.\n\n\
         A metric is offered for rubrics where all this holds. Its interval of separation lies above 0.5: that experts are better by it is no \
         chance, and some hand does it at all. The mean of {JUDGED_BY} attempts, by which the shipped course judges, agrees with that of {JUDGED_BY} others by {FAIR:.2} or more, \
         the least that Cicchetti (1994) calls fair; by Spearman and Brown that is an agreement of single attempts of {:.3}. And no later version mends \
         what the tremor does to it. What must or must not happen ({}) is offered for its content, whatever a comparison of groups shows: \
         the patient's tissue sets the force of a rupture, so that its presence matters and not its size, and a needle that errs away from a \
         structure has more clearance than one on the planned line.\n\n{}",
        measured_on(Subject::Metrics, quick),
        size.group,
        size.people,
        size.attempts,
        size.exercises,
        least_agreement(),
        BY_CONTENT.join(", "),
        sheet.markdown()
    );
    Ok(vec![path, sheet::write_text(out.join("metrics.md"), &text)?])
}

fn table(crowds: &[Crowd]) -> ReportSheet {
    let mut sheet = ReportSheet::new([
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
    let scores = Figures::from_readings(&MetricReading::of_scores(crowds));
    row(&mut sheet, SCORE, 1, &scores, None);
    for definition in DEFINITIONS {
        let figures = Figures::from_readings(&MetricReading::of_metric(definition, crowds));
        row(&mut sheet, definition.id, definition.version, &figures, Some(definition));
    }
    sheet
}

fn row(sheet: &mut ReportSheet, id: &str, version: u32, figures: &Figures, definition: Option<&Definition>) {
    let interval = |of: Option<Pooled>| {
        of.map_or_else(Default::default, |p| [p.value, p.low, p.high].map(|value| format!("{value:.2}")))
    };
    let percent = |share: Option<f64>| share.map_or_else(String::new, |share| format!("{:.1}", 1e2 * share));
    let found = if BY_CONTENT.contains(&id) { "by content".to_owned() } else { figures.found() };
    let offered = definition.map_or("", |d| if d.unoffered.is_empty() { "yes" } else { "no" });
    let mut cells = vec![id.to_owned(), version.to_string()];
    cells.extend(interval(figures.separation));
    cells.extend(interval(figures.agreement));
    cells.extend([percent(figures.tremor), percent(figures.rate), found, offered.to_owned()]);
    sheet.row(cells);
}
