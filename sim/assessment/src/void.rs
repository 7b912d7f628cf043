//! Void attempts, which do not reflect the trainee's skill: the device was lost, or the hand did
//! not receive the force. A void attempt is stored unchanged and never counted.

use std::fmt;

use phrase::{Phrase, phrase};
use recording::sample::flags;
use recording::{EventKind, Recording};
use serde::{Deserialize, Serialize};

/// Largest fraction of the time in the body without force (choice): one device fault, and the 1.5 s
/// in which the force is restored, in an insertion of ten seconds.
pub const MOST_UNFELT: f64 = 0.1;

/// The reason why an attempt is void.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Void {
    /// The device or the program ended it.
    Interrupted {
        /// Time, in s.
        t_s: f64,
        /// Description.
        why: String,
    },
    /// The hand did not receive the tissue's force for too long.
    Unfelt {
        /// Time in the body in which less than half of the force was rendered, in s.
        unfelt_s: f64,
        /// Time in the body, in s.
        inside_s: f64,
    },
}

impl Void {
    /// Returns the translatable message.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        match self {
            Self::Interrupted { t_s, why } => {
                phrase!("ended after {t} s: {why}", t = Phrase::number(*t_s, 1), why = Phrase::Known(why.clone()))
            }
            Self::Unfelt { unfelt_s, inside_s } => phrase!(
                "the hand received less than half of the force for {unfelt} s of {inside} s in the body; at most \
                 {most} % is allowed",
                unfelt = Phrase::number(*unfelt_s, 1),
                inside = Phrase::number(*inside_s, 1),
                most = Phrase::number(MOST_UNFELT * 100.0, 0)
            ),
        }
    }
}

/// The JSON for a void attempt, in place of an assessment.
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

/// Returns the reason why an attempt is void; `None` if it can be judged.
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
