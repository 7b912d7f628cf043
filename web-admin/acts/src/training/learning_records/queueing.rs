//! Makes statements when a grade changes, in the same transaction.

use std::collections::BTreeMap;

use model::ids::{OverrideId, ScoreId};
use model::training::assignment::AssignmentTask;
use model::training::progress::{Course, Progress};
use model::training::xapi::{
    GradeChange, SENT_METRICS, StatementActor, StatementAssignment, StatementAttempt, StatementCourse, StatementGrade,
    StatementMaker, StatementSubject,
};
use model::{Moment, PersonKey, SessionKey};
use store::Connection;
use store::scoring::{grades, scores};
use store::training::curricula::TaughtCurriculum;
use store::training::learning_records::{AttemptFacts, RecordStore};
use store::training::{assignments, learning_records, practice};

use super::super::assignments as teaching;
use crate::error::Error;
use crate::service::Service;

/// What has changed the grade of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GradeSource {
    /// A computed score.
    Score(ScoreId),
    /// An override.
    Override(OverrideId),
    /// The withdrawal of an override.
    Withdrawal(OverrideId),
}

/// Queues the statements about a changed grade, if the school uses a learning record store and may
/// send them.
///
/// # Errors
/// Fails if the database fails.
pub async fn queue_statements(
    service: &Service,
    tx: &mut Connection,
    session: SessionKey,
    source: GradeSource,
    now: Moment,
) -> Result<(), Error> {
    let Some(store) = learning_records::find_record_store(&mut *tx, session.school_id).await? else { return Ok(()) };
    let facts = learning_records::find_attempt_facts(&mut *tx, session).await?;
    if !facts.counts || !learning_records::may_send(&mut *tx, &store, facts.trainee_id).await? {
        return Ok(());
    }
    let taught = match source {
        // A statement is voided without its courses.
        GradeSource::Withdrawal(_) => Vec::new(),
        _ => teaching::taught_curricula(service, session.school_id).await?,
    };
    let changed = ChangedGrade { service, store: &store, facts: &facts, taught: &taught, session, now };
    changed.queue(tx, source).await
}

/// A changed grade, with what its statements need.
#[derive(Clone, Copy)]
struct ChangedGrade<'a> {
    service: &'a Service,
    store: &'a RecordStore,
    facts: &'a AttemptFacts,
    taught: &'a [(TaughtCurriculum, Course)],
    session: SessionKey,
    now: Moment,
}

