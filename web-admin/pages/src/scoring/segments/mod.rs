//! Pop marking: tasks, the form that creates one, and the results.

mod trace;

use askama::Template;
use askama_web::WebTemplate;
use model::ids::PersonId;
use model::scoring::segments::TraceOutcome;
use model::training::due::Local;
use serde::Deserialize;
use time::OffsetDateTime;
pub use trace::{StripView, TracePage, TraceTruth};

use crate::form::{FilledForm, SelectOption, read_trimmed_text};
use crate::{Shell, StatusWord, format};

/// The visitor's marking tasks.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/segments/list.html")]
pub struct SegmentsPage {
    /// Page frame.
    pub shell: Shell,
    /// Tasks.
    pub tasks: Vec<TaskRow>,
    /// Whether the visitor may create tasks.
    pub teaches: bool,
}

/// A task in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskRow {
    /// Address of the task's page.
    pub href: String,
    /// Title.
    pub title: String,
    /// Name of the cohort.
    pub cohort: String,
    /// Due time on the school's clock.
    pub due: Option<Local>,
    /// Days by which the due date was extended for the visitor.
    pub extended_days: i64,
    /// Whether it is past due and not done.
    pub late: bool,
    /// Number of traces.
    pub traces: u32,
    /// Number of traces the visitor has submitted.
    pub sent: u32,
}

/// The form that creates a task.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/segments/new.html")]
pub struct NewTaskPage {
    /// Page frame.
    pub shell: Shell,
    /// The school's time zone.
    pub time_zone: String,
    /// Cohorts to choose from.
    pub cohorts: Vec<SelectOption>,
    /// Attempts to choose from.
    pub attempts: Vec<SelectOption>,
    /// The form.
    pub form: FilledForm<NewTaskForm>,
}

/// Input of the form that creates a task.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct NewTaskForm {
    /// Title.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub title: String,
    /// Due date.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub due: String,
    /// Id of the cohort.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub cohort: String,
    /// Ids of the attempts.
    #[serde(rename = "attempt")]
    pub attempts: Vec<String>,
}

/// A task as a trainee sees it: their traces.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/segments/own.html")]
pub struct OwnTaskPage {
    /// A task for a trainee, with the trainee's traces.
    pub shell: Shell,
    /// The task.
    pub task: TaskRow,
    /// Address of each trace, and whether it was submitted.
    pub traces: Vec<(String, bool)>,
    /// Result of the submitted traces.
    pub outcome: TraceOutcome,
}

/// A task for an instructor, with the results of all trainees.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "scoring/segments/task.html")]
pub struct TaskPage {
    /// Page frame.
    pub shell: Shell,
    /// The task.
    pub task: TaskRow,
    /// For each trace: its address, the address of its attempt, and its number of pops.
    pub traces: Vec<(String, String, usize)>,
    /// Trainees by name.
    pub rows: Vec<ResultRow>,
}

/// A trainee's result.
#[derive(Clone, Debug, PartialEq)]
pub struct ResultRow {
    /// Id of the trainee.
    pub id: PersonId,
    /// Name of the trainee.
    pub name: String,
    /// Due time of this trainee.
    pub due: Option<Local>,
    /// Result over all submitted traces.
    pub outcome: TraceOutcome,
}

/// Formats milliseconds; a dash for `None`.
#[must_use]
pub fn as_milliseconds(error_ms: Option<f64>) -> String {
    error_ms.map_or_else(|| "–".to_owned(), |ms| format!("{} ms", format::format_fixed(ms, 0)))
}

/// Returns the label of an attempt in a list: trainee, exercise and time.
#[must_use]
pub fn attempt_label(trainee: &str, exercise: &str, at: OffsetDateTime) -> String {
    format!("{trainee} · {exercise} · {}", format::format_date_time(at))
}

#[cfg(test)]
mod tests {
    //! Open tasks must be visible to the trainee, and a missing value must not be shown as 0.

    use model::Role;
    use model::scoring::segments::MarksVerdict;

    use super::*;
    use crate::samples;

    fn task() -> TaskRow {
        TaskRow {
            href: "/segments/1".to_owned(),
            title: "Where are the <pops>?".to_owned(),
            cohort: "Spring".to_owned(),
            due: Some(model::training::due::local(model::Moment::from(samples::NOW), "Europe/Berlin")),
            extended_days: 2,
            late: true,
            traces: 3,
            sent: 1,
        }
    }

    fn outcome() -> TraceOutcome {
        let verdict = MarksVerdict::of(&[1.0, 2.0, 3.0], &[1.05, 2.1, 7.0]);
        TraceOutcome { sent: 1, traces: 3, verdict, late: true, extended_days: 2, ..TraceOutcome::default() }
    }

    #[test]
    fn a_trainee_sees_what_is_left_and_an_instructor_makes_more() {
        let page = SegmentsPage { shell: samples::shell(Role::Trainee), tasks: vec![task()], teaches: false };
        let html = samples::keep_page("segments-own", &page);
        assert!(
            html.contains("1 of 3")
                && html.contains("2 more days for you")
                && html.contains("&#60;pops&#62;")
                && html.contains("Late"),
            "{html}"
        );
        let own = OwnTaskPage {
            shell: samples::shell(Role::Trainee),
            task: task(),
            traces: vec![("/segments/traces/1".to_owned(), true), ("/segments/traces/2".to_owned(), false)],
            outcome: outcome(),
        };
        let html = samples::keep_page("segments-task-own", &own);
        assert!(html.contains("<strong>2</strong> of 3 pops") && html.contains("75 ms"), "{html}");
        let page = SegmentsPage { shell: samples::shell(Role::Instructor), tasks: vec![], teaches: true };
        assert!(samples::keep_page("segments-none", &page).contains("/segments/new"));
    }

    #[test]
    fn results_are_by_trainee() {
        let row =
            |name: &str, outcome| ResultRow { id: PersonId::nil(), name: name.to_owned(), due: task().due, outcome };
        let page = TaskPage {
            shell: samples::shell(Role::Instructor),
            task: task(),
            traces: vec![("/segments/traces/1".to_owned(), "/sessions/1/replay".to_owned(), 3)],
            rows: vec![row("Ada", outcome()), row("Ben", TraceOutcome { traces: 3, ..TraceOutcome::default() })],
        };
        let html = samples::keep_page("segments-task", &page);
        assert!(
            html.contains("100 ms") && html.contains("name=\"days\"") && html.contains("0 of 3") && html.contains("–"),
            "{html}"
        );
    }

    #[test]
    fn a_refused_task_keeps_what_was_typed() {
        let (title, due) = ("x \"y\"".to_owned(), "2026-03-29T02:30".to_owned());
        let typed = NewTaskForm { title, due, ..NewTaskForm::default() };
        let page = NewTaskPage {
            shell: samples::shell(Role::Instructor),
            time_zone: "Europe/Berlin".to_owned(),
            cohorts: vec![SelectOption { value: "2".to_owned(), label: "Spring".to_owned(), chosen: false }],
            attempts: vec![SelectOption { value: "1".to_owned(), label: "Ada".to_owned(), chosen: true }],
            form: FilledForm::refused(typed, "the due date: skipped".to_owned()),
        };
        let html = samples::keep_page("segments-new", &page);
        assert!(html.contains("x &#34;y&#34;") && html.contains("2026-03-29T02:30") && html.contains("skipped"));
    }
}
