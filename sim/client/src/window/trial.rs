//! The attempt: the picture in the middle, the instruments and messages around it.

use std::sync::Arc;

use documents::Channel;
use eframe::egui::{self, Event, InputState, Key, MouseWheelSource, MouseWheelUnit, PointerButton, Response, Ui};
use render::frame::View;

use super::Station;
use super::canvas::Canvas;
use super::overlay::{self, Instruments};
use super::sound::Sound;
use super::steer::{Steering, SteeringWish};
use super::x_ray::XRayPanel;
use crate::live::open::Steered;
use crate::live::{self, Finished, Live, Phase};
use crate::picture::Look;

/// Speed of the needle with the arrow keys, in m/s; with shift a quarter of it.
const KEY_M_PER_S: f64 = 0.006;
/// Speed of the tilt with the keys, in rad/s; with shift a quarter of it.
const KEY_RAD_PER_S: f64 = 0.25;
/// Motion of the needle by a drag, in m per point.
const DRAG_M: f64 = 0.000_08;
/// Motion of the needle by a notch of the wheel, in m, and points of a touchpad per notch.
const NOTCH_M: f64 = 0.000_75;
const NOTCH_POINTS: f64 = 40.0;
/// Maximum number of notches at once, and per second: enough for a hand, but not for a wheel that
/// spins on.
const MOST_NOTCHES: f64 = 16.0;
const MOST_NOTCHES_HZ: f64 = 60.0;
/// Time for which a key counts that is released within the frame, in s; and the longest time that
/// counts for a frame, in s.
const TAP_S: f64 = 0.08;
const LONGEST_S: f32 = 0.25;
/// Rotation of the picture by a drag, in rad per point.
const ORBIT_RAD: f32 = 0.006;

/// The attempt screen.
pub struct TrialScreen {
    live: Live,
    steering: Steering,
    wheel: Wheel,
    steered: Steered,
    /// Reasons why other devices were not used.
    passed_over: Vec<String>,
    look: Look,
    x_ray: XRayPanel,
    sound: Sound,
    /// Factor of the speed of mouse and keys.
    pointer_speed: f64,
    pops_heard: u64,
}

/// The next step.
pub enum AfterTrial {
    /// Stay on this screen.
    Stay,
    /// The attempt is over.
    Over,
}

impl TrialScreen {
    /// Shows an attempt, and moves its device if the window steers it.
    pub fn new(live: Live, steered: Steered, passed_over: Vec<String>, station: &Station) -> Self {
        let (guided, settings) = (station.guided, station.settings);
        let steering = Steering::new(&live.trial.bundle);
        let bundle = &live.trial.bundle;
        let look = Look { closed: !bundle.exercise.feedback.gives(Channel::Inside), ..Look::at(&bundle.scene, guided) };
        Self {
            live,
            steering,
            wheel: Wheel::default(),
            steered,
            passed_over,
            look,
            x_ray: XRayPanel::default(),
            sound: Sound::open(settings.volume as f32),
            pointer_speed: settings.pointer_speed,
            pops_heard: 0,
        }
    }

    /// Shows one frame.
    pub fn ui(&mut self, ui: &mut Ui, canvas: &mut Canvas) -> AfterTrial {
        ui.ctx().request_repaint();
        let latest = self.live.latest().cloned();
        let shown = self.live.shown().clone();
        let exercise = &self.live.trial.bundle.exercise;
        let feedback = exercise.feedback;
        if shown.pops > self.pops_heard {
            if feedback.gives(Channel::Sound) {
                self.sound.pop();
            }
            if let (Steered::Gamepad(feed), true) = (&self.steered, feedback.gives(Channel::Force)) {
                feed.pop();
            }
            self.pops_heard = shown.pops;
        }
        let instruments = Instruments {
            shown: &shown,
            latest: latest.as_ref(),
            live: &self.live,
            quality: canvas.quality(),
            passed_over: &self.passed_over,
            by_hand: matches!(self.steered, Steered::Window(_)),
        };
        let over = overlay::show_side_panel(ui, &instruments, &mut self.sound);
        overlay::show_messages(ui, &shown, feedback);
        if let Some(arm) = &self.live.trial.arm {
            self.x_ray.ui(ui, arm, shown.moment.sample.t_s);
        }
        let frame = shown.moment.frame(&self.look, exercise.target_depth_mm * 1e-3);
        let picture = egui::CentralPanel::no_frame().show(ui, |ui| {
            let picture = canvas.show(ui, &frame);
            overlay::draw_heading(ui, picture.rect, &instruments);
            if feedback.gives(Channel::Readings) && self.look.view == View::Section {
                overlay::draw_layer_names(ui, picture.rect, &canvas.camera(&frame), &self.live.trial);
            }
            picture
        });
        self.control(ui, &picture.inner);
        let ended = self.live.servo().ended().is_some() || matches!(shown.phase, Phase::Withdrawn | Phase::TimeUp);
        if over || ended { AfterTrial::Over } else { AfterTrial::Stay }
    }

