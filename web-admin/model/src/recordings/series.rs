//! Minima and maxima of an attempt's signals over spans of time, at every scale: few enough values
//! to send, without losing a peak.
//!
//! A pyramid has a level with spans of a few samples, one with spans of eight of those, and so on.
//! A query uses the coarsest level that is still finer than requested, so that its cost is the same
//! for a minute and for an hour.

use attempt::{HandForces, HandSample};
use recording::{Recording, Sample};
use serde::Serialize;
use utoipa::ToSchema;

/// Maximum number of spans per query.
pub const MAX_POINTS: usize = 10_000;
/// Number of spans of a level that are combined in the next.
const FACTOR: usize = 8;
/// Maximum number of spans in the finest level: enough for every sample of two minutes at 1 kHz.
const MOST_FINEST: usize = 1 << 17;
/// Maximum number of spans in the coarsest level.
const MOST_COARSEST: usize = 256;
/// Start of each file, with the version of the format.
const MAGIC: &[u8; 8] = b"pyramid1";
/// Size of a span: number of values, and bytes.
const NUMBERS: usize = 6;
const SPAN_BYTES: usize = NUMBERS * 8;

/// A span of time with the minima and maxima of the signals in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = Span)]
pub struct TimeSpan {
    /// Time of its first sample, in s.
    pub t_s: f64,
    /// Minimum depth of the tip, in mm.
    pub depth_min_mm: f64,
    /// Maximum depth of the tip, in mm.
    pub depth_max_mm: f64,
    /// Least force on the hand along the needle, in N.
    pub force_min_n: f64,
    /// Greatest force on the hand along the needle, in N.
    pub force_max_n: f64,
    /// Maximum lateral force on the hand, in N.
    pub lateral_max_n: f64,
}

impl TimeSpan {
    /// One sample with the force on the hand along the needle in N. A value that is not a number stays one, so that it never counts among
    /// its neighbours.
    fn of(HandSample { sample, force_n }: HandSample<'_>) -> Self {
        let finite = |value: f64| if value.is_finite() { value } else { f64::NAN };
        let (depth_mm, force_n) = (finite(f64::from(sample.depth_m) * 1e3), finite(force_n));
        Self {
            t_s: sample.t_s,
            depth_min_mm: depth_mm,
            depth_max_mm: depth_mm,
            force_min_n: force_n,
            force_max_n: force_n,
            lateral_max_n: finite(lateral_n(sample)),
        }
    }

    /// Combines this span with a later one.
    fn join(self, later: Self) -> Self {
        Self {
            t_s: self.t_s,
            depth_min_mm: self.depth_min_mm.min(later.depth_min_mm),
            depth_max_mm: self.depth_max_mm.max(later.depth_max_mm),
            force_min_n: self.force_min_n.min(later.force_min_n),
            force_max_n: self.force_max_n.max(later.force_max_n),
            lateral_max_n: self.lateral_max_n.max(later.lateral_max_n),
        }
    }

    const fn numbers(self) -> [f64; NUMBERS] {
        let Self { t_s, depth_min_mm, depth_max_mm, force_min_n, force_max_n, lateral_max_n } = self;
        [t_s, depth_min_mm, depth_max_mm, force_min_n, force_max_n, lateral_max_n]
    }

    const fn from_numbers(numbers: [f64; NUMBERS]) -> Self {
        let [t_s, depth_min_mm, depth_max_mm, force_min_n, force_max_n, lateral_max_n] = numbers;
        Self { t_s, depth_min_mm, depth_max_mm, force_min_n, force_max_n, lateral_max_n }
    }

    /// Replaces NaN by 0 for display, in spans without a finite value.
    fn shown(self) -> Self {
        Self::from_numbers(self.numbers().map(|value| if value.is_nan() { 0.0 } else { value }))
    }
}

/// Returns the lateral force on the hand, in N.
#[must_use]
pub fn lateral_n(sample: &Sample) -> f64 {
    sample.lateral_n.iter().map(|&part| f64::from(part) * f64::from(part)).sum::<f64>().sqrt()
}

/// A section of an attempt, in s from its start; `None` means its start or end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AttemptStretch {
    /// Start.
    pub from_s: Option<f64>,
    /// End.
    pub to_s: Option<f64>,
}

