//! `/review`, and the pages of a grade with its history and reasons.

use acts::error::Error;
use acts::letters::notices;
use acts::scoring::regrading::{Regrader, Rubric};
use acts::scoring::{regrading, reviewing};
use acts::surveys;
use assessment::{Assessment, questionnaire};
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::CurrentPerson;
use model::ids::{CohortId, SessionId};
use model::letters::notice::NoticePlace;
use model::scoring::judgement;
use model::scoring::judgement::{ScoreOverride, TypedOverride};
use model::scoring::rating::mean;
use model::scoring::review::{AskedReviews, QueuePlace, ReviewFilter};
use pages::form::{FilledForm, SelectOption};
use pages::scoring::review as views;
use pages::scoring::review::{GradeAct, GradePage, JudgedAttempt, RatedMean, RegradePage, ReviewPage, WaitingRow};
use pages::{NavPlace, Shell, StatusWord, format};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::audit::Actor;
use store::authoring::exercises;
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::scoring::grades::NewOverride;
use store::scoring::reviews::WaitingReview;
use store::scoring::scores::Score;
use store::scoring::{grades, ratings, regradings, reviews, scores, supervisions};
use store::training::reports;
use store::training::reports::NamedItem;

use crate::recordings::sessions as attempts;

/// Filter and position of the review queue.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct QueueQuery {
    #[serde(flatten)]
    asked: AskedReviews,
    #[serde(default)]
    after: String,
}

pub(crate) async fn show_queue(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(query): Query<QueueQuery>,
) -> Result<ReviewPage, PageError> {
    let reader = state.db.reader();
    let filter = ReviewFilter::asked(&query.asked);
    let after: Option<QueuePlace> = query.after.parse().ok();
    let mut waiting = reviews::list_review_queue(reader, &person, &filter, after).await?;
    let more = waiting.len() > reviews::LISTED as usize;
    waiting.truncate(reviews::LISTED as usize);
    let next = waiting.last().filter(|_| more).map(|last| queue_href(&filter, Some(last.place())));
    let cohorts = reports::cohorts(reader, &person).await?.into_iter();
    let option = |cohort: NamedItem<CohortId>| SelectOption {
        chosen: filter.cohort == Some(cohort.id),
        value: cohort.id.to_string(),
        label: cohort.name,
    };
    Ok(ReviewPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Review),
        waiting: waiting.into_iter().map(make_waiting_row).collect(),
        next,
        first: after.map(|_| queue_href(&filter, None)),
        cohorts: cohorts.map(option).collect(),
        exercises: exercises::list_current_exercises(reader, person.school_id)
            .await?
            .into_iter()
            .map(|exercise| SelectOption {
                chosen: filter.exercise.as_ref() == Some(&exercise.exercise_id),
                value: exercise.exercise_id,
                label: exercise.title,
            })
            .collect(),
        filter,
        to_rate: ratings::count_open(reader, &person).await?,
    })
}

fn queue_href(filter: &ReviewFilter, after: Option<QueuePlace>) -> String {
    let parts = [filter.query(), after.map_or_else(String::new, |after| format!("after={after}"))];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    if parts.is_empty() { "/review".to_owned() } else { format!("/review?{}", parts.join("&")) }
}

fn make_waiting_row(waiting: WaitingReview) -> WaitingRow {
    WaitingRow {
        session: waiting.id,
        at: waiting.started_at.to_utc(),
        trainee: waiting.trainee,
        exercise: waiting.exercise,
        score: waiting.score,
        status: if waiting.passed { StatusWord::Passed } else { StatusWord::Failed },
        flagged: waiting.flagged,
        questions: waiting.questions,
    }
}

/// Returns an attempt that a person may see.
async fn find_visible_attempt(state: &AppState, person: &CurrentPerson, id: SessionId) -> Result<Session, Error> {
    sessions::find_visible_session(state.db.reader(), person, id).await?.ok_or(Error::NotFound)
}

/// Returns a scored attempt that a person may grade.
pub(crate) async fn find_scored(state: &AppState, person: &CurrentPerson, id: SessionId) -> Result<Session, Error> {
    let session = find_visible_attempt(state, person, id).await?;
    match grades::find_grade(state.db.reader(), session.key()).await? {
        Some(_) => Ok(session),
        None => Err(Error::Conflict(tr!("this attempt has not been scored yet").to_owned())),
    }
}

pub(crate) async fn show_grade(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
) -> Result<GradePage, PageError> {
    let session = find_visible_attempt(&state, &person, id).await?;
    let person = notices::note_read(&state, person, NoticePlace::Grade(id)).await?;
    Ok(make_grade_page(&state, Visit::new(&person, &csrf), &session, FilledForm::default()).await?)
}

