//! `/exams/{id}/candidates/{person}`: the station of a candidate.

use acts::error::Error;
use acts::scoring::exams;
use acts::scoring::exams::OpenSitting;
use acts::surveys;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect};
use model::CurrentPerson;
use model::ids::{ExamId, PersonId};
use model::surveys::given::GivenAnswers;
use pages::scoring::exams::{SittingClock, StationPage, list_answers, list_scores};
use pages::surveys::form::{FormQuestion, Refusals};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use store::scoring::exams as stored;
use store::scoring::exams::{Exam, Sitting};

use super::exam::ExamView;
use super::{attempt_href, exam_href};
use crate::scoring::ratings::rate::{RateForm, RaterInput, list_rater_questions};

pub(super) async fn show_station(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId((id, candidate)): PathId<(ExamId, PersonId)>,
    csrf: Csrf,
) -> Result<StationPage, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    let (name, sitting) = exams::find_candidate(&state, &exam, candidate).await?;
    let all = stored::list_sittings(state.db.reader(), exam.school_id, id).await.map_err(Error::from)?;
    let view = ExamView::new(&exam, &person, &all);
    let sitting =
        sitting.filter(|_| !view.is_second_rater || !view.hides(all.iter().find(|s| s.person_id == candidate)));
    let mut page = make_station_page(Visit::new(&person, &csrf), &exam, candidate, name);
    page.is_second_rater = view.is_second_rater && sitting.is_none();
    if let Some(sitting) = sitting {
        show_sitting(&state, &person, &mut page, exam, sitting).await?;
    }
    Ok(page)
}

/// Returns the page of a candidate without their sitting.
fn make_station_page(Visit { person, csrf }: Visit<'_>, exam: &Exam, candidate: PersonId, name: String) -> StationPage {
    StationPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Assignments),
        href: format!("{}/candidates/{candidate}", exam_href(exam.id)),
        exam: (exam.title.clone(), exam_href(exam.id)),
        name,
        exercise: exam.exercise.clone(),
        instrument: exam.instrument.clone(),
        limit_min: exam.limit_min,
        may_begin: exam.closed_at.is_none(),
        clock: None,
        examiner: String::new(),
        questions: Vec::new(),
        scores: Vec::new(),
        answers: Vec::new(),
        attempt: None,
        is_second_rater: false,
    }
}

async fn show_sitting(
    state: &AppState,
    person: &CurrentPerson,
    page: &mut StationPage,
    exam: Exam,
    sitting: Sitting,
) -> Result<(), Error> {
    page.clock = Some(SittingClock::new(&sitting.times(), state.clock.now()));
    page.examiner.clone_from(&sitting.examiner);
    if sitting.finished_at.is_some() {
        let instrument = surveys::revision(state, exam.school_id, exam.revision_id).await?.ok_or(Error::NotFound)?;
        page.scores = list_scores(&instrument, &sitting.answers);
        page.answers = list_answers(&instrument, &sitting.answers);
        page.attempt = sitting.session_id.map(attempt_href);
    } else if sitting.examiner_id == person.id && exam.closed_at.is_none() {
        let open = exams::open(state, person, exam, sitting.person_id).await?;
        page.questions = questions_of(&open, &Refusals::default(), &GivenAnswers::default());
    }
    Ok(())
}

fn questions_of(open: &OpenSitting, refusals: &Refusals, given: &GivenAnswers) -> Vec<FormQuestion> {
    list_rater_questions(&open.instrument, &open.sitting.answers, RaterInput { refusals, given })
}

pub(super) async fn begin_sitting(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId((id, candidate)): PathId<(ExamId, PersonId)>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    exams::begin(&state, &person, &exam, candidate).await?;
    Ok(Redirect::to(&format!("{}/candidates/{candidate}", exam_href(id))))
}

pub(super) async fn fill_in_form(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId((id, candidate)): PathId<(ExamId, PersonId)>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<RateForm>,
) -> Result<FormAnswer<StationPage>, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    let mut open = exams::open(&state, &person, exam, candidate).await?;
    let refused = open.read(&form.given);
    let refusals = match refused.is_empty() {
        false => Some(Refusals::new(&open.instrument, &form.given, &refused)),
        true => match form.step.as_str() {
            "save" => {
                open.save(&state).await?;
                return Ok(FormAnswer::Answered(StatusCode::NO_CONTENT.into_response()));
            }
            "keep" => {
                open.save(&state).await?;
                return Ok(FormAnswer::lead_to(&exam_href(id)));
            }
            "finish" => finish_or_list_blanks(&state, &person, &open, &form.given).await?,
            other => return Err(Error::BadRequest(format!("do: \"{other}\"; allowed: save, keep, finish")).into()),
        },
    };
    let Some(refusals) = refusals else { return Ok(FormAnswer::lead_to(&exam_href(id))) };
    let visit = Visit::new(&person, &csrf);
    let page = make_station_page(visit, &open.exam, candidate, open.sitting.name.clone());
    Ok(FormAnswer::Refused(StationPage {
        clock: Some(SittingClock::new(&open.sitting.times(), state.clock.now())),
        examiner: open.sitting.examiner.clone(),
        questions: questions_of(&open, &refusals, &form.given),
        ..page
    }))
}

/// Finishes a sitting, or saves it and returns the items left blank.
async fn finish_or_list_blanks(
    state: &AppState,
    person: &CurrentPerson,
    open: &OpenSitting,
    given: &GivenAnswers,
) -> Result<Option<Refusals>, Error> {
    let blank = open.unanswered(given);
    if blank.is_empty() {
        open.finish(state, person).await?;
        return Ok(None);
    }
    open.save(state).await?;
    Ok(Some(Refusals::of_blanks(&blank)))
}
