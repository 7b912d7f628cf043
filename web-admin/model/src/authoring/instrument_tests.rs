//! The form preserves instruments, and references to questions are updated. The tests check that an
//! unchanged form reproduces each shipped instrument, that a change of one field changes no other,
//! and that no score, pair or condition refers to a removed id.

use std::path::Path;

use documents::Instrument;

use super::*;

fn shipped() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments");
    let files = std::fs::read_dir(folder).expect("the instruments").map(|file| file.expect("a file").path());
    files.map(|file| std::fs::read_to_string(file).expect("a text")).collect()
}

/// Fields of an instrument's form, with the text entered to change them.
const COLUMNS: [(&str, FieldSort, &str); 18] = [
    ("title.en", FieldSort::Translation, "Another"),
    ("intro.de", FieldSort::Translation, "Anders"),
    ("duration_min", FieldSort::Number, "7.50"),
    ("source", FieldSort::Text, "Ours"),
    ("licence", FieldSort::Text, "Free"),
    ("scale[].points", FieldSort::Number, "6"),
    ("scale[].first.de", FieldSort::Translation, "Anders"),
    ("scale[].labels[].en", FieldSort::Translation, "Another"),
    ("scale[].option[].text.de", FieldSort::Translation, "Anders"),
    ("scale[].max_characters", FieldSort::Number, "77"),
    ("section[].title.en", FieldSort::Translation, "Another"),
    ("section[].text.de", FieldSort::Translation, "Anders"),
    ("item[].text.en", FieldSort::Translation, "Another"),
    ("item[].name.de", FieldSort::Translation, "Anders"),
    ("item[].pair[]", FieldSort::Text, "another"),
    ("score[].title.en", FieldSort::Translation, "Another"),
    ("score[].factor", FieldSort::Number, "2.50"),
    ("score[].least_answered", FieldSort::Number, "3"),
];

fn typed(field: &str, typed: &str) -> TypedField {
    TypedField { field: field.to_owned(), typed: typed.to_owned() }
}

/// Returns the data that a browser submits for an unchanged form.
fn sent(document: &EditedDocument) -> SentForm {
    let ids = ["id", "kind", "scale", "section", "combine", "missing", "better", "relevant_from", "when.item"];
    let arrays = ["scale[]", "section[]", "item[]", "score[]", "scale[].option[]"];
    let named = arrays.iter().flat_map(|array| ids.iter().map(move |key| format!("{array}.{key}")));
    let columns = COLUMNS.iter().map(|(pattern, ..)| (*pattern).to_owned());
    let addresses = columns.chain(named).flat_map(|pattern| document.list_addresses(&pattern));
    let mut fields: Vec<TypedField> = addresses.map(|field| typed(&field, &document.written_at(&field))).collect();
    let mut boxes = document.list_addresses("scale[].labels");
    for labels in boxes.iter().filter(|labels| document.is_written(labels)) {
        fields.push(typed(labels, "yes"));
    }
    for list in ["score[].items", "score[].reversed", "score[].pairs", "section[].when.is"] {
        for list in document.list_addresses(list) {
            for id in document.texts_at(&list).into_iter().chain(["nobody".to_owned()]) {
                if document.names_id(&list, &id) {
                    fields.push(typed(&format!("{list}:{id}"), "yes"));
                }
                boxes.push(format!("{list}:{id}"));
            }
        }
    }
    SentForm { boxes, fields }
}

#[test]
fn unchanged_form_keeps_every_byte_of_an_instrument() {
    let shipped = shipped();
    assert!(shipped.len() >= 6, "{}", shipped.len());
    for text in shipped {
        let mut document = EditedDocument::from_text(&text).expect("TOML");
        sent(&document).write_into(&mut document);
        assert_eq!(document.into_text(), text);
    }
}

