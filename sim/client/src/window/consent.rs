//! The consent page of a guest: the consent text of the study, and the use of the data.

use eframe::egui::{self, RichText, ScrollArea, Ui};

use crate::live::desk::StudyTerms;

/// A guest's decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsentDecision {
    /// No decision yet.
    Wait,
    /// The guest takes part.
    Agree,
    /// The guest declines: nothing is stored, and the code remains valid.
    Decline,
}

/// Width of the text, in points.
const COLUMN: f32 = 640.0;

/// Shows the consent page in place of the exercises; returns the guest's decision.
pub fn ask_consent(ui: &mut Ui, terms: &StudyTerms) -> ConsentDecision {
    let decision = egui::Panel::bottom("consent").show(ui, |ui| {
        ui.add_space(8.0);
        let decision = ui.horizontal_wrapped(|ui| {
            let agree = egui::Button::new(RichText::new(tr!("I agree to take part")).size(18.0));
            let agrees = ui.add(agree.min_size([160.0, 36.0].into())).clicked();
            let declines = ui.button(tr!("No, thank you")).clicked();
            match (agrees, declines) {
                (true, _) => ConsentDecision::Agree,
                (false, true) => ConsentDecision::Decline,
                (false, false) => ConsentDecision::Wait,
            }
        });
        ui.add_space(8.0);
        decision.inner
    });
    let page = egui::Frame::central_panel(ui.style()).inner_margin(egui::Margin::symmetric(48, 32));
    egui::CentralPanel::default().frame(page).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.set_max_width(COLUMN);
            show_terms(ui, terms);
        });
    });
    decision.inner
}

fn show_terms(ui: &mut Ui, terms: &StudyTerms) {
    ui.heading(&terms.study);
    ui.add_space(8.0);
    ui.label(RichText::new(tr!("What you agree to")).strong());
    for line in terms.consent.lines() {
        ui.label(RichText::new(line).size(16.5).line_height(Some(24.0)));
    }
    ui.add_space(12.0);
    ui.label(RichText::new(tr!("Data that are stored")).strong());
    ui.label(tr!(
        "Your movements, the forces and times of each attempt, and your answers afterwards, under a pseudonym. Your \
         name is not stored."
    ));
    ui.label(tr!("The recordings also stay on this computer until its administrator deletes them."));
    ui.add_space(12.0);
    let kept = trn!("{n} month after the study has ended", "{n} months after the study has ended", terms.kept_months);
    let facts = [
        (tr!("Answers for the data"), terms.controller.as_str()),
        (tr!("Contact"), terms.contact.as_str()),
        (tr!("Data are kept"), kept.as_str()),
    ];
    egui::Grid::new("terms").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
        for (name, fact) in facts {
            ui.label(RichText::new(name).strong());
            ui.add(egui::Label::new(fact).wrap());
            ui.end_row();
        }
    });
    ui.add_space(12.0);
    ui.label(tr!("If you do not agree, nothing is stored here and your code remains valid."));
}
