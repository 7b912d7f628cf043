//! Before an attempt: the exercises there are, and the briefing of the one that is chosen.

use eframe::egui::{self, Color32, Key, RichText, ScrollArea, Ui};
use scene::Exercise;
use time::OffsetDateTime;
use time::macros::format_description;

use super::{colours, help};
use crate::clock;
use crate::live::desk::Listed;
use crate::live::history::{History, Tally};
use crate::shelf::{Broken, Offer, Shelf};

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

/// What the list is made of.
pub struct Choice<'a> {
    /// What there is to practise.
    pub shelf: &'a Shelf,
    /// What was practised here before.
    pub history: &'a History,
    /// The school's list, where somebody has signed in.
    pub school: Option<&'a [Listed]>,
}

impl Choice<'_> {
    /// What the school lists of an exercise.
    fn listed(&self, exercise: &Exercise) -> Option<&Listed> {
        self.school?.iter().find(|listed| listed.exercise_id == exercise.id)
    }

    /// Whether an exercise is done as far as anybody here knows: mastered for the school, passed on this machine without one.
    fn is_done(&self, exercise_id: &str) -> bool {
        match self.school {
            Some(listed) => listed.iter().any(|listed| listed.exercise_id == exercise_id && listed.mastered),
            None => self.history.tally(exercise_id).passed > 0,
        }
    }

    /// Course and place, progress, and what is to be mastered first.
    fn facts(&self, offer: &Offer) -> String {
        let exercise = &offer.bundle.exercise;
        let course = offer.course.as_ref();
        let place = course.map(|course| format!("{}, {} of {}", course.title, course.place[0], course.place[1]));
        let progress = match self.listed(exercise) {
            Some(listed) if listed.mastered => "mastered".to_owned(),
            Some(listed) if listed.due => "not mastered yet".to_owned(),
            Some(_) => "not open yet".to_owned(),
            None if self.school.is_some() => "not among your school's exercises".to_owned(),
            None => told(self.history.tally(&exercise.id)),
        };
        let missing = course.into_iter().flat_map(|course| &course.prerequisites).filter(|id| !self.is_done(id));
        let missing: Vec<&str> = missing.map(|id| self.title(id)).collect();
        let first = (!missing.is_empty()).then(|| format!("first: {}", missing.join(", ")));
        place.into_iter().chain([progress]).chain(first).collect::<Vec<_>>().join(" · ")
    }

    fn title<'a>(&'a self, exercise_id: &'a str) -> &'a str {
        let known = self.shelf.exercises.iter().find(|offer| offer.bundle.exercise.id == exercise_id);
        known.map_or(exercise_id, |offer| &offer.bundle.exercise.title)
    }
}

/// What became of the attempts on this machine, in words.
fn told(Tally { attempts, passed, best }: Tally) -> String {
    match attempts {
        0 => "not tried here yet".to_owned(),
        1 => format!("1 attempt here, {}, {best:.0} points", if passed > 0 { "passed" } else { "not passed" }),
        _ => format!("{attempts} attempts here, {passed} passed, best {best:.0} points"),
    }
}

/// The list of exercises. Answers the one that is chosen.
pub fn choose(ui: &mut Ui, choice: &Choice<'_>) -> Option<usize> {
    let chosen = egui::CentralPanel::default().frame(page(ui)).show(ui, |ui| {
        ui.heading("Exercises");
        ui.add_space(8.0);
        let exercises = &choice.shelf.exercises;
        let mut order: Vec<usize> = (0..exercises.len()).collect();
        // Assigned ones first, in the order in which they are due; the others as they were given.
        let due = || choice.school.unwrap_or_default().iter().filter(|listed| listed.due);
        let place = |at: &usize| {
            let id = exercises.get(*at).map(|offer| offer.bundle.exercise.id.as_str());
            due().position(|due| Some(due.exercise_id.as_str()) == id).unwrap_or(usize::MAX)
        };
        order.sort_by_key(place);
        let scrolled = ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let rows = order.iter().filter_map(|&at| exercises.get(at).map(|offer| (at, offer)));
            let chosen = rows.filter_map(|(at, offer)| row(ui, choice, offer).then_some(at)).last();
            broken(ui, &choice.shelf.broken);
            chosen
        });
        scrolled.inner
    });
    chosen.inner
}

fn row(ui: &mut Ui, choice: &Choice<'_>, offer: &Offer) -> bool {
    let exercise = &offer.bundle.exercise;
    let clicked = ui.horizontal(|ui| {
        let clicked =
            ui.add(egui::Button::new(RichText::new(&exercise.title).size(17.0)).min_size([320.0, 34.0].into()));
        ui.vertical(|ui| {
            ui.horizontal(|ui| {
                let harder = usize::from(exercise.difficulty);
                ui.label("●".repeat(harder) + &"○".repeat(5_usize.saturating_sub(harder))).on_hover_text("Difficulty");
                ui.label(format!("target {:.0} mm, {:.0}°", exercise.target_depth_mm, exercise.angle_deg));
                if let Some(due) = choice.listed(exercise).filter(|listed| listed.due) {
                    let (colour, words) = when(due, clock::now());
                    ui.colored_label(colour, words);
                }
            });
            ui.label(RichText::new(choice.facts(offer)).weak().small());
        });
        clicked.clicked()
    });
    clicked.inner
}

/// What could not be read, and why.
fn broken(ui: &mut Ui, broken: &[Broken]) {
    if broken.is_empty() {
        return;
    }
    ui.add_space(16.0);
    ui.label(RichText::new("Cannot be used").strong());
    for Broken { path, why } in broken {
        let name =
            path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
        ui.colored_label(colours::BAD, format!("× {name}"));
        ui.label(RichText::new(why).weak().small());
    }
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
    /// Mouse and keyboard move the needle, unless a device is found.
    pub by_hand: bool,
    /// Draw the planned line.
    pub guided: &'a mut bool,
    /// The attempt may begin: who makes it is known.
    pub ready: bool,
    /// Why the attempt cannot begin.
    pub error: Option<&'a str>,
}

/// The briefing.
pub fn brief(ui: &mut Ui, briefing: Briefing<'_>) -> Decision {
    let Briefing { exercise, device, by_hand, guided, ready, error } = briefing;
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
            ui.add_space(12.0);
            help::how_to_move(ui, by_hand);
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

    fn offer(at: usize) -> (Shelf, usize) {
        let course = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics");
        (Shelf::read(&[course]).unwrap(), at)
    }

    #[test]
    fn the_list_tells_course_progress_and_what_comes_first() {
        let (shelf, second) = offer(1);
        let (history, offers) = (History::default(), &shelf.exercises);
        let first = &offers[0].bundle.exercise;
        let here = Choice { shelf: &shelf, history: &history, school: None };
        let told = here.facts(&offers[second]);
        let parts = [", 2 of 7 · not tried here yet · first: ", first.title.as_str()];
        assert!(parts.iter().all(|part| told.contains(part)), "{told}");
        let listed: Vec<Listed> = serde_json::from_value(json!([
            { "exercise_id": first.id, "due": false, "mastered": true },
            { "exercise_id": offers[second].bundle.exercise.id, "due": true },
        ]))
        .unwrap();
        let school = Choice { shelf: &shelf, history: &history, school: Some(&listed) };
        assert!(school.facts(&offers[0]).ends_with("mastered"), "{}", school.facts(&offers[0]));
        assert!(school.facts(&offers[second]).ends_with("not mastered yet"), "{}", school.facts(&offers[second]));
    }

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
