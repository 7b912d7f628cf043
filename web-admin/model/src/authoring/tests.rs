//! The form preserves documents. The tests check that an unchanged form reproduces a document byte
//! for byte, and that a change of one field changes no other.

use std::path::{Path, PathBuf};

use super::*;

fn shipped() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula");
    let folders =
        std::fs::read_dir(root).expect("the shipped documents").map(|folder| folder.expect("a folder").path());
    let courses = folders.filter(|folder| folder.join("course.toml").is_file());
    let files = courses.flat_map(|course| std::fs::read_dir(course).expect("a course"));
    files
        .map(|file| file.expect("a file").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .map(|path| (path.clone(), std::fs::read_to_string(path).expect("a text")))
        .collect()
}

const PLACES: [&str; 21] = [
    "title.en",
    "title.de",
    "briefing.en",
    "briefing.de",
    "description.en",
    "description.de",
    "difficulty",
    "pass_mark",
    "time_limit_s",
    "entry.point_mm[0]",
    "entry.point_mm[1]",
    "entry.angle_deg",
    "target.depth_mm",
    "required.reached",
    "required.within_mm",
    "mastery.rule",
    "mastery.passes",
    "mastery.p0",
    "mastery.alpha",
    "mastery.within",
    "required.confirmed",
];

const COLUMNS: [&str; 10] = [
    "rubric[].metric",
    "rubric[].full",
    "rubric[].zero",
    "rubric[].weight",
    "hard_fail[].metric",
    "hard_fail[].above",
    "hard_fail[].why.en",
    "coaching[].quantity",
    "coaching[].message.de",
    "exercise[].survey",
];

/// Returns the addresses of all fields in the form of a document.
fn fields(document: &EditedDocument) -> Vec<String> {
    let rows = COLUMNS.iter().flat_map(|column| {
        let (array, key) = column.split_once("[]").expect("a column");
        (0..document.count_rows(array)).map(move |row| format!("{array}[{row}]{key}"))
    });
    PLACES.iter().map(|place| (*place).to_owned()).chain(rows).collect()
}

fn sent(document: &EditedDocument) -> SentForm {
    let typed = |field: String| {
        let is_metric = field.ends_with(".metric");
        let typed = if is_metric { document.metric_at(&field) } else { document.written_at(&field) };
        TypedField { field, typed }
    };
    let ticked = document.is_written("required").then(|| TypedField { field: "required".into(), typed: "yes".into() });
    let boxes = ["required", "required.confirmed", "required.withdrawn"].map(str::to_owned).to_vec();
    let flags = ["required.confirmed", "required.withdrawn"].map(str::to_owned);
    let flags = flags.into_iter().map(typed).filter(|sent| !sent.typed.is_empty());
    SentForm { boxes, fields: ticked.into_iter().chain(flags).chain(fields(document).into_iter().map(typed)).collect() }
}

#[test]
fn a_form_that_nobody_has_changed_keeps_every_byte() {
    let shipped = shipped();
    assert!(shipped.len() >= 10, "{}", shipped.len());
    for (path, text) in shipped {
        let mut document = EditedDocument::from_text(&text).expect("TOML");
        let sent = sent(&document);
        sent.write_into(&mut document);
        assert_eq!(document.into_text(), text, "{}", path.display());
    }
}

#[test]
fn a_change_of_one_field_changes_that_field_alone() {
    for (path, text) in shipped() {
        let before = EditedDocument::from_text(&text).expect("TOML");
        for field in
            fields(&before).into_iter().filter(|field| before.is_written(field) && !field.ends_with("confirmed"))
        {
            let sort = sort_for_test(&field);
            let (mut changed, other) = (before.clone(), if sort == FieldSort::Number { "7.50" } else { "another" });
            changed.write_field(&field, sort, other);
            let (was, is) = (before.clone().into_text(), changed.clone().into_text());
            assert_eq!(changed.written_at(&field), other, "{} {field}", path.display());
            let start = was.bytes().zip(is.bytes()).take_while(|(a, b)| a == b).count();
            let end = was.bytes().rev().zip(is.bytes().rev()).take_while(|(a, b)| a == b).count();
            assert!(start + end + before.written_at(&field).len() + 600 > was.len(), "{field}: too much differs");
            changed.write_field(&field, sort, &before.written_at(&field));
            let back: toml::Table = changed.into_text().parse().expect("TOML");
            assert_eq!(back, text.parse::<toml::Table>().expect("TOML"), "{} {field}", path.display());
        }
    }
}

fn sort_for_test(field: &str) -> FieldSort {
    match field {
        "required.reached" | "mastery.rule" => FieldSort::Text,
        _ if field.ends_with(".en") || field.ends_with(".de") => FieldSort::Translation,
        _ if ["metric", "quantity", "survey"].iter().any(|key| field.ends_with(key)) => FieldSort::Text,
        _ => FieldSort::Number,
    }
}

