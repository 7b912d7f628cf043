//! The replay of an attempt, with its comments.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::ids::{CommentId, SessionId};
use model::scoring::review::{ReviewFilter, ReviewReason};
use model::training::comment::{CommentKind, MOST_CHARACTERS, TypedComment};
use time::OffsetDateTime;

use crate::charts::Drawing;
use crate::form::FilledForm;
use crate::scoring::experts::BesideExperts;
use crate::scoring::replay_events::{NamedHappenings, OtherAttempt};
use crate::{Shell, StatusWord, anatomy, assets, format};

/// The page of a replay.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "recordings/replay.html")]
pub struct ReplayPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the attempt.
    pub session: SessionId,
    /// Title of the exercise.
    pub exercise: String,
    /// Name of the trainee and address of their page, if the visitor is another person.
    pub trainee: Option<(String, String)>,
    /// Start of the attempt.
    pub started_at: OffsetDateTime,
    /// Duration, in s.
    pub duration_s: f64,
    /// The curves, for browsers without scripts.
    pub drawing: Option<Drawing>,
    /// Events, and the time at which the replay opens.
    pub happened: NamedHappenings,
    /// Comparison with the experts, if enough of them consent.
    pub experts: Option<BesideExperts>,
    /// When the visitor consented to the use of their attempts as an expert; the outer `None` for a
    /// trainee, who is not an expert.
    pub consent: Option<Option<OffsetDateTime>>,
    /// State of the review; `None` for visitors who do not review, and before the attempt is
    /// scored.
    pub look: Option<ReviewLook>,
    /// Comments in order of time.
    pub comments: Vec<CommentView>,
    /// The form, with its input.
    pub form: CommentForm,
    /// Attempts that can be overlaid for comparison.
    pub others: Vec<OtherAttempt>,
}

/// Review state of an attempt, and the queue filter from which it was opened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReviewLook {
    /// Whether the attempt has been reviewed.
    pub reviewed: bool,
    /// Filter of the review queue.
    pub filter: ReviewFilter,
}

impl ReviewLook {
    fn what(&self) -> &'static str {
        self.filter.reason.map_or("", ReviewReason::name)
    }

    fn cohort(&self) -> String {
        self.filter.cohort.map(String::from).unwrap_or_default()
    }

    fn exercise(&self) -> &str {
        self.filter.exercise.as_deref().unwrap_or_default()
    }

    fn queue_href(&self) -> String {
        let query = self.filter.query();
        if query.is_empty() { "/review".to_owned() } else { format!("/review?{query}") }
    }
}

/// A comment with its answers.
#[derive(Clone, Debug, PartialEq)]
pub struct CommentView {
    /// Id.
    pub id: CommentId,
    /// Kind of comment.
    pub kind: CommentKind,
    /// Time, or start of the interval, in s.
    pub from_s: f64,
    /// End of the interval, in s.
    pub to_s: Option<f64>,
    /// Text and author.
    pub said: Utterance,
    /// Answers with their ids, oldest first.
    pub answers: Vec<(CommentId, Utterance)>,
}

/// The text of a comment or answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Utterance {
    /// Text.
    pub body: String,
    /// Name of the author.
    pub author: String,
    /// Time of writing.
    pub at: OffsetDateTime,
    /// Whether the visitor wrote it and may withdraw it.
    pub own: bool,
}

/// The form for a comment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommentForm {
    /// Input of the form.
    pub fields: FilledForm<TypedComment>,
    /// The comment to which a refused answer belongs; `None` if the form is for a new comment.
    pub answers: Option<CommentId>,
}

impl CommentForm {
    fn picked(&self, kind: impl Borrow<CommentKind>) -> bool {
        self.fields.typed.kind == kind.borrow().name()
    }

    fn is_answer_to(&self, comment: impl Borrow<CommentId>) -> bool {
        self.answers.as_ref() == Some(comment.borrow())
    }
}

impl ReplayPage {
    /// Returns the address from which the script fetches the replay.
    fn address(&self) -> String {
        format!("/api/v1/sessions/{}", self.session)
    }

    fn script(&self) -> String {
        assets::asset_address("replay.js")
    }

    fn other(&self) -> Option<&OtherAttempt> {
        self.others.iter().find(|other| other.chosen)
    }

