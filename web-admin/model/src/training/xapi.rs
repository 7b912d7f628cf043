//! Statements about attempts for a learning record store (xAPI 1.0.3 and 2.0.0).
//!
//! The same statement always has the same id (UUIDv5), so that a store that receives it twice keeps
//! it once. `docs/learning-records.md` describes the statements for other programs.

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
        let digest = Sha1::new().chain_update(school.uuid().as_bytes()).chain_update(name).finalize();
        let mut bytes = [0; 16];
        bytes.copy_from_slice(&digest[..16]);
        Builder::from_sha1_bytes(bytes).into_uuid()
    }
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
            context["registration"] = assignment.id.to_string().into();
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

#[cfg(test)]
mod tests {
    //! Checks the statements against the examples of the specification, section by section, and that
    //! the same subject has the same id. Another program judges random ones
    //! (`tests/counterparts/statements.mjs`).

    use super::*;

    const SCHOOL: SchoolId = SchoolId::from_u128(1);
    const PERSON: PersonId = PersonId::from_u128(2);

    fn actor() -> StatementActor {
        StatementActor { pseudonym: "brave-otter-17".to_owned(), name: None }
    }

    fn attempt() -> StatementAttempt {
        StatementAttempt {
            session: SessionId::from_u128(3),
            exercise_id: "epidural-l3".to_owned(),
            exercise_sha256: "ab".repeat(32),
            title: Some("Epidural at L3".to_owned()),
            started_at: Moment::from_micros(1_700_000_000_250_000),
            duration_s: 61.5,
            is_complete: true,
            assignment: None,
        }
    }

    fn grade() -> StatementGrade {
        let metrics = [(("peak_force_n".to_owned(), 2), 4.25)];
        StatementGrade { score: 72.5, passed: true, metrics: metrics.into() }
    }

