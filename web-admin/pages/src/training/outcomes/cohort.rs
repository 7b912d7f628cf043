//! The outcomes of a cohort: the level of each trainee, and how many had reached a level over time.

use askama::Template;
use askama_web::WebTemplate;
use time::OffsetDateTime;

use super::trainee::level_words;
use crate::form::SelectOption;
use crate::people::listed::ListPart;
use crate::{Shell, format};

/// The page of a cohort's outcomes.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/outcomes/cohort.html")]
pub struct CohortOutcomesPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the cohort.
    pub name: String,
    /// Address of the cohort's page.
    pub href: String,
    /// The outcomes, by code.
    pub columns: Vec<CohortOutcomeColumn>,
    /// Trainees whom the page shows, by name.
    pub rows: Vec<CohortOutcomesRow>,
    /// Which they are.
    pub list: ListPart,
    /// Names of the levels, lowest first.
    pub levels: Vec<String>,
    /// The levels as options; the chosen one is counted over time.
    pub level_options: Vec<SelectOption>,
    /// Number of trainees.
    pub trainees: usize,
}

impl CohortOutcomesPage {
    fn name_level(&self, level: &i64) -> String {
        level_words(&self.levels, *level)
    }
}

/// An outcome as a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CohortOutcomeColumn {
    /// Code.
    pub code: String,
    /// Title.
    pub title: String,
    /// Number of trainees at the chosen level or above, on days in order; the same for all outcomes.
    pub counts: Vec<DayCount>,
}

/// Number of trainees at a level or above on a day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DayCount {
    /// The day.
    pub day: OffsetDateTime,
    /// Number of trainees.
    pub trainees: usize,
}

/// A trainee as a row.
#[derive(Clone, Debug, PartialEq)]
pub struct CohortOutcomesRow {
    /// Address of the trainee's outcomes.
    pub href: String,
    /// Name.
    pub name: String,
    /// A cell per outcome.
    pub cells: Vec<LevelCell>,
}

/// Level and evidence of a trainee for an outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelCell {
    /// Level in force and time of the decision.
    pub level: Option<(i64, OffsetDateTime)>,
    /// Number of mastered exercises of the courses that lead to it.
    pub mastered: usize,
    /// Number of their exercises.
    pub exercises: usize,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::people::listed::ListQuery;
    use crate::samples;
    use crate::training::outcomes::name_levels;

    #[test]
    fn each_trainee_has_a_level_and_evidence_for_each_outcome() {
        let cell = |level| LevelCell { level, mastered: 3, exercises: 6 };
        let row = CohortOutcomesRow {
            href: "/trainees/1/outcomes".to_owned(),
            name: "Ada <Okafor>".to_owned(),
            cells: vec![cell(Some((3, samples::NOW))), cell(None)],
        };
        let day = |(ago, trainees)| DayCount { day: samples::NOW - time::Duration::days(ago), trainees };
        let column = |code: &str| CohortOutcomeColumn {
            code: code.to_owned(),
            title: "Lumbar puncture".to_owned(),
            counts: [(30, 0), (0, 1)].map(day).to_vec(),
        };
        let (rows, list) = ListPart::of(ListQuery::default(), vec![row], |row| &row.name);
        let levels = name_levels(Vec::new());
        let option = |(at, label): (usize, &String)| SelectOption {
            value: (at + 1).to_string(),
            label: label.clone(),
            chosen: at == 2,
        };
        let page = CohortOutcomesPage {
            shell: samples::shell(Role::Instructor),
            name: "Spring".to_owned(),
            href: "/cohorts/1".to_owned(),
            columns: vec![column("EPA 1"), column("EPA 2")],
            rows,
            list,
            level_options: levels.iter().enumerate().map(option).collect(),
            levels,
            trainees: 1,
        };
        let html = samples::keep_page("cohort-outcomes", &page);
        for wanted in ["Ada &#60;Okafor&#62;", "3 – Acts with supervision on call", "3 of 6", "not decided", "1 of 1"]
        {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
    }
}
