//! Limits the rise of the force per tick, never its fall: a fall is a pop, and a late pop is not
//! felt.

use nalgebra::Vector3;

/// Returns the force nearest to `wanted_n` that is reachable from `last_n` within a rise of
/// `max_rise_n`, all in N, and whether it was changed.
///
/// Any change towards zero is allowed. So only the component of the last force along the wanted one
/// counts, and a force that reverses falls at once and rises slowly.
#[must_use]
pub fn limit(last_n: &Vector3<f64>, wanted_n: &Vector3<f64>, max_rise_n: f64) -> (Vector3<f64>, bool) {
    let norm_n = wanted_n.norm();
    if norm_n <= max_rise_n {
        return (*wanted_n, false);
    }
    let direction = wanted_n / norm_n;
    let allowed_n = last_n.dot(&direction).max(0.0) + max_rise_n;
    if norm_n <= allowed_n { (*wanted_n, false) } else { (direction * allowed_n, true) }
}

#[cfg(test)]
mod tests {
    //! A limit that also slowed the fall would swallow the pops; one that ignored direction would
    //! let a force flip.

    use super::*;

    fn along_x(x: f64) -> Vector3<f64> {
        Vector3::new(x, 0.0, 0.0)
    }

    #[test]
    fn a_fall_is_whole_and_a_rise_is_bounded() {
        assert_eq!(limit(&along_x(3.0), &along_x(0.5), 0.1), (along_x(0.5), false));
        assert_eq!(limit(&along_x(3.0), &Vector3::zeros(), 0.1), (Vector3::zeros(), false));
        let (risen_n, limited) = limit(&along_x(1.0), &along_x(3.0), 0.1);
        assert!((risen_n - along_x(1.1)).norm() < 1e-12 && limited);
        assert_eq!(limit(&along_x(1.0), &along_x(1.05), 0.1), (along_x(1.05), false));
    }

    #[test]
    fn a_force_that_turns_round_falls_at_once_and_rises_slowly() {
        let (turned_n, limited) = limit(&along_x(3.0), &along_x(-3.0), 0.1);
        assert!((turned_n - along_x(-0.1)).norm() < 1e-12 && limited);
    }

    #[test]
    fn it_gets_there() {
        let mut force_n = Vector3::zeros();
        let ticks = (1..1000).find(|_| {
            force_n = limit(&force_n, &Vector3::new(1.0, 2.0, 2.0), 0.1).0;
            (force_n - Vector3::new(1.0, 2.0, 2.0)).norm() < 1e-12
        });
        assert_eq!(ticks, Some(30));
    }
}
