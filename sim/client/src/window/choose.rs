//! Before an attempt: the exercises there are, and the briefing of the one that is chosen.

use eframe::egui::{self, Color32, Key, RichText, ScrollArea, Ui};
use scene::{Exercise, ExerciseBundle};
use time::OffsetDateTime;
use time::macros::format_description;

use super::colours;
use crate::clock;
use crate::live::desk::Listed;

/// What the person decides on the briefing.
pub enum Decision {
    /// Nothing yet.
    Stay,
    /// Begin.
    Begin,
    /// Another exercise.
    Back,
}

/// A page to read, with margins.
fn page(ui: &Ui) -> egui::Frame {
    egui::Frame::central_panel(ui.style()).inner_margin(egui::Margin::symmetric(48, 32))
}

/// The list of exercises, with what is due for whoever sits here. Answers the one that is chosen.
pub fn choose(ui: &mut Ui, exercises: &[ExerciseBundle], due: &[Listed]) -> Option<usize> {
    let chosen = egui::CentralPanel::default().frame(page(ui)).show(ui, |ui| {
        ui.heading("Exercises");
        ui.add_space(8.0);
        let mut order: Vec<usize> = (0..exercises.len()).collect();
        // Assigned ones first, in the order in which they are due; the others as they were given.
        let place = |at: &usize| {
            let id = exercises.get(*at).map(|bundle| bundle.exercise.id.as_str());
            due.iter().position(|due| Some(due.exercise_id.as_str()) == id).unwrap_or(usize::MAX)
        };
        order.sort_by_key(place);
        let scrolled = ScrollArea::vertical().show(ui, |ui| {
            let rows = order.iter().filter_map(|&at| exercises.get(at).map(|bundle| (at, &bundle.exercise)));
            let listed = |exercise: &Exercise| due.iter().find(|due| due.exercise_id == exercise.id);
            rows.filter_map(|(at, exercise)| row(ui, exercise, listed(exercise)).then_some(at)).last()
        });
        scrolled.inner
    });
    chosen.inner
}

fn row(ui: &mut Ui, exercise: &Exercise, due: Option<&Listed>) -> bool {
    let clicked = ui.horizontal(|ui| {
        let clicked =
            ui.add(egui::Button::new(RichText::new(&exercise.title).size(17.0)).min_size([320.0, 34.0].into()));
        let stars =
            "●".repeat(exercise.difficulty.into()) + &"○".repeat(5_usize.saturating_sub(exercise.difficulty.into()));
        ui.label(stars).on_hover_text("Difficulty");
        ui.label(format!("target {:.0} mm, {:.0}°", exercise.target_depth_mm, exercise.angle_deg));
        if let Some(due) = due {
            let (colour, words) = when(due, clock::now());
            ui.colored_label(colour, words);
        }
        clicked.clicked()
    });
    clicked.inner
}

/// Until when an exercise is to be done, in words. Where nobody has set a day it is simply next.
fn when(due: &Listed, now: OffsetDateTime) -> (Color32, String) {
    let Some(at) = due.due_at() else { return (colours::WARN, "→ to do".to_owned()) };
    let format = format_description!("[day padding:none] [month repr:short] [year], [hour]:[minute]");
    let day = at.format(format).unwrap_or_default();
    if at < now { (colours::BAD, format!("× was due {day}")) } else { (colours::WARN, format!("→ due {day}")) }
}

/// What is said before an attempt, and what the person may decide.
pub struct Briefing<'a> {
    /// The exercise.
    pub exercise: &'a Exercise,
    /// What will happen with the device, in words.
    pub device: &'a str,
    /// Draw the planned line.
    pub guided: &'a mut bool,
    /// The attempt may begin: who makes it is known.
    pub ready: bool,
    /// Why the attempt cannot begin.
    pub error: Option<&'a str>,
}

/// The briefing.
pub fn brief(ui: &mut Ui, briefing: Briefing<'_>) -> Decision {
    let Briefing { exercise, device, guided, ready, error } = briefing;
    let decision = egui::Panel::bottom("begin").show(ui, |ui| {
        ui.add_space(8.0);
        let decision = ui.horizontal(|ui| {
            let begin = egui::Button::new(RichText::new("Begin (Enter)").size(18.0)).min_size([160.0, 36.0].into());
            let entered = ready && ui.input(|input| input.key_pressed(Key::Enter));
            if ui.add_enabled(ready, begin).clicked() || entered {
                return Decision::Begin;
            }
            if ui.button("Another exercise (Esc)").clicked() || ui.input(|input| input.key_pressed(Key::Escape)) {
                return Decision::Back;
            }
            ui.checkbox(guided, "Guided: show the planned line, entry and target");
            Decision::Stay
        });
        ui.add_space(8.0);
        decision.inner
    });
    egui::CentralPanel::default().frame(page(ui)).show(ui, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            ui.set_max_width(760.0);
            ui.heading(&exercise.title);
            ui.add_space(8.0);
            ui.label(RichText::new(&exercise.briefing).size(16.5).line_height(Some(24.0)));
            ui.add_space(12.0);
            facts(ui, exercise, device);
            if let Some(error) = error {
                ui.add_space(8.0);
                ui.colored_label(colours::BAD, format!("× {error}"));
            }
        });
    });
    decision.inner
}

fn facts(ui: &mut Ui, exercise: &Exercise, device: &str) {
    let [x_mm, y_mm] = exercise.entry_mm;
    let facts = [
        ("Target", format!("{:.1} mm along the needle", exercise.target_depth_mm)),
        ("Entry", format!("{x_mm:.0} mm right, {y_mm:.0} mm away, {:.0}° to the skin's normal", exercise.angle_deg)),
        ("Time", format!("{:.0} s", exercise.time_limit_s)),
        ("Passed with", format!("{:.0} of 100 points", exercise.pass_mark)),
        ("You are given", exercise.feedback.in_words().to_owned()),
        ("Device", device.to_owned()),
    ];
    egui::Grid::new("facts").spacing([16.0, 6.0]).show(ui, |ui| {
        for (name, fact) in facts {
            ui.label(RichText::new(name).strong());
            ui.label(fact);
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    //! A trainee must see a day that is past for what it is, on their school's clock.

    use super::*;
    use serde_json::json;
    use time::macros::datetime;

    #[test]
    fn a_day_is_told_on_the_schools_clock_and_a_past_one_as_past() {
        let listed =
            |due_at| serde_json::from_value::<Listed>(json!({ "exercise_id": "x", "due": true, "due_at": due_at }));
        let told = |due_at, now| when(&listed(due_at).unwrap(), now).1;
        let day = json!("2026-11-30T18:00:00+01:00");
        assert_eq!(told(day.clone(), datetime!(2026-11-30 16:59 UTC)), "→ due 30 Nov 2026, 18:00");
        assert_eq!(told(day, datetime!(2026-11-30 17:01 UTC)), "× was due 30 Nov 2026, 18:00");
        assert_eq!(told(json!(null), datetime!(2026-11-30 17:01 UTC)), "→ to do");
        assert_eq!(
            told(json!("soon"), datetime!(2026-11-30 17:01 UTC)),
            "→ to do",
            "a newer service's words are no reason to stop"
        );
    }
}
