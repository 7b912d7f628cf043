//! Maps the device's workspace to the patient, and forces back to the device.
//!
//! Device frame: x to the right, y up, z towards the user. Patient frame: z out of the body, x to
//! the right, y away from the user, who stands next to the patient. Lengths are mapped one to one,
//! so that stiffness is rendered unscaled; the clutch extends the workspace.

use nalgebra::{Isometry3, Point3, Quaternion, Unit, UnitQuaternion, Vector3};

use crate::device::{Reading, buttons};

/// Start pose of the needle in an exercise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Home {
    /// Position of the tip, in m, patient frame.
    pub tip_m: Point3<f64>,
    /// Direction of the needle from hub to tip, patient frame.
    pub axis: Unit<Vector3<f64>>,
}

impl Home {
    /// The pose at a distance `approach_m` above the planned entry, both in m, against the planned
    /// direction.
    #[must_use]
    pub fn above(entry_m: Point3<f64>, axis: Unit<Vector3<f64>>, approach_m: f64) -> Self {
        Self { tip_m: entry_m - axis.into_inner() * approach_m, axis }
    }
}

/// How a device stands at the patient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// How far the device is turned to the left, seen from above, in rad: half a turn for a person at the patient's other side.
    pub yaw_rad: f64,
    /// Motion of the needle per motion of the handle, at most 1. Forces are not scaled by it, so that tissue becomes softer.
    pub motion: f64,
}

impl Default for Placement {
    fn default() -> Self {
        Self { yaw_rad: 0.0, motion: 1.0 }
    }
}

/// What turns the needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pointing {
    /// The orientation of the handle.
    Handle,
    /// The home axis, constant. For devices that do not measure orientation.
    Planned,
}

/// The relation between the device frame and the patient frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    rotation: UnitQuaternion<f64>,
    /// A handle position and the tip position that corresponds to it, both in m, patient frame;
    /// `None` until the next reading.
    anchor: Option<(Vector3<f64>, Vector3<f64>)>,
    /// Motion of the needle per motion of the handle.
    motion: f64,
    home: Home,
    pointing: Pointing,
    /// Position of the needle's tip, in m; a clutch keeps it.
    tip_m: Vector3<f64>,
    clutched: bool,
}

/// The pose of a needle, bit for bit as a recording stores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeedlePose {
    /// Tip, in m, patient frame.
    pub position_m: [f64; 3],
    /// patient_from_needle as a unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl NeedlePose {
    /// A recording does not store the sign of a zero: adding 0 clears it before the force law can
    /// see it.
    fn new(tip_m: &Vector3<f64>, rotation: &UnitQuaternion<f64>) -> Self {
        Self { position_m: tip_m.map(|c| c + 0.0).into(), orientation: rotation.coords.map(|c| c + 0.0).into() }
    }

    /// The same pose for the force law. Not normalised again, which would change the last bit.
    #[must_use]
    pub fn isometry(&self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::new_unchecked(Quaternion::from(self.orientation));
        Isometry3::from_parts(Vector3::from(self.position_m).into(), rotation)
    }
}

