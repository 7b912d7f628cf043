//! A gamepad moves the set-point of a virtual hand: the left stick in the plane of the skin, the right stick or the triggers in and out,
//! and the left stick with the left bumper held leans the needle. It shakes at a pop.
//!
//! Sticks set a speed, so that the needle can be moved both finely and far. A thread polls the
//! gamepad a hundred times a second; the servo never waits for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use gilrs::ff::{BaseEffect, BaseEffectType, Effect, EffectBuilder, Repeat, Replay, Ticks};
use gilrs::{Axis, Button, Gamepad, GamepadId, Gilrs};
use nalgebra::{UnitQuaternion, Vector3};

use super::hand::{Aim, AimWriter};
use crate::device::buttons;

/// Polling period of the sticks, in s.
const PERIOD_S: f64 = 0.01;
/// Speed of the set-point at full deflection, in m/s.
const FASTEST_M_PER_S: f64 = 0.03;
/// A pop shakes the gamepad for so long, in ms, with so much of its strength.
const RUMBLE_MS: u32 = 90;
const RUMBLE_STRENGTH: u16 = 40_000;
/// Speed of leaning with a stick all the way, in rad/s, and how far from straight down the needle may lean, in rad.
const FASTEST_RAD_PER_S: f64 = 0.5;
const MOST_LEAN_RAD: f64 = 1.2;
/// The set-point stays within this distance of the middle, on each axis, in m.
const REACH_M: f64 = 0.2;

/// How sticks move the needle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickFeel {
    /// Factor on the speed of 30 mm/s with a stick all the way.
    pub speed: f64,
    /// Sticks do not come to rest exactly: below this part of their way they count as at rest.
    pub dead_zone: f64,
}

impl Default for StickFeel {
    fn default() -> Self {
        Self { speed: 1.0, dead_zone: 0.12 }
    }
}

/// Why there is no gamepad.
#[derive(Debug, thiserror::Error)]
pub enum GamepadError {
    /// None is connected.
    #[error("no gamepad found: connect one and press a button on it")]
    None,
    /// The system denies access.
    #[error("gamepads cannot be read: {0}; on Linux the user must be allowed to read /dev/input (group input)")]
    System(String),
    /// The thread cannot be created.
    #[error("the gamepad's thread cannot be started: {0}")]
    Thread(#[from] std::io::Error),
}

/// One reading of the sticks and buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sticks {
    /// Left stick, right and up positive, −1 to 1.
    left: [f64; 2],
    /// Right stick, up positive, and triggers, the left one out, −1 to 1.
    lift: f64,
    /// The left stick leans the needle instead of moving it.
    leans: bool,
    /// Buttons of the device trait.
    buttons: u32,
}

/// The thread that polls a gamepad. Dropping it stops the thread.
#[derive(Debug)]
pub struct GamepadFeed {
    name: String,
    shared: Arc<FeedShared>,
    thread: Option<JoinHandle<()>>,
}

/// What both sides of the thread see.
#[derive(Debug, Default)]
struct FeedShared {
    stop: AtomicBool,
    /// How often it is to shake so far.
    pops: AtomicU32,
}

/// Names of the gamepads that are connected.
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
    /// Lets the first gamepad move a set-point, which begins with a planned orientation, device_from_handle.
    ///
    /// # Errors
    /// When there is none.
    pub fn start(aim: AimWriter, feel: StickFeel, planned: UnitQuaternion<f64>) -> Result<Self, GamepadError> {
        let gilrs = open()?;
        let (id, gamepad) = gilrs.gamepads().next().ok_or(GamepadError::None)?;
        let name = gamepad.name().to_owned();
        let shared = Arc::new(FeedShared::default());
        let theirs = Arc::clone(&shared);
        let first = Aim { orientation: planned, ..Aim::default() };
        let thread = thread::Builder::new()
            .name("gamepad".to_owned())
            .spawn(move || follow(gilrs, id, Feed { writer: aim, feel, aim: first }, &theirs))?;
        Ok(Self { name, shared, thread: Some(thread) })
    }

    /// Shakes the gamepad, where it has motors for that.
    pub fn pop(&self) {
        self.shared.pops.fetch_add(1, Ordering::Relaxed);
    }

    /// The gamepad's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for GamepadFeed {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The thread ends within one period; a panic in it needs no handling here.
            let _ = thread.join();
        }
    }
}

/// What the thread moves.
struct Feed {
    writer: AimWriter,
    feel: StickFeel,
    aim: Aim,
}

/// The thread.
fn follow(mut gilrs: Gilrs, id: GamepadId, mut feed: Feed, shared: &FeedShared) {
    let rumble = build_rumble(&mut gilrs, id);
    let mut felt = 0;
    while !shared.stop.load(Ordering::Relaxed) {
        while gilrs.next_event().is_some() {}
        // An unplugged gamepad reads as sticks at rest, so the set-point stays.
        let sticks = gilrs.connected_gamepad(id).map(read).unwrap_or_default();
        feed.aim = moved(&feed.aim, &sticks, &feed.feel, PERIOD_S);
        feed.writer.write(feed.aim);
        let pops = shared.pops.load(Ordering::Relaxed);
        if pops != felt {
            felt = pops;
            // One that was unplugged shakes no more.
            let _unfelt = rumble.as_ref().map(Effect::play);
        }
        thread::sleep(Duration::from_secs_f64(PERIOD_S));
    }
}

