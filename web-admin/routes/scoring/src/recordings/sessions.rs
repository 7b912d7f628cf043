//! `/sessions/{id}`: one attempt.

use acts::error::Error;
use acts::letters::notices;
use acts::scoring::regrading::Rubric;
use attempt::AttemptCurve;
use axum::extract::State;
use documents::{Exercise, ExerciseBundle};
use law::structures::StructureKind;
use model::ids::SessionId;
use model::letters::notice::NoticePlace;
use model::{CurrentPerson, SessionKey, Uncounted};
use pages::charts::Drawing;
use pages::recordings::session::{Ruling, SessionOutcome, SessionPage, VerificationResult};
use pages::scoring::exam_files::{ExamFileRow, ExamFiles};
use pages::scoring::judgement::{GradedAttempt, JudgementView};
use pages::training::addresses::exercise_href;
use pages::{NavPlace, Shell, format};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::authoring::exercises::published_bundle;
use routes_base::error::PageError;
use routes_base::{AppState, surveys};
use store::authoring::exercises;
use store::recordings::sessions;
use store::recordings::sessions::{Session, SessionState};
use store::scoring::exam_files::ListedExamFile;
use store::scoring::{exam_files, grades, scores, supervisions};
use store::stations;
use store::training::reports;

use crate::recordings::others;

pub(crate) async fn show_session(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SessionId>,
    csrf: Csrf,
) -> Result<SessionPage, PageError> {
    let reader = state.db.reader();
    let session = sessions::find_visible_session(reader, &person, id).await?.ok_or(Error::NotFound)?;
    let person = notices::note_read(&state, person, NoticePlace::Attempt(id)).await?;
    let key = SessionKey { school_id: session.school_id, id };
    let bundle = match session.revision_id {
        Some(revision) => published_bundle(&state, session.school_id, revision).await?,
        None => None,
    };
    let taught = exercises::find_current_revision(reader, session.school_id, &session.exercise_id).await?;
    let title = bundle
        .as_ref()
        .map(|b| b.exercise.title.in_language(words::current().code()).to_owned())
        .or(taught.as_ref().map(|t| t.title.clone()));
    let curve = scores::find_curve(reader, key).await?;
    let replay_href = format!("/sessions/{id}/replay");
    Ok(SessionPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Elsewhere),
        exercise: title.unwrap_or_else(|| session.exercise_id.clone()),
        exercise_href: taught.map(|t| exercise_href(&t.exercise_id)),
        trainee: name_of_trainee(&state, &person, &session).await?,
        started_at: session.started_at.to_utc(),
        grade_href: format!("/sessions/{id}/grade"),
        outcome: outcome_of_session(&state, &person, &session, bundle.as_ref(), curve.as_ref()).await?,
        ruling: ruling_on_session(&state, &session).await?,
        drawing: curve.as_ref().map(|curve| Drawing::new(curve).leading_to(&replay_href)),
        replay_href,
        uncounted: why_uncounted(&state, &person, &session).await?,
        is_replaced: session.uncounted == Some(Uncounted::Unpublished) && session.revision_id.is_some(),
        verification: verification_of_session(&session),
        signed_by: name_of_signer(&state, &session).await?,
        supervised_by: supervisions::find_supervision(reader, key).await?.map(|there| there.by),
        surveys: surveys::list_surveys_after(&state, &person, &session).await?,
        facts: list_session_facts(&session),
        exam_files: exam_files_of(&state, &person, &session).await?,
    })
}

