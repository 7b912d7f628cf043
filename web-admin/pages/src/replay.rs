//! An attempt to be watched again, with what was said about it.

use std::borrow::Borrow;

use askama::Template;
use askama_web::WebTemplate;
use attempt::{AttemptCurve, CurveMark, MarkKind};
use model::comment::{CommentKind, MOST_CHARACTERS, TypedComment};
use model::expert_way::GhostStretch;
use model::ids::{CommentId, SessionId};
use model::review::{ReviewFilter, ReviewReason};
use time::OffsetDateTime;

use super::experts::BesideExperts;
use super::form::FilledForm;
use super::session::Drawing;
use super::{Shell, StatusWord, anatomy, assets, format, moments};

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
    /// What happened when, and where it opens.
    pub happened: NamedHappenings,
    /// The attempt beside the experts, where enough of them consent.
    pub experts: Option<BesideExperts>,
    /// Since when the visitor lets their own attempts be part of it; absent for a trainee, who is no expert.
    pub consent: Option<Option<OffsetDateTime>>,
    /// The step through the review queue; absent for whoever does not review, and before the attempt is scored.
    pub look: Option<ReviewLook>,
    /// What was said, by its moment.
    pub comments: Vec<CommentView>,
    /// The form as it was filled in.
    pub form: CommentForm,
    /// Attempts that may be laid over this one.
    pub others: Vec<OtherAttempt>,
}

/// Whether somebody has looked at an attempt, and by which part of the queue it was come to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReviewLook {
    /// Somebody has looked at it.
    pub reviewed: bool,
    /// The part of the queue.
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

/// What happened when in a replay, in words, and where it opens.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedHappenings {
    /// Events in order of time.
    pub events: Vec<NamedEvent>,
    /// The second at which it opens; absent for the beginning.
    pub opened: Option<OpenedMoment>,
    /// The way of the experts' median, which is shown as a ghost.
    pub ghost: Option<ExpertGhost>,
}

/// The way of the experts' median.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpertGhost {
    /// From each crossing of the attempt to the next.
    pub stretches: Vec<GhostStretch>,
    /// How many experts.
    pub experts: usize,
}

impl ExpertGhost {
    /// For the script, as JSON.
    pub(crate) fn as_json(&self) -> String {
        // Numbers that are finite always have a JSON.
        serde_json::to_string(&self.stretches).unwrap_or_default()
    }
}

impl NamedHappenings {
    /// Everything that happened in an attempt; `asked` is the second that an address asks for.
    #[must_use]
    pub fn new(curve: Option<&AttemptCurve>, asked: &str, duration_s: f64) -> Self {
        Self {
            events: curve.map(name_events).unwrap_or_default(),
            opened: OpenedMoment::asked(asked, duration_s, curve),
            ghost: None,
        }
    }

    /// The same, with the experts' median beside the needle, where there is one.
    #[must_use]
    pub fn beside(self, stretches: Vec<GhostStretch>, experts: usize) -> Self {
        let ghost = (!stretches.is_empty()).then_some(ExpertGhost { stretches, experts });
        Self { ghost, ..self }
    }

    /// The words of the events for the script, as JSON, in order of time.
    pub(crate) fn as_json(&self) -> String {
        let words: Vec<&str> = self.events.iter().map(|event| event.what.as_str()).collect();
        // A list of strings always has a JSON.
        serde_json::to_string(&words).unwrap_or_default()
    }
}

/// The second at which a replay opens.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenedMoment {
    /// Since the start, in s.
    pub t_s: f64,
    /// What stands there: depth, force, layer, what happened last.
    pub words: String,
}

impl OpenedMoment {
    /// The moment that an address asks for, where it names one of the attempt's.
    fn asked(said: &str, duration_s: f64, curve: Option<&AttemptCurve>) -> Option<Self> {
        let t_s = said.replace(',', ".").parse::<f64>().ok().filter(|t_s| t_s.is_finite())?.clamp(0.0, duration_s);
        Some(Self { t_s, words: curve.map_or_else(String::new, |curve| moments::say_moment(curve, t_s)) })
    }
}

/// An event and its second.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEvent {
    /// Since the start, in s.
    pub t_s: f64,
    /// What happened, in words.
    pub what: String,
    /// Its sign in the plots.
    pub kind: MarkKind,
}

/// Everything that happened in an attempt, in words.
fn name_events(curve: &AttemptCurve) -> Vec<NamedEvent> {
    let name = |mark: &CurveMark| NamedEvent {
        t_s: mark.t_s,
        what: format::as_sentence(&anatomy::say_event(mark.kind, &anatomy::say_structure(&mark.name))),
        kind: mark.kind,
    };
    curve.marks.iter().map(name).collect()
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
            "Looked at, next",
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
        let asked = |said| OpenedMoment::asked(said, 26.0, None).map(|moment| moment.t_s);
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
        let fields = FilledForm::refused(typed, "from: \"99\"; allowed is 0 to 26 s".to_owned());
        let page = ReplayPage { form: CommentForm { fields, answers: None }, comments: vec![], ..page() };
        let html = samples::keep_page("replay-refused", &page);
        for wanted in ["value=\"99\"", "Too &#34;deep&#34;", "allowed is 0 to 26 s", "Nothing has been said"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
