//! One attempt: score with reasons, curves, damage, verification.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use attempt::{AttemptCurve, BoundaryStage, StageSpan};
use model::Uncounted;
use recording::keep_extremes;
use time::OffsetDateTime;

use super::judgement::JudgementView;
use super::{Shell, StatusWord, anatomy, charts, format};

/// The page of an attempt.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "session.html")]
pub struct SessionPage {
    /// Frame.
    pub shell: Shell,
    /// The exercise's title.
    pub exercise: String,
    /// The exercise's page, where the school publishes it.
    pub exercise_href: Option<String>,
    /// The trainee's name and page, where the visitor is somebody else.
    pub trainee: Option<(String, String)>,
    /// When the attempt began.
    pub started_at: OffsetDateTime,
    /// Where it is watched again.
    pub replay_href: String,
    /// Where the history of its grade is.
    pub grade_href: String,
    /// What became of it.
    pub outcome: SessionOutcome,
    /// What somebody has put in place of the computed score.
    pub ruling: Option<Ruling>,
    /// The curves.
    pub drawing: Option<Drawing>,
    /// Why it counts nowhere, and the page of the attempt that it repeats, where the visitor may see that.
    pub uncounted: Option<(Uncounted, Option<String>)>,
    /// The school has published its exercise, and replaced it before the attempt.
    pub is_replaced: bool,
    /// The server's re-simulation.
    pub verification: VerificationResult,
    /// The paired station that has signed it.
    pub signed_by: Option<String>,
    /// Whoever was there, as they have confirmed.
    pub supervised_by: Option<String>,
    /// What is asked after this attempt: title, address and minutes.
    pub surveys: Vec<(String, String, f64)>,
    /// What else is known: name and value.
    pub facts: Vec<(&'static str, String)>,
}

impl SessionPage {
    /// Where the second is watched that cost points.
    fn watched_at(&self, t_s: impl Borrow<f64>) -> String {
        moment_href(&self.replay_href, *t_s.borrow())
    }

    /// The score that counts as a bar with the pass mark on it.
    fn counting_bar(&self) -> String {
        let SessionOutcome::Scored(judgement) = &self.outcome else { return String::new() };
        self.ruling
            .as_ref()
            .map_or_else(|| judgement.bar.clone(), |ruling| charts::draw_score_bar(ruling.score, judgement.pass_mark))
    }

    fn uncounted_words(&self) -> &'static str {
        self.uncounted.as_ref().map_or("", |(why, _)| uncounted_in_short(*why))
    }
}

/// Why an attempt counts nowhere, in a few words.
#[must_use]
pub fn uncounted_in_short(why: Uncounted) -> &'static str {
    match why {
        Uncounted::Unpublished => tr!("Exercise not published"),
        Uncounted::Duplicate => tr!("Same motion as before"),
    }
}

/// What became of an attempt.
#[derive(Clone, Debug)]
pub enum SessionOutcome {
    /// In the queue.
    Waiting,
    /// Not to be scored, with the reason.
    Refused(String),
    /// Scored.
    Scored(Box<JudgementView>),
}

/// What somebody has put in place of a computed score.
#[derive(Clone, Debug, PartialEq)]
pub struct Ruling {
    /// 0–100.
    pub score: f64,
    /// It counts as a pass.
    pub passed: bool,
    /// Who.
    pub by: String,
    /// Why.
    pub reason: String,
}

/// What the server's own re-simulation of the recorded input found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VerificationResult {
    /// Not run yet.
    Waiting,
    /// Every force and event is the same.
    Same,
    /// Something differs.
    Differs {
        /// Largest deviation of any force, in N.
        deviation_n: f64,
        /// Events that differ.
        events: i64,
    },
}

/// The curves as drawings and tables.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Force against depth, for both widths.
    pub force_depth: String,
    /// Force and depth against time, for both widths.
    pub force_time: String,
    /// Numbered events.
    pub marks: Vec<MarkRow>,
    /// Stages of each boundary.
    pub stages: Vec<StageRow>,
    /// Name, beginning and end of each layer, in mm along the needle.
    pub layers: Vec<(String, f64, f64)>,
    /// Time, way along the needle and force at about twenty moments, the peaks among them.
    pub points: Vec<(f64, f64, f64)>,
    /// The page on which the attempt is watched again; absent where whoever sees the drawing must not know whose it is.
    pub replay: Option<String>,
}

/// A numbered event.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkRow {
    /// Number in the drawings.
    pub number: usize,
    /// What happened.
    pub what: String,
    /// When, in s.
    pub t_s: f64,
    /// Where, in mm along the needle.
    pub advance_mm: f64,
    /// Axial force on the hand just before, in N.
    pub force_n: f64,
}

