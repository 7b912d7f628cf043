//! The form of an exercise.

use assessment::catalogue::{self, Definition};
use documents::Feedback;
use documents::metrics::{METRICS, SceneNames};
use model::authoring::EditedDocument;
use model::authoring::draft::DraftRemark;

use super::{
    ChoiceGroup, DocumentForm, DraftPictures, FieldInput, FormField, FormReader, FormRow, FormSection, RowAdding,
    mark_chosen, place_id, plain_choices,
};
use crate::form::SelectOption;
use crate::metric::GROUPS;
use crate::{anatomy, metric};

/// Data that the form of an exercise needs in addition to the document.
#[derive(Clone, Debug)]
pub struct ExerciseContext {
    /// Names of the layers, structures and targets of its scene.
    pub scene: SceneNames,
    /// Pictures of the draft.
    pub pictures: DraftPictures,
}

/// Builds the form of an exercise in a scene, with the remarks shown at their fields.
#[must_use]
pub fn make_exercise_form(
    document: &EditedDocument,
    remarks: &[DraftRemark],
    context: &ExerciseContext,
) -> DocumentForm {
    let form = ExerciseFormMaker { read: FormReader { document, remarks }, scene: &context.scene };
    let sections = vec![
        form.about_section(),
        form.read.picture_section(&context.pictures),
        form.place_section(),
        form.required_section(),
        form.rubric_section(),
        form.limit_section(),
        form.coaching_section(),
        form.read.language_section(),
    ];
    DocumentForm { sections }
}

struct ExerciseFormMaker<'d> {
    read: FormReader<'d>,
    scene: &'d SceneNames,
}

