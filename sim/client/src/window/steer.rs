//! Converts mouse and keyboard input to a set-point of the needle: depth, lateral position and
//! tilt.

use documents::ExerciseBundle;
use haptics::devices::hand::Aim;
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};

use crate::live::open::handle_along;

/// The steering input of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteeringWish {
    /// Advance along the needle, in m; positive is further in.
    pub advance_m: f64,
    /// Motion to the right and away from the user, in m.
    pub aside_m: [f64; 2],
    /// Tilt of the tip to the right and away from the user, in rad.
    pub lean_rad: [f64; 2],
    /// Number of confirmations of the position.
    pub confirmed: u32,
}

impl SteeringWish {
    /// Returns the same motion, scaled by a factor.
    pub fn at_speed(self, factor: f64) -> Self {
        Self {
            advance_m: self.advance_m * factor,
            aside_m: self.aside_m.map(|way_m| way_m * factor),
            lean_rad: self.lean_rad.map(|angle_rad| angle_rad * factor),
            ..self
        }
    }
}

/// Maximum tilt of the needle from straight down, in rad.
const MOST_LEAN_RAD: f64 = 1.2;
/// Maximum distance of the set-point beyond the end of the shaft, in m: the hub would be pushed
/// into the skin.
const BEYOND_SHAFT_M: f64 = 0.002;

/// The set-point of a virtual hand. Device frame: x to the right, y up, z towards the user.
#[derive(Clone, Debug)]
pub struct Steering {
    axis: Unit<Vector3<f64>>,
    /// Offset from the start, in m, patient frame.
    away_m: Vector3<f64>,
    confirmed: u32,
    /// Maximum offset from the start, in m.
    most_away_m: f64,
}

impl Steering {
    /// Starts where the exercise's plan does, tilted as planned; the set-point stays within reach
    /// of its needle.
    pub fn new(bundle: &ExerciseBundle) -> Self {
        let shaft_m = bundle.scene.needle.length_mm * 1e-3;
        let most_away_m = bundle.exercise.plan().approach_m + shaft_m + BEYOND_SHAFT_M;
        Self::straight(Unit::new_normalize(bundle.exercise.axis()), most_away_m)
    }

    /// Starts with the needle along an axis; the set-point stays within a distance from there, in
    /// m.
    pub fn straight(axis: Unit<Vector3<f64>>, most_away_m: f64) -> Self {
        Self { axis, away_m: Vector3::zeros(), confirmed: 0, most_away_m }
    }

    /// Applies the input of a frame; returns the new target of the hand. Advancing moves along the
    /// needle.
    pub fn follow(&mut self, wish: &SteeringWish) -> Aim {
        self.lean(wish.lean_rad);
        self.confirmed += wish.confirmed;
        let step_m = self.axis.into_inner() * wish.advance_m + Vector3::new(wish.aside_m[0], wish.aside_m[1], 0.0);
        let away_m = self.away_m + step_m;
        if away_m.norm() <= self.most_away_m {
            self.away_m = away_m;
        }
        let device_from_patient = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        Aim {
            position_m: device_from_patient * self.away_m,
            orientation: handle_along(&self.axis),
            buttons: 0,
            confirmed: self.confirmed,
        }
    }

    fn lean(&mut self, [right_rad, away_rad]: [f64; 2]) {
        // A positive rotation about y turns the downward axis to the left, one about x to the far
        // side.
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), -right_rad)
            * Rotation3::from_axis_angle(&Vector3::x_axis(), away_rad);
        let leaned = Unit::new_normalize(turn * self.axis.into_inner());
        if -leaned.z >= libm::cos(MOST_LEAN_RAD) {
            self.axis = leaned;
        }
    }
}

#[cfg(test)]
mod tests {
    //! Fails if input moves the needle the wrong way, or if it cannot be brought back.

    use super::*;

    fn steering() -> Steering {
        Steering::straight(-Vector3::z_axis(), 0.15)
    }

    #[test]
    fn confirmations_are_counted() {
        let mut steering = steering();
        let told = [0, 2, 0, 1]
            .map(|confirmed| steering.follow(&SteeringWish { confirmed, ..SteeringWish::default() }).confirmed);
        assert_eq!(told, [0, 2, 2, 3]);
    }

    #[test]
    fn in_is_down_and_aside_is_level() {
        let mut steering = steering();
        let aim = steering.follow(&SteeringWish { advance_m: 0.01, ..SteeringWish::default() });
        assert!((aim.position_m - Vector3::new(0.0, -0.01, 0.0)).norm() < 1e-15, "{}", aim.position_m);
        let aim = steering.follow(&SteeringWish { aside_m: [0.002, 0.003], ..SteeringWish::default() });
        assert!((aim.position_m - Vector3::new(0.002, -0.01, -0.003)).norm() < 1e-15, "{}", aim.position_m);
    }

    #[test]
    fn a_leaning_needle_goes_in_along_itself_and_leans_as_asked() {
        let mut steering = steering();
        steering.follow(&SteeringWish { lean_rad: [0.3, 0.0], ..SteeringWish::default() });
        assert!(steering.axis.x > 0.29 && steering.axis.y.abs() < 1e-15, "the tip goes right: {}", steering.axis.x);
        steering.follow(&SteeringWish { lean_rad: [0.0, 0.2], ..SteeringWish::default() });
        assert!(steering.axis.y > 0.18, "the tip goes away from the person: {}", steering.axis.y);
        let before_m = steering.away_m;
        steering.follow(&SteeringWish { advance_m: 0.01, ..SteeringWish::default() });
        assert!((steering.away_m - before_m - steering.axis.into_inner() * 0.01).norm() < 1e-15);
    }

    #[test]
    fn the_handle_points_where_the_needle_does() {
        let mut steering = steering();
        let aim = steering.follow(&SteeringWish { lean_rad: [0.3, -0.1], ..SteeringWish::default() });
        let patient_from_device = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let needle = patient_from_device * aim.orientation * Vector3::z();
        assert!((needle - steering.axis.into_inner()).norm() < 1e-12);
    }

    #[test]
    fn whatever_is_asked_it_stays_near_and_can_come_back() {
        let mut steering = steering();
        for _ in 0..1000 {
            steering.follow(&SteeringWish { advance_m: 0.01, lean_rad: [0.1, 0.1], ..SteeringWish::default() });
        }
        assert!(steering.away_m.norm() <= steering.most_away_m && -steering.axis.z >= libm::cos(MOST_LEAN_RAD));
        let before_m = steering.away_m.norm();
        steering.follow(&SteeringWish { advance_m: -0.01, ..SteeringWish::default() });
        assert!(steering.away_m.norm() < before_m);
    }
}
