//! The list of exercises.

use assessment::learning::{Mastery, Reached};
use documents::{Exercise, Wording};
use eframe::egui::{self, Align, Color32, Layout, RichText, ScrollArea, Ui};
use time::OffsetDateTime;
use words::fixed;

use super::colours;
use super::language::WindowLanguage;
use super::thumbnails::Thumbnails;
use crate::clock;
use crate::live::desk::Listed;
use crate::live::history::{History, Tally};
use crate::shelf::{Broken, Offer, Shelf};

/// A page of text, with margins.
pub fn reading_page(ui: &Ui) -> egui::Frame {
    egui::Frame::central_panel(ui.style()).inner_margin(egui::Margin::symmetric(48, 32))
}

/// The content of the list.
pub struct ExerciseChoice<'a> {
    /// The catalogue of exercises.
    pub shelf: &'a Shelf,
    /// Earlier attempts at this station.
    pub history: &'a History,
    /// The source of the assignments.
    pub listing: Listing<'a>,
}

/// The source of the assignments.
#[derive(Clone, Copy)]
pub enum Listing<'a> {
    /// No school: all exercises of the catalogue.
    Here,
    /// The school of the signed-in trainee.
    School(&'a [Listed]),
    /// The study of a guest, who sees no other exercises.
    Study(&'a [Listed]),
}

impl<'a> Listing<'a> {
    fn listed(self) -> Option<&'a [Listed]> {
        match self {
            Self::Here => None,
            Self::School(listed) | Self::Study(listed) => Some(listed),
        }
    }
}

impl ExerciseChoice<'_> {
    /// Returns the school's entry for an exercise.
    fn listed(&self, exercise: &Exercise) -> Option<&Listed> {
        self.listing.listed()?.iter().find(|listed| listed.exercise_id == exercise.id)
    }

    /// Whether an exercise fulfils the prerequisite of others: it is mastered according to the
    /// school, or without a school by the course's own rule on the attempts at this machine.
    /// Mastery found by a learning curve fulfils it for good, even if later attempts regress.
    fn opens(&self, exercise_id: &str, mastery: &Mastery) -> bool {
        match self.listing.listed() {
            Some(listed) => listed.iter().any(|listed| listed.exercise_id == exercise_id && listed.mastered),
            None => {
                let (reached, _) = mastery.judge(&self.history.tally(exercise_id).passed);
                !matches!(reached, Reached::Open { .. })
            }
        }
    }

    /// Returns the heading of an exercise's group: due ones, or its course with the number of
    /// mastered exercises.
    fn heading(&self, offer: &Offer) -> String {
        if self.listed(&offer.bundle.exercise).is_some_and(|listed| listed.due) {
            return tr!("To do").to_owned();
        }
        let Some(course) = &offer.course else { return tr!("Other exercises").to_owned() };
        let of_course = self.shelf.exercises.iter().filter(|other| {
            other.course.as_ref().is_some_and(|other| other.title == course.title)
                && self.opens(&other.bundle.exercise.id, &course.mastery)
        });
        let [_, all] = course.place;
        let (title, mastered) = (own_words(&course.title), of_course.count());
        tr!("{course} · {mastered} of {all} mastered", course = title, mastered = mastered, all = all)
    }

    /// Describes the place in the course, the progress, and the exercises to master first.
    fn facts(&self, offer: &Offer) -> String {
        let exercise = &offer.bundle.exercise;
        let course = offer.course.as_ref();
        let place = course.map(|course| {
            let [at, all] = course.place;
            tr!("{at} of {all}", at = at, all = all)
        });
        let listed = self.listed(exercise);
        let progress = match listed {
            Some(_) if matches!(self.listing, Listing::Study(_)) => tr!("part of the study").to_owned(),
            Some(listed) if listed.mastered => tr!("mastered").to_owned(),
            Some(listed) if listed.due => tr!("not mastered yet").to_owned(),
            Some(_) => tr!("locked").to_owned(),
            None if self.listing.listed().is_some() => tr!("not one of your school's exercises").to_owned(),
            None => say_standing(&self.history.tally(&exercise.id), course.map(|course| course.mastery)),
        };
        // An exercise that is due at the school is open, regardless of its prerequisites.
        let asked = course.into_iter().filter(|_| listed.is_none_or(|listed| !listed.due));
        let asked = asked.flat_map(|course| course.prerequisites.iter().map(|id| (id, &course.mastery)));
        let missing: Vec<&str> =
            asked.filter(|(id, mastery)| !self.opens(id, mastery)).map(|(id, _)| self.title(id)).collect();
        let first = (!missing.is_empty()).then(|| tr!("complete first: {exercises}", exercises = missing.join(", ")));
        place.into_iter().chain([progress]).chain(first).collect::<Vec<_>>().join(" · ")
    }

    /// Whether the current user may practise an exercise.
    fn is_offered(&self, exercise: &Exercise) -> bool {
        !matches!(self.listing, Listing::Study(_)) || self.listed(exercise).is_some()
    }

    fn title<'a>(&'a self, exercise_id: &'a str) -> &'a str {
        let known = self.shelf.exercises.iter().find(|offer| offer.bundle.exercise.id == exercise_id);
        known.map_or(exercise_id, |offer| own_words(&offer.bundle.exercise.title))
    }
}

