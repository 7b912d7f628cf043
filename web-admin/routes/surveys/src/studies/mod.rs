//! `/studies`: validation studies, for their owners and for administrators.

mod change;
mod exports;
mod make;
mod own;
mod results;

use acts::error::Error;
use acts::privacy::study_retention;
use acts::studies as acting;
use acts::studies::{GuestCode, ParticipantFacts};
use acts::surveys::SurveyLink;
use axum::extract::{Path, Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{PersonId, StudyId};
use model::privacy::retention::{Now, RetentionAction};
use model::{CurrentPerson, Moment, count_u32, single_line_text};
use pages::form::{FilledForm, read_ticked_box};
use pages::studies::{
    GuestCodePage, ParticipantForm, ParticipantRow, StudiesPage, StudyDataEnd, StudyDone, StudyPage, StudyRow,
    kept_in_words,
};
use pages::surveys::manage::SurveyLinksPage;
use pages::{NavPlace, Shell, format};
use routes_base::addresses::{PathId, own_address};
use routes_base::auth::{Csrf, CsrfForm, NoFields, PageHead, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::privacy::retention;
use store::studies::{self, Study, StudyExercise, StudyParticipant};

/// Maximum length of an answer to a question of a study, in characters.
const LONGEST_FACT: usize = 200;

/// Returns the routes of studies for instructors, and of invitations for every member.
pub(super) fn study_routes() -> Routes {
    Routes::new()
        .route("/account/studies", get(own::list_own_studies))
        .route("/account/studies/{id}/join", post(own::join_study))
        .route("/account/studies/{id}/leave", post(own::leave_study))
        .route("/studies", get(list_studies))
        .route("/studies/new", get(make::show_new_study).merge(post(make::make_study)))
        .route("/studies/{id}", get(show_study))
        .route("/studies/{id}/change", get(change::show_study_change).merge(post(change::change_study)))
        .route("/studies/{id}/results", get(results::show_results))
        .route("/studies/{id}/results/{file}", get(exports::serve_export))
        .route("/studies/{id}/close", post(close_study))
        .route("/studies/{id}/participants", post(add_participant))
        .route("/studies/{id}/participants/{person}/code", post(renew_code))
        .route("/studies/{id}/participants/{person}/links", post(make_links))
        .route("/studies/{id}/participants/{person}/withdraw", post(withdraw_participant))
}

/// Query parameter that names the change just made.
#[derive(Clone, Copy, Debug, Deserialize)]
struct StudyDoneQuery {
    done: Option<StudyDone>,
}

/// Returns a study that the visitor owns or administers.
async fn find_own_study(state: &AppState, person: &CurrentPerson, id: StudyId) -> Result<Study, Error> {
    studies::find_visible_study(state.db.reader(), person, id).await?.ok_or(Error::NotFound)
}

async fn list_studies(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<StudiesPage, PageError> {
    let row = |study: Study| StudyRow {
        href: format!("/studies/{}", study.id),
        title: study.title,
        owner: study.owner,
        open: study.closed_at.is_none(),
        generated: study.generated,
        created_at: study.created_at.to_utc(),
    };
    let found = studies::list_studies(state.db.reader(), &person).await.map_err(Error::from)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Surveys);
    Ok(StudiesPage { shell, studies: found.into_iter().map(row).collect() })
}

async fn show_study(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    csrf: Csrf,
    Query(StudyDoneQuery { done }): Query<StudyDoneQuery>,
) -> Result<StudyPage, PageError> {
    let study = find_own_study(&state, &person, id).await?;
    let page = make_study_page(&state, Visit::new(&person, &csrf), study, FilledForm::default()).await?;
    Ok(StudyPage { done, ..page })
}

async fn make_study_page(
    state: &AppState,
    visit: Visit<'_>,
    study: Study,
    form: FilledForm<ParticipantForm>,
) -> Result<StudyPage, Error> {
    let reader = state.db.reader();
    let exercises = studies::list_study_exercises(reader, &study).await?;
    let participants = studies::list_participants(reader, &study).await?;
    let href = format!("/studies/{}", study.id);
    Ok(StudyPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Surveys),
        facts: list_study_facts(state, &study, &exercises).await?,
        asked: study.attempts * count_u32(exercises.len()),
        participants: participants.into_iter().map(|found| participant_row(&study, &href, found)).collect(),
        open: study.closed_at.is_none(),
        ends: end_of_study_data(state, &study).await?,
        done: None,
        title: study.title,
        generated: study.generated,
        consent: study.consent,
        groups: study.groups.0,
        questions: study.questions.0,
        href,
        form,
    })
}

