//! Forms that edit documents: the fields of an exercise, a course and an instrument, with labels
//! and the problems at each.

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
use model::authoring::draft::DraftRemark;
pub use picture::{DraftPictures, PictureAdding};

use crate::authoring::pictures::ShownPicture;
use crate::form::SelectOption;

/// Prefix of the names of document fields in a form, which keeps them apart from the form's other
/// fields.
pub const FIELD_PREFIX: &str = "x.";

/// A document, displayed as a form.
#[derive(Clone, Debug, Default)]
pub struct DocumentForm {
    /// Sections in order.
    pub sections: Vec<FormSection>,
}

/// A section of a form.
#[derive(Clone, Debug, Default)]
pub struct FormSection {
    /// Id of the heading's element.
    pub id: &'static str,
    /// Heading.
    pub title: &'static str,
    /// Introductory text; may be empty.
    pub about: &'static str,
    /// Fields outside rows.
    pub fields: Vec<FormField>,
    /// Rows of fields.
    pub rows: Vec<FormRow>,
    /// Controls that add a row, if the section has rows.
    pub adding: Option<RowAdding>,
    /// Controls that add a picture, if the rows are pictures.
    pub uploading: Option<PictureAdding>,
}

/// A row of fields.
#[derive(Clone, Debug, Default)]
pub struct FormRow {
    /// Id of the row's element.
    pub id: String,
    /// Heading.
    pub title: String,
    /// Note shown in the row; may be empty.
    pub note: String,
    /// Picture that the row describes.
    pub picture: Option<ShownPicture>,
    /// Fields.
    pub fields: Vec<FormField>,
    /// Groups of checkboxes.
    pub boxes: Vec<FormBoxes>,
    /// Fields shown after the checkboxes.
    pub rest: Vec<FormField>,
    /// Nested rows.
    pub parts: Vec<FormRow>,
    /// Controls that add a nested row.
    pub adding: Option<RowAdding>,
    /// `None` if the row cannot be collapsed, else whether it is expanded.
    pub fold: Option<bool>,
    /// Value that the remove button sends; empty if the row cannot be removed.
    pub removal: String,
    /// Effects of the removal, to be confirmed first; empty if no confirmation is needed.
    pub loss: String,
    /// Buttons that move the row up or down, where possible.
    pub moves: Vec<RowMove>,
}

/// A group of checkboxes.
#[derive(Clone, Debug)]
pub struct FormBoxes {
    /// Heading.
    pub title: &'static str,
    /// Checkboxes.
    pub boxes: Vec<FormField>,
    /// Problems with the group.
    pub problems: Vec<String>,
}

/// A button that moves a row.
#[derive(Clone, Debug)]
pub struct RowMove {
    /// Value that the button sends.
    pub act: String,
    /// Label of the button.
    pub label: &'static str,
}

/// Controls that add a row.
#[derive(Clone, Debug)]
pub struct RowAdding {
    /// Value that the button sends.
    pub act: String,
    /// Form name of the selection.
    pub name: &'static str,
    /// Label of the selection.
    pub label: &'static str,
    /// Label of the button.
    pub button: &'static str,
    /// Kinds of row to select from; empty if there is only one kind.
    pub choices: Vec<ChoiceGroup>,
    /// Problems with the number of rows.
    pub problems: Vec<String>,
}

impl RowAdding {
    /// Creates controls for rows of a single kind.
    fn plain(act: impl Into<String>, button: &'static str, problems: Vec<String>) -> Self {
        Self { act: act.into(), name: "", label: "", button, choices: Vec::new(), problems }
    }
}

impl FormRow {
    /// Returns the row's fields and those of its nested rows.
    pub fn all_fields(&self) -> impl Iterator<Item = &FormField> {
        self.fields.iter().chain(&self.rest).chain(self.parts.iter().flat_map(|part| &part.fields))
    }
}

/// Options under a heading; the heading may be empty.
#[derive(Clone, Debug, Default)]
pub struct ChoiceGroup {
    /// Heading.
    pub title: &'static str,
    /// Options.
    pub choices: Vec<SelectOption>,
}

/// The input element of a field.
#[derive(Clone, Debug)]
pub enum FieldInput {
    /// One line of text.
    Line,
    /// Several paragraphs.
    Prose,
    /// One or two sentences.
    Note,
    /// A number.
    Number,
    /// A checkbox.
    Tick,
    /// A selection.
    Choice(Vec<ChoiceGroup>),
}

/// A field of a form.
#[derive(Clone, Debug)]
pub struct FormField {
    /// Address in the document.
    pub field: String,
    /// Label.
    pub label: String,
    /// Unit; empty if the field has none.
    pub unit: &'static str,
    /// Help text; may be empty.
    pub hint: String,
    /// Input element.
    pub input: FieldInput,
    /// Current value.
    pub value: String,
    /// Problems with the value.
    pub problems: Vec<String>,
    /// Code of the value's language; empty if the document declares no languages.
    pub language: String,
}

