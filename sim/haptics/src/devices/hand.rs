//! A virtual hand for mouse, keyboard and gamepad: a mass on a spring and a damper that follows a
//! set-point.
//!
//! A mouse has no motors: a needle that it moved directly would pass through bone. So the mouse
//! moves a set-point, and a hand of [`law::operator`] follows it: tissue can stop the hand, and a
//! pop throws it forward.

use law::operator::{Hand, SetPoint, Skill};
use nalgebra::{UnitQuaternion, Vector3};
use triple_buffer::{Input, Output, triple_buffer};

use crate::device::{Device, DeviceFault, DeviceInfo, Reading, buttons as button};

/// Set-point of the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Position, in m, device frame.
    pub position_m: Vector3<f64>,
    /// Orientation, device_from_handle.
    pub orientation: UnitQuaternion<f64>,
    /// Buttons held down; see [`crate::device::buttons`].
    pub buttons: u32,
    /// Number of confirmations so far. The hand presses and releases its confirm button once for
    /// each, even if several arrive in one update.
    pub confirmed: u32,
}

impl Default for Aim {
    /// The middle of the workspace, no button pressed, no confirmation.
    fn default() -> Self {
        Self { position_m: Vector3::zeros(), orientation: UnitQuaternion::identity(), buttons: 0, confirmed: 0 }
    }
}

/// The writing end of the set-point, for the window or a gamepad's thread.
#[derive(Debug)]
pub struct AimWriter {
    cell: Input<Aim>,
}

impl AimWriter {
    /// Writes the set-point. Never waits.
    pub fn write(&mut self, aim: Aim) {
        self.cell.write(aim);
    }
}

/// Interpolates set-points written a few times a second: each is reached linearly in the time that
/// passed since the previous one.
#[derive(Clone, Copy, Debug)]
struct Glide {
    from: Aim,
    to: Aim,
    /// Duration of the interpolation, and readings since it began.
    takes: u32,
    passed: u32,
}

/// A pause longer than this, in readings, ends a motion: the next set-point begins a new one.
const PAUSE: u32 = 250;
/// Duration of the interpolation for the first set-point after a pause, in readings: one display
/// frame.
const FIRST: u32 = 16;

impl Glide {
    /// At rest in the middle, with no orientation yet.
    fn still() -> Self {
        Self { from: Aim::default(), to: Aim::default(), takes: FIRST, passed: u32::MAX }
    }

    /// Starts towards another set-point. The first one sets the orientation at once.
    fn turn(&mut self, to: Aim) {
        let takes = if self.passed < PAUSE { self.passed.max(1) } else { FIRST };
        let from = if self.passed == u32::MAX { Aim { orientation: to.orientation, ..self.aim() } } else { self.aim() };
        *self = Self { from, to, takes, passed: 0 };
    }

    /// The interpolated set-point.
    fn aim(&self) -> Aim {
        let share = f64::from(self.passed.min(self.takes)) / f64::from(self.takes);
        Aim {
            position_m: self.from.position_m.lerp(&self.to.position_m, share),
            orientation: self.from.orientation.nlerp(&self.to.orientation, share),
            ..self.to
        }
    }

    /// Advances by one reading.
    fn step(&mut self) -> Aim {
        self.passed = self.passed.saturating_add(1);
        self.aim()
    }
}

/// Readings for which the confirm button is down, and then up, at each press.
const PRESS: u32 = 25;

/// Presses the confirm button once for each confirmation.
#[derive(Clone, Copy, Debug, Default)]
struct Finger {
    /// Presses started.
    begun: u32,
    /// Readings left of the last press.
    left: u32,
}

impl Finger {
    /// Returns whether the button is down at this reading; `confirmed` is the number of presses due
    /// by now.
    fn step(&mut self, confirmed: u32) -> bool {
        if self.left == 0 && self.begun < confirmed {
            *self = Self { begun: self.begun + 1, left: 2 * PRESS };
        }
        let is_down = self.left > PRESS;
        self.left = self.left.saturating_sub(1);
        is_down
    }
}

/// The hand. Each reading advances its time by one period.
#[derive(Debug)]
pub struct VirtualHand {
    info: DeviceInfo,
    hand: Hand,
    aim: Output<Aim>,
    glide: Glide,
    finger: Finger,
    force_n: Vector3<f64>,
    period_s: f64,
    readings: u64,
}

/// Maximum force of a hand, in N: above that of any puncture.
const MAX_FORCE_N: f64 = 40.0;
/// Greatest stiffness against which such a hand is stable at 1 kHz, in N/m: k dt² stays far below 4
/// M.
const MAX_STIFFNESS_N_PER_M: f64 = 10_000.0;

/// Limits of virtual devices: any scene is rendered unscaled.
pub(super) fn info(name: &str) -> DeviceInfo {
    DeviceInfo {
        name: name.to_owned(),
        serial: None,
        max_force_n: MAX_FORCE_N,
        continuous_force_n: MAX_FORCE_N,
        max_stiffness_n_per_m: MAX_STIFFNESS_N_PER_M,
        workspace_m: [0.4, 0.4, 0.4],
        measures_orientation: true,
        is_virtual: true,
    }
}

impl VirtualHand {
    /// A hand with a skill in the middle of its workspace, ticked at `rate_hz`, in Hz, and the
    /// writer of its set-point. `name` is the input device, for example `mouse`.
    #[must_use]
    pub fn new(name: &str, skill: &Skill, rate_hz: f64) -> (Self, AimWriter) {
        let (writer, aim) = triple_buffer(&Aim::default());
        let hand = Self {
            info: info(name),
            hand: Hand::new(skill, Vector3::zeros()),
            aim,
            glide: Glide::still(),
            finger: Finger::default(),
            force_n: Vector3::zeros(),
            period_s: 1.0 / rate_hz,
            readings: 0,
        };
        (hand, AimWriter { cell: writer })
    }

