//! Marking the moment of each pop on a trace of force: what the pops are, what may be typed, and how near the marks come.

use attempt::{AttemptCurve, MarkKind};

use crate::Moment;

/// How near a mark must come to a pop to hit it, in s.
pub const TOLERANCE_S: f64 = 0.150;
/// Ruptures within so many seconds of the first look like one pop, and count as one.
const ONE_POP_S: f64 = 0.1;
/// Most marks on a trace.
pub const MOST_MARKS: usize = 100;
/// Length of a strip of the trace, in s, where there are not too many.
const STRIP_S: f64 = 5.0;
/// Most strips of a trace.
const MOST_STRIPS: f64 = 24.0;

/// The moments of the pops of an attempt, in s since its start: of tip and of rim, those that look like one once.
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

/// Beginning and end of each strip of a trace, in s.
#[must_use]
pub fn strips(duration_s: f64) -> Vec<(f64, f64)> {
    let duration_s = if duration_s.is_finite() { duration_s.max(0.0) } else { 0.0 };
    let length_s = STRIP_S.max((duration_s / MOST_STRIPS).ceil());
    let count = (duration_s / length_s).ceil().clamp(1.0, MOST_STRIPS);
    (0..count as u32).map(|n| (f64::from(n) * length_s, f64::from(n + 1) * length_s)).collect()
}

/// Why marks were refused: the place from 1, what was typed, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MarksRefused {
    /// One is no moment of the attempt.
    #[error("{}", tr!(
        "pop {place}: “{typed}”; allowed is a number of seconds from 0 to {last}",
        place = .place,
        typed = .typed,
        last = .last
    ))]
    NoMoment {
        /// Its place, from 1.
        place: usize,
        /// As it was typed.
        typed: String,
        /// The end of the attempt, in s, in words.
        last: String,
    },
    /// There are too many.
    #[error("{}", tr!("marks: {count}; allowed are at most {most}", count = .0, most = MOST_MARKS))]
    TooMany(usize),
}

/// Marks as they were typed, empty fields left out: in order of time, each once.
///
/// # Errors
/// When one is no moment of the attempt, or there are too many.
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

/// Marks against the truth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarksVerdict {
    /// Pops that were hit: the pop and its mark, in s.
    pub hits: Vec<(f64, f64)>,
    /// Pops that no mark hit, in s.
    pub missed: Vec<f64>,
    /// Marks that hit no pop, in s.
    pub false_marks: Vec<f64>,
}

impl MarksVerdict {
    /// Pairs pops and marks, both in order of time: as many hits as can be, and among those the nearest.
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

    /// Both verdicts together.
    #[must_use]
    pub fn join(mut self, other: Self) -> Self {
        self.hits.extend(other.hits);
        self.missed.extend(other.missed);
        self.false_marks.extend(other.false_marks);
        self
    }

    /// How many pops there were.
    #[must_use]
    pub fn pops(&self) -> usize {
        self.hits.len() + self.missed.len()
    }

    /// Mean distance of the hits, in ms; none without a hit.
    #[must_use]
    pub fn mean_error_ms(&self) -> Option<f64> {
        let n = u32::try_from(self.hits.len()).ok().filter(|n| *n > 0)?;
        Some(self.errors_ms().sum::<f64>() / f64::from(n))
    }

    /// Largest distance of a hit, in ms; none without a hit.
    #[must_use]
    pub fn largest_error_ms(&self) -> Option<f64> {
        self.errors_ms().reduce(f64::max)
    }

    fn errors_ms(&self) -> impl Iterator<Item = f64> + '_ {
        self.hits.iter().map(|(pop, mark)| (mark - pop).abs() * 1e3)
    }
}

/// Hits, and the sum of their distances in s.
type PairingValue = (usize, f64);

fn better(a: PairingValue, b: PairingValue) -> bool {
    a.0 > b.0 || (a.0 == b.0 && a.1 < b.1)
}

/// What a pair adds to what comes after it; none where the two are too far apart.
fn pair(pop: f64, mark: f64, after: PairingValue) -> Option<PairingValue> {
    let distance = (mark - pop).abs();
    // A mark typed at the very limit hits, whatever the last bit of the difference.
    (distance <= TOLERANCE_S + 1e-9).then(|| (after.0 + 1, after.1 + distance))
}

/// The best value of what is left from each pop and each mark on.
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

/// How somebody has done in a task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TraceOutcome {
    /// Traces that were sent.
    pub sent: usize,
    /// Traces that there are for them.
    pub traces: usize,
    /// Over all that were sent.
    pub verdict: MarksVerdict,
    /// One was sent after the task was due for them.
    pub late: bool,
    /// When it is due for them.
    pub due_at: Option<Moment>,
    /// Calendar days by which it was extended for them; 0 for none.
    pub extended_days: i64,
}

#[cfg(test)]
mod tests {
    //! Fails when a mark hits two pops, a near mark is wasted on a far pop, or a strip is missing.

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
        // 1.14 is nearer to the second pop, but taken for it the first would be missed.
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

    /// All sets of pops and marks on two grids that do not fit each other.
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
