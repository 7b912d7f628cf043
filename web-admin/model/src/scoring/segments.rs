//! Marking pops on a force trace: the true times, validation of the marks, and their accuracy.

use attempt::{AttemptCurve, MarkKind};

use crate::Moment;

/// Maximum distance between a mark and the pop that it hits, in s.
pub const TOLERANCE_S: f64 = 0.150;
/// Ruptures within this time after the first look like one pop and count as one, in s.
const ONE_POP_S: f64 = 0.1;
/// Maximum number of marks on a trace.
pub const MOST_MARKS: usize = 100;
/// Length of a strip of the trace, in s, unless this makes too many strips.
const STRIP_S: f64 = 5.0;
/// Maximum number of strips per trace.
const MOST_STRIPS: f64 = 24.0;

/// Returns the times of an attempt's pops, in s from its start: ruptures by tip and rim, with those
/// that look like one pop counted once.
#[must_use]
pub fn pops(curve: &AttemptCurve) -> Vec<f64> {
    let ruptures = curve.marks.iter().filter(|mark| matches!(mark.kind, MarkKind::TipRupture | MarkKind::RimRupture));
    let mut moments: Vec<f64> = ruptures.map(|mark| mark.t_s).collect();
    moments.sort_by(f64::total_cmp);
    let mut pops: Vec<f64> = Vec::new();
    for moment in moments {
        if pops.last().is_none_or(|first| moment - first > ONE_POP_S) {
            pops.push(moment);
        }
    }
    pops
}

/// Returns start and end of each strip of a trace, in s.
#[must_use]
pub fn strips(duration_s: f64) -> Vec<(f64, f64)> {
    let duration_s = if duration_s.is_finite() { duration_s.max(0.0) } else { 0.0 };
    let length_s = STRIP_S.max((duration_s / MOST_STRIPS).ceil());
    let count = (duration_s / length_s).ceil().clamp(1.0, MOST_STRIPS);
    (0..count as u32).map(|n| (f64::from(n) * length_s, f64::from(n + 1) * length_s)).collect()
}

/// Reason why marks are refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MarksRefused {
    /// A mark is not a time within the attempt.
    #[error("{}", tr!(
        "pop {place}: “{typed}”; allowed: 0 to {last} seconds",
        place = .place,
        typed = .typed,
        last = .last
    ))]
    NoMoment {
        /// Number of the mark, from 1.
        place: usize,
        /// Text as entered.
        typed: String,
        /// End of the attempt, in s, as text.
        last: String,
    },
    /// There are too many marks.
    #[error("{}", tr!("marks: {count}; allowed: at most {most}", count = .0, most = MOST_MARKS))]
    TooMany(usize),
}

/// Parses marks and ignores empty fields. Returns them sorted, without duplicates, in s.
///
/// # Errors
/// If a mark is not a time within the attempt, or there are too many.
pub fn read_pop_marks(typed: &[impl AsRef<str>], duration_s: f64) -> Result<Vec<f64>, MarksRefused> {
    let mut marks = Vec::new();
    for (at, said) in typed.iter().map(AsRef::as_ref).enumerate().filter(|(_, said)| !said.trim().is_empty()) {
        let moment = said.trim().replace(',', ".").parse::<f64>().ok();
        let allowed = moment.filter(|moment| (0.0..=duration_s).contains(moment));
        let last = format!("{duration_s:.2}");
        marks.push(allowed.ok_or_else(|| MarksRefused::NoMoment { place: at + 1, typed: said.to_owned(), last })?);
    }
    if marks.len() > MOST_MARKS {
        return Err(MarksRefused::TooMany(marks.len()));
    }
    marks.sort_by(f64::total_cmp);
    marks.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    Ok(marks)
}

/// Marks compared with the true pops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarksVerdict {
    /// Pops that were hit: time of the pop and of the mark, in s.
    pub hits: Vec<(f64, f64)>,
    /// Pops without a mark, in s.
    pub missed: Vec<f64>,
    /// Marks without a pop, in s.
    pub false_marks: Vec<f64>,
}

