//! Checks the statements against the examples of the specification, section by section, and that
//! the same subject has the same id. Another program judges random ones
//! (`tests/counterparts/statements.mjs`).

use super::*;
use crate::training::random_numbers::RandomNumbers;

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
    // As `uuid.uuid5` of Python computes it.
    assert_eq!(context["registration"], "7b323fba-7398-59bf-8225-39693d982d41");
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

impl RandomNumbers {
    fn id(&mut self) -> u128 {
        u128::from(self.next()) << 64 | u128::from(self.next())
    }

    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn title(&mut self) -> String {
        const KNOWN: [&str; 8] = ["Needle ", "“quoted”\n", "Größe", "\u{2028}", "<b>", "\\", "🩺", "0"];
        (0..1 + self.next() % 5).map(|_| KNOWN[(self.next() % 8) as usize]).collect()
    }

    fn course(&mut self) -> StatementCourse {
        StatementCourse { id: "spine".to_owned(), sha256: format!("{:064x}", self.next()), title: self.title() }
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
            title: (!self.next().is_multiple_of(4)).then(|| self.title()),
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
        let name = self.next().is_multiple_of(2).then(|| self.title());
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
    let mut numbers = RandomNumbers(1);
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
