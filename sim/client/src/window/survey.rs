//! A survey after an attempt, next to the debrief. Each answer is saved at once; declining or
//! deleting leaves no trace.

mod question;

use std::sync::Arc;

use assessment::questionnaire::{Answer as Said, asked_pages};
use eframe::egui::{self, RichText, ScrollArea, Ui};
use phrase::Phrase;
use uuid::Uuid;
use words::Language;

use self::question::{Question, Typed};
use super::colours;
use crate::exit::Failure;
use crate::live::desk::{self, AskedSurvey, Call, DeskAnswer};
use crate::outbox::{AnswerSheet, Outbox};
use crate::station::Pairing;

/// Width of the panel, in points.
const WIDTH: f32 = 420.0;

/// A survey that is offered, open or sent.
pub struct Survey {
    asked: Arc<AskedSurvey>,
    session: Uuid,
    pairing: Pairing,
    outbox: Outbox,
    language: String,
    stage: SurveyStage,
    /// The error to show.
    error: Option<String>,
}

enum SurveyStage {
    /// Offered; the trainee has not consented.
    Offered,
    /// Open for answers.
    Open(Box<OpenAnswers>),
    /// Sent; the secret gives access to the answers.
    Sent { call: Call<Phrase>, secret: String },
}

/// Answers that are being entered.
struct OpenAnswers {
    sheet: AnswerSheet,
    /// In the order of the items.
    answers: Vec<Option<Said>>,
    /// Typed text, in the order of the items.
    typed: Vec<Typed>,
    /// Index of the page shown, among those that apply.
    step: usize,
}

/// The user's action in a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wish {
    Nothing,
    Begin,
    Save,
    Send,
    Leave,
}

impl Survey {
    /// Offers a survey after an attempt.
    pub fn new(asked: Arc<AskedSurvey>, session: Uuid, pairing: Pairing, outbox: Outbox) -> Self {
        let language = asked.instrument.language_for(words::current().code()).to_owned();
        Self { asked, session, pairing, outbox, language, stage: SurveyStage::Offered, error: None }
    }

    /// Returns the language of the panel's own text: that of the survey if the window supports it,
    /// otherwise English.
    fn spoken(&self) -> Language {
        Language::named(&self.language).unwrap_or(Language::ENGLISH)
    }

    /// Shows one frame; returns true if the user closes the panel.
    pub fn ui(&mut self, ui: &mut Ui) -> bool {
        let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(egui::Margin::symmetric(16, 8));
        let panel = egui::Panel::right("survey").resizable(false).exact_size(WIDTH).frame(frame);
        let language = self.spoken();
        let shown = panel.show(ui, |ui| {
            words::within(language, || {
                ScrollArea::vertical().show(ui, |ui| {
                    ui.add_space(12.0);
                    ui.heading(RichText::new(&self.asked.title).size(19.0));
                    let wish = match &mut self.stage {
                        SurveyStage::Offered => self.offer(ui),
                        SurveyStage::Open(_) => self.questions(ui),
                        SurveyStage::Sent { .. } => self.thanks(ui),
                    };
                    if let Some(error) = &self.error {
                        ui.colored_label(colours::BAD, format!("× {error}"));
                    }
                    wish
                })
            })
        });
        self.grant(shown.inner.inner)
    }

    fn offer(&mut self, ui: &mut Ui) -> Wish {
        let asked = Arc::clone(&self.asked);
        if asked.instrument.languages.len() > 1 {
            ui.horizontal(|ui| {
                for code in &asked.instrument.languages {
                    ui.selectable_value(&mut self.language, code.clone(), code.to_uppercase());
                }
            });
        }
        let questions = asked.instrument.items.len();
        let minutes = asked.instrument.duration_min;
        let questions = trn!("{n} question", "{n} questions", questions);
        let facts = format!("{questions} · {} min", words::decimal(&minutes.to_string()));
        ui.label(RichText::new(facts).weak());
        for line in asked.terms.get(&self.language).into_iter().flatten() {
            ui.add_space(2.0);
            ui.label(line);
        }
        ui.add_space(8.0);
        ui.horizontal_wrapped(|ui| {
            if ui.button(tr!("I agree: begin")).clicked() {
                return Wish::Begin;
            }
            if ui.button(tr!("No, thank you")).clicked() { Wish::Leave } else { Wish::Nothing }
        })
        .inner
    }