impl ExerciseFormMaker<'_> {
    fn about_section(&self) -> FormSection {
        let read = &self.read;
        let levels = ["1", "2", "3", "4", "5"].map(|level| (level, tr!("{difficulty} of 5", difficulty = level)));
        let difficulty = std::iter::once(("", tr!("Not set: 1").to_owned())).chain(levels);
        let given = Feedback::ALL.map(say_feedback);
        let given = std::iter::once(("", tr!("Not set: everything").to_owned())).chain(given);
        let mut said = read.wording("title", tr!("Title"), &FieldInput::Line);
        let briefing = read.wording("briefing", tr!("Briefing"), &FieldInput::Prose);
        said.extend(
            briefing
                .into_iter()
                .map(|text| text.hinted(tr!("Shown before the attempt. An empty line begins a paragraph."))),
        );
        FormSection {
            id: "f-about",
            title: tr!("What to do"),
            fields: said
                .into_iter()
                .chain([
                    read.choice("difficulty", tr!("Difficulty"), plain_choices(difficulty)),
                    read.field("pass_mark", tr!("Pass mark"), FieldInput::Number)
                        .hinted(tr!("Points of 100. Empty: 70.")),
                    read.field("time_limit_s", tr!("Time limit"), FieldInput::Number)
                        .in_unit("s")
                        .hinted(tr!("Empty: 300.")),
                    read.choice("feedback", tr!("What the trainee sees and feels"), plain_choices(given)),
                ])
                .collect(),
            ..FormSection::default()
        }
    }

    fn place_section(&self) -> FormSection {
        let read = &self.read;
        let number = |field: &str, label: &str, unit| read.field(field, label, FieldInput::Number).in_unit(unit);
        FormSection {
            id: "f-target",
            title: tr!("Target and entry"),
            about: tr!("The drawing on this page shows both."),
            fields: vec![
                number("target.depth_mm", tr!("Target depth"), "mm").hinted(tr!("Along the needle, from the skin.")),
                number("entry.angle_deg", tr!("Angle"), "°").hinted(tr!("To the perpendicular of the skin. Empty: 0.")),
                number("entry.azimuth_deg", tr!("Heading of the tip"), "°")
                    .hinted(tr!("Seen from outside, from +x to +y. Empty: 0.")),
                number("entry.point_mm[0]", tr!("Entry on the skin, x"), "mm").hinted(tr!("Both empty: the middle.")),
                number("entry.point_mm[1]", tr!("Entry on the skin, y"), "mm"),
            ],
            ..FormSection::default()
        }
    }

    fn required_section(&self) -> FormSection {
        let read = &self.read;
        let there = read.document.is_written("required");
        let present = FormField {
            value: if there { "yes" } else { "" }.to_owned(),
            ..read.field("required", tr!("No points until all of these are done"), FieldInput::Tick)
        };
        let layers = self.scene.layers.iter().map(|layer| (layer.as_str(), anatomy::say_structure(layer)));
        let layers = std::iter::once(("", tr!("None").to_owned())).chain(layers);
        FormSection {
            id: "f-required",
            title: tr!("Required steps"),
            about: tr!("If ticked, lines for a layer that was never reached score zero."),
            fields: vec![
                present,
                read.choice("required.reached", tr!("Layer whose boundary was opened"), plain_choices(layers)),
                read.field("required.within_mm", tr!("Largest distance from the target depth"), FieldInput::Number)
                    .in_unit("mm"),
                read.field("required.confirmed", tr!("The position was confirmed in the body"), FieldInput::Tick),
                read.field("required.withdrawn", tr!("The needle was withdrawn"), FieldInput::Tick),
            ],
            ..FormSection::default()
        }
    }

    fn rubric_section(&self) -> FormSection {
        FormSection {
            id: "f-rubric",
            title: tr!("Rubric"),
            about: tr!(
                "A line scores 100 % at the value for full marks, 0 % at the value for no marks, and proportionally in between. The score is the weighted mean."
            ),
            rows: (0..self.read.document.count_rows("rubric")).map(|row| self.rubric_row(row)).collect(),
            adding: Some(self.metric_adding("add:rubric", "new.rubric", tr!("Add a line"), "rubric")),
            ..FormSection::default()
        }
    }

    fn rubric_row(&self, row: usize) -> FormRow {
        let read = &self.read;
        let at = |key: &str| format!("rubric[{row}].{key}");
        let known = self.definition_of(&at("metric"));
        let unit = known.map_or("", |known| unit_in_words(known.unit));
        let number = |key: &str, label: &str, unit| read.field(at(key), label, FieldInput::Number).in_unit(unit);
        self.metric_row(
            "rubric",
            row,
            vec![
                number("full", tr!("Full marks at"), unit),
                number("zero", tr!("No marks at"), unit),
                number("weight", tr!("Weight"), "").hinted(tr!("Empty: 1.")),
            ],
        )
    }

    fn limit_section(&self) -> FormSection {
        FormSection {
            id: "f-hard-fail",
            title: tr!("Limits"),
            about: tr!("An attempt that goes above one of these fails, whatever its score."),
            rows: (0..self.read.document.count_rows("hard_fail")).map(|row| self.limit_row(row)).collect(),
            adding: Some(self.metric_adding("add:hard_fail", "new.hard_fail", tr!("Add a limit"), "hard_fail")),
            ..FormSection::default()
        }
    }

    fn limit_row(&self, row: usize) -> FormRow {
        let at = |key: &str| format!("hard_fail[{row}].{key}");
        let unit = self.definition_of(&at("metric")).map_or("", |known| unit_in_words(known.unit));
        let mut fields = vec![self.read.field(at("above"), tr!("Fails above"), FieldInput::Number).in_unit(unit)];
        fields.extend(self.read.wording(&at("why"), tr!("Message to the trainee"), &FieldInput::Line));
        self.metric_row("hard_fail", row, fields)
    }

    /// Builds a row that begins with the choice of a metric and states which direction is better.
    fn metric_row(&self, array: &str, row: usize, fields: Vec<FormField>) -> FormRow {
        let at = format!("{array}[{row}].metric");
        let (chosen, read) = (self.read.document.metric_at(&at), &self.read);
        let id = chosen.split('@').next().unwrap_or_default().to_owned();
        let better = self.definition_of(&at).map(|known| metric::say_better_way(&id, known.direction, &[]));
        let input = FieldInput::Choice(mark_chosen(self.metric_choices(), &chosen));
        let mut problems = read.problems_of(&at);
        problems.extend(read.problems_of(&format!("{array}[{row}].version")));
        let picked = FormField { value: chosen, problems, ..read.field(at, tr!("Metric"), input) };
        FormRow {
            id: place_id(&format!("{array}[{row}]")),
            title: format!("{}. {}", row + 1, metric::metric_label(&id)),
            note: better.map_or_else(String::new, |better| tr!("Better: {way}.", way = better)),
            fields: std::iter::once(picked).chain(fields).collect(),
            removal: format!("remove:{array}[{row}]"),
            ..FormRow::default()
        }
    }

    fn definition_of(&self, field: &str) -> Option<&'static Definition> {
        let chosen = self.read.document.metric_at(field);
        catalogue::newest_definition(chosen.split('@').next().unwrap_or_default())
    }

    fn metric_adding(&self, act: &'static str, name: &'static str, button: &'static str, array: &str) -> RowAdding {
        let problems = self.read.problems_of(array);
        RowAdding { act: act.to_owned(), name, label: tr!("Metric"), button, choices: self.metric_choices(), problems }
    }

    /// Returns all metrics that a rubric may use in this scene, under the headings that scores use.
    fn metric_choices(&self) -> Vec<ChoiceGroup> {
        let offered = METRICS.iter().flat_map(|known| known.ids_in(self.scene)).filter_map(|id| metric_option(&id));
        let offered: Vec<SelectOption> = offered.collect();
        let mut groups: Vec<ChoiceGroup> =
            GROUPS.iter().map(|(title, _)| ChoiceGroup { title: words::say(title), choices: Vec::new() }).collect();
        for option in offered {
            let claims = |(_, starts): &(&str, &[&str])| starts.iter().any(|start| option.value.starts_with(start));
            if let Some(group) = GROUPS.iter().position(claims) {
                groups[group].choices.push(option);
            }
        }
        groups.retain(|group| !group.choices.is_empty());
        groups
    }

    fn coaching_section(&self) -> FormSection {
        FormSection {
            id: "f-coaching",
            title: tr!("Coaching"),
            about: tr!(
                "Shown during the attempt when a value rises above the limit, and again after it has fallen below the second limit."
            ),
            rows: (0..self.read.document.count_rows("coaching")).map(|row| self.coaching_row(row)).collect(),
            adding: Some(RowAdding {
                act: "add:coaching".to_owned(),
                name: "new.coaching",
                label: tr!("Measured value"),
                button: tr!("Add a message"),
                choices: plain_choices(QUANTITIES.iter().map(|known| (known.0, words::say(known.1).to_owned()))),
                problems: self.read.problems_of("coaching"),
            }),
            ..FormSection::default()
        }
    }

    fn coaching_row(&self, row: usize) -> FormRow {
        let read = &self.read;
        let at = |key: &str| format!("coaching[{row}].{key}");
        let watched = read.document.written_at(&at("quantity"));
        let known = QUANTITIES.iter().find(|known| known.0 == watched);
        let unit = known.map_or("", |known| known.2);
        let choices = plain_choices(QUANTITIES.iter().map(|known| (known.0, words::say(known.1).to_owned())));
        FormRow {
            id: place_id(&format!("coaching[{row}]")),
            title: format!("{}. {}", row + 1, known.map_or(watched.as_str(), |known| words::say(known.1))),
            note: String::new(),
            fields: vec![
                read.choice(&at("quantity"), tr!("Measured value"), choices),
                read.field(at("above"), tr!("Show when above"), FieldInput::Number).in_unit(unit),
                read.field(at("rearm_below"), tr!("Show again after falling below"), FieldInput::Number)
                    .in_unit(unit)
                    .hinted(tr!("Empty: the same.")),
            ]
            .into_iter()
            .chain(read.wording(&at("message"), tr!("Message"), &FieldInput::Line))
            .collect(),
            removal: format!("remove:coaching[{row}]"),
            ..FormRow::default()
        }
    }
}