/// Describes the results of the attempts at this machine, and the distance to mastery in a course.
fn say_standing(Tally { passed, best }: &Tally, mastery: Option<Mastery>) -> String {
    let passes = passed.iter().filter(|passed| **passed).count();
    let tried = match passed.len() {
        0 => return tr!("not attempted here yet").to_owned(),
        1 if passes > 0 => tr!("1 attempt here, passed, {points} points", points = fixed(*best, 0)),
        1 => tr!("1 attempt here, not passed, {points} points", points = fixed(*best, 0)),
        attempts => tr!(
            "{attempts} attempts here, {passes} passed, best {points} points",
            attempts = attempts,
            passes = passes,
            points = fixed(*best, 0)
        ),
    };
    [mastery.map(|mastery| say_distance(&mastery, passed)), Some(tried)]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(" · ")
}

fn say_distance(mastery: &Mastery, passed: &[bool]) -> String {
    let (reached, curve) = mastery.judge(passed);
    let needed = curve.map_or(0, |curve| curve.successes_needed);
    match (reached, mastery) {
        (Reached::Mastered { .. }, _) => tr!("mastered").to_owned(),
        (Reached::Regressing { .. }, _) => trn!(
            "needs practice again: {n} more consecutive pass needed",
            "needs practice again: {n} more consecutive passes needed",
            needed
        ),
        (Reached::Open { passes }, Mastery::Passes { passes: needed, of }) => tr!(
            "not mastered yet: {passes} of {needed} passes needed within {of} consecutive attempts",
            passes = passes,
            needed = needed,
            of = of
        ),
        (Reached::Open { .. }, Mastery::Curve(_)) => trn!(
            "not mastered yet: {n} more consecutive pass needed",
            "not mastered yet: {n} more consecutive passes needed",
            needed
        ),
    }
}

/// Controls and pictures of the list.
pub struct ListControls<'a> {
    /// Language of the window.
    pub language: &'a mut WindowLanguage,
    /// Whether the settings are open.
    pub settings: &'a mut bool,
    /// The pictures of the exercises.
    pub thumbnails: &'a mut Thumbnails,
}

