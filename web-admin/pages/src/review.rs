//! What waits to be looked at, and the whole history of a grade.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use assessment::Assessment;
use model::ids::SessionId;
use model::judgement::TypedOverride;
use model::review::{ReviewFilter, ReviewReason};
use time::OffsetDateTime;

use super::form::FilledForm;
use super::people::SelectOption;
use super::{Shell, StatusWord, format, metric};

/// The queue of attempts that wait.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "review.html")]
pub struct ReviewPage {
    /// Frame.
    pub shell: Shell,
    /// With questions first, then flagged, then failed, then the oldest.
    pub waiting: Vec<WaitingRow>,
    /// The next stretch of the queue, where there is one.
    pub next: Option<String>,
    /// The first stretch, where this is a later one.
    pub first: Option<String>,
    /// Which attempts are shown.
    pub filter: ReviewFilter,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
    /// Exercises to choose from.
    pub exercises: Vec<SelectOption>,
    /// Ratings that the visitor is asked for.
    pub to_rate: u32,
}

impl ReviewPage {
    fn picked(&self, reason: impl Borrow<ReviewReason>) -> bool {
        self.filter.reason.as_ref() == Some(reason.borrow())
    }

    fn limited(&self) -> bool {
        self.filter != ReviewFilter::default()
    }

    /// The replay of an attempt, which leads on through the same part of the queue.
    fn replay_of(&self, session: impl Borrow<SessionId>) -> String {
        let query = self.filter.query();
        let mark = if query.is_empty() { "" } else { "?" };
        format!("/sessions/{}/replay{mark}{query}", session.borrow())
    }
}

/// An attempt that waits.
#[derive(Clone, Debug, PartialEq)]
pub struct WaitingRow {
    /// The attempt.
    pub session: SessionId,
    /// When it began.
    pub at: OffsetDateTime,
    /// Who tried.
    pub trainee: String,
    /// Title of the exercise.
    pub exercise: String,
    /// 0–100, by the grade that counts.
    pub score: f64,
    /// Passed or not.
    pub status: StatusWord,
    /// The re-simulation differs.
    pub flagged: bool,
    /// Questions that nobody has answered.
    pub questions: i64,
}

/// The history of a grade.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "grade.html")]
pub struct GradePage {
    /// Frame.
    pub shell: Shell,
    /// The attempt.
    pub attempt: JudgedAttempt,
    /// What counts now: 0–100, and whether it is a pass; absent before the attempt is scored.
    pub counts: Option<(f64, bool)>,
    /// The newest computed score, 0–100.
    pub computed: Option<f64>,
    /// An override counts.
    pub overridden: bool,
    /// Everything that happened to the grade, oldest first.
    pub history: Vec<GradeHistoryEntry>,
    /// Who has looked at the attempt, and when.
    pub reviewed: Option<(String, OffsetDateTime)>,
    /// Who was there during the attempt, and when they confirmed it.
    pub supervised: Option<(String, OffsetDateTime)>,
    /// What raters gave it.
    pub ratings: Vec<RatedMean>,
    /// The visitor may judge.
    pub judge: bool,
    /// What is typed into the form of an override.
    pub form: FilledForm<TypedOverride>,
}

/// The mean of what several raters gave.
#[derive(Clone, Debug, PartialEq)]
pub struct RatedMean {
    /// Title of the round.
    pub round: String,
    /// Page of the round.
    pub href: String,
    /// Title of the score.
    pub score: String,
    /// The mean.
    pub mean: f64,
    /// Raters who gave a score.
    pub raters: usize,
    /// The ratings were made by a program.
    pub generated: bool,
}

/// The attempt that a page of judgement is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JudgedAttempt {
    /// Session.
    pub id: SessionId,
    /// The exercise's title.
    pub exercise: String,
    /// The trainee's name and page, where the visitor is somebody else.
    pub trainee: Option<(String, String)>,
    /// When it began.
    pub started_at: OffsetDateTime,
}