impl MarksVerdict {
    /// Pairs pops and marks, both sorted by time: the maximum number of hits, and among those the
    /// minimum sum of distances.
    #[must_use]
    pub fn of(pops: &[f64], marks: &[f64]) -> Self {
        let best = best(pops, marks);
        let mut verdict = Self::default();
        let (mut p, mut m) = (0, 0);
        while p < pops.len() && m < marks.len() {
            if pair(pops[p], marks[m], best[p + 1][m + 1]).is_some_and(|value| !better(best[p][m], value)) {
                verdict.hits.push((pops[p], marks[m]));
                (p, m) = (p + 1, m + 1);
            } else if better(best[p + 1][m], best[p][m + 1]) {
                verdict.missed.push(pops[p]);
                p += 1;
            } else {
                verdict.false_marks.push(marks[m]);
                m += 1;
            }
        }
        verdict.missed.extend(&pops[p..]);
        verdict.false_marks.extend(&marks[m..]);
        verdict
    }

    /// Combines two results.
    #[must_use]
    pub fn join(mut self, other: Self) -> Self {
        self.hits.extend(other.hits);
        self.missed.extend(other.missed);
        self.false_marks.extend(other.false_marks);
        self
    }

    /// Returns the number of pops.
    #[must_use]
    pub fn pops(&self) -> usize {
        self.hits.len() + self.missed.len()
    }

    /// Returns the mean distance of the hits, in ms; `None` without hits.
    #[must_use]
    pub fn mean_error_ms(&self) -> Option<f64> {
        let n = u32::try_from(self.hits.len()).ok().filter(|n| *n > 0)?;
        Some(self.errors_ms().sum::<f64>() / f64::from(n))
    }

    /// Returns the largest distance of a hit, in ms; `None` without hits.
    #[must_use]
    pub fn largest_error_ms(&self) -> Option<f64> {
        self.errors_ms().reduce(f64::max)
    }

    fn errors_ms(&self) -> impl Iterator<Item = f64> + '_ {
        self.hits.iter().map(|(pop, mark)| (mark - pop).abs() * 1e3)
    }
}

/// Number of hits, and sum of their distances in s.
type PairingValue = (usize, f64);

fn better(a: PairingValue, b: PairingValue) -> bool {
    a.0 > b.0 || (a.0 == b.0 && a.1 < b.1)
}

/// Adds a pair to the value of the remainder; `None` if the two are too far apart.
fn pair(pop: f64, mark: f64, after: PairingValue) -> Option<PairingValue> {
    let distance = (mark - pop).abs();
    // The margin makes a mark exactly at the limit hit, regardless of rounding.
    (distance <= TOLERANCE_S + 1e-9).then(|| (after.0 + 1, after.1 + distance))
}

/// Returns the best value for the remainder from each pop and each mark on (dynamic programming).
fn best(pops: &[f64], marks: &[f64]) -> Vec<Vec<PairingValue>> {
    let mut table = vec![vec![(0, 0.0); marks.len() + 1]; pops.len() + 1];
    for p in (0..pops.len()).rev() {
        for m in (0..marks.len()).rev() {
            let skipped = if better(table[p + 1][m], table[p][m + 1]) { table[p + 1][m] } else { table[p][m + 1] };
            let paired = pair(pops[p], marks[m], table[p + 1][m + 1]);
            table[p][m] = paired.filter(|paired| !better(skipped, *paired)).unwrap_or(skipped);
        }
    }
    table
}

/// A person's result in a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TraceOutcome {
    /// Number of submitted traces.
    pub sent: usize,
    /// Number of traces for this person.
    pub traces: usize,
    /// Result over all submitted traces.
    pub verdict: MarksVerdict,
    /// A trace was submitted after the person's due date.
    pub late: bool,
    /// Due date for this person.
    pub due_at: Option<Moment>,
    /// Length of the person's extension, in calendar days; 0 without one.
    pub extended_days: i64,
}

#[cfg(test)]
mod tests {
    //! Checks that a mark hits at most one pop, that the number of hits is maximal, and that no
    //! strip is missing.

    use attempt::CurveMark;

    use super::*;

    fn verdict(pops: &[f64], marks: &[f64]) -> (usize, usize, usize) {
        let verdict = MarksVerdict::of(pops, marks);
        (verdict.hits.len(), verdict.missed.len(), verdict.false_marks.len())
    }

