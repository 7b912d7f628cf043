//! Documents written in forms: which fields an exercise, a course and an instrument have, in words, and what is wrong at each.

mod course;
mod exercise;
mod instrument;
mod instrument_rows;
mod picture;

pub use course::{CourseContext, CourseExercise, make_course_form};
use documents::list_document_languages;
pub use exercise::{ExerciseContext, make_exercise_form};
pub use instrument::make_instrument_form;
pub use instrument_rows::begin_scale;
use model::authoring::EditedDocument;
use model::draft::DraftRemark;
pub use picture::{DraftPictures, PictureAdding};

use super::people::SelectOption;
use super::pictures::ShownPicture;

/// What stands before the name of every field of a document: other fields of the same form are called otherwise.
pub const FIELD_PREFIX: &str = "x.";

/// A document as a form.
#[derive(Clone, Debug, Default)]
pub struct DocumentForm {
    /// Its sections in order.
    pub sections: Vec<FormSection>,
}

/// A section of a form.
#[derive(Clone, Debug, Default)]
pub struct FormSection {
    /// Its heading's id.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What to know.
    pub about: &'static str,
    /// Fields that stand alone.
    pub fields: Vec<FormField>,
    /// Rows of fields.
    pub rows: Vec<FormRow>,
    /// How a row is added, where there are rows.
    pub adding: Option<RowAdding>,
    /// How a picture is added, where rows are pictures.
    pub uploading: Option<PictureAdding>,
}

/// A row of fields.
#[derive(Clone, Debug, Default)]
pub struct FormRow {
    /// Its id on the page.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What to know of it.
    pub note: String,
    /// The picture that it is about.
    pub picture: Option<ShownPicture>,
    /// Fields.
    pub fields: Vec<FormField>,
    /// Boxes that belong together, each group under its heading.
    pub boxes: Vec<FormBoxes>,
    /// Fields behind the boxes.
    pub rest: Vec<FormField>,
    /// Rows that stand in it.
    pub parts: Vec<FormRow>,
    /// How one of these is added.
    pub adding: Option<RowAdding>,
    /// It can be folded: whether it is open.
    pub fold: Option<bool>,
    /// What takes it away; empty for what stays.
    pub removal: String,
    /// What is lost with it, where it asks first.
    pub loss: String,
    /// What lets it change places with the one before and the one behind it, where it may.
    pub moves: Vec<RowMove>,
}

/// Boxes that belong together.
#[derive(Clone, Debug)]
pub struct FormBoxes {
    /// Heading.
    pub title: &'static str,
    /// Boxes.
    pub boxes: Vec<FormField>,
    /// What is wrong with them.
    pub problems: Vec<String>,
}

/// A way of moving a row.
#[derive(Clone, Debug)]
pub struct RowMove {
    /// What is sent.
    pub act: String,
    /// What is read.
    pub label: &'static str,
}

/// How a row is added.
#[derive(Clone, Debug)]
pub struct RowAdding {
    /// What is sent.
    pub act: String,
    /// Name of the choice.
    pub name: &'static str,
    /// What is chosen.
    pub label: &'static str,
    /// What the button says.
    pub button: &'static str,
    /// From what; nothing where there is but one sort of rows.
    pub choices: Vec<ChoiceGroup>,
    /// What is wrong with there being so many or so few.
    pub problems: Vec<String>,
}

impl RowAdding {
    /// Adding of rows of which there is but one sort.
    fn plain(act: impl Into<String>, button: &'static str, problems: Vec<String>) -> Self {
        Self { act: act.into(), name: "", label: "", button, choices: Vec::new(), problems }
    }
}

impl FormRow {
    /// Its fields and those of the rows in it.
    pub fn all_fields(&self) -> impl Iterator<Item = &FormField> {
        self.fields.iter().chain(&self.rest).chain(self.parts.iter().flat_map(|part| &part.fields))
    }
}

/// Choices under a heading; an empty heading for none.
#[derive(Clone, Debug, Default)]
pub struct ChoiceGroup {
    /// Heading.
    pub title: &'static str,
    /// Choices.
    pub choices: Vec<SelectOption>,
}

/// How a field is filled in.
#[derive(Clone, Debug)]
pub enum FieldInput {
    /// A line.
    Line,
    /// Paragraphs.
    Prose,
    /// A sentence or two.
    Note,
    /// A number.
    Number,
    /// A box to tick.
    Tick,
    /// A choice.
    Choice(Vec<ChoiceGroup>),
}

