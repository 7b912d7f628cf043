//! The first harmonic: the displacement under a push across the axis, as a function of (r, z) times
//! a cosine or a sine of the angle φ.
//!
//! A push along x, at φ = 0, moves the tissue by u_r cos φ, −w sin φ around the axis and q cos φ
//! along the depth (Wilson, "Structural analysis of axisymmetric solids", AIAA J. 3, 1965).
//! Continuity on the axis requires u_r = w. So the unknowns are s = (u_r + w)/2 and t = (u_r −
//! w)/2, and only t and q have to vanish on the axis, independently of each other:
//!
//! ```text
//! u_x = s + t cos 2φ,   u_y = t sin 2φ,   u_z = q cos φ
//! ```

use super::element::{AxialIntegrals, RadialIntegrals};
use crate::ElasticLayer;

/// Fills an element's stiffness per π: rows and columns are its nodes, grouped by columns of nodes,
/// with (s, t, q) at each. From the virtual work of λ tr(ε) tr(δε) + 2μ ε:δε with ε of the
/// displacements above,
///
/// ```text
/// ε_rr = s,r + t,r     ε_φφ = 2t/r     ε_zz = q,z                              (times cos φ)
/// 2ε_rφ = t,r − s,r − 2t/r     2ε_φz = t,z − s,z − q/r     (times sin φ)       2ε_rz = s,z + t,z + q,r (times cos φ)
/// ```
pub(super) fn stiffness(layer: &ElasticLayer, r: &RadialIntegrals, z: &AxialIntegrals, matrix: &mut [f64]) {
    let (lambda, mu) = layer.lame_pa();
    let (n, m) = (r.mass.len().isqrt(), z.mass.len().isqrt());
    let size = 3 * n * m;
    for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
        let (at, back) = (i * n + k, k * n + i);
        let ss_mass = (lambda + 3.0 * mu) * r.slope[at];
        let tt_mass =
            ss_mass + 4.0 * (lambda + 3.0 * mu) * r.hoop[at] + 2.0 * (lambda - mu) * (r.lean[at] + r.lean[back]);
        let (qq_mass, qq_slope) = (mu * (r.hoop[at] + r.slope[at]), (lambda + 2.0 * mu) * r.mass[at]);
        let same_slope = 2.0 * mu * r.mass[at];
        let ts = (lambda + mu) * (r.slope[at] + 2.0 * r.lean[back]);
        let (qs, qs_back) = (lambda * r.mixed[back], mu * (r.mixed[at] + r.plain[at]));
        let (qt, qt_back) = (lambda * (r.mixed[back] + 2.0 * r.plain[at]), mu * (r.mixed[at] - r.plain[at]));
        for (j, l) in (0..m).flat_map(|j| (0..m).map(move |l| (j, l))) {
            let (mass, slope) = (z.mass[j * m + l], z.slope[j * m + l]);
            let (forth, back) = (z.mixed[l * m + j], z.mixed[j * m + l]);
            let (row, column) = (3 * (i * m + j), 3 * (k * m + l));
            let mut put = |row: usize, column: usize, value: f64| matrix[column * size + row] = value;
            put(row, column, ss_mass * mass + same_slope * slope);
            put(row + 1, column + 1, tt_mass * mass + same_slope * slope);
            put(row + 2, column + 2, qq_mass * mass + qq_slope * slope);
            for (upper, lower, value) in
                [(0, 1, ts * mass), (0, 2, qs * forth + qs_back * back), (1, 2, qt * forth + qt_back * back)]
            {
                put(row + lower, column + upper, value);
                put(column + upper, row + lower, value);
            }
        }
    }
}
