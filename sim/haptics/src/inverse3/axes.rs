//! Conversion between the service's axes (x right, y forward, z up, origin at the foot of the arm)
//! and ours.

use nalgebra::{UnitQuaternion, Vector3};

/// Approximate middle of the workspace, in m, in the service's axes: in front of the arm, at the
/// height of its elbow. Our choice; exercises set their home pose in the mapping.
const MIDDLE_M: [f64; 3] = [0.0, -0.15, 0.15];

/// Converts a position, in m.
pub fn position_m(service_m: Vector3<f64>) -> Vector3<f64> {
    vector(service_m - Vector3::from(MIDDLE_M))
}

/// Converts a direction or a force: forward is away from the user, so the sign of our z is
/// opposite.
fn vector(service: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(service.x, service.z, -service.y)
}

/// Converts a force, in N, from our axes to the service's.
pub fn force_n(ours_n: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(ours_n.x, -ours_n.z, ours_n.y)
}

/// Converts a force, in N, from the service's axes to ours.
pub fn our_force_n(service_n: Vector3<f64>) -> Vector3<f64> {
    vector(service_n)
}

/// device_from_handle, from the orientation of the grip in the service's axes. An unrotated grip is
/// assumed to point forward, along its own y; our handle points along its z. Both differ by the
/// same quarter turn about x.
pub fn orientation(service_from_grip: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
    quarter * service_from_grip * quarter
}
