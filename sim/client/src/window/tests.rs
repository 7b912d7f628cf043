//! Draws every screen that needs no graphics card, in every language, in a large window and a small
//! one. Fails if a text bypasses the catalogues, is cut or overlaps another, or if a choice of
//! language takes effect only on another screen.

use std::path::PathBuf;
use std::sync::Mutex;

use eframe::egui::epaint::ClippedShape;
use eframe::egui::{Context, RawInput, Rect, Shape, pos2, vec2};
use haptics::devices::scripted::Fault;
use phrase::phrase;
use serde_json::json;
use words::Language;

use super::choose::{ExerciseChoice, ListControls, Listing};
use super::overlay::Instruments;
use super::sound::Sound;
use super::*;
use crate::live::desk::{DeskAnswer, DeskReply, Listed};
use crate::live::{history, tests as attempts};
use crate::shelf::Broken;

/// The initial and the minimum size of the window.
const SIZES: [[f32; 2]; 2] = [[1280.0, 720.0], [900.0, 500.0]];

/// A text on the screen.
#[derive(Clone, Debug)]
struct DrawnText {
    text: String,
    area: Rect,
    clip: Rect,
    elided: bool,
}

/// Returns the texts of a screen in a language, once it has settled.
fn draw(language: Language, size: [f32; 2], mut show: impl FnMut(&mut Ui)) -> Vec<DrawnText> {
    let context = Context::default();
    colours::apply_colours(&context);
    let mut shapes = Vec::new();
    for frame in 0..4 {
        let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), size.into()));
        let input = RawInput { screen_rect, time: Some(f64::from(frame)), ..RawInput::default() };
        let mut output = context.run_ui(input, |ui| words::within(language, || show(ui)));
        output.textures_delta.clear();
        shapes = output.shapes;
    }
    let mut texts = Vec::new();
    for ClippedShape { clip_rect, shape, .. } in shapes {
        collect_texts(&shape, clip_rect, &mut texts);
    }
    texts
}

fn collect_texts(shape: &Shape, clip: Rect, texts: &mut Vec<DrawnText>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect_texts(shape, clip, texts)),
        Shape::Text(text) if !text.galley.text().trim().is_empty() => texts.push(DrawnText {
            text: text.galley.text().to_owned(),
            area: text.visual_bounding_rect(),
            clip,
            elided: text.galley.elided,
        }),
        _ => {}
    }
}

fn course() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/lower-back-basics")
}

fn shelf() -> Shelf {
    let mut shelf = Shelf::read(&[course()]).unwrap();
    shelf.broken.push(Broken { path: "BROKEN".into(), why: "X".to_owned() });
    shelf
}

fn show_list(ui: &mut Ui, choice: &ExerciseChoice<'_>, language: &mut WindowLanguage, thumbnails: &mut Thumbnails) {
    choose::choose_exercise(ui, choice, ListControls { language, settings: &mut false, thumbnails });
}

fn pairing() -> Pairing {
    serde_json::from_value(json!({ "server": "http://127.0.0.1:9", "school": "NORTH", "name": "LAB", "token": "t" }))
        .unwrap()
}

fn school_list(shelf: &Shelf) -> Vec<Listed> {
    let [first, second, third] = [0, 1, 2].map(|at| shelf.exercises[at].bundle.exercise.id.clone());
    serde_json::from_value(json!([
        { "exercise_id": first, "due": false, "mastered": true },
        { "exercise_id": second, "due": true, "due_at": "2024-11-30T18:00:00+01:00" },
        { "exercise_id": third, "due": true, "due_at": "2124-11-30T18:00:00+01:00" },
    ]))
    .unwrap()
}

/// Draws every screen in a language and a size, and passes each with its name to `look`.
fn every_screen(language: Language, size: [f32; 2], look: &mut dyn FnMut(&str, Vec<DrawnText>)) {
    draw_choices(language, size, look);
    draw_attempt(language, size, look);
}