/// Something that happened to a grade.
#[derive(Clone, Debug, PartialEq)]
pub struct GradeHistoryEntry {
    /// When.
    pub at: OffsetDateTime,
    /// What.
    pub act: GradeAct,
    /// The score, 0–100, and whether it is a pass; absent where the computed score counts again.
    pub grade: Option<(f64, bool)>,
}

/// What was done to a grade.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GradeAct {
    /// Computed from the recording, by a rubric (the beginning of its hash).
    Computed(String),
    /// Computed again.
    Regraded {
        /// By which rubric.
        rubric: String,
        /// Who had this attempt or every attempt at the exercise graded again, and why; absent where no reason was kept.
        why: Option<(String, String)>,
    },
    /// Somebody put another in its place, for a reason.
    Overridden {
        /// Who.
        by: String,
        /// Why.
        reason: String,
    },
    /// Somebody let the computed score count again, for a reason.
    Withdrawn {
        /// Who.
        by: String,
        /// Why.
        reason: String,
    },
}

impl GradePage {
    fn chose(&self, result: &str) -> bool {
        self.form.typed.result == result
    }
}

/// What an attempt would score by the rubric that its exercise has now.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "regrade.html")]
pub struct RegradePage {
    /// Frame.
    pub shell: Shell,
    /// The attempt.
    pub attempt: JudgedAttempt,
    /// The newest computed score, 0–100, and whether it is a pass.
    pub before: (f64, bool),
    /// What it would be.
    pub after: (f64, bool),
    /// The rubric is the same.
    pub same: bool,
    /// What costs points by the rubric of today: reason and points.
    pub lost: Vec<(String, f64)>,
    /// Why it would fail whatever its points by the rubric of today.
    pub failures: Vec<String>,
    /// The reason.
    pub reason: FilledForm<String>,
}

/// What costs points in an assessment: reason and points, dearest first.
#[must_use]
pub fn list_deductions(assessment: &Assessment) -> Vec<(String, f64)> {
    let dear = assessment.deductions.iter().filter(|d| d.points > 0.0);
    dear.map(|d| (metric::short_deduction_reason(d), d.points)).collect()
}

/// Why an assessment fails whatever its points.
#[must_use]
pub fn list_failures(assessment: &Assessment) -> Vec<String> {
    assessment.hard_fails.iter().map(metric::say_failure).collect()
}

#[cfg(test)]
mod tests {
    //! The computed score must stay in sight of whatever was put in its place.

    use model::Role;

    use super::*;
    use crate::samples;

    fn judged() -> JudgedAttempt {
        let trainee = Some(("Ana Lindqvist".to_owned(), "/trainees/1".to_owned()));
        JudgedAttempt {
            id: SessionId::nil(),
            exercise: "Stop in the fat".to_owned(),
            trainee,
            started_at: samples::NOW,
        }
    }

    fn grade_page() -> GradePage {
        let by = || "Dr Osei".to_owned();
        let entry = |act, grade| GradeHistoryEntry { at: samples::NOW, act, grade };
        GradePage {
            shell: samples::shell(Role::Instructor),
            attempt: judged(),
            counts: Some((72.0, true)),
            computed: Some(64.0),
            overridden: true,
            history: vec![
                entry(GradeAct::Computed("abc123".to_owned()), Some((61.0, false))),
                entry(
                    GradeAct::Regraded {
                        rubric: "def456".to_owned(),
                        why: Some((by(), "A <milder> rubric".to_owned())),
                    },
                    Some((64.0, false)),
                ),
                entry(GradeAct::Overridden { by: by(), reason: "The <device> slipped".to_owned() }, Some((72.0, true))),
                entry(GradeAct::Withdrawn { by: by(), reason: "It did not".to_owned() }, None),
            ],
            reviewed: Some((by(), samples::NOW)),
            supervised: Some((by(), samples::NOW)),
            ratings: vec![RatedMean {
                round: "Spring round".to_owned(),
                href: "/ratings/1".to_owned(),
                score: "Global rating (7–35)".to_owned(),
                mean: 24.25,
                raters: 4,
                generated: false,
            }],
            judge: true,
            form: FilledForm::default(),
        }
    }

