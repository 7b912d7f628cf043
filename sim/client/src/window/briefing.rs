//! The briefing of the chosen exercise, and the preparation of its attempt.

use documents::Exercise;
use eframe::egui::{self, Align, Key, Layout, ProgressBar, RichText, ScrollArea, Ui};
use words::fixed;

use super::choose::{own_words, reading_page, show_heading};
use super::language::WindowLanguage;
use super::pictures::BriefingPictures;
use super::{colours, help};

/// The user's decision on the briefing.
pub enum Decision {
    /// No decision yet.
    Stay,
    /// Begin the attempt.
    Begin,
    /// Choose another exercise.
    Back,
}

/// The content of the briefing.
pub struct Briefing<'a> {
    /// The exercise.
    pub exercise: &'a Exercise,
    /// Its pictures.
    pub pictures: &'a mut BriefingPictures,
    /// Description of the device.
    pub device: &'a str,
    /// Whether mouse and keyboard move the needle, unless a haptic device or a gamepad is found.
    pub by_hand: bool,
    /// Whether to show the planned line, entry and target.
    pub guided: &'a mut bool,
    /// Whether the attempt may begin: no sign-in is in progress.
    pub ready: bool,
    /// Why the attempt cannot begin.
    pub error: Option<&'a str>,
    /// Language of the window.
    pub language: &'a mut WindowLanguage,
}

/// Shows the briefing; returns the user's decision.
pub fn show_briefing(ui: &mut Ui, briefing: Briefing<'_>) -> Decision {
    let Briefing { exercise, pictures, device, by_hand, guided, ready, error, language } = briefing;
    let decision = egui::Panel::bottom("begin").show(ui, |ui| {
        ui.add_space(8.0);
        let decision = ui.horizontal_wrapped(|ui| {
            let begin =
                egui::Button::new(RichText::new(tr!("Begin (Enter)")).size(18.0)).min_size([160.0, 36.0].into());
            let pressed = |ui: &Ui, key| ui.input(|input| input.key_pressed(key));
            let begin = ui.add_enabled(ready, begin).clicked() || ready && pressed(ui, Key::Enter);
            let back = ui.button(tr!("Another exercise (Esc)")).clicked() || pressed(ui, Key::Escape);
            ui.checkbox(guided, tr!("Guided: show the planned line, entry and target"));
            match (begin, back) {
                (true, _) => Decision::Begin,
                (false, true) => Decision::Back,
                (false, false) => Decision::Stay,
            }
        });
        ui.add_space(8.0);
        decision.inner
    });
    egui::CentralPanel::default().frame(reading_page(ui)).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            show_heading(ui, own_words(&exercise.title), |ui| language.ui(ui));
            ui.add_space(8.0);
            let beside = ui.available_width() >= BESIDE;
            let layout = if beside { Layout::left_to_right(Align::TOP) } else { Layout::top_down(Align::LEFT) };
            ui.with_layout(layout, |ui| {
                reading_column(ui, |ui| {
                    ui.label(RichText::new(own_words(&exercise.briefing)).size(16.5).line_height(Some(24.0)));
                    pictures.show(ui);
                    if let Some(error) = error {
                        ui.add_space(8.0);
                        ui.colored_label(colours::BAD, format!("× {error}"));
                    }
                });
                ui.add_space(if beside { 40.0 } else { 12.0 });
                reading_column(ui, |ui| {
                    show_exercise_facts(ui, exercise, device);
                    ui.add_space(12.0);
                    help::how_to_move(ui, by_hand);
                });
            });
        });
    });
    decision.inner
}

/// Width of the briefing's text, and of the facts next to it, in points; and the least width at
/// which both fit side by side.
const COLUMN: f32 = 540.0;
const BESIDE: f32 = 2.0 * COLUMN + 60.0;

fn reading_column(ui: &mut Ui, show: impl FnOnce(&mut Ui)) {
    ui.vertical(|ui| {
        ui.set_width(COLUMN);
        show(ui);
    });
}

/// Shows that an attempt is being prepared, with the completed fraction if that takes long.
pub fn show_preparing(ui: &mut Ui, share: Option<f32>) {
    egui::CentralPanel::default().show(ui, |ui| {
        ui.vertical_centered(|ui| {
            ui.add_space(0.45 * ui.available_height());
            ui.label(RichText::new(tr!("Preparing the patient …")).size(22.0));
            if let Some(share) = share {
                ui.add_space(14.0);
                ui.add(ProgressBar::new(share).animate(true).desired_width(260.0));
            }
        });
    });
}

fn show_exercise_facts(ui: &mut Ui, exercise: &Exercise, device: &str) {
    let [right, away] = exercise.entry_mm.map(|mm| fixed(mm, 0));
    let facts = [
        (tr!("Target"), tr!("{depth} mm along the needle", depth = fixed(exercise.target_depth_mm, 1))),
        (
            tr!("Entry"),
            tr!(
                "{right} mm right, {away} mm away, {angle}° from the skin's normal",
                right = right,
                away = away,
                angle = fixed(exercise.angle_deg, 0)
            ),
        ),
        (tr!("Time"), format!("{} s", fixed(exercise.time_limit_s, 0))),
        (tr!("Pass mark"), tr!("{mark} of 100 points", mark = fixed(exercise.pass_mark, 0))),
        (tr!("Feedback"), words::say(exercise.feedback.in_words()).to_owned()),
        (tr!("Device"), device.to_owned()),
    ];
    egui::Grid::new("facts").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
        for (name, fact) in facts {
            ui.label(RichText::new(name).strong());
            ui.add(egui::Label::new(fact).wrap());
            ui.end_row();
        }
    });
}
