//! Sign-in at a station that has joined a school: with the code from the trainee's own page, or
//! with a guest's code of a study.

use std::sync::Arc;

use eframe::egui::{self, Align, Key, Layout, Modifiers, TextEdit, Ui};

use super::colours;
use super::consent::{ConsentDecision, ask_consent};
use super::language::WindowLanguage;
use crate::live::desk::{AskedSurvey, Call, CodeEntry, DeskAnswer, DeskReply, SignedIn, StudyTerms, read, sign_in};
use crate::station::Pairing;

/// The session of the station's user.
#[derive(Default)]
pub struct Desk {
    code: String,
    /// Whether the window has switched to the language of the signed-in user.
    greeted: bool,
    /// The code that was sent. It is sent again when a guest agrees.
    entry: CodeEntry,
    pub(super) call: Option<Call<DeskReply>>,
    /// Exercises practised since the sign-in.
    practised: Vec<String>,
}

impl Desk {
    /// Returns the signed-in user.
    pub fn signed_in(&self) -> Option<SignedIn> {
        match self.call.as_ref().map(read)? {
            DeskAnswer::Came(DeskReply::SignedIn(who)) => Some(who),
            DeskAnswer::Came(DeskReply::ConsentAsked(_)) | DeskAnswer::Waiting | DeskAnswer::Refused(_) => None,
        }
    }

    /// Returns the terms that a guest must agree to.
    fn consent_asked(&self) -> Option<StudyTerms> {
        match self.call.as_ref().map(read)? {
            DeskAnswer::Came(DeskReply::ConsentAsked(terms)) => Some(terms),
            DeskAnswer::Came(DeskReply::SignedIn(_)) | DeskAnswer::Waiting | DeskAnswer::Refused(_) => None,
        }
    }

    /// Whether a guest must agree before anything else.
    pub fn asks_consent(&self) -> bool {
        self.consent_asked().is_some()
    }

    /// Shows the consent page in place of the exercises.
    pub fn show_consent(&mut self, ui: &mut Ui, pairing: &Pairing) {
        let Some(terms) = self.consent_asked() else { return };
        match ask_consent(ui, &terms) {
            ConsentDecision::Wait => {}
            ConsentDecision::Decline => *self = Self::default(),
            ConsentDecision::Agree => {
                self.entry.agreed = Some(terms.revision);
                self.call = Some(sign_in(pairing.clone(), std::mem::take(&mut self.entry)));
            }
        }
    }

    /// Adds an attempt of the signed-in user; returns the surveys to show after it.
    pub fn note_attempt(&mut self, exercise: &str) -> Vec<Arc<AskedSurvey>> {
        let Some(who) = self.signed_in() else { return Vec::new() };
        self.practised.push(exercise.to_owned());
        who.asked_after(&self.practised)
    }

    /// Whether a sign-in is in progress.
    pub fn is_asking(&self) -> bool {
        matches!(self.call.as_ref().map(read), Some(DeskAnswer::Waiting))
    }

    /// Switches to the language of a user who has just signed in.
    fn greet(&mut self, language: &mut WindowLanguage) {
        if let Some(who) = self.signed_in().filter(|_| !self.greeted) {
            self.greeted = true;
            language.change_person(who.language());
        }
    }

    /// Shows the line at the top of the list and the briefing.
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
                    Some(DeskAnswer::Came(DeskReply::ConsentAsked(terms))) => {
                        ui.label(tr!("a guest of the study “{study}”", study = terms.study));
                    }
                    Some(DeskAnswer::Came(DeskReply::SignedIn(who))) => {
                        ui.colored_label(colours::GOOD, format!("● {}", who.display_name));
                        if ui.button(tr!("Sign out")).clicked() {
                            *self = Self::default();
                            language.change_person(None);
                        }
                    }
                    Some(DeskAnswer::Waiting) => {
                        ui.label(tr!("contacting the school …"));
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
        // Consumes the key, so that the page below does not begin an attempt.
        let entered = code.lost_focus() && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter));
        if (entered || ui.button(tr!("Sign in")).clicked()) && !self.code.trim().is_empty() {
            self.entry = CodeEntry { code: std::mem::take(&mut self.code), agreed: None };
            self.call = Some(sign_in(pairing.clone(), self.entry.clone()));
        }
        ui.label(tr!("Without it you practise anonymously."));
    }
}
