//! Rows of an instrument's form: scales, conditions and scores.

use model::authoring::{EditedDocument, FieldSort};
use words::Language;

use super::instrument::{InstrumentFormMaker, choices_or};
use super::{FieldInput, FormBoxes, FormField, FormRow, FormSection, RowAdding, plain_choices};

/// A kind of scale that the form can add.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewKind {
    /// Value sent by the form.
    pub(super) word: &'static str,
    /// Label shown to the reader.
    pub(super) label: &'static str,
}

/// Returns the kinds of scale that the form can add.
pub(super) fn list_new_kinds() -> impl Iterator<Item = NewKind> {
    let yes_no = NewKind { word: "yes-no", label: sentence!("Yes or no") };
    let of_kind = |(word, label): (&'static str, &'static str)| NewKind { word, label };
    let mut kinds: Vec<NewKind> = KINDS.into_iter().map(of_kind).collect();
    kinds.insert(1, yes_no);
    kinds.into_iter()
}

/// Kinds of scale and their labels.
const KINDS: [(&str, &str); 7] = [
    ("likert", sentence!("Rating scale (Likert)")),
    ("choice", sentence!("One of several options")),
    ("choices", sentence!("Several options")),
    ("slider", sentence!("Position on a line")),
    ("number", sentence!("A number")),
    ("text", sentence!("A text")),
    ("pair", sentence!("One of two questions (pair)")),
];

/// Returns the kind of a scale by its id; empty if there is no such scale.
pub(super) fn find_kind(document: &EditedDocument, scale: &str) -> String {
    let row = document.find_row_of("scale", scale);
    row.map_or_else(String::new, |row| document.written_at(&format!("scale[{row}].kind")))
}

/// Adds a scale with the usual defaults, with texts in those languages of the document that this
/// program supports. Returns its id.
pub fn begin_scale(document: &mut EditedDocument, kind: &str) -> String {
    let stem = match kind {
        "likert" => "agreement",
        "yes-no" => "yes-no",
        "slider" => "line",
        "choice" | "choices" => "options",
        "number" => "number",
        "text" => "words",
        _ => "pair",
    };
    let row = document.add_named_row("scale", stem);
    let at = |key: &str| format!("scale[{row}].{key}");
    let written = if kind == "yes-no" { "choice" } else { kind };
    document.write_field(&at("kind"), FieldSort::Text, written);
    let numbers: &[(&str, &str)] = match kind {
        "likert" => &[("points", "5")],
        "slider" => &[("min", "0"), ("max", "100"), ("step", "5")],
        "number" => &[("min", "0"), ("max", "100")],
        "text" => &[("max_characters", "1000")],
        _ => &[],
    };
    for (key, number) in numbers {
        document.write_field(&at(key), FieldSort::Number, number);
    }
    match kind {
        "likert" => {
            write_words(document, &at("first"), || tr!("Strongly disagree"));
            write_words(document, &at("last"), || tr!("Strongly agree"));
        }
        "slider" => {
            write_words(document, &at("first"), || tr!("Very low"));
            write_words(document, &at("last"), || tr!("Very high"));
        }
        "yes-no" => {
            document.add_row(&at("option"), &[("id", "yes")]);
            document.add_row(&at("option"), &[("id", "no")]);
            write_words(document, &at("option[0].text"), || tr!("Yes"));
            write_words(document, &at("option[1].text"), || tr!("No"));
        }
        "choice" | "choices" => {
            document.add_named_row(&at("option"), "option");
            document.add_named_row(&at("option"), "option");
        }
        _ => {}
    }
    document.written_at(&at("id"))
}

/// Writes a text in each of the document's languages that this program supports.
fn write_words(document: &mut EditedDocument, text: &str, say: impl Fn() -> &'static str) {
    for language in document.languages() {
        if let Some(spoken) = Language::named(&language) {
            let said = words::within(spoken, &say);
            document.write_field(&format!("{text}.{language}"), FieldSort::Translation, said);
        }
    }
}

