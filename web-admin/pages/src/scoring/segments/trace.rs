//! The page that marks a trace, and afterwards compares the marks with the pops.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::TraceId;
use model::recordings::series::TimeSpan;
use model::scoring::segments::{MOST_MARKS, MarksVerdict, TOLERANCE_S};

use crate::charts::{Extent, TRACE_LEFT, TRACE_RIGHT, TraceStrip};
use crate::form::FilledForm;
use crate::scoring::segments::{TaskRow, as_milliseconds};
use crate::{Shell, assets, charts, format};

/// Number of additional empty fields.
const SPARE: usize = 4;

/// The page of a trace.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/segments/trace.html")]
pub struct TracePage {
    /// Page frame.
    pub shell: Shell,
    /// The task.
    pub task: TaskRow,
    /// Id of the trace.
    pub trace: TraceId,
    /// Position of this trace among the visitor's, from 1, and their number.
    pub place: (usize, usize),
    /// Duration of the attempt, in s.
    pub duration_s: f64,
    /// The trace as a series of strips.
    pub strips: Vec<StripView>,
    /// The form with one text per mark.
    pub form: FilledForm<Vec<String>>,
    /// The true pops; `None` until they may be shown.
    pub found: Option<TraceTruth>,
    /// Address of the next trace that is not submitted.
    pub next: Option<String>,
}

/// A strip of the trace.
#[derive(Clone, Debug, PartialEq)]
pub struct StripView {
    /// Start, in s.
    pub from_s: f64,
    /// End, in s.
    pub to_s: f64,
    /// Drawing at both widths.
    pub drawing: String,
}

/// The true pops, compared with the marks.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceTruth {
    /// Comparison of marks and pops; `None` for an instructor, who only views the pops.
    pub verdict: Option<MarksVerdict>,
    /// Times of the pops, in s.
    pub pops: Vec<f64>,
}

/// A row in the table of pops and marks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PopLine {
    pop_s: Option<f64>,
    mark_s: Option<f64>,
}

impl PopLine {
    fn moment_s(&self) -> f64 {
        self.pop_s.or(self.mark_s).unwrap_or(0.0)
    }

    /// Formats the deviation of the mark from the pop in ms, with its sign.
    fn error(&self) -> Option<String> {
        let error_ms = self.pop_s.zip(self.mark_s).map(|(pop, mark)| (mark - pop) * 1e3)?;
        let sign = if error_ms > 0.0 { "+" } else { "" };
        Some(format!("{sign}{} ms", format::format_fixed(error_ms, 0)))
    }
}

impl StripView {
    /// Returns the strips of a trace, with marks and, once they may be shown, pops.
    #[must_use]
    pub fn all(spans: &[Vec<TimeSpan>], strips: &[(f64, f64)], marks: &[f64], pops: &[f64]) -> Vec<Self> {
        let ends = |pick: fn(&TimeSpan) -> f64| spans.iter().flatten().map(pick);
        let low = ends(|span| span.force_min_n).fold(0.0, f64::min);
        let high = ends(|span| span.force_max_n).fold(0.0, f64::max);
        let view = |(at, (from_s, to_s)): (usize, &(f64, f64))| {
            let strip = TraceStrip {
                number: at + 1,
                stretch_s: Extent::new(*from_s, *to_s),
                force_n: Extent::new(low, high),
                spans: spans.get(at).map_or(&[], Vec::as_slice),
                marks,
                pops,
            };
            Self {
                from_s: *from_s,
                to_s: *to_s,
                drawing: charts::draw_both_widths(|size| charts::draw_trace_strip(&strip, size)),
            }
        };
        strips.iter().enumerate().map(view).collect()
    }
}

impl TracePage {
    /// Returns the values of the filled fields, followed by empty ones.
    fn fields(&self) -> Vec<String> {
        let wanted = (self.form.typed.len() + SPARE).min(MOST_MARKS);
        let mut fields: Vec<String> = self.form.typed.iter().take(MOST_MARKS).cloned().collect();
        fields.resize(wanted, String::new());
        fields
    }

