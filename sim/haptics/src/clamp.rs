//! Clamps the norm of a force and keeps its direction. Clamping each axis would turn the force.

use nalgebra::Vector3;

/// Returns `force_n` scaled to a norm of at most `max_n`, both in N, and whether it was changed. A
/// force that is not finite becomes zero.
#[must_use]
pub fn norm(force_n: &Vector3<f64>, max_n: f64) -> (Vector3<f64>, bool) {
    // Large components would overflow when squared, so divide by the largest one first.
    let largest_n = force_n.amax();
    if !largest_n.is_finite() || force_n.iter().any(|part| part.is_nan()) {
        return (Vector3::zeros(), true);
    }
    if largest_n == 0.0 {
        return (*force_n, false);
    }
    let scaled = force_n / largest_n;
    let norm_n = scaled.norm() * largest_n;
    if norm_n <= max_n { (*force_n, false) } else { (scaled * (max_n / scaled.norm()), true) }
}

#[cfg(test)]
mod tests {
    //! A clamp that turns the force, or drops it above the limit, would be felt exactly at hard
    //! contact.

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_norm_is_bounded_and_the_direction_kept(
            parts in prop::array::uniform3(prop_oneof![-10.0..10.0, -1e300..1e300_f64]),
            max_n in 0.1..50.0_f64,
        ) {
            let force_n = Vector3::from(parts);
            let (clamped_n, changed) = norm(&force_n, max_n);
            prop_assert!(clamped_n.norm() <= max_n * (1.0 + 1e-12));
            prop_assert!(force_n == Vector3::zeros() || clamped_n.norm() > 0.0, "it does not let go");
            let unit = |v: &Vector3<f64>| (v / v.amax()).normalize();
            if force_n != Vector3::zeros() {
                prop_assert!((unit(&force_n) - unit(&clamped_n)).norm() < 1e-9, "the direction is kept");
            }
            prop_assert_eq!(changed, clamped_n != force_n);
        }
    }

    #[test]
    fn what_is_no_number_is_no_force() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(norm(&Vector3::new(1.0, bad, 0.0), 3.3), (Vector3::zeros(), true));
        }
    }
}
