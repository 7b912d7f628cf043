//! Poses of a needle from its tip and axis.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Pose of a needle whose tip is at a point and whose axis (hub to tip) is a unit vector, without
/// roll.
///
/// Straight down is exact: the rotation takes z to −z without round-off, so that a perpendicular
/// needle stays on its line.
#[must_use]
pub fn needle_pose(tip_m: &Point3<f64>, axis: &Vector3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(tip_m.coords), rotation_from_z(axis))
}

/// The shortest rotation from z (axes pointing up), or half a turn about x followed by the shortest
/// from −z (pointing down). Either half keeps clear of the direction in which the shortest rotation
/// is not unique.
fn rotation_from_z(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    if axis.z > 0.0 {
        return UnitQuaternion::new_normalize(Quaternion::new(1.0 + axis.z, -axis.y, axis.x, 0.0));
    }
    let from_down = UnitQuaternion::new_normalize(Quaternion::new(1.0 - axis.z, axis.y, -axis.x, 0.0));
    let half_turn = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0));
    from_down * half_turn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_needles_z_points_along_the_axis() {
        for (x, y, z) in [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.3, -0.4, -0.8), (-0.2, 0.5, 0.6)] {
            let axis = Vector3::new(x, y, z).normalize();
            let pose = needle_pose(&Point3::new(0.1, 0.2, 0.3), &axis);
            assert!((pose.rotation * Vector3::z() - axis).norm() < 1e-15, "{axis}");
            assert_eq!(pose.translation.vector, Vector3::new(0.1, 0.2, 0.3));
        }
    }

    #[test]
    fn straight_down_is_exact() {
        let pose = needle_pose(&Point3::origin(), &-Vector3::z());
        assert_eq!(pose.rotation * Vector3::z(), -Vector3::z());
    }
}
