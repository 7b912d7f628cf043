//! The events of an attempt as text, for the pages that replay it.

use attempt::{AttemptCurve, CurveMark, MarkKind};
use model::ids::SessionId;
use model::scoring::expert_comparison::GhostStretch;

use crate::scoring::moments;
use crate::{anatomy, format};

/// Events of a replay as text, and the time at which it opens.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedHappenings {
    /// Events in order of time.
    pub events: Vec<NamedEvent>,
    /// Time at which the replay opens; `None` for the start.
    pub opened: Option<OpenedMoment>,
    /// Median trajectory of the experts, shown as a ghost needle.
    pub ghost: Option<ExpertGhost>,
}

/// Median trajectory of the experts.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpertGhost {
    /// Stretches from each layer crossing of the attempt to the next.
    pub stretches: Vec<GhostStretch>,
    /// Number of experts.
    pub experts: usize,
}

impl ExpertGhost {
    /// Returns the stretches as JSON for the script.
    pub(crate) fn as_json(&self) -> String {
        // Finite numbers always serialize.
        serde_json::to_string(&self.stretches).unwrap_or_default()
    }
}

impl NamedHappenings {
    /// Lists the events of an attempt; `asked` is the time in the request's query string.
    #[must_use]
    pub fn new(curve: Option<&AttemptCurve>, asked: &str, duration_s: f64) -> Self {
        Self {
            events: curve.map(name_events).unwrap_or_default(),
            opened: OpenedMoment::asked(asked, duration_s, curve),
            ghost: None,
        }
    }

    /// Adds the experts' median trajectory; `stretches` may be empty.
    #[must_use]
    pub fn beside(self, stretches: Vec<GhostStretch>, experts: usize) -> Self {
        let ghost = (!stretches.is_empty()).then_some(ExpertGhost { stretches, experts });
        Self { ghost, ..self }
    }

    /// Returns the event texts in order of time, as JSON for the script.
    pub(crate) fn as_json(&self) -> String {
        let words: Vec<&str> = self.events.iter().map(|event| event.what.as_str()).collect();
        // A list of strings always serializes.
        serde_json::to_string(&words).unwrap_or_default()
    }
}

/// The time at which a replay opens.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenedMoment {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Description of that time: depth, force, layer and latest event.
    pub words: String,
}

impl OpenedMoment {
    /// Parses the time in a query string, clamped to the attempt; `None` if it is not a finite
    /// number.
    fn asked(said: &str, duration_s: f64, curve: Option<&AttemptCurve>) -> Option<Self> {
        let t_s = said.replace(',', ".").parse::<f64>().ok().filter(|t_s| t_s.is_finite())?.clamp(0.0, duration_s);
        Some(Self { t_s, words: curve.map_or_else(String::new, |curve| moments::say_moment(curve, t_s)) })
    }
}

/// An event with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEvent {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Description of the event.
    pub what: String,
    /// Kind, which determines its mark in the plots.
    pub kind: MarkKind,
}

/// Describes all events of an attempt.
fn name_events(curve: &AttemptCurve) -> Vec<NamedEvent> {
    let name = |mark: &CurveMark| NamedEvent {
        t_s: mark.t_s,
        what: format::as_sentence(&anatomy::say_event(mark.kind, &anatomy::say_structure(&mark.name))),
        kind: mark.kind,
    };
    curve.marks.iter().map(name).collect()
}

/// An attempt that can be overlaid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherAttempt {
    /// Id of the attempt.
    pub session: SessionId,
    /// Label in the list.
    pub label: String,
    /// Whether it is currently overlaid.
    pub chosen: bool,
}
