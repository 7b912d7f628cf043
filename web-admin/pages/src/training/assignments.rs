//! Assignments: a trainee's tasks, and their completion.

use askama::Template;
use askama_web::WebTemplate;
use model::Role;
use model::ids::{AssignmentId, SessionId};
use model::training::assignment::{AssignmentStage, AssignmentStanding, AssignmentTally, AssignmentTask};
use model::training::due::{Local, local};
use time::OffsetDateTime;

use crate::form::{FilledForm, SelectOption};
use crate::people::listed::ListPart;
use crate::{Shell, StatusWord, format};

/// A trainee's assignments.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/assignments/own.html")]
pub struct OwnAssignmentsPage {
    /// Page frame.
    pub shell: Shell,
    /// Assignments by due date, with finished ones last.
    pub rows: Vec<AssignmentRow>,
}

/// An assignment and a trainee's progress on it.
#[derive(Clone, Debug, PartialEq)]
pub struct AssignmentRow {
    /// Title of the task, or name of the trainee in a list of people.
    pub title: String,
    /// Address of the page that the row links to.
    pub href: String,
    /// Due time on the school's clock.
    pub due: Option<Local>,
    /// Days by which the due date was extended.
    pub extended_days: i64,
    /// Progress on the assignment.
    pub stage: AssignmentStage,
    /// Whether it is past due and not done.
    pub overdue: bool,
    /// When it was assigned.
    pub made_at: OffsetDateTime,
    /// Whether only attempts after `made_at` count.
    pub since_only: bool,
    /// Number of attempts that count.
    pub attempts: usize,
    /// Best score among them, 0–100.
    pub best: Option<f64>,
    /// Maximum number of attempts that may count.
    pub limit: Option<u32>,
    /// Whether attempts count only under an instructor's supervision.
    pub supervised: bool,
    /// The trainee's id in a list of people; empty in the trainee's own list.
    pub person: String,
    /// Attempts whose supervision an instructor has yet to confirm.
    pub unconfirmed: Vec<SessionId>,
}

/// Assignments that an instructor manages, and the form for a new one.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/assignments/managed.html")]
pub struct ManagedAssignmentsPage {
    /// Page frame.
    pub shell: Shell,
    /// Assignments, latest first.
    pub rows: Vec<ManagedRow>,
    /// The form for a new assignment.
    pub form: FilledForm<AssignForm>,
}

/// An assignment in an instructor's list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ManagedRow {
    /// Address of the assignment's page.
    pub href: String,
    /// Title of the task.
    pub title: String,
    /// Name of the cohort or trainee.
    pub to: String,
    /// Due time on the school's clock.
    pub due: Option<Local>,
    /// Maximum number of attempts that count.
    pub limit: Option<u32>,
    /// Whether attempts count only under an instructor's supervision.
    pub supervised: bool,
    /// Whether only attempts after the assignment was made count.
    pub since_only: bool,
    /// Who has done it, and who is late, where that is counted.
    pub tally: Option<AssignmentTally>,
}

/// Input of the form for a new assignment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AssignForm {
    /// Courses and exercises to choose from.
    pub tasks: Vec<SelectOption>,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
    /// Email address of a single trainee.
    pub email: String,
    /// Due date.
    pub due: String,
    /// Maximum number of attempts.
    pub limit: String,
    /// Whether attempts count only under an instructor's supervision.
    pub supervised: bool,
    /// Only attempts from now on count.
    pub since_only: bool,
    /// Whether the form was refused because the task is locked for a trainee.
    pub locked: bool,
    /// Whether to assign the task although it is locked for a trainee.
    pub despite_locks: bool,
    /// Whether to email the trainees at once.
    pub mailed: bool,
    /// The school's time zone.
    pub time_zone: String,
}

/// An assignment and the progress of every trainee.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "training/assignments/one.html")]
pub struct AssignmentPage {
    /// Page frame.
    pub shell: Shell,
    /// Id of the assignment.
    pub id: AssignmentId,
    /// The assignment.
    pub assignment: ManagedRow,
    /// Who has done it, and who is late.
    pub tally: AssignmentTally,
    /// Those of the trainees whom the page shows, the late ones first, then by name.
    pub rows: Vec<AssignmentRow>,
    /// Which they are.
    pub list: ListPart,
    /// The gradebook of the cohort to which it is assigned.
    pub gradebook: Option<String>,
}

/// An assignment of a cohort or a trainee, listed for their teacher.
#[derive(Clone, Debug, PartialEq)]
pub struct DueLine {
    /// Address of the assignment's page.
    pub href: String,
    /// Title of the task.
    pub title: String,
    /// Name of the cohort or trainee.
    pub to: String,
    /// Due time on the school's clock.
    pub due: Option<Local>,
    /// Number of trainees who are done, and who are late.
    pub tally: AssignmentTally,
}

