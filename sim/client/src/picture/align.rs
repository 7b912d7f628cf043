//! Aligns two attempts in time by the events that both have.

use recording::{Event, EventKind};

/// Maps times of one recording to times of another.
#[derive(Clone, Debug, PartialEq)]
pub struct Alignment {
    /// Times in s at which both pass the same point, in the one and in the other; both increase.
    knots: Vec<[f64; 2]>,
}

impl Alignment {
    /// Aligns by contact, ruptures, confirmation and skin exit that both have, each by its first
    /// occurrence.
    #[must_use]
    pub fn new(one: &[Event], other: &[Event]) -> Self {
        let mut knots = vec![[0.0, 0.0]];
        for event in one {
            let Some(point) = WayPoint::at_event(event).filter(|point| first(one, point) == Some(event.t_s)) else {
                continue;
            };
            let last = knots.last().copied().unwrap_or_default();
            if let Some(there_s) = first(other, &point).filter(|there_s| *there_s > last[1] && event.t_s > last[0]) {
                knots.push([event.t_s, there_s]);
            }
        }
        Self { knots }
    }

    /// Returns the other's time for a time of the one, in s. Up to the last common point, time is
    /// interpolated linearly between points; beyond it, the other runs at its own speed.
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

/// A point that every attempt may pass.
#[derive(PartialEq)]
struct WayPoint {
    kind: EventKind,
    boundary: Option<u32>,
}

impl WayPoint {
    fn at_event(event: &Event) -> Option<Self> {
        use EventKind::{Confirm, Contact, RimRupture, SkinExit, TipRupture};
        let tells = matches!(event.kind, Contact | TipRupture | RimRupture | Confirm | SkinExit);
        tells.then_some(Self { kind: event.kind, boundary: event.boundary })
    }
}

/// Returns the time at which an attempt first passes a point, in s.
fn first(events: &[Event], point: &WayPoint) -> Option<f64> {
    events.iter().find(|event| WayPoint::at_event(event).as_ref() == Some(point)).map(|event| event.t_s)
}

#[cfg(test)]
mod tests {
    //! Fails if a ghost is not where the other attempt was at the same boundary, which would show a
    //! difference that does not exist.

    use EventKind::{Coaching, Confirm, Contact, TipRupture};

    use super::*;

    fn events(told: &[(EventKind, Option<u32>, f64)]) -> Vec<Event> {
        let event = |&(kind, boundary, t_s): &(EventKind, Option<u32>, f64)| Event {
            t_s,
            kind,
            boundary,
            x_m: 0.0,
            position_m: [0.0; 3],
            force_n: 0.0,
            dissipated_j: 0.0,
            track: None,
            structure: None,
            text: String::new(),
        };
        told.iter().map(event).collect()
    }

    #[track_caller]
    fn expect(alignment: &Alignment, pairs: &[[f64; 2]]) {
        for &[t_s, expected_s] in pairs {
            let found_s = alignment.other_s(t_s);
            assert!((found_s - expected_s).abs() < 1e-12, "{t_s} s is {found_s} s there, not {expected_s} s");
        }
    }

    #[test]
    fn alignment_matches_shared_events_and_stretches_between_them() {
        let one = events(&[(Contact, None, 2.0), (TipRupture, Some(0), 4.0), (Confirm, None, 8.0)]);
        let other = events(&[(Contact, None, 1.0), (TipRupture, Some(0), 5.0), (Confirm, None, 6.0)]);
        let alignment = Alignment::new(&one, &other);
        expect(
            &alignment,
            &[[0.0, 0.0], [1.0, 0.5], [2.0, 1.0], [3.0, 3.0], [4.0, 5.0], [6.0, 5.5], [8.0, 6.0], [9.5, 7.5]],
        );
    }

    #[test]
    fn what_only_one_went_through_and_what_is_said_count_nothing() {
        let one = events(&[(Contact, None, 2.0), (Coaching, None, 3.0), (TipRupture, Some(1), 4.0)]);
        let other = events(&[(Coaching, None, 0.5), (Contact, None, 3.0), (TipRupture, Some(0), 9.0)]);
        expect(&Alignment::new(&one, &other), &[[2.0, 3.0], [4.0, 5.0]]);
        expect(&Alignment::new(&one, &[]), &[[2.0, 2.0]]);
    }

    #[test]
    fn the_first_time_counts_and_time_never_runs_back() {
        let one = events(&[(Contact, None, 1.0), (TipRupture, Some(0), 2.0), (Contact, None, 5.0)]);
        let other = events(&[(TipRupture, Some(0), 1.0), (Contact, None, 3.0), (TipRupture, Some(0), 4.0)]);
        let alignment = Alignment::new(&one, &other);
        let times: Vec<f64> = (0..60).map(|tenth| alignment.other_s(f64::from(tenth) * 0.1)).collect();
        assert!(times.windows(2).all(|pair| pair[1] >= pair[0]));
        expect(&alignment, &[[1.0, 3.0]]);
    }
}