#[test]
fn changed_field_changes_only_its_line_of_the_instrument() {
    for text in shipped() {
        let before = EditedDocument::from_text(&text).expect("TOML");
        for (pattern, _, other) in COLUMNS {
            for field in before.list_addresses(pattern).into_iter().filter(|field| before.is_written(field)) {
                if field.ends_with("points") && before.is_written(&field.replace("points", "labels")) {
                    continue;
                }
                let mut form = sent(&before);
                form.fields
                    .iter_mut()
                    .filter(|sent| sent.field == field)
                    .for_each(|sent| sent.typed = other.to_owned());
                let mut changed = before.clone();
                form.write_into(&mut changed);
                assert_eq!(changed.written_at(&field), other, "{field}");
                let (was, is): (Vec<&str>, String) = (text.lines().collect(), changed.into_text());
                let differ = is.lines().zip(&was).filter(|(is, was)| is != *was).count();
                assert_eq!((differ, is.lines().count()), (1, was.len()), "{field}: {is}");
            }
        }
    }
}

#[test]
fn questions_pages_and_options_change_places_and_come_back() {
    for text in shipped() {
        let mut document = EditedDocument::from_text(&text).expect("TOML");
        let options: Vec<String> = document.list_addresses("scale[].option");
        for array in ["item", "section", "score", "scale"].into_iter().chain(options.iter().map(String::as_str)) {
            for row in 1..document.count_rows(array) {
                document.swap_rows(array, row - 1, row);
            }
            let moved = document.clone().into_text();
            assert!(document.count_rows(array) < 2 || moved != text, "{array}");
            moved.parse::<toml::Table>().expect("TOML");
            for row in (1..document.count_rows(array)).rev() {
                document.swap_rows(array, row - 1, row);
            }
            assert_eq!(document.clone().into_text(), text, "{array}");
        }
    }
}

fn blank() -> EditedDocument {
    let text = "id = \"a\"\ntitle = { en = \"T\", de = \"T\" }\nlanguages = [\"en\", \"de\"]\nduration_min = 1\nsource = \"s\"\nlicence = \"l\"\n";
    EditedDocument::from_text(text).expect("TOML")
}

/// Writes a text in both languages.
fn say(document: &mut EditedDocument, field: &str) {
    for language in ["en", "de"] {
        document.write_field(&format!("{field}.{language}"), FieldSort::Translation, &format!("{field} {language}"));
    }
}

/// Returns an instrument with two questions on a Likert scale, one of which is the condition of a
/// page, and a score over both.
fn questionnaire() -> EditedDocument {
    let mut document = blank();
    let row = document.add_named_row("scale", "agreement");
    document.write_field("scale[0].kind", FieldSort::Text, "likert");
    document.write_field("scale[0].points", FieldSort::Number, "3");
    assert_eq!(row, 0);
    for _ in 0..2 {
        let row = document.add_question("agreement-1");
        say(&mut document, &format!("item[{row}].text"));
    }
    document.add_section();
    let second = document.add_section();
    say(&mut document, "section[0].title");
    say(&mut document, &format!("section[{second}].title"));
    document.write_field("section[1].when.item", FieldSort::Subject, "q-1");
    document.tick_id("section[1].when.is", "2", true);
    let last = document.add_question("agreement-1");
    say(&mut document, &format!("item[{last}].text"));
    document.write_field(&format!("item[{last}].section"), FieldSort::Text, "page-2");
    document.add_named_row("score", "score");
    say(&mut document, "score[0].title");
    document.write_field("score[0].combine", FieldSort::Text, "mean");
    document.tick_id("score[0].items", "q-1", true);
    document.tick_id("score[0].items", "q-2", true);
    document.tick_id("score[0].reversed", "q-1", true);
    document
}

fn read(document: &EditedDocument) -> Instrument {
    let text = document.clone().into_text();
    Instrument::from_bytes("t", text.as_bytes()).unwrap_or_else(|refused| panic!("{refused}\n{text}"))
}

