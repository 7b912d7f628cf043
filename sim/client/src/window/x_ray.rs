//! The monitor and the controls of a C-arm.

use std::sync::Arc;

use eframe::egui::{self, Color32, ColorImage, Key, RichText, Slider, TextureHandle, TextureOptions, Ui, Vec2};
use guidance::PIXELS;
use guidance::c_arm::{FIELD_M, ORBITAL_DEG, TILT_DEG};
use recording::CArmControls;
use words::fixed;

use super::colours;
use crate::live::x_ray::{LiveArm, Monitor, XRayPicture};

/// Width of the panel, in points.
const SIDE: f32 = 300.0;
/// Speed of the C-arm's rotation by keys, in rad/s.
const TURN_RAD_PER_S: f64 = 0.5;
/// Step of the collimator by a key, in m.
const FIELD_STEP_M: f64 = 0.01;
/// Contrast medium of an injection, and the most in all, in ml.
const INJECTION_ML: f64 = 5.0;
const MOST_CONTRAST_ML: f64 = 20.0;
/// Age from which a picture is marked as an old one, in s.
const OLD_S: f64 = 0.5;

/// The monitor of a C-arm, with the pictures on the graphics adapter.
#[derive(Default)]
pub struct XRayPanel {
    shown: Vec<(u32, TextureHandle)>,
}

impl XRayPanel {
    /// Shows the monitor and the controls at the left, and sets the controls.
    pub fn ui(&mut self, ui: &mut Ui, arm: &LiveArm, now_s: f64) {
        let monitor = arm.radiographer.monitor().clone();
        side_panel().show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                ui.add_space(8.0);
                self.show_monitor(ui, &monitor, now_s);
                show_dose(ui, &monitor, arm.pulses_per_s);
                self.show_saved(ui, &monitor);
                ui.separator();
                arm.set(show_controls(ui, arm.controls()));
            });
        });
    }

    /// Shows the monitor of a replay at a time in s, at the left.
    pub fn replay_ui(&mut self, ui: &mut Ui, monitor: &Monitor, now_s: f64) {
        side_panel().show(ui, |ui| {
            ui.add_space(8.0);
            self.show_monitor(ui, monitor, now_s);
        });
        if monitor.latest.as_ref().map(|picture| picture.pulse) != monitor.last_pulse {
            ui.ctx().request_repaint();
        }
    }

    /// Shows the last picture with its age at a time in s.
    fn show_monitor(&mut self, ui: &mut Ui, monitor: &Monitor, now_s: f64) {
        let edge = ui.available_width();
        let Some(picture) = &monitor.latest else {
            let (place, _) = ui.allocate_exact_size(Vec2::splat(edge), egui::Sense::hover());
            ui.painter().rect_filled(place, 0.0, Color32::BLACK);
            let text = tr!("no picture yet");
            ui.painter().text(
                place.center(),
                egui::Align2::CENTER_CENTER,
                text,
                egui::FontId::proportional(14.0),
                Color32::GRAY,
            );
            return;
        };
        let texture = self.texture(ui, picture);
        ui.add(egui::Image::new((texture, Vec2::splat(edge))));
        let age_s = now_s - picture.pulse.t_s;
        let view = say_view(&picture.controls);
        if age_s > OLD_S {
            let held = tr!("last picture, {age} s old", age = fixed(age_s, 0));
            ui.label(RichText::new(format!("{view} · {held}")).weak());
        } else {
            ui.colored_label(colours::WARN, format!("● {view}"));
        }
    }

    fn show_saved(&mut self, ui: &mut Ui, monitor: &Monitor) {
        if monitor.saved.is_empty() {
            return;
        }
        ui.horizontal(|ui| {
            for picture in &monitor.saved {
                let texture = self.texture(ui, picture);
                let hint = say_view(&picture.controls);
                ui.add(egui::Image::new((texture, Vec2::splat(84.0)))).on_hover_text(hint);
            }
        });
    }

    /// Returns the texture of a picture; those of pictures that are no longer shown are freed.
    fn texture(&mut self, ui: &Ui, picture: &Arc<XRayPicture>) -> egui::TextureId {
        /// The last picture, the saved ones, and one more.
        const MOST: usize = 6;
        let index = picture.pulse.index;
        if let Some((_, texture)) = self.shown.iter().find(|(shown, _)| *shown == index) {
            return texture.id();
        }
        let image = ColorImage::from_gray([PIXELS, PIXELS], &picture.greys);
        let texture = ui.ctx().load_texture("x-ray", image, TextureOptions::LINEAR);
        let id = texture.id();
        self.shown.insert(0, (index, texture));
        self.shown.truncate(MOST);
        id
    }
}