/// Returns the exam files of an attempt, if the visitor teaches its trainee.
async fn exam_files_of(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<Option<ExamFiles>, Error> {
    if !person.role.teaches() || person.id == session.trainee_id {
        return Ok(None);
    }
    let row = |file: ListedExamFile| ExamFileRow {
        id: file.id,
        by: file.by,
        at: file.made_at.to_utc(),
        bytes: file.bytes,
        sha256: file.sha256,
        is_erased: file.is_erased,
    };
    let files = exam_files::list_exam_files(state.db.reader(), session.key()).await?;
    let is_scored = session.state == SessionState::Scored && session.recording_erased_at.is_none();
    Ok(Some(ExamFiles { session: session.id, is_scored, files: files.into_iter().map(row).collect() }))
}

/// Returns the current title of the attempted exercise, or its id if it is no longer taught.
pub(crate) async fn title_of_exercise(state: &AppState, session: &Session) -> Result<String, Error> {
    let taught = exercises::find_current_revision(state.db.reader(), session.school_id, &session.exercise_id).await?;
    Ok(taught.map_or_else(|| session.exercise_id.clone(), |taught| taught.title))
}

/// Returns name and page of the trainee, unless the visitor is the trainee.
pub(crate) async fn name_of_trainee(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<Option<(String, String)>, Error> {
    if person.id == session.trainee_id {
        return Ok(None);
    }
    let trainee = reports::trainee(state.db.reader(), person, session.trainee_id).await?;
    Ok(trainee.map(|t| (t.name, format!("/trainees/{}", t.id))))
}

async fn outcome_of_session(
    state: &AppState,
    viewer: &CurrentPerson,
    session: &Session,
    bundle: Option<&ExerciseBundle>,
    curve: Option<&AttemptCurve>,
) -> Result<SessionOutcome, Error> {
    let reader = state.db.reader();
    let key = SessionKey { school_id: session.school_id, id: session.id };
    let Some(score) = scores::find_newest_score(reader, key).await? else {
        return Ok(match session.state {
            SessionState::Refused => SessionOutcome::Refused(session.refusal.clone().unwrap_or_default()),
            SessionState::Pending | SessionState::Scored => SessionOutcome::Waiting,
        });
    };
    let metrics = scores::list_score_metrics(reader, key).await?;
    let judged_by = match bundle {
        Some(bundle) => Some(judging_exercise(state, session, &bundle.exercise, &score.rubric_sha256).await?),
        None => None,
    };
    let graded = GradedAttempt {
        score: score.score,
        passed: score.passed,
        deductions: &score.deductions,
        hard_fails: &score.hard_fails,
        metrics: &metrics,
        exercise: judged_by.as_ref(),
        targets: &bundle.map(names_of_targets).unwrap_or_default(),
        curve,
        others: &others::spreads_beside(state, viewer, session).await?,
    };
    Ok(SessionOutcome::Scored(Box::new(JudgementView::new(&graded))))
}

/// Returns the exercise with the rubric that was applied: after a re-grade it differs from the one
/// shown to the trainee.
async fn judging_exercise(
    state: &AppState,
    session: &Session,
    asked: &Exercise,
    rubric_sha256: &str,
) -> Result<Exercise, Error> {
    if asked.rubric_sha256() == rubric_sha256 {
        return Ok(asked.clone());
    }
    let rubric = Rubric::of_digest(state, session.school_id, &session.exercise_id, rubric_sha256).await?;
    Ok(rubric.map_or_else(|| asked.clone(), |rubric| rubric.judging(asked)))
}

/// Returns the names of the target structures.
fn names_of_targets(bundle: &ExerciseBundle) -> Vec<String> {
    let targets = bundle.scene.structures.iter().filter(|structure| structure.spec.kind == StructureKind::Target);
    targets.map(|structure| structure.spec.name.clone()).collect()
}

/// Returns the override in force, if there is one.
async fn ruling_on_session(state: &AppState, session: &Session) -> Result<Option<Ruling>, Error> {
    let newest = grades::list_overrides(state.db.reader(), session.key()).await?.pop();
    Ok(newest.and_then(|made| {
        let (score, passed) = made.score.zip(made.passed)?;
        Some(Ruling { score, passed, by: made.by, reason: made.reason })
    }))
}

/// Returns why an attempt does not count, and the page of the attempt that it duplicates, if the
/// visitor may see that.
async fn why_uncounted(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<Option<(Uncounted, Option<String>)>, Error> {
    let Some(why) = session.uncounted else { return Ok(None) };
    let first = match session.repeats {
        Some(first) => sessions::find_visible_session(state.db.reader(), person, first).await?,
        None => None,
    };
    Ok(Some((why, first.map(|first| format!("/sessions/{}", first.id)))))
}

/// Returns the name of the station that signed the attempt.
async fn name_of_signer(state: &AppState, session: &Session) -> Result<Option<String>, Error> {
    match session.signed_by {
        Some(station) => Ok(stations::find_station_name(state.db.reader(), session.school_id, station).await?),
        None => Ok(None),
    }
}

fn verification_of_session(session: &Session) -> VerificationResult {
    match (session.verify_flagged, session.verify_deviation_n) {
        (None, _) => VerificationResult::Waiting,
        (Some(false), _) => VerificationResult::Same,
        (Some(true), deviation) => VerificationResult::Differs {
            deviation_n: deviation.unwrap_or(f64::INFINITY),
            events: session.verify_event_differences.unwrap_or(0),
        },
    }
}

fn list_session_facts(session: &Session) -> Vec<(&'static str, String)> {
    let size = format::format_size(session.recording_size);
    let recording = match (session.recording_erased_at, session.complete) {
        (Some(at), _) => tr!("erased on {date}", date = format::format_date(at.to_utc())),
        (None, true) => tr!("{size}, complete", size = size),
        (None, false) => tr!("{size}, truncated", size = size),
    };
    let short = |hash: &str| format::shorten_hash(hash).to_owned();
    let revision = match session.revision_id {
        Some(_) => short(&session.exercise_sha256),
        None => tr!("{hash}, never published by this school", hash = short(&session.exercise_sha256)),
    };
    let claimed = session
        .claimed_started_at
        .map(|at| (tr!("Started, according to the recording"), format::format_date_time(at.to_utc())));
    let facts = [
        (tr!("Duration"), format::format_span(session.duration_s)),
        (tr!("Device"), session.device.clone()),
        (tr!("Received"), format::format_date_time(session.received_at.to_utc())),
        (tr!("Simulator"), session.simulator_version.clone()),
        (tr!("Seed"), session.seed.clone()),
        (tr!("Recording"), recording),
        (tr!("Exercise revision"), revision),
        (tr!("Scene revision"), short(&session.scene_sha256)),
        (tr!("Session"), session.id.to_string()),
    ];
    claimed.into_iter().chain(facts).collect()
}
