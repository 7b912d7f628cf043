//! Regrading of all attempts at an exercise by another rubric: selection, preview and confirmation.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::ids::{RegradingId, SessionId};
use model::scoring::regrading::{OutcomeCount, RegradingLine, RegradingOutcome, RegradingState, count_attempts};
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::{FilledForm, SelectOption};
use crate::{Shell, StatusWord, format};

/// The page that selects a rubric.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/regrading/choose.html")]
pub struct ChooseRubricPage {
    /// Page frame.
    pub shell: Shell,
    /// Title and address of the exercise.
    pub exercise: (String, String),
    /// Revisions to choose from, newest first.
    pub revisions: Vec<SelectOption>,
    /// Earlier regradings, latest first.
    pub earlier: Vec<EarlierRegrading>,
    /// Whether the visitor's attempts are all of the school's.
    pub whole_school: bool,
}

/// A regrading in a list.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierRegrading {
    /// Address of its page.
    pub href: String,
    /// Time of the preview.
    pub at: OffsetDateTime,
    /// Name of the person who requested it.
    pub by: String,
    /// State of the regrading.
    pub state: RegradingState,
    /// Reason given on confirmation.
    pub reason: Option<String>,
}

/// Filter of the attempts listed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RegradingFilter {
    /// Attempts whose score or result changes.
    #[default]
    Changes,
    /// Attempts that newly pass.
    Passes,
    /// Attempts that no longer pass.
    Fails,
    /// Attempts with a different score and the same result.
    Changed,
    /// Attempts with an override, which continues to count.
    Overridden,
    /// Attempts whose score does not change.
    Kept,
    /// Attempts that are not regraded.
    Left,
}

impl RegradingFilter {
    const ALL: [Self; 6] = [Self::Passes, Self::Fails, Self::Changed, Self::Overridden, Self::Kept, Self::Left];

    /// Returns the outcomes that the filter selects.
    #[must_use]
    pub const fn outcomes(self) -> &'static [RegradingOutcome] {
        match self {
            Self::Changes => &[
                RegradingOutcome::Passes,
                RegradingOutcome::Fails,
                RegradingOutcome::Changed,
                RegradingOutcome::Overridden,
            ],
            Self::Passes => &[RegradingOutcome::Passes],
            Self::Fails => &[RegradingOutcome::Fails],
            Self::Changed => &[RegradingOutcome::Changed],
            Self::Overridden => &[RegradingOutcome::Overridden],
            Self::Kept => &[RegradingOutcome::Equal, RegradingOutcome::Same],
            Self::Left => &[RegradingOutcome::Unreadable, RegradingOutcome::Overtaken],
        }
    }

    /// Returns the filter's name in addresses.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Changes => "changes",
            Self::Passes => "passes",
            Self::Fails => "fails",
            Self::Changed => "changed",
            Self::Overridden => "overridden",
            Self::Kept => "kept",
            Self::Left => "left",
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Changes => tr!("Score or result changed"),
            Self::Passes => tr!("Now passed"),
            Self::Fails => tr!("No longer passed"),
            Self::Changed => tr!("Score changed, same result"),
            Self::Overridden => tr!("Overridden: score unchanged"),
            Self::Kept => tr!("Same score"),
            Self::Left => tr!("Not changed"),
        }
    }
}

/// A count that links to the attempts counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegradingTile {
    /// Label of the count.
    pub label: &'static str,
    /// Name of the filter in addresses.
    pub word: &'static str,
    /// Number of attempts.
    pub attempts: i64,
    /// Whether these attempts are listed below.
    pub current: bool,
}

/// The page of a regrading: its progress, and the changes it would make or has made.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/regrading/one.html")]
pub struct RegradingPage {
    /// Page frame.
    pub shell: Shell,
    /// Id.
    pub id: RegradingId,
    /// Title and address of the exercise.
    pub exercise: (String, String),
    /// Publication time of the revision with the rubric, and the start of its hash.
    pub revision: (OffsetDateTime, String),
    /// State of the regrading.
    pub state: RegradingState,
    /// Name of the person who requested the preview, and its time.
    pub looked: (String, OffsetDateTime),
    /// Reason given on confirmation.
    pub reason: Option<String>,
    /// Time of completion.
    pub ended_at: Option<OffsetDateTime>,
    /// Number of attempts by outcome.
    pub counts: Vec<OutcomeCount>,
    /// Number of attempts processed, and of all attempts.
    pub progress: (i64, i64),
    /// Filter of the attempts listed.
    pub shown: RegradingFilter,
    /// Attempts listed on this page.
    pub lines: Vec<RegradingLine>,
    /// Last attempt of this page, after which the next page begins.
    pub next: Option<SessionId>,
    /// Whether this is a page after the first.
    pub further: bool,
    /// Digest of the preview, so that exactly this preview is confirmed.
    pub digest: String,
    /// Whether the visitor may confirm it.
    pub own: bool,
    /// Whether attempts have changed since the preview.
    pub stale: bool,
    /// The form with the reason for the regrading.
    pub confirmation: FilledForm<String>,
}