impl Mapping {
    /// A mapping for a handle in its workspace: the first reading places the needle at `home`.
    #[must_use]
    pub fn at_home(home: Home, pointing: Pointing) -> Self {
        // z of the device (towards the person) is −y of the patient, y of the device (up) is z.
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::FRAC_PI_2);
        Self { rotation, anchor: None, motion: 1.0, home, pointing, tip_m: home.tip_m.coords, clutched: false }
    }

    /// The same for a device that stands otherwise at the patient.
    #[must_use]
    pub fn placed(self, placement: Placement) -> Self {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), placement.yaw_rad);
        Self { rotation: turn * self.rotation, motion: placement.motion, ..self }
    }

    /// The same with a needle that keeps the home axis, whatever the handle's orientation.
    #[must_use]
    pub fn pointing_as_planned(self) -> Self {
        Self { pointing: Pointing::Planned, ..self }
    }

    /// A mapping for a device that uses the patient frame: virtual operators and recorded
    /// trajectories.
    #[must_use]
    pub fn in_patient_frame() -> Self {
        let home = Home { tip_m: Point3::origin(), axis: -Vector3::z_axis() };
        Self {
            rotation: UnitQuaternion::identity(),
            anchor: Some((Vector3::zeros(), Vector3::zeros())),
            motion: 1.0,
            home,
            pointing: Pointing::Handle,
            tip_m: Vector3::zeros(),
            clutched: false,
        }
    }

    /// Returns the pose of the needle for a reading. The clutch freezes the needle outside the body
    /// only: inside, releasing the needle would leave the tissue's force unbalanced.
    pub fn needle(&mut self, reading: &Reading, inside: bool) -> NeedlePose {
        self.clutched = reading.buttons & buttons::CLUTCH != 0 && !inside;
        if self.clutched {
            self.anchor = None;
        }
        let handle_m = self.rotation * reading.position_m;
        let (there_m, tip_m) = *self.anchor.get_or_insert((handle_m, self.tip_m));
        self.tip_m = tip_m + (handle_m - there_m) * self.motion;
        NeedlePose::new(&self.tip_m, &self.patient_from_handle(reading))
    }

    /// Keeps the needle where it is and re-anchors the handle at its next reading.
    pub fn let_go(&mut self) {
        self.anchor = None;
    }

    /// Whether the clutch holds the needle.
    #[must_use]
    pub fn clutched(&self) -> bool {
        self.clutched
    }

    /// Rotates a force from the patient frame to the device frame; same unit.
    #[must_use]
    pub fn device_from_patient(&self, force_n: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.inverse_transform_vector(force_n)
    }

    /// Rotates a force from the device frame to the patient frame; same unit.
    #[must_use]
    pub fn patient_from_device(&self, force_n: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * force_n
    }

    fn patient_from_handle(&self, reading: &Reading) -> UnitQuaternion<f64> {
        match self.pointing {
            Pointing::Handle => UnitQuaternion::new_normalize((self.rotation * reading.orientation).into_inner()),
            Pointing::Planned => law::operator::needle_pose(&Point3::origin(), &self.home.axis).rotation,
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "what is kept must be kept to the bit")]
mod tests {
    //! A needle that starts away from home, jumps at a clutch or is pushed sideways by a straight
    //! force would be felt at once.

    use super::*;

    fn reading(x: f64, y: f64, z: f64, buttons: u32) -> Reading {
        Reading {
            t_s: 0.0,
            position_m: Vector3::new(x, y, z),
            orientation: UnitQuaternion::identity(),
            buttons,
            motor_heat: 0.0,
        }
    }

    fn home() -> Home {
        Home::above(Point3::new(0.01, 0.0, 0.0), -Vector3::z_axis(), 0.02)
    }

    #[test]
    fn turned_device_maps_motion_and_force_through_its_placement() {
        let home = Home::above(Point3::origin(), -Vector3::z_axis(), 0.02);
        let quarter = Placement { yaw_rad: core::f64::consts::FRAC_PI_2, motion: 0.5 };
        let mut mapping = Mapping::at_home(home, Pointing::Planned).placed(quarter);
        mapping.needle(&reading(0.0, 0.0, 0.0, 0), false);
        // To the device's right and down: away from where the person stood before, half as far.
        let moved = mapping.needle(&reading(0.01, -0.02, 0.0, 0), false).position_m;
        for (found, wanted) in moved.into_iter().zip([0.0, 0.005, 0.02 - 0.01]) {
            assert!((found - wanted).abs() < 1e-12, "{moved:?}");
        }
        let force_n = Vector3::new(1.0, 2.0, 3.0);
        let back_n = mapping.patient_from_device(&mapping.device_from_patient(&force_n));
        assert!(
            (back_n - force_n).norm() < 1e-12
                && (mapping.device_from_patient(&Vector3::y()) - Vector3::x()).norm() < 1e-12
        );
    }

