//! Creates rating rounds: attempts of an assignment or of the review queue, raters, an instrument.

use std::collections::BTreeSet;

use acts::error::Error;
use acts::scoring::ratings;
use acts::surveys;
use axum::extract::{Query, State};
use documents::Instrument;
use model::ids::{AssignmentId, PersonId, SchoolId, SessionId};
use model::scoring::review::ReviewFilter;
use model::{CurrentPerson, single_line_text};
use pages::form::{FilledForm, SelectOption};
use pages::scoring::rating::{AttemptChoice, NewRoundForm, NewRoundPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::recordings::sessions;
use store::scoring::ratings::{NewRound, RateableAttempt, Rater};
use store::scoring::{grades, ratings as stored, reviews};
use store::surveys::instruments;
use store::training::assignments;

/// Maximum number of raters of a round, and of attempts.
const MOST_RATERS: usize = 20;
const MOST_ATTEMPTS: usize = 100;

#[derive(Deserialize)]
pub(super) struct NewRoundQuery {
    /// The assignment whose attempts are offered; empty for the review queue.
    #[serde(default)]
    assignment: String,
}

pub(super) async fn show_new_round(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(from): Query<NewRoundQuery>,
) -> Result<NewRoundPage, PageError> {
    let form = NewRoundForm { assignment: from.assignment.trim().to_owned(), ..NewRoundForm::default() };
    let mut page = make_new_round_page(&state, Visit::new(&person, &csrf), FilledForm::new(form)).await?;
    // All attempts at an assignment are preselected.
    for attempt in &mut page.attempts {
        attempt.chosen = !page.form.typed.assignment.is_empty();
    }
    Ok(page)
}

/// Returns the distinct choices.
fn list_chosen_once(chosen: &[String]) -> BTreeSet<&str> {
    chosen.iter().map(String::as_str).collect()
}

/// Returns the attempts on offer: those at an assignment that the visitor manages, or those of
/// their review queue.
async fn offered_attempts(
    state: &AppState,
    person: &CurrentPerson,
    form: &NewRoundForm,
) -> Result<Vec<RateableAttempt>, Error> {
    let reader = state.db.reader();
    if form.assignment.is_empty() {
        let waiting = reviews::list_review_queue(reader, person, &ReviewFilter::default(), None).await?;
        let candidate = |waiting: reviews::WaitingReview| RateableAttempt {
            id: waiting.id,
            trainee: waiting.trainee,
            exercise: waiting.exercise,
            started_at: waiting.started_at,
        };
        return Ok(waiting.into_iter().map(candidate).collect());
    }
    let id: AssignmentId = form.assignment.parse().map_err(|_| Error::NotFound)?;
    let managed = assignments::list_managed_assignments(reader, person, Some(id), 1).await?;
    if managed.is_empty() {
        return Err(Error::NotFound);
    }
    Ok(stored::of_assignment(reader, person.school_id, id).await?)
}

async fn make_new_round_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<NewRoundForm>,
) -> Result<NewRoundPage, Error> {
    let reader = state.db.reader();
    let (chosen_raters, chosen_attempts) =
        (list_chosen_once(&form.typed.raters), list_chosen_once(&form.typed.attempts));
    let raters = stored::raters(reader, person.school_id).await?;
    let rater = |rater: Rater| {
        let value = rater.id.to_string();
        SelectOption { chosen: chosen_raters.contains(value.as_str()), value, label: rater.name }
    };
    let attempt = |attempt: RateableAttempt| AttemptChoice {
        chosen: chosen_attempts.contains(attempt.id.to_string().as_str()),
        session: attempt.id,
        trainee: attempt.trainee,
        exercise: attempt.exercise,
        started_at: attempt.started_at.to_utc(),
    };
    Ok(NewRoundPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Review),
        instruments: scored_instruments(state, person.school_id, &form.typed).await?,
        raters: raters.into_iter().map(rater).collect(),
        attempts: offered_attempts(state, person, &form.typed).await?.into_iter().map(attempt).collect(),
        form,
    })
}

/// Returns the instruments that have a score, since agreement is computed from scores. The global
/// rating is preselected.
async fn scored_instruments(
    state: &AppState,
    school: SchoolId,
    form: &NewRoundForm,
) -> Result<Vec<SelectOption>, Error> {
    const PROPOSED: &str = "global-rating-puncture";
    let wanted = match form.instrument.as_str() {
        "" => PROPOSED,
        typed => typed,
    };
    list_instrument_options(state, school, wanted, |instrument| !instrument.scores.is_empty()).await
}

