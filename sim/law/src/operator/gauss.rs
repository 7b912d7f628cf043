//! Seeded random draws, with an own Gaussian over the generator's raw bits, so that no library
//! update can change recorded attempts.

use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// Clamp of the normal draws, in standard deviations: a hand is clumsy, not absurd.
const CUT_SD: f64 = 3.0;

/// Seeded draws for virtual hands and measurements.
#[derive(Clone, Debug)]
pub struct Draw {
    bits: Pcg64,
}

impl Draw {
    /// Starts the sequence of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { bits: Pcg64::seed_from_u64(seed) }
    }

    /// Starts another sequence, which depends on this one.
    pub(super) fn branch(&mut self) -> Self {
        Self::new(self.bits.next_u64())
    }

    /// Uniform in (0, 1], from the top 53 bits.
    pub fn uniform(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1_u64 << 53) as f64;
        ((self.bits.next_u64() >> 11) + 1) as f64 * SCALE
    }

    /// Normal with mean 0, clamped to three standard deviations (Box and Muller 1958).
    pub fn normal(&mut self, sd: f64) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
        let angle = core::f64::consts::TAU * self.uniform();
        (radius * libm::cos(angle)).clamp(-CUT_SD, CUT_SD) * sd
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_draws_have_the_mean_and_deviation_asked_for() {
        let mut draw = Draw::new(7);
        let draws: Vec<f64> = (0..20_000).map(|_| draw.normal(2.0)).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.05, "{mean}");
        assert!((variance.sqrt() - 2.0).abs() < 0.05, "{variance}");
        assert!(draws.iter().all(|value| value.abs() <= 6.0));
    }
}
