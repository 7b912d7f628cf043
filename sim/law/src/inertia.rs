//! The contribution of the tissue's mass to the force on a needle: a calculation that is not part
//! of the law, because the contribution is small.
//!
//! A boundary that a needle dents is a small disc on an elastic half-space. Lysmer's analogue of
//! 1966 gives the radiation damping of one that moves at a speed v, and the tissue that moves along
//! has the mass of a dent that falls off like a/r down to the depth d of the supporting structure:
//!
//! ```text
//! F_wave = 3.4 a² √(ρG)/(1 − ν) v,   F_mass = 2πρa²d v̇
//! ```

use core::f64::consts::TAU;

/// Tissue in front of a needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovedTissue {
    /// Radius a of the needle, in m.
    pub radius_m: f64,
    /// Young's modulus, in Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson ratio.
    pub poisson_ratio: f64,
    /// Density ρ, in kg/m³.
    pub density_kg_per_m3: f64,
    /// Depth d of the tissue down to the rigid support, in m.
    pub depth_m: f64,
}

impl MovedTissue {
    /// Radiation damping, in N·s/m.
    #[must_use]
    pub fn wave_drag_n_s_per_m(&self) -> f64 {
        let shear_pa = self.youngs_modulus_pa / (2.0 * (1.0 + self.poisson_ratio));
        let impedance = libm::sqrt(self.density_kg_per_m3 * shear_pa);
        3.4 * self.radius_m * self.radius_m * impedance / (1.0 - self.poisson_ratio)
    }

    /// Mass that moves along, in kg.
    #[must_use]
    pub fn riding_mass_kg(&self) -> f64 {
        TAU * self.density_kg_per_m3 * self.radius_m * self.radius_m * self.depth_m
    }
}