fn draw_choices(language: Language, size: [f32; 2], look: &mut dyn FnMut(&str, Vec<DrawnText>)) {
    let (shelf, mut window) = (shelf(), WindowLanguage::default());
    let listed = school_list(&shelf);
    let first = shelf.exercises[0].bundle.exercise.id.clone();
    for (name, history, listing) in [
        ("a choice", history::tests::of(&first, "PF"), Listing::Here),
        ("a choice of the school's", History::default(), Listing::School(&listed)),
        ("a guest's choice", History::default(), Listing::Study(&listed)),
    ] {
        let choice = ExerciseChoice { shelf: &shelf, history: &history, listing };
        let mut thumbnails = Thumbnails::default();
        look(
            name,
            draw(language, size, |ui| {
                show_list(ui, &choice, &mut window, &mut thumbnails);
            }),
        );
    }
    for offer in &shelf.exercises {
        let (device, mut guided) = (open::DeviceChoice::Mouse.phrase(), true);
        look(
            "a briefing",
            draw(language, size, |ui| {
                let (device, language) = (words::phrase(&device), &mut window);
                let (guided, exercise) = (&mut guided, &offer.bundle.exercise);
                let mut pictures = BriefingPictures::default();
                let pictures = pictures.of(&offer.bundle);
                briefing::show_briefing(
                    ui,
                    Briefing {
                        exercise,
                        pictures,
                        device: &device,
                        by_hand: true,
                        guided,
                        ready: true,
                        error: None,
                        language,
                    },
                );
            }),
        );
    }
    let mut page = SettingsPage { open: true, ..SettingsPage::default() };
    let (mut settings, mut device) = (Settings::default(), open::DeviceChoice::Auto);
    look("the settings", draw(language, size, |ui| page.ui(ui, &mut settings, &mut device)));
    draw_wall(language, size, look);
    look("a moment of waiting", draw(language, size, |ui| briefing::show_preparing(ui, Some(0.5))));
    let refused = DeskAnswer::Refused(phrase!("unknown sign-in code; create a new one on your account page"));
    for answer in
        [None, Some(DeskAnswer::Waiting), Some(refused), Some(DeskAnswer::Came(DeskReply::SignedIn(signed_in())))]
    {
        let mut desk = Desk::default();
        desk.call = answer.map(|answer| Arc::new(Mutex::new(answer)));
        look("the desk", draw(language, size, |ui| desk.ui(ui, &pairing(), &mut window)));
    }
    let mut desk = desk_of_guest();
    look(
        "a guest's consent",
        draw(language, size, |ui| {
            desk.ui(ui, &pairing(), &mut window);
            desk.show_consent(ui, &pairing());
        }),
    );
}

fn draw_wall(language: Language, size: [f32; 2], look: &mut dyn FnMut(&str, Vec<DrawnText>)) {
    let (args, none) = (DeviceArgs::default(), Settings::default());
    let desk = open::Desk { args: &args, settings: &none };
    let test = WallTest::start(&open::DeviceChoice::Mouse, &desk, TICK_HZ).unwrap();
    let mut wall = WallPage::new(test, 1.0);
    look(
        "a wall",
        draw(language, size, |ui| {
            wall.ui(ui);
        }),
    );
}

/// A desk that asks a guest for consent.
fn desk_of_guest() -> Desk {
    let terms = json!({
        "study": "STUDY", "consent": "CONSENT\nLINE", "controller": "CONTROLLER", "contact": "CONTACT", "kept_months": 12,
        "revision": "r",
    });
    let asked = DeskReply::ConsentAsked(serde_json::from_value(terms).unwrap());
    let mut desk = Desk::default();
    desk.call = Some(Arc::new(Mutex::new(DeskAnswer::Came(asked))));
    desk
}

fn signed_in() -> live::desk::SignedIn {
    serde_json::from_value(json!({ "trainee": "t", "display_name": "ADA", "exercises": [], "language": "de" })).unwrap()
}

