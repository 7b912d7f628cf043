//! Assignments: what a trainee is to do, and who has done it.

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::assignment::{AssignmentStage, AssignmentStanding, AssignmentTask};
use model::due::{Local, local};
use model::ids::{AssignmentId, SessionId};

use super::form::FilledForm;
use super::people::SelectOption;
use super::{Shell, StatusWord, format};

/// A trainee's assignments.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "assignments/own.html")]
pub struct OwnAssignmentsPage {
    /// Frame.
    pub shell: Shell,
    /// What is due first comes first, what is done last.
    pub rows: Vec<AssignmentRow>,
}

/// An assignment and how somebody stands to it.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignmentRow {
    /// What is assigned, or who, where the list is of people.
    pub title: String,
    /// Its page.
    pub href: String,
    /// When it is due.
    pub due: Option<Local>,
    /// Days by which it was extended.
    pub extended_days: i64,
    /// How far it has come.
    pub stage: AssignmentStage,
    /// It is due, and not done.
    pub overdue: bool,
    /// Attempts that count.
    pub limit: Option<u32>,
    /// Under an instructor's eyes.
    pub supervised: bool,
    /// The trainee's id, where the list is of people.
    pub person: String,
    /// Attempts that wait for somebody to confirm that they were there.
    pub unconfirmed: Vec<SessionId>,
}

/// What somebody has assigned.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "assignments/managed.html")]
pub struct ManagedAssignmentsPage {
    /// Frame.
    pub shell: Shell,
    /// The latest first.
    pub rows: Vec<ManagedRow>,
    /// The form.
    pub form: FilledForm<AssignForm>,
}

/// An assignment that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ManagedRow {
    /// Its page.
    pub href: String,
    /// What.
    pub title: String,
    /// To whom.
    pub to: String,
    /// Until when.
    pub due: Option<Local>,
    /// Attempts that count.
    pub limit: Option<u32>,
    /// Under an instructor's eyes.
    pub supervised: bool,
}

/// What was typed to assign something.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AssignForm {
    /// Courses and exercises to choose from.
    pub tasks: Vec<SelectOption>,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
    /// Address of one trainee.
    pub email: String,
    /// Due date.
    pub due: String,
    /// Attempts.
    pub limit: String,
    /// Under an instructor's eyes.
    pub supervised: bool,
    /// Whom it concerns is mailed at once.
    pub mailed: bool,
    /// The school's time zone.
    pub time_zone: String,
}

/// An assignment and everybody's standing.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "assignments/one.html")]
pub struct AssignmentPage {
    /// Frame.
    pub shell: Shell,
    /// Its id.
    pub id: AssignmentId,
    /// The assignment.
    pub assignment: ManagedRow,
    /// Trainees by name.
    pub rows: Vec<AssignmentRow>,
}

impl AssignmentRow {
    /// A row under a title of its own.
    #[must_use]
    pub fn new(standing: AssignmentStanding, title: String, href: String, person: String) -> Self {
        let AssignmentStanding { assigned, stage, overdue, unconfirmed } = standing;
        Self {
            title,
            href,
            due: assigned.due_at.map(|at| local(at, &assigned.time_zone)),
            extended_days: assigned.extended_days,
            stage,
            overdue,
            limit: assigned.attempt_limit,
            supervised: assigned.supervised,
            person,
            unconfirmed,
        }
    }

    /// A trainee's own row.
    #[must_use]
    pub fn own(standing: AssignmentStanding) -> Self {
        let href = match &standing.assigned.task {
            AssignmentTask::Exercise(id) => super::addresses::exercise_href(id),
            AssignmentTask::Course(_) => "/curricula".to_owned(),
        };
        let title = standing.assigned.title.clone();
        Self::new(standing, title, href, String::new())
    }

    /// How it stands, as a badge.
    #[must_use]
    pub fn badge(&self) -> String {
        match (&self.stage, self.overdue) {
            (AssignmentStage::Done { late: false, .. }, _) => StatusWord::Passed.badge_saying(tr!("Done")),
            (AssignmentStage::Done { late: true, .. }, _) => StatusWord::Passed.badge_saying(tr!("Done late")),
            (AssignmentStage::Spent, _) => StatusWord::Failed.badge_saying(tr!("No attempts left")),
            (_, true) => StatusWord::Help.badge_saying(tr!("Late")),
            (AssignmentStage::Locked { .. }, false) => StatusWord::Locked.badge(),
            (AssignmentStage::Open { .. }, false) => StatusWord::Open.badge_saying(tr!("To do")),
        }
    }
}

