//! Statements about attempts for a learning record store (xAPI 1.0.3 and 2.0.0).
//!
//! The same statement always has the same id (UUIDv5), so that a store that receives it twice keeps
//! it once. `docs/learning-records.md` describes the statements for other programs.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde_json::{Value, json};
use sha1::{Digest, Sha1};
use uuid::{Builder, Uuid};

use crate::Moment;
use crate::ids::{AssignmentId, CohortId, OverrideId, PersonId, SchoolId, ScoreId, SessionId};

/// Metrics that a statement contains: depth, force, and damage of the tissue.
pub const SENT_METRICS: [&str; 4] = ["depth_error_mm", "peak_force_n", "cutting_energy_mj", "rupture_energy_mj"];
/// Language tag of titles: their language is not known (ISO 639-2).
const UNKNOWN_LANGUAGE: &str = "und";

/// What a statement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatementSubject<'a> {
    /// The start of an attempt.
    Start(SessionId),
    /// The end of an attempt.
    End(SessionId),
    /// A computed score of an attempt.
    Score(ScoreId),
    /// An override of the computed score, or its withdrawal.
    Override(OverrideId),
    /// The mastery of a course by a person; with the SHA-256 of its document.
    Mastery(PersonId, &'a str),
}

impl StatementSubject<'_> {
    /// Returns the id of the statement.
    #[must_use]
    pub fn statement_id(self, school: SchoolId) -> Uuid {
        let name = match self {
            Self::Start(session) => format!("start/{session}"),
            Self::End(session) => format!("end/{session}"),
            Self::Score(score) => format!("score/{score}"),
            Self::Override(change) => format!("override/{change}"),
            Self::Mastery(person, course) => format!("mastery/{person}/{course}"),
        };
        make_named_uuid(school, &name)
    }
}

/// Returns the UUIDv5 of a name in a school. Stores accept no UUIDv7, which other ids are.
fn make_named_uuid(school: SchoolId, name: &str) -> Uuid {
    let digest = Sha1::new().chain_update(school.uuid().as_bytes()).chain_update(name).finalize();
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&digest[..16]);
    Builder::from_sha1_bytes(bytes).into_uuid()
}

/// What a statement says of its subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verb {
    Initialized,
    Completed,
    Passed,
    Failed,
    Scored,
    Mastered,
    Voided,
}

impl Verb {
    const fn word(self) -> &'static str {
        match self {
            Self::Initialized => "initialized",
            Self::Completed => "completed",
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Scored => "scored",
            Self::Mastered => "mastered",
            Self::Voided => "voided",
        }
    }

    fn to_json(self) -> Value {
        let word = self.word();
        json!({ "id": format!("http://adlnet.gov/expapi/verbs/{word}"), "display": { "en": word } })
    }
}

/// The person of a statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatementActor {
    /// Pseudonym, which is the name of the account.
    pub pseudonym: String,
    /// Name; `None` unless the school sends names.
    pub name: Option<String>,
}

/// A course, as an activity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatementCourse {
    /// Id of the course.
    pub id: String,
    /// SHA-256 of its document.
    pub sha256: String,
    /// Title.
    pub title: String,
}

/// The assignment to which an attempt belongs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StatementAssignment {
    /// Id.
    pub id: AssignmentId,
    /// Cohort of the assignment; `None` for an individual one.
    pub cohort: Option<CohortId>,
    /// The assigned course; `None` if an exercise is assigned.
    pub course: Option<StatementCourse>,
}

/// An attempt, as statements describe it.
#[derive(Clone, Debug, PartialEq)]
pub struct StatementAttempt {
    /// Session.
    pub session: SessionId,
    /// Id of the exercise.
    pub exercise_id: String,
    /// SHA-256 of the exercise.
    pub exercise_sha256: String,
    /// Title of the exercise, if the school has published it.
    pub title: Option<String>,
    /// Start time.
    pub started_at: Moment,
    /// Length of the recording, in s.
    pub duration_s: f64,
    /// Whether the recording was finished.
    pub is_complete: bool,
    /// The assignment.
    pub assignment: Option<StatementAssignment>,
}

/// A score of an attempt.
#[derive(Clone, Debug, PartialEq)]
pub struct StatementGrade {
    /// Score, 0–100.
    pub score: f64,
    /// Passed.
    pub passed: bool,
    /// Values of metrics, by id and version.
    pub metrics: BTreeMap<(String, u32), f64>,
}

/// Makes the statements of a school about a person.
#[derive(Clone, Copy, Debug)]
pub struct StatementMaker<'a> {
    /// Public address of the service, the start of the ids of its activities.
    pub address: &'a str,
    /// School.
    pub school: SchoolId,
    /// The person.
    pub actor: &'a StatementActor,
}

