//! The settings page: the user's side, devices and their speeds, and the loudness of a pop.

use std::ops::RangeInclusive;

use eframe::egui::{self, Slider, Ui};

use super::colours;
use crate::live::open::DeviceChoice;
use crate::settings::{DEAD_ZONES, MOTIONS, SPEEDS, Settings, VOLUMES, YAWS_DEG};

/// Devices to choose from.
const DEVICES: [DeviceChoice; 5] =
    [DeviceChoice::Auto, DeviceChoice::OpenHaptics, DeviceChoice::Inverse3, DeviceChoice::Gamepad, DeviceChoice::Mouse];

/// The page, open or closed.
#[derive(Default)]
pub struct SettingsPage {
    /// Whether it is shown.
    pub open: bool,
    /// Why the settings could not be saved.
    pub refused: Option<String>,
    /// Whether the user wants to test the device at a wall.
    pub tests_wall: bool,
    /// Why the device could not be tested.
    pub untested: Option<String>,
}

impl SettingsPage {
    /// Shows the page if it is open. Changes take effect with the next attempt; all but the choice
    /// of the device are saved.
    pub fn ui(&mut self, ui: &Ui, settings: &mut Settings, device: &mut DeviceChoice) {
        let mut open = self.open;
        let before = *settings;
        egui::Window::new(tr!("Settings")).open(&mut open).collapsible(false).resizable(false).show(ui.ctx(), |ui| {
            egui::Grid::new("settings").num_columns(2).spacing([24.0, 10.0]).show(ui, |ui| {
                show_device(ui, device);
                show_side(ui, settings);
                show_sliders(ui, settings);
            });
            ui.horizontal(|ui| {
                let feel = ui.button(tr!("Feel a wall"));
                let feel = feel.on_hover_text(tr!("Press the device against a virtual wall and compare the force"));
                self.tests_wall = feel.clicked();
                if ui.button(tr!("Restore defaults")).clicked() {
                    *settings = Settings::default();
                }
            });
            if let Some(why) = &self.untested {
                ui.colored_label(colours::BAD, format!("× {why}"));
            }
            if let Some(why) = &self.refused {
                ui.colored_label(colours::BAD, format!("× {}", tr!("not saved: {why}", why = why)));
            }
        });
        self.open = open;
        if *settings != before {
            self.refused = settings.save().err().map(|failure| failure.to_string());
        }
    }
}

fn show_device(ui: &mut Ui, device: &mut DeviceChoice) {
    ui.label(tr!("Device"));
    egui::ComboBox::from_id_salt("device").selected_text(words::phrase(&device.phrase())).width(300.0).show_ui(
        ui,
        |ui| {
            for choice in DEVICES {
                let name = words::phrase(&choice.phrase());
                ui.selectable_value(device, choice, name);
            }
        },
    );
    ui.end_row();
}

fn show_side(ui: &mut Ui, settings: &mut Settings) {
    ui.label(tr!("Your position"));
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.other_side, false, tr!("on the usual side"));
        ui.selectable_value(&mut settings.other_side, true, tr!("on the opposite side"));
    });
    ui.end_row();
}

fn show_sliders(ui: &mut Ui, settings: &mut Settings) {
    let Settings { device_yaw_deg, motion, pointer_speed, stick_speed, stick_dead_zone, volume, .. } = settings;
    slider(ui, tr!("Device rotated to the left"), Slider::new(device_yaw_deg, YAWS_DEG).suffix("°").step_by(5.0));
    slider(ui, tr!("Needle travel per handle travel"), share(motion, MOTIONS));
    slider(ui, tr!("Speed of mouse and keys"), share(pointer_speed, SPEEDS).logarithmic(true));
    slider(ui, tr!("Speed of the sticks"), share(stick_speed, SPEEDS).logarithmic(true));
    slider(ui, tr!("Dead zone of the sticks"), share(stick_dead_zone, DEAD_ZONES));
    slider(ui, tr!("Volume of pops"), share(volume, VOLUMES));
}

fn slider(ui: &mut Ui, name: &str, slider: Slider<'_>) {
    let label = ui.label(name);
    ui.add(slider).labelled_by(label.id);
    ui.end_row();
}

/// A slider in percent.
fn share(value: &mut f64, allowed: RangeInclusive<f64>) -> Slider<'_> {
    Slider::new(value, allowed)
        .custom_formatter(|share, _| format!("{:.0} %", 100.0 * share))
        .custom_parser(|text| text.trim_end_matches('%').trim().parse::<f64>().ok().map(|percent| percent / 100.0))
}