/// Returns when the data of a study will be erased, if that is soon, or were erased.
async fn end_of_study_data(state: &AppState, study: &Study) -> Result<StudyDataEnd, Error> {
    if let Some(at) = study.erased_at {
        return Ok(StudyDataEnd::Erased(at.to_utc()));
    }
    let observed_s = retention::service_time(state.db.reader()).await?.observed_s;
    let now = Now { at: state.clock.now(), observed_s };
    Ok(match study_retention::plan_study(study, now) {
        Some(RetentionAction::Wait(days)) => StudyDataEnd::InDays(days),
        Some(RetentionAction::Erase) => StudyDataEnd::InDays(0),
        _ => StudyDataEnd::Far,
    })
}

fn participant_row(study: &Study, href: &str, found: StudyParticipant) -> ParticipantRow {
    let told: Vec<String> = found.facts.0.into_iter().filter(|fact| !fact.is_empty()).collect();
    ParticipantRow {
        href: format!("{href}/participants/{}", found.person_id),
        pseudonym: found.pseudonym,
        name: found.name,
        group: study.groups.0.get(found.group_place as usize).cloned().unwrap_or_default(),
        facts: told.join(" · "),
        attempts: found.attempts,
        answers: found.answers,
        agreed_at: found.agreed_at.map(Moment::to_utc),
        withdrawn_at: found.withdrawn_at.map(Moment::to_utc),
        has_code: found.has_code,
    }
}

async fn list_study_facts(
    state: &AppState,
    study: &Study,
    exercises: &[StudyExercise],
) -> Result<Vec<(&'static str, String)>, Error> {
    let asked = studies::list_study_surveys(state.db.reader(), study).await?;
    let titles = |at_end| {
        let titles: Vec<&str> = asked.iter().filter(|s| s.at_end == at_end).map(|s| s.instrument.as_str()).collect();
        if titles.is_empty() { tr!("nothing").to_owned() } else { titles.join(", ") }
    };
    let exercises: Vec<&str> = exercises.iter().map(|exercise| exercise.title.as_str()).collect();
    let mut facts = vec![
        (tr!("Exercises"), exercises.join(", ")),
        (tr!("Attempts at each"), study.attempts.to_string()),
        (tr!("After each attempt"), titles(false)),
        (tr!("After the last attempt"), titles(true)),
        (tr!("Run by"), study.owner.clone()),
        (tr!("Since"), format::format_date(study.created_at.to_utc())),
    ];
    facts.extend(study.closed_at.map(|at| (tr!("Ended"), format::format_date(at.to_utc()))));
    facts.extend(terms_of_study(study));
    Ok(facts)
}

/// Returns controller, contact and retention period of the data.
fn terms_of_study(study: &Study) -> Vec<(&'static str, String)> {
    vec![
        (tr!("Data controller"), study.controller.clone()),
        (tr!("Contact"), study.contact.clone()),
        (tr!("Data are kept"), kept_in_words(study.kept_months as usize)),
    ]
}

async fn add_participant(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<ParticipantForm>,
) -> Result<FormAnswer<Response>, PageError> {
    let study = find_own_study(&state, &person, id).await?;
    let added = match read_participant(&study, &form) {
        Err(why) => Err(why),
        Ok(told) if form.email.is_empty() => {
            let code = acting::add_guest(&state, &person, &study, &told).await?;
            let page = make_code_page(&state, Visit::new(&person, &csrf), &study, code).await?;
            return Ok(FormAnswer::Answered(page.into_response()));
        }
        Ok(told) => split_refusal(acting::add_member(&state, &person, &study, &form.email, &told).await)?,
    };
    match added {
        Ok(()) => Ok(FormAnswer::lead_to(&format!("/studies/{id}?done=added#participants"))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            let page = make_study_page(&state, Visit::new(&person, &csrf), study, form).await?;
            Ok(FormAnswer::Refused(page.into_response()))
        }
    }
}