    fn questions(&mut self, ui: &mut Ui) -> Wish {
        let (asked, language) = (Arc::clone(&self.asked), self.language.clone());
        let SurveyStage::Open(open) = &mut self.stage else { return Wish::Nothing };
        let instrument = &asked.instrument;
        let pages = asked_pages(instrument, &open.answers);
        let Some((page, items)) = pages.get(open.step.min(pages.len().saturating_sub(1))) else { return Wish::Nothing };
        if let Some(section) = instrument.pages().get(*page).and_then(|(section, _)| *section) {
            ui.label(RichText::new(section.title.in_language(&language)).strong());
        }
        let mut changed = false;
        for &at in items {
            let question = Question { instrument, item: &instrument.items[at], language: &language };
            changed |= question.ui(ui, &mut open.answers[at], &mut open.typed[at]);
        }
        ui.add_space(8.0);
        let last = open.step + 1 >= pages.len();
        let wish = ui.horizontal_wrapped(|ui| {
            if open.step > 0 && ui.button(tr!("Back")).clicked() {
                open.step -= 1;
            }
            if !last && ui.button(tr!("Save and go on")).clicked() {
                open.step += 1;
            }
            let send = last && ui.button(tr!("Send my answers")).clicked();
            let leave = ui.button(tr!("Delete and stop")).clicked();
            if leave {
                Wish::Leave
            } else if send {
                Wish::Send
            } else {
                Wish::Nothing
            }
        });
        if changed && wish.inner == Wish::Nothing { Wish::Save } else { wish.inner }
    }

    fn thanks(&self, ui: &mut Ui) -> Wish {
        let SurveyStage::Sent { call, secret } = &self.stage else { return Wish::Nothing };
        ui.label(RichText::new(tr!("Thank you.")).strong());
        match desk::read(call) {
            DeskAnswer::Waiting => {
                ui.label(tr!("sending the answers …"));
                ui.ctx().request_repaint_after_secs(0.2);
            }
            DeskAnswer::Came(told) => drop(ui.colored_label(colours::GOOD, format!("● {}", words::phrase(&told)))),
            DeskAnswer::Refused(why) => drop(ui.colored_label(colours::WARN, format!("▲ {}", words::phrase(&why)))),
        }
        if self.asked.anonymous {
            ui.add_space(8.0);
            ui.label(tr!("Withdraw your answers at:"));
            ui.add(
                egui::Label::new(RichText::new(format!("{}/survey/{secret}", self.pairing.server)).monospace()).wrap(),
            );
        }
        ui.add_space(8.0);
        if ui.button(tr!("Close")).clicked() { Wish::Leave } else { Wish::Nothing }
    }

    /// Carries out the user's action; returns true if there is nothing more to show.
    fn grant(&mut self, wish: Wish) -> bool {
        let done = match wish {
            Wish::Nothing => return false,
            Wish::Begin => {
                self.begin();
                return false;
            }
            Wish::Save => self.save(),
            Wish::Send => self.send(),
            Wish::Leave => return self.forget(),
        };
        self.error = done.err().map(|failure| failure.to_string());
        false
    }

    fn begin(&mut self) {
        let items = self.asked.instrument.items.len();
        self.stage = SurveyStage::Open(Box::new(OpenAnswers {
            sheet: AnswerSheet::new(self.session, self.asked.id, &self.language),
            answers: vec![None; items],
            typed: vec![Typed::default(); items],
            step: 0,
        }));
    }

    fn save(&mut self) -> Result<(), Failure> {
        let SurveyStage::Open(open) = &mut self.stage else { return Ok(()) };
        open.write_down(&self.asked);
        self.outbox.save_draft(&open.sheet)
    }

    fn send(&mut self) -> Result<(), Failure> {
        let SurveyStage::Open(open) = &mut self.stage else { return Ok(()) };
        open.write_down(&self.asked);
        open.sheet.sent = true;
        let handed_in = desk::hand_in(&self.outbox, &open.sheet, self.pairing.clone());
        open.sheet.sent = handed_in.is_ok();
        self.stage = SurveyStage::Sent { secret: open.sheet.secret.clone(), call: handed_in? };
        Ok(())
    }

    /// Deletes the answers that were not sent; returns false if that fails.
    fn forget(&mut self) -> bool {
        let SurveyStage::Open(open) = &self.stage else { return true };
        match self.outbox.forget_draft(&open.sheet) {
            Ok(()) => {
                self.stage = SurveyStage::Offered;
                true
            }
            Err(failure) => {
                self.error = Some(failure.to_string());
                false
            }
        }
    }
}

impl OpenAnswers {
    /// Updates the sheet with the answers to the questions that apply.
    fn write_down(&mut self, asked: &AskedSurvey) {
        let asked_items = asked_pages(&asked.instrument, &self.answers).into_iter().flat_map(|(_, items)| items);
        let given =
            asked_items.filter_map(|at| Some((asked.instrument.items[at].id.clone(), self.answers[at].clone()?)));
        self.sheet.answers = given.collect();
    }
}

impl Drop for Survey {
    /// Leaving in the middle hands in the answers as not final: the trainee can complete them on
    /// their own page.
    fn drop(&mut self) {
        let SurveyStage::Open(open) = &self.stage else { return };
        if !open.sheet.answers.is_empty() {
            // The draft is on the disk: if this fails, the next start takes it up.
            let _ = desk::hand_in(&self.outbox, &open.sheet, self.pairing.clone());
        }
    }
}

#[cfg(test)]
mod tests;