fn draw_attempt(language: Language, size: [f32; 2], look: &mut dyn FnMut(&str, Vec<DrawnText>)) {
    let folder = tempfile::tempdir().unwrap();
    let mut live = attempts::begin(Fault::None, None, folder.path());
    attempts::wait_for_ticks(&live);
    let latest = live.latest().cloned();
    let (shown, mut sound) = (live.shown().clone(), Sound::open(1.0));
    let instruments = Instruments {
        shown: &shown,
        latest: latest.as_ref(),
        live: &live,
        quality: render::Quality::Full,
        passed_over: &[],
        by_hand: true,
    };
    look(
        "an attempt",
        draw(language, size, |ui| {
            overlay::show_side_panel(ui, &instruments, &mut sound);
            overlay::show_messages(ui, &shown, documents::Feedback::Both);
            overlay::draw_heading(ui, ui.available_rect_before_wrap(), &instruments);
        }),
    );
    let (trial, finished) = live.stop();
    let mut debrief = Debrief::new(&trial, finished, None, Vec::new()).unwrap();
    look("a debriefing", draw(language, size, |ui| drop(debrief.ui(ui, &trial))));
    let recording = Arc::new(sources::read_recording(&trial.path).unwrap());
    let mut replay = replay(&trial.bundle, &recording, Some(&recording));
    look(
        "a replay",
        draw(language, size, |ui| {
            replay.timeline(ui);
            replay.plots(ui);
        }),
    );

    for (name, fault, saved) in [
        ("a debriefing of a lost device", Fault::Disconnect, true),
        ("an attempt that is not saved", Fault::None, false),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let live = attempts::begin(fault, None, folder.path());
        attempts::wait_for_ticks(&live);
        if !saved {
            std::fs::remove_dir_all(folder.path()).unwrap();
        }
        let (trial, finished) = live.stop();
        let mut debrief = Debrief::new(&trial, finished, None, Vec::new()).unwrap();
        assert_eq!(debrief.may_close(), saved);
        look(name, draw(language, size, |ui| drop(debrief.ui(ui, &trial))));
    }
}

/// Returns the parts of a text outside all brackets of the pseudo-language.
fn unbracketed(text: &str) -> String {
    let mut depth = 0_u32;
    let outside = text.chars().filter(|c| {
        depth += u32::from(*c == '⟦');
        let is_outside = depth == 0;
        depth = depth.saturating_sub(u32::from(*c == '⟧'));
        is_outside
    });
    outside.collect()
}

#[test]
fn nothing_is_said_past_the_catalogues() {
    let shelf = shelf();
    let written: Vec<String> = shelf
        .exercises
        .iter()
        .flat_map(|offer| {
            let course = offer.course.as_ref().map(|course| course.title.own().to_owned());
            let exercise = &offer.bundle.exercise;
            let coached = exercise.coaching.iter().map(|rule| &rule.message);
            let pictured = exercise.pictures.iter().flat_map(|picture| [Some(&picture.alt), picture.caption.as_ref()]);
            let texts = [&exercise.title, &exercise.briefing].into_iter().chain(coached).chain(pictured.flatten());
            texts.map(|text| text.own().to_owned()).chain(course).collect::<Vec<_>>()
        })
        .chain(Language::all().map(|language| language.own_name().to_owned()))
        .chain(
            [
                "scripted",
                "mouse",
                "BROKEN",
                "CONSENT",
                "LINE",
                "CONTROLLER",
                "CONTACT",
                "STUDY",
                "NORTH",
                "LAB",
                "ADA",
                "device lost: the device is gone",
            ]
            .map(str::to_owned),
        )
        .collect();
    let mut past = Vec::new();
    every_screen(Language::PSEUDO, SIZES[0], &mut |screen, texts| {
        assert!(!texts.is_empty(), "{screen} is empty");
        for DrawnText { text, .. } in texts {
            let said = written.iter().fold(text.clone(), |said, known| said.replace(known.as_str(), ""));
            let left = unbracketed(&said);
            let is_word = |word: &&str| word.chars().count() > 3;
            let word = left.split(|c: char| !c.is_alphabetic()).find(is_word).map(str::to_owned);
            if let Some(word) = word.filter(|_| !left.contains(std::path::MAIN_SEPARATOR)) {
                past.push(format!("{screen}: {word} of “{text}”"));
            }
        }
    });
    assert!(past.is_empty(), "said past the catalogues: {past:#?}");
}