fn read_participant(study: &Study, form: &ParticipantForm) -> Result<ParticipantFacts, String> {
    // Members give their consent after signing in.
    if form.email.is_empty() && !form.consent {
        return Err(tr!("Participation requires consent.").to_owned());
    }
    let group_place = form.group.parse().ok().filter(|place| (*place as usize) < study.groups.0.len());
    let group_place: u32 = group_place.ok_or_else(|| tr!("group: choose one from the list").to_owned())?;
    let fact = |(at, question): (usize, &String)| {
        let told = form.facts.get(at).map_or("", |fact| fact.trim());
        if told.chars().count() > LONGEST_FACT {
            return Err(tr!("{question}: at most {most} characters", question = question, most = LONGEST_FACT));
        }
        single_line_text::refusal(question, told).map_or_else(|| Ok(told.to_owned()), Err)
    };
    let facts = study.questions.0.iter().enumerate().map(fact).collect::<Result<_, _>>()?;
    Ok(ParticipantFacts { group_place, facts })
}

/// Renders a code directly: with a redirect it would have to be stored until it is shown.
async fn make_code_page(
    state: &AppState,
    visit: Visit<'_>,
    study: &Study,
    code: GuestCode,
) -> Result<GuestCodePage, Error> {
    let exercises = studies::list_study_exercises(state.db.reader(), study).await?;
    Ok(GuestCodePage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Surveys),
        study: (study.title.clone(), format!("/studies/{}", study.id)),
        pseudonym: code.pseudonym,
        code: code.code,
        exercises: exercises.into_iter().map(|exercise| exercise.title).collect(),
        attempts: study.attempts as usize,
        consent: study.consent.clone(),
        terms: terms_of_study(study),
    })
}

/// Path parameters of a study and a participant.
#[derive(Deserialize)]
struct ParticipantPlace {
    id: String,
    person: String,
}

/// Returns the study and the participant of a path.
async fn find_place(
    state: &AppState,
    person: &CurrentPerson,
    place: &ParticipantPlace,
) -> Result<(Study, PersonId), Error> {
    let study = place.id.parse().map_err(|_| Error::NotFound)?;
    let participant = place.person.parse().map_err(|_| Error::NotFound)?;
    Ok((find_own_study(state, person, study).await?, participant))
}

async fn renew_code(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(place): Path<ParticipantPlace>,
    csrf: Csrf,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<GuestCodePage, PageError> {
    let (study, guest) = find_place(&state, &person, &place).await?;
    let code = acting::renew_guest_code(&state, &person, &study, guest).await?;
    Ok(make_code_page(&state, Visit::new(&person, &csrf), &study, code).await?)
}

async fn make_links(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(place): Path<ParticipantPlace>,
    head: PageHead,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<SurveyLinksPage, PageError> {
    let (study, participant) = find_place(&state, &person, &place).await?;
    let links = acting::make_answer_links(&state, &person, &study, participant).await?;
    let address = own_address(&state, &head.headers);
    let link = |SurveyLink { label, token }: SurveyLink| (label, format!("{address}/survey/{token}"));
    Ok(SurveyLinksPage {
        shell: Shell::new(&person, head.csrf.token(), NavPlace::Surveys),
        href: format!("/studies/{}", study.id),
        title: study.title,
        links: links.into_iter().map(link).collect(),
    })
}

#[derive(Deserialize)]
#[serde(default)]
#[derive(Default)]
struct WithdrawForm {
    #[serde(deserialize_with = "read_ticked_box")]
    erase: bool,
}

async fn withdraw_participant(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(place): Path<ParticipantPlace>,
    CsrfForm(form): CsrfForm<WithdrawForm>,
) -> Result<Redirect, PageError> {
    let (study, participant) = find_place(&state, &person, &place).await?;
    acting::withdraw_participant(&state, &person, &study, participant, form.erase).await?;
    Ok(Redirect::to(&format!("/studies/{}?done=left#participants", study.id)))
}

#[derive(Deserialize)]
struct CloseStudyForm {
    closed: bool,
}

async fn close_study(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    CsrfForm(form): CsrfForm<CloseStudyForm>,
) -> Result<Redirect, PageError> {
    let study = find_own_study(&state, &person, id).await?;
    acting::close_study(&state, &person, &study, form.closed).await?;
    Ok(Redirect::to(&format!("/studies/{id}?done={}", if form.closed { "ended" } else { "opened" })))
}
