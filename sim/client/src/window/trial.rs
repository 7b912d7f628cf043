//! The attempt: picture in the middle, what is felt and said beside it.

use std::sync::Arc;

use eframe::egui::{self, Key, PointerButton, Response, Ui};
use render::frame::View;

use super::canvas::Canvas;
use super::overlay::{self, Instruments};
use super::sound::Sound;
use super::steer::{Steering, Wish};
use crate::live::open::Steered;
use crate::live::{self, Finished, Live, Phase};
use crate::picture::Look;

/// Speed of the needle under the arrow keys, in m/s; with shift a quarter of it.
const KEY_M_PER_S: f64 = 0.006;
/// Lean under the keys, in rad/s.
const KEY_RAD_PER_S: f64 = 0.25;
/// Way of the needle under a drag or the wheel, in m per point.
const DRAG_M: f64 = 0.000_08;
/// Turn of the picture under a drag, in rad per point.
const ORBIT_RAD: f32 = 0.006;

/// An attempt on the screen.
pub struct Trial {
    live: Live,
    steering: Steering,
    steered: Steered,
    /// Why other devices were passed over.
    passed_over: Vec<String>,
    look: Look,
    sound: Sound,
    pops_heard: u64,
}

/// What is to happen next.
pub enum Next {
    /// Go on.
    Stay,
    /// The attempt is over.
    Over,
}

impl Trial {
    /// Shows an attempt, and what moves its device.
    pub fn new(live: Live, (steered, passed_over): (Steered, Vec<String>), guided: bool) -> Self {
        let steering = Steering::new(&live.trial.bundle.exercise);
        let bundle = &live.trial.bundle;
        let look = Look { closed: !bundle.exercise.feedback.inside(), ..Look::at(&bundle.scene, guided) };
        Self { live, steering, steered, passed_over, look, sound: Sound::open(), pops_heard: 0 }
    }

    /// One frame.
    pub fn ui(&mut self, ui: &mut Ui, canvas: &mut Canvas) -> Next {
        ui.ctx().request_repaint();
        let latest = self.live.latest().cloned();
        let shown = self.live.shown().clone();
        let exercise = &self.live.trial.bundle.exercise;
        let overlay = exercise.feedback.overlay();
        if shown.pops > self.pops_heard {
            self.sound.pop();
            self.pops_heard = shown.pops;
        }
        let instruments = Instruments {
            shown: &shown,
            latest: latest.as_ref(),
            live: &self.live,
            quality: canvas.quality(),
            passed_over: &self.passed_over,
        };
        let over = overlay::side(ui, &instruments, &mut self.sound);
        overlay::messages(ui, &shown);
        let frame = shown.moment.frame(&self.look, exercise.target_depth_mm * 1e-3);
        let picture = egui::CentralPanel::no_frame().show(ui, |ui| {
            let picture = canvas.show(ui, &frame);
            overlay::heading(ui, picture.rect, &instruments);
            if overlay && self.look.view == View::Section {
                overlay::bands(ui, picture.rect, &canvas.camera(&frame), &self.live.trial);
            }
            picture
        });
        self.control(ui, &picture.inner);
        let ended = self.live.servo().ended().is_some() || matches!(shown.phase, Phase::Withdrawn | Phase::TimeUp);
        if over || ended { Next::Over } else { Next::Stay }
    }

    /// Ends the attempt with zero force on the device.
    pub fn stop(self) -> (Arc<live::Trial>, Finished) {
        self.live.stop()
    }

    fn control(&mut self, ui: &Ui, picture: &Response) {
        look(ui, picture, &mut self.look);
        if let Steered::Window(aim) = &mut self.steered {
            aim.write(self.steering.follow(&wish(ui, picture)));
        }
    }
}

/// Views by number, guide, and the person's own turn of the picture with the right button.
pub fn look(ui: &Ui, picture: &Response, look: &mut Look) {
    ui.input(|input| {
        let views = [(Key::Num1, View::Whole), (Key::Num2, View::Tip), (Key::Num3, View::Section)];
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

/// What the person asks of a virtual hand in this frame.
fn wish(ui: &Ui, picture: &Response) -> Wish {
    let drag = if picture.dragged_by(PointerButton::Primary) { picture.drag_delta() } else { Default::default() };
    ui.input(|input| {
        let dt_s = f64::from(input.stable_dt.min(0.1));
        let held = |key| f64::from(u8::from(input.key_down(key)));
        let slow = if input.modifiers.shift { 0.25 } else { 1.0 };
        let keys_m = slow * KEY_M_PER_S * dt_s;
        let wheel = if picture.hovered() && !input.modifiers.command { input.smooth_scroll_delta().y } else { 0.0 };
        let aside = input.modifiers.shift && drag != egui::Vec2::ZERO;
        let along = if aside { 0.0 } else { f64::from(drag.y - wheel) * DRAG_M };
        let across = if aside { [f64::from(drag.x) * DRAG_M, -f64::from(drag.y) * DRAG_M] } else { [0.0; 2] };
        Wish {
            advance_m: along + (held(Key::ArrowDown) - held(Key::ArrowUp)) * keys_m,
            aside_m: [
                across[0] + (held(Key::D) - held(Key::A)) * keys_m,
                across[1] + (held(Key::W) - held(Key::S)) * keys_m,
            ],
            lean_rad: [
                (held(Key::L) - held(Key::J)) * slow * KEY_RAD_PER_S * dt_s,
                (held(Key::I) - held(Key::K)) * slow * KEY_RAD_PER_S * dt_s,
            ],
            confirm: input.key_down(Key::Space),
        }
    })
}