/// Returns the element id for the address of a field or row.
#[must_use]
pub fn place_id(field: &str) -> String {
    let id = field.replace(['[', '.', ':', '_'], "-");
    format!("f-{}", id.replace(']', ""))
}

impl FormField {
    /// Returns the field's name in the form.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{FIELD_PREFIX}{}", self.field)
    }

    /// Returns the field's element id.
    #[must_use]
    pub fn id(&self) -> String {
        place_id(&self.field)
    }

    /// Returns whether the field takes a number.
    #[must_use]
    pub const fn is_number(&self) -> bool {
        matches!(self.input, FieldInput::Number)
    }

    /// Returns the visible number of text lines.
    #[must_use]
    pub const fn count_lines(&self) -> u8 {
        if matches!(self.input, FieldInput::Note) { 4 } else { 9 }
    }

    /// Returns whether the field takes the full width of the form.
    #[must_use]
    pub const fn is_wide(&self) -> bool {
        matches!(self.input, FieldInput::Line | FieldInput::Prose | FieldInput::Note)
    }

    /// Sets the help text.
    #[must_use]
    fn hinted(self, hint: impl Into<String>) -> Self {
        Self { hint: hint.into(), ..self }
    }

    /// Sets the unit.
    #[must_use]
    fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}

impl DocumentForm {
    /// Shows why a picture was refused, and keeps the description the user entered.
    #[must_use]
    pub(crate) fn with_refused_picture(mut self, alt: &str, why: &str) -> Self {
        for adding in self.sections.iter_mut().filter_map(|section| section.uploading.as_mut()) {
            alt.clone_into(&mut adding.alt);
            adding.problems.push(why.to_owned());
        }
        self
    }

    /// Finds the place of a field on the page: its element id, and its label with that of its row.
    /// A field that is not shown leads to the nearest row or section around it.
    #[must_use]
    pub fn find_place(&self, field: &str) -> Option<(String, String)> {
        let fields = self.sections.iter().flat_map(|section| {
            let alone = section.fields.iter().map(|field| (field, String::new()));
            let rows = section.rows.iter();
            alone.chain(rows.flat_map(|row| row.all_fields().map(|field| (field, format!("{}: ", row.title)))))
        });
        // The address of a vector leads to its first component.
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

/// Builds form fields from a document.
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

    /// Returns one field of a text for each language of the document.
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

    /// Builds the section of the document's languages.
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
        let own = self.choice("languages", tr!("Language of this document"), all);
        let row = |(at, code): (usize, &String)| FormRow {
            id: place_id(&format!("languages[{at}]")),
            title: words::own_name(code).to_owned(),
            note: if at == 0 {
                tr!("Default language, shown to anyone whose language is not listed.").to_owned()
            } else {
                String::new()
            },
            removal: if at == 0 { String::new() } else { format!("remove:languages[{at}]") },
            loss: tr!("All texts in this language are removed from this draft.").to_owned(),
            ..FormRow::default()
        };
        FormSection {
            id: "f-languages",
            title: tr!("Languages"),
            about: tr!(
                "Trainees see the document in their own language if a translation exists, otherwise in its default language."
            ),
            fields: if languages.is_empty() { vec![own] } else { Vec::new() },
            rows: languages.iter().enumerate().map(row).collect(),
            adding: Some(RowAdding {
                act: "add:languages".to_owned(),
                name: "new.languages",
                label: tr!("Also available in"),
                button: tr!("Add the language"),
                choices,
                problems: self.problems_of("languages"),
            }),
            ..FormSection::default()
        }
    }

    /// Returns the problems with a field, or with the vector that contains it.
    fn problems_of(&self, field: &str) -> Vec<String> {
        let vector = field.strip_suffix(']').and_then(|field| field.rsplit_once('[')).map(|(vector, _)| vector);
        let is_here = |remark: &&DraftRemark| remark.field == field || Some(remark.field.as_str()) == vector;
        self.remarks.iter().filter(is_here).map(|remark| remark.what.clone()).collect()
    }

    /// Creates a selection. A current value that is not among the options is kept as an additional
    /// one.
    fn choice(&self, field: &str, label: &str, choices: Vec<ChoiceGroup>) -> FormField {
        let made = self.field(field, label, FieldInput::Line);
        let input = FieldInput::Choice(mark_chosen(choices, &made.value));
        FormField { input, ..made }
    }
}

/// Wraps options in one group without a heading.
fn plain_choices<'c>(choices: impl IntoIterator<Item = (&'c str, String)>) -> Vec<ChoiceGroup> {
    let option = |(value, label): (&str, String)| SelectOption { value: value.to_owned(), label, chosen: false };
    vec![ChoiceGroup { title: "", choices: choices.into_iter().map(option).collect() }]
}

/// Marks the chosen option; a value that is not among the options is inserted first.
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
