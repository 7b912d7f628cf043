//! An attempt as smallest and largest values over equal spans of time: few enough to send, and no peak lost.

use recording::Sample;
use serde::Serialize;
use utoipa::ToSchema;

/// Most spans that are made.
pub const MAX_POINTS: usize = 10_000;

/// A span of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Span {
    /// Time of its first sample, in s.
    pub t_s: f64,
    /// Least depth of the tip, in mm.
    pub depth_min_mm: f64,
    /// Greatest depth of the tip, in mm.
    pub depth_max_mm: f64,
    /// Least axial force on the hand, in N.
    pub force_min_n: f64,
    /// Greatest axial force on the hand, in N.
    pub force_max_n: f64,
    /// Greatest sideways force on the hand, in N.
    pub lateral_max_n: f64,
}

impl Span {
    fn of(samples: &[Sample]) -> Option<Self> {
        let t_s = samples.first()?.t_s;
        let range = |value: fn(&Sample) -> f64| {
            let values = samples.iter().map(value).filter(|v| v.is_finite());
            // A span without one finite value has nothing to show and reads 0.
            values.fold(None, |seen: Option<(f64, f64)>, v| Some(seen.map_or((v, v), |(a, b)| (a.min(v), b.max(v)))))
        };
        let (depth_min_mm, depth_max_mm) = range(|s| f64::from(s.depth_m) * 1e3).unwrap_or_default();
        let (force_min_n, force_max_n) = range(Sample::axial_n).unwrap_or_default();
        let (_, lateral_max_n) = range(lateral_n).unwrap_or_default();
        Some(Self { t_s, depth_min_mm, depth_max_mm, force_min_n, force_max_n, lateral_max_n })
    }
}

fn lateral_n(sample: &Sample) -> f64 {
    sample.lateral_n.iter().map(|&part| f64::from(part) * f64::from(part)).sum::<f64>().sqrt()
}

/// At most `points` spans, of as equal a number of samples as can be.
#[must_use]
pub fn spans(samples: &[Sample], points: usize) -> Vec<Span> {
    let count = points.clamp(1, MAX_POINTS).min(samples.len());
    (0..count).filter_map(|k| Span::of(&samples[k * samples.len() / count..(k + 1) * samples.len() / count])).collect()
}

#[cfg(test)]
mod tests {
    //! Fails when a peak falls between two spans, or a broken number spoils its neighbours.
    use super::*;

    fn samples(forces_n: &[f32]) -> Vec<Sample> {
        let times = (0..).map(f64::from);
        times.zip(forces_n).map(|(t_s, &tip_n)| Sample { t_s, tip_n, ..Sample::default() }).collect()
    }

    #[test]
    fn no_peak_is_lost() {
        for count in 1..40 {
            let mut forces_n = vec![0.5_f32; 40];
            forces_n[count] = 7.0;
            forces_n[39 - count] = -3.0;
            let made = spans(&samples(&forces_n), count);
            assert_eq!(made.len(), count);
            let highest = made.iter().map(|s| s.force_max_n).fold(f64::MIN, f64::max);
            let lowest = made.iter().map(|s| s.force_min_n).fold(f64::MAX, f64::min);
            assert_eq!((highest.to_bits(), lowest.to_bits()), (7.0_f64.to_bits(), (-3.0_f64).to_bits()), "{count}");
        }
    }

    #[test]
    fn few_samples_make_few_spans_and_none_make_none() {
        assert_eq!(spans(&samples(&[1.0, 2.0]), 1000).len(), 2);
        assert!(spans(&[], 1000).is_empty());
        let made = spans(&samples(&[f32::NAN, 2.0]), 1);
        assert!(made[0].force_max_n > 1.9 && made[0].force_min_n > 1.9, "{made:?}");
    }
}