    /// Ends the attempt with zero force on the device.
    pub fn stop(self) -> (Arc<live::LiveTrial>, Finished) {
        self.live.stop()
    }

    fn control(&mut self, ui: &Ui, picture: &Response) {
        change_look(ui, picture, &mut self.look);
        if let Steered::Window(aim) = &mut self.steered {
            let wish = steering_wish(ui, picture, &mut self.wheel).at_speed(self.pointer_speed);
            aim.write(self.steering.follow(&wish));
        }
    }
}

/// A mouse's wheel or a touchpad, with the number of notches that still count. The limit does not
/// depend on the frame rate.
pub struct Wheel {
    notches_left: f64,
}

impl Default for Wheel {
    fn default() -> Self {
        Self { notches_left: MOST_NOTCHES }
    }
}

impl Wheel {
    /// Returns the advance by the wheel in a frame of `dt_s`, in m; scrolling down is in. With the
    /// command key the wheel zooms instead. A touchpad's momentum is ignored.
    fn advance_m(&mut self, events: &[Event], dt_s: f64) -> f64 {
        self.notches_left = (self.notches_left + MOST_NOTCHES_HZ * dt_s).min(MOST_NOTCHES);
        let notches = events.iter().map(|event| match event {
            Event::MouseWheel { unit, delta, source, modifiers, .. }
                if !modifiers.command && *source != MouseWheelSource::Momentum =>
            {
                match unit {
                    MouseWheelUnit::Line => f64::from(delta.y),
                    MouseWheelUnit::Point => f64::from(delta.y) / NOTCH_POINTS,
                    MouseWheelUnit::Page => f64::from(delta.y) * MOST_NOTCHES,
                }
            }
            _ => 0.0,
        });
        let counted = notches.sum::<f64>().clamp(-self.notches_left, self.notches_left);
        self.notches_left -= counted.abs();
        -counted * NOTCH_M
    }
}

/// Changes the view by number keys, the guide by G, and the user's own rotation of the picture by
/// the right button.
pub fn change_look(ui: &Ui, picture: &Response, look: &mut Look) {
    ui.input(|input| {
        let views =
            [(Key::Num1, View::Whole), (Key::Num2, View::Tip), (Key::Num3, View::Section), (Key::Num4, View::Patient)];
        for (key, view) in views.into_iter().filter(|_| !look.closed) {
            if input.key_pressed(key) {
                look.view = view;
                look.orbit = Default::default();
            }
        }
        if input.key_pressed(Key::G) {
            look.guide = !look.guide;
        }
        if input.key_pressed(Key::Num0) {
            look.orbit = Default::default();
        }
    });
    if picture.dragged_by(PointerButton::Secondary) {
        let way = picture.drag_delta();
        look.orbit.yaw_rad += way.x * ORBIT_RAD;
        look.orbit.pitch_rad = (look.orbit.pitch_rad + way.y * ORBIT_RAD).clamp(-1.0, 1.0);
    }
    if picture.hovered() {
        let zoom = ui.input(|input| input.zoom_delta());
        look.orbit.distance = (look.orbit.distance / zoom).clamp(0.3, 3.0);
    }
}

/// Returns the steering input of this frame for a virtual hand.
pub fn steering_wish(ui: &Ui, picture: &Response, wheel: &mut Wheel) -> SteeringWish {
    let drag = if picture.dragged_by(PointerButton::Primary) { picture.drag_delta() } else { Default::default() };
    ui.input(|input| wished_motion(input, drag, picture.hovered().then_some(wheel)))
}