    /// The hand that holds a mouse: braced and critically damped, so that it follows without swinging.
    #[must_use]
    pub fn braced() -> Skill {
        Skill { stiffness_n_per_m: 1500.0, damping_n_s_per_m: 60.0, ..Skill::expert() }
    }
}

impl Device for VirtualHand {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self) -> Result<Reading, DeviceFault> {
        if self.aim.update() {
            self.glide.turn(*self.aim.output_buffer());
        }
        let Aim { position_m, orientation, buttons, confirmed } = self.glide.step();
        let confirms = if self.finger.step(confirmed) { button::CONFIRM } else { 0 };
        let set_point = SetPoint { position_m, velocity_m_per_s: Vector3::zeros() };
        self.hand.step(self.period_s, &set_point, &self.force_n);
        self.readings += 1;
        Ok(Reading {
            t_s: self.readings as f64 * self.period_s,
            position_m: self.hand.position_m,
            orientation,
            buttons: buttons | confirms,
            motor_heat: 0.0,
        })
    }

    fn write(&mut self, force_n: &Vector3<f64>) -> Result<(), DeviceFault> {
        self.force_n = *force_n;
        Ok(())
    }

    fn close(&mut self) {
        self.force_n = Vector3::zeros();
    }
}

#[cfg(test)]
mod tests {
    //! The hand must follow, be stopped, and be released: otherwise a mouse passes through bone or
    //! never shows a pop.

    use super::*;

    /// Position along x, in m, after a force in N has acted for a second.
    fn after_a_second(hand: &mut VirtualHand, force_n: f64) -> f64 {
        let mut x_m = 0.0;
        for _ in 0..1000 {
            x_m = hand.read().expect("a hand is always there").position_m.x;
            hand.write(&Vector3::new(force_n, 0.0, 0.0)).expect("it takes any force");
        }
        x_m
    }

    #[test]
    fn it_follows_the_set_point_and_yields_by_force_over_stiffness() {
        let (mut hand, mut aim) = VirtualHand::new("mouse", &VirtualHand::braced(), 1000.0);
        aim.write(Aim { position_m: Vector3::new(0.03, 0.0, 0.0), buttons: 1, ..Aim::default() });
        assert!((after_a_second(&mut hand, 0.0) - 0.03).abs() < 1e-6);
        let pushed_m = after_a_second(&mut hand, -3.0);
        assert!((pushed_m - (0.03 - 3.0 / 1500.0)).abs() < 1e-6, "{pushed_m}");
        assert_eq!(hand.read().expect("there").buttons, 1);
        hand.close();
        assert!((after_a_second(&mut hand, 0.0) - 0.03).abs() < 1e-6, "let go, it comes back");
    }

    /// Greatest acceleration, in m/s², with a set-point that moves 1 cm in a second and is written
    /// every `every` readings.
    fn roughest_m_per_s2(every: usize) -> f64 {
        let (mut hand, mut aim) = VirtualHand::new("keyboard", &VirtualHand::braced(), 1000.0);
        let mut way = Vec::new();
        for reading in 0..1000 {
            if reading % every == 0 {
                let position_m = Vector3::new(1e-5 * reading as f64, 0.0, 0.0);
                aim.write(Aim { position_m, ..Aim::default() });
            }
            way.push(hand.read().expect("there").position_m.x);
        }
        let steady = way[600..].windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs() * 1e6);
        steady.fold(0.0, f64::max)
    }

    #[test]
    fn a_slow_picture_does_not_make_it_jerk() {
        // Steps of 2 mm would push the hand with k Δx / M = 5 m/s².
        assert!(roughest_m_per_s2(200) < 0.05, "{}", roughest_m_per_s2(200));
        assert!(roughest_m_per_s2(16) < 0.05, "{}", roughest_m_per_s2(16));
    }

    #[test]
    fn every_confirmation_is_a_press_of_its_own_and_nothing_else_is() {
        let (mut hand, mut aim) = VirtualHand::new("keyboard", &VirtualHand::braced(), 1000.0);
        let mut buttons = vec![0];
        for confirmed in [0, 1, 1, 4, 4] {
            aim.write(Aim { confirmed, ..Aim::default() });
            buttons.extend((0..200).map(|_| hand.read().expect("there").buttons));
        }
        let presses = buttons.windows(2).filter(|pair| pair[0] == 0 && pair[1] == button::CONFIRM).count();
        assert_eq!(presses, 4);
        assert_eq!(buttons.last(), Some(&0), "and it is let go");
    }

    #[test]
    fn first_reading_has_the_orientation_of_the_first_set_point() {
        let (mut hand, mut aim) = VirtualHand::new("mouse", &VirtualHand::braced(), 1000.0);
        let orientation = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 1.0);
        aim.write(Aim { orientation, ..Aim::default() });
        assert!(hand.read().expect("there").orientation.angle_to(&orientation) < 1e-9);
    }

    #[test]
    fn it_does_not_swing() {
        let (mut hand, mut aim) = VirtualHand::new("mouse", &VirtualHand::braced(), 1000.0);
        aim.write(Aim { position_m: Vector3::new(0.03, 0.0, 0.0), ..Aim::default() });
        let way: Vec<f64> = (0..1000).map(|_| hand.read().expect("there").position_m.x).collect();
        assert!(way.iter().all(|&x| x <= 0.03 * 1.001), "it overshoots by less than a thousandth");
    }
}