    fn maker(actor: &StatementActor) -> StatementMaker<'_> {
        StatementMaker { address: "https://training.example.edu", school: SCHOOL, actor }
    }

    #[test]
    fn a_judged_attempt_has_score_duration_and_metrics() {
        let actor = actor();
        let statement = maker(&actor).judge(&attempt(), ScoreId::from_u128(4), &grade());
        assert_eq!(
            statement["result"],
            json!({
                "score": { "scaled": 0.725, "raw": 72.5, "min": 0, "max": 100 },
                "success": true,
                "completion": true,
                "duration": "PT61.50S",
                "extensions": { "https://training.example.edu/metrics/peak_force_n/2": 4.25 },
            })
        );
        assert_eq!(statement["verb"]["id"], "http://adlnet.gov/expapi/verbs/passed");
        assert_eq!(statement["timestamp"], "2023-11-14T22:14:21.75Z", "the end of the attempt");
        let account = json!({ "homePage": "https://training.example.edu", "name": "brave-otter-17" });
        assert_eq!(statement["actor"], json!({ "objectType": "Agent", "account": account }));
        assert!(statement["context"].get("registration").is_none(), "an attempt without an assignment");
    }

    #[test]
    fn an_assignment_is_the_context() {
        let actor = actor();
        let course = StatementCourse { id: "spine".to_owned(), sha256: "cd".repeat(32), title: "Spine".to_owned() };
        let id = AssignmentId::from_u128(5);
        let assignment = StatementAssignment { id, cohort: Some(CohortId::from_u128(6)), course: Some(course) };
        let statement = maker(&actor).begin(&StatementAttempt { assignment: Some(assignment), ..attempt() });
        let context = &statement["context"];
        assert_eq!(context["registration"], id.to_string());
        let parent = &context["contextActivities"]["parent"][0];
        assert_eq!(parent["id"], format!("https://training.example.edu/curricula/spine/revisions/{}", "cd".repeat(32)));
        let cohort = &context["contextActivities"]["grouping"][0]["id"];
        assert_eq!(cohort, &format!("https://training.example.edu/cohorts/{}", CohortId::from_u128(6)));
    }

    #[test]
    fn a_change_refers_to_the_first_score() {
        let (actor, first) = (actor(), ScoreId::from_u128(4));
        let change = GradeChange {
            subject: StatementSubject::Override(OverrideId::from_u128(7)),
            first,
            grade: &grade(),
            at: Moment::from_micros(1_700_000_100_000_000),
        };
        let statement = maker(&actor).score_again(&attempt(), change);
        let id = maker(&actor).judge(&attempt(), first, &grade())["id"].clone();
        assert_eq!(statement["context"]["statement"], json!({ "objectType": "StatementRef", "id": id }));
        let voided = maker(&actor).void(OverrideId::from_u128(8), OverrideId::from_u128(7), change.at);
        assert_eq!(voided["object"], json!({ "objectType": "StatementRef", "id": statement["id"] }));
        assert!(voided.get("context").is_none(), "platform is not allowed beside a reference (xAPI 1.0.3, 2.4.6)");
    }

    #[test]
    fn the_same_subject_has_the_same_id() {
        let course = "cd".repeat(32);
        let subjects = [
            StatementSubject::Start(SessionId::from_u128(3)),
            StatementSubject::End(SessionId::from_u128(3)),
            StatementSubject::Score(ScoreId::from_u128(3)),
            StatementSubject::Override(OverrideId::from_u128(3)),
            StatementSubject::Mastery(PERSON, &course),
        ];
        let mut ids: Vec<Uuid> = subjects.map(|subject| subject.statement_id(SCHOOL)).to_vec();
        assert_eq!(ids, subjects.map(|subject| subject.statement_id(SCHOOL)));
        // As `uuid.uuid5` of Python computes it.
        assert_eq!(ids[0].to_string(), "dd1b1087-348d-5707-b244-c068e70636e4");
        ids.push(subjects[0].statement_id(SchoolId::from_u128(9)));
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), subjects.len() + 1, "subjects with one id");
    }

    /// Random numbers that are the same every time (SplitMix64).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> u64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            mixed ^ (mixed >> 31)
        }

        fn id(&mut self) -> u128 {
            u128::from(self.next()) << 64 | u128::from(self.next())
        }

        fn fraction(&mut self) -> f64 {
            (self.next() >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn text(&mut self) -> String {
            const KNOWN: [&str; 8] = ["Needle ", "“quoted”\n", "Größe", "\u{2028}", "<b>", "\\", "🩺", "0"];
            (0..1 + self.next() % 5).map(|_| KNOWN[(self.next() % 8) as usize]).collect()
        }

        fn course(&mut self) -> StatementCourse {
            StatementCourse { id: "spine".to_owned(), sha256: format!("{:064x}", self.next()), title: self.text() }
        }

        fn attempt(&mut self) -> StatementAttempt {
            let assignment = self.next().is_multiple_of(2).then(|| StatementAssignment {
                id: AssignmentId::from_u128(self.id()),
                cohort: self.next().is_multiple_of(2).then(|| CohortId::from_u128(self.id())),
                course: self.next().is_multiple_of(2).then(|| self.course()),
            });
            StatementAttempt {
                session: SessionId::from_u128(self.id()),
                exercise_id: "epidural-l3".to_owned(),
                exercise_sha256: format!("{:064x}", self.next()),
                title: (!self.next().is_multiple_of(4)).then(|| self.text()),
                started_at: Moment::from_micros((self.next() % 4_000_000_000_000_000) as i64),
                duration_s: self.fraction() * 4000.0,
                is_complete: self.next().is_multiple_of(2),
                assignment,
            }
        }

        fn grade(&mut self) -> StatementGrade {
            let metrics =
                (0..self.next() % 5).map(|n| ((SENT_METRICS[n as usize % 4].to_owned(), 1), self.fraction() * 80.0));
            let metrics = metrics.collect();
            StatementGrade { score: self.fraction() * 100.0, passed: self.next().is_multiple_of(2), metrics }
        }

        /// One statement of each kind.
        fn statements(&mut self) -> [Value; 6] {
            let name = self.next().is_multiple_of(2).then(|| self.text());
            let actor = StatementActor { pseudonym: format!("p-{:012x}", self.next() >> 16), name };
            let maker = maker(&actor);
            let (attempt, grade, at) = (self.attempt(), self.grade(), Moment::from_micros(1_700_000_100_000_000));
            let (first, change, withdrawal) = (ScoreId::from_u128(self.id()), self.id(), self.id());
            let change = OverrideId::from_u128(change);
            let subject = StatementSubject::Override(change);
            [
                maker.begin(&attempt),
                maker.end(&attempt),
                maker.judge(&attempt, first, &grade),
                maker.score_again(&attempt, GradeChange { subject, first, grade: &grade, at }),
                maker.void(OverrideId::from_u128(withdrawal), change, at),
                maker.master(PersonId::from_u128(self.id()), &self.course(), at),
            ]
        }
    }

    /// Writes statements for other programs, if they ask for them: `tests/counterparts/records.py`.
    #[test]
    fn statements_have_their_required_properties() {
        let kept = std::env::var_os("STYLET_KEEP_STATEMENTS");
        let mut numbers = Numbers(1);
        let rounds = if kept.is_some() { 1667 } else { 50 };
        let statements: Vec<Value> = (0..rounds).flat_map(|_| numbers.statements()).collect();
        for statement in &statements {
            for property in ["id", "actor", "verb", "object", "timestamp"] {
                assert!(statement.get(property).is_some(), "{property}: {statement}");
            }
        }
        let Some(file) = kept else { return };
        let lines: String = statements.iter().map(|statement| format!("{statement}\n")).collect();
        std::fs::write(file, lines).expect("a file");
    }
}
