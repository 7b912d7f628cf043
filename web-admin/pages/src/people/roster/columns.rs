//! Column mapping of a roster, selected next to a preview of the first lines.

use askama::Template;
use askama_web::WebTemplate;
use model::ids::RosterId;
use model::people::roster::{
    GroupSplit, LineOutcome, MappingDoubt, Refusal, RosterChange, RosterColumn, RosterMapping, RosterOutcome,
};
use serde::Deserialize;

use crate::form::{FilledForm, SelectOption, read_trimmed_text};
use crate::people::roster;
use crate::{Shell, format};

/// The page that maps the columns of a roster file.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/roster/columns.html")]
pub struct RosterColumnsPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the pending roster.
    pub id: RosterId,
    /// Name of the uploaded file.
    pub file_name: String,
    /// Heading of each column, and its first value.
    pub columns: Vec<(String, Option<String>)>,
    /// Why the mapping must be confirmed.
    pub doubts: Vec<MappingDoubt>,
    /// The mapping form, with the reason if it was refused.
    pub form: FilledForm<RosterColumnsForm, ColumnsRefused>,
    /// Preview of the first lines.
    pub lines: Vec<LineOutcome>,
}

/// Reasons why a mapping was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnsRefused {
    /// No column for the name.
    NoName,
    /// No column for the email address.
    NoEmail,
    /// A column is used twice.
    Twice,
    /// The domain is invalid.
    Domain,
}

/// Input of the mapping form: for each property the index of its column, or empty.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RosterColumnsForm {
    /// Full name.
    pub name: String,
    /// Given name.
    pub given: String,
    /// Family name.
    pub family: String,
    /// Email address.
    pub email: String,
    /// Sign-in name.
    pub login: String,
    /// Registrar's number.
    pub registrar_id: String,
    /// Cohorts.
    pub cohort: String,
    /// Role: trainee or instructor.
    pub role: String,
    /// Status: active or deleted.
    pub status: String,
    /// Whether the account may be used.
    pub enabled: String,
    /// Whether the account is suspended.
    pub suspended: String,
    /// Whether the account is deleted.
    pub deleted: String,
    /// Separator of several cohorts.
    pub split: String,
    /// Domain appended to addresses without an @ sign.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub domain: String,
    /// Set by the button that only updates the preview.
    pub look: String,
}

impl RosterColumnsForm {
    /// Fills the form from a mapping.
    #[must_use]
    pub fn of_mapping(mapping: &RosterMapping) -> Self {
        let place = |column| mapping.columns.get(&column).map(usize::to_string).unwrap_or_default();
        Self {
            name: place(RosterColumn::Name),
            given: place(RosterColumn::Given),
            family: place(RosterColumn::Family),
            email: place(RosterColumn::Email),
            login: place(RosterColumn::Login),
            registrar_id: place(RosterColumn::RegistrarId),
            cohort: place(RosterColumn::Cohort),
            role: place(RosterColumn::Role),
            status: place(RosterColumn::Status),
            enabled: place(RosterColumn::Enabled),
            suspended: place(RosterColumn::Suspended),
            deleted: place(RosterColumn::Deleted),
            split: split_word(mapping.split).to_owned(),
            domain: mapping.domain.clone().unwrap_or_default(),
            look: String::new(),
        }
    }

    fn places(&self) -> [(RosterColumn, &String); 12] {
        [
            (RosterColumn::Name, &self.name),
            (RosterColumn::Given, &self.given),
            (RosterColumn::Family, &self.family),
            (RosterColumn::Email, &self.email),
            (RosterColumn::Login, &self.login),
            (RosterColumn::RegistrarId, &self.registrar_id),
            (RosterColumn::Cohort, &self.cohort),
            (RosterColumn::Role, &self.role),
            (RosterColumn::Status, &self.status),
            (RosterColumn::Enabled, &self.enabled),
            (RosterColumn::Suspended, &self.suspended),
            (RosterColumn::Deleted, &self.deleted),
        ]
    }

    /// Returns the mapping that was selected.
    #[must_use]
    pub fn mapping(&self) -> RosterMapping {
        let columns = self.places().into_iter().filter_map(|(column, place)| Some((column, place.parse().ok()?)));
        let splits = [GroupSplit::One, GroupSplit::Comma, GroupSplit::Semicolon, GroupSplit::Sentence];
        RosterMapping {
            columns: columns.collect(),
            split: splits.into_iter().find(|split| split_word(*split) == self.split).unwrap_or_default(),
            domain: Some(self.domain.trim_start_matches('@').to_lowercase()).filter(|domain| !domain.is_empty()),
        }
    }
}

const fn split_word(split: GroupSplit) -> &'static str {
    match split {
        GroupSplit::One => "one",
        GroupSplit::Comma => "comma",
        GroupSplit::Semicolon => "semicolon",
        GroupSplit::Sentence => "sentence",
    }
}

/// Names the property of a roster column.
#[must_use]
pub fn say_column(column: RosterColumn) -> &'static str {
    match column {
        RosterColumn::Email => tr!("email address"),
        RosterColumn::Login => tr!("sign-in name, if the email address is empty"),
        RosterColumn::Name => tr!("full name"),
        RosterColumn::Given => tr!("given name"),
        RosterColumn::Family => tr!("family name"),
        RosterColumn::RegistrarId => tr!("registrar’s number"),
        RosterColumn::Cohort => tr!("cohort"),
        RosterColumn::Role => tr!("role: trainee or instructor"),
        RosterColumn::Status => tr!("status: active or deleted"),
        RosterColumn::Enabled => tr!("account enabled: true or false"),
        RosterColumn::Suspended => tr!("account suspended: 1 or 0"),
        RosterColumn::Deleted => tr!("account deleted: 1 or 0"),
    }
}

