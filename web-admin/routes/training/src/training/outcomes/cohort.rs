//! `/cohorts/{id}/outcomes`: the levels of a cohort's trainees.

use std::collections::BTreeMap;

use acts::error::Error;
use axum::extract::{Query, State};
use model::ids::{CohortId, OutcomeId, PersonId, SchoolId};
use model::{Moment, count_i64};
use pages::form::SelectOption;
use pages::people::listed::{ListPart, ListQuery};
use pages::training::outcomes::{
    CohortOutcomeColumn, CohortOutcomesPage, CohortOutcomesRow, DayCount, LevelCell, name_levels,
};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::training::outcomes::{Entrustment, Outcome};
use store::training::reports::NamedItem;
use store::training::{outcomes, reports};

use crate::training::{cohorts, standing};

/// Interval between the days at which trainees are counted, in s: two months.
const INTERVAL_S: i64 = 61 * 24 * 3600;
/// Number of days at which trainees are counted.
const DAYS: i64 = 6;

/// Part of the list and counted level.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct OutcomesQuery {
    q: String,
    page: Option<u32>,
    level: Option<usize>,
}

/// Number of mastered exercises, and of all, by outcome and trainee.
type Evidence = BTreeMap<(OutcomeId, PersonId), (usize, usize)>;

pub(super) async fn show_cohort_outcomes(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    Query(query): Query<OutcomesQuery>,
    csrf: Csrf,
) -> Result<CohortOutcomesPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, &person, id).await.map_err(Error::from)?.ok_or(Error::NotFound)?;
    let taught = outcomes::list_taught_outcomes(reader, school).await.map_err(Error::from)?;
    let decisions = outcomes::list_cohort_entrustments(reader, school, id).await.map_err(Error::from)?;
    let levels = name_levels(outcomes::list_levels(reader, school).await.map_err(Error::from)?);
    // By default the level below the highest: acting without supervision on the usual scale.
    let chosen = query.level.unwrap_or(levels.len().saturating_sub(1)).clamp(1, levels.len());
    let least = count_i64(chosen);
    let (trainees, evidence) = read_evidence(&state, cohort.clone(), &taught, school).await?;
    let days: Vec<Moment> = (0..DAYS).rev().map(|n| state.clock.now().plus_s(-n * INTERVAL_S)).collect();
    let all = trainees.len();
    let kept = vec![("level", chosen.to_string())];
    let (part, list) = ListPart::of(ListQuery { q: query.q, page: query.page, kept }, trainees, |one| &one.name);
    // Decisions are in order of time, so that the last of each trainee and outcome stays.
    let last: BTreeMap<(OutcomeId, PersonId), &Entrustment> =
        decisions.iter().map(|decision| ((decision.outcome_id, decision.person_id), decision)).collect();
    let cell_of = |key| cell(last.get(&key).copied(), evidence.get(&key));
    let row = |trainee: NamedItem<PersonId>| CohortOutcomesRow {
        href: format!("/trainees/{}/outcomes", trainee.id),
        cells: taught.iter().map(|outcome| cell_of((outcome.id, trainee.id))).collect(),
        name: trainee.name,
    };
    let option = |(at, name): (usize, &String)| SelectOption {
        value: (at + 1).to_string(),
        label: format!("{} – {name}", at + 1),
        chosen: at + 1 == chosen,
    };
    Ok(CohortOutcomesPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        href: cohorts::cohort_href(&cohort),
        name: cohort.name,
        columns: taught.iter().map(|outcome| column(outcome, &decisions, &days, least)).collect(),
        rows: part.into_iter().map(row).collect(),
        list,
        level_options: levels.iter().enumerate().map(option).collect(),
        levels,
        trainees: all,
    })
}

/// Returns the trainees of a cohort by name, and their mastered exercises by outcome.
async fn read_evidence(
    state: &AppState,
    cohort: NamedItem<CohortId>,
    taught: &[Outcome],
    school: SchoolId,
) -> Result<(Vec<NamedItem<PersonId>>, Evidence), Error> {
    let courses = standing::taught_courses(state, school).await?;
    let leading = outcomes::list_outcome_courses(state.db.reader(), school).await?;
    let practised = standing::practice_of_cohort(state, school, cohort).await?;
    let judged = standing::judged_courses(&courses);
    let standing = practised.standing(&judged, state.clock.now());
    let mut evidence = Evidence::new();
    for pair in leading.iter().filter(|pair| taught.iter().any(|outcome| outcome.id == pair.outcome_id)) {
        let Some(course) = courses.iter().position(|course| course.id == pair.curriculum_id) else { continue };
        for (trainee, (_, progress)) in standing.trainees().zip(standing.in_course(course)) {
            let (mastered, exercises) = evidence.entry((pair.outcome_id, trainee.id)).or_default();
            *mastered += progress.mastered();
            *exercises += progress.steps.len();
        }
    }
    Ok((standing.trainees().cloned().collect(), evidence))
}

/// Returns level and evidence of an outcome for a trainee.
fn cell(last: Option<&Entrustment>, evidence: Option<&(usize, usize)>) -> LevelCell {
    let (mastered, exercises) = evidence.copied().unwrap_or_default();
    let level = last.and_then(|decision| Some((decision.level?, decision.decided_at.to_utc())));
    LevelCell { level, mastered, exercises }
}

/// Returns an outcome with the number of trainees at a level or above on each day.
fn column(outcome: &Outcome, decisions: &[Entrustment], days: &[Moment], least: i64) -> CohortOutcomeColumn {
    let of_outcome = || decisions.iter().filter(|decision| decision.outcome_id == outcome.id);
    let count = |day: &Moment| {
        let until = of_outcome().take_while(|decision| decision.decided_at <= *day);
        // Decisions are in order of time, so that the last of each person stays.
        let levels: BTreeMap<PersonId, Option<i64>> =
            until.map(|decision| (decision.person_id, decision.level)).collect();
        let trainees = levels.values().filter(|level| level.is_some_and(|level| level >= least)).count();
        DayCount { day: day.to_utc(), trainees }
    };
    CohortOutcomeColumn {
        code: outcome.code.clone(),
        title: outcome.title.clone(),
        counts: days.iter().map(count).collect(),
    }
}
