//! Signing in at a station that has joined a school, by the code from one's own page, or a guest's of a study.

use std::sync::Arc;

use eframe::egui::{self, Align, Key, Layout, Modifiers, TextEdit, Ui};

use super::colours;
use super::consent::{ConsentDecision, ask_consent};
use super::language::WindowLanguage;
use crate::live::desk::{AskedSurvey, Call, CodeEntry, DeskAnswer, DeskReply, SignedIn, StudyTerms, read, sign_in};
use crate::station::Pairing;

/// Who sits here.
#[derive(Default)]
pub struct Desk {
    code: String,
    /// The window speaks the language of whoever has signed in.
    greeted: bool,
    /// What was typed and is asked about: a guest who agrees is asked about once more.
    entry: CodeEntry,
    pub(super) call: Option<Call<DeskReply>>,
    /// The exercises that they have practised since.
    practised: Vec<String>,
}

impl Desk {
    /// Who has signed in.
    pub fn signed_in(&self) -> Option<SignedIn> {
        match self.call.as_ref().map(read)? {
            DeskAnswer::Came(DeskReply::SignedIn(who)) => Some(who),
            DeskAnswer::Came(DeskReply::ConsentAsked(_)) | DeskAnswer::Waiting | DeskAnswer::Refused(_) => None,
        }
    }

    /// What a guest is asked to agree to.
    fn consent_asked(&self) -> Option<StudyTerms> {
        match self.call.as_ref().map(read)? {
            DeskAnswer::Came(DeskReply::ConsentAsked(terms)) => Some(terms),
            DeskAnswer::Came(DeskReply::SignedIn(_)) | DeskAnswer::Waiting | DeskAnswer::Refused(_) => None,
        }
    }

    /// A guest has to agree before anything else.
    pub fn asks_consent(&self) -> bool {
        self.consent_asked().is_some()
    }

    /// What a guest is asked, in place of the exercises.
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
            self.entry = CodeEntry { code: std::mem::take(&mut self.code), agreed: None };
            self.call = Some(sign_in(pairing.clone(), self.entry.clone()));
        }
        ui.label(tr!("Without it you practise unnamed."));
    }
}
