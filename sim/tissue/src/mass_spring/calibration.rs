//! Spring constants of a box cell from its Young's modulus.
//!
//! A cell a × b × c has springs along its edges and the diagonals of its faces. Under a uniform
//! strain ε a spring with vector e and length l stretches by eᵀεe/l, so the energy stored in the
//! cell per volume V = abc is
//!
//! ```text
//! U/V = ½ εᵢⱼ Cᵢⱼₖₗ εₖₗ,   Cᵢⱼₖₗ = (1/V) Σ k eᵢ eⱼ eₖ eₗ / l²
//! ```
//!
//! (Born and Huang 1954, §11). C does not change when its indices are permuted, so C1122 = C1212:
//! an isotropic lattice has λ = μ, that is a Poisson ratio of 1/4, and then C1111 = 3μ and C1122 =
//! μ = E / (2 (1 + ¼)) = 0.4 E.
//!
//! Shared between neighbours, a cell has one edge along each axis and two diagonals across each
//! face. Only the diagonals across xy have both e₁ and e₂, so two of constant k_xy give
//!
//! ```text
//! C1122 = 2 k_xy a² b² / ((a² + b²) abc) = μ     k_xy = μ c (a² + b²) / (2ab)
//! ```
//!
//! and those across xy and xz, which together give C1111 a share μ (a²/b² + a²/c²), leave the edge
//!
//! ```text
//! C1111 = k_x a² / abc + μ (a²/b² + a²/c²) = 3μ  k_x = μ (bc/a) (3 − a²/b² − a²/c²)
//! ```
//!
//! A cube of side h has k = μh = 0.4 E h for all of them. No spring constant may be negative, so a
//! cell must stay near a cube.

use super::links::{CLASSES, Class};

/// Shear modulus of the lattice over Young's modulus: 1 / (2 (1 + ν)) at ν = 1/4.
pub(super) const SHEAR_PER_YOUNG: f64 = 0.4;

/// Minimum and maximum ratio of height to width of a cell at which all constants are at least 0: 3
/// − 1 − a²/c² ≥ 0 and 3 − 2c²/a² ≥ 0.
pub(super) const HEIGHT_PER_WIDTH: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2, 1.224_744_871_391_589];

/// Constant of the springs of each class, in N/m, of a cell with these sides, in m, including the
/// shares of all neighbours.
pub(super) fn spring_constants(youngs_modulus_pa: f64, sides_m: [f64; 3]) -> [f64; CLASSES.len()] {
    let shear_pa = SHEAR_PER_YOUNG * youngs_modulus_pa;
    CLASSES.map(|class| shear_pa * size_m(class, sides_m))
}

/// A spring constant divided by the shear modulus, in m.
fn size_m(class: Class, sides_m: [f64; 3]) -> f64 {
    let (along, others) = class.axes();
    match *along {
        [axis] => {
            let a = sides_m[axis];
            let [b, c] = [sides_m[others[0]], sides_m[others[1]]];
            // At the maximum or minimum height the constant is 0 to rounding.
            (b * c / a * (3.0 - a * a / (b * b) - a * a / (c * c))).max(0.0)
        }
        [first, second] => {
            let [a, b, c] = [sides_m[first], sides_m[second], sides_m[others[0]]];
            c * (a * a + b * b) / (2.0 * a * b)
        }
        _ => 0.0,
    }
}