impl StatementMaker<'_> {
    /// Says that an attempt began.
    #[must_use]
    pub fn begin(&self, attempt: &StatementAttempt) -> Value {
        let mut statement = self.about(StatementSubject::Start(attempt.session), Verb::Initialized, attempt.started_at);
        self.describe(&mut statement, attempt);
        statement
    }

    /// Says that an attempt ended.
    #[must_use]
    pub fn end(&self, attempt: &StatementAttempt) -> Value {
        let at = end_of(attempt);
        let mut statement = self.about(StatementSubject::End(attempt.session), Verb::Completed, at);
        self.describe(&mut statement, attempt);
        statement["result"] =
            json!({ "completion": attempt.is_complete, "duration": write_duration(attempt.duration_s) });
        statement
    }

    /// Says that an attempt was passed or failed, by its first score.
    #[must_use]
    pub fn judge(&self, attempt: &StatementAttempt, score: ScoreId, grade: &StatementGrade) -> Value {
        let verb = if grade.passed { Verb::Passed } else { Verb::Failed };
        let mut statement = self.about(StatementSubject::Score(score), verb, end_of(attempt));
        self.describe(&mut statement, attempt);
        statement["result"] = self.result(grade);
        statement["result"]["completion"] = attempt.is_complete.into();
        statement["result"]["duration"] = write_duration(attempt.duration_s).into();
        statement
    }

    /// Says that an attempt has another score than the first one.
    #[must_use]
    pub fn score_again(&self, attempt: &StatementAttempt, change: GradeChange<'_>) -> Value {
        let mut statement = self.about(change.subject, Verb::Scored, change.at);
        self.describe(&mut statement, attempt);
        statement["result"] = self.result(change.grade);
        let first = StatementSubject::Score(change.first).statement_id(self.school);
        statement["context"]["statement"] = refer_to(first);
        statement
    }

    /// Voids the statement about an override that was withdrawn.
    #[must_use]
    pub fn void(&self, withdrawal: OverrideId, voided: OverrideId, at: Moment) -> Value {
        let mut statement = self.about(StatementSubject::Override(withdrawal), Verb::Voided, at);
        statement["object"] = refer_to(StatementSubject::Override(voided).statement_id(self.school));
        statement
    }

    /// Says that the person has mastered a course.
    #[must_use]
    pub fn master(&self, person: PersonId, course: &StatementCourse, at: Moment) -> Value {
        let mut statement = self.about(StatementSubject::Mastery(person, &course.sha256), Verb::Mastered, at);
        statement["object"] = self.course(course);
        statement["context"] = json!({ "platform": "Stylet" });
        statement["result"] = json!({ "success": true, "completion": true });
        statement
    }

    fn about(&self, subject: StatementSubject<'_>, verb: Verb, at: Moment) -> Value {
        let StatementActor { pseudonym, name } = self.actor;
        let mut actor = json!({ "objectType": "Agent", "account": { "homePage": self.address, "name": pseudonym } });
        if let Some(name) = name {
            actor["name"] = name.as_str().into();
        }
        json!({
            "id": subject.statement_id(self.school),
            "actor": actor,
            "verb": verb.to_json(),
            "timestamp": at.to_string(),
        })
    }

    /// Adds the exercise and its context.
    fn describe(&self, statement: &mut Value, attempt: &StatementAttempt) {
        let StatementAttempt { exercise_id, exercise_sha256, title, assignment, .. } = attempt;
        let id = format!("{}/exercises/{exercise_id}/revisions/{exercise_sha256}", self.address);
        statement["object"] = activity(&id, "simulation", title.as_deref());
        let mut context = json!({ "platform": "Stylet" });
        if let Some(assignment) = assignment {
            context["registration"] = json!(make_named_uuid(self.school, &format!("assignment/{}", assignment.id)));
            let mut near = json!({});
            if let Some(course) = &assignment.course {
                near["parent"] = json!([self.course(course)]);
            }
            if let Some(cohort) = assignment.cohort {
                near["grouping"] =
                    json!([{ "objectType": "Activity", "id": format!("{}/cohorts/{cohort}", self.address) }]);
            }
            if near != json!({}) {
                context["contextActivities"] = near;
            }
        }
        statement["context"] = context;
    }

    fn course(&self, course: &StatementCourse) -> Value {
        let StatementCourse { id, sha256, title } = course;
        activity(&format!("{}/curricula/{id}/revisions/{sha256}", self.address), "course", Some(title))
    }

    fn result(&self, grade: &StatementGrade) -> Value {
        let mut result = json!({
            "score": { "scaled": grade.score / 100.0, "raw": grade.score, "min": 0, "max": 100 },
            "success": grade.passed,
        });
        if !grade.metrics.is_empty() {
            let key = |(id, version): &(String, u32)| format!("{}/metrics/{id}/{version}", self.address);
            result["extensions"] = grade.metrics.iter().map(|(metric, value)| (key(metric), json!(value))).collect();
        }
        result
    }
}

/// A score after the first one.
#[derive(Clone, Copy, Debug)]
pub struct GradeChange<'a> {
    /// The new score, or the override.
    pub subject: StatementSubject<'a>,
    /// The first score.
    pub first: ScoreId,
    /// The new grade.
    pub grade: &'a StatementGrade,
    /// Time of the change.
    pub at: Moment,
}

fn activity(id: &str, kind: &str, title: Option<&str>) -> Value {
    let mut definition = json!({ "type": format!("http://adlnet.gov/expapi/activities/{kind}") });
    if let Some(title) = title {
        definition["name"] = json!({ UNKNOWN_LANGUAGE: title });
    }
    json!({ "objectType": "Activity", "id": id, "definition": definition })
}

fn refer_to(statement: Uuid) -> Value {
    json!({ "objectType": "StatementRef", "id": statement })
}

fn end_of(attempt: &StatementAttempt) -> Moment {
    let length_us = (attempt.duration_s.max(0.0) * 1e6).round() as i64;
    Moment::from_micros(attempt.started_at.micros().saturating_add(length_us))
}

/// Returns a duration in s as ISO 8601, in hundredths of a second.
fn write_duration(seconds: f64) -> String {
    format!("PT{:.2}S", seconds.max(0.0))
}