    #[test]
    fn the_history_of_a_grade_is_whole() {
        let html = samples::keep_page("grade", &grade_page());
        for wanted in [
            "72",
            "64",
            "61",
            "abc123",
            "The &#60;device&#62; slipped",
            "A &#60;milder&#62; rubric",
            "It did not",
            "Dr Osei",
        ] {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
        let trainee = GradePage { judge: false, shell: samples::shell(Role::Trainee), ..grade_page() };
        let html = samples::keep_page("grade-trainee", &trainee);
        assert!(html.contains("24.3") || html.contains("24.2"), "the mean of the raters: {html}");
        assert!(!html.contains("/ratings/1"), "a trainee does not see who gave what");
        assert!(!html.contains("/override") && html.contains("slipped"), "a trainee reads, and does not judge");
    }

    #[test]
    fn a_refused_override_keeps_what_was_typed() {
        let typed = TypedOverride { score: "720".to_owned(), result: "failed".to_owned(), reason: "x < y".to_owned() };
        let page = GradePage { form: FilledForm::refused(typed, "score: \"720\"".to_owned()), ..grade_page() };
        let html = samples::keep_page("grade-refused", &page);
        assert!(html.contains("value=\"720\"") && html.contains("x &#60; y") && html.contains("score: &#34;720&#34;"));
    }

    #[test]
    fn the_queue_says_what_to_do_and_when_it_is_empty() {
        let row = WaitingRow {
            session: SessionId::nil(),
            at: samples::NOW,
            trainee: "Ana Lindqvist".to_owned(),
            exercise: "Stop in the fat".to_owned(),
            score: 64.0,
            status: StatusWord::Failed,
            flagged: true,
            questions: 2,
        };
        let shell = samples::shell(Role::Instructor);
        let filter = ReviewFilter { reason: Some(ReviewReason::Failed), ..ReviewFilter::default() };
        let page = ReviewPage {
            shell: shell.clone(),
            waiting: vec![row],
            next: Some("/review?what=failed&after=1".to_owned()),
            first: Some("/review?what=failed".to_owned()),
            filter,
            cohorts: vec![],
            exercises: vec![],
            to_rate: 3,
        };
        let html = samples::keep_page("review", &page);
        assert!(
            html.contains("2 questions")
                && html.contains("Rate 3 attempts")
                && html.contains("/replay")
                && html.contains("Re-simulation differs")
        );
        assert!(html.contains("/replay?what=failed") && html.contains("rel=\"next\""), "it leads on: {html}");
        let empty = ReviewPage { shell, waiting: vec![], next: None, first: None, ..page };
        assert!(samples::keep_page("review-none", &empty).contains("None of the attempts that wait"));
        let empty = ReviewPage { filter: ReviewFilter::default(), ..empty };
        assert!(samples::keep_page("review-empty", &empty).contains("Nothing waits"));
    }

    #[test]
    fn a_regrading_shows_both_scores_before_it_is_done() {
        let page = RegradePage {
            shell: samples::shell(Role::Instructor),
            attempt: judged(),
            before: (61.0, false),
            after: (74.0, true),
            same: false,
            lost: vec![("1.9 mm too deep".to_owned(), 12.0)],
            failures: vec![],
            reason: FilledForm::refused("the mark was < 60".to_owned(), "reason: empty".to_owned()),
        };
        let html = samples::keep_page("regrade", &page);
        assert!(html.contains("61") && html.contains("74") && html.contains("1.9 mm too deep"));
        let same = RegradePage { same: true, ..page };
        assert!(samples::keep_page("regrade-same", &same).contains("has not changed"));
    }
}
