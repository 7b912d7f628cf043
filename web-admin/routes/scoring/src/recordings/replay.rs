//! `/sessions/{id}/replay`: the replay of an attempt, with its comments.

use acts::error::Error;
use acts::letters::notices;
use acts::privacy::consents;
use acts::training::comments as said;
use attempt::AttemptCurve;
use axum::extract::{Path, Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{CommentId, SessionId};
use model::letters::notice::NoticePlace;
use model::scoring::expert_comparison::GhostStretch;
use model::scoring::review::{AskedReviews, ReviewFilter};
use model::scoring::{corridor, expert_comparison};
use model::training::comment;
use model::training::comment::{Comment, TypedComment};
use model::{CurrentPerson, Moment, Role};
use pages::charts::Drawing;
use pages::form::FilledForm;
use pages::recordings::replay::{CommentForm, CommentView, ReplayPage, ReviewLook, Utterance};
use pages::scoring::experts::BesideExperts;
use pages::scoring::replay_events::{NamedHappenings, OtherAttempt};
use pages::{NavPlace, Shell, format};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::privacy::experts;
use store::recordings::sessions;
use store::recordings::sessions::{Session, SessionState};
use store::scoring::{reviews, scores};
use store::training::comments::CommentRecord;
use store::training::{comments, reports};

use crate::recordings::sessions as attempts;

/// Query parameters of the replay.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct ReplayQuery {
    /// An attempt to overlay; empty for none.
    #[serde(default)]
    with: String,
    /// Time at which the replay opens, in s; empty for the beginning.
    #[serde(default)]
    t: String,
    /// The filter of the review queue from which the page was opened.
    #[serde(flatten)]
    asked: AskedReviews,
}

pub(crate) async fn show_replay(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
    Query(query): Query<ReplayQuery>,
) -> Result<ReplayPage, PageError> {
    let session = find_visible_attempt(&state, &person, id).await?;
    let person = notices::note_read(&state, person, NoticePlace::Replay(id)).await?;
    Ok(make_replay_page(&state, Visit::new(&person, &csrf), &session, CommentForm::default(), query).await?)
}

/// Returns an attempt that a person may see.
async fn find_visible_attempt(state: &AppState, person: &CurrentPerson, id: SessionId) -> Result<Session, Error> {
    sessions::find_visible_session(state.db.reader(), person, id).await?.ok_or(Error::NotFound)
}

async fn make_replay_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    session: &Session,
    form: CommentForm,
    query: ReplayQuery,
) -> Result<ReplayPage, Error> {
    let reader = state.db.reader();
    let key = session.key();
    let curve = scores::find_curve(reader, key).await?;
    let said = comments::list_session_comments(reader, key).await?;
    let beside = match &curve {
        Some(curve) => compare_with_experts(state, session, curve).await?,
        None => None,
    };
    let happened = NamedHappenings::new(curve.as_ref(), &query.t, session.duration_s);
    Ok(ReplayPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Elsewhere),
        session: session.id,
        exercise: attempts::title_of_exercise(state, session).await?,
        trainee: attempts::name_of_trainee(state, person, session).await?,
        started_at: session.started_at.to_utc(),
        duration_s: session.duration_s,
        drawing: curve.as_ref().map(|curve| Drawing::new(curve).leading_to("")),
        happened: match beside.as_ref().filter(|_| query.with == EXPERTS) {
            Some(beside) => happened.beside(beside.ghost.clone(), beside.shown.experts),
            None => happened,
        },
        experts: beside.map(|beside| beside.shown),
        consent: match person.role {
            Role::Trainee | Role::Guest => None,
            _ => Some(experts::list_consents(reader, person.school_id, person.id).await?.map(Moment::to_utc)),
        },
        look: look_at(state, person, session, &query).await?,
        comments: comment_views(&said, person),
        form,
        others: other_attempts(state, person, session, query.with.parse().ok()).await?,
    })
}

/// Returns the review controls, for teachers.
async fn look_at(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
    query: &ReplayQuery,
) -> Result<Option<ReviewLook>, Error> {
    if !person.role.teaches() || session.state != SessionState::Scored {
        return Ok(None);
    }
    let reviewed = reviews::find_review(state.db.reader(), session.key()).await?.is_some();
    Ok(Some(ReviewLook { reviewed, filter: ReviewFilter::asked(&query.asked) }))
}

/// Value of `with` that selects the experts' median instead of an attempt.
const EXPERTS: &str = "experts";

/// The comparison of an attempt with the experts, and the path of their median.
struct ExpertsBeside {
    shown: BesideExperts,
    ghost: Vec<GhostStretch>,
}

async fn compare_with_experts(
    state: &AppState,
    session: &Session,
    curve: &AttemptCurve,
) -> Result<Option<ExpertsBeside>, Error> {
    let experts = experts::list_expert_curves(state.db.reader(), session.school_id, &session.exercise_id).await?;
    Ok(corridor::corridor(curve, &experts).map(|made| ExpertsBeside {
        shown: BesideExperts::new(
            curve,
            &made,
            &expert_comparison::compare_by_layer(curve, &experts),
            expert_comparison::find_overreach(curve, &experts).as_ref(),
        ),
        ghost: expert_comparison::median_way(curve, &experts),
    }))
}

#[derive(Debug, Deserialize)]
pub(crate) struct ConsentForm {
    #[serde(default)]
    consent: String,
}