impl AssignmentRow {
    /// Creates a row with the given title and link.
    #[must_use]
    pub fn new(standing: AssignmentStanding, title: String, href: String, person: String) -> Self {
        let AssignmentStanding { assigned, stage, overdue, attempts, best, unconfirmed } = standing;
        Self {
            title,
            href,
            due: assigned.due_at.map(|at| local(at, &assigned.time_zone)),
            extended_days: assigned.extended_days,
            stage,
            overdue,
            made_at: assigned.made_at.to_utc(),
            since_only: assigned.since_only,
            attempts,
            best,
            limit: assigned.attempt_limit,
            supervised: assigned.supervised,
            person,
            unconfirmed,
        }
    }

    /// Creates a row for the trainee's own list.
    #[must_use]
    pub fn own(standing: AssignmentStanding) -> Self {
        let href = task_href(&standing.assigned.task);
        let title = standing.assigned.title.clone();
        Self::new(standing, title, href, String::new())
    }

    /// Returns the row's status as a badge.
    #[must_use]
    pub fn badge(&self) -> String {
        let status = match (&self.stage, self.overdue) {
            (AssignmentStage::Done { .. }, _) => StatusWord::Passed,
            (AssignmentStage::Spent, _) => StatusWord::Failed,
            (_, true) => StatusWord::Help,
            (AssignmentStage::Locked { .. }, false) => StatusWord::Locked,
            (AssignmentStage::Open { .. }, false) => StatusWord::Open,
        };
        status.badge_saying(self.say_state())
    }

    /// Names the row's status.
    #[must_use]
    pub fn say_state(&self) -> &'static str {
        match (&self.stage, self.overdue) {
            (AssignmentStage::Done { on, .. }, _) if *on < self.made_at => tr!("Done earlier"),
            (AssignmentStage::Done { late: false, .. }, _) => tr!("Done"),
            (AssignmentStage::Done { late: true, .. }, _) => tr!("Done late"),
            (AssignmentStage::Spent, _) => tr!("No attempts left"),
            (_, true) => tr!("Late"),
            (AssignmentStage::Locked { .. }, false) => tr!("Locked"),
            (AssignmentStage::Open { .. }, false) => tr!("To do"),
        }
    }
}

impl ManagedAssignmentsPage {
    fn say_done(&self, tally: &AssignmentTally) -> String {
        tr!("{done} of {of}", done = tally.done, of = tally.of)
    }
}

/// Returns the address of the page that shows a trainee what is to be done.
#[must_use]
pub fn task_href(task: &AssignmentTask) -> String {
    match task {
        AssignmentTask::Exercise(id) => crate::training::addresses::exercise_href(id),
        AssignmentTask::Course(_) => "/curricula".to_owned(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    //! A trainee must see which assignments are late; an instructor, which trainees are.

    use model::Moment;
    use model::training::assignment::{Assigned, MasteredShare};

    use super::*;
    use crate::samples;

    fn standing(stage: AssignmentStage, overdue: bool) -> AssignmentStanding {
        let assigned = Assigned {
            id: AssignmentId::nil(),
            task: AssignmentTask::Exercise("stop-in-the-fat".to_owned()),
            title: "Stop in the <fat>".to_owned(),
            person_id: None,
            made_at: Moment::from(samples::NOW),
            since_only: true,
            due_at: Some(Moment::from(samples::NOW)),
            extended_days: 3,
            attempt_limit: Some(5),
            supervised: true,
            time_zone: "Europe/Berlin".to_owned(),
        };
        AssignmentStanding {
            assigned,
            stage,
            overdue,
            attempts: 4,
            best: Some(71.2),
            unconfirmed: vec![SessionId::from_u128(1)],
        }
    }

    pub(crate) fn rows() -> Vec<AssignmentRow> {
        let stages = [
            (AssignmentStage::Open { left: Some(2), mastered: None }, true),
            (AssignmentStage::Open { left: None, mastered: Some(MasteredShare { exercises: 6, of: 7 }) }, false),
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
        assert!(html.contains("1 attempt is waiting for your instructor"), "{html}");
        assert!(html.contains("3 more days") && html.contains("&#60;fat&#62;"), "{html}");
        let empty = OwnAssignmentsPage { shell: samples::shell(Role::Trainee), rows: vec![] };
        assert!(samples::keep_page("assignments-none", &empty).contains("You have no assignments"));
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
            since_only: true,
            tally: Some(AssignmentTally { done: 3, late: 2, of: 9 }),
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
        assert!(html.contains("3 of 9") && html.contains("Late"), "{html}");
        assert!(html.contains("value=\"2026-03-29T02:30\"") && html.contains("The due date: skipped"), "{html}");
        let tally = AssignmentTally { done: 1, late: 1, of: 5 };
        let list = ListPart { all: 120, ..ListPart::default() };
        let (id, rows) = (AssignmentId::nil(), rows());
        let page = AssignmentPage { shell, id, assignment: managed, tally, rows, list, gradebook: None };
        let html = samples::keep_page("assignment", &page);
        assert!(
            html.contains("/sessions/00000000-0000-0000-0000-000000000001/supervision")
                && html.contains("I supervised it"),
            "{html}"
        );
        assert!(html.contains("<strong>1</strong> of 5 have done it") && html.contains("Extend"), "{html}");
    }
}
