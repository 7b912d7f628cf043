//! Outcomes of a school: their list, one of them, those of a trainee and those of a cohort.

mod cohort;
mod trainee;

use askama::Template;
use askama_web::WebTemplate;
pub use cohort::{CohortOutcomeColumn, CohortOutcomesPage, CohortOutcomesRow, DayCount, LevelCell};
use model::training::outcome::{LONGEST_CODE, LONGEST_DESCRIPTION, LONGEST_TITLE, OutcomeText};
use serde::Deserialize;
pub use trainee::{CourseEvidence, DecisionRow, OutcomeView, TraineeOutcomesPage, level_words};

use crate::form::{FilledForm, SelectOption, read_ticked_box, read_trimmed_text};
use crate::people::listed::ListPart;
use crate::{Shell, format};

/// Returns the names of a school's levels, or the usual ones if it has set none: the scale of
/// ten Cate, "Nuts and bolts of entrustable professional activities", J Grad Med Educ 2013;5:157.
#[must_use]
pub fn name_levels(set: Vec<String>) -> Vec<String> {
    if !set.is_empty() {
        return set;
    }
    [
        tr!("Observes"),
        tr!("Acts under direct supervision"),
        tr!("Acts with supervision on call"),
        tr!("Acts without supervision"),
        tr!("Supervises others"),
    ]
    .map(str::to_owned)
    .to_vec()
}

/// The page of all outcomes of a school.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/outcomes/list.html")]
pub struct OutcomesPage {
    /// Page frame.
    pub shell: Shell,
    /// Outcomes that the page shows, by code.
    pub rows: Vec<OutcomeRow>,
    /// Which they are.
    pub list: ListPart,
    /// The form of a new outcome.
    pub form: FilledForm<OutcomeForm>,
    /// The form of the levels.
    pub levels: FilledForm<LevelsForm>,
    /// Why a file was refused.
    pub refused_file: Option<String>,
    /// Result of an import.
    pub imported: Option<String>,
}

/// An outcome in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutcomeRow {
    /// Address of its page.
    pub href: String,
    /// Code.
    pub code: String,
    /// Title.
    pub title: String,
    /// Titles of the courses that lead to it.
    pub courses: Vec<String>,
    /// Whether it is retired.
    pub is_retired: bool,
}

/// Input of the form of an outcome.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct OutcomeForm {
    /// Code.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub code: String,
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// Description.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub description: String,
    /// Ids of the courses that lead to it.
    #[serde(default)]
    pub courses: Vec<String>,
    /// Whether it is retired.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub retired: bool,
}

impl OutcomeForm {
    /// Returns the texts of the outcome, with its identifier in a catalogue.
    #[must_use]
    pub fn text(&self, source: &str) -> OutcomeText {
        OutcomeText {
            code: self.code.clone(),
            title: self.title.clone(),
            description: self.description.replace("\r\n", "\n"),
            source: source.to_owned(),
        }
    }
}

/// Input of the form of levels.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct LevelsForm {
    /// Names, one per line, lowest first.
    pub levels: String,
}

/// The page of an outcome.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/outcomes/one.html")]
pub struct OutcomePage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the page.
    pub href: String,
    /// Code and title as stored.
    pub heading: String,
    /// Identifier in a catalogue; empty if it was entered by hand.
    pub source: String,
    /// The form.
    pub form: FilledForm<OutcomeForm>,
    /// The courses of the school.
    pub courses: Vec<SelectOption>,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::people::listed::ListQuery;
    use crate::samples;

    #[test]
    fn outcomes_are_listed_with_their_courses() {
        let row = OutcomeRow {
            href: "/admin/outcomes/1".to_owned(),
            code: "EPA <3>".to_owned(),
            title: "Lumbar puncture".to_owned(),
            courses: vec!["Lower back".to_owned()],
            is_retired: false,
        };
        let retired = OutcomeRow { is_retired: true, courses: Vec::new(), ..row.clone() };
        let (rows, list) = ListPart::of(ListQuery::default(), vec![row, retired], |row| &row.title);
        let page = OutcomesPage {
            shell: samples::shell(Role::Administrator),
            rows,
            list,
            form: FilledForm::refused(OutcomeForm::default(), "code: 0 characters".to_owned()),
            levels: FilledForm::new(LevelsForm { levels: "A\nB".to_owned() }),
            refused_file: Some("line 3: title: 0 characters".to_owned()),
            imported: Some("3 outcomes added.".to_owned()),
        };
        let html = samples::keep_page("outcomes", &page);
        for wanted in ["EPA &#60;3&#62;", "Lower back", "Retired", "Line 3", "A\nB"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }

    #[test]
    fn an_outcome_shows_its_courses_as_boxes() {
        let form = OutcomeForm { code: "EPA 3".to_owned(), title: "Puncture".to_owned(), ..OutcomeForm::default() };
        let course = SelectOption { value: "lower-back".to_owned(), label: "Lower <back>".to_owned(), chosen: true };
        let page = OutcomePage {
            shell: samples::shell(Role::Administrator),
            href: "/admin/outcomes/1".to_owned(),
            heading: "EPA 3 Puncture".to_owned(),
            source: "0a1b2c3d".to_owned(),
            form: FilledForm::new(form),
            courses: vec![course],
        };
        let html = samples::keep_page("outcome", &page);
        assert!(
            html.contains("Lower &#60;back&#62;") && html.contains("checked") && html.contains("0a1b2c3d"),
            "{html}"
        );
    }
}
