//! The form of a course.

use std::collections::BTreeMap;

use model::authoring::draft::DraftRemark;
use model::authoring::{EditedDocument, find_exercise_id};

use super::{
    ChoiceGroup, DocumentForm, FieldInput, FormBoxes, FormField, FormReader, FormRow, FormSection, RowAdding, RowMove,
    place_id, plain_choices,
};
use crate::form::SelectOption;

/// An exercise that a course may contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CourseExercise {
    /// Its id.
    pub id: String,
    /// Its title.
    pub title: String,
}

/// The school's published exercises and instruments, from which a course is built.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CourseContext {
    /// The school's published exercises.
    pub exercises: Vec<CourseExercise>,
    /// The school's instruments: id and title.
    pub instruments: Vec<(String, String)>,
    /// Exercise ids by the file names used in the course document.
    pub files: BTreeMap<String, String>,
}

impl CourseContext {
    fn title_of(&self, id: &str) -> String {
        let known = self.exercises.iter().find(|exercise| exercise.id == id);
        known.map_or_else(|| id.to_owned(), |exercise| exercise.title.clone())
    }
}

/// Builds the form of a course, with the remarks shown at their fields.
#[must_use]
pub fn make_course_form(document: &EditedDocument, remarks: &[DraftRemark], context: &CourseContext) -> DocumentForm {
    let form = CourseFormMaker { read: FormReader { document, remarks }, context };
    DocumentForm {
        sections: vec![
            form.about_section(),
            form.mastery_section(),
            form.exercise_section(),
            form.read.language_section(),
        ],
    }
}

struct CourseFormMaker<'d> {
    read: FormReader<'d>,
    context: &'d CourseContext,
}

impl CourseFormMaker<'_> {
    fn about_section(&self) -> FormSection {
        let mut fields = self.read.wording("title", tr!("Title"), &FieldInput::Line);
        fields.extend(self.read.wording("description", tr!("What the course teaches"), &FieldInput::Prose));
        FormSection { id: "f-about", title: tr!("The course"), fields, ..FormSection::default() }
    }

    fn mastery_section(&self) -> FormSection {
        let read = &self.read;
        let rules = [
            ("passes", tr!("A number of passes within the last attempts").to_owned()),
            ("lc-cusum", tr!("The learning curve (LC-CUSUM) shows competence").to_owned()),
            ("cusum", tr!("The failure chart (CUSUM) stays below its limit").to_owned()),
        ];
        let number = |key: &str, label: &str| read.field(format!("mastery.{key}"), label, FieldInput::Number);
        let mut fields = vec![read.choice("mastery.rule", tr!("Rule"), plain_choices(rules))];
        let rule = read.document.written_at("mastery.rule");
        let shown = |keys: &[&str]| keys.iter().any(|key| read.document.is_written(&format!("mastery.{key}")));
        if rule == "passes" || shown(&["passes", "of"]) {
            fields.push(number("passes", tr!("Passes")));
            fields.push(number("of", tr!("Number of last attempts")));
        }
        if rule != "passes" || shown(&["p0", "p1", "alpha", "beta", "within"]) {
            fields.push(number("p0", tr!("Acceptable failure rate")).hinted(tr!("Between 0 and 1, like 0.2.")));
            fields.push(number("p1", tr!("Unacceptable failure rate")));
            fields.push(number("alpha", tr!("Proportion of non-competent trainees passed as competent (α)")));
            fields.push(number("beta", tr!("Proportion of competent trainees missed (β)")));
        }
        if rule == "lc-cusum" || shown(&["within"]) {
            fields.push(number("within", tr!("Within how many attempts")).hinted(tr!("Empty: 50.")));
        }
        FormSection {
            id: "f-mastery",
            title: tr!("When an exercise is mastered"),
            about: tr!("Save after you choose another rule, to see its fields."),
            fields,
            ..FormSection::default()
        }
    }

    fn exercise_section(&self) -> FormSection {
        let count = self.read.document.count_rows("exercise");
        let ids: Vec<String> = (0..count).map(|row| self.id_at(row)).collect();
        let others = self.context.exercises.iter().filter(|exercise| !ids.contains(&exercise.id));
        let option = |exercise: &CourseExercise| SelectOption {
            value: exercise.id.clone(),
            label: exercise.title.clone(),
            chosen: false,
        };
        let choices = vec![ChoiceGroup { title: "", choices: others.map(option).collect() }];
        FormSection {
            id: "f-exercise",
            title: tr!("Exercises"),
            about: tr!("In the order in which trainees see them."),
            rows: (0..count).map(|row| self.exercise_row(row, &ids)).collect(),
            adding: Some(RowAdding {
                act: "add:exercise".to_owned(),
                name: "new.exercise",
                label: tr!("Exercise"),
                button: tr!("Add the exercise"),
                choices,
                problems: self.read.problems_of("exercise"),
            }),
            ..FormSection::default()
        }
    }

    fn id_at(&self, row: usize) -> String {
        find_exercise_id(&self.context.files, &self.read.document.written_at(&format!("exercise[{row}].file")))
    }

    fn exercise_row(&self, row: usize, ids: &[String]) -> FormRow {
        let at = |key: &str| format!("exercise[{row}].{key}");
        let asked = self.context.instruments.iter().map(|(id, title)| (id.as_str(), title.clone()));
        let asked = std::iter::once(("", tr!("Nothing").to_owned())).chain(asked);
        let up = (row > 0).then(|| RowMove { act: format!("up:exercise[{row}]"), label: tr!("Up") });
        let down = (row + 1 < ids.len()).then(|| RowMove { act: format!("down:exercise[{row}]"), label: tr!("Down") });
        FormRow {
            id: place_id(&format!("exercise[{row}]")),
            title: format!("{}. {}", row + 1, self.context.title_of(&ids[row])),
            note: self.read.problems_of(&at("file")).join(" "),
            fields: vec![self.read.choice(&at("survey"), tr!("After each attempt"), plain_choices(asked))],
            boxes: self.prerequisites_of(row, ids).into_iter().collect(),
            removal: format!("remove:exercise[{row}]"),
            moves: up.into_iter().chain(down).collect(),
            ..FormRow::default()
        }
    }

    /// Returns checkboxes for the prerequisites: every other exercise of the course, and the ids
    /// already listed.
    fn prerequisites_of(&self, row: usize, ids: &[String]) -> Option<FormBoxes> {
        let list = format!("exercise[{row}].prerequisites");
        let ticked = self.read.document.texts_at(&list);
        let others = ids.iter().enumerate().filter(|(other, _)| *other != row).map(|(_, id)| id);
        let odd = ticked.iter().filter(|id| !ids.contains(id));
        let tick = |id: &String| FormField {
            value: if ticked.contains(id) { "yes" } else { "" }.to_owned(),
            ..self.read.field(format!("{list}:{id}"), self.context.title_of(id), FieldInput::Tick)
        };
        let boxes: Vec<FormField> = others.chain(odd).map(tick).collect();
        let problems = self.read.problems_of(&list);
        (!boxes.is_empty()).then_some(FormBoxes { title: tr!("Prerequisites"), boxes, problems })
    }
}
