//! An attempt that the disk has refused: it stays in memory until it is saved, here or elsewhere, or thrown away on purpose.

use std::path::PathBuf;

use eframe::egui::{Key, TextEdit, Ui};

use super::colours;
use crate::live::Unsaved;

/// What the person does about it.
pub enum RescueWish {
    /// Nothing yet.
    Wait,
    /// Save it there.
    Save(PathBuf),
    /// Throw it away.
    ThrowAway,
}

/// An attempt that is not on disk.
pub struct Rescue {
    /// The attempt.
    pub unsaved: Box<Unsaved>,
    /// Another folder to save it in, as it is typed.
    folder: String,
    /// The person is about to leave it, and is asked back.
    leaving: bool,
}

impl Rescue {
    /// Keeps an attempt.
    pub fn new(unsaved: Box<Unsaved>) -> Self {
        Self { unsaved, folder: String::new(), leaving: false }
    }

    /// The person wants to go: they are told what that would cost.
    pub fn leave(&mut self) {
        self.leaving = true;
    }

    /// One frame.
    pub fn ui(&mut self, ui: &mut Ui) -> RescueWish {
        ui.heading(tr!("The attempt is not on disk yet"));
        ui.colored_label(colours::BAD, format!("× {}: {}", self.unsaved.path().display(), self.unsaved.why));
        ui.label(tr!("All of it is in memory. Make room on the disk and save it again, or save it on another disk."));
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

    /// Throwing away takes two presses.
    fn farewell(&mut self, ui: &mut Ui) -> RescueWish {
        if !self.leaving {
            self.leaving = ui.button(tr!("Throw the attempt away …")).clicked();
            return RescueWish::Wait;
        }
        let lost = tr!("Without being saved the attempt is lost for good.");
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