/// A stage of a boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct StageRow {
    /// The layer below the boundary.
    pub boundary: String,
    /// The stage.
    pub stage: BoundaryStage,
    /// Where it began, in mm along the needle.
    pub from_mm: f64,
    /// Where it ended, in mm along the needle.
    pub to_mm: f64,
}

/// The address of a second in a replay.
#[must_use]
pub fn moment_href(replay: &str, t_s: f64) -> String {
    format!("{replay}?t={}", format::plain_seconds(t_s))
}

/// Most rows of the table of the curve.
const TABLE_ROWS: usize = 24;

impl Drawing {
    /// Draws a curve.
    #[must_use]
    pub fn new(curve: &AttemptCurve) -> Self {
        let curve = &anatomy::name_layers_of_curve(curve);
        let rows = keep_extremes(&curve.points, TABLE_ROWS, |point| point.force_n).into_iter();
        Self {
            force_depth: charts::draw_both_widths(|size| charts::draw_force_over_depth(curve, size)),
            force_time: charts::draw_both_widths(|size| charts::draw_force_and_depth(curve, size)),
            marks: charts::number_marks(curve)
                .map(|(number, mark)| MarkRow {
                    number,
                    what: anatomy::say_event(mark.kind, &mark.name),
                    t_s: mark.t_s,
                    advance_mm: mark.advance_mm,
                    force_n: mark.axial_n,
                })
                .collect(),
            stages: make_stage_rows(curve),
            layers: curve.bands.iter().map(|b| (b.name.clone(), b.top_mm, b.bottom_mm)).collect(),
            points: rows.map(|p| (p.t_s, p.advance_mm, p.force_n)).collect(),
            replay: None,
        }
    }

    /// The same, its events leading to their second of a replay.
    #[must_use]
    pub fn leading_to(self, replay: &str) -> Self {
        Self { replay: Some(replay.to_owned()), ..self }
    }

    /// Where a second of the attempt is watched.
    pub(crate) fn watched_at(&self, t_s: impl Borrow<f64>) -> Option<String> {
        self.replay.as_ref().map(|replay| moment_href(replay, *t_s.borrow()))
    }
}

fn make_stage_rows(curve: &AttemptCurve) -> Vec<StageRow> {
    let row = |span: &StageSpan| StageRow {
        boundary: curve.bands.get(span.boundary).map_or_else(String::new, |b| b.name.clone()),
        stage: span.stage,
        from_mm: span.from_mm,
        to_mm: span.to_mm,
    };
    curve.stages.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    //! The page must show the score with its arithmetic, and say plainly when there is none.

    use super::*;
    use crate::samples;

    #[test]
    fn a_scored_attempt_shows_its_arithmetic() {
        let html = samples::keep_page("session", &samples::session_page());
        for wanted in
            ["out of 100", "Passed", "1.9 mm too deep", "−4.8", "Rim into fat", "full marks", "mJ", "identical", ">81<"]
        {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
        assert!(html.matches("<caption").count() >= 5, "each table says what it is");
        assert!(html.contains("/sessions/0190/replay?t=19.00"), "a lost point leads to its second");
        assert!(html.matches("<details class=\"theme\"").count() >= 3, "what earns no points is folded");
        assert!(html.contains("2.30 (1.90 to 2.70"), "the cohort stands beside it");
    }

    #[test]
    fn what_counts_leads_where_a_score_is_overridden() {
        let ruling = Ruling { score: 72.0, passed: false, by: "Dr Osei".to_owned(), reason: "A second try".to_owned() };
        let page = SessionPage { ruling: Some(ruling), ..samples::session_page() };
        let html = samples::keep_page("session-overridden", &page);
        let (counts, computed) = (html.find("<strong>72</strong>"), html.find("Computed from the recording: 81"));
        assert!(counts.is_some() && counts < computed, "{html}");
        assert!(html.contains("A second try") && !html.contains("<strong>81</strong>"));
    }

    #[test]
    fn a_waiting_attempt_says_so() {
        let page = SessionPage {
            outcome: SessionOutcome::Waiting,
            drawing: None,
            verification: VerificationResult::Waiting,
            ..samples::session_page()
        };
        assert!(samples::keep_page("session-waiting", &page).contains("is being scored"));
    }

    #[test]
    fn a_refused_attempt_gives_the_reason() {
        let outcome = SessionOutcome::Refused("the recording holds no samples".to_owned());
        let page = SessionPage { outcome, drawing: None, ..samples::session_page() };
        assert!(samples::keep_page("session-refused", &page).contains("the recording holds no samples"));
    }

    #[test]
    fn a_deviation_is_shown_as_a_warning() {
        let page = SessionPage {
            verification: VerificationResult::Differs { deviation_n: 0.25, events: 2 },
            ..samples::session_page()
        };
        let html = samples::keep_page("session-differs", &page);
        assert!(html.contains("differs from the recording") && html.contains("0.25"));
    }
}
