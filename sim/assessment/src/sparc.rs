//! Spectral arc length of a speed profile (SPARC; Balasubramanian, Melendez-Calderon, Roby-Brami
//! and Burdet 2015, "On the analysis of movement smoothness", Journal of NeuroEngineering and
//! Rehabilitation 12, 112).

use std::f64::consts::PI;

/// Sample rate of the speed, in Hz.
pub(crate) const SPARC_HZ: f64 = 50.0;

/// The authors' settings: the spectrum is evaluated up to this frequency, in Hz, and from the first
/// to the last amplitude of at least this share of the largest; the speed is zero-padded to the
/// next power of two, times 2⁴.
const UP_TO_HZ: f64 = 10.0;
const LEAST_AMPLITUDE: f64 = 0.05;
const PADDED: usize = 16;

/// Returns −∫ √((df/Δf)² + dM²) over the normalised amplitudes M of the speed's spectrum; a
/// dimensionless number below −1, and the closer to −1 the smoother. `None` for fewer than two
/// points, and for a speed that is 0 throughout.
pub(crate) fn spectral_arc_length(speed: &[f64]) -> Option<f64> {
    if speed.len() < 2 {
        return None;
    }
    let points = speed.len().next_power_of_two() * PADDED;
    let mut real = speed.to_vec();
    real.resize(points, 0.0);
    let mut imaginary = vec![0.0; points];
    transform(&mut real, &mut imaginary);
    let looked_at = (UP_TO_HZ / SPARC_HZ * points as f64) as usize + 1;
    let amplitudes = real.iter().zip(&imaginary).map(|(re, im)| libm::hypot(*re, *im));
    let mut amplitudes: Vec<f64> = amplitudes.collect();
    let largest = amplitudes.iter().copied().fold(0.0, f64::max);
    amplitudes.truncate(looked_at);
    let is_high = |amplitude: &f64| *amplitude >= LEAST_AMPLITUDE * largest;
    let (first, last) = (amplitudes.iter().position(is_high)?, amplitudes.iter().rposition(is_high)?);
    if largest <= 0.0 || last == first {
        return None;
    }
    let step = 1.0 / (last - first) as f64;
    let arc = |pair: &[f64]| libm::hypot(step, (pair[1] - pair[0]) / largest);
    Some(-amplitudes[first..=last].windows(2).map(arc).sum::<f64>())
}

/// In-place discrete Fourier transform; the number of points is a power of two (Cooley and Tukey
/// 1965).
fn transform(real: &mut [f64], imaginary: &mut [f64]) {
    let points = real.len();
    let bits = points.trailing_zeros();
    for i in 0..points {
        let mirrored = i.reverse_bits() >> (usize::BITS - bits);
        if i < mirrored {
            real.swap(i, mirrored);
            imaginary.swap(i, mirrored);
        }
    }
    // A single table of twiddle factors, each exact to the last bit; repeated multiplication would
    // drift.
    let angle = |k: usize| -2.0 * PI * k as f64 / points as f64;
    let twiddles: Vec<(f64, f64)> = (0..points / 2).map(|k| (libm::cos(angle(k)), libm::sin(angle(k)))).collect();
    let mut half = 1;
    while half < points {
        let stride = points / (2 * half);
        for start in (0..points).step_by(2 * half) {
            for k in 0..half {
                let (cos, sin) = twiddles[k * stride];
                let (upper, lower) = (start + k, start + k + half);
                let re = real[lower] * cos - imaginary[lower] * sin;
                let im = real[lower] * sin + imaginary[lower] * cos;
                (real[lower], imaginary[lower]) = (real[upper] - re, imaginary[upper] - im);
                (real[upper], imaginary[upper]) = (real[upper] + re, imaginary[upper] + im);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    //! Compared with the authors' own program, run with numpy on the same speeds.

    use super::*;

    /// Columns: name of the speed, and numpy's result.
    const BY_NUMPY: &str = include_str!("../../../tests/data/sparc/by_numpy.csv");

    fn minimum_jerk(s: f64) -> f64 {
        30.0 * s * s * (1.0 - s) * (1.0 - s)
    }

    /// Returns the speeds for which the reference was computed.
    fn speed(name: &str) -> Vec<f64> {
        let points = |n: u32| (0..n).map(f64::from);
        match name {
            "one movement" => points(101).map(|i| minimum_jerk(i / 100.0)).collect(),
            "two with a pause" => {
                let at = |i: f64| {
                    if i < 100.0 { minimum_jerk(i / 100.0) } else { minimum_jerk((i - 150.0).max(0.0) / 100.0) }
                };
                points(251).map(at).collect()
            }
            "trembling" => {
                let at = |i: f64| minimum_jerk(i / 200.0) + 0.2 * libm::sin(2.0 * PI * 3.0 * i / SPARC_HZ).abs();
                points(201).map(at).collect()
            }
            "constant" => vec![1.0; 77],
            _ => points(1500).map(|i| 1.0 + 0.7 * libm::sin(0.05 * i) + 0.3 * libm::cos(0.31 * i + 1.0)).collect(),
        }
    }

    #[test]
    fn the_authors_programme_finds_the_same() {
        let mut rows = 0;
        for row in BY_NUMPY.lines().skip(1) {
            let (name, expected) = row.split_once(',').expect("two columns");
            let expected: f64 = expected.parse().expect("a number");
            let found = spectral_arc_length(&speed(name)).expect("a speed");
            assert!((found - expected).abs() < 1e-9, "{name}: {found}, by numpy {expected}");
            rows += 1;
        }
        assert_eq!(rows, 5);
    }

    #[test]
    fn what_does_not_move_has_no_spectrum() {
        assert_eq!(spectral_arc_length(&[]), None);
        assert_eq!(spectral_arc_length(&[1.0]), None);
        assert_eq!(spectral_arc_length(&[0.0; 100]), None);
        assert_eq!(spectral_arc_length(&[f64::NAN; 100]), None);
    }
}