#[test]
fn an_instrument_is_written_from_nothing() {
    let instrument = read(&questionnaire());
    assert_eq!(instrument.items.len(), 3);
    assert_eq!(instrument.pages().iter().map(|(_, items)| items.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(instrument.scores[0].reversed, ["q-1"]);
}

#[test]
fn whoever_names_a_question_follows_it_to_another_name() {
    let mut document = questionnaire();
    let fields = vec![
        typed("item[0].id", "first"),
        typed("item[1].id", "q-1"),
        typed("scale[0].id", "yes"),
        typed("section[0].id", "start"),
        typed("section[1].when.item", "q-1"),
    ];
    let boxes = vec!["section[1].when.is:2".to_owned(), "section[1].when.is:3".to_owned()];
    let fields = fields.into_iter().chain([typed("section[1].when.is:3", "yes")]).collect();
    SentForm { boxes, fields }.write_into(&mut document);
    let instrument = read(&document);
    assert_eq!(instrument.scores[0].items, ["first", "q-1"], "both at once, the one to the other's old name");
    assert_eq!(instrument.scores[0].reversed, ["first"]);
    let when = instrument.sections[1].when.clone().expect("a condition");
    assert_eq!((when.item.as_str(), when.is), ("first", vec!["3".to_owned()]));
    assert!(instrument.items.iter().all(|item| item.scale == "yes"));
}

#[test]
fn what_depends_on_a_choice_goes_with_it() {
    let mut document = questionnaire();
    let choose = |document: &mut EditedDocument, field: &str, chosen: &str| {
        SentForm { boxes: Vec::new(), fields: vec![typed(field, chosen)] }.write_into(document);
    };
    choose(&mut document, "section[1].when.item", "");
    assert!(!document.is_written("section[1].when"));
    choose(&mut document, "score[0].missing", "mean-of-answered");
    choose(&mut document, "score[0].least_answered", "1");
    read(&document);
    choose(&mut document, "score[0].missing", "no-score");
    assert!(!document.is_written("score[0].least_answered"));
    choose(&mut document, "scale[0].labels", "yes");
    assert_eq!(document.count_rows("scale[0].labels"), 3);
    for point in 0..3 {
        say(&mut document, &format!("scale[0].labels[{point}]"));
    }
    choose(&mut document, "scale[0].points", "2");
    assert_eq!(document.count_rows("scale[0].labels"), 3, "words are never dropped unasked");
    choose(&mut document, "scale[0].points", "4");
    assert_eq!(document.count_rows("scale[0].labels"), 4);
    SentForm { boxes: vec!["scale[0].labels".to_owned()], fields: Vec::new() }.write_into(&mut document);
    assert!(!document.is_written("scale[0].labels"));
    choose(&mut document, "scale[0].kind", "number");
    assert!(!document.is_written("scale[0].points"));
}

#[test]
fn what_is_removed_leaves_no_name_behind_in_scores() {
    let mut document = questionnaire();
    document.remove_scale(0);
    assert_eq!(document.count_rows("scale"), 1, "three questions are answered so");
    document.remove_question(0);
    assert_eq!(document.texts_at("score[0].items"), ["q-2"]);
    assert!(!document.is_written("score[0].reversed"));
    assert!(document.is_written("section[1].when"), "its author decides what is asked instead");
    document.remove_section(1);
    document.remove_section(0);
    assert!(document.list_addresses("item[].section").iter().all(|item| !document.is_written(item)));
    read(&document);
    document.remove_row("scale[0].option", 0);
    document.remove_language(1);
    assert!(!document.into_text().contains("de ="));
}

#[test]
fn options_come_into_a_scale_wherever_it_stands() {
    for rows in [
        "[[scale]]\nid = \"s\"\nkind = \"choice\"\n\n[[scale]]\nid = \"t\"\n\n[[item]]\nid = \"q\"\n",
        "scale = [{ id = \"s\", kind = \"choice\" }]\n",
    ] {
        let mut document =
            EditedDocument::from_text(&format!("id = \"a\"\nlanguages = [\"en\"]\n{rows}")).expect("TOML");
        for _ in 0..2 {
            let option = document.add_named_row("scale[0].option", "option");
            document.write_field(&format!("scale[0].option[{option}].text.en"), FieldSort::Translation, "x");
        }
        document.swap_rows("scale[0].option", 0, 1);
        let text = document.clone().into_text();
        let table: toml::Table = text.parse().expect("TOML");
        let ids: Vec<&str> =
            table["scale"][0]["option"].as_array().expect("options").iter().filter_map(|o| o["id"].as_str()).collect();
        assert_eq!(ids, ["option-2", "option-1"], "{text}");
        document.remove_row("scale[0].option", 1);
        document.remove_row("scale[0].option", 0);
        assert!(!document.is_written("scale[0].option"));
    }
}
