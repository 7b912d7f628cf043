//! Attempts that tell nothing of whoever made them: the device was lost, or the hand was not given what it should have felt. Such an
//! attempt is kept as it is, and counts nowhere.

use std::fmt;

use phrase::{Phrase, phrase};
use recording::sample::flags;
use recording::{EventKind, Recording};
use serde::{Deserialize, Serialize};

/// The largest part of the time in the body that may go unfelt (choice): one hiccup of the device, and the second and a half in which
/// the force comes back, in an insertion of ten seconds.
pub const MOST_UNFELT: f64 = 0.1;

/// Why an attempt is void.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Void {
    /// The device or the program ended it.
    Interrupted {
        /// When, in s.
        t_s: f64,
        /// What happened, in words.
        why: String,
    },
    /// The hand was not given the tissue's force for too long.
    Unfelt {
        /// Time in the body in which less than half of the force was given, in s.
        unfelt_s: f64,
        /// Time in the body, in s.
        inside_s: f64,
    },
}

impl Void {
    /// In words, for whoever has another language.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        match self {
            Self::Interrupted { t_s, why } => {
                phrase!("ended after {t} s: {why}", t = Phrase::number(*t_s, 1), why = Phrase::Known(why.clone()))
            }
            Self::Unfelt { unfelt_s, inside_s } => phrase!(
                "the hand was given less than half of the force for {unfelt} s of {inside} s in the body; {most} % may be",
                unfelt = Phrase::number(*unfelt_s, 1),
                inside = Phrase::number(*inside_s, 1),
                most = Phrase::number(MOST_UNFELT * 100.0, 0)
            ),
        }
    }
}

/// What a void attempt is told to programs as, in the place of an assessment.
#[derive(Debug, Serialize)]
pub struct VoidAnswer<'a> {
    score: Option<f64>,
    passed: Option<bool>,
    void: &'a Void,
    why: String,
}

impl<'a> From<&'a Void> for VoidAnswer<'a> {
    fn from(void: &'a Void) -> Self {
        Self { score: None, passed: None, void, why: void.to_string() }
    }
}

impl fmt::Display for Void {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.phrase().fmt(f)
    }
}

/// Why an attempt is void; `None` where it may be judged.
#[must_use]
pub fn find_void_reason(recording: &Recording) -> Option<Void> {
    interrupted(recording).or_else(|| unfelt(recording))
}

fn interrupted(recording: &Recording) -> Option<Void> {
    let event = recording.events.iter().find(|event| event.kind == EventKind::Interrupted)?;
    Some(Void::Interrupted { t_s: event.t_s, why: event.text.clone() })
}

fn unfelt(recording: &Recording) -> Option<Void> {
    let (mut unfelt_s, mut inside_s) = (0.0, 0.0);
    for pair in recording.samples.windows(2).filter(|pair| pair[0].flags & flags::INSIDE != 0) {
        let lasts_s = pair[1].t_s - pair[0].t_s;
        inside_s += lasts_s;
        unfelt_s += if pair[0].flags & flags::UNFELT != 0 { lasts_s } else { 0.0 };
    }
    (unfelt_s > MOST_UNFELT * inside_s).then_some(Void::Unfelt { unfelt_s, inside_s })
}