fn side_panel() -> egui::Panel {
    egui::Panel::left("x-ray").exact_size(SIDE).resizable(false)
}

/// Describes a position of the C-arm.
fn say_view(controls: &CArmControls) -> String {
    let [orbital, tilt] = [controls.orbital_rad, controls.tilt_rad].map(|angle| fixed(angle.to_degrees(), 0));
    tr!("orbital {orbital}°, tilt {tilt}°", orbital = orbital, tilt = tilt)
}

fn show_dose(ui: &mut Ui, monitor: &Monitor, pulses_per_s: f64) {
    let time_s = f64::from(monitor.pedal_pulses) / pulses_per_s;
    let (kerma_mgy, area_gycm2) =
        monitor.last_pulse.map_or((0.0, 0.0), |pulse| (pulse.kerma_mgy, pulse.kerma_area_gycm2));
    let dose = tr!(
        "{time} s · {kerma} mGy · {area} Gy·cm²",
        time = fixed(time_s, 1),
        kerma = fixed(kerma_mgy, 2),
        area = fixed(area_gycm2, 3)
    );
    ui.label(RichText::new(dose).strong());
}

/// Shows the controls; returns the new ones.
fn show_controls(ui: &mut Ui, controls: CArmControls) -> CArmControls {
    let mut new = controls;
    let pedal = ui.add_sized([ui.available_width(), 28.0], egui::Button::new(tr!("X-rays while held (F)")));
    new.pedal = pedal.is_pointer_button_down_on() || ui.input(|input| input.key_down(Key::F));
    ui.horizontal(|ui| {
        if ui.button(tr!("Single shot (X)")).clicked() || ui.input(|input| input.key_pressed(Key::X)) {
            new.shots += 1;
        }
        let contrast = ui.add_enabled(
            new.contrast_ml < MOST_CONTRAST_ML,
            egui::Button::new(tr!("{volume} ml contrast (C)", volume = fixed(INJECTION_ML, 0))),
        );
        if contrast.clicked() || ui.input(|input| input.key_pressed(Key::C)) {
            new.contrast_ml = (new.contrast_ml + INJECTION_ML).min(MOST_CONTRAST_ML);
        }
    });
    turn_by_keys(ui, &mut new);
    ui.spacing_mut().slider_width = 110.0;
    let [mut orbital_deg, mut tilt_deg] = [new.orbital_rad, new.tilt_rad].map(|angle| angle.to_degrees());
    let mut field_mm = new.field_m * 1e3;
    let slide = |ui: &mut Ui, value: &mut f64, [least, most]: [f64; 2], unit: &str, name: &str| {
        let slider = Slider::new(value, least..=most).suffix(unit).text(name);
        let slider = slider.custom_formatter(|value, _| fixed(value, 0));
        ui.add(slider.custom_parser(|typed| typed.trim().replace(',', ".").parse().ok())).changed()
    };
    if slide(ui, &mut orbital_deg, ORBITAL_DEG, "°", tr!("orbital (← →)")) {
        new.orbital_rad = orbital_deg.to_radians();
    }
    if slide(ui, &mut tilt_deg, TILT_DEG, "°", tr!("tilt (page ↑ ↓)")) {
        new.tilt_rad = tilt_deg.to_radians();
    }
    if slide(ui, &mut field_mm, FIELD_M.map(|edge| edge * 1e3), " mm", tr!("field ([ ])")) {
        new.field_m = field_mm * 1e-3;
    }
    new
}

/// Turns the C-arm and moves the collimator by keys.
fn turn_by_keys(ui: &Ui, controls: &mut CArmControls) {
    ui.input(|input| {
        let turned = TURN_RAD_PER_S * f64::from(input.stable_dt.min(0.1));
        let held = |more, less| f64::from(u8::from(input.key_down(more))) - f64::from(u8::from(input.key_down(less)));
        let tapped =
            |more, less| f64::from(u8::from(input.key_pressed(more))) - f64::from(u8::from(input.key_pressed(less)));
        let within = |value: f64, [least, most]: [f64; 2]| value.clamp(least.to_radians(), most.to_radians());
        controls.orbital_rad =
            within(controls.orbital_rad + turned * held(Key::ArrowRight, Key::ArrowLeft), ORBITAL_DEG);
        controls.tilt_rad = within(controls.tilt_rad + turned * held(Key::PageUp, Key::PageDown), TILT_DEG);
        let field_m = controls.field_m + FIELD_STEP_M * tapped(Key::CloseBracket, Key::OpenBracket);
        controls.field_m = field_m.clamp(FIELD_M[0], FIELD_M[1]);
    });
}
