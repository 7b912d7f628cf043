//! Submitted form data of a document.

use super::instrument::InstrumentNames;
use super::languages::split_language;
use super::{EditedDocument, FieldSort};

/// Fields of an exercise, course or instrument that a form can change, without row numbers.
const FIELDS: &[(&str, FieldSort)] = &[
    ("title", FieldSort::Text),
    ("languages", FieldSort::OwnLanguage),
    ("briefing", FieldSort::Text),
    ("description", FieldSort::Text),
    ("difficulty", FieldSort::Number),
    ("pass_mark", FieldSort::Number),
    ("time_limit_s", FieldSort::Number),
    ("feedback", FieldSort::Text),
    ("entry.point_mm[]", FieldSort::Number),
    ("entry.angle_deg", FieldSort::Number),
    ("entry.azimuth_deg", FieldSort::Number),
    ("target.depth_mm", FieldSort::Number),
    ("required", FieldSort::Presence),
    ("required.reached", FieldSort::Text),
    ("required.within_mm", FieldSort::Number),
    ("required.confirmed", FieldSort::Flag),
    ("required.withdrawn", FieldSort::Flag),
    ("rubric[].metric", FieldSort::Metric),
    ("rubric[].full", FieldSort::Number),
    ("rubric[].zero", FieldSort::Number),
    ("rubric[].weight", FieldSort::Number),
    ("hard_fail[].metric", FieldSort::Metric),
    ("hard_fail[].above", FieldSort::Number),
    ("hard_fail[].why", FieldSort::Text),
    ("coaching[].quantity", FieldSort::Text),
    ("coaching[].above", FieldSort::Number),
    ("coaching[].rearm_below", FieldSort::Number),
    ("coaching[].message", FieldSort::Text),
    ("picture[].alt", FieldSort::Text),
    ("picture[].caption", FieldSort::Text),
    ("mastery.rule", FieldSort::Text),
    ("mastery.passes", FieldSort::Number),
    ("mastery.of", FieldSort::Number),
    ("mastery.p0", FieldSort::Number),
    ("mastery.p1", FieldSort::Number),
    ("mastery.alpha", FieldSort::Number),
    ("mastery.beta", FieldSort::Number),
    ("mastery.within", FieldSort::Number),
    ("exercise[].survey", FieldSort::Text),
    ("exercise[].prerequisites", FieldSort::Ids),
    ("duration_min", FieldSort::Number),
    ("source", FieldSort::Text),
    ("licence", FieldSort::Text),
    ("scale[].id", FieldSort::Text),
    ("scale[].kind", FieldSort::Text),
    ("scale[].points", FieldSort::Number),
    ("scale[].labels", FieldSort::TextList),
    ("scale[].relevant_from", FieldSort::Number),
    ("scale[].min", FieldSort::Number),
    ("scale[].max", FieldSort::Number),
    ("scale[].step", FieldSort::Number),
    ("scale[].unit", FieldSort::Text),
    ("scale[].max_characters", FieldSort::Number),
    ("scale[].option[].id", FieldSort::Text),
    ("section[].id", FieldSort::Text),
    ("section[].when.item", FieldSort::Subject),
    ("section[].when.is", FieldSort::Ids),
    ("item[].id", FieldSort::Text),
    ("item[].section", FieldSort::Text),
    ("item[].scale", FieldSort::Text),
    ("item[].pair[]", FieldSort::Text),
    ("item[].when.item", FieldSort::Subject),
    ("item[].when.is", FieldSort::Ids),
    ("score[].id", FieldSort::Text),
    ("score[].items", FieldSort::Ids),
    ("score[].reversed", FieldSort::Ids),
    ("score[].pairs", FieldSort::Ids),
    ("score[].shift", FieldSort::Number),
    ("score[].combine", FieldSort::Text),
    ("score[].factor", FieldSort::Number),
    ("score[].offset", FieldSort::Number),
    ("score[].missing", FieldSort::Text),
    ("score[].least_answered", FieldSort::Number),
    ("score[].better", FieldSort::Text),
];