/// Returns the instruments of a school that suit a purpose; one of them is selected.
pub(in crate::scoring) async fn list_instrument_options(
    state: &AppState,
    school: SchoolId,
    chosen: &str,
    suits: fn(&Instrument) -> bool,
) -> Result<Vec<SelectOption>, Error> {
    let mut choices = Vec::new();
    for known in surveys::list_titled_instruments(state, school).await? {
        if suits(&surveys::read(&known.bytes)?) {
            let chosen = known.instrument_id == chosen;
            choices.push(SelectOption { value: known.instrument_id, label: known.title, chosen });
        }
    }
    Ok(choices)
}

pub(super) async fn make_round(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<NewRoundForm>,
) -> Result<FormAnswer<NewRoundPage>, PageError> {
    match split_refusal(read_new_round(&state, &person, &form).await)? {
        Ok(new) => {
            let id = ratings::make(&state, &person, &new).await?;
            Ok(FormAnswer::lead_to(&crate::scoring::ratings::round_href(id)))
        }
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_new_round_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

/// Parses the form. Attempts and raters that the visitor may not see are treated as unknown.
async fn read_new_round(state: &AppState, person: &CurrentPerson, form: &NewRoundForm) -> Result<NewRound, Error> {
    let refused = |why: String| Err(Error::Unprocessable(why));
    let title = single_line_text::title(&form.title).map_err(Error::Unprocessable)?.to_owned();
    let asked = form.instrument.as_str();
    let Some(instrument) = instruments::find_current_instrument(state.db.reader(), person.school_id, asked).await?
    else {
        return refused(tr!("questionnaire: “{id}” does not exist", id = asked));
    };
    let raters = read_raters(state, person, form).await?;
    let sessions = read_attempts(state, person, form, &raters).await?;
    Ok(NewRound { revision_id: instrument.id, title, generated: false, sessions, raters })
}

async fn read_raters(state: &AppState, person: &CurrentPerson, form: &NewRoundForm) -> Result<Vec<PersonId>, Error> {
    let known = stored::raters(state.db.reader(), person.school_id).await?;
    let chosen = list_chosen_once(&form.raters);
    if !(2..=MOST_RATERS).contains(&chosen.len()) {
        return Err(Error::Unprocessable(tr!(
            "raters: {count}; allowed: 2 to {most}",
            count = chosen.len(),
            most = MOST_RATERS
        )));
    }
    let find = |id: &str| known.iter().find(|rater| rater.id.to_string() == id).map(|rater| rater.id);
    let unknown =
        |id: &str| Error::Unprocessable(tr!("rater: “{id}”; allowed: the instructors of the school", id = id));
    chosen.into_iter().map(|id| find(id).ok_or_else(|| unknown(id))).collect()
}

async fn read_attempts(
    state: &AppState,
    person: &CurrentPerson,
    form: &NewRoundForm,
    raters: &[PersonId],
) -> Result<Vec<SessionId>, Error> {
    let chosen = list_chosen_once(&form.attempts);
    if !(1..=MOST_ATTEMPTS).contains(&chosen.len()) {
        return Err(Error::Unprocessable(tr!(
            "attempts: {count}; allowed: 1 to {most}",
            count = chosen.len(),
            most = MOST_ATTEMPTS
        )));
    }
    let mut attempts = Vec::new();
    for id in chosen {
        let id: SessionId = id.parse().map_err(|_| Error::NotFound)?;
        let session = sessions::find_visible_session(state.db.reader(), person, id).await?.ok_or(Error::NotFound)?;
        if raters.contains(&session.trainee_id) {
            return Err(Error::Unprocessable(
                tr!("attempts: one of them is a rater’s own; raters cannot rate themselves").to_owned(),
            ));
        }
        if session.uncounted.is_some() {
            return Err(Error::Unprocessable(
                tr!("attempts: one of them does not count and cannot be rated").to_owned(),
            ));
        }
        grades::find_grade(state.db.reader(), session.key()).await?.ok_or(Error::NotFound)?;
        attempts.push(id);
    }
    Ok(attempts)
}
