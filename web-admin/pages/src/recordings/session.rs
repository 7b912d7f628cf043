//! The page of an attempt: score with reasons, curves, damage, verification.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::Uncounted;
use time::OffsetDateTime;

use crate::charts::{Drawing, moment_href};
use crate::scoring::exam_files::ExamFiles;
use crate::scoring::judgement::JudgementView;
use crate::{Shell, StatusWord, charts, format};

/// The page of an attempt.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "recordings/session.html")]
pub struct SessionPage {
    /// Page frame.
    pub shell: Shell,
    /// Title of the exercise.
    pub exercise: String,
    /// Address of the exercise's page, if the school publishes it.
    pub exercise_href: Option<String>,
    /// Name of the trainee and address of their page, if the visitor is another person.
    pub trainee: Option<(String, String)>,
    /// Start of the attempt.
    pub started_at: OffsetDateTime,
    /// Address of the replay.
    pub replay_href: String,
    /// Address of the grade's history.
    pub grade_href: String,
    /// Result of scoring.
    pub outcome: SessionOutcome,
    /// The override of the computed score.
    pub ruling: Option<Ruling>,
    /// The curves.
    pub drawing: Option<Drawing>,
    /// Why the attempt does not count, and the address of the attempt that it repeats, if the
    /// visitor may see that one.
    pub uncounted: Option<(Uncounted, Option<String>)>,
    /// Whether the attempt used a revision of the exercise that had already been replaced.
    pub is_replaced: bool,
    /// Result of the re-simulation.
    pub verification: VerificationResult,
    /// Name of the paired station that signed it.
    pub signed_by: Option<String>,
    /// Name of the supervisor who confirmed it.
    pub supervised_by: Option<String>,
    /// Surveys asked after this attempt: title, address and duration in min.
    pub surveys: Vec<(String, String, f64)>,
    /// Further facts: name and value.
    pub facts: Vec<(&'static str, String)>,
    /// Exam files, for people who may freeze the attempt.
    pub exam_files: Option<ExamFiles>,
}

impl SessionPage {
    /// Returns the address of the replay at the time that cost points.
    fn watched_at(&self, t_s: impl Borrow<f64>) -> String {
        moment_href(&self.replay_href, *t_s.borrow())
    }

    /// Returns the score that counts as a bar with the pass mark on it.
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

/// Describes briefly why an attempt does not count.
#[must_use]
pub fn uncounted_in_short(why: Uncounted) -> &'static str {
    match why {
        Uncounted::Unpublished => tr!("Exercise not published"),
        Uncounted::Duplicate => tr!("Same motion as before"),
    }
}

/// Result of scoring an attempt.
#[derive(Clone, Debug)]
pub enum SessionOutcome {
    /// Waiting in the queue.
    Waiting,
    /// Not scored, with the reason.
    Refused(String),
    /// Scored.
    Scored(Box<JudgementView>),
}

/// An override of a computed score.
#[derive(Clone, Debug, PartialEq)]
pub struct Ruling {
    /// Score, 0–100.
    pub score: f64,
    /// Whether it counts as a pass.
    pub passed: bool,
    /// Name of the person who set it.
    pub by: String,
    /// Reason given.
    pub reason: String,
}

/// Result of the server's re-simulation of the recorded input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VerificationResult {
    /// Not run yet.
    Waiting,
    /// All forces and events are identical.
    Same,
    /// Forces or events differ.
    Differs {
        /// Largest deviation of any force, in N.
        deviation_n: f64,
        /// Number of events that differ.
        events: i64,
    },
}

#[cfg(test)]
mod tests {
    //! The page must show the score with its breakdown, and state clearly if there is no score.

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
    fn exam_files_lead_to_their_downloads() {
        let html = samples::keep_page("session-exam-files", &samples::session_page());
        let files = samples::exam_files();
        for file in &files.files {
            let href = format!("/sessions/{}/exam-files/{}", files.session, file.id);
            assert_eq!(html.contains(&href), !file.is_erased, "{href}");
        }
        assert!(html.contains("Freeze for the exam board"));
        let page = SessionPage { exam_files: None, ..samples::session_page() };
        assert!(!samples::keep_page("session", &page).contains("exam-files"), "for a trainee");
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