    fn edges(&self) -> (f64, f64) {
        (TRACE_LEFT, TRACE_RIGHT)
    }

    fn tolerance_ms(&self) -> String {
        format::format_fixed(TOLERANCE_S * 1e3, 0)
    }

    fn script(&self) -> String {
        assets::asset_address("segments.js")
    }

    /// Returns whether the visitor's own marks are compared with the pops.
    fn is_judged(&self) -> bool {
        self.found.as_ref().is_some_and(|found| found.verdict.is_some())
    }

    /// Returns pops, hit or missed, and false marks, in order of time.
    fn lines(&self) -> Vec<PopLine> {
        let Some(found) = &self.found else { return Vec::new() };
        let alone = |pop: &f64| PopLine { pop_s: Some(*pop), mark_s: None };
        let Some(verdict) = &found.verdict else { return found.pops.iter().map(alone).collect() };
        let mut lines: Vec<PopLine> =
            verdict.hits.iter().map(|(pop, mark)| PopLine { pop_s: Some(*pop), mark_s: Some(*mark) }).collect();
        lines.extend(verdict.missed.iter().map(alone));
        lines.extend(verdict.false_marks.iter().map(|mark| PopLine { pop_s: None, mark_s: Some(*mark) }));
        lines.sort_by(|a, b| a.moment_s().total_cmp(&b.moment_s()));
        lines
    }
}

#[cfg(test)]
mod tests {
    //! The pops must not be on the page before the marks are submitted; afterwards every figure
    //! must have its unit.

    use model::Role;

    use super::*;
    use crate::samples;

    fn page(found: Option<TraceTruth>) -> TracePage {
        let span = |n: u32| TimeSpan {
            t_s: f64::from(n) * 0.1,
            depth_min_mm: 0.0,
            depth_max_mm: 0.0,
            force_min_n: 0.2,
            force_max_n: 1.0 + f64::from(n % 7) * 0.2,
            lateral_max_n: 0.0,
        };
        let spans = [(0..50).map(span).collect(), (50..80).map(span).collect()];
        let pops = found.as_ref().map_or(&[][..], |found| &found.pops);
        TracePage {
            shell: samples::shell(Role::Trainee),
            task: TaskRow {
                href: "/segments/1".to_owned(),
                title: "Where are the pops?".to_owned(),
                cohort: "Spring".to_owned(),
                due: None,
                extended_days: 0,
                late: false,
                traces: 3,
                sent: 1,
            },
            trace: TraceId::nil(),
            place: (2, 3),
            duration_s: 8.0,
            strips: StripView::all(&spans, &[(0.0, 5.0), (5.0, 10.0)], &[2.0, 6.1], pops),
            form: FilledForm::new(vec!["2".to_owned(), "6.1".to_owned()]),
            found: found.clone(),
            next: None,
        }
    }

    #[test]
    fn a_trace_is_marked_with_numbers_alone_and_tells_nothing() {
        let html = samples::keep_page("segments-trace", &page(None));
        assert_eq!(html.matches("name=\"mark\"").count(), 6, "{html}");
        assert!(!html.contains("class=\"pop") && html.contains("value=\"6.1\""), "{html}");
        let open = page(None);
        let form = FilledForm::refused(open.form.typed, "pop 1: “x”".to_owned());
        let refused = TracePage { form, ..open };
        assert!(samples::keep_page("segments-trace-refused", &refused).contains("role=\"alert\""));
    }

    #[test]
    fn afterwards_pops_stand_beside_the_marks() {
        let pops = vec![2.1, 4.0];
        let verdict = MarksVerdict::of(&pops, &[2.0, 6.1]);
        let html = samples::keep_page("segments-trace-sent", &page(Some(TraceTruth { verdict: Some(verdict), pops })));
        for wanted in ["class=\"pop\"", "1 of 2", "−100 ms", "missed", "no pop here"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        assert!(!html.contains("name=\"mark\""));
    }
}
