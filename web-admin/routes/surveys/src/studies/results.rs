//! `/studies/{id}/results`: the results of a study.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::surveys::instrument_of;
use axum::extract::{Query, State};
use documents::Instrument;
use model::ids::{PersonId, StudyId};
use model::studies::{StudyFindings, StudyGroups, StudyMetric, StudyValue};
use model::surveys::Survey;
use model::surveys::results::{ResponseRow, Results};
use pages::metric::label_of;
use pages::studies::results::{StudyResultsPage, StudySurveyBlock};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Teacher};
use routes_base::error::PageError;
use serde::Deserialize;
use store::scoring::scores;
use store::scoring::scores::MetricOfMany;
use store::studies::{self, Study, StudyAttempt, StudyExercise, StudyParticipant};
use store::surveys::{self, SubmittedResponse};

use super::find_own_study;
use crate::surveys::results::rows_of_responses;

/// Role under which answers of the last group are analysed as those of experts.
const EXPERT: &str = "expert";

/// All data of a study from its current participants.
pub(super) struct GatheredStudy {
    pub study: Study,
    pub exercises: Vec<StudyExercise>,
    pub participants: Vec<StudyParticipant>,
    /// Attempts that count, person by person.
    pub attempts: Vec<StudyAttempt>,
    /// The newest version of each metric.
    pub metrics: Vec<MetricOfMany>,
    pub answered: Vec<AnsweredSurvey>,
}

/// A survey of the study, with its submitted responses.
pub(super) struct AnsweredSurvey {
    pub survey: Survey,
    pub instrument: Instrument,
    pub submitted: Vec<SubmittedResponse>,
}

impl GatheredStudy {
    pub async fn read(state: &AppState, study: Study) -> Result<Self, Error> {
        let reader = state.db.reader();
        let exercises = studies::list_study_exercises(reader, &study).await?;
        let mut participants = studies::list_participants(reader, &study).await?;
        participants.retain(|participant| participant.agreed_at.is_some() && participant.withdrawn_at.is_none());
        let attempts = studies::list_study_attempts(reader, &study).await?;
        let sessions: Vec<_> = attempts.iter().map(|attempt| attempt.session_id).collect();
        let mut metrics = scores::metrics_of_many(reader, study.school_id, &sessions).await?;
        // Sorted by id and version: the last one of an id is the newest.
        metrics.reverse();
        let mut seen = Vec::new();
        metrics.retain(|metric| {
            !seen.contains(&metric.id) && {
                seen.push(metric.id.clone());
                true
            }
        });
        metrics.reverse();
        let mut answered = Vec::new();
        for survey in studies::list_study_surveys(reader, &study).await? {
            let instrument = instrument_of(state, &survey).await?;
            let submitted = surveys::submitted(reader, &survey).await?;
            answered.push(AnsweredSurvey { survey, instrument, submitted });
        }
        Ok(Self { study, exercises, participants, attempts, metrics, answered })
    }

    /// Returns the index of each participant.
    fn places(&self) -> BTreeMap<PersonId, usize> {
        self.participants.iter().enumerate().map(|(place, participant)| (participant.person_id, place)).collect()
    }

    /// Returns the findings for an exercise.
    pub fn findings(&self, exercise: &str) -> StudyFindings {
        let places = self.places();
        let of_participants: Vec<usize> = self.participants.iter().map(|found| found.group_place as usize).collect();
        let groups = StudyGroups { of_participants: &of_participants, count: self.study.groups.0.len() };
        let value = |attempt: &StudyAttempt, value: f64| {
            let participant = *places.get(&attempt.person_id).filter(|_| attempt.exercise_id == exercise)?;
            Some(StudyValue { participant, number: attempt.number as usize, value })
        };
        let score = StudyMetric {
            id: "score".to_owned(),
            label: tr!("Score").to_owned(),
            unit: String::new(),
            values: self.attempts.iter().filter_map(|attempt| value(attempt, attempt.score)).collect(),
        };
        let metric = |metric: &MetricOfMany| StudyMetric {
            id: metric.id.clone(),
            label: label_of(&metric.id, &metric.label),
            unit: metric.unit.clone(),
            values: metric
                .found
                .0
                .iter()
                .filter_map(|found| value(self.attempts.get(found.0)?, found.value()?))
                .collect(),
        };
        let metrics: Vec<StudyMetric> = self.metrics.iter().map(metric).collect();
        StudyFindings::new(groups, self.study.attempts as usize, &score, &metrics)
    }

    /// Returns the results of a survey of the study, group by group; the last group is treated as
    /// the experts.
    pub fn survey_results(&self, answered: &AnsweredSurvey) -> Results {
        let mut roles = self.study.groups.0.clone();
        if let Some(last) = roles.last_mut() {
            EXPERT.clone_into(last);
        }
        let group = |given: &SubmittedResponse| {
            let known = self.participants.iter().find(|known| Some(&known.pseudonym) == given.pseudonym.as_ref())?;
            roles.get(known.group_place as usize)
        };
        let rows: Vec<ResponseRow<'_>> = rows_of_responses(&answered.instrument, &answered.submitted)
            .into_iter()
            .zip(&answered.submitted)
            .filter_map(|(row, given)| Some(ResponseRow { role: group(given)?, ..row }))
            .collect();
        Results::new(&answered.instrument, &rows.iter().collect::<Vec<_>>(), true)
    }
}

#[derive(Deserialize)]
pub(super) struct StudyResultsQuery {
    #[serde(default)]
    exercise: String,
}

pub(super) async fn show_results(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<StudyId>,
    csrf: Csrf,
    Query(query): Query<StudyResultsQuery>,
) -> Result<StudyResultsPage, PageError> {
    let gathered = GatheredStudy::read(&state, find_own_study(&state, &person, id).await?).await?;
    let chosen = gathered.exercises.iter().find(|known| known.exercise_id == query.exercise);
    let chosen = chosen.or(gathered.exercises.first()).ok_or(Error::NotFound)?;
    let href = format!("/studies/{id}");
    let tab = |known: &StudyExercise| {
        (known.title.clone(), format!("{href}/results?exercise={}", known.exercise_id), known == chosen)
    };
    let taking_part = |place: usize| gathered.participants.iter().filter(|p| p.group_place as usize == place).count();
    let groups = gathered.study.groups.0.iter().enumerate();
    let block = |answered: &AnsweredSurvey| StudySurveyBlock {
        title: answered.survey.instrument.clone(),
        href: format!("/surveys/{}/results", answered.survey.id),
        at_end: answered.survey.at_end,
        results: gathered.survey_results(answered),
    };
    Ok(StudyResultsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Surveys),
        title: gathered.study.title.clone(),
        generated: gathered.study.generated,
        exercises: gathered.exercises.iter().map(tab).collect(),
        groups: groups.map(|(place, name)| (name.clone(), taking_part(place))).collect(),
        findings: gathered.findings(&chosen.exercise_id),
        surveys: gathered.answered.iter().map(block).collect(),
        href,
    })
}
