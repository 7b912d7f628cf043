//! Signing in at a station that has joined a school, by the code from one's own page, or a guest's of a study.

use std::sync::Arc;

use eframe::egui::{self, Align, Key, Layout, Modifiers, TextEdit, Ui};

use super::colours;
use super::language::WindowLanguage;
use crate::live::desk::{AskedSurvey, Call, DeskAnswer, SignedIn, read, sign_in};
use crate::station::Pairing;

/// Who sits here.
#[derive(Default)]
pub struct Desk {
    code: String,
    /// The window speaks the language of whoever has signed in.
    greeted: bool,
    pub(super) call: Option<Call<SignedIn>>,
    /// The exercises that they have practised since.
    practised: Vec<String>,
}

impl Desk {
    /// Who has signed in.
    pub fn signed_in(&self) -> Option<SignedIn> {
        match self.call.as_ref().map(read)? {
            DeskAnswer::Came(who) => Some(who),
            DeskAnswer::Waiting | DeskAnswer::Refused(_) => None,
        }
    }

    /// Notes an attempt of whoever sits here; says what is asked after it.
    pub fn note_attempt(&mut self, exercise: &str) -> Vec<Arc<AskedSurvey>> {
        let Some(who) = self.signed_in() else { return Vec::new() };
        self.practised.push(exercise.to_owned());
        who.asked_after(&self.practised)
    }

    /// The school is being asked who this is.
    pub fn is_asking(&self) -> bool {
        matches!(self.call.as_ref().map(read), Some(DeskAnswer::Waiting))
    }

    /// Speaks the language of whoever has just signed in.
    fn greet(&mut self, language: &mut WindowLanguage) {
        if let Some(who) = self.signed_in().filter(|_| !self.greeted) {
            self.greeted = true;
            language.change_person(who.language());
        }
    }

    /// The line at the top of the choice and the briefing.
    pub fn ui(&mut self, ui: &mut Ui, pairing: &Pairing, language: &mut WindowLanguage) {
        self.greet(language);
        let panel = egui::Panel::top("desk");
        panel.show(ui, |ui| {
            ui.add_space(6.0);
            let line = egui::vec2(ui.available_width(), 32.0);
            ui.allocate_ui_with_layout(line, Layout::left_to_right(Align::Center), |ui| {
                ui.label(tr!("{station} at {school}", station = pairing.name, school = pairing.school));
                ui.separator();
                match self.call.as_ref().map(read) {
                    Some(DeskAnswer::Came(who)) => {
                        ui.colored_label(colours::GOOD, format!("● {}", who.display_name));
                        if ui.button(tr!("Sign out")).clicked() {
                            *self = Self::default();
                            language.change_person(None);
                        }
                    }
                    Some(DeskAnswer::Waiting) => {
                        ui.label(tr!("asking the school …"));
                        ui.ctx().request_repaint_after_secs(0.1);
                    }
                    Some(DeskAnswer::Refused(_)) | None => self.ask(ui, pairing),
                }
            });
            if let Some(DeskAnswer::Refused(why)) = self.call.as_ref().map(read) {
                ui.colored_label(colours::BAD, format!("× {}", tr!("not signed in: {why}", why = words::phrase(&why))));
            }
            ui.add_space(6.0);
        });
    }

    fn ask(&mut self, ui: &mut Ui, pairing: &Pairing) {
        let code = ui.add(TextEdit::singleline(&mut self.code).hint_text(tr!("your sign-in code")).password(true));
        // The key is taken: the page below must not begin an attempt by it.
        let entered = code.lost_focus() && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter));
        if (entered || ui.button(tr!("Sign in")).clicked()) && !self.code.trim().is_empty() {
            self.call = Some(sign_in(pairing.clone(), std::mem::take(&mut self.code)));
        }
        ui.label(tr!("Without it you practise unnamed."));
    }
}
