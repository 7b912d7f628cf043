//! Physiological tremor: 8–12 Hz, as a sum of a few seeded sinusoids per axis.

use nalgebra::Vector3;

use super::gauss::Draw;
use super::wave::Wave;

/// Number of sinusoids per axis: enough not to repeat within an attempt.
const WAVES: usize = 6;
/// Band of physiological tremor, in Hz.
const BAND_HZ: [f64; 2] = [8.0, 12.0];

/// Involuntary displacement of the tip.
#[derive(Clone, Debug)]
pub(super) struct Tremor {
    waves: [[Wave; WAVES]; 3],
    amplitude_m: f64,
}

impl Tremor {
    /// Tremor whose displacement vector has the given rms, in m.
    pub fn new(rms_m: f64, draw: &mut Draw) -> Self {
        let mut waves = [[Wave::default(); WAVES]; 3];
        waves.as_flattened_mut().fill_with(|| Wave::draw(BAND_HZ, draw));
        // The mean square of a sinusoid is half its squared amplitude, and 3 · WAVES of them add
        // up.
        Self { waves, amplitude_m: rms_m * libm::sqrt(2.0 / (3 * WAVES) as f64) }
    }

    /// Displacement at a time in s, in m.
    pub fn at(&self, t_s: f64) -> Vector3<f64> {
        let sum = |waves: &[Wave; WAVES]| -> f64 { waves.iter().map(|wave| wave.at(t_s)).sum() };
        let [x, y, z] = &self.waves;
        Vector3::new(sum(x), sum(y), sum(z)) * self.amplitude_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rms_is_the_one_asked_for_and_the_band_is_physiological() {
        let tremor = Tremor::new(150e-6, &mut Draw::new(3));
        let ticks = 120_000;
        let square: f64 = (0..ticks).map(|tick| tremor.at(f64::from(tick) * 1e-3).norm_squared()).sum();
        let rms = libm::sqrt(square / f64::from(ticks));
        assert!((rms - 150e-6).abs() < 0.05 * 150e-6, "{rms}");
        let crossings = (1..ticks)
            .filter(|tick| {
                let at = |tick: i32| tremor.at(f64::from(tick) * 1e-3).x;
                at(tick - 1) < 0.0 && at(*tick) >= 0.0
            })
            .count();
        assert!((960..=1440).contains(&crossings), "{crossings} cycles in 120 s");
    }
}
