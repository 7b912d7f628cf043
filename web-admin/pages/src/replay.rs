//! An attempt to be watched again, with what was said about it.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use model::comment::{CommentKind, MOST_CHARACTERS, TypedComment};
use model::ids::{CommentId, SessionId};
use time::OffsetDateTime;

use super::form::FilledForm;
use super::session::Drawing;
use super::{Shell, anatomy, assets, format};

/// The page of a replay.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "replay.html")]
pub struct ReplayPage {
    /// Frame.
    pub shell: Shell,
    /// The attempt.
    pub session: SessionId,
    /// The exercise's title.
    pub exercise: String,
    /// The trainee's name and page, where the visitor is somebody else.
    pub trainee: Option<(String, String)>,
    /// When the attempt began.
    pub started_at: OffsetDateTime,
    /// Its length, in s.
    pub duration_s: f64,
    /// The curves, for browsers without scripts.
    pub drawing: Option<Drawing>,
    /// The attempt over the experts' corridor, for both widths, where enough of them consent.
    pub corridor: Option<String>,
    /// Since when the visitor lets their own attempts be part of it; absent for a trainee, who is no expert.
    pub consent: Option<Option<OffsetDateTime>>,
    /// What was said, by its moment.
    pub comments: Vec<CommentView>,
    /// The form as it was filled in.
    pub form: CommentForm,
    /// Attempts that may be laid over this one.
    pub others: Vec<OtherAttempt>,
}

/// An attempt that may be laid over another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherAttempt {
    /// The attempt.
    pub session: SessionId,
    /// What it is called in a list.
    pub label: String,
    /// It is laid over this one now.
    pub chosen: bool,
}

/// A comment with its answers.
#[derive(Clone, Debug, PartialEq)]
pub struct CommentView {
    /// Id.
    pub id: CommentId,
    /// What it is meant as.
    pub kind: CommentKind,
    /// The moment, or the beginning of the interval, in s.
    pub from_s: f64,
    /// The end of the interval, in s.
    pub to_s: Option<f64>,
    /// What is said, by whom.
    pub said: Utterance,
    /// Answers, oldest first, each with its id.
    pub answers: Vec<(CommentId, Utterance)>,
}

/// Something that somebody said.
#[derive(Clone, Debug, PartialEq)]
pub struct Utterance {
    /// The words.
    pub body: String,
    /// Who.
    pub author: String,
    /// When.
    pub at: OffsetDateTime,
    /// It is the visitor's own, who may take it back.
    pub own: bool,
}

/// The form for a comment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommentForm {
    /// What is typed.
    pub fields: FilledForm<TypedComment>,
    /// The comment that an answer was meant for, where it was one that was refused.
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
    /// Where the replay is fetched.
    fn address(&self) -> String {
        format!("/api/v1/sessions/{}", self.session)
    }

    fn script(&self) -> String {
        assets::asset_address("replay.js")
    }

    fn other(&self) -> Option<&OtherAttempt> {
        self.others.iter().find(|other| other.chosen)
    }

    fn longest(&self) -> usize {
        MOST_CHARACTERS
    }
}

impl CommentView {
    /// The sign of its kind: a second cue beside the colour, the same as in the plots.
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
    //! The page must be of use without scripts: curves, events, comments and a form with seconds.

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
            drawing: Some(Drawing::new(&samples::curve())),
            corridor: None,
            consent: Some(None),
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
        ] {
            assert!(html.contains(wanted), "{wanted} is missing");
        }
    }

    #[test]
    fn a_refused_comment_keeps_what_was_typed() {
        let typed = TypedComment {
            kind: "error".to_owned(),
            from_s: "99".to_owned(),
            to_s: String::new(),
            body: "Too \"deep\"".to_owned(),
        };
        let fields = FilledForm::refused(typed, "from: \"99\"; allowed is 0 to 26 s".to_owned());
        let page = ReplayPage { form: CommentForm { fields, answers: None }, comments: vec![], ..page() };
        let html = samples::keep_page("replay-refused", &page);
        for wanted in ["value=\"99\"", "Too &#34;deep&#34;", "allowed is 0 to 26 s", "Nothing has been said"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