/// Gives or withdraws the visitor's own consent to be one of the experts.
pub(crate) async fn change_own_consent(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(form): CsrfForm<ConsentForm>,
) -> Result<Redirect, PageError> {
    if person.role == Role::Trainee {
        return Err(Error::Forbidden(tr!("the experts’ corridor is for instructors")).into());
    }
    match form.consent.as_str() {
        "given" => consents::give_own_consent(&state, &person, words::say(corridor::WORDING)).await?,
        "withdrawn" => consents::withdraw_consent(&state, &person, person.id).await?,
        other => {
            let why = format!("consent: \"{other}\"; allowed: given, withdrawn");
            return Err(Error::BadRequest(why).into());
        }
    }
    Ok(Redirect::to("/review"))
}

/// Returns other scored attempts at the same exercise that the visitor may see, including those of
/// the same trainee.
async fn other_attempts(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
    chosen: Option<SessionId>,
) -> Result<Vec<OtherAttempt>, Error> {
    let listed = reports::latest_at(state.db.reader(), person, &session.exercise_id).await?;
    let scored = listed.into_iter().filter(|other| other.id != session.id && other.score.is_some());
    let label = |other: &reports::ListedAttempt| {
        let score = other.score.map_or_else(String::new, format::format_points);
        format!("{}, {}, {score}", other.trainee, format::format_date_time(other.started_at.to_utc()))
    };
    Ok(scored.map(|o| OtherAttempt { session: o.id, label: label(&o), chosen: Some(o.id) == chosen }).collect())
}

/// Returns comments with their answers.
fn comment_views(kept: &[CommentRecord], visitor: &CurrentPerson) -> Vec<CommentView> {
    let said = |kept: &CommentRecord| Utterance {
        body: kept.body.clone(),
        author: kept.author.clone(),
        at: kept.made_at.to_utc(),
        own: kept.author_id == visitor.id,
    };
    let answers = |id: CommentId| kept.iter().filter(move |k| k.answers == Some(id)).map(|k| (k.id, said(k))).collect();
    let view = |k: &CommentRecord| {
        let (kind, from_s) = k.kind.zip(k.from_s)?;
        Some(CommentView { id: k.id, kind, from_s, to_s: k.to_s, said: said(k), answers: answers(k.id) })
    };
    kept.iter().filter_map(view).collect()
}

/// Adds a comment; a refused one is shown again with the input.
pub(crate) async fn add_comment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<TypedComment>,
) -> Result<FormAnswer<ReplayPage>, PageError> {
    let session = find_visible_attempt(&state, &person, id).await?;
    match Comment::parse(&typed, session.duration_s) {
        Ok(comment) => {
            let made = said::add_comment(&state, &person, &session, &comment).await?;
            Ok(FormAnswer::Answered(redirect_to_comment(id, made, comment.from_s)))
        }
        Err(refused) => {
            let form = CommentForm { fields: FilledForm::refused(typed, refused.to_string()), answers: None };
            Ok(FormAnswer::Refused(make_commented_page(&state, Visit::new(&person, &csrf), &session, form).await?))
        }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct CommentAnswerForm {
    #[serde(default)]
    body: String,
}

/// Answers a comment.
pub(crate) async fn answer_comment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(SessionId, CommentId)>, axum::extract::rejection::PathRejection>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<CommentAnswerForm>,
) -> Result<FormAnswer<ReplayPage>, PageError> {
    let Path((id, comment)) = path.map_err(|_| Error::NotFound)?;
    let session = find_visible_attempt(&state, &person, id).await?;
    let body = match comment::words(&typed.body) {
        Ok(body) => body,
        Err(refused) => {
            let typed = TypedComment { body: typed.body, ..TypedComment::default() };
            let form = CommentForm { fields: FilledForm::refused(typed, refused.to_string()), answers: Some(comment) };
            let page = make_commented_page(&state, Visit::new(&person, &csrf), &session, form).await?;
            return Ok(FormAnswer::Refused(page));
        }
    };
    let made = said::answer_comment(&state, &person, &session, comment, &body).await?;
    let said = comments::list_session_comments(state.db.reader(), session.key()).await?;
    let from_s = said.iter().find(|said| said.id == comment).and_then(|said| said.from_s);
    Ok(FormAnswer::Answered(redirect_to_comment(id, made, from_s.unwrap_or_default())))
}

/// Withdraws a comment or an answer of the visitor's own.
pub(crate) async fn withdraw_comment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(SessionId, CommentId)>, axum::extract::rejection::PathRejection>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let Path((id, add_comment)) = path.map_err(|_| Error::NotFound)?;
    let session = find_visible_attempt(&state, &person, id).await?;
    said::withdraw_comment(&state, &person, &session, add_comment).await?;
    Ok(Redirect::to(&format!("/sessions/{id}/replay#comments")).into_response())
}

/// The replay at the moment of a comment.
fn redirect_to_comment(session: SessionId, comment: CommentId, from_s: f64) -> Response {
    Redirect::to(&format!("/sessions/{session}/replay?t={from_s:.2}#comment-{comment}")).into_response()
}

async fn make_commented_page(
    state: &AppState,
    visit: Visit<'_>,
    session: &Session,
    form: CommentForm,
) -> Result<ReplayPage, Error> {
    make_replay_page(state, visit, session, form, ReplayQuery::default()).await
}
