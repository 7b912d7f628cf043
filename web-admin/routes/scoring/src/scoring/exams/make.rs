//! Lists exams, and creates one.

use acts::error::Error;
use acts::scoring::exams::{make, suits_exams};
use acts::surveys;
use acts::training::assignments as teaching;
use axum::extract::State;
use model::ids::{CohortId, PersonId};
use model::scoring::exam::read_limit_min;
use model::{CurrentPerson, single_line_text};
use pages::form::{FilledForm, SelectOption};
use pages::scoring::exams::{ExamForm, ExamOptions, ExamRow, ExamsPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use store::authoring::exercises;
use store::scoring::exams::{Exam, NewExam};
use store::scoring::{exams as stored, ratings};
use store::surveys::instruments;
use store::training::reports;

use super::exam_href;
use crate::scoring::ratings::make::list_instrument_options;

/// The instrument and the time limit that are proposed.
const PROPOSED: &str = "puncture-checklist";
const PROPOSED_MIN: &str = "10";

/// Returns the list of exams with the form of a new one.
pub(super) async fn make_list(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    mut form: FilledForm<ExamForm>,
) -> Result<ExamsPage, Error> {
    let row = |exam: Exam| ExamRow {
        href: exam_href(exam.id),
        title: exam.title,
        cohort: exam.cohort,
        exercise: exam.exercise,
        limit_min: exam.limit_min,
        finished: (exam.finished, exam.begun),
        made_at: exam.made_at.to_utc(),
        is_closed: exam.closed_at.is_some(),
    };
    let rows = stored::list_exams(state.db.reader(), person).await?.into_iter().map(row).collect();
    let options = list_options(state, person, &form.typed).await?;
    if form.refused.is_none() {
        PROPOSED_MIN.clone_into(&mut form.typed.limit);
    }
    Ok(ExamsPage { shell: Shell::new(person, csrf.token(), NavPlace::Assignments), rows, form, options })
}

async fn list_options(state: &AppState, person: &CurrentPerson, form: &ExamForm) -> Result<ExamOptions, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let option = |value: String, label: String, chosen: &str| SelectOption { chosen: value == chosen, value, label };
    let cohorts = reports::cohorts(reader, person).await?.into_iter();
    let raters = ratings::raters(reader, school).await?.into_iter();
    let wanted = if form.instrument.is_empty() { PROPOSED } else { form.instrument.as_str() };
    let mut exercises: Vec<SelectOption> = Vec::new();
    for (curriculum, course) in teaching::taught_curricula(state, school).await? {
        let labelled = course.steps.iter().map(|step| {
            let label = format!("{}: {}", curriculum.title, step.title);
            option(step.exercise.clone(), label, &form.exercise)
        });
        exercises.extend(labelled);
    }
    for alone in exercises::list_current_exercises(reader, school).await? {
        if exercises.iter().all(|known| known.value != alone.exercise_id) {
            exercises.push(option(alone.exercise_id, alone.title, &form.exercise));
        }
    }
    Ok(ExamOptions {
        cohorts: cohorts.map(|cohort| option(cohort.id.to_string(), cohort.name, &form.cohort)).collect(),
        exercises,
        instruments: list_instrument_options(state, school, wanted, suits_exams).await?,
        raters: raters.map(|rater| option(rater.id.to_string(), rater.name, &form.second)).collect(),
    })
}

pub(super) async fn make_exam(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<ExamForm>,
) -> Result<FormAnswer<ExamsPage>, PageError> {
    match split_refusal(read_new_exam(&state, &person, &form).await)? {
        Ok(new) => Ok(FormAnswer::lead_to(&exam_href(make(&state, &person, &new).await?))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_list(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

/// Parses the form. A cohort or an exercise that the visitor may not see is answered with 404.
async fn read_new_exam(state: &AppState, person: &CurrentPerson, form: &ExamForm) -> Result<NewExam, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let title = single_line_text::title(&form.title).map_err(Error::Unprocessable)?.to_owned();
    let limit_min = read_limit_min(&form.limit).map_err(Error::Unprocessable)?;
    let cohort_id: CohortId = form.cohort.parse().map_err(|_| Error::NotFound)?;
    reports::cohort(reader, person, cohort_id).await?.ok_or(Error::NotFound)?;
    exercises::find_current_revision(reader, school, &form.exercise).await?.ok_or(Error::NotFound)?;
    let unknown = || Error::Unprocessable(tr!("questionnaire: “{id}” does not exist", id = form.instrument));
    let instrument = instruments::find_current_instrument(reader, school, &form.instrument).await?;
    let instrument = instrument.ok_or_else(unknown)?;
    let document = surveys::revision(state, school, instrument.id).await?.ok_or_else(unknown)?;
    if !suits_exams(&document) {
        let why = tr!("questionnaire: an exam needs one with a score and without free text");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    Ok(NewExam {
        title,
        cohort_id,
        exercise_id: form.exercise.clone(),
        revision_id: instrument.id,
        limit_min,
        second_rater_id: read_second_rater(state, person, &form.second).await?,
    })
}

async fn read_second_rater(state: &AppState, person: &CurrentPerson, typed: &str) -> Result<Option<PersonId>, Error> {
    if typed.is_empty() {
        return Ok(None);
    }
    let known = ratings::raters(state.db.reader(), person.school_id).await?;
    let found = known.iter().find(|rater| rater.id.to_string() == typed).map(|rater| rater.id);
    let unknown = || Error::Unprocessable(tr!("rater: “{id}”; allowed: the instructors of the school", id = typed));
    found.map(Some).ok_or_else(unknown)
}