    /// The second at which the page opens, as an address says it; empty for the beginning.
    fn opened_at(&self) -> String {
        self.happened.opened.as_ref().map_or_else(String::new, |opened| format::plain_seconds(opened.t_s))
    }

    /// The second in the form: as it was typed, or at which the page opens.
    fn typed_from(&self) -> String {
        match (&self.form.fields.refused, &self.happened.opened) {
            (None, Some(opened)) => format::plain_seconds(opened.t_s),
            _ => self.form.fields.typed.from_s.clone(),
        }
    }

    fn longest(&self) -> usize {
        MOST_CHARACTERS
    }
}

impl CommentView {
    /// Returns the sign of the comment's kind: a second cue next to colour, the same as in the
    /// plots.
    const fn sign(&self) -> &'static str {
        match self.kind {
            CommentKind::Praise => "+",
            CommentKind::Error => "!",
            CommentKind::Question => "?",
            CommentKind::Teaching => "T",
        }
    }
}

#[cfg(test)]
mod tests {
    //! The page must work without scripts: curves, events, comments and a form with times.

    use model::Role;

    use super::*;
    use crate::samples;

    fn page() -> ReplayPage {
        let said =
            |body: &str, own| Utterance { body: body.to_owned(), author: "Dr Osei".to_owned(), at: samples::NOW, own };
        let comment = CommentView {
            id: CommentId::nil(),
            kind: CommentKind::Question,
            from_s: 3.5,
            to_s: Some(4.25),
            said: said("Why <so> fast here?", false),
            answers: vec![(CommentId::nil(), said("I lost the layer.", true))],
        };
        ReplayPage {
            shell: samples::shell(Role::Trainee),
            session: SessionId::nil(),
            exercise: "Stop in the fat".to_owned(),
            trainee: None,
            started_at: samples::NOW,
            duration_s: 26.0,
            drawing: Some(Drawing::new(&samples::curve()).leading_to("")),
            happened: NamedHappenings::new(Some(&samples::curve()), "19,5", 26.0),
            experts: None,
            consent: Some(None),
            look: Some(ReviewLook {
                reviewed: false,
                filter: ReviewFilter { reason: Some(ReviewReason::Failed), ..ReviewFilter::default() },
            }),
            comments: vec![comment],
            form: CommentForm::default(),
            others: vec![OtherAttempt { session: SessionId::nil(), label: "12 May, 80".to_owned(), chosen: true }],
        }
    }

    #[test]
    fn everything_is_there_without_scripts() {
        let html = samples::keep_page("replay", &page());
        for wanted in [
            "<svg",
            "Ruptures and other events",
            "3.50",
            "4.25",
            "Why &#60;so&#62; fast",
            "I lost the layer.",
            "name=\"from_s\"",
            "Mark as reviewed, go to next",
            "name=\"what\" value=\"failed\"",
        ] {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
    }

    #[test]
    fn it_opens_at_the_second_that_is_asked_for() {
        let html = samples::keep_page("replay-moment", &page());
        assert!(html.contains("data-at=\"19.5\"") && html.contains("At 19.50 s"), "{html}");
        assert!(html.contains("Position confirmed, 0.5"), "in words, for whoever runs no scripts");
        assert!(html.contains("?t=3.50") && html.contains("data-second=\"3.5\""), "from a comment");
        let asked = |said| NamedHappenings::new(None, said, 26.0).opened.map(|moment| moment.t_s);
        assert_eq!([asked("99"), asked("-1"), asked("x"), asked("NaN")], [Some(26.0), Some(0.0), None, None]);
    }

    #[test]
    fn a_refused_comment_keeps_what_was_typed() {
        let typed = TypedComment {
            kind: "error".to_owned(),
            from_s: "99".to_owned(),
            to_s: String::new(),
            body: "Too \"deep\"".to_owned(),
        };
        let fields = FilledForm::refused(typed, "from: \"99\"; allowed: 0 to 26 s".to_owned());
        let page = ReplayPage { form: CommentForm { fields, answers: None }, comments: vec![], ..page() };
        let html = samples::keep_page("replay-refused", &page);
        for wanted in ["value=\"99\"", "Too &#34;deep&#34;", "allowed: 0 to 26 s", "No comments on this attempt yet"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
