//! The window's view of an attempt in progress.

use std::collections::VecDeque;

use attempt::tick::Tick;
use documents::{Wording, name_structure};
use law::axial::Contactor;
use phrase::{Phrase, phrase};
use recording::{Event, EventKind, Sample};

use super::LiveTrial;
use crate::picture::Moment;

/// Duration of the force plot, in s, and its points per second.
const TRACE_S: f64 = 10.0;
const TRACE_HZ: f64 = 100.0;
/// Height of the tip above the skin at which the needle counts as withdrawn, in m.
const CLEAR_M: f64 = 0.003;

/// Phase of an attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// The needle has not touched the skin.
    #[default]
    Approach,
    /// The needle is in the body.
    Inside,
    /// The position is confirmed; the needle has to be withdrawn.
    Confirmed,
    /// The needle is out again after the position was confirmed.
    Withdrawn,
    /// The time limit is exceeded.
    TimeUp,
}

/// One point of the force plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePoint {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Displacement along the needle, in mm.
    pub x_mm: f64,
    /// Force on the hand along the needle, in N, positive against the push.
    pub force_n: f64,
}

/// A message or an event.
#[derive(Clone, Debug, PartialEq)]
pub struct SpokenEvent {
    /// Time since the start, in s.
    pub t_s: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// Text, translatable.
    pub text: Phrase,
}

/// The state shown by the window. The recorder updates it, one whole tick at a time.
#[derive(Clone, Debug)]
pub struct AttemptView {
    /// State of the picture.
    pub moment: Moment,
    /// Phase of the attempt.
    pub phase: Phase,
    /// Force on the hand along the needle, in N, positive against the push.
    pub hand_n: f64,
    /// The last 10 s of force.
    pub trace: VecDeque<TracePoint>,
    /// All messages, in order.
    pub said: Vec<SpokenEvent>,
    /// Number of ruptures so far: it increases by one at each pop.
    pub pops: u64,
    /// Why nothing is written any more, after a write error.
    pub refused: Option<String>,
    /// Names of the layers from the skin down.
    layers: Vec<String>,
    time_limit_s: f64,
}

impl AttemptView {
    /// The view before the first tick.
    pub fn new(trial: &LiveTrial) -> Self {
        let (bundle, thickness_mm) = (&trial.bundle, &trial.session.patient_thickness_mm);
        Self {
            moment: Moment::before(bundle, thickness_mm),
            phase: Phase::Approach,
            hand_n: 0.0,
            trace: VecDeque::new(),
            said: Vec::new(),
            pops: 0,
            refused: None,
            layers: bundle.scene.layers.iter().map(|layer| layer.name.clone()).collect(),
            time_limit_s: bundle.exercise.time_limit_s,
        }
    }

