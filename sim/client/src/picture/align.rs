//! Two attempts at the same point of their way: aligned by what both went through.

use recording::{Event, EventKind, Recording};

/// Times of one recording told in the time of another.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Times in s at which both were at the same point, in the one and in the other, rising in both.
    knots: Vec<[f64; 2]>,
}

impl Alignment {
    /// Aligns by contact, every rupture, confirmation and skin exit that both have, each the first time it happened.
    #[must_use]
    pub fn new(one: &Recording, other: &Recording) -> Self {
        let mut knots = vec![[0.0, 0.0]];
        for event in &one.events {
            let Some(point) = Point::of(event).filter(|point| first(one, point) == Some(event.t_s)) else { continue };
            let last = knots.last().copied().unwrap_or_default();
            if let Some(there_s) = first(other, &point).filter(|there_s| *there_s > last[1] && event.t_s > last[0]) {
                knots.push([event.t_s, there_s]);
            }
        }
        Self { knots }
    }

    /// The other's time when the one is at a time in s. Before, between and beyond the common points the other keeps its own
    /// order: between them it is stretched, beyond them it runs as it was.
    #[must_use]
    pub fn other_s(&self, t_s: f64) -> f64 {
        let after = self.knots.partition_point(|knot| knot[0] <= t_s);
        let from = self.knots.get(after.saturating_sub(1)).copied().unwrap_or_default();
        match self.knots.get(after) {
            Some(to) if after > 0 => from[1] + (t_s - from[0]) * (to[1] - from[1]) / (to[0] - from[0]),
            _ => from[1] + (t_s - from[0]),
        }
    }
}

/// A point of the way that every attempt may pass.
#[derive(PartialEq)]
struct Point {
    kind: EventKind,
    boundary: Option<u32>,
}

impl Point {
    fn of(event: &Event) -> Option<Self> {
        use EventKind::{Confirm, Contact, RimRupture, SkinExit, TipRupture};
        let tells = matches!(event.kind, Contact | TipRupture | RimRupture | Confirm | SkinExit);
        tells.then_some(Self { kind: event.kind, boundary: event.boundary })
    }
}

/// When a recording first passed a point, in s.
fn first(recording: &Recording, point: &Point) -> Option<f64> {
    recording.events.iter().find(|event| Point::of(event).as_ref() == Some(point)).map(|event| event.t_s)
}
