//! Modulation of the set-point's speed by slow waves, so that an uneven hand advances in fits and
//! starts.

use super::gauss::Draw;
use super::wave::Wave;

/// Number of sinusoids.
const WAVES: usize = 5;
/// Their band, in Hz: the sub-movements of a voluntary motion lie below 2 Hz.
const BAND_HZ: [f64; 2] = [0.3, 1.5];

/// A factor on the speed.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    swells: [Wave; WAVES],
    amplitude: f64,
}

impl Pace {
    /// A pace whose factor has mean 1 and the given standard deviation before it is clamped at 0:
    /// the hand halts, but does not retract.
    pub fn new(unevenness: f64, draw: &mut Draw) -> Self {
        let mut swells = [Wave::default(); WAVES];
        swells.fill_with(|| Wave::draw(BAND_HZ, draw));
        Self { swells, amplitude: unevenness * libm::sqrt(2.0 / WAVES as f64) }
    }

    /// The factor at a time in s, 0 or more.
    pub fn at(&self, t_s: f64) -> f64 {
        let wave: f64 = self.swells.iter().map(|swell| swell.at(t_s)).sum();
        (1.0 + self.amplitude * wave).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pace_has_the_requested_spread_and_is_never_negative() {
        let factors = |unevenness: f64| -> Vec<f64> {
            let pace = Pace::new(unevenness, &mut Draw::new(4));
            (0..200_000).map(|tick| pace.at(f64::from(tick) * 1e-3)).collect()
        };
        let even = factors(0.3);
        let mean = even.iter().sum::<f64>() / even.len() as f64;
        let sd = (even.iter().map(|factor| (factor - mean) * (factor - mean)).sum::<f64>() / even.len() as f64).sqrt();
        assert!((mean - 1.0).abs() < 0.03 && (sd - 0.3).abs() < 0.03, "{mean} ± {sd}");
        let uneven = factors(1.0);
        assert!(uneven.iter().all(|factor| *factor >= 0.0) && uneven.contains(&0.0), "fits and starts");
    }
}
