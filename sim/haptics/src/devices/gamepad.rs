//! A gamepad that moves the set-point of a virtual hand: the left stick in the plane of the skin,
//! the right stick in and out.
//!
//! Sticks set a speed, so that the needle can be moved both finely and far. A thread polls the
//! gamepad a hundred times a second; the servo never waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use gilrs::{Axis, Button, Gamepad, GamepadId, Gilrs};
use nalgebra::Vector3;

use super::hand::{Aim, AimWriter};
use crate::device::buttons;

/// Polling period of the sticks, in s.
const PERIOD_S: f64 = 0.01;
/// Speed of the set-point at full deflection, in m/s.
const FASTEST_M_PER_S: f64 = 0.03;
/// Dead zone: sticks do not centre exactly, so deflections below this fraction count as zero.
const DEAD: f64 = 0.12;
/// Bound of the set-point from the middle, on each axis, in m.
const REACH_M: f64 = 0.2;

/// Why no gamepad is available.
#[derive(Debug, thiserror::Error)]
pub enum GamepadError {
    /// None is connected.
    #[error("no gamepad found: connect one and press a button on it")]
    None,
    /// The system denies access.
    #[error("gamepads cannot be read: {0}; on Linux the user must be allowed to read /dev/input (group input)")]
    System(String),
    /// The thread cannot be created.
    #[error("no thread for the gamepad: {0}")]
    Thread(#[from] std::io::Error),
}

/// One reading of the sticks and buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sticks {
    /// Left stick, right and up positive, −1 to 1.
    left: [f64; 2],
    /// Right stick, up positive, −1 to 1.
    lift: f64,
    /// Buttons held down; see [`buttons`].
    buttons: u32,
}

/// The thread that polls a gamepad. Dropping it stops the thread.
#[derive(Debug)]
pub struct GamepadFeed {
    name: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Returns the names of the connected gamepads.
///
/// # Errors
/// If the system denies access.
pub fn connected() -> Result<Vec<String>, GamepadError> {
    Ok(open()?.gamepads().map(|(_, gamepad)| gamepad.name().to_owned()).collect())
}

fn open() -> Result<Gilrs, GamepadError> {
    Gilrs::new().map_err(|error| GamepadError::System(error.to_string()))
}

impl GamepadFeed {
    /// Starts moving the set-point with the first gamepad.
    ///
    /// # Errors
    /// If no gamepad is connected, the system denies access, or the thread cannot be created.
    pub fn start(aim: AimWriter) -> Result<Self, GamepadError> {
        let gilrs = open()?;
        let (id, gamepad) = gilrs.gamepads().next().ok_or(GamepadError::None)?;
        let name = gamepad.name().to_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&stop);
        let thread =
            thread::Builder::new().name("gamepad".to_owned()).spawn(move || follow(gilrs, id, aim, &theirs))?;
        Ok(Self { name, stop, thread: Some(thread) })
    }

    /// The gamepad's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for GamepadFeed {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The thread ends within one period; a panic in it needs no handling here.
            let _ = thread.join();
        }
    }
}

/// Body of the thread.
fn follow(mut gilrs: Gilrs, id: GamepadId, mut writer: AimWriter, stop: &AtomicBool) {
    let mut aim = Aim::default();
    while !stop.load(Ordering::Relaxed) {
        while gilrs.next_event().is_some() {}
        // An unplugged gamepad reads as sticks at rest, so the set-point stays.
        let sticks = gilrs.connected_gamepad(id).map(read).unwrap_or_default();
        aim = moved(&aim, &sticks, PERIOD_S);
        writer.write(aim);
        thread::sleep(Duration::from_secs_f64(PERIOD_S));
    }
}

fn read(gamepad: Gamepad<'_>) -> Sticks {
    let button = |button: Button, bit: u32| if gamepad.is_pressed(button) { bit } else { 0 };
    Sticks {
        left: [Axis::LeftStickX, Axis::LeftStickY].map(|axis| f64::from(gamepad.value(axis))),
        lift: f64::from(gamepad.value(Axis::RightStickY)),
        buttons: button(Button::South, buttons::CONFIRM) | button(Button::RightTrigger, buttons::CLUTCH),
    }
}

/// Returns the set-point after the sticks have acted for `dt_s`, in s. Device frame: x right, y up,
/// z towards the user.
fn moved(aim: &Aim, sticks: &Sticks, dt_s: f64) -> Aim {
    let [right, away] = sticks.left;
    let way = Vector3::new(right, sticks.lift, -away).map(speed_m_per_s) * dt_s;
    Aim {
        position_m: (aim.position_m + way).map(|part| part.clamp(-REACH_M, REACH_M)),
        buttons: sticks.buttons,
        ..*aim
    }
}

/// Speed at a stick deflection, in m/s: zero in the dead zone, then quadratic.
fn speed_m_per_s(way: f64) -> f64 {
    let beyond = ((way.abs() - DEAD) / (1.0 - DEAD)).clamp(0.0, 1.0);
    FASTEST_M_PER_S * beyond * beyond * way.signum()
}

#[cfg(test)]
mod tests {
    //! A set-point that creeps, runs away or goes the wrong way would move the needle against the
    //! user's intention.

    use super::*;

    fn after_a_second(sticks: Sticks) -> Vector3<f64> {
        (0..100).fold(Aim::default(), |aim, _| moved(&aim, &sticks, PERIOD_S)).position_m
    }

    #[test]
    fn sticks_at_rest_do_not_creep_and_those_all_the_way_move_at_the_stated_speed() {
        let resting = Sticks { left: [0.1, -0.1], lift: 0.11, buttons: 0 };
        assert_eq!(after_a_second(resting), Vector3::zeros());
        let down = after_a_second(Sticks { lift: -1.0, ..Sticks::default() });
        assert!((down - Vector3::new(0.0, -0.03, 0.0)).norm() < 1e-12, "{down}");
        let away = after_a_second(Sticks { left: [0.0, 1.0], ..Sticks::default() });
        assert!((away - Vector3::new(0.0, 0.0, -0.03)).norm() < 1e-12, "{away}");
    }

    #[test]
    fn the_set_point_stays_within_reach_and_ignores_nonsense() {
        let mut aim = Aim::default();
        for _ in 0..10_000 {
            aim = moved(&aim, &Sticks { left: [1.0, 2.0], lift: -9.0, buttons: 3 }, PERIOD_S);
        }
        assert!((aim.position_m - Vector3::new(0.2, -0.2, -0.2)).norm() < 1e-12 && aim.buttons == 3);
    }
}