/// Spans at every scale, in the format of the file; a query decodes only the spans that it needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pyramid {
    bytes: Vec<u8>,
    /// First byte and number of spans of each level, finest first.
    levels: Vec<(usize, usize)>,
}

impl Pyramid {
    /// Builds the pyramid of a recording.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let forces = HandForces::measure(recording);
        Self::of_samples(&forces.iter().collect::<Vec<_>>())
    }

    /// Builds the pyramid of samples in order of time, each with the force on the hand along the needle in N.
    fn of_samples(samples: &[HandSample<'_>]) -> Self {
        let mut base = 1;
        while samples.len().div_ceil(base) > MOST_FINEST {
            base *= FACTOR;
        }
        let joined = |spans: &mut dyn Iterator<Item = TimeSpan>| spans.reduce(TimeSpan::join);
        let finest = samples.chunks(base).filter_map(|few| joined(&mut few.iter().copied().map(TimeSpan::of)));
        let mut levels: Vec<Vec<TimeSpan>> = vec![finest.collect()];
        while let Some(last) = levels.last().filter(|last| last.len() > MOST_COARSEST) {
            let above = last.chunks(FACTOR).filter_map(|few| joined(&mut few.iter().copied())).collect();
            levels.push(above);
        }
        Self::pack(&levels)
    }

    fn pack(levels: &[Vec<TimeSpan>]) -> Self {
        let mut bytes = MAGIC.to_vec();
        bytes.extend((levels.len() as u64).to_le_bytes());
        levels.iter().for_each(|level| bytes.extend((level.len() as u64).to_le_bytes()));
        let mut places = Vec::with_capacity(levels.len());
        for level in levels {
            places.push((bytes.len(), level.len()));
            let numbers = level.iter().flat_map(|span| span.numbers());
            bytes.extend(numbers.flat_map(f64::to_le_bytes));
        }
        Self { bytes, levels: places }
    }

    /// Returns the content of the file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Parses a file. `None` if it does not have this format or is incomplete.
    #[must_use]
    pub fn from_bytes(bytes: Vec<u8>) -> Option<Self> {
        let word = |at: usize| {
            let word = bytes.get(at..)?.first_chunk::<8>()?;
            usize::try_from(u64::from_le_bytes(*word)).ok()
        };
        let count = word(MAGIC.len()).filter(|count| bytes.starts_with(MAGIC) && *count <= 64)?;
        let mut at = MAGIC.len() + 8 * (count + 1);
        let mut levels = Vec::with_capacity(count);
        for level in 0..count {
            let spans = word(MAGIC.len() + 8 * (level + 1))?;
            levels.push((at, spans));
            at = at.checked_add(spans.checked_mul(SPAN_BYTES)?)?;
        }
        (at == bytes.len()).then_some(Self { bytes, levels })
    }

    /// Returns at most `points` spans over a section, with numbers of samples as equal as possible.
    /// The first and last span extend to the next sample beyond the section, so that a line through
    /// them crosses the whole plot.
    #[must_use]
    pub fn spans(&self, points: usize, stretch: AttemptStretch) -> Vec<TimeSpan> {
        let points = points.clamp(1, MAX_POINTS);
        let fine_enough = |&&(start, count): &&(usize, usize)| {
            let (from, to) = self.within(start, count, stretch);
            to - from >= points
        };
        let finest = self.levels.first();
        let Some(&(start, count)) = self.levels.iter().rfind(fine_enough).or(finest) else { return Vec::new() };
        let (from, to) = self.within(start, count, stretch);
        let made = points.min(to - from);
        let group = |k: usize| (from + k * (to - from) / made)..(from + (k + 1) * (to - from) / made);
        (0..made)
            .filter_map(|k| group(k).map(|i| self.span(start, i)).reduce(TimeSpan::join))
            .map(TimeSpan::shown)
            .collect()
    }

    /// Returns the index range of a level's spans, from the last one that starts at or before the
    /// section to the first one that starts after it.
    fn within(&self, start: usize, count: usize, stretch: AttemptStretch) -> (usize, usize) {
        let time = |i: usize| self.span(start, i).t_s;
        let from = stretch.from_s.map_or(0, |from_s| first(count, |i| time(i) > from_s).saturating_sub(1));
        let to = stretch.to_s.map_or(count, |to_s| (first(count, |i| time(i) > to_s) + 1).min(count));
        (from, to.max(from))
    }

    fn span(&self, start: usize, index: usize) -> TimeSpan {
        let at = start + index * SPAN_BYTES;
        let words = self.bytes.get(at..at + SPAN_BYTES).unwrap_or_default().as_chunks::<8>().0;
        TimeSpan::from_numbers(std::array::from_fn(|k| words.get(k).map_or(f64::NAN, |word| f64::from_le_bytes(*word))))
    }
}

