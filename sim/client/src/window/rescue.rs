//! An attempt that could not be written to disk: it stays in memory until the user saves it, here
//! or elsewhere, or discards it.

use std::path::PathBuf;

use eframe::egui::{Key, TextEdit, Ui};

use super::colours;
use crate::live::Unsaved;

/// The user's decision.
pub enum RescueWish {
    /// No decision yet.
    Wait,
    /// Save it at this path.
    Save(PathBuf),
    /// Discard it.
    ThrowAway,
}

/// An attempt that is not on disk.
pub struct Rescue {
    /// The attempt.
    pub unsaved: Box<Unsaved>,
    /// Another folder to save it in, as typed.
    folder: String,
    /// Whether the user is about to leave, and must confirm.
    leaving: bool,
}

impl Rescue {
    /// Holds an unsaved attempt.
    pub fn new(unsaved: Box<Unsaved>) -> Self {
        Self { unsaved, folder: String::new(), leaving: false }
    }

    /// Warns a user who wants to leave that the attempt would be lost.
    pub fn leave(&mut self) {
        self.leaving = true;
    }

    /// Shows one frame; returns the user's decision.
    pub fn ui(&mut self, ui: &mut Ui) -> RescueWish {
        ui.heading(tr!("The attempt is not on disk yet"));
        ui.colored_label(colours::BAD, format!("× {}: {}", self.unsaved.path().display(), self.unsaved.why));
        ui.label(tr!("The whole attempt is still in memory. Free some disk space and save it again, or save it to \
             another disk."));
        ui.add_space(8.0);
        let typing = ui.ctx().egui_wants_keyboard_input();
        let again =
            ui.button(tr!("Save again (S)")).clicked() || !typing && ui.input(|input| input.key_pressed(Key::S));
        let elsewhere = ui.horizontal(|ui| {
            let field = ui.add(TextEdit::singleline(&mut self.folder).hint_text(tr!("another folder")));
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            (ui.button(tr!("Save there")).clicked() || entered) && !self.folder.trim().is_empty()
        });
        ui.add_space(16.0);
        match (again, elsewhere.inner) {
            (true, _) => RescueWish::Save(self.unsaved.path().to_owned()),
            (false, true) => RescueWish::Save(self.elsewhere()),
            (false, false) => self.farewell(ui),
        }
    }

    fn elsewhere(&self) -> PathBuf {
        PathBuf::from(self.folder.trim()).join(self.unsaved.path().file_name().unwrap_or_default())
    }

    /// Discarding takes two clicks.
    fn farewell(&mut self, ui: &mut Ui) -> RescueWish {
        if !self.leaving {
            self.leaving = ui.button(tr!("Discard the attempt …")).clicked();
            return RescueWish::Wait;
        }
        let lost = tr!("If the attempt is not saved, it is lost permanently.");
        ui.colored_label(colours::WARN, format!("▲ {lost}"));
        let answer = ui.horizontal(|ui| {
            if ui.button(tr!("Keep it")).clicked() {
                self.leaving = false;
            }
            ui.button(tr!("Throw it away")).clicked()
        });
        if answer.inner { RescueWish::ThrowAway } else { RescueWish::Wait }
    }
}
