//! Reduces a long attempt to few samples without losing a peak.

use crate::sample::Sample;

/// Returns the samples of smallest and largest axial force in equal ranges: [`keep_extremes`].
/// Samples with a non-finite time, displacement or force are left out.
#[must_use]
pub fn thin(samples: &[Sample], most: usize) -> Vec<&Sample> {
    let finite: Vec<&Sample> = samples.iter().filter(|sample| is_finite(sample)).collect();
    keep_extremes(&finite, most, |sample| sample.axial_n()).into_iter().copied().collect()
}

/// Divides the items into `most / 2` equal ranges and returns, in order, those of smallest and
/// largest height of each; returns all items if there are at most `most`.
pub fn keep_extremes<T>(items: &[T], most: usize, height: impl Fn(&T) -> f64) -> Vec<&T> {
    if items.len() <= most {
        return items.iter().collect();
    }
    let stretches = most / 2;
    let by_height = |a: &&usize, b: &&usize| height(&items[**a]).total_cmp(&height(&items[**b]));
    let mut kept = Vec::with_capacity(most);
    for k in 0..stretches {
        let stretch: Vec<usize> = (k * items.len() / stretches..(k + 1) * items.len() / stretches).collect();
        let ends = stretch.iter().min_by(by_height).into_iter().chain(stretch.iter().max_by(by_height));
        let mut ends: Vec<usize> = ends.copied().collect();
        ends.sort_unstable();
        ends.dedup();
        kept.extend(ends.into_iter().map(|at| &items[at]));
    }
    kept
}

fn is_finite(sample: &Sample) -> bool {
    sample.t_s.is_finite() && sample.x_m.is_finite() && sample.axial_n().is_finite()
}

#[cfg(test)]
mod tests {
    //! A peak between two of every Nth sample must not be lost: peaks determine the score.

    use super::*;

    fn sample(t_s: f64, tip_n: f32) -> Sample {
        Sample { t_s, tip_n, ..Sample::default() }
    }

    #[test]
    fn every_extreme_stays_and_time_goes_on() {
        let mut samples: Vec<Sample> = (0..60_000).map(|i| sample(f64::from(i) * 1e-3, 0.5)).collect();
        (samples[31_234].tip_n, samples[45_678].tip_n) = (7.5, -2.5);
        let kept = thin(&samples, 600);
        assert!(kept.len() <= 600);
        for t_s in [31.234, 45.678] {
            assert!(kept.iter().any(|sample| (sample.t_s - t_s).abs() < 1e-9), "the extreme at {t_s} s");
        }
        assert!(kept.windows(2).all(|pair| pair[0].t_s < pair[1].t_s));
    }

    #[test]
    fn few_samples_stay_and_what_is_no_number_does_not() {
        let samples = [sample(0.0, 0.1), sample(1.0, f32::NAN), sample(2.0, 0.3)];
        let times: Vec<f64> = thin(&samples, 600).iter().map(|sample| sample.t_s).collect();
        assert_eq!(times, [0.0, 2.0]);
        assert!(thin(&[], 600).is_empty());
    }
}