impl InstrumentFormMaker<'_> {
    /// Summarizes a scale: its kind, and the texts that distinguish it from others of its kind.
    pub(super) fn say_scale(&self, row: usize) -> String {
        let document = self.read.document;
        let at = |key: &str| format!("scale[{row}].{key}");
        let kind = document.written_at(&at("kind"));
        let label = KINDS.iter().find(|(known, _)| *known == kind).map(|(_, label)| words::say(label).to_owned());
        let word = |key: &str| document.wording_in(&at(key), self.language);
        let told = match kind.as_str() {
            "likert" | "slider" if !word("first").is_empty() => format!("{} … {}", word("first"), word("last")),
            "likert" => {
                let last = document.count_rows(&at("labels")).saturating_sub(1);
                format!("{} … {}", word("labels[0]"), word(&format!("labels[{last}]")))
            }
            "choice" | "choices" => {
                let options = 0..document.count_rows(&at("option"));
                options.map(|option| word(&format!("option[{option}].text"))).collect::<Vec<_>>().join(", ")
            }
            "number" => format!(
                "{}–{} {}",
                document.written_at(&at("min")),
                document.written_at(&at("max")),
                document.written_at(&at("unit"))
            ),
            _ => String::new(),
        };
        let label = label.unwrap_or_else(|| document.written_at(&at("id")));
        match told.trim_matches([' ', '…', ',', '–']) {
            "" => label,
            told => format!("{label}: {told}"),
        }
    }

    pub(super) fn scale_section(&self) -> FormSection {
        let count = self.read.document.count_rows("scale");
        let kinds = list_new_kinds().map(|kind| (kind.word, words::say(kind.label).to_owned()));
        FormSection {
            id: "f-scale",
            title: tr!("Answer formats"),
            about: tr!("Each format is shared by the questions that use it: a change here applies to all of them."),
            rows: (0..count).map(|row| self.scale_row(row)).collect(),
            adding: Some(RowAdding {
                act: "add:scale".to_owned(),
                name: "new.scale",
                label: tr!("Kind"),
                button: tr!("Add an answer format"),
                choices: plain_choices(kinds),
                problems: self.read.problems_of("scale"),
            }),
            ..FormSection::default()
        }
    }

    fn scale_row(&self, row: usize) -> FormRow {
        let (read, at) = (&self.read, |key: &str| format!("scale[{row}].{key}"));
        let (kind, id) = (read.document.written_at(&at("kind")), read.document.written_at(&at("id")));
        let uses = (0..read.document.count_rows("item"))
            .filter(|item| read.document.written_at(&format!("item[{item}].scale")) == id)
            .count();
        let kinds = plain_choices(KINDS.map(|(word, label)| (word, words::say(label).to_owned())));
        let mut fields = vec![FormField {
            hint: tr!("If you choose another and save, settings that only this one has are lost.").to_owned(),
            ..read.choice(&at("kind"), tr!("Kind"), kinds)
        }];
        fields.extend(self.scale_numbers(row, &kind));
        fields.extend(self.scale_words(row, &kind));
        fields
            .push(read.field(at("id"), tr!("Id"), FieldInput::Line).hinted(tr!("Questions that use it are updated.")));
        let has_options = ["choice", "choices"].contains(&kind.as_str()) || read.document.is_written(&at("option"));
        let options = 0..read.document.count_rows(&at("option"));
        FormRow {
            title: format!("{}. {}", row + 1, self.say_scale(row)),
            note: match uses {
                0 => tr!("No question uses this format.").to_owned(),
                uses => trn!("{n} question uses this format.", "{n} questions use this format.", uses),
            },
            fields,
            parts: options.map(|option| self.option_row(row, option)).collect(),
            adding: has_options.then(|| {
                RowAdding::plain(
                    format!("add:scale[{row}].option"),
                    tr!("Add an option"),
                    read.problems_of(&at("option")),
                )
            }),
            removal: if uses == 0 { format!("remove:scale[{row}]") } else { String::new() },
            ..FormRow::at(format!("scale[{row}]"))
        }
    }

    fn scale_numbers(&self, row: usize, kind: &str) -> Vec<FormField> {
        let at = |key: &str| format!("scale[{row}].{key}");
        let number = |key: &str, label: &str| self.read.field(at(key), label, FieldInput::Number);
        let known = [
            ("points", number("points", tr!("Number of points")).hinted(tr!("2 to 11."))),
            ("min", number("min", tr!("Lowest answer"))),
            ("max", number("max", tr!("Highest answer"))),
            ("step", number("step", tr!("Distance between two marks"))),
            ("unit", self.read.field(at("unit"), tr!("Unit"), FieldInput::Line)),
            ("max_characters", number("max_characters", tr!("Maximum number of characters"))),
            (
                "relevant_from",
                number("relevant_from", tr!("Relevant from"))
                    .hinted(tr!("For content validity: answers from this point count as relevant. Empty otherwise.")),
            ),
        ];
        let own: &[&str] = match kind {
            "likert" => &["points", "relevant_from"],
            "slider" => &["min", "max", "step"],
            "number" => &["min", "max", "unit"],
            "text" => &["max_characters"],
            _ => &[],
        };
        let is_shown = |key: &str| own.contains(&key) || self.read.document.is_written(&at(key));
        known.into_iter().filter(|(key, _)| is_shown(key)).map(|(_, field)| field).collect()
    }

    /// Returns the fields for the texts at the ends and the points.
    fn scale_words(&self, row: usize, kind: &str) -> Vec<FormField> {
        let (read, at) = (&self.read, |key: &str| format!("scale[{row}].{key}"));
        let mut fields = Vec::new();
        for (key, label) in [("first", tr!("Label of the low end")), ("last", tr!("Label of the high end"))] {
            if ["likert", "slider"].contains(&kind) || read.document.is_written(&at(key)) {
                fields.extend(self.wording(&at(key), label, &FieldInput::Line));
            }
        }
        let labels = at("labels");
        let has_labels = read.document.is_written(&labels);
        if kind == "likert" || has_labels {
            fields.push(FormField {
                value: if has_labels { "yes" } else { "" }.to_owned(),
                ..read.field(&labels, tr!("Each point has its own label (save to see the fields)"), FieldInput::Tick)
            });
        }
        for point in 0..read.document.count_rows(&labels) {
            let label = tr!("Point {point}", point = point + 1);
            fields.extend(self.wording(&format!("{labels}[{point}]"), &label, &FieldInput::Line));
        }
        fields
    }

    fn option_row(&self, scale: usize, row: usize) -> FormRow {
        let array = format!("scale[{scale}].option");
        let at = |key: &str| format!("{array}[{row}].{key}");
        let mut fields = self.wording(&at("text"), tr!("Option"), &FieldInput::Line);
        fields.push(
            self.read
                .field(at("id"), tr!("Id"), FieldInput::Line)
                .hinted(tr!("The value that is stored and exported.")),
        );
        FormRow {
            title: self.number_row(row, &at("text")),
            fields,
            removal: format!("remove:{array}[{row}]"),
            moves: self.moves_of(&array, row),
            ..FormRow::at(format!("{array}[{row}]"))
        }
    }

    /// Returns the field that selects the question on which a row depends; `None` if no earlier
    /// question qualifies.
    pub(super) fn condition_field(&self, row: &str) -> Option<FormField> {
        let (document, field) = (self.read.document, format!("{row}.when.item"));
        let earlier: Vec<usize> =
            (0..document.count_rows("item")).filter(|item| self.comes_before(*item, row)).collect();
        if earlier.is_empty() && !document.is_written(&field) {
            return None;
        }
        let asked: Vec<_> = earlier.into_iter().map(|item| self.option_of("item", item, "name")).collect();
        let asked = asked.iter().map(|option| (option.value.as_str(), option.label.clone()));
        let choices = plain_choices(std::iter::once(("", tr!("Always").to_owned())).chain(asked));
        let made = self.read.choice(&field, tr!("Shown only after certain answers to"), choices);
        Some(made.hinted(tr!("Save after you choose another question, to see its answers.")))
    }

    /// Returns whether an item with selectable answers is on an earlier page than the row.
    fn comes_before(&self, item: usize, row: &str) -> bool {
        let document = self.read.document;
        let kind = find_kind(document, &document.written_at(&format!("item[{item}].scale")));
        let page_of = |field: &str| document.find_row_of("section", &document.written_at(field));
        let asked = page_of(&format!("item[{item}].section"));
        let here =
            if row.starts_with("section") { page_of(&format!("{row}.id")) } else { page_of(&format!("{row}.section")) };
        ["likert", "choice", "choices"].contains(&kind.as_str())
            && asked.zip(here).is_some_and(|(asked, here)| asked < here)
    }

    /// Returns checkboxes for the answers on which a row depends.
    pub(super) fn condition_boxes(&self, row: &str) -> Option<FormBoxes> {
        let (document, list) = (self.read.document, format!("{row}.when.is"));
        if !document.is_written(&format!("{row}.when")) {
            return None;
        }
        let item = document.find_row_of("item", &document.written_at(&format!("{row}.when.item")));
        let scale = item.map(|item| document.written_at(&format!("item[{item}].scale")));
        let scale = scale.and_then(|scale| document.find_row_of("scale", &scale));
        let mut answers = scale.map_or_else(Vec::new, |scale| self.answers_of(scale));
        for odd in document.texts_at(&list) {
            if !answers.iter().any(|(id, _)| *id == odd) {
                answers.push((odd.clone(), odd));
            }
        }
        let boxes = self.boxes_of(&list, answers);
        Some(FormBoxes { title: tr!("Shown after these answers"), boxes, problems: self.read.problems_of(&list) })
    }

    /// Returns the answers of a scale: id and text.
    fn answers_of(&self, scale: usize) -> Vec<(String, String)> {
        let document = self.read.document;
        let points: usize = document.written_at(&format!("scale[{scale}].points")).parse().unwrap_or(0);
        let points = (1..=points.min(11)).map(|point| (point.to_string(), point.to_string()));
        let options = (0..document.count_rows(&format!("scale[{scale}].option")))
            .map(|option| self.option_of(&format!("scale[{scale}].option"), option, "text"))
            .map(|option| (option.value, option.label));
        points.chain(options).collect()
    }

    /// Returns one checkbox per id, ticked if the list contains it.
    fn boxes_of(&self, list: &str, known: impl IntoIterator<Item = (String, String)>) -> Vec<FormField> {
        let tick = |(id, label): (String, String)| FormField {
            value: if self.read.document.names_id(list, &id) { "yes" } else { "" }.to_owned(),
            ..self.read.field(format!("{list}:{id}"), label, FieldInput::Tick)
        };
        known.into_iter().map(tick).collect()
    }

    pub(super) fn score_row(&self, row: usize) -> FormRow {
        let (read, at) = (&self.read, |key: &str| format!("score[{row}].{key}"));
        let number = |key: &str, label: &str| read.field(at(key), label, FieldInput::Number);
        let combine = [("sum", tr!("Sum")), ("mean", tr!("Mean"))];
        let weighted = ("pair-weighted", tr!("Mean, weighted by how often a question is chosen in the pairs"));
        let missing = [("mean-of-answered", tr!("It counts as the mean of the answered questions"))];
        let better = [("higher", tr!("Higher")), ("lower", tr!("Lower"))];
        let combine =
            plain_choices(combine.into_iter().chain([weighted]).map(|(word, label)| (word, label.to_owned())));
        let mut fields = self.wording(&at("title"), tr!("Title"), &FieldInput::Line);
        fields.push(read.choice(&at("combine"), tr!("Calculation"), combine));
        let mut missing = read.choice(&at("missing"), tr!("If an answer is missing"), {
            let none = ("no-score", tr!("No score is calculated"));
            let is_said = read.document.is_written(&at("missing"));
            let rest = is_said.then_some(none).into_iter().chain(missing);
            match is_said {
                true => plain_choices(rest.map(|(word, label)| (word, label.to_owned()))),
                false => choices_or(tr!("No score is calculated"), rest),
            }
        });
        missing.hint = tr!("Save after you choose another, to see its field.").to_owned();
        fields.push(missing);
        if read.document.is_written(&at("least_answered"))
            || read.document.written_at(&at("missing")) == "mean-of-answered"
        {
            fields.push(number("least_answered", tr!("Minimum number of answered questions")));
        }
        fields.push(read.choice(&at("better"), tr!("Better is"), choices_or(tr!("Neither"), better)));
        let rest = vec![
            number("shift", tr!("Added to each answer")).hinted(tr!("Empty: 0.")),
            number("factor", tr!("Multiplied by")).hinted(tr!("Empty: 1.")),
            number("offset", tr!("Added to the total")).hinted(tr!("Empty: 0.")),
            read.field(at("id"), tr!("Id"), FieldInput::Line).hinted(tr!("The name in exports.")),
        ];
        FormRow {
            title: self.number_row(row, &at("title")),
            note: trn!(
                "{n} question is counted",
                "{n} questions are counted",
                read.document.texts_at(&at("items")).len()
            ),
            fields,
            boxes: self.score_boxes(row),
            rest,
            removal: format!("remove:score[{row}]"),
            loss: tr!("Answers are kept; results no longer show this score.").to_owned(),
            moves: self.moves_of("score", row),
            ..FormRow::at(format!("score[{row}]"))
        }
    }

    /// Returns checkboxes for the questions that count, those that are reversed, and the pairs that
    /// weight them.
    fn score_boxes(&self, row: usize) -> Vec<FormBoxes> {
        let (read, at) = (&self.read, |key: &str| format!("score[{row}].{key}"));
        let items = 0..read.document.count_rows("item");
        let kind = |item: usize| find_kind(read.document, &read.document.written_at(&format!("item[{item}].scale")));
        let of_kinds =
            |kinds: &'static [&'static str]| items.clone().filter(move |item| kinds.contains(&kind(*item).as_str()));
        let boxes = |key: &str, title: &'static str, offered: Vec<usize>| {
            let list = at(key);
            let offered = offered.into_iter().map(|item| self.option_of("item", item, "name"));
            let mut known: Vec<(String, String)> = offered.map(|option| (option.value, option.label)).collect();
            for odd in read.document.texts_at(&list) {
                if !known.iter().any(|(id, _)| *id == odd) {
                    known.push((odd.clone(), odd));
                }
            }
            FormBoxes { title, boxes: self.boxes_of(&list, known), problems: read.problems_of(&list) }
        };
        let numeric: Vec<usize> = of_kinds(&["likert", "slider", "number"]).collect();
        let id_of = |item: usize| read.document.written_at(&format!("item[{item}].id"));
        let counted =
            numeric.iter().copied().filter(|item| read.document.names_id(&at("items"), &id_of(*item))).collect();
        let mut groups = vec![
            boxes("items", tr!("Questions in this score"), numeric),
            boxes("reversed", tr!("Reverse-scored: a high answer counts low"), counted),
        ];
        if read.document.written_at(&at("combine")) == "pair-weighted" || read.document.is_written(&at("pairs")) {
            groups.push(boxes("pairs", tr!("Pairs for weighting"), of_kinds(&["pair"]).collect()));
        }
        groups.retain(|group| !group.boxes.is_empty() || !group.problems.is_empty());
        groups
    }
}
