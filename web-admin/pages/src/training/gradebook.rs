//! The gradebook: state, best score and attempts of each trainee for each assignment of a cohort.

use askama::Template;
use askama_web::WebTemplate;
use model::training::assignment::{AssignmentStage, AssignmentTally};
use model::training::due::Local;

use crate::people::listed::ListPart;
use crate::training::assignments::{AssignmentRow, DueLine};
use crate::{Shell, StatusWord, format};

/// The gradebook of a cohort.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/gradebook.html")]
pub struct GradebookPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the cohort's page.
    pub href: String,
    /// The cohort's name.
    pub name: String,
    /// Assignments of the cohort, earliest first.
    pub columns: Vec<GradebookColumn>,
    /// Those of the trainees whom the page shows, by name.
    pub rows: Vec<GradebookRow>,
    /// Which they are.
    pub list: ListPart,
    /// What is assigned to single trainees.
    pub alone: Vec<DueLine>,
}

/// An assignment as a column heading.
#[derive(Clone, Debug, PartialEq)]
pub struct GradebookColumn {
    /// Address of the assignment's page.
    pub href: String,
    /// Title of the task.
    pub title: String,
    /// Due time on the school's clock.
    pub due: Option<Local>,
    /// Number of trainees who are done, and who are late.
    pub tally: AssignmentTally,
}

/// A trainee.
#[derive(Clone, Debug, PartialEq)]
pub struct GradebookRow {
    /// Address of the trainee's page.
    pub href: String,
    /// Name.
    pub name: String,
    /// Number from the registrar's office.
    pub registrar_id: Option<String>,
    /// Progress per assignment, in the order of the columns.
    pub cells: Vec<AssignmentRow>,
}

#[cfg(test)]
mod tests {
    //! Names must never become markup, and each column must show how many trainees are late.

    use model::Role;

    use super::*;
    use crate::samples;
    use crate::training::assignments::tests::rows;

    #[test]
    fn everybody_stands_beside_everything_assigned() {
        let columns = rows().into_iter().map(|row| GradebookColumn {
            href: "/assignments/1".to_owned(),
            title: row.title,
            due: row.due,
            tally: AssignmentTally { done: 3, late: 2, of: 9 },
        });
        let row = GradebookRow {
            href: "/trainees/1".to_owned(),
            name: "Ada <Okafor>".to_owned(),
            registrar_id: Some("4711".to_owned()),
            cells: rows(),
        };
        let page = GradebookPage {
            shell: samples::shell(Role::Instructor),
            href: "/cohorts/1".to_owned(),
            name: "Spring".to_owned(),
            columns: columns.collect(),
            rows: vec![row],
            list: ListPart::default(),
            alone: vec![samples::due_line()],
        };
        let html = samples::keep_page("gradebook", &page);
        for wanted in ["Ada &#60;Okafor&#62;", "4711", "2 late", "3 of 9", "Done late", "71", "gradebook.csv?bom=1"] {
            assert!(html.contains(wanted), "{wanted} is missing in {html}");
        }
        let words: Vec<&str> = rows().iter().map(AssignmentRow::say_state).collect();
        assert_eq!(words, ["Late", "To do", "Locked", "No attempts left", "Done late"]);
    }
}