/// Quantities that coaching can watch: key, name and unit.
const QUANTITIES: [(&str, &str, &str); 4] = [
    ("depth_mm", sentence!("Depth along the needle"), "mm"),
    ("force_n", sentence!("Force"), "N"),
    ("speed_mm_per_s", sentence!("Speed"), "mm/s"),
    ("angle_error_deg", sentence!("Error of the angle"), "°"),
];

/// Returns the newest version of a metric as an option; `None` if rubrics may no longer use it.
fn metric_option(id: &str) -> Option<SelectOption> {
    let newest = catalogue::newest_definition(id).filter(|known| known.unoffered.is_empty())?;
    let version = newest.version;
    let value = if version > 1 { format!("{id}@{version}") } else { id.to_owned() };
    let (label, better) = (metric::metric_label(id), metric::say_better_way(id, newest.direction, &[]));
    let label = match unit_in_words(newest.unit) {
        "" => tr!("{metric} (better: {way})", metric = label, way = better),
        unit => tr!("{metric} in {unit} (better: {way})", metric = label, unit = unit, way = better),
    };
    Some(SelectOption { value, label, chosen: false })
}

/// Returns a unit as displayed; empty for counts and dimensionless numbers.
fn unit_in_words(unit: &'static str) -> &'static str {
    match unit {
        "count" | "1" => "",
        "deg" => "°",
        other => other,
    }
}

fn say_feedback(feedback: Feedback) -> (&'static str, String) {
    match feedback {
        Feedback::Both => ("both", tr!("Everything").to_owned()),
        Feedback::Force => ("force", tr!("Force feedback only").to_owned()),
        Feedback::Picture => {
            ("picture", tr!("The inside of the body in the picture, without force feedback").to_owned())
        }
        Feedback::Fluoroscopy => {
            ("fluoroscopy", tr!("Force in the hand and X-rays, without inside and target").to_owned())
        }
        Feedback::Overlay => ("overlay", tr!("Depth and force as numbers, without force feedback").to_owned()),
    }
}
