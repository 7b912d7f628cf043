//! Instruments: what their parts say of each other is checked, and each refusal names its place.
//!
//! Would fail if a form could ask what cannot be answered, hide a question for ever, or score what is no number.

use documents::instrument::{Combine, Instrument, Missing};

use crate::support::{INSTRUMENT, curricula};

fn read(text: &str) -> Result<Instrument, String> {
    Instrument::from_bytes("document.toml", text.as_bytes()).map_err(|refused| refused.to_string())
}

#[test]
fn the_small_instrument_reads_as_it_is_written() {
    let instrument = read(INSTRUMENT).unwrap();
    assert_eq!(instrument.title.in_language("de"), "Klein");
    assert_eq!(instrument.title.in_language("fr"), "Klein", "whoever speaks neither gets one of them");
    assert_eq!(instrument.pages().iter().map(|(_, items)| items.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!((instrument.scores[0].combine, instrument.scores[0].missing), (Combine::Sum, Missing::NoScore));
    assert_eq!(instrument.language_for("fr-CH, de;q=0.8, en;q=0.5"), "de");
    assert_eq!(instrument.language_for("ja"), "en");
}

#[test]
fn each_mistake_is_refused_with_its_place_and_what_is_allowed() {
    let mistakes = [
        (", de = \"Klein\"", "", "title.de: missing"),
        ("de = \"Klein\"", "de = \"Klein\", fr = \"Petit\"", "title.fr: a text in another language"),
        ("[\"en\", \"de\"]", "[\"en\", \"de\", \"en\"]", "languages: \"en\"; each must be unique"),
        ("points = 5", "points = 5\nmax = 3", "scale[0].max: not a key of this kind; the kind likert has points"),
        ("points = 5", "", "scale[0].points: missing; required for the kind likert"),
        ("points = 5", "points = 5\nrelevant_from = 6", "scale[0].relevant_from: 6; allowed: at most 5"),
        ("scale = \"agree\"", "scale = \"agre\"", "item[0].scale: \"agre\"; allowed: agree, yes-no"),
        ("section = \"first\"", "section = \"frist\"", "item[0].section: \"frist\"; allowed: first, second"),
        ("section = \"first\"\n", "", "item[0].section: missing"),
        ("item = \"again\"", "item = \"why\"", "section[1].when.item: \"why\"; allowed: an item of an earlier section"),
        ("is = [\"no\"]", "is = [\"maybe\"]", "section[1].when.is: \"maybe\"; allowed: yes, no"),
        ("items = [\"easy\"]", "items = [\"again\"]", "score[0].items: \"again\"; allowed: items of kind likert"),
        ("items = [\"easy\"]", "items = []", "score[0].items: none"),
        ("items = [\"easy\"]", "items = [\"easy\"]\nreversed = [\"why\"]", "score[0].reversed: \"why\""),
        ("\"sum\"", "\"pair-weighted\"", "score[0].pairs: missing"),
        ("\"sum\"", "\"sum\"\nmissing = \"mean-of-answered\"", "score[0].least_answered: missing"),
        ("\"sum\"", "\"sum\"\nleast_answered = 1", "score[0].least_answered: not a key of this policy"),
        ("id = \"again\"", "id = \"easy\"", "item[1].id: \"easy\"; item[0] already has it"),
        ("scale = \"yes-no\"", "scale = \"yes-no\"\npair = [\"easy\", \"why\"]", "item[1].pair: a pair"),
        ("id = \"no\"", "id = \"yes\"", "scale[1].option[1].id: \"yes\"; each must be unique"),
    ];
    for (from, to, says) in mistakes {
        assert!(INSTRUMENT.contains(from), "{from}");
        let refused = read(&INSTRUMENT.replacen(from, to, 1)).expect_err(to);
        assert!(refused.contains(says), "{to}: {refused}");
    }
}

#[test]
fn shipped_instruments_have_two_languages_and_a_source() {
    let folder = curricula().join("instruments");
    let mut ids = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let instrument = Instrument::from_bytes("shipped", &std::fs::read(&path).unwrap()).unwrap();
        assert_eq!(instrument.languages, ["en", "de"], "{}", instrument.id);
        assert!(instrument.source.len() > 20 && instrument.licence.len() > 20, "{}", instrument.id);
        assert_eq!(path.file_stem().unwrap().to_str(), Some(instrument.id.as_str()));
        ids.push(instrument.id);
    }
    ids.sort();
    let shipped = [
        "free-comment",
        "global-rating-puncture",
        "nasa-tlx",
        "nasa-tlx-weighted",
        "puncture-checklist",
        "simulator-validity",
        "sus",
    ];
    assert_eq!(ids, shipped);
}