/// Shows the list of exercises, with a button that opens the settings; returns the index of the
/// chosen exercise.
pub fn choose_exercise(ui: &mut Ui, choice: &ExerciseChoice<'_>, controls: ListControls<'_>) -> Option<usize> {
    let ListControls { language, settings, thumbnails } = controls;
    let chosen = egui::CentralPanel::default().frame(reading_page(ui)).show(ui, |ui| {
        show_heading(ui, tr!("Exercises"), |ui| {
            language.ui(ui);
            *settings |= ui.button(tr!("Settings")).clicked();
        });
        ui.add_space(8.0);
        let exercises = &choice.shelf.exercises;
        let mut order: Vec<usize> =
            (0..exercises.len()).filter(|&at| choice.is_offered(&exercises[at].bundle.exercise)).collect();
        // Due exercises first, in the order of the school's list; the others in the order of the
        // catalogue.
        let due = || choice.listing.listed().unwrap_or_default().iter().filter(|listed| listed.due);
        let place = |at: &usize| {
            let id = exercises.get(*at).map(|offer| offer.bundle.exercise.id.as_str());
            due().position(|due| Some(due.exercise_id.as_str()) == id).unwrap_or(usize::MAX)
        };
        // Among the others, those without a course last.
        let course = |at: &usize| exercises.get(*at).is_none_or(|offer| offer.course.is_none());
        order.sort_by_key(|at| (place(at), course(at)));
        let scrolled = ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let rows = order.iter().filter_map(|&at| exercises.get(at).map(|offer| (at, offer)));
            let mut chosen = None;
            let mut under = None;
            for (at, offer) in rows {
                let heading = choice.heading(offer);
                if under.as_ref() != Some(&heading) {
                    ui.add_space(10.0);
                    ui.label(RichText::new(&heading).strong().size(16.0));
                    ui.add_space(2.0);
                    under = Some(heading);
                }
                if exercise_row(ui, choice, offer, thumbnails) {
                    chosen = Some(at);
                }
            }
            show_reading(ui, choice.shelf);
            list_unreadable(ui, &choice.shelf.broken);
            chosen
        });
        scrolled.inner
    });
    chosen.inner
}

/// Shows a page's heading, with widgets at the other end of its line.
pub fn show_heading(ui: &mut Ui, heading: &str, other_end: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        ui.horizontal(other_end);
        ui.with_layout(Layout::top_down(Align::LEFT), |ui| {
            ui.add(egui::Label::new(RichText::new(heading).heading()).wrap())
        });
    });
}

/// Returns a document's text in the window's language.
pub fn own_words(text: &Wording) -> &str {
    text.in_language(words::current().code())
}

/// Shows that further exercises are being read.
fn show_reading(ui: &mut Ui, shelf: &Shelf) {
    if shelf.is_reading() {
        ui.add_space(10.0);
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label(RichText::new(tr!("Reading further exercises …")).weak());
        });
        ui.ctx().request_repaint_after_secs(0.1);
    }
}

fn exercise_row(ui: &mut Ui, choice: &ExerciseChoice<'_>, offer: &Offer, thumbnails: &mut Thumbnails) -> bool {
    let exercise = &offer.bundle.exercise;
    let clicked = ui.horizontal(|ui| {
        thumbnails.show(ui, &offer.bundle);
        let clicked = ui.add(
            egui::Button::new(RichText::new(own_words(&exercise.title)).size(17.0)).min_size([320.0, 34.0].into()),
        );
        ui.vertical(|ui| {
            ui.horizontal(|ui| {
                let harder = usize::from(exercise.difficulty);
                ui.label("●".repeat(harder) + &"○".repeat(5_usize.saturating_sub(harder)))
                    .on_hover_text(tr!("Difficulty"));
                let (depth, angle) = (fixed(exercise.target_depth_mm, 0), fixed(exercise.angle_deg, 0));
                ui.label(tr!("target {depth} mm, {angle}°", depth = depth, angle = angle));
                if let Some(due) = choice.listed(exercise).filter(|listed| listed.due) {
                    let (colour, words) = say_due_time(due, clock::now());
                    ui.colored_label(colour, words);
                }
            });
            ui.label(RichText::new(choice.facts(offer)).weak().small());
        });
        clicked.clicked()
    });
    clicked.inner
}

/// Lists the documents that cannot be used, with the reasons.
fn list_unreadable(ui: &mut Ui, broken: &[Broken]) {
    if broken.is_empty() {
        return;
    }
    ui.add_space(16.0);
    ui.label(RichText::new(tr!("Unusable files")).strong());
    for Broken { path, why } in broken {
        let name =
            path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
        ui.colored_label(colours::BAD, format!("× {name}"));
        ui.label(RichText::new(why).weak().small());
    }
}

/// Describes the deadline of an exercise; without one, the exercise is marked as to do.
fn say_due_time(due: &Listed, now: OffsetDateTime) -> (Color32, String) {
    let Some(at) = due.due_at() else { return (colours::WARN, format!("→ {}", tr!("to do"))) };
    let day = words::dates::date(at.year(), u8::from(at.month()), at.day());
    let day = tr!("{date}, {time}", date = day, time = format!("{:02}:{:02}", at.hour(), at.minute()));
    if at < now {
        (colours::BAD, format!("× {}", tr!("was due {day}", day = day)))
    } else {
        (colours::WARN, format!("→ {}", tr!("due {day}", day = day)))
    }
}