    #[test]
    fn each_mark_hits_one_pop_at_most() {
        assert_eq!(verdict(&[1.0, 2.0, 3.0], &[1.1, 2.4, 3.15]), (2, 1, 1));
        assert_eq!(verdict(&[1.0, 1.2], &[1.1]), (1, 1, 0));
        assert_eq!(verdict(&[1.0], &[0.9, 1.05, 1.1]), (1, 0, 2));
        // 1.14 is nearer to the second pop, but pairing them would miss the first.
        assert_eq!(verdict(&[1.0, 1.2], &[1.14, 1.3]), (2, 0, 0));
        assert_eq!(verdict(&[], &[1.0]), (0, 0, 1));
        assert_eq!(verdict(&[1.0], &[]), (0, 1, 0));
    }

    #[test]
    fn errors_are_of_the_hits_in_milliseconds() {
        let found = MarksVerdict::of(&[1.0, 2.0, 9.0], &[1.1, 1.98, 5.0]);
        assert!((found.mean_error_ms().expect("two hits") - 60.0).abs() < 1e-6);
        assert!((found.largest_error_ms().expect("two hits") - 100.0).abs() < 1e-6);
        assert_eq!(MarksVerdict::of(&[1.0], &[]).mean_error_ms(), None);
        assert_eq!(MarksVerdict::of(&[1.0], &[0.9]).hits, [(1.0, 0.9)]);
    }

    /// Tests all subsets of pops and marks on two incommensurate grids.
    #[test]
    fn nothing_is_lost_or_counted_twice_however_marks_lie() {
        let chosen = |mask: u32, step_s: f64| -> Vec<f64> {
            (0..6_u32).filter(|bit| mask >> bit & 1 == 1).map(|bit| f64::from(bit) * step_s).collect()
        };
        for (pops, marks) in (0..64).flat_map(|p| (0..64).map(move |m| (chosen(p, 0.11), chosen(m, 0.13)))) {
            let found = MarksVerdict::of(&pops, &marks);
            assert_eq!(found.pops(), pops.len());
            assert_eq!(found.hits.len() + found.false_marks.len(), marks.len());
            assert!(found.largest_error_ms().is_none_or(|ms| ms <= TOLERANCE_S * 1e3 + 1e-5));
            let reachable = |pop: &f64| found.false_marks.iter().any(|mark| (mark - pop).abs() <= TOLERANCE_S);
            assert!(!found.missed.iter().any(reachable), "{pops:?} {marks:?}: a false mark could have hit");
        }
    }

    #[test]
    fn ruptures_of_one_moment_are_one_pop() {
        let mark = |kind, t_s| CurveMark { kind, t_s, advance_mm: 0.0, axial_n: 0.0, name: String::new() };
        let curve = AttemptCurve {
            bands: vec![],
            points: vec![],
            marks: vec![
                mark(MarkKind::Contact, 0.2),
                mark(MarkKind::RimRupture, 2.05),
                mark(MarkKind::TipRupture, 2.0),
                mark(MarkKind::TipRupture, 3.0),
                mark(MarkKind::Confirm, 3.5),
            ],
            stages: vec![],
            target_depth_mm: 0.0,
            duration_s: 5.0,
        };
        assert_eq!(pops(&curve), [2.0, 3.0]);
    }

    #[test]
    fn what_is_typed_is_a_moment_of_the_attempt() {
        assert_eq!(read_pop_marks(&["3,5", "", " 1.25 ", "3.5"], 10.0), Ok(vec![1.25, 3.5]));
        for typed in ["-0.1", "10.01", "nan", "inf", "soon"] {
            let refused = read_pop_marks(&["1", typed], 10.0).expect_err(typed).to_string();
            assert!(refused.contains("pop 2") && refused.contains(typed) && refused.contains("10.00"), "{refused}");
        }
        assert_eq!(read_pop_marks(&["1"; 200], 10.0), Err(MarksRefused::TooMany(200)));
    }

    #[test]
    fn strips_cover_the_attempt() {
        assert_eq!(strips(12.0), [(0.0, 5.0), (5.0, 10.0), (10.0, 15.0)]);
        for duration_s in [0.0, 5.0, 26.3, 600.0, 7200.0, f64::NAN] {
            let strips = strips(duration_s);
            assert!((1..=24).contains(&strips.len()), "{duration_s}");
            assert!(strips.last().is_some_and(|(_, end)| *end >= duration_s || duration_s.is_nan()), "{duration_s}");
        }
    }
}
