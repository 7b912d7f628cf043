//! Unit responses over the angle of the needle.
//!
//! The tissue is independent of the needle's inclination: two harmonics are solved once, and the
//! angle only determines their proportions and where a boundary is met. The result is smooth in the
//! cosine of the angle to the normal, so that a polynomial through a few angles interpolates it.

use std::f64::consts::PI;

use super::responses::Responses;

/// The flattest needle that the responses follow, in rad from the normal: 60°. A flatter needle is
/// treated as this one, or as one at the angle of the exercise if that is flatter.
pub const FLATTEST_RAD: f64 = PI / 3.0;

/// The responses of a tissue to a needle at any angle.
#[derive(Clone, Debug, PartialEq)]
pub struct AngledResponses {
    /// Cosine of the flattest needle.
    least: f64,
    /// Cosines of the known angles.
    cosines: Vec<f64>,
    /// The responses at each of them.
    tables: Vec<Responses>,
}

/// Chebyshev points between the cosine of the flattest needle and 1.
pub(super) fn place_cosines(flattest_rad: f64, count: usize) -> Vec<f64> {
    let least = libm::cos(flattest_rad);
    let (middle, half) = (0.5 * (1.0 + least), 0.5 * (1.0 - least));
    let point = |at: usize| middle + half * libm::cos(PI * (2 * at + 1) as f64 / (2 * count) as f64);
    (0..count).map(point).collect()
}

impl AngledResponses {
    /// Responses independent of the angle.
    #[must_use]
    pub fn constant(responses: Responses) -> Self {
        Self { least: 1.0, cosines: vec![1.0], tables: vec![responses] }
    }

    /// Responses at distinct cosines, for needles no flatter than an angle in rad.
    pub(super) fn new(flattest_rad: f64, cosines: Vec<f64>, tables: Vec<Responses>) -> Self {
        Self { least: libm::cos(flattest_rad), cosines, tables }
    }

    /// The responses at a cosine of the needle's angle to the normal.
    #[must_use]
    pub fn at(&self, cosine: f64) -> Responses {
        let mut responses = self.tables[0].clone();
        self.write_at(cosine, &mut responses);
        responses
    }

    /// Writes the responses over others of the same tissue. A cosine outside the known range is
    /// clamped. Never allocates.
    pub fn write_at(&self, cosine: f64, responses: &mut Responses) {
        let cosine = cosine.clamp(self.least, 1.0);
        responses.clear();
        for (at, (own, table)) in self.cosines.iter().zip(&self.tables).enumerate() {
            let others = self.cosines.iter().enumerate().filter(|(other, _)| *other != at);
            let share = others.map(|(_, other)| (cosine - other) / (own - other)).product();
            responses.add(share, table);
        }
    }

    /// Adds other responses at every angle.
    pub(super) fn add(&mut self, others: &Responses) {
        self.tables.iter_mut().for_each(|table| table.add(1.0, others));
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cosines[..]) + self.tables.iter().map(Responses::bytes).sum::<usize>()
    }
}
