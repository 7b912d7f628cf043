//! Unit responses over the angle of the needle.
//!
//! The tissue does not know how the needle leans: two harmonics are solved once, and the angle only says how much there is of each and where a
//! boundary is met. What comes out is smooth in the cosine of the angle to the normal, so that a polynomial through few angles gives the rest.

use std::f64::consts::PI;

use super::responses::Responses;

/// The flattest needle that the responses follow, in rad from the normal: 60°. One that lies flatter is taken for it, or for one at the
/// angle of the exercise where that is flatter.
pub const FLATTEST_RAD: f64 = PI / 3.0;

/// The responses of a tissue to a needle at any angle.
#[derive(Clone, Debug, PartialEq)]
pub struct AngledResponses {
    /// Cosine of the flattest needle.
    least: f64,
    /// Cosines of the angles at which they are known.
    cosines: Vec<f64>,
    /// The responses at each of them.
    tables: Vec<Responses>,
}

/// Chebyshev's points between the cosine of the flattest needle and 1.
pub(super) fn place_cosines(flattest_rad: f64, count: usize) -> Vec<f64> {
    let least = libm::cos(flattest_rad);
    let (middle, half) = (0.5 * (1.0 + least), 0.5 * (1.0 - least));
    let point = |at: usize| middle + half * libm::cos(PI * (2 * at + 1) as f64 / (2 * count) as f64);
    (0..count).map(point).collect()
}

impl AngledResponses {
    /// Responses that are the same at every angle.
    #[must_use]
    pub fn constant(responses: Responses) -> Self {
        Self { least: 1.0, cosines: vec![1.0], tables: vec![responses] }
    }

    /// Responses known at these cosines, no two of them the same, to a needle no flatter than an angle in rad.
    pub(super) fn new(flattest_rad: f64, cosines: Vec<f64>, tables: Vec<Responses>) -> Self {
        Self { least: libm::cos(flattest_rad), cosines, tables }
    }

    /// The responses to a needle at this cosine of its angle to the normal.
    #[must_use]
    pub fn at(&self, cosine: f64) -> Responses {
        let mut responses = self.tables[0].clone();
        self.write_at(cosine, &mut responses);
        responses
    }

    /// Writes them over others of the same tissue. A cosine beyond those known is taken for the nearest. Never allocates.
    pub fn write_at(&self, cosine: f64, responses: &mut Responses) {
        let cosine = cosine.clamp(self.least, 1.0);
        responses.clear();
        for (at, (own, table)) in self.cosines.iter().zip(&self.tables).enumerate() {
            let others = self.cosines.iter().enumerate().filter(|(other, _)| *other != at);
            let share = others.map(|(_, other)| (cosine - other) / (own - other)).product();
            responses.add(share, table);
        }
    }

    /// Adds others to those of every angle.
    pub(super) fn add(&mut self, others: &Responses) {
        self.tables.iter_mut().for_each(|table| table.add(1.0, others));
    }

    /// Bytes that they hold.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cosines[..]) + self.tables.iter().map(Responses::bytes).sum::<usize>()
    }
}