/// A short shake; none for a gamepad without motors.
fn build_rumble(gilrs: &mut Gilrs, id: GamepadId) -> Option<Effect> {
    let has_motors = gilrs.connected_gamepad(id).is_some_and(|gamepad| gamepad.is_ff_supported());
    let shake = BaseEffect {
        kind: BaseEffectType::Strong { magnitude: RUMBLE_STRENGTH },
        scheduling: Replay { play_for: Ticks::from_ms(RUMBLE_MS), ..Replay::default() },
        ..BaseEffect::default()
    };
    // Played once for each pop, not again and again.
    let once = Repeat::For(Ticks::from_ms(RUMBLE_MS));
    has_motors.then(|| EffectBuilder::new().add_effect(shake).repeat(once).gamepads(&[id]).finish(gilrs).ok()).flatten()
}

fn read(gamepad: Gamepad<'_>) -> Sticks {
    let button = |button: Button, bit: u32| if gamepad.is_pressed(button) { bit } else { 0 };
    let trigger = |button: Button| gamepad.button_data(button).map_or(0.0, |data| f64::from(data.value()));
    Sticks {
        left: [Axis::LeftStickX, Axis::LeftStickY].map(|axis| f64::from(gamepad.value(axis))),
        lift: f64::from(gamepad.value(Axis::RightStickY)) + trigger(Button::LeftTrigger2)
            - trigger(Button::RightTrigger2),
        leans: gamepad.is_pressed(Button::LeftTrigger),
        buttons: button(Button::South, buttons::CONFIRM) | button(Button::RightTrigger, buttons::CLUTCH),
    }
}

/// The set-point after a time in s of the sticks. Device frame: x right, y up, z towards the person.
fn moved(aim: &Aim, sticks: &Sticks, feel: &StickFeel, dt_s: f64) -> Aim {
    let [right, away] = sticks.left.map(|way| feel.share(way));
    let aside = if sticks.leans { [0.0; 2] } else { [right, away] };
    let way = Vector3::new(aside[0], feel.share(sticks.lift), -aside[1]) * (FASTEST_M_PER_S * dt_s);
    let lean = if sticks.leans { [right, away] } else { [0.0; 2] };
    Aim {
        position_m: (aim.position_m + way).map(|part| part.clamp(-REACH_M, REACH_M)),
        orientation: leaned(&aim.orientation, lean.map(|share| share * FASTEST_RAD_PER_S * dt_s)),
        buttons: sticks.buttons,
        ..*aim
    }
}

/// An orientation whose tip leans further to the right and away from the person, by angles in rad; unchanged where that is too far.
fn leaned(orientation: &UnitQuaternion<f64>, [right_rad, away_rad]: [f64; 2]) -> UnitQuaternion<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), right_rad)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), away_rad);
    let turned = turn * orientation;
    let from_down_rad = (turned * Vector3::z()).angle(&-Vector3::y());
    if from_down_rad <= MOST_LEAN_RAD { turned } else { *orientation }
}

impl StickFeel {
    /// Share of the greatest speed for a stick's way: nothing near rest, then rising with the square.
    fn share(&self, way: f64) -> f64 {
        let beyond = ((way.abs() - self.dead_zone) / (1.0 - self.dead_zone)).clamp(0.0, 1.0);
        self.speed * beyond * beyond * way.signum()
    }
}

#[cfg(test)]
mod tests {
    //! A set-point that creeps, runs away or goes the wrong way would move the needle against the
    //! user's intention.

    use super::*;

    fn after_a_second(sticks: Sticks) -> Vector3<f64> {
        (0..100).fold(Aim::default(), |aim, _| moved(&aim, &sticks, &StickFeel::default(), PERIOD_S)).position_m
    }

    #[test]
    fn resting_sticks_hold_still_and_full_sticks_move_at_set_speed() {
        let resting = Sticks { left: [0.1, -0.1], lift: 0.11, ..Sticks::default() };
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
            let sticks = Sticks { left: [1.0, 2.0], lift: -9.0, leans: false, buttons: 3 };
            aim = moved(&aim, &sticks, &StickFeel::default(), PERIOD_S);
        }
        assert!((aim.position_m - Vector3::new(0.2, -0.2, -0.2)).norm() < 1e-12 && aim.buttons == 3);
    }

    #[test]
    fn a_held_bumper_leans_the_needle_and_no_further_than_it_may() {
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let mut aim = Aim { orientation: down, ..Aim::default() };
        let sticks = Sticks { left: [1.0, 0.0], leans: true, ..Sticks::default() };
        aim = moved(&aim, &sticks, &StickFeel::default(), PERIOD_S);
        let needle = aim.orientation * Vector3::z();
        assert!(needle.x > 0.004 && needle.y < -0.99 && aim.position_m == Vector3::zeros(), "{needle}");
        for _ in 0..1000 {
            aim = moved(&aim, &sticks, &StickFeel::default(), PERIOD_S);
        }
        assert!((aim.orientation * Vector3::z()).angle(&-Vector3::y()) <= MOST_LEAN_RAD);
    }
}