#[test]
fn a_number_stays_as_it_is_typed_and_its_comment_with_it() {
    let mut document = EditedDocument::from_text("[target]\ndepth_mm = 8 # to the fat\nodd = 1\n").expect("TOML");
    for (typed, written) in [("8.50", "8.50"), ("9,25", "9.25"), (" 7 ", "7"), (".5", "0.5"), ("deep", "\"deep\"")] {
        document.write_field("target.depth_mm", FieldSort::Number, typed);
        let text = document.clone().into_text();
        assert_eq!(text, format!("[target]\ndepth_mm = {written} # to the fat\nodd = 1\n"));
    }
    assert_eq!(document.written_at("target.depth_mm"), "deep", "what was typed is not lost");
}

#[test]
fn rows_come_go_and_change_places_with_their_comments() {
    let text = "id = \"a\"\n\n# first\n[[rubric]]\nmetric = \"x\"\n\n# second\n[[rubric]]\nmetric = \"y\"\n\n[[coaching]]\nabove = 1\n";
    let mut document = EditedDocument::from_text(text).expect("TOML");
    document.swap_rows("rubric", 0, 1);
    document.swap_rows("rubric", 1, 0);
    assert_eq!(document.clone().into_text(), text);
    document.add_row("rubric", &[("metric", "z")]);
    document.write_field("required.reached", FieldSort::Text, "fat");
    document.write_field("rubric[2].full", FieldSort::Number, "0.50");
    let grown = document.clone().into_text();
    assert!(grown.contains("metric = \"y\"\n\n[[rubric]]\nmetric = \"z\"\nfull = 0.50\n\n[[coaching]]"), "{grown}");
    assert!(grown.contains("[required]\nreached = \"fat\"\n"), "{grown}");
    document.remove_row("rubric", 2);
    document.write_field("required", FieldSort::Presence, "");
    assert_eq!(document.clone().into_text(), text);
    document.remove_row("coaching", 0);
    document.remove_row("coaching", 7);
    assert!(!document.into_text().contains("coaching"));
}

#[test]
fn a_metric_is_picked_with_its_version_and_boxes_are_ticked() {
    let mut document = EditedDocument::from_text("[[rubric]]\nmetric = \"stop_time_s\"\nfull = 1\n").expect("TOML");
    document.write_field("rubric[0].metric", FieldSort::Metric, "path_length_mm@2");
    assert_eq!(document.metric_at("rubric[0].metric"), "path_length_mm@2");
    document.write_field("rubric[0].metric", FieldSort::Metric, "depth_error_mm");
    assert_eq!(document.clone().into_text(), "[[rubric]]\nmetric = \"depth_error_mm\"\nfull = 1\n");
    let mut course = EditedDocument::from_text("[[exercise]]\nfile = \"a\"\n").expect("TOML");
    course.tick_id("exercise[0].prerequisites", "b", true);
    course.tick_id("exercise[0].prerequisites", "c", true);
    course.tick_id("exercise[0].prerequisites", "b", false);
    assert_eq!(course.texts_at("exercise[0].prerequisites"), ["c"]);
}

#[test]
fn a_text_comes_into_another_language_and_goes_again() {
    let text = "id = \"a\"\ntitle = \"Stop\" # short\n\n[[hard_fail]]\nwhy = \"Too deep\"\n";
    let mut document = EditedDocument::from_text(text).expect("TOML");
    document.write_field("title.de", FieldSort::Translation, "");
    assert!(!document.add_language("de"), "its own is not known yet");
    document.write_field("languages", FieldSort::OwnLanguage, "en");
    assert!(document.add_language("de") && !document.add_language("de") && !document.add_language("tlh"));
    assert_eq!([document.address_in("title", "en"), document.address_in("title", "de")], ["title", "title.de"]);
    let typed = |field: &str, typed: &str| TypedField { field: field.into(), typed: typed.into() };
    let fields = vec![typed("title", "Stop"), typed("title.de", "Halt"), typed("hard_fail[0].why.de", "Zu tief")];
    SentForm { boxes: Vec::new(), fields }.write_into(&mut document);
    let both = document.clone().into_text();
    assert!(both.contains("title = { en = \"Stop\", de = \"Halt\" } # short\n"), "{both}");
    assert!(both.contains("why = { en = \"Too deep\", de = \"Zu tief\" }\n"), "{both}");
    assert!(both.contains("languages = [\"en\", \"de\"]\n"), "{both}");
    assert_eq!(document.address_in("title", "en"), "title.en");
    document.write_field("title.en", FieldSort::Translation, "Stop now");
    document.remove_language(1);
    document.remove_language(0);
    let own = document.into_text();
    assert!(own.contains("title = { en = \"Stop now\" } # short\n") && own.contains("languages = [\"en\"]\n"), "{own}");
}

#[test]
fn what_no_form_has_is_left_alone_whatever_is_sent() {
    let text = "id = \"a\"\n[target]\ndepth_mm = 1\n";
    let mut document = EditedDocument::from_text(text).expect("TOML");
    let odd = ["id", "target", "rubric[9].full", "rubric[].full", "[0]", "", "target.depth_mm.x", "entry.point_mm[9]"];
    let fields = odd.map(|field| TypedField { field: field.into(), typed: "7".into() }).to_vec();
    SentForm { boxes: vec!["target".into(), "x:y".into()], fields }.write_into(&mut document);
    assert_eq!(document.into_text(), text);
}
