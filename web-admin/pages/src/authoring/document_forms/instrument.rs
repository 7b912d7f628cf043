//! The form of an instrument.

use model::authoring::draft::DraftRemark;
use model::authoring::{EditedDocument, is_wording};

use super::instrument_rows::{find_kind, list_new_kinds};
use super::{
    ChoiceGroup, DocumentForm, FieldInput, FormField, FormReader, FormRow, FormSection, RowAdding, RowMove, place_id,
    plain_choices,
};
use crate::form::SelectOption;

/// Above this number of rows with problems, all of them stay collapsed.
const MOST_OPEN: usize = 3;

/// Builds the form of an instrument, with the remarks shown at their fields.
#[must_use]
pub fn make_instrument_form(document: &EditedDocument, remarks: &[DraftRemark]) -> DocumentForm {
    let form = InstrumentFormMaker { read: FormReader { document, remarks }, language: words::current().code() };
    let mut sections = vec![
        form.about_section(),
        form.language_section(),
        form.question_section(),
        form.scale_section(),
        form.page_section(),
        form.score_section(),
    ];
    sections.iter_mut().for_each(|section| fold_rows(&mut section.rows));
    DocumentForm { sections }
}

/// Collapses the rows, and expands those with problems if there are few.
fn fold_rows(rows: &mut [FormRow]) {
    let wrong = rows.iter().filter(|row| row.count_problems() > 0).count();
    for row in rows.iter_mut().filter(|row| !row.fields.is_empty()) {
        row.fold = Some(row.count_problems() > 0 && wrong <= MOST_OPEN);
    }
}

/// Builds the form of an instrument.
#[derive(Clone, Copy, Debug)]
pub(super) struct InstrumentFormMaker<'d> {
    pub(super) read: FormReader<'d>,
    /// The reader's language.
    pub(super) language: &'static str,
}