#[test]
fn no_text_is_cut_or_runs_over_another() {
    let mut wrong = Vec::new();
    for (language, size) in Language::all().flat_map(|language| SIZES.map(|size| (language, size))) {
        every_screen(language, size, &mut |screen, texts| {
            for (at, one) in texts.iter().enumerate() {
                let place = format!("{screen} in {language} at {size:?}: “{}”", one.text);
                let fits = one.area.left() >= one.clip.left() - 1.0 && one.area.right() <= one.clip.right() + 1.0;
                if one.elided || one.area.intersects(one.clip) && !fits {
                    wrong.push(format!("{place} is cut: {:?} of {:?}", one.area, one.clip));
                }
                let over = texts[at + 1..].iter().find(|other| {
                    let shared = one.area.intersect(one.clip).intersect(other.area.intersect(other.clip));
                    shared.width() > 2.0 && shared.height() > 2.0 && one.text != other.text
                });
                wrong.extend(over.map(|other| format!("{place} runs over “{}”", other.text)));
            }
        });
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn languages_differ_on_every_screen_and_switch_at_once() {
    let german = Language::named("de").unwrap();
    let texts = |language| {
        let mut all = Vec::new();
        every_screen(language, SIZES[0], &mut |screen, texts| all.push((screen.to_owned(), texts)));
        all
    };
    for ((screen, english), (_, german)) in texts(Language::ENGLISH).into_iter().zip(texts(german)) {
        let words = |texts: &[DrawnText]| texts.iter().map(|drawn| drawn.text.clone()).collect::<Vec<_>>();
        assert_ne!(words(&english), words(&german), "{screen} is the same in both");
    }
    let (shelf, history, mut window) = (shelf(), History::default(), WindowLanguage::default());
    let mut thumbnails = Thumbnails::default();
    let context = Context::default();
    colours::apply_colours(&context);
    let mut frame = |at: f64, window: &mut WindowLanguage, events: Vec<egui::Event>| {
        let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(1280.0, 720.0)));
        let input = RawInput { screen_rect, time: Some(at), events, ..RawInput::default() };
        let language = window.spoken();
        let mut output = context.run_ui(input, |ui| {
            words::within(language, || {
                let choice = ExerciseChoice { shelf: &shelf, history: &history, listing: Listing::Here };
                show_list(ui, &choice, window, &mut thumbnails);
            });
        });
        output.textures_delta.clear();
        let mut texts = Vec::new();
        output.shapes.iter().for_each(|drawn| collect_texts(&drawn.shape, drawn.clip_rect, &mut texts));
        texts
    };
    frame(0.0, &mut window, vec![]);
    let texts = frame(0.1, &mut window, vec![]);
    let deutsch = texts.iter().find(|drawn| drawn.text == "Deutsch").expect("a choice of languages").area.center();
    let button = |pressed| egui::Event::PointerButton {
        pos: deutsch,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    frame(0.2, &mut window, vec![egui::Event::PointerMoved(deutsch)]);
    frame(0.3, &mut window, vec![button(true)]);
    frame(0.35, &mut window, vec![button(false)]);
    let texts = frame(0.4, &mut window, vec![]);
    assert!(texts.iter().any(|drawn| drawn.text == "Übungen"), "{texts:?}");
}

#[test]
fn sign_in_switches_the_window_to_the_persons_language() {
    let mut window = WindowLanguage::default();
    let came = Arc::new(Mutex::new(DeskAnswer::Came(DeskReply::SignedIn(signed_in()))));
    let mut desk = Desk::default();
    desk.call = Some(came);
    draw(Language::ENGLISH, SIZES[0], |ui| desk.ui(ui, &pairing(), &mut window));
    assert_eq!(window.spoken().code(), "de");
}

#[test]
fn declining_ends_the_sign_in_and_agreeing_awaits_the_school() {
    let press = |desk: &mut Desk, label: &str| {
        let texts = draw(Language::ENGLISH, SIZES[0], |ui| desk.show_consent(ui, &pairing()));
        let at = texts.iter().find(|drawn| drawn.text == label).expect("a button").area.center();
        let context = Context::default();
        colours::apply_colours(&context);
        let button = |pressed| egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let frames = [vec![], vec![], vec![egui::Event::PointerMoved(at)], vec![button(true)], vec![button(false)]];
        for (frame, events) in frames.into_iter().enumerate() {
            let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), SIZES[0].into()));
            let input = RawInput { screen_rect, time: Some(frame as f64 * 0.05), events, ..RawInput::default() };
            context.run_ui(input, |ui| desk.show_consent(ui, &pairing())).textures_delta.clear();
        }
    };
    let mut desk = desk_of_guest();
    assert!(desk.asks_consent() && desk.signed_in().is_none());
    press(&mut desk, "No, thank you");
    assert!(!desk.asks_consent() && desk.signed_in().is_none() && !desk.is_asking());
    let mut desk = desk_of_guest();
    press(&mut desk, "I agree to take part");
    assert!(!desk.asks_consent() && desk.signed_in().is_none(), "the school is asked, which is not there");
}