/// Returns the number of attempts that get a score by the new rubric.
#[must_use]
pub fn count_graded(counts: &[OutcomeCount]) -> i64 {
    count_attempts(counts, RegradingFilter::Changes.outcomes()) + count_attempts(counts, &[RegradingOutcome::Equal])
}

impl RegradingPage {
    fn of(&self, shown: RegradingFilter) -> i64 {
        count_attempts(&self.counts, shown.outcomes())
    }

    fn attempts(&self) -> i64 {
        self.counts.iter().map(|count| count.attempts).sum()
    }

    fn graded(&self) -> i64 {
        count_graded(&self.counts)
    }

    /// Returns the mean of the computed scores before and after, 0–100.
    fn means(&self) -> (f64, f64) {
        let mean =
            |sum: fn(&OutcomeCount) -> f64| self.counts.iter().map(sum).sum::<f64>() / self.attempts().max(1) as f64;
        (mean(|count| count.before), mean(|count| count.after))
    }

    fn before(&self) -> String {
        format::format_fixed(self.means().0, 1)
    }

    fn after(&self) -> String {
        format::format_fixed(self.means().1, 1)
    }

    /// Returns whether the preview can be discarded: it is the visitor's own, current and
    /// unconfirmed.
    fn may_forget(&self) -> bool {
        self.own && !self.stale && matches!(self.state, RegradingState::Looking | RegradingState::Shown)
    }

    /// Formats the change of the mean, with its sign.
    fn change(&self) -> String {
        let (before, after) = self.means();
        let sign = if after - before >= 0.05 { "+" } else { "" };
        format!("{sign}{}", format::format_fixed(after - before, 1))
    }

    /// Returns the counts to show; rare outcomes only if there are any.
    fn tiles(&self) -> Vec<RegradingTile> {
        let tile = |shown: RegradingFilter| RegradingTile {
            label: shown.label(),
            word: shown.word(),
            attempts: self.of(shown),
            current: self.shown == shown,
        };
        let always = |tile: &RegradingTile| tile.attempts > 0 || matches!(tile.word, "passes" | "fails" | "changed");
        RegradingFilter::ALL.into_iter().map(tile).filter(always).collect()
    }
}

/// Formats a result as a badge.
#[must_use]
pub fn say_result(passed: impl Borrow<bool>) -> String {
    if *passed.borrow() { StatusWord::Passed.badge() } else { StatusWord::Failed.badge() }
}

/// Returns score and result of an attempt by the new rubric.
fn score_after(line: &RegradingLine) -> Option<(f64, bool)> {
    line.after.zip(line.passed_after)
}

/// Formats the state of a regrading as a badge.
#[must_use]
pub fn outcome_badge(state: impl Borrow<RegradingState>) -> String {
    match state.borrow() {
        RegradingState::Looking => StatusWord::Waiting.badge_saying(tr!("Being checked")),
        RegradingState::Shown => StatusWord::Open.badge_saying(tr!("Waiting for confirmation")),
        RegradingState::Grading => StatusWord::Current.badge_saying(tr!("Being graded")),
        RegradingState::Done => StatusWord::Passed.badge_saying(tr!("Done")),
    }
}

#[cfg(test)]
mod tests {
    //! The preview must show which attempts newly pass or fail, that overrides continue to count,
    //! and the correct sign of the change.

    use model::{Moment, Role};

    use super::*;
    use crate::samples;

    fn count(outcome: RegradingOutcome, attempts: i64, before: f64, after: f64) -> OutcomeCount {
        OutcomeCount { outcome, attempts, before, after }
    }

    fn line(outcome: RegradingOutcome, before: f64, after: Option<f64>) -> RegradingLine {
        RegradingLine {
            session_id: SessionId::nil(),
            started_at: Moment::from(samples::NOW),
            trainee: "Ana <Lindqvist>".to_owned(),
            before,
            passed_before: before >= 70.0,
            after,
            passed_after: after.map(|after| after >= 70.0),
            overridden: (outcome == RegradingOutcome::Overridden).then_some(90.0),
            outcome,
            why: (outcome == RegradingOutcome::Unreadable).then(|| "nothing to score".to_owned()),
        }
    }