impl InstrumentFormMaker<'_> {
    fn about_section(&self) -> FormSection {
        let read = &self.read;
        let mut fields = self.wording("title", tr!("Title"), &FieldInput::Line);
        let intro = self.wording("intro", tr!("Introduction"), &FieldInput::Note);
        fields.extend(
            intro.into_iter().map(|text| text.hinted(tr!("Shown before the first question. May be left empty."))),
        );
        fields.push(read.field("duration_min", tr!("How long it takes"), FieldInput::Number).in_unit("min"));
        fields.push(
            read.field("source", tr!("Source"), FieldInput::Note)
                .hinted(tr!("Authors, place of publication, and translators.")),
        );
        fields.push(
            read.field("licence", tr!("Licence"), FieldInput::Note)
                .hinted(tr!("Terms of use. Many questionnaires need their authors’ permission.")),
        );
        FormSection {
            id: "f-about",
            title: tr!("The questionnaire"),
            about: tr!("The form shows every field of a questionnaire. Comments in the TOML are preserved."),
            fields,
            ..FormSection::default()
        }
    }

    /// Builds the section of languages, with the number of missing texts in each.
    fn language_section(&self) -> FormSection {
        let section = self.read.language_section();
        let lacks = |code: &String| {
            let ending = format!(".{code}");
            // A text that has no language yet is missing in all of them.
            let is_in = |field: &str| field.ends_with(&ending) || is_wording(field);
            self.read.remarks.iter().filter(|remark| is_in(&remark.field)).count()
        };
        let languages = self.read.document.languages();
        let note = |(row, code): (FormRow, &String)| match lacks(code) {
            0 => row,
            missing => FormRow {
                note: format!(
                    "{} {}",
                    row.note,
                    trn!("{n} text is missing or wrong in it.", "{n} texts are missing or wrong in it.", missing)
                )
                .trim()
                .to_owned(),
                ..row
            },
        };
        FormSection {
            about: tr!("Participants choose one of these. Every text is needed in each of them."),
            rows: section.rows.into_iter().zip(&languages).map(note).collect(),
            ..section
        }
    }

    fn question_section(&self) -> FormSection {
        let count = self.read.document.count_rows("item");
        FormSection {
            id: "f-item",
            title: tr!("Questions"),
            about: tr!("In the order in which participants see them."),
            rows: (0..count).map(|row| self.question_row(row)).collect(),
            adding: Some(RowAdding {
                act: "add:item".to_owned(),
                name: "new.item",
                label: tr!("Answer format"),
                button: tr!("Add a question"),
                choices: self.answering_choices(),
                problems: self.read.problems_of("item"),
            }),
            ..FormSection::default()
        }
    }

    /// Returns the existing scales, and the kinds of new ones.
    fn answering_choices(&self) -> Vec<ChoiceGroup> {
        let known = (0..self.read.document.count_rows("scale")).map(|row| SelectOption {
            value: self.read.document.written_at(&format!("scale[{row}].id")),
            label: self.say_scale(row),
            chosen: false,
        });
        let made = list_new_kinds().map(|kind| SelectOption {
            value: format!("new:{}", kind.word),
            label: words::say(kind.label).to_owned(),
            chosen: false,
        });
        let known = ChoiceGroup { title: tr!("Use an existing answer format"), choices: known.collect() };
        let made = ChoiceGroup { title: tr!("New answer format"), choices: made.collect() };
        [known, made].into_iter().filter(|group| !group.choices.is_empty()).collect()
    }

    fn question_row(&self, row: usize) -> FormRow {
        let (read, at) = (&self.read, |key: &str| format!("item[{row}].{key}"));
        let scale = read.document.written_at(&at("scale"));
        let answered = read.document.find_row_of("scale", &scale).map(|scale| self.say_scale(scale));
        let mut fields = self.wording(&at("text"), tr!("Question"), &FieldInput::Line);
        fields.push(read.choice(&at("scale"), tr!("Answer format"), self.scale_choices()));
        fields.extend(self.pair_fields(row));
        if read.document.count_rows("section") > 0 || read.document.is_written(&at("section")) {
            fields.push(read.choice(&at("section"), tr!("Page"), self.page_choices()));
        }
        let name = self.wording(&at("name"), tr!("Short name"), &FieldInput::Line);
        fields
            .extend(name.into_iter().map(|name| name.hinted(tr!("Shown in results and in pairs. May be left empty."))));
        fields.extend(self.condition_field(&format!("item[{row}]")));
        let id = read
            .field(at("id"), tr!("Id"), FieldInput::Line)
            .hinted(tr!("The name in exports. Scores and conditions that use it are updated."));
        FormRow {
            title: self.number_row(row, &at("text")),
            note: answered.unwrap_or_default(),
            fields,
            boxes: self.condition_boxes(&format!("item[{row}]")).into_iter().collect(),
            rest: vec![id],
            removal: format!("remove:item[{row}]"),
            loss: self.say_loss_of_item(row),
            moves: self.moves_of("item", row),
            ..FormRow::at(format!("item[{row}]"))
        }
    }

    /// Returns the fields that select the two questions of a pair.
    fn pair_fields(&self, row: usize) -> Vec<FormField> {
        let (read, pair) = (&self.read, format!("item[{row}].pair"));
        let scale = read.document.written_at(&format!("item[{row}].scale"));
        if find_kind(read.document, &scale) != "pair" && !read.document.is_written(&pair) {
            return Vec::new();
        }
        let offered = || {
            let others = (0..read.document.count_rows("item")).filter(|other| {
                let scale = read.document.written_at(&format!("item[{other}].scale"));
                *other != row && find_kind(read.document, &scale) != "pair"
            });
            ChoiceGroup { title: "", choices: others.map(|other| self.option_of("item", other, "name")).collect() }
        };
        let field = |at: usize, label: &str| read.choice(&format!("{pair}[{at}]"), label, vec![offered()]);
        vec![field(0, tr!("First question")), field(1, tr!("Second question"))]
    }

    fn scale_choices(&self) -> Vec<ChoiceGroup> {
        let rows = 0..self.read.document.count_rows("scale");
        let option = |row| SelectOption {
            value: self.read.document.written_at(&format!("scale[{row}].id")),
            label: self.say_scale(row),
            chosen: false,
        };
        vec![ChoiceGroup { title: "", choices: rows.map(option).collect() }]
    }

    fn page_choices(&self) -> Vec<ChoiceGroup> {
        let rows = 0..self.read.document.count_rows("section");
        vec![ChoiceGroup { title: "", choices: rows.map(|row| self.option_of("section", row, "title")).collect() }]
    }

    /// Returns a row as an option: its id as the value, one of its texts as the label.
    pub(super) fn option_of(&self, array: &str, row: usize, text: &str) -> SelectOption {
        let value = self.read.document.written_at(&format!("{array}[{row}].id"));
        let named = self.read.document.wording_in(&format!("{array}[{row}].{text}"), self.language);
        let asked = || self.read.document.wording_in(&format!("{array}[{row}].text"), self.language);
        let label = [named, asked(), value.clone()].into_iter().find(|label| !label.is_empty());
        SelectOption { label: label.unwrap_or_default(), value, chosen: false }
    }

    /// Describes the effects of removing a question: the scores that lose it, and the rows to
    /// change.
    fn say_loss_of_item(&self, row: usize) -> String {
        let document = self.read.document;
        let id = document.written_at(&format!("item[{row}].id"));
        let scores = (0..document.count_rows("score")).filter(|score| {
            ["items", "pairs"].iter().any(|list| document.names_id(&format!("score[{score}].{list}"), &id))
        });
        let scores: Vec<String> = scores.map(|score| self.option_of("score", score, "title").label).collect();
        let asks = |array: &str| {
            let is_asked = |at: &usize| {
                document.written_at(&format!("{array}[{at}].when.item")) == id
                    || document.names_id(&format!("{array}[{at}].pair"), &id)
            };
            (0..document.count_rows(array)).filter(is_asked).collect::<Vec<usize>>()
        };
        let questions = asks("item").into_iter().map(|at| self.option_of("item", at, "name").label);
        let pages = asks("section").into_iter().map(|at| self.option_of("section", at, "title").label);
        let others: Vec<String> = questions.chain(pages).collect();
        let mut loss = tr!("The question is removed from this draft, in every language.").to_owned();
        if !scores.is_empty() {
            loss += &format!(" {}", tr!("It is removed from the scores {scores}.", scores = scores.join(", ")));
        }
        if !others.is_empty() {
            loss +=
                &format!(" {}", tr!("These refer to it and must be changed: {others}.", others = others.join(", ")));
        }
        loss
    }

    /// Returns one field of a text for each language of the document. Texts of an instrument are
    /// always translated.
    pub(super) fn wording(&self, text: &str, label: &str, input: &FieldInput) -> Vec<FormField> {
        let languages = self.read.document.languages();
        let labelled = |language: &String| match languages.len() {
            1 => label.to_owned(),
            _ => format!("{label} ({})", words::own_name(language)),
        };
        let in_language = |language: &String| {
            let field = self.read.field(format!("{text}.{language}"), labelled(language), input.clone());
            let own = languages.first() == Some(language);
            // A problem with the text as a whole is shown once, at the first language.
            let whole = if own { self.read.problems_of(text) } else { Vec::new() };
            FormField {
                language: language.clone(),
                problems: whole.into_iter().chain(field.problems.clone()).collect(),
                ..field
            }
        };
        languages.iter().map(in_language).collect()
    }

    /// Returns a row's number and its text.
    pub(super) fn number_row(&self, row: usize, text: &str) -> String {
        let said = self.read.document.wording_in(text, self.language);
        match said.is_empty() {
            true => format!("{}. {}", row + 1, tr!("(no text yet)")),
            false => format!("{}. {said}", row + 1),
        }
    }

    pub(super) fn moves_of(&self, array: &str, row: usize) -> Vec<RowMove> {
        let count = self.read.document.count_rows(array);
        let up = (row > 0).then(|| RowMove { act: format!("up:{array}[{row}]"), label: tr!("Up") });
        let down = (row + 1 < count).then(|| RowMove { act: format!("down:{array}[{row}]"), label: tr!("Down") });
        up.into_iter().chain(down).collect()
    }

    fn page_section(&self) -> FormSection {
        let count = self.read.document.count_rows("section");
        FormSection {
            id: "f-section",
            title: tr!("Pages"),
            about: tr!("Without pages, all questions are shown on one page. A page can depend on earlier answers."),
            rows: (0..count).map(|row| self.page_row(row)).collect(),
            adding: Some(RowAdding::plain("add:section", tr!("Add a page"), self.read.problems_of("section"))),
            ..FormSection::default()
        }
    }

    fn page_row(&self, row: usize) -> FormRow {
        let (document, at) = (self.read.document, |key: &str| format!("section[{row}].{key}"));
        let id = document.written_at(&at("id"));
        let on_it = (0..document.count_rows("item"))
            .filter(|item| document.written_at(&format!("item[{item}].section")) == id)
            .count();
        let mut fields = self.wording(&at("title"), tr!("Heading"), &FieldInput::Line);
        let text = self.wording(&at("text"), tr!("Instructions before the questions of this page"), &FieldInput::Note);
        fields.extend(text.into_iter().map(|text| text.hinted(tr!("May be left empty."))));
        fields.extend(self.condition_field(&format!("section[{row}]")));
        FormRow {
            title: self.number_row(row, &at("title")),
            note: trn!("{n} question", "{n} questions", on_it),
            fields,
            boxes: self.condition_boxes(&format!("section[{row}]")).into_iter().collect(),
            rest: vec![self.read.field(at("id"), tr!("Id"), FieldInput::Line)],
            removal: format!("remove:section[{row}]"),
            loss: tr!("The heading and text are deleted. Questions on this page remain and must be moved to another page if there are others.")
                .to_owned(),
            moves: self.moves_of("section", row),
            ..FormRow::at(format!("section[{row}]"))
        }
    }

    fn score_section(&self) -> FormSection {
        let count = self.read.document.count_rows("score");
        FormSection {
            id: "f-score",
            title: tr!("Scores"),
            about: tr!("Without scores, results show the answers only."),
            rows: (0..count).map(|row| self.score_row(row)).collect(),
            adding: Some(RowAdding::plain("add:score", tr!("Add a score"), self.read.problems_of("score"))),
            ..FormSection::default()
        }
    }
}