/// A field.
#[derive(Clone, Debug)]
pub struct FormField {
    /// Its address in the document.
    pub field: String,
    /// What is asked for.
    pub label: String,
    /// In which unit; empty for none.
    pub unit: &'static str,
    /// What to know.
    pub hint: String,
    /// How it is filled in.
    pub input: FieldInput,
    /// What stands in it.
    pub value: String,
    /// What is wrong with it.
    pub problems: Vec<String>,
    /// Code of the language in which it is filled in; empty where the document says nothing of languages.
    pub language: String,
}

/// The id on the page of a field or row at an address.
#[must_use]
pub fn place_id(field: &str) -> String {
    let id = field.replace(['[', '.', ':', '_'], "-");
    format!("f-{}", id.replace(']', ""))
}

impl FormField {
    /// Its name in the form.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{FIELD_PREFIX}{}", self.field)
    }

    /// Its id on the page.
    #[must_use]
    pub fn id(&self) -> String {
        place_id(&self.field)
    }

    /// A number is typed into it.
    #[must_use]
    pub const fn is_number(&self) -> bool {
        matches!(self.input, FieldInput::Number)
    }

    /// How many lines of a text stand in it at once.
    #[must_use]
    pub const fn count_lines(&self) -> u8 {
        if matches!(self.input, FieldInput::Note) { 4 } else { 9 }
    }

    /// It takes a whole line of the form.
    #[must_use]
    pub const fn is_wide(&self) -> bool {
        matches!(self.input, FieldInput::Line | FieldInput::Prose | FieldInput::Note)
    }

    /// The same with something to know.
    #[must_use]
    fn hinted(self, hint: impl Into<String>) -> Self {
        Self { hint: hint.into(), ..self }
    }

    /// The same in a unit.
    #[must_use]
    fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}

impl DocumentForm {
    /// The same after a picture was refused, with what was typed of it.
    #[must_use]
    pub(crate) fn with_refused_picture(mut self, alt: &str, why: &str) -> Self {
        for adding in self.sections.iter_mut().filter_map(|section| section.uploading.as_mut()) {
            alt.clone_into(&mut adding.alt);
            adding.problems.push(why.to_owned());
        }
        self
    }

    /// Where a field is called what: the id of its place on the page, and its label with that of its row; of a field that stands
    /// nowhere, those of the nearest around it.
    #[must_use]
    pub fn find_place(&self, field: &str) -> Option<(String, String)> {
        let fields = self.sections.iter().flat_map(|section| {
            let alone = section.fields.iter().map(|field| (field, String::new()));
            let rows = section.rows.iter();
            alone.chain(rows.flat_map(|row| row.all_fields().map(|field| (field, format!("{}: ", row.title)))))
        });
        // A vector is where its first component is.
        let vector_of = |known: &'_ str| {
            known.strip_suffix(']').and_then(|known| known.rsplit_once('[')).map(|(vector, _)| vector.to_owned())
        };
        let is_it = |known: &str| known == field || vector_of(known).as_deref() == Some(field);
        if let Some((known, row)) = fields.into_iter().find(|(known, _)| is_it(&known.field)) {
            return Some((known.id(), format!("{row}{}", known.label)));
        }
        let mut rows = self.sections.iter().flat_map(|section| &section.rows);
        rows.find(|row| place_id(field).starts_with(&format!("{}-", row.id)) || row.id == place_id(field))
            .map(|row| (row.id.clone(), row.title.clone()))
            .or_else(|| self.find_section(field))
    }

    fn find_section(&self, field: &str) -> Option<(String, String)> {
        let array = field.split(['[', '.']).next()?;
        let section = self.sections.iter().find(|section| section.id == place_id(array))?;
        Some((section.id.to_owned(), section.title.to_owned()))
    }
}

/// Reads fields out of a document.
#[derive(Clone, Copy, Debug)]
struct FormReader<'d> {
    document: &'d EditedDocument,
    remarks: &'d [DraftRemark],
}