impl AssignmentPage {
    fn done(&self) -> usize {
        self.rows.iter().filter(|row| matches!(row.stage, AssignmentStage::Done { .. })).count()
    }
}

#[cfg(test)]
mod tests {
    //! Fails when a trainee cannot see what is late, or an instructor who it is.

    use model::Moment;
    use model::assignment::Assigned;

    use super::*;
    use crate::samples;

    fn standing(stage: AssignmentStage, overdue: bool) -> AssignmentStanding {
        let assigned = Assigned {
            id: AssignmentId::nil(),
            task: AssignmentTask::Exercise("stop-in-the-fat".to_owned()),
            title: "Stop in the <fat>".to_owned(),
            made_at: Moment::from(samples::NOW),
            due_at: Some(Moment::from(samples::NOW)),
            extended_days: 3,
            attempt_limit: Some(5),
            supervised: true,
            time_zone: "Europe/Berlin".to_owned(),
        };
        AssignmentStanding { assigned, stage, overdue, unconfirmed: vec![SessionId::from_u128(1)] }
    }

    fn rows() -> Vec<AssignmentRow> {
        let stages = [
            (AssignmentStage::Open { left: Some(2) }, true),
            (AssignmentStage::Open { left: None }, false),
            (AssignmentStage::Locked { missing: vec!["Feel the layers".to_owned()] }, false),
            (AssignmentStage::Spent, false),
            (AssignmentStage::Done { on: samples::NOW, late: true }, false),
        ];
        stages.into_iter().map(|(stage, overdue)| AssignmentRow::own(standing(stage, overdue))).collect()
    }

    #[test]
    fn a_trainee_sees_what_is_due_on_the_schools_clock() {
        let page = OwnAssignmentsPage { shell: samples::shell(Role::Trainee), rows: rows() };
        let html = samples::keep_page("assignments-own", &page);
        for words in
            ["Late", "2 attempts left", "Feel the layers", "No attempts left", "Done late", "11:30", "UTC+02:00"]
        {
            assert!(html.contains(words), "{words} is missing in {html}");
        }
        assert!(html.contains("1 attempt waits for your instructor"), "{html}");
        assert!(html.contains("3 days longer") && html.contains("&#60;fat&#62;"), "{html}");
        let empty = OwnAssignmentsPage { shell: samples::shell(Role::Trainee), rows: vec![] };
        assert!(samples::keep_page("assignments-none", &empty).contains("Nothing is assigned"));
    }

    #[test]
    fn an_instructor_sees_who_has_done_it_and_what_was_typed() {
        let managed = ManagedRow {
            href: "/assignments/1".to_owned(),
            title: "Stop in the fat".to_owned(),
            to: "Spring".to_owned(),
            due: Some(local(Moment::from(samples::NOW), "Europe/Berlin")),
            limit: Some(5),
            supervised: false,
        };
        let form = AssignForm {
            due: "2026-03-29T02:30".to_owned(),
            time_zone: "Europe/Berlin".to_owned(),
            ..AssignForm::default()
        };
        let form = FilledForm::refused(form, "the due date: skipped".to_owned());
        let shell = samples::shell(Role::Instructor);
        let page = ManagedAssignmentsPage { shell: shell.clone(), rows: vec![managed.clone()], form };
        let html = samples::keep_page("assignments-managed", &page);
        assert!(html.contains("value=\"2026-03-29T02:30\"") && html.contains("The due date: skipped"), "{html}");
        let page = AssignmentPage { shell, id: AssignmentId::nil(), assignment: managed, rows: rows() };
        let html = samples::keep_page("assignment", &page);
        assert!(
            html.contains("/sessions/00000000-0000-0000-0000-000000000001/supervision") && html.contains("I was there"),
            "{html}"
        );
        assert!(html.contains("<strong>1</strong> of 5 have done it") && html.contains("Give longer"), "{html}");
    }
}
