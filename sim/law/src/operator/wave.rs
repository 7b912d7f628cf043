//! A seeded sinusoid, the component of tremor and of an uneven pace.

use core::f64::consts::TAU;

use super::gauss::Draw;

/// A sinusoid of amplitude 1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wave {
    angular_rad_per_s: f64,
    phase_rad: f64,
}

impl Wave {
    /// A frequency within a band, in Hz, and a phase.
    pub fn draw([low_hz, high_hz]: [f64; 2], draw: &mut Draw) -> Self {
        let angular_rad_per_s = TAU * (low_hz + (high_hz - low_hz) * draw.uniform());
        Self { angular_rad_per_s, phase_rad: TAU * draw.uniform() }
    }

    /// Its value at a time in s.
    pub fn at(&self, t_s: f64) -> f64 {
        libm::sin(self.angular_rad_per_s * t_s + self.phase_rad)
    }
}
