//! Low-pass filter and derivative of uniformly sampled columns.

/// Rate of the uniform grid, in Hz. The lower of the rates that must agree: recordings at 1 kHz and
/// 250 Hz share their grid points, whereas a faster grid would interpolate linearly between the
/// slower one's samples.
pub(crate) const RATE_HZ: f64 = 250.0;

/// Cut-off of the low-pass before every derivative, in Hz. Passes an 8–12 Hz tremor.
pub(crate) const CUTOFF_HZ: f64 = 20.0;

/// Cut-off that separates the hand's intent from its tremor, in Hz: it leaves 6 % of 8 Hz and 1 %
/// of 12 Hz.
pub(crate) const INTENT_HZ: f64 = 4.0;

/// Number of cut-off periods by which a column is extended at each end: the filter's transient
/// decays to below 1e-12 within them.
const PAD_PERIODS: f64 = 8.0;

/// Coefficients of a second-order section with `a0 = 1`.
struct FilterSection {
    b: [f64; 3],
    a: [f64; 2],
}

impl FilterSection {
    /// Designs a second-order Butterworth low-pass by the bilinear transform with pre-warping
    /// (Oppenheim and Schafer, Discrete-Time Signal Processing, section 7.1).
    fn low_pass(cutoff_hz: f64) -> Self {
        let k = libm::tan(std::f64::consts::PI * cutoff_hz / RATE_HZ);
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * k + k * k);
        let b0 = k * k * norm;
        let a1 = 2.0 * (k * k - 1.0) * norm;
        let a2 = (1.0 - std::f64::consts::SQRT_2 * k + k * k) * norm;
        Self { b: [b0, 2.0 * b0, b0], a: [a1, a2] }
    }

    /// Filters in place, in steady state for the first value.
    fn run(&self, values: &mut [f64]) {
        let first = values.first().copied().unwrap_or(0.0);
        let mut z2 = (self.b[2] - self.a[1]) * first;
        let mut z1 = (self.b[1] - self.a[0]) * first + z2;
        for value in values {
            let x = *value;
            let y = self.b[0] * x + z1;
            z1 = self.b[1] * x - self.a[0] * y + z2;
            z2 = self.b[2] * x - self.a[1] * y;
            *value = y;
        }
    }
}

/// Low-passes a uniform column at a cut-off in Hz, forwards and backwards, so that there is no
/// delay.
///
/// Each end is extended by its point reflection: a constant and a straight line pass unchanged up
/// to the ends.
pub(crate) fn low_pass(column: &[f64], cutoff_hz: f64) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (column.first(), column.last()) else { return Vec::new() };
    let pad = ((PAD_PERIODS * RATE_HZ / cutoff_hz) as usize).min(column.len() - 1);
    let mut padded = Vec::with_capacity(column.len() + 2 * pad);
    padded.extend((1..=pad).rev().map(|i| 2.0 * first - column[i]));
    padded.extend_from_slice(column);
    padded.extend((1..=pad).map(|i| 2.0 * last - column[column.len() - 1 - i]));
    let section = FilterSection::low_pass(cutoff_hz);
    section.run(&mut padded);
    padded.reverse();
    section.run(&mut padded);
    padded.reverse();
    padded.drain(..pad);
    padded.truncate(column.len());
    padded
}

/// Returns the derivative of a uniform column per second: central differences, one-sided at the
/// ends.
pub(crate) fn derivative(column: &[f64]) -> Vec<f64> {
    let last = column.len().saturating_sub(1);
    (0..column.len())
        .map(|i| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
            if after == before { 0.0 } else { (column[after] - column[before]) * RATE_HZ / (after - before) as f64 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    //! The low-pass has the gain of its closed form, no delay and no transients at the ends.

    use super::*;

    const PI: f64 = std::f64::consts::PI;

    fn sine(frequency_hz: f64, points: usize) -> Vec<f64> {
        (0..points).map(|i| libm::sin(2.0 * PI * frequency_hz * i as f64 / RATE_HZ)).collect()
    }

    #[test]
    fn a_sine_keeps_its_phase_and_takes_the_closed_gain() {
        for cutoff_hz in [CUTOFF_HZ, INTENT_HZ] {
            for frequency_hz in [1.0, 10.0, 20.0, 40.0] {
                let ratio = libm::tan(PI * frequency_hz / RATE_HZ) / libm::tan(PI * cutoff_hz / RATE_HZ);
                let gain = 1.0 / (1.0 + ratio.powi(4));
                let input = sine(frequency_hz, 4000);
                let output = low_pass(&input, cutoff_hz);
                for i in 1500..2500 {
                    assert!(
                        (output[i] - gain * input[i]).abs() < 1e-9,
                        "{frequency_hz} Hz at {i} behind {cutoff_hz} Hz"
                    );
                }
            }
        }
    }

    #[test]
    fn straight_lines_pass_unchanged_to_the_ends() {
        let line: Vec<f64> = (0..400).map(|i| 3.0 - 0.25 * f64::from(i)).collect();
        for cutoff_hz in [CUTOFF_HZ, INTENT_HZ] {
            for (i, (a, b)) in line.iter().zip(low_pass(&line, cutoff_hz)).enumerate() {
                assert!((a - b).abs() < 1e-9, "point {i}: {a} became {b}");
            }
        }
    }

    #[test]
    fn short_columns_are_filtered_too() {
        assert!(low_pass(&[], CUTOFF_HZ).is_empty());
        assert_eq!(low_pass(&[7.0], INTENT_HZ).len(), 1);
        assert!(low_pass(&[7.0, 7.0], INTENT_HZ).iter().all(|v| (v - 7.0).abs() < 1e-12));
    }

    #[test]
    fn the_derivative_of_a_parabola_is_exact_inside() {
        let parabola: Vec<f64> = (0..100).map(|i| (f64::from(i) / RATE_HZ).powi(2)).collect();
        for (i, slope) in derivative(&parabola).iter().enumerate().take(99).skip(1) {
            assert!((slope - 2.0 * i as f64 / RATE_HZ).abs() < 1e-12);
        }
        assert_eq!(derivative(&[1.0]), vec![0.0]);
    }
}
