//! The pull of a spring.
//!
//! A spring of constant k, rest vector e and rest length l₀ whose ends moved apart by Δ has the
//! vector D = e + Δ and stretches by
//!
//! ```text
//! l − l₀ = q / (l + l₀),   q = l² − l₀² = Δ·(e + D),   l² = l₀² + q
//! ```
//!
//! so that a stretch of 1e-9 of the length is as accurate as a large one: the difference of two
//! lengths would cancel. The pull k (l − l₀) D/l is along the current direction of the spring: a
//! rigid motion costs no energy.

use super::kernel::Law;
use super::lanes::Lanes;
use super::links::Link;

/// Length relative to the rest length below which the pull is k (1 − l₀/l) D with the l of this
/// length, so that the stiffness stays within ±k in every direction. The law of longer springs
/// would reach −∞ at l = 0, where a spring turns inside out, and no step would be short enough
/// there.
const SHORTEST: f64 = 0.5;

/// The smallest change of the squared length of a spring that counts, relative to its square at
/// rest.
const MOST_SHORTENED: f64 = SHORTEST * SHORTEST - 1.0;

/// The current state of a spring.
struct Stretched<T> {
    /// From A to B, in m.
    along_m: [T; 3],
    /// Length, in m, at least [`SHORTEST`] times that at rest.
    length_m: T,
    /// (l − l₀)/l: the pull per vector, divided by k.
    strain: T,
}

#[inline(always)]
fn stretched<T: Lanes>(link: &Link<T>, change_m: [T; 3]) -> Stretched<T> {
    let ([ex, ey, ez], [ux, uy, uz]) = (link.rest_m, change_m);
    let along_m = [ex + ux, ey + uy, ez + uz];
    let rest_m2 = link.length_m * link.length_m;
    let grown_m2 = dot(change_m, [ex + along_m[0], ey + along_m[1], ez + along_m[2]]);
    let grown_m2 = grown_m2.at_least(T::splat(MOST_SHORTENED) * rest_m2);
    let length_m = (rest_m2 + grown_m2).sqrt();
    Stretched { along_m, length_m, strain: grown_m2 / (length_m * (length_m + link.length_m)) }
}

#[inline(always)]
fn dot<T: Lanes>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn times<T: Lanes>(factor: T, vector: [T; 3]) -> [T; 3] {
    [factor * vector[0], factor * vector[1], factor * vector[2]]
}

/// Pull of displaced ends. Field: displacement.
pub(super) struct Elastic;

impl<T: Lanes> Law<T, 1> for Elastic {
    #[inline(always)]
    fn pull(&self, link: &Link<T>, constant: T, [change_m]: [[T; 3]; 1]) -> [T; 3] {
        let spring = stretched(link, change_m);
        times(constant * spring.strain, spring.along_m)
    }
}

/// The same with a dashpot in every spring, β k along it. Fields: displacement, velocity.
pub(super) struct Damped {
    /// β, in s.
    pub(super) stiffness_damping_s: f64,
}

impl<T: Lanes> Law<T, 2> for Damped {
    #[inline(always)]
    fn pull(&self, link: &Link<T>, constant: T, [change_m, rate_m_per_s]: [[T; 3]; 2]) -> [T; 3] {
        let spring = stretched(link, change_m);
        let rate = dot(spring.along_m, rate_m_per_s) / (spring.length_m * spring.length_m);
        times(constant * (spring.strain + T::splat(self.stiffness_damping_s) * rate), spring.along_m)
    }
}

/// Resistance to a change of displacement, without the part of a compressed spring that pushes it
/// further aside: the remainder is positive semidefinite, so that a step computed with it decreases
/// the energy. Fields: displacement, its change.
pub(super) struct Stiffness {
    /// Factor on the part along the spring: 1, or more if a dashpot adds to it.
    pub(super) along: f64,
    /// Factor on the part across it.
    pub(super) across: f64,
}

impl<T: Lanes> Law<T, 2> for Stiffness {
    #[inline(always)]
    fn pull(&self, link: &Link<T>, constant: T, [change_m, delta]: [[T; 3]; 2]) -> [T; 3] {
        let spring = stretched(link, change_m);
        let across = T::splat(-self.across) * constant * spring.strain.at_least(T::splat(0.0));
        let part = dot(spring.along_m, delta) / (spring.length_m * spring.length_m);
        let [x, y, z] = times((T::splat(-self.along) * constant - across) * part, spring.along_m);
        [x + across * delta[0], y + across * delta[1], z + across * delta[2]]
    }
}

/// Resistance to a change of displacement at rest. Field: change of displacement.
pub(super) struct Linear;

impl<T: Lanes> Law<T, 1> for Linear {
    #[inline(always)]
    fn pull(&self, link: &Link<T>, constant: T, [delta]: [[T; 3]; 1]) -> [T; 3] {
        let per_m2 = T::splat(-1.0) / (link.length_m * link.length_m);
        times(per_m2 * (constant * dot(link.rest_m, delta)), link.rest_m)
    }
}

/// Energy of a spring, in J.
pub(super) fn energy_j(link: &Link<f64>, constant: f64, change_m: [f64; 3]) -> f64 {
    let rest_m2 = link.length_m * link.length_m;
    let axes = link.rest_m.iter().zip(change_m);
    let grown_m2: f64 = axes.map(|(rest_m, change_m)| change_m * (2.0 * rest_m + change_m)).sum();
    let counted_m2 = grown_m2.max(MOST_SHORTENED * rest_m2);
    let length_m = (rest_m2 + counted_m2).sqrt();
    let stretch_m = counted_m2 / (length_m + link.length_m);
    0.5 * constant * (stretch_m * stretch_m + stretch_m / length_m * (grown_m2 - counted_m2))
}