/// Converts the input of a frame, with the drag in points, and with the wheel if the pointer is
/// over the picture. Keys are read from events, so that a tap that ends within the frame counts.
fn wished_motion(input: &InputState, drag: egui::Vec2, wheel: Option<&mut Wheel>) -> SteeringWish {
    let dt_s = f64::from(input.stable_dt.min(LONGEST_S));
    let held_s = |key| match (input.key_down(key), input.key_pressed(key)) {
        (true, _) => dt_s,
        (false, true) => dt_s.min(TAP_S),
        (false, false) => 0.0,
    };
    let slow = if input.modifiers.shift { 0.25 } else { 1.0 };
    let (keys_m, keys_rad) = (slow * KEY_M_PER_S, slow * KEY_RAD_PER_S);
    let wheel_m = wheel.map_or(0.0, |wheel| wheel.advance_m(&input.events, dt_s));
    let aside = input.modifiers.shift && drag != egui::Vec2::ZERO;
    let along = if aside { 0.0 } else { f64::from(drag.y) * DRAG_M };
    let across = if aside { [f64::from(drag.x) * DRAG_M, -f64::from(drag.y) * DRAG_M] } else { [0.0; 2] };
    SteeringWish {
        advance_m: along + wheel_m + (held_s(Key::ArrowDown) - held_s(Key::ArrowUp)) * keys_m,
        aside_m: [
            across[0] + (held_s(Key::D) - held_s(Key::A)) * keys_m,
            across[1] + (held_s(Key::W) - held_s(Key::S)) * keys_m,
        ],
        lean_rad: [(held_s(Key::L) - held_s(Key::J)) * keys_rad, (held_s(Key::I) - held_s(Key::K)) * keys_rad],
        confirmed: count_key_presses(&input.events, Key::Space),
    }
}

/// Returns how often a key was pressed.
fn count_key_presses(events: &[Event], wanted: Key) -> u32 {
    let is_press =
        |event: &&Event| matches!(event, Event::Key { key, pressed: true, repeat: false, .. } if *key == wanted);
    events.iter().filter(is_press).map(|_| 1).sum()
}

#[cfg(test)]
mod tests {
    //! Fails if a tap is lost, or if the wheel moves the needle through the body at once.

    use eframe::egui::{Modifiers, RawInput, TouchPhase};

    use super::*;

    /// Returns the steering input of these events in a first frame of 0.2 s.
    fn asked(events: Vec<Event>) -> SteeringWish {
        asked_of(&mut Wheel::default(), 0.2, events)
    }

    fn asked_of(wheel: &mut Wheel, dt_s: f32, events: Vec<Event>) -> SteeringWish {
        let context = egui::Context::default();
        let mut wish = SteeringWish::default();
        let input = RawInput { time: Some(10.0), predicted_dt: dt_s, events, ..RawInput::default() };
        let mut output =
            context.run_ui(input, |ui| wish = ui.input(|input| wished_motion(input, egui::Vec2::ZERO, Some(wheel))));
        // Nothing is drawn here.
        output.textures_delta.clear();
        wish
    }

    fn key(key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE }
    }

    fn notches(count: f32) -> Event {
        let (unit, source, modifiers) = (MouseWheelUnit::Line, MouseWheelSource::Wheel, Modifiers::NONE);
        Event::MouseWheel { unit, delta: egui::vec2(0.0, count), phase: TouchPhase::Move, source, modifiers }
    }

    #[test]
    fn a_tap_within_a_frame_counts() {
        let taps = [key(Key::Space, true), key(Key::Space, false), key(Key::Space, true), key(Key::Space, false)];
        assert_eq!(asked(taps.to_vec()).confirmed, 2);
        assert_eq!(asked(vec![]).confirmed, 0);
        let tapped = asked(vec![key(Key::ArrowDown, true), key(Key::ArrowDown, false)]).advance_m;
        assert!(tapped > 1e-4 && tapped < 1e-3, "{tapped} m for a tap");
    }

    #[test]
    fn a_notch_is_less_than_a_millimetre_and_many_are_bounded() {
        let notch_m = asked(vec![notches(-1.0)]).advance_m;
        assert!((notch_m - NOTCH_M).abs() < 1e-9 && (0.0005..=0.001).contains(&notch_m), "{notch_m} m in");
        assert!((asked(vec![notches(1.0)]).advance_m + notch_m).abs() < 1e-12, "and out again");
        let mut wheel = Wheel::default();
        for (frames, at_once) in [(1, 12), (12, 1), (2, 6)] {
            let ways_m = (0..frames)
                .map(|_| asked_of(&mut wheel, 0.016, (0..at_once).map(|_| notches(-1.0)).collect()).advance_m);
            let way_m: f64 = ways_m.sum();
            assert!((way_m - 12.0 * notch_m).abs() < 1e-9, "{way_m} m for a dozen within {frames} frames");
            assert!(asked_of(&mut wheel, LONGEST_S, vec![]).advance_m.abs() < f64::EPSILON, "none comes later");
        }
        let spun_m: f64 = (0..60).map(|_| asked_of(&mut wheel, 1.0 / 60.0, vec![notches(-5.0)]).advance_m).sum();
        assert!(spun_m > 60.0 * notch_m && spun_m < 80.0 * notch_m, "{spun_m} m in a second of a wheel that spins on");
    }
}