/// Returns the first of `count` indices for which `holds` is true, or `count`. The condition must
/// hold for all later indices, too.
fn first(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) { high = middle } else { low = middle + 1 }
    }
    low
}

#[cfg(test)]
mod tests {
    //! Checks that no peak is lost between spans or levels, that invalid values do not affect their
    //! neighbours, and that truncated files are rejected.
    use super::*;

    const ALL: AttemptStretch = AttemptStretch { from_s: None, to_s: None };

    /// The pyramid of one sample a second with these forces.
    fn pyramid(forces_n: &[f64]) -> Pyramid {
        let samples: Vec<Sample> =
            (0..forces_n.len()).map(|t_s| Sample { t_s: t_s as f64, ..Sample::default() }).collect();
        let hand = samples.iter().zip(forces_n).map(|(sample, &force_n)| HandSample { sample, force_n });
        Pyramid::of_samples(&hand.collect::<Vec<_>>())
    }

    #[test]
    fn no_peak_is_lost_at_any_scale() {
        for (length, peak) in [(40, 3), (40, 39), (5000, 4321), (300_000, 123_456)] {
            let mut forces_n = vec![0.5_f64; length];
            (forces_n[peak], forces_n[length - 1 - peak]) = (7.0, -3.0);
            let pyramid = pyramid(&forces_n);
            for points in [1, 7, 40, 999] {
                let made = pyramid.spans(points, ALL);
                assert_eq!(made.len(), points.min(length));
                let highest = made.iter().map(|s| s.force_max_n).fold(f64::MIN, f64::max);
                let lowest = made.iter().map(|s| s.force_min_n).fold(f64::MAX, f64::min);
                assert_eq!(
                    (highest.to_bits(), lowest.to_bits()),
                    (7.0_f64.to_bits(), (-3.0_f64).to_bits()),
                    "{length}"
                );
            }
        }
    }

    #[test]
    fn a_stretch_shows_what_is_in_it_and_nothing_far_outside() {
        let forces_n: Vec<f64> = (0..10_000_u16).map(f64::from).collect();
        let pyramid = pyramid(&forces_n);
        let made = pyramid.spans(50, AttemptStretch { from_s: Some(4000.0), to_s: Some(4999.0) });
        assert_eq!(made.len(), 50);
        assert!((3980.0..=4000.0).contains(&made[0].t_s), "{:?}", made[0]);
        assert!((4999.0..=5020.0).contains(&made[49].force_max_n), "{:?}", made[49]);
        assert!(made.windows(2).all(|pair| pair[0].t_s < pair[1].t_s));
        let beyond = pyramid.spans(50, AttemptStretch { from_s: Some(1e9), to_s: Some(2e9) });
        assert!(beyond.len() <= 1, "{beyond:?}");
    }

    #[test]
    fn few_samples_make_few_spans_and_none_make_none() {
        assert_eq!(pyramid(&[1.0, 2.0]).spans(1000, ALL).len(), 2);
        assert!(pyramid(&[]).spans(1000, ALL).is_empty());
        let made = pyramid(&[f64::NAN, 2.0]).spans(1, ALL);
        assert!(made[0].force_max_n > 1.9 && made[0].force_min_n > 1.9, "{made:?}");
        let nothing = pyramid(&[f64::NAN]).spans(1, ALL);
        assert!(nothing[0].force_max_n.abs() < 1e-12, "{nothing:?}");
    }

    #[test]
    fn a_file_reads_back_and_a_cut_one_does_not() {
        let pyramid = pyramid(&[1.0; 700]);
        let bytes = pyramid.bytes().to_vec();
        assert_eq!(Pyramid::from_bytes(bytes.clone()).as_ref(), Some(&pyramid));
        for cut in [0, 8, 20, bytes.len() - 1] {
            assert_eq!(Pyramid::from_bytes(bytes[..cut].to_vec()), None, "{cut}");
        }
        let mut huge = bytes;
        huge[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
        assert_eq!(Pyramid::from_bytes(huge), None);
    }
}