/// A field and its entered value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypedField {
    /// Address of the field.
    pub field: String,
    /// Entered value, with the line endings of TOML.
    pub typed: String,
}

/// Submitted data of a form.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SentForm {
    /// All checkboxes of the form: browsers do not submit unchecked ones.
    pub boxes: Vec<String>,
    /// Entered values, in the order of the form, including checked boxes.
    pub fields: Vec<TypedField>,
}

impl SentForm {
    /// Writes the data to a document.
    pub fn write_into(&self, document: &mut EditedDocument) {
        let before = document.written_at("mastery.rule");
        let names = InstrumentNames::of(document);
        let gone: Vec<&str> = self.tables_without_tick(document).collect();
        for table in &gone {
            document.write_field(table, FieldSort::Presence, "");
        }
        let is_below = |rest: &str| rest.starts_with(['.', '[']);
        let is_gone = |field: &str| gone.iter().any(|table| field.strip_prefix(table).is_some_and(is_below));
        for TypedField { field, typed } in self.fields.iter().filter(|sent| !is_gone(&sent.field)) {
            if let Some(sort) = sort_of_field(field) {
                document.write_field(field, sort, typed);
            }
        }
        for field in self.boxes.iter().filter(|field| !is_gone(field)) {
            self.write_box(document, field);
        }
        let rule = document.written_at("mastery.rule");
        if rule != before {
            drop_keys_of_other_rules(document, &rule);
        }
        names.follow(document);
    }

    fn is_ticked(&self, field: &str) -> bool {
        self.fields.iter().any(|sent| sent.field == field && !sent.typed.is_empty())
    }

    /// Returns the existing tables whose checkbox in the form is unchecked.
    fn tables_without_tick<'s>(&'s self, document: &EditedDocument) -> impl Iterator<Item = &'s str> {
        let is_table =
            |field: &&String| matches!(sort_of_field(field), Some(FieldSort::Presence | FieldSort::TextList));
        let there: Vec<&str> =
            self.boxes.iter().filter(is_table).map(String::as_str).filter(|field| document.is_written(field)).collect();
        there.into_iter().filter(|field| !self.is_ticked(field))
    }

    fn write_box(&self, document: &mut EditedDocument, field: &str) {
        if let Some((list, id)) = field.split_once(':') {
            // The options of a condition are removed together with the condition.
            let is_there = list.rsplit_once('.').is_some_and(|(table, _)| document.is_written(table));
            if is_there && sort_of_field(list) == Some(FieldSort::Ids) {
                document.tick_id(list, id, self.is_ticked(field));
            }
        } else if sort_of_field(field) == Some(FieldSort::Flag) && !self.is_ticked(field) {
            document.write_field(field, FieldSort::Flag, "");
        }
    }
}

/// Removes keys of other mastery rules after the author has chosen one.
fn drop_keys_of_other_rules(document: &mut EditedDocument, rule: &str) {
    let others: &[&str] = match rule {
        "passes" => &["p0", "p1", "alpha", "beta", "within"],
        "cusum" => &["passes", "of", "within"],
        "lc-cusum" => &["passes", "of"],
        _ => &[],
    };
    for key in others {
        document.write_field(&format!("mastery.{key}"), FieldSort::Text, "");
    }
}

/// Returns the type of a field, or `None` if no form has it.
fn sort_of_field(field: &str) -> Option<FieldSort> {
    if split_language(field).is_some() {
        return Some(FieldSort::Translation);
    }
    let pattern = pattern_of_field(field);
    FIELDS.iter().find(|(known, _)| *known == pattern).map(|(_, sort)| *sort)
}

/// Returns an address without row numbers.
pub(super) fn pattern_of_field(field: &str) -> String {
    let mut pattern = String::new();
    let mut in_row = false;
    for c in field.chars() {
        in_row = (in_row || c == '[') && c != ']';
        if !in_row || c == '[' {
            pattern.push(c);
        }
    }
    pattern
}