impl FormReader<'_> {
    fn field(&self, field: impl Into<String>, label: impl Into<String>, input: FieldInput) -> FormField {
        let (field, label) = (field.into(), label.into());
        let (value, problems) = (self.document.written_at(&field), self.problems_of(&field));
        FormField { value, problems, field, label, unit: "", hint: String::new(), input, language: String::new() }
    }

    /// A text in each language of the document.
    fn wording(&self, text: &str, label: &str, input: &FieldInput) -> Vec<FormField> {
        let languages = self.document.languages();
        let in_language = |language: &String| FormField {
            language: language.clone(),
            ..self.field(
                self.document.address_in(text, language),
                format!("{label} ({})", words::own_name(language)),
                input.clone(),
            )
        };
        match languages.as_slice() {
            [] => vec![self.field(text, label, input.clone())],
            [only] => vec![FormField { label: label.to_owned(), ..in_language(only) }],
            all => all.iter().map(in_language).collect(),
        }
    }

    /// In which languages the document is written.
    fn language_section(&self) -> FormSection {
        let languages = self.document.languages();
        let option = |code: &str| SelectOption {
            value: code.to_owned(),
            label: words::own_name(code).to_owned(),
            chosen: false,
        };
        let others = list_document_languages().filter(|code| languages.iter().all(|known| known != code));
        let choices = vec![ChoiceGroup { title: "", choices: others.map(option).collect() }];
        let all = plain_choices(list_document_languages().map(|code| (code, words::own_name(code).to_owned())));
        let own = self.choice("languages", tr!("This document is written in"), all);
        let row = |(at, code): (usize, &String)| FormRow {
            id: place_id(&format!("languages[{at}]")),
            title: words::own_name(code).to_owned(),
            note: if at == 0 {
                tr!("Its own language: for whoever speaks none of the others.").to_owned()
            } else {
                String::new()
            },
            removal: if at == 0 { String::new() } else { format!("remove:languages[{at}]") },
            loss: tr!("Every text in this language is removed from this draft.").to_owned(),
            ..FormRow::default()
        };
        FormSection {
            id: "f-languages",
            title: tr!("Languages"),
            about: tr!("Trainees read it in their language, where it is written in that, and else in its own."),
            fields: if languages.is_empty() { vec![own] } else { Vec::new() },
            rows: languages.iter().enumerate().map(row).collect(),
            adding: Some(RowAdding {
                act: "add:languages".to_owned(),
                name: "new.languages",
                label: tr!("Also in"),
                button: tr!("Add the language"),
                choices,
                problems: self.problems_of("languages"),
            }),
            ..FormSection::default()
        }
    }

    /// What is wrong with a field, or with the vector that it is a part of.
    fn problems_of(&self, field: &str) -> Vec<String> {
        let vector = field.strip_suffix(']').and_then(|field| field.rsplit_once('[')).map(|(vector, _)| vector);
        let is_here = |remark: &&DraftRemark| remark.field == field || Some(remark.field.as_str()) == vector;
        self.remarks.iter().filter(is_here).map(|remark| remark.what.clone()).collect()
    }

    /// A choice of words; what stands there and is none of them can be kept, too.
    fn choice(&self, field: &str, label: &str, choices: Vec<ChoiceGroup>) -> FormField {
        let made = self.field(field, label, FieldInput::Line);
        let input = FieldInput::Choice(mark_chosen(choices, &made.value));
        FormField { input, ..made }
    }
}

/// One group without a heading.
fn plain_choices<'c>(choices: impl IntoIterator<Item = (&'c str, String)>) -> Vec<ChoiceGroup> {
    let option = |(value, label): (&str, String)| SelectOption { value: value.to_owned(), label, chosen: false };
    vec![ChoiceGroup { title: "", choices: choices.into_iter().map(option).collect() }]
}

/// The choices with the chosen one marked; one that is none of them stands first.
fn mark_chosen(mut groups: Vec<ChoiceGroup>, chosen: &str) -> Vec<ChoiceGroup> {
    let mut options = groups.iter_mut().flat_map(|group| &mut group.choices);
    if let Some(option) = options.find(|option| option.value == chosen) {
        option.chosen = true;
    } else {
        let label = if chosen.is_empty() { tr!("Choose").to_owned() } else { chosen.to_owned() };
        let own = SelectOption { value: chosen.to_owned(), label, chosen: true };
        groups.insert(0, ChoiceGroup { title: "", choices: vec![own] });
    }
    groups
}