    /// Adds a tick, and the messages of coach and safety chain about it.
    pub fn tell(&mut self, tick: &Tick, coached: &[&Wording], faulty: &[&'static str]) {
        let Sample { t_s, x_m, .. } = tick.sample;
        self.hand_n = tick.hand_n;
        self.moment.sample(&tick.sample);
        for event in &tick.events {
            self.moment.event(event);
            self.pops += u64::from(event.kind.contactor().is_some());
            if let Some(text) = in_words(event, self.phase) {
                self.said.push(SpokenEvent { t_s, kind: event.kind, text });
            }
        }
        let coached = coached.iter().map(|&text| (EventKind::Coaching, Phrase::from(text)));
        let faulty = faulty.iter().map(|&text| (EventKind::Fault, Phrase::sentence(text)));
        self.said.extend(coached.chain(faulty).map(|(kind, text)| SpokenEvent { t_s, kind, text }));
        if let Some(tent) = &tick.tent {
            self.moment.tent(tent);
        }
        if self.trace.back().is_none_or(|last| t_s - last.t_s >= 1.0 / TRACE_HZ) {
            self.trace.push_back(TracePoint { t_s, x_mm: x_m * 1e3, force_n: tick.hand_n });
            while self.trace.front().is_some_and(|first| t_s - first.t_s > TRACE_S) {
                self.trace.pop_front();
            }
        }
        self.phase = self.next_phase(tick);
    }

    /// Adds a warning that does not come from a tick.
    pub fn warn(&mut self, text: Phrase) {
        self.said.push(SpokenEvent { t_s: self.moment.sample.t_s, kind: EventKind::Fault, text });
    }

    fn next_phase(&self, tick: &Tick) -> Phase {
        let happened = |kind| tick.events.iter().any(|event| event.kind == kind);
        match self.phase {
            Phase::Withdrawn | Phase::TimeUp => self.phase,
            _ if tick.sample.t_s > self.time_limit_s => Phase::TimeUp,
            Phase::Confirmed if tick.sample.x_m < -CLEAR_M => Phase::Withdrawn,
            Phase::Confirmed => Phase::Confirmed,
            Phase::Inside if happened(EventKind::Confirm) => Phase::Confirmed,
            Phase::Inside if happened(EventKind::SkinExit) => Phase::Approach,
            _ if happened(EventKind::Contact) => Phase::Inside,
            phase => phase,
        }
    }

    /// Returns the position of the tip: outside, at the skin, or in a layer. Tissue that only
    /// deforms is not entered yet.
    #[must_use]
    pub fn place(&self) -> Phrase {
        let layer = self.moment.layer().and_then(|layer| self.layers.get(layer));
        match (self.moment.opened(), layer) {
            (None, _) => phrase!("outside"),
            (Some(1..), Some(layer)) => name_structure(layer),
            (Some(_), _) => phrase!("on the skin"),
        }
    }

    /// Returns the time left, in s.
    #[must_use]
    pub fn left_s(&self) -> f64 {
        (self.time_limit_s - self.moment.sample.t_s).max(0.0)
    }
}

/// Describes an event in a phase, as a caption of the sensation or sound.
fn in_words(event: &Event, phase: Phase) -> Option<Phrase> {
    let pop = |contactor: Contactor| phrase!("pop: {pop}", pop = contactor.into_layer(name_structure(&event.text)));
    match event.kind {
        EventKind::Contact => Some(phrase!("skin touched")),
        EventKind::TipRupture => Some(pop(Contactor::Tip)),
        EventKind::RimRupture => Some(pop(Contactor::Rim)),
        EventKind::StructureHit => Some(phrase!("{structure} hit", structure = name_structure(&event.text))),
        EventKind::HubContact => Some(phrase!("hub at the skin: the needle is fully inserted")),
        EventKind::SkinExit => Some(phrase!("out of the skin")),
        EventKind::Confirm if phase == Phase::Approach => Some(phrase!("not confirmed: the tip is outside the body")),
        EventKind::Confirm => Some(phrase!("position confirmed: withdraw")),
        EventKind::Fault | EventKind::Interrupted => Some(Phrase::Known(event.text.clone())),
        EventKind::Coaching => None,
    }
}

#[cfg(test)]
mod tests {
    //! Fails if an attempt ends before the withdrawal, or never ends.

    use recording::sample::flags;

    use super::*;

    fn german() -> words::Language {
        words::Language::named("de").unwrap()
    }

    fn shown(time_limit_s: f64) -> AttemptView {
        let layers = vec!["skin".to_owned(), "fat".to_owned()];
        let (trace, said) = (VecDeque::new(), Vec::new());
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../curricula/lower-back-basics/1-feel-the-layers.toml");
        let bundle = documents::ExerciseBundle::read(std::path::Path::new(file)).unwrap();
        let (moment, phase) = (Moment::before(&bundle, &[]), Phase::Approach);
        AttemptView { moment, phase, hand_n: 0.0, trace, said, pops: 0, refused: None, layers, time_limit_s }
    }

