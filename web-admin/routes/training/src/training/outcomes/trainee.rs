//! `/trainees/{id}/outcomes`: evidence and decisions for a trainee.

use std::collections::{BTreeMap, BTreeSet};

use acts::error::Error;
use acts::training::outcomes::{self as deeds, Decision};
use axum::extract::State;
use model::ids::{OutcomeId, PersonId, SessionId};
use model::training::progress::Progress;
use model::{CurrentPerson, PersonKey};
use pages::training::outcomes::{CourseEvidence, DecisionRow, OutcomeView, TraineeOutcomesPage, name_levels};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::scoring::supervisions;
use store::training::outcomes::{Entrustment, Outcome};
use store::training::{outcomes, practice, reports};

use crate::training::standing;

pub(super) async fn show_trainee_outcomes(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<TraineeOutcomesPage, PageError> {
    Ok(make_page(&state, Visit::new(&person, &csrf), id).await?)
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    id: PersonId,
) -> Result<TraineeOutcomesPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let trainee = reports::trainee(reader, person, id).await?.ok_or(Error::NotFound)?;
    let own = trainee.id == person.id;
    let whom = PersonKey { school_id: school, person_id: id };
    let decisions = outcomes::list_entrustments(reader, whom).await?;
    let evidence = evidence_by_course(state, whom).await?;
    let courses = outcomes::list_outcome_courses(reader, school).await?;
    let view = |outcome: Outcome| OutcomeView {
        decide_href: format!("/trainees/{id}/outcomes/{}", outcome.id),
        evidence: courses
            .iter()
            .filter(|course| course.outcome_id == outcome.id)
            .filter_map(|course| evidence.get(&course.curriculum_id).cloned())
            .collect(),
        decisions: list_decisions(&decisions, outcome.id),
        code: outcome.code,
        title: outcome.title,
        description: outcome.description,
    };
    Ok(TraineeOutcomesPage {
        shell: Shell::new(person, csrf.token(), if own { NavPlace::Home } else { NavPlace::Cohorts }),
        name: trainee.name,
        href: if own { "/".to_owned() } else { format!("/trainees/{id}") },
        own,
        outcomes: list_shown(state, person, &decisions).await?.into_iter().map(view).collect(),
        levels: name_levels(outcomes::list_levels(reader, school).await?),
        may_decide: deeds::may_decide(person, id),
        refused: None,
    })
}

/// Returns the outcomes to which a course leads, and those of which a level was decided.
async fn list_shown(
    state: &AppState,
    person: &CurrentPerson,
    decisions: &[Entrustment],
) -> Result<Vec<Outcome>, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let taught = outcomes::list_taught_outcomes(reader, school).await?;
    if decisions.iter().all(|decision| taught.iter().any(|outcome| outcome.id == decision.outcome_id)) {
        return Ok(taught);
    }
    let known: BTreeSet<OutcomeId> =
        taught.iter().map(|outcome| outcome.id).chain(decisions.iter().map(|decision| decision.outcome_id)).collect();
    Ok(outcomes::list_outcomes(reader, school)
        .await?
        .into_iter()
        .filter(|outcome| known.contains(&outcome.id))
        .collect())
}

/// Returns the decisions on an outcome, newest first.
fn list_decisions(decisions: &[Entrustment], outcome: OutcomeId) -> Vec<DecisionRow> {
    let of_outcome = decisions.iter().rev().filter(|decision| decision.outcome_id == outcome);
    let row = |decision: &Entrustment| DecisionRow {
        level: decision.level,
        note: decision.note.clone(),
        by: decision.decided_by.clone(),
        at: decision.decided_at.to_utc(),
    };
    of_outcome.map(row).collect()
}

/// Returns a trainee's work in each course of the school, by its id.
async fn evidence_by_course(state: &AppState, whom: PersonKey) -> Result<BTreeMap<String, CourseEvidence>, Error> {
    let reader = state.db.reader();
    let courses = standing::taught_courses(state, whom.school_id).await?;
    let attempts = practice::list_trainee_practice(reader, whom.school_id, whom.person_id).await?;
    let supervised = supervisions::list_trainee_supervisions(reader, whom.school_id, whom.person_id).await?;
    let supervised: BTreeSet<SessionId> = supervised.into_iter().collect();
    let ratings = outcomes::count_ratings(reader, whom).await?;
    let evidence = |taught: &standing::TaughtCourse| {
        let progress = Progress::of(&taught.course, &attempts);
        let attempts = progress.steps.iter().flat_map(|step| &step.attempts);
        let is_of_course = |exercise: &str| taught.course.steps.iter().any(|step| step.exercise == exercise);
        CourseEvidence {
            supervised: attempts.filter(|attempt| supervised.contains(&attempt.session)).count(),
            ratings: ratings.iter().filter(|rated| is_of_course(&rated.exercise_id)).map(|rated| rated.ratings).sum(),
            ..CourseEvidence::new(&taught.title, &progress)
        }
    };
    Ok(courses.iter().map(|taught| (taught.id.clone(), evidence(taught))).collect())
}

/// The form of a decision. Level 0 ends the entrustment.
#[derive(Debug, Deserialize)]
pub(super) struct DecisionForm {
    level: String,
    #[serde(default)]
    note: String,
}

pub(super) async fn entrust_level(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId((id, outcome_id)): PathId<(PersonId, OutcomeId)>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<DecisionForm>,
) -> Result<FormAnswer<TraineeOutcomesPage>, PageError> {
    let whom = PersonKey { school_id: person.school_id, person_id: id };
    let decided = match form.level.parse::<i64>() {
        Ok(level) => {
            let note = form.note.replace("\r\n", "\n");
            let decision = Decision { outcome_id, level: (level != 0).then_some(level), note: &note };
            split_refusal(deeds::entrust_level(&state, &person, whom, decision).await)?
        }
        Err(_) => Err(tr!("choose a level").to_owned()),
    };
    match decided {
        Ok(()) => Ok(FormAnswer::lead_to(&format!("/trainees/{id}/outcomes"))),
        Err(why) => {
            let page = make_page(&state, Visit::new(&person, &csrf), id).await?;
            Ok(FormAnswer::Refused(TraineeOutcomesPage { refused: Some(why), ..page }))
        }
    }
}
