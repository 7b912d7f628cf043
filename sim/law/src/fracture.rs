//! The force at which a sharp tip advances through soft tissue, from the fracture energy of the
//! tissue.
//!
//! The balance is that of Shergold and Fleck (2004) for a sharp punch: it opens a slit of length 2a
//! ahead of itself and forces the slit open around its shaft of radius R. Per length of advance
//!
//! ```text
//! P = 2a J + S(a)
//! ```
//!
//! with the fracture energy J of the slit's faces and the energy S stored in the tissue around the
//! shaft. The slit is replaced by a round hole with the same rim, 4a = 2πA, in an incompressible
//! neo-Hookean solid of shear modulus μ that the shaft opens from A to R in plane strain, for which
//!
//! ```text
//! S = πμ (R² − A²) ln(R/A)
//! ```
//!
//! The slit minimises the energy. With s = A/R and j = J/(μR):
//!
//! ```text
//! j = 1/s − s − 2 s ln s,   P = πμR² (j s + (1 − s²) ln(1/s))
//! ```
//!
//! Not included: friction on the shaft (the law has it separately), bending and yielding of the
//! faces, strengthening under stretch (an Ogden solid of a higher exponent, such as skin, requires
//! more), and the initiation of a crack. A blunt tip tears a ring and is not covered.

use core::f64::consts::PI;

/// A sharp tip in soft tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpPunch {
    /// Radius R of the shaft, in m.
    pub radius_m: f64,
    /// Shear modulus μ of the tissue, in Pa.
    pub shear_modulus_pa: f64,
    /// Fracture energy J of the tissue, in J/m².
    pub fracture_energy_j_per_m2: f64,
}

/// Number of halvings that reduce the slit's length to round-off.
const HALVINGS: u32 = 64;

impl SharpPunch {
    /// The smallest force that supplies the energy of slit and opening, in N. All numbers must be
    /// above 0.
    #[must_use]
    pub fn threshold_n(&self) -> f64 {
        let Self { radius_m, shear_modulus_pa, fracture_energy_j_per_m2 } = *self;
        let j = fracture_energy_j_per_m2 / (shear_modulus_pa * radius_m);
        let s = slit_share(j);
        PI * shear_modulus_pa * radius_m * radius_m * (j * s - (1.0 - s * s) * libm::log(s))
    }
}

/// s = A/R where j = 1/s − s − 2 s ln s. The right side falls from ∞ to 0 as s goes from 0 to 1,
/// and is above j at 1/(1 + j).
fn slit_share(j: f64) -> f64 {
    let (mut low, mut high) = (1.0 / (1.0 + j), 1.0);
    for _ in 0..HALVINGS {
        let s = 0.5 * (low + high);
        if 1.0 / s - s - 2.0 * s * libm::log(s) > j {
            low = s;
        } else {
            high = s;
        }
    }
    0.5 * (low + high)
}