    /// Adds a tick at a time in s with the tip at a depth in mm and events of these kinds; returns
    /// the phase.
    fn tell(shown: &mut AttemptView, t_s: f64, depth_mm: f64, kinds: &[EventKind]) -> Phase {
        let flags = if depth_mm > 0.0 { flags::INSIDE } else { 0 };
        let (x_m, position_m) = (depth_mm * 1e-3, [0.0, 0.0, -depth_mm * 1e-3]);
        let sample = Sample { t_s, x_m, position_m, orientation: [1.0, 0.0, 0.0, 0.0], flags, ..Sample::default() };
        let event = |&kind: &EventKind| Event {
            t_s,
            kind,
            boundary: Some(0),
            x_m,
            position_m,
            force_n: 1.0,
            dissipated_j: 0.0,
            track: Some(0),
            structure: None,
            text: "skin".to_owned(),
        };
        let events = kinds.iter().map(event).collect();
        shown.tell(&Tick { sample, events, tent: None, felt: Default::default(), hand_n: 0.0 }, &[], &[]);
        shown.phase
    }

    #[test]
    fn it_is_over_when_the_needle_is_out_after_the_confirmation() {
        let mut shown = shown(60.0);
        assert_eq!(tell(&mut shown, 0.0, -5.0, &[]), Phase::Approach);
        assert_eq!(tell(&mut shown, 1.0, 0.1, &[EventKind::Contact]), Phase::Inside);
        assert_eq!(tell(&mut shown, 2.0, -1.0, &[EventKind::SkinExit]), Phase::Approach, "not confirmed: go on");
        assert_eq!(tell(&mut shown, 3.0, 4.0, &[EventKind::Contact, EventKind::TipRupture]), Phase::Inside);
        assert_eq!(tell(&mut shown, 4.0, 4.0, &[EventKind::Confirm]), Phase::Confirmed);
        assert_eq!(tell(&mut shown, 5.0, -1.0, &[EventKind::SkinExit]), Phase::Confirmed, "still at the skin");
        assert_eq!(tell(&mut shown, 6.0, -3.1, &[]), Phase::Withdrawn);
        assert_eq!(shown.pops, 1);
    }

    #[test]
    fn a_confirmation_in_the_air_neither_confirms_nor_ends_anything() {
        let mut shown = shown(60.0);
        assert_eq!(tell(&mut shown, 0.5, -10.0, &[EventKind::Confirm]), Phase::Approach);
        assert_eq!(tell(&mut shown, 0.6, -10.0, &[]), Phase::Approach);
        assert!(shown.said[0].text.to_string().contains("outside the body"), "{:?}", shown.said);
        tell(&mut shown, 1.0, 0.1, &[EventKind::Contact]);
        assert_eq!(tell(&mut shown, 2.0, 4.0, &[EventKind::Confirm]), Phase::Confirmed);
    }

    #[test]
    fn it_is_over_when_the_time_is_up() {
        let mut shown = shown(60.0);
        assert_eq!(tell(&mut shown, 60.0, 1.0, &[EventKind::Contact]), Phase::Inside);
        assert_eq!(tell(&mut shown, 60.1, 1.0, &[]), Phase::TimeUp);
        assert!(shown.left_s() <= 0.0);
    }

    #[test]
    fn tissue_that_only_gives_way_is_not_entered() {
        let mut shown = shown(60.0);
        assert_eq!(shown.place().to_string(), "outside");
        tell(&mut shown, 1.0, 0.1, &[EventKind::Contact]);
        tell(&mut shown, 1.5, 3.0, &[]);
        assert_eq!(shown.place().to_string(), "on the skin");
        tell(&mut shown, 2.0, 3.1, &[EventKind::TipRupture]);
        shown.moment.sample.depth_m = 3.1e-3;
        assert_eq!(shown.place().to_string(), "fat");
        // On the way out the position of the tip counts, not the boundaries that it has opened.
        shown.moment.sample.depth_m = 0.4e-3;
        assert_eq!(words::within(german(), || words::phrase(&shown.place())), "Haut");
    }

    #[test]
    fn the_plot_keeps_the_last_seconds_only() {
        let mut shown = shown(600.0);
        for tick in 0..20_000 {
            tell(&mut shown, f64::from(tick) * 1e-3, 1.0, &[]);
        }
        let span_s =
            shown.trace.back().map_or(0.0, |last| last.t_s) - shown.trace.front().map_or(0.0, |first| first.t_s);
        assert!(
            (9.9..=10.0).contains(&span_s) && shown.trace.len() <= 1001,
            "{span_s} s, {} points",
            shown.trace.len()
        );
    }
}
