//! A needle that bends: an Euler–Bernoulli beam on the layers' Winkler foundation.
//!
//! The hand holds the hub at an offset δ from the latched axis and parallel to it: a device renders
//! no torque, and the axis is latched. From the hub to the skin the needle is free; inside, the
//! tissue presses back with k per metre:
//!
//! ```text
//! EI w'''' = 0          over the free length h        w = δ, w' = 0 at the hub
//! EI w'''' + k w = 0    over the inserted length s     w'' = w''' = 0 at the tip
//! ```
//!
//! The problem is linear and uniform, so it has a closed form: two beams joined at the skin. It is
//! exact at the cost of a few exponentials, where finite elements would need several tens of
//! unknowns a tick for the same number. Bending is small (the inserted length is that of the
//! straight needle) and the axial force does not buckle it.
//!
//! As EI → ∞ it becomes the rigid law, F⊥ = k s δ, with the tip at the hand's line.

mod end;

use end::End;

use crate::axial::{Domain, ParamError};

/// Below this 2βs the needle is rigid to round-off; smaller numbers would underflow when
/// multiplied.
const RIGID: f64 = 1e-9;

/// A checked bending needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    foundation_n_per_m2: f64,
    length_m: f64,
    /// β = (k/4EI)^¼, in 1/m.
    beta_per_m: f64,
}

/// Response of the bent needle per metre of the hand's offset from the latched axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Lateral force on the hand per metre of offset, in N/m.
    pub stiffness_n_per_m: f64,
    /// Displacement of the tip relative to the hand's offset: 1 for a rigid needle.
    pub tip_share: f64,
}

impl Bend {
    /// A rigid needle inserted by a length, in m, into a foundation, in N/m².
    #[must_use]
    pub fn rigid(foundation_n_per_m2: f64, inserted_m: f64) -> Self {
        Self { stiffness_n_per_m: foundation_n_per_m2 * inserted_m, tip_share: 1.0 }
    }
}

/// Bending stiffness EI of a round tube, in N·m², from its Young's modulus, in Pa, and its
/// diameters, in m.
#[must_use]
pub fn tube_n_m2(youngs_modulus_pa: f64, outer_m: f64, inner_m: f64) -> f64 {
    let fourth = |diameter_m: f64| diameter_m * diameter_m * diameter_m * diameter_m;
    youngs_modulus_pa * std::f64::consts::PI / 64.0 * (fourth(outer_m) - fourth(inner_m))
}

impl Beam {
    /// A needle with a bending stiffness EI, in N·m², and a length from tip to hub, in m, on a
    /// foundation, in N/m².
    ///
    /// # Errors
    /// The first number that is not finite or out of range.
    pub fn new(bending_n_m2: f64, length_m: f64, foundation_n_per_m2: f64) -> Result<Self, ParamError> {
        Domain::Positive.check("needle_bending_n_m2", bending_n_m2, "N·m²")?;
        Domain::Positive.check("needle_length_m", length_m, "m")?;
        Domain::NotNegative.check("lateral_stiffness_n_per_m2", foundation_n_per_m2, "N/m²")?;
        let beta_per_m = (foundation_n_per_m2 / (4.0 * bending_n_m2)).sqrt().sqrt();
        Ok(Self { foundation_n_per_m2, length_m, beta_per_m })
    }

    /// β = (k/4EI)^¼, in 1/m: the needle bends over lengths of 1/β.
    #[must_use]
    pub fn beta_per_m(&self) -> f64 {
        self.beta_per_m
    }

    /// Response when inserted by a length, in m. Never fails: without insertion the stiffness is 0.
    ///
    /// In units of β and k, with A to G of the inserted part's end and η = βh, the joint's
    /// compliance times A is `c11 = 2B + 4Aη³/3`, `c12 = 2Aη² − 2C`, `c22 = 4D + 4Aη` (the
    /// cantilever's h³/3EI, h²/2EI and h/EI, with EI = k/4β⁴). The hub does not rotate, which gives
    /// the moment at the skin, M/V = −c12/c22, and with it force and tip.
    #[must_use]
    pub fn bend(&self, inserted_m: f64) -> Bend {
        let twice = 2.0 * self.beta_per_m * inserted_m;
        if !(twice >= RIGID && twice.is_finite()) {
            return Bend::rigid(self.foundation_n_per_m2, if inserted_m > 0.0 { inserted_m } else { 0.0 });
        }
        let End { a, b, c, d, e, g } = End::new(twice);
        let eta = self.beta_per_m * (self.length_m - inserted_m).max(0.0);
        let c11 = 2.0 * b + 4.0 / 3.0 * a * eta * eta * eta;
        let c12 = 2.0 * a * eta * eta - 2.0 * c;
        let c22 = 4.0 * d + 4.0 * a * eta;
        let determinant = c11 * c22 - c12 * c12;
        Bend {
            stiffness_n_per_m: self.foundation_n_per_m2 / self.beta_per_m * (a * c22 / determinant),
            tip_share: (2.0 * e * c22 - 4.0 * g * c12) / determinant,
        }
    }

    /// Deflection and slope at the loaded end, and deflection at the far end, of a beam with two
    /// free ends on the foundation over a length, in m, under a unit force at one end: in m/N, 1/N
    /// and m/N. All 0 without a foundation.
    ///
    /// Hetényi, "Beams on Elastic Foundation" (1946), section 13; as the length grows, w = 2β/k and
    /// w' = −2β²/k (section 9).
    #[must_use]
    pub fn end_loaded(&self, length_m: f64) -> [f64; 3] {
        let twice = 2.0 * self.beta_per_m * length_m;
        if !(twice >= RIGID && twice.is_finite()) {
            return [0.0; 3];
        }
        let End { a, b, c, e, .. } = End::new(twice);
        let unit = 2.0 * self.beta_per_m / self.foundation_n_per_m2;
        [unit * b / a, -unit * self.beta_per_m * c / a, unit * e / a]
    }
}