    #[test]
    fn the_first_reading_is_home_and_down_is_in() {
        let mut mapping = Mapping::at_home(home(), Pointing::Planned);
        assert_eq!(mapping.needle(&reading(0.03, -0.04, 0.05, 0), false).position_m, [0.01, 0.0, 0.02]);
        let down = mapping.needle(&reading(0.03, -0.07, 0.05, 0), false).position_m;
        assert!((Vector3::from(down) - Vector3::new(0.01, 0.0, -0.01)).norm() < 1e-15, "{down:?}");
        let away = mapping.needle(&reading(0.03, -0.07, 0.04, 0), false).position_m;
        assert!((Vector3::from(away) - Vector3::new(0.01, 0.01, -0.01)).norm() < 1e-15, "{away:?}");
    }

    #[test]
    fn outward_push_lifts_the_handle_and_maps_back_unchanged() {
        let mapping = Mapping::at_home(home(), Pointing::Handle);
        let lifted = mapping.device_from_patient(&Vector3::z());
        assert!((lifted - Vector3::y()).norm() < 1e-15, "{lifted}");
        let force_n = Vector3::new(0.3, -0.2, 1.4);
        let back = mapping.patient_from_device(&mapping.device_from_patient(&force_n));
        assert!((back - force_n).norm() < 1e-15);
    }

    #[test]
    fn a_handle_held_upright_points_the_needle_down() {
        // The handle's z points from its back to its tip: a quarter turn about x brings it from z
        // to −y, downwards.
        let upright = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::FRAC_PI_2);
        let mut mapping = Mapping::at_home(home(), Pointing::Handle);
        let pose = mapping.needle(&Reading { orientation: upright, ..reading(0.0, 0.0, 0.0, 0) }, false);
        assert!((pose.isometry().rotation * Vector3::z() + Vector3::z()).norm() < 1e-15);
    }

    #[test]
    fn the_clutch_holds_the_needle_in_the_air_and_not_in_the_body() {
        let mut mapping = Mapping::at_home(home(), Pointing::Planned);
        let start = mapping.needle(&reading(0.0, 0.0, 0.0, 0), false);
        assert_eq!(mapping.needle(&reading(0.0, 0.05, 0.0, buttons::CLUTCH), false), start);
        assert!(mapping.clutched());
        let after = mapping.needle(&reading(0.0, 0.06, 0.0, 0), false).position_m[2];
        assert!((after - 0.03).abs() < 1e-15, "only what comes after counts: {after}");
        let inside = mapping.needle(&reading(0.0, 0.0, 0.0, buttons::CLUTCH), true);
        assert!((inside.position_m[2] + 0.03).abs() < 1e-15 && !mapping.clutched());
    }

    #[test]
    fn letting_go_keeps_the_needle_where_it_is() {
        let mut mapping = Mapping::at_home(home(), Pointing::Planned);
        let before = mapping.needle(&reading(0.0, 0.0, 0.0, 0), true);
        mapping.let_go();
        assert_eq!(mapping.needle(&reading(0.0, 0.08, 0.03, 0), true), before);
    }

    #[test]
    fn the_patients_frame_is_kept_to_the_bit() {
        let orientation = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
        let mut mapping = Mapping::in_patient_frame();
        let position_m = Vector3::new(0.1 / 3.0, -0.0, -0.012_345);
        let pose = mapping.needle(&Reading { t_s: 0.0, position_m, orientation, buttons: 0, motor_heat: 0.0 }, false);
        assert_eq!(pose.position_m, [0.1 / 3.0, 0.0, -0.012_345]);
        assert!(pose.position_m[1].is_sign_positive(), "a recording keeps no sign of zero");
    }
}
