//! A Maxwell element: a spring K in series with a dashpot of time τ. Over a tick its end moves
//! linearly in time, so that with Δ = Δt/τ and u = 1 − e^(−Δ)
//!
//! ```text
//! q ← q e^(−Δ) + K Δx u/Δ
//! stored  q²/(2 K)
//! lost    ∫ q²/(K τ) dt = (1/K) (q₀² (u − u²/2) + q₀ a u²/Δ + a² (Δ − u − u²/2)/Δ²),   a = K Δx
//! ```
//!
//! exact for any tick.

/// A tick of the element: the displacement of its end in m, and the time in units of τ.
pub(super) struct Stretch {
    pub way_m: f64,
    pub delta: f64,
}

impl Stretch {
    /// Advances the force q of an element to the end of the tick. Returns the loss of its dashpot,
    /// in J, never negative.
    pub fn relax(&self, q: &mut f64, stiffness_n_per_m: f64) -> f64 {
        let Self { way_m, delta } = *self;
        let a = stiffness_n_per_m * way_m;
        if delta <= 0.0 {
            *q += a;
            return 0.0;
        }
        let u = -libm::expm1(-delta);
        let before = *q;
        *q = before * (1.0 - u) + a * (u / delta);
        let squared = before * before * (u - 0.5 * u * u) + before * a * (u * u / delta) + a * a * ramp_loss(u, delta);
        (squared / stiffness_n_per_m).max(0.0)
    }
}

/// (Δ − u − u²/2)/Δ². Since Δ = −ln(1 − u) = u + u²/2 + u³/3 + …, only higher powers of u remain
/// for a short tick.
fn ramp_loss(u: f64, delta: f64) -> f64 {
    /// Bound of u below which the series is exact to round-off with the summed terms.
    const SHORT: f64 = 0.03;
    if u >= SHORT {
        return (delta - u - 0.5 * u * u) / (delta * delta);
    }
    // Horner's scheme of Σ u^n/(n + 3), n = 0 … 9.
    let sum = (3..=12).rev().fold(0.0, |sum, n| sum * u + 1.0 / f64::from(n));
    u * u * u * sum / (delta * delta)
}