impl ChangedGrade<'_> {
    async fn queue(&self, tx: &mut Connection, source: GradeSource) -> Result<(), Error> {
        let (school, now) = (self.session.school_id, self.now);
        let Some(first) = learning_records::find_first_score(&mut *tx, self.session).await? else { return Ok(()) };
        let address = self.service.config.address();
        let actor = StatementActor {
            pseudonym: self.facts.pseudonym.clone(),
            name: Some(self.facts.display_name.clone()).filter(|_| self.store.settings.names),
        };
        let maker = StatementMaker { address: &address, school, actor: &actor };
        let attempt = self.describe_attempt(tx).await?;
        let grade = self.read_grade(tx, source).await?;
        if source == GradeSource::Score(first) {
            let statements = [maker.begin(&attempt), maker.end(&attempt), maker.judge(&attempt, first, &grade)];
            for statement in statements {
                self.add(tx, &statement).await?;
            }
            return self.queue_mastery(tx, &maker).await;
        }
        // The store has never heard of attempts from before the consent.
        if !self.is_queued(tx, StatementSubject::Score(first)).await? {
            return Ok(());
        }
        let subject = match source {
            GradeSource::Score(score) => StatementSubject::Score(score),
            GradeSource::Override(change) => StatementSubject::Override(change),
            GradeSource::Withdrawal(change) => return self.queue_voiding(tx, &maker, change).await,
        };
        self.add(tx, &maker.score_again(&attempt, GradeChange { subject, first, grade: &grade, at: now })).await?;
        self.queue_mastery(tx, &maker).await
    }

    /// Voids the statement about the override that was withdrawn.
    async fn queue_voiding(
        &self,
        tx: &mut Connection,
        maker: &StatementMaker<'_>,
        withdrawal: OverrideId,
    ) -> Result<(), Error> {
        let before = learning_records::find_override_before(&mut *tx, self.session, withdrawal).await?;
        if let Some(before) = before
            && self.is_queued(tx, StatementSubject::Override(before)).await?
        {
            self.add(tx, &maker.void(withdrawal, before, self.now)).await?;
        }
        Ok(())
    }

    /// Says that the trainee has mastered the courses of the exercise, once for each.
    async fn queue_mastery(&self, tx: &mut Connection, maker: &StatementMaker<'_>) -> Result<(), Error> {
        let (school, trainee) = (self.session.school_id, self.facts.trainee_id);
        let attempts = practice::list_trainee_practice(&mut *tx, school, trainee).await?;
        for (curriculum, course) in self.taught {
            let is_part = course.steps.iter().any(|step| step.exercise == self.facts.exercise_id);
            if is_part && Progress::of(course, &attempts).complete() {
                let statement = maker.master(trainee, &describe_course(curriculum), self.now);
                self.add(tx, &statement).await?;
            }
        }
        Ok(())
    }

    async fn describe_attempt(&self, tx: &mut Connection) -> Result<StatementAttempt, Error> {
        let facts = self.facts;
        Ok(StatementAttempt {
            session: self.session.id,
            exercise_id: facts.exercise_id.clone(),
            exercise_sha256: facts.exercise_sha256.clone(),
            title: facts.title.clone(),
            started_at: facts.started_at,
            duration_s: facts.duration_s,
            is_complete: facts.complete,
            assignment: self.find_assignment(tx).await?,
        })
    }

    /// Returns the newest assignment that asks for the exercise, rather one of the exercise itself
    /// than one of a course.
    async fn find_assignment(&self, tx: &mut Connection) -> Result<Option<StatementAssignment>, Error> {
        let (school, trainee) = (self.session.school_id, self.facts.trainee_id);
        let assigned = assignments::list_trainee_assignments(&mut *tx, school, trainee).await?;
        let course_of = |id: &str| {
            self.taught.iter().find(|(curriculum, course)| {
                curriculum.curriculum_id == id && course.steps.iter().any(|s| s.exercise == self.facts.exercise_id)
            })
        };
        let asks = |task: &AssignmentTask| match task {
            AssignmentTask::Exercise(id) => *id == self.facts.exercise_id,
            AssignmentTask::Course(id) => course_of(id).is_some(),
        };
        let of_course = |task: &AssignmentTask| matches!(task, AssignmentTask::Course(_));
        let newest =
            assigned.into_iter().filter(|one| asks(&one.task)).max_by_key(|one| (!of_course(&one.task), one.made_at));
        let Some(newest) = newest else { return Ok(None) };
        let course = match &newest.task {
            AssignmentTask::Course(id) => course_of(id).map(|(curriculum, _)| describe_course(curriculum)),
            AssignmentTask::Exercise(_) => None,
        };
        let cohort = assignments::find_cohort(&mut *tx, school, newest.id).await?;
        Ok(Some(StatementAssignment { id: newest.id, cohort, course }))
    }

    /// Returns the override, or the computed score even if an override counts in its place.
    async fn read_grade(&self, tx: &mut Connection, source: GradeSource) -> Result<StatementGrade, Error> {
        let (score, passed) = match source {
            GradeSource::Score(_) => {
                let newest = scores::find_newest_score(&mut *tx, self.session).await?.ok_or(Error::NotFound)?;
                (newest.score, newest.passed)
            }
            GradeSource::Override(_) | GradeSource::Withdrawal(_) => {
                let grade = grades::find_grade(&mut *tx, self.session).await?.ok_or(Error::NotFound)?;
                (grade.score, grade.passed)
            }
        };
        let metrics = scores::list_score_metrics(&mut *tx, self.session).await?;
        let sent: BTreeMap<(String, u32), f64> = metrics
            .into_iter()
            .filter(|metric| SENT_METRICS.contains(&metric.id.as_str()))
            .filter_map(|metric| Some(((metric.id, metric.version), metric.value?)))
            .collect();
        Ok(StatementGrade { score, passed, metrics: sent })
    }

    async fn is_queued(&self, tx: &mut Connection, subject: StatementSubject<'_>) -> Result<bool, Error> {
        let id = subject.statement_id(self.session.school_id);
        Ok(learning_records::is_queued(&mut *tx, self.store.id, id).await?)
    }

    async fn add(&self, tx: &mut Connection, statement: &serde_json::Value) -> Result<(), Error> {
        let person = PersonKey { school_id: self.session.school_id, person_id: self.facts.trainee_id };
        Ok(learning_records::add_statement(tx, self.store.id, person, statement, self.now).await?)
    }
}

fn describe_course(curriculum: &TaughtCurriculum) -> StatementCourse {
    StatementCourse {
        id: curriculum.curriculum_id.clone(),
        sha256: curriculum.sha256.clone(),
        title: curriculum.title.clone(),
    }
}