/// A selection among the columns of a file.
struct ColumnChoice {
    name: &'static str,
    label: String,
    choices: Vec<SelectOption>,
    wrong: bool,
}

impl RosterColumnsPage {
    fn fields(&self) -> Vec<ColumnChoice> {
        const NAMES: [&str; 12] = [
            "name",
            "given",
            "family",
            "email",
            "login",
            "registrar_id",
            "cohort",
            "role",
            "status",
            "enabled",
            "suspended",
            "deleted",
        ];
        let places = self.form.typed.places();
        let field = |((column, chosen), name): ((RosterColumn, &String), &'static str)| ColumnChoice {
            name,
            label: format::as_sentence(say_column(column)),
            choices: self.choices(chosen),
            wrong: match self.form.refused {
                Some(ColumnsRefused::NoName) => {
                    matches!(column, RosterColumn::Name | RosterColumn::Given | RosterColumn::Family)
                }
                Some(ColumnsRefused::NoEmail) => matches!(column, RosterColumn::Email | RosterColumn::Login),
                Some(ColumnsRefused::Twice) => {
                    !chosen.is_empty() && places.iter().filter(|(_, place)| *place == chosen).count() > 1
                }
                Some(ColumnsRefused::Domain) | None => false,
            },
        };
        places.into_iter().zip(NAMES).map(field).collect()
    }

    fn choices(&self, chosen: &str) -> Vec<SelectOption> {
        let choice = |(index, (heading, sample)): (usize, &(String, Option<String>))| SelectOption {
            value: index.to_string(),
            label: match sample {
                Some(sample) => format!("{heading} ({})", sample.chars().take(40).collect::<String>()),
                None => heading.clone(),
            },
            chosen: index.to_string() == chosen,
        };
        self.columns.iter().enumerate().map(choice).collect()
    }

    fn splits(&self) -> Vec<SelectOption> {
        let all = [
            ("one", tr!("Each line contains one cohort")),
            ("comma", tr!("Several, separated by commas")),
            ("semicolon", tr!("Several, separated by semicolons")),
            ("sentence", tr!("Several, as a list in a sentence: A, B, and C")),
        ];
        let choice = |(value, label): (&str, &str)| SelectOption {
            value: value.to_owned(),
            label: label.to_owned(),
            chosen: self.form.typed.split == value,
        };
        all.into_iter().map(choice).collect()
    }

    fn said_doubts(&self) -> Vec<String> {
        let say = |doubt: &MappingDoubt| match doubt {
            MappingDoubt::NoEmail => tr!("No column was recognised as the email address.").to_owned(),
            MappingDoubt::NoName => tr!("No column was recognised as the name.").to_owned(),
            MappingDoubt::Alike(one, other) => {
                tr!("The columns “{one}” and “{other}” may contain the same data.", one = one, other = other)
            }
            MappingDoubt::Unclear(heading) => {
                tr!("It is not clear what the column “{heading}” contains.", heading = heading)
            }
        };
        self.doubts.iter().map(say).collect()
    }
}

#[cfg(test)]
mod tests {
    //! The content of each column must be visible, and the selection must be kept.

    use model::Role;
    use model::people::roster::RosterEntry;

    use super::*;
    use crate::samples;

    #[test]
    fn column_page_shows_sample_cells_and_their_interpretation() {
        let entry = RosterEntry {
            email: "ana@example.org".to_owned(),
            name: "Ana".to_owned(),
            registrar_id: Some("7".to_owned()),
            cohorts: vec!["Spring".to_owned()],
            role: Some(Role::Trainee),
            standing: None,
            identity: None,
        };
        let shown = "Ana".to_owned();
        let read = LineOutcome { line: 2, shown: shown.clone(), entry: Some(entry), outcome: RosterOutcome::New };
        let outcome = RosterOutcome::Refused(Refusal::NobodyNamed);
        let left_out = LineOutcome { line: 3, shown, entry: None, outcome };
        let page = RosterColumnsPage {
            shell: samples::shell(Role::Administrator),
            id: RosterId::nil(),
            file_name: "spring.csv".to_owned(),
            columns: vec![("<Kennung>".to_owned(), Some("4711".to_owned())), ("Wer".to_owned(), None)],
            doubts: vec![
                MappingDoubt::NoEmail,
                MappingDoubt::NoName,
                MappingDoubt::Alike("a".to_owned(), "b".to_owned()),
                MappingDoubt::Unclear("x".to_owned()),
            ],
            form: FilledForm::refused(
                RosterColumnsForm { name: "1".to_owned(), ..RosterColumnsForm::default() },
                ColumnsRefused::NoEmail,
            ),
            lines: vec![read, left_out],
        };
        let html = samples::keep_page("roster-columns", &page);
        assert!(html.contains("&#60;Kennung&#62; (4711)") && html.contains("Choose the column of the email"), "{html}");
        assert!(html.contains("aria-invalid") && html.contains("<option value=\"1\" selected>Wer"), "{html}");
    }

    #[test]
    fn what_is_chosen_is_what_was_said_before() {
        let mapping = RosterMapping {
            columns: [(RosterColumn::Name, 3), (RosterColumn::Email, 0)].into(),
            split: GroupSplit::Comma,
            domain: Some("uni.example".to_owned()),
        };
        assert_eq!(RosterColumnsForm::of_mapping(&mapping).mapping(), mapping);
    }
}