async fn make_grade_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    session: &Session,
    form: FilledForm<TypedOverride>,
) -> Result<GradePage, Error> {
    let (reader, key) = (state.db.reader(), session.key());
    let computed = scores::list_scores(reader, key).await?;
    let grade = grades::find_grade(reader, key).await?;
    let review = reviews::find_review(reader, key).await?;
    let supervised = supervisions::find_supervision(reader, key).await?;
    let regraded = regradings::of_session(reader, key).await?;
    Ok(GradePage {
        shell: Shell::new(person, csrf.token(), NavPlace::Elsewhere),
        attempt: judged_attempt(state, person, session).await?,
        counts: grade.map(|grade| (grade.score, grade.passed)),
        computed: computed.last().map(|score| score.score),
        overridden: grade.is_some_and(|grade| grade.overridden),
        history: grade_history(&computed, &regraded, grades::list_overrides(reader, key).await?),
        reviewed: review.map(|review| (review.by, review.reviewed_at.to_utc())),
        supervised: supervised.map(|known| (known.by, known.confirmed_at.to_utc())),
        ratings: means_of_ratings(state, person, session).await?,
        judge: person.role.teaches(),
        form,
    })
}

/// Returns the means of the finished ratings, by round and score.
async fn means_of_ratings(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<Vec<RatedMean>, Error> {
    let finished = ratings::finished_of(state.db.reader(), session.key(), person.id).await?;
    let mut means = Vec::new();
    for round in finished.chunk_by(|a, b| a.round_id == b.round_id) {
        let first = &round[0];
        let Some(instrument) = surveys::revision(state, session.school_id, first.revision_id).await? else { continue };
        for key in &instrument.scores {
            let score =
                |given: &ratings::FinishedRating| questionnaire::score_response(&instrument, key, &given.answers).ok();
            let scores: Vec<Option<f64>> = round.iter().map(score).collect();
            means.extend(mean(&scores).map(|(mean, raters)| RatedMean {
                round: first.title.clone(),
                href: format!("/ratings/{}", first.round_id),
                score: key.title.in_language(words::current().code()).to_owned(),
                mean,
                raters,
                generated: first.generated,
            }));
        }
    }
    Ok(means)
}

async fn judged_attempt(state: &AppState, person: &CurrentPerson, session: &Session) -> Result<JudgedAttempt, Error> {
    Ok(JudgedAttempt {
        id: session.id,
        exercise: attempts::title_of_exercise(state, session).await?,
        trainee: attempts::name_of_trainee(state, person, session).await?,
        started_at: session.started_at.to_utc(),
    })
}

fn grade_history(
    computed: &[Score],
    regraded: &[regradings::RegradingAct],
    overrides: Vec<grades::OverrideRecord>,
) -> Vec<views::GradeHistoryEntry> {
    let computed = computed.iter().enumerate().map(|(i, score)| {
        let rubric = format::shorten_hash(&score.rubric_sha256).to_owned();
        let why = regraded.iter().find(|act| act.score_id == score.id);
        let by =
            |act: &regradings::RegradingAct| act.by.clone().unwrap_or_else(|| tr!("At the command line").to_owned());
        let why = why.map(|act| (by(act), act.reason.clone()));
        let act = if i == 0 { GradeAct::Computed(rubric) } else { GradeAct::Regraded { rubric, why } };
        views::GradeHistoryEntry { at: score.computed_at.to_utc(), act, grade: Some((score.score, score.passed)) }
    });
    let overrides = overrides.into_iter().map(|made| {
        let (by, reason) = (made.by, made.reason);
        let grade = made.score.zip(made.passed);
        let act =
            if grade.is_some() { GradeAct::Overridden { by, reason } } else { GradeAct::Withdrawn { by, reason } };
        views::GradeHistoryEntry { at: made.made_at.to_utc(), act, grade }
    });
    let mut history: Vec<views::GradeHistoryEntry> = computed.chain(overrides).collect();
    history.sort_by_key(|entry| entry.at);
    history
}

/// Overrides the computed score. Without a reason it is refused, and the input is shown again.
pub(crate) async fn put_override(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<TypedOverride>,
) -> Result<FormAnswer<GradePage>, PageError> {
    let session = find_scored(&state, &person, id).await?;
    match ScoreOverride::parse(&typed) {
        Ok(ScoreOverride { score, passed, reason }) => {
            let new = NewOverride { grade: Some((score, passed)), reason: &reason, made_by: person.id };
            reviewing::override_grade(&state, &person, &session, &new).await?;
            Ok(FormAnswer::Answered(redirect_to_grade(id)))
        }
        Err(refused) => {
            let form = FilledForm::refused(typed, refused.to_string());
            Ok(FormAnswer::Refused(make_grade_page(&state, Visit::new(&person, &csrf), &session, form).await?))
        }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct ReasonForm {
    #[serde(default)]
    reason: String,
}

/// Withdraws the override, so that the computed score counts again.
pub(crate) async fn withdraw_override(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<ReasonForm>,
) -> Result<FormAnswer<GradePage>, PageError> {
    let session = find_scored(&state, &person, id).await?;
    match judgement::reason(&typed.reason) {
        Ok(reason) => {
            let new = NewOverride { grade: None, reason: &reason, made_by: person.id };
            reviewing::override_grade(&state, &person, &session, &new).await?;
            Ok(FormAnswer::Answered(redirect_to_grade(id)))
        }
        Err(refused) => {
            let form = FilledForm::refused(TypedOverride::default(), refused.to_string());
            Ok(FormAnswer::Refused(make_grade_page(&state, Visit::new(&person, &csrf), &session, form).await?))
        }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct MarkForm {
    #[serde(default)]
    mark: String,
    /// Page to open next: `next` for the next attempt of the queue, `stay` for the replay, else the
    /// page of the grade.
    #[serde(default)]
    then: String,
    /// The filter of the review queue.
    #[serde(flatten)]
    asked: AskedReviews,
}

/// Marks an attempt as reviewed, or returns it to the queue.
pub(crate) async fn mark_reviewed(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    CsrfForm(form): CsrfForm<MarkForm>,
) -> Result<Response, PageError> {
    let session = find_scored(&state, &person, id).await?;
    let reviewed = match form.mark.as_str() {
        "reviewed" => true,
        "waiting" => false,
        other => {
            let why = format!("mark: \"{other}\"; allowed: reviewed, waiting");
            return Err(Error::BadRequest(why).into());
        }
    };
    reviewing::set_reviewed(&state, &person, &session, reviewed).await?;
    let filter = ReviewFilter::asked(&form.asked);
    Ok(match form.then.as_str() {
        "next" => lead_to_next(&state, &person, &filter).await?,
        "stay" => Redirect::to(&replay_in_queue(id, &filter)).into_response(),
        _ => redirect_to_grade(id),
    })
}

/// Redirects to the replay of the first attempt in the queue; to the queue itself if it is empty.
async fn lead_to_next(state: &AppState, person: &CurrentPerson, filter: &ReviewFilter) -> Result<Response, Error> {
    let waiting = reviews::list_review_queue(state.db.reader(), person, filter, None).await?;
    let to = waiting.first().map_or_else(|| queue_href(filter, None), |first| replay_in_queue(first.id, filter));
    Ok(Redirect::to(&to).into_response())
}

fn replay_in_queue(session: SessionId, filter: &ReviewFilter) -> String {
    let query = filter.query();
    let mark = if query.is_empty() { "" } else { "?" };
    format!("/sessions/{session}/replay{mark}{query}")
}

/// Shows the attempt's score by the current rubric.
pub(crate) async fn preview_regrade(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
) -> Result<RegradePage, PageError> {
    let session = find_scored(&state, &person, id).await?;
    let after = assess_by_today(&state, &session).await?;
    Ok(make_regrade_page(&state, Visit::new(&person, &csrf), &session, after).await?)
}

async fn make_regrade_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    session: &Session,
    after: Assessment,
) -> Result<RegradePage, Error> {
    let before = scores::find_newest_score(state.db.reader(), session.key()).await?.ok_or(Error::NotFound)?;
    Ok(RegradePage {
        shell: Shell::new(person, csrf.token(), NavPlace::Elsewhere),
        attempt: judged_attempt(state, person, session).await?,
        before: (before.score, before.passed),
        after: (after.score, after.passed),
        same: before.rubric_sha256 == after.rubric.sha256,
        lost: views::list_deductions(&after),
        failures: views::list_failures(&after),
        reason: FilledForm::default(),
    })
}

async fn assess_by_today(state: &AppState, session: &Session) -> Result<Assessment, Error> {
    let rubric = Rubric::of_today(state, session.school_id, &session.exercise_id).await?;
    let not_taught =
        || Error::Conflict(tr!("this exercise is no longer taught, so it has no current rubric").to_owned());
    rubric.ok_or_else(not_taught)?.judge(state, session).await
}

/// Grades the attempt by the current rubric. Without a reason it is refused, and the input is shown
/// again.
pub(crate) async fn regrade_attempt(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<ReasonForm>,
) -> Result<FormAnswer<RegradePage>, PageError> {
    let session = find_scored(&state, &person, id).await?;
    let after = assess_by_today(&state, &session).await?;
    match judgement::reason(&typed.reason) {
        Ok(reason) => {
            let by = Regrader { actor: Actor::Person(person.id), reason: Some(&reason) };
            regrading::apply(&state, by, &session, &after).await?;
            Ok(FormAnswer::Answered(redirect_to_grade(id)))
        }
        Err(refused) => {
            let page = make_regrade_page(&state, Visit::new(&person, &csrf), &session, after).await?;
            let reason = FilledForm::refused(typed.reason, refused.to_string());
            Ok(FormAnswer::Refused(RegradePage { reason, ..page }))
        }
    }
}

fn redirect_to_grade(session: SessionId) -> Response {
    Redirect::to(&format!("/sessions/{session}/grade")).into_response()
}
