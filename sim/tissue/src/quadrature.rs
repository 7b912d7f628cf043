//! Quadrature on [−1, 1]: integration points and nodes of the elements.

use std::f64::consts::PI;

/// Newton iterations for a root: from the cosines, the fifth is the last to change anything.
const NEWTON: usize = 6;

/// Legendre polynomial of a degree and its slope at x, |x| < 1, by Bonnet's recursion.
fn legendre(degree: usize, x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for n in 1..degree {
        let n = n as f64;
        (before, value) = (value, ((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0));
    }
    [value, degree as f64 * (before - x * value) / (1.0 - x * x)]
}

/// Points and weights of Gauss–Legendre quadrature, ascending.
#[must_use]
pub fn gauss_rule(count: usize) -> Vec<(f64, f64)> {
    let point = |at: usize| {
        let mut x = -libm::cos(PI * (at as f64 + 0.75) / (count as f64 + 0.5));
        for _ in 0..NEWTON {
            let [value, slope] = legendre(count, x);
            x -= value / slope;
        }
        let [_, slope] = legendre(count, x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(point).collect()
}

/// Points and weights of Gauss–Lobatto quadrature, ascending: ±1 and the extrema of the Legendre
/// polynomial of an order, 1 or more. They are the nodes of an element of this order, which keeps
/// high orders well conditioned.
#[must_use]
pub fn lobatto_rule(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    let end = 2.0 / (n * (n + 1.0));
    let inside = |at: usize| {
        let mut x = -libm::cos(PI * at as f64 / n);
        for _ in 0..NEWTON {
            let [value, slope] = legendre(order, x);
            // Legendre's equation gives the second derivative: (1 − x²) P″ = 2x P′ − n(n + 1) P.
            let bend = (2.0 * x * slope - n * (n + 1.0) * value) / (1.0 - x * x);
            x -= slope / bend;
        }
        let [value, _] = legendre(order, x);
        (x, end / (value * value))
    };
    let ends = [(-1.0, end), (1.0, end)];
    ends[..1].iter().copied().chain((1..order).map(inside)).chain(ends[1..].iter().copied()).collect()
}