    fn page() -> RegradingPage {
        RegradingPage {
            shell: samples::shell(Role::Instructor),
            id: RegradingId::nil(),
            exercise: ("Stop in the fat".to_owned(), "/exercises/stop-in-the-fat".to_owned()),
            revision: (samples::NOW, "abc123".to_owned()),
            state: RegradingState::Shown,
            looked: ("Dr Osei".to_owned(), samples::NOW),
            reason: None,
            ended_at: None,
            counts: vec![
                count(RegradingOutcome::Passes, 2, 130.0, 150.0),
                count(RegradingOutcome::Fails, 1, 72.0, 61.0),
                count(RegradingOutcome::Overridden, 1, 40.0, 50.0),
                count(RegradingOutcome::Same, 5, 350.0, 350.0),
                count(RegradingOutcome::Unreadable, 1, 50.0, 50.0),
            ],
            progress: (0, 0),
            shown: RegradingFilter::Changes,
            lines: vec![
                line(RegradingOutcome::Passes, 65.0, Some(75.0)),
                line(RegradingOutcome::Fails, 72.0, Some(61.0)),
                line(RegradingOutcome::Overridden, 40.0, Some(50.0)),
                line(RegradingOutcome::Unreadable, 50.0, None),
            ],
            next: Some(SessionId::nil()),
            further: false,
            digest: "d1gest".to_owned(),
            own: true,
            stale: false,
            confirmation: FilledForm::default(),
        }
    }

    #[test]
    fn what_would_change_is_read_before_it_is_confirmed() {
        let html = samples::keep_page("regrading", &page());
        for wanted in ["Now passed", "No longer passed", "d1gest", "Ana &#60;Lindqvist&#62;", "+1.9", "abc123"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        assert!(html.contains("an override continues to count") && html.contains("Re-grade 4 attempts"), "{html}");
        assert!(html.contains("?show=changes&amp;after=") && html.contains("nothing to score"));
        let other = RegradingPage { own: false, ..page() };
        assert!(!samples::keep_page("regrading-other", &other).contains("d1gest"), "only whoever has looked confirms");
    }

    #[test]
    fn a_refusal_keeps_what_was_typed() {
        let confirmation = FilledForm::refused("x < y".to_owned(), "reason: empty".to_owned());
        let html = samples::keep_page("regrading-refused", &RegradingPage { confirmation, ..page() });
        assert!(html.contains("x &#60; y") && html.contains("reason: empty"));
        let html = samples::keep_page("regrading-stale", &RegradingPage { stale: true, ..page() });
        assert!(html.contains("role=\"alert\"") && !html.contains("d1gest"), "{html}");
    }

    #[test]
    fn work_under_way_says_how_far_it_is() {
        let looking = RegradingPage { state: RegradingState::Looking, progress: (10, 20), counts: vec![], ..page() };
        let html = samples::keep_page("regrading-looking", &looking);
        assert!(html.contains("10 of 20") && !html.contains("d1gest"), "{html}");
        let reason = || Some("Milder <now>".to_owned());
        let html = samples::keep_page(
            "regrading-grading",
            &RegradingPage { state: RegradingState::Grading, progress: (3, 4), reason: reason(), ..page() },
        );
        assert!(html.contains("3 of 4") && html.contains("Milder &#60;now&#62;"), "{html}");
        let done =
            RegradingPage { state: RegradingState::Done, reason: reason(), ended_at: Some(samples::NOW), ..page() };
        assert!(samples::keep_page("regrading-done", &done).contains("4 attempts were re-graded"));
        let counts = vec![count(RegradingOutcome::Same, 5, 350.0, 350.0)];
        let same = RegradingPage { counts, lines: vec![], next: None, ..page() };
        assert!(samples::keep_page("regrading-same", &same).contains("already graded with this rubric"));
    }

    #[test]
    fn a_rubric_is_chosen_among_revisions() {
        let page = ChooseRubricPage {
            shell: samples::shell(Role::Administrator),
            exercise: page().exercise,
            revisions: vec![SelectOption { value: "1".to_owned(), label: "20 May 2026, abc".to_owned(), chosen: true }],
            earlier: vec![EarlierRegrading {
                href: "/regradings/1".to_owned(),
                at: samples::NOW,
                by: "Dr Osei".to_owned(),
                state: RegradingState::Done,
                reason: Some("Milder".to_owned()),
            }],
            whole_school: true,
        };
        let html = samples::keep_page("regrading-choose", &page);
        assert!(html.contains("/regradings/1") && html.contains("Milder") && html.contains("20 May 2026, abc"));
    }
}