/// Returns a choice whose first option leaves the value unset.
pub(super) fn choices_or<'c>(none: &str, known: impl IntoIterator<Item = (&'c str, &'static str)>) -> Vec<ChoiceGroup> {
    let known = known.into_iter().map(|(value, label)| (value, label.to_owned()));
    plain_choices(std::iter::once(("", none.to_owned())).chain(known))
}

impl FormRow {
    /// Creates an empty row for a place in the document.
    pub(super) fn at(field: String) -> Self {
        Self { id: place_id(&field), ..Self::default() }
    }

    /// Returns the number of problems in the row.
    #[must_use]
    pub fn count_problems(&self) -> usize {
        let own = self.all_fields().map(|field| field.problems.len()).sum::<usize>();
        let boxes = self.boxes.iter().map(|group| group.problems.len()).sum::<usize>();
        own + boxes + self.adding.as_ref().map_or(0, |adding| adding.problems.len())
    }
}

#[cfg(test)]
mod tests {
    //! Every problem of an instrument must have a place in its form, and the scales that a form
    //! begins must be valid once filled in.

    use documents::Instrument;
    use model::authoring::FieldSort;

    use super::*;
    use crate::authoring::document_forms::begin_scale;

    fn shipped(name: &str) -> EditedDocument {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../curricula/instruments");
        EditedDocument::from_text(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
    }

    fn remark(field: &str) -> DraftRemark {
        DraftRemark { field: field.to_owned(), what: "odd".to_owned(), ..DraftRemark::default() }
    }

    #[test]
    fn every_fault_leads_to_its_field_or_to_the_row_around_it() {
        let document = shipped("simulator-validity.toml");
        let form = make_instrument_form(&document, &[]);
        for (field, place) in [
            ("title.de", "f-title-de"),
            ("scale[1].labels[2].de", "f-scale-1-labels-2-de"),
            ("scale[2].option[3].text.en", "f-scale-2-option-3-text-en"),
            ("section[1].when.item", "f-section-1-when-item"),
            ("section[1].when.is", "f-section-1"),
            ("item[4].scale", "f-item-4-scale"),
            ("score[0].items", "f-score-0"),
            ("score[0].factor", "f-score-0-factor"),
            ("item", "f-item"),
        ] {
            assert_eq!(form.find_place(field).map(|(id, _)| id).as_deref(), Some(place), "{field}");
        }
        let pairs = make_instrument_form(&shipped("nasa-tlx-weighted.toml"), &[]);
        assert_eq!(pairs.find_place("item[6].pair").map(|(id, _)| id).as_deref(), Some("f-item-6-pair-0"));
    }

    #[test]
    fn few_faulty_rows_are_open_and_many_are_not() {
        let document = shipped("sus.toml");
        let open = |wrong: usize| {
            let remarks: Vec<DraftRemark> = (0..wrong).map(|row| remark(&format!("item[{row}].text.en"))).collect();
            let form = make_instrument_form(&document, &remarks);
            let questions = form.sections.iter().find(|section| section.id == "f-item").unwrap();
            questions.rows.iter().filter(|row| row.fold == Some(true)).count()
        };
        assert_eq!([open(0), open(3), open(9)], [0, 3, 0]);
    }

    #[test]
    fn a_way_of_answering_begins_as_something_that_can_be_answered() {
        let text = "id = \"a\"\ntitle = { en = \"T\", de = \"T\" }\nlanguages = [\"en\", \"de\"]\nduration_min = 1\nsource = \"s\"\nlicence = \"l\"\n";
        for kind in list_new_kinds().filter(|kind| kind.word != "pair") {
            let mut document = EditedDocument::from_text(text).unwrap();
            let scale = begin_scale(&mut document, kind.word);
            document.add_question(&scale);
            let mut say = |field: &str| {
                for language in ["en", "de"] {
                    document.write_field(&format!("{field}.{language}"), FieldSort::Translation, "Text");
                }
            };
            say("item[0].text");
            match kind.word {
                "choice" | "choices" => (0..2).for_each(|row| say(&format!("scale[0].option[{row}].text"))),
                "number" => document.write_field("scale[0].unit", FieldSort::Text, "years"),
                _ => {}
            }
            let text = document.into_text();
            let read = Instrument::from_bytes("t", text.as_bytes());
            assert!(read.is_ok(), "{}: {read:?}\n{text}", kind.word);
        }
    }
}
