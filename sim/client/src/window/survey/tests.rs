//! Uses the panel by keys alone. Fails if an answer is not on the disk at once, if declined or
//! deleted answers leave a trace, or if leaving loses answers.

use std::fs;
use std::path::Path;

use eframe::egui::{Context, Event, Key, Modifiers, RawInput, Rect, pos2};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::*;

const INSTRUMENT: &str = r#"
id = "short"
title = { en = "Short", de = "Kurz" }
languages = ["en", "de"]
duration_min = 1
source = "here"
licence = "any"
[[scale]]
id = "line"
kind = "slider"
min = 0
max = 100
step = 5
[[scale]]
id = "words"
kind = "text"
max_characters = 40
[[item]]
id = "mental"
text = { en = "How hard?", de = "Wie schwer?" }
scale = "line"
[[item]]
id = "comment"
text = { en = "Anything else?", de = "Noch etwas?" }
scale = "words"
"#;

/// A station whose school is unreachable.
struct SurveyStation {
    folder: TempDir,
    context: Context,
    survey: Option<Survey>,
}

impl SurveyStation {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let told = json!({
            "survey_id": Uuid::nil(), "title": "Short", "identity": "anonymous", "exercises": [],
            "terms": { "en": ["You may."], "de": ["Sie dürfen."] }, "instrument_toml": INSTRUMENT,
        });
        let asked: AskedSurvey = serde_json::from_value(told).unwrap();
        let pairing: Pairing = serde_json::from_value(
            json!({ "server": "http://127.0.0.1:9", "school": "North", "name": "lab", "token": "t" }),
        )
        .unwrap();
        let outbox = Outbox::open(Some(folder.path())).unwrap();
        let survey = Survey::new(Arc::new(asked), Uuid::nil(), pairing, outbox);
        let mut station = Self { folder, context: Context::default(), survey: Some(survey) };
        station.frame(Vec::new());
        station
    }

    fn frame(&mut self, events: Vec<Event>) {
        let screen_rect = Some(Rect::from_min_max(pos2(0.0, 0.0), pos2(1280.0, 800.0)));
        let input = RawInput { screen_rect, events, ..RawInput::default() };
        let survey = &mut self.survey;
        let mut gone = false;
        self.context
            .run_ui(input, |ui| gone |= survey.as_mut().is_some_and(|survey| survey.ui(ui)))
            .textures_delta
            .clear();
        if gone {
            self.survey = None;
        }
    }

    fn press(&mut self, key: Key) {
        let event =
            |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
        self.frame(vec![event(true)]);
        self.frame(vec![event(false)]);
    }

    fn press_all(&mut self, keys: &[Key]) {
        keys.iter().for_each(|key| self.press(*key));
    }

    /// Returns the contents of the files in the outbox with an extension.
    fn files(&self, extension: &str) -> Vec<Value> {
        let found = fs::read_dir(self.folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let read = |path: &Path| serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
        found.filter(|path| path.extension().is_some_and(|e| e == extension)).map(|path| read(&path)).collect()
    }

    fn waits(&self) -> usize {
        self.files("draft").len() + self.files("answers").len()
    }

    /// Moves past both languages to the agreement, and consents.
    fn begin(&mut self) {
        self.press_all(&[Key::Tab, Key::Tab, Key::Tab, Key::Enter]);
    }

    /// Consents, and sets the line's second mark.
    fn answer(&mut self) {
        self.begin();
        self.press_all(&[Key::Tab, Key::ArrowRight, Key::ArrowRight]);
    }
}

#[test]
fn what_is_declined_leaves_no_trace() {
    let mut station = SurveyStation::new();
    station.press_all(&[Key::Tab, Key::Tab, Key::Tab, Key::Tab, Key::Enter]);
    assert!(station.survey.is_none(), "the panel is gone");
    assert_eq!(station.waits(), 0);
    let mut station = SurveyStation::new();
    station.begin();
    assert_eq!(station.waits(), 0, "agreeing alone writes nothing");
    station.survey = None;
    assert_eq!(station.waits(), 0);
}

#[test]
fn each_answer_is_on_the_disk_at_once_and_can_be_deleted() {
    let mut station = SurveyStation::new();
    station.answer();
    let drafts = station.files("draft");
    assert_eq!(
        (drafts.len(), &drafts[0]["answers"], &drafts[0]["sent"]),
        (1, &json!({ "mental": 5.0 }), &json!(false))
    );
    // The cross next to the line, the text, send, delete.
    station.press_all(&[Key::Tab, Key::Tab, Key::Tab, Key::Tab, Key::Enter]);
    assert!(station.survey.is_none(), "the panel is gone");
    assert_eq!(station.waits(), 0);
}

#[test]
fn whoever_goes_away_finds_their_answers_and_has_not_sent_them() {
    let mut station = SurveyStation::new();
    station.answer();
    station.survey = None;
    let kept = station.files("answers");
    assert_eq!((kept.len(), &kept[0]["sent"], &kept[0]["language"]), (1, &json!(false), &json!("en")));
    assert_eq!(station.files("draft").len(), 0);
}

#[test]
fn what_is_sent_waits_in_the_outbox_until_the_school_has_it() {
    let mut station = SurveyStation::new();
    station.answer();
    station.press_all(&[Key::Tab, Key::Tab]);
    station.frame(vec![Event::Text("fine".to_owned())]);
    station.press_all(&[Key::Tab, Key::Enter]);
    let kept = station.files("answers");
    assert_eq!((kept.len(), &kept[0]["sent"]), (1, &json!(true)));
    assert_eq!(kept[0]["answers"], json!({ "mental": 5.0, "comment": "fine" }));
    assert_eq!(kept[0]["secret"].as_str().map(str::len), Some(64));
    station.survey = None;
    assert_eq!(station.waits(), 1, "once");
}

#[test]
fn what_a_killed_program_was_asking_is_taken_up() {
    let mut station = SurveyStation::new();
    station.answer();
    std::mem::forget(station.survey.take());
    Outbox::open(Some(station.folder.path())).unwrap().take_up_drafts().unwrap();
    assert_eq!((station.files("draft").len(), station.files("answers").len()), (0, 1));
}