#[cfg(test)]
mod tests {
    //! Fails if a deadline in the past looks like a future one, or is not shown in the school's
    //! time zone.

    use serde_json::json;
    use time::macros::datetime;

    use super::*;
    use crate::live::history;

    fn offer(at: usize) -> (Shelf, usize) {
        let course = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics");
        (Shelf::read(&[course]).unwrap(), at)
    }

    #[test]
    fn the_list_tells_course_progress_and_what_comes_first() {
        let (shelf, second) = offer(1);
        let (history, offers) = (History::default(), &shelf.exercises);
        let first = &offers[0].bundle.exercise;
        let here = ExerciseChoice { shelf: &shelf, history: &history, listing: Listing::Here };
        let told = here.facts(&offers[second]);
        let parts = ["2 of 7 · not attempted here yet · complete first: ", first.title.own()];
        assert!(parts.iter().all(|part| told.contains(part)), "{told}");
        let listed: Vec<Listed> = serde_json::from_value(json!([
            { "exercise_id": first.id, "due": false, "mastered": true },
            { "exercise_id": offers[second].bundle.exercise.id, "due": true },
        ]))
        .unwrap();
        let school = ExerciseChoice { shelf: &shelf, history: &history, listing: Listing::School(&listed) };
        assert!(school.facts(&offers[0]).ends_with("mastered"), "{}", school.facts(&offers[0]));
        assert!(school.facts(&offers[second]).ends_with("not mastered yet"), "{}", school.facts(&offers[second]));
        let study = ExerciseChoice { listing: Listing::Study(&listed), ..school };
        let offered = offers.iter().filter(|offer| study.is_offered(&offer.bundle.exercise)).count();
        assert_eq!((offered, offers.len()), (2, 7), "a guest sees the exercises of the study");
        assert!(study.facts(&offers[second]).ends_with("part of the study"), "{}", study.facts(&offers[second]));
    }

    #[test]
    fn mastery_at_the_station_agrees_with_the_service() {
        let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/mastery/cases.json");
        let cases: Vec<serde_json::Value> = serde_json::from_slice(&std::fs::read(cases).unwrap()).unwrap();
        for case in cases {
            let (rule, number) = (&case["rule"], |key: &str| case["rule"][key].as_f64());
            let count = |key: &str| rule[key].as_u64().and_then(|count| u32::try_from(count).ok());
            let mastery = Mastery::from_rule(&match (count("passes"), count("of")) {
                (Some(passes), Some(of)) => documents::MasteryRule::Passes { passes, of },
                _ => {
                    let [p0, p1, alpha, beta] = ["p0", "p1", "alpha", "beta"].map(|key| number(key).unwrap());
                    documents::MasteryRule::Cusum { within: count("within"), p0, p1, alpha, beta }
                }
            });
            let (mut shelf, _) = offer(0);
            shelf.exercises.iter_mut().for_each(|offer| offer.course.as_mut().unwrap().mastery = mastery.unwrap());
            let first = shelf.exercises[0].bundle.exercise.id.clone();
            let history = history::tests::of(&first, case["attempts"].as_str().unwrap());
            let here = ExerciseChoice { shelf: &shelf, history: &history, listing: Listing::Here };
            let [told, next] = [0, 1].map(|at| here.facts(&shelf.exercises[at]));
            assert_eq!(told.contains(" · mastered"), case["mastered"] == true, "{case}: {told}");
            assert_eq!(!next.contains(" · complete first: "), case["opens"] == true, "{case}: {next}");
        }
    }

    #[test]
    fn a_day_is_told_on_the_schools_clock_and_a_past_one_as_past() {
        let listed =
            |due_at| serde_json::from_value::<Listed>(json!({ "exercise_id": "x", "due": true, "due_at": due_at }));
        let told = |due_at, now| say_due_time(&listed(due_at).unwrap(), now).1;
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
