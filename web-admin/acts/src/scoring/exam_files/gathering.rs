//! Gathers the content of an exam file.

use std::collections::BTreeMap;

use assessment::questionnaire;
use documents::ExerciseBundle;
use documents::instrument::ScoreKey;
use model::ids::{ExamFileId, RevisionId};
use model::scoring::exam_file::{ExamCourse, ExamGrade, ExamManifest, ExamProof, ExaminedAttempt, ExaminedPerson};
use model::training::certificate::SCOPE;
use model::training::progress::{Course, Mastery, Progress, ScoredAttempt, StepState};
use model::{CurrentPerson, Moment, Needed, PersonKey, Proof, Uncounted};
use serde_json::{Value, json};
use store::authoring::exercises;
use store::operations::schools;
use store::recordings::proofs;
use store::recordings::sessions::Session;
use store::scoring::exam_files::NamedRating;
use store::scoring::exams::{self, Sitting};
use store::scoring::scores::Score;
use store::scoring::{exam_files, grades, regradings, reviews, scores, supervisions};
use store::surveys::instruments;
use store::surveys::instruments::InstrumentRevision;
use store::training::curricula::TaughtCurriculum;
use store::training::{curricula, practice};
use store::{people, stations};
use time::OffsetDateTime;

use super::ExamWords;
use crate::error::Error;
use crate::scoring::regrading::Rubric;
use crate::service::Service;
use crate::surveys;
use crate::training::{assignments, badges};

/// The content of an exam file.
pub(super) struct Gathered {
    /// The statement, without id, time and entries.
    statement: ExamManifest,
    /// Small entries by name.
    pub entries: BTreeMap<String, Vec<u8>>,
}

/// Completes the manifest.
pub(super) fn manifest_of(gathered: &Gathered, id: ExamFileId, now: Moment) -> ExamManifest {
    ExamManifest { id: id.to_string(), frozen_at: now.to_string(), ..gathered.statement.clone() }
}

/// Reads all parts of an exam file but the recording.
pub(super) async fn gather(
    service: &Service,
    by: &CurrentPerson,
    session: &Session,
    words: ExamWords,
) -> Result<Gathered, Error> {
    let (reader, key) = (service.db.reader(), session.key());
    let not_scored = || Error::Conflict(tr!("this attempt has not been scored yet").to_owned());
    let grade = grades::find_grade(reader, key).await?.ok_or_else(not_scored)?;
    let computed = scores::list_scores(reader, key).await?;
    let rubric_sha256 = computed.last().ok_or_else(not_scored)?.rubric_sha256.clone();
    let needed = schools::certificate_needs(reader, session.school_id).await?;
    let proof = proofs::find_proof(reader, key).await?;
    let mut entries = Entries::default();
    let exercise = entries.add_exercise(service, session, &rubric_sha256).await?;
    let courses = entries.add_courses(service, session, needed, words).await?;
    entries.add_ratings(service, session).await?;
    entries.add_json("scores.json", &scores_of(service, session, &computed).await?)?;
    entries.add_json("decisions.json", &decisions_on(service, session, &computed).await?)?;
    entries.add_json("proofs.json", &proofs_of(service, session).await?)?;
    let statement = ExamManifest {
        kind: ExamManifest::KIND.to_owned(),
        format: ExamManifest::FORMAT,
        id: String::new(),
        school: schools::find_school_name(reader, session.school_id).await?,
        person: examined_person(service, session).await?,
        attempt: ExaminedAttempt {
            id: session.id.to_string(),
            exercise_id: session.exercise_id.clone(),
            exercise: exercise.unwrap_or_else(|| session.exercise_id.clone()),
            exercise_sha256: session.exercise_sha256.clone(),
            scene_sha256: session.scene_sha256.clone(),
            published: session.revision_id.is_some(),
            started_at: session.started_at.to_string(),
            received_at: session.received_at.to_string(),
            duration_s: session.duration_s,
        },
        grade: ExamGrade { score: grade.score, passed: grade.passed, overridden: grade.overridden, rubric_sha256 },
        proof: proof_statement(session, proof, needed, words),
        courses,
        frozen_by: by.display_name.clone(),
        frozen_at: String::new(),
        scope: SCOPE.to_owned(),
        entries: Vec::new(),
    };
    Ok(Gathered { statement, entries: entries.0 })
}

async fn examined_person(service: &Service, session: &Session) -> Result<ExaminedPerson, Error> {
    let reader = service.db.reader();
    let person = people::find_person(reader, session.trainee_id).await?.ok_or(Error::NotFound)?;
    Ok(ExaminedPerson {
        name: person.display_name,
        registrar_id: people::find_registrar_id(reader, session.school_id, session.trainee_id).await?,
        pseudonym: person.pseudonym,
    })
}

fn proof_statement(session: &Session, proof: Proof, needed: Needed, words: ExamWords) -> ExamProof {
    let uncounted = session.uncounted.map(Uncounted::word);
    ExamProof::new(proof, (words.needed)(needed), uncounted, needed.met_by(proof))
}

/// The small entries of a file.
#[derive(Default)]
struct Entries(BTreeMap<String, Vec<u8>>);

impl Entries {
    fn add_json(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let bytes = serde_json::to_vec_pretty(value).map_err(anyhow::Error::from)?;
        self.0.insert(name.to_owned(), bytes);
        Ok(())
    }

    /// Adds the documents of the attempt, and those of the rubric if it is of another revision.
    /// Returns the title of the exercise. Meshes are in the recording; an exercise that the school
    /// never published is only there.
    async fn add_exercise(
        &mut self,
        service: &Service,
        session: &Session,
        rubric_sha256: &str,
    ) -> Result<Option<String>, Error> {
        let Some(revision) = session.revision_id else { return Ok(None) };
        let bytes = exercises::read_exercise_bytes(service.db.reader(), session.school_id, revision).await?;
        let bytes = bytes.ok_or(Error::NotFound)?;
        let bundle = ExerciseBundle::from_parts(&bytes.exercise, &bytes.scene, &bytes.meshes);
        let exercise = bundle.map_err(anyhow::Error::new)?.exercise;
        if exercise.rubric_sha256() != rubric_sha256 {
            let rubric = Rubric::of_digest(service, session.school_id, &session.exercise_id, rubric_sha256).await?;
            if let Some(rubric) = rubric {
                self.add_rubric(service, session, rubric.revision()).await?;
            }
        }
        self.0.insert("documents/exercise.toml".to_owned(), bytes.exercise);
        self.0.insert("documents/scene.toml".to_owned(), bytes.scene);
        Ok(Some(exercise.title.in_language("en").to_owned()))
    }

    async fn add_rubric(&mut self, service: &Service, session: &Session, revision: RevisionId) -> Result<(), Error> {
        let bytes = exercises::read_exercise_bytes(service.db.reader(), session.school_id, revision).await?;
        self.0.extend(bytes.map(|bytes| ("documents/rubric.toml".to_owned(), bytes.exercise)));
        Ok(())
    }

    /// Adds the courses that contain the exercise, each with the revision to which mastery refers.
    async fn add_courses(
        &mut self,
        service: &Service,
        session: &Session,
        needed: Needed,
        words: ExamWords,
    ) -> Result<Vec<ExamCourse>, Error> {
        let (reader, school) = (service.db.reader(), session.school_id);
        let trainee = PersonKey { school_id: school, person_id: session.trainee_id };
        let attempts = practice::list_trainee_practice(reader, school, session.trainee_id).await?;
        let proved = badges::list_proved_attempts(service, trainee, needed, &attempts).await?;
        let mut courses = Vec::new();
        for (curriculum, course) in assignments::taught_curricula(service, school).await? {
            let Some(judged) = judge_course(&curriculum, &course, session, &proved) else { continue };
            let found = curricula::find_curriculum_by_hash(reader, school, judged.sha256).await?;
            if let Some(revision) = found {
                let bytes = curricula::read_curriculum_bytes(reader, school, revision).await?;
                let name = format!("documents/course-{}.toml", judged.sha256);
                self.0.extend(bytes.map(|bytes| (name, bytes)));
            }
            courses.push(judged.statement(&curriculum, words));
        }
        Ok(courses)
    }

    /// Adds the finished ratings, those of an exam's examiner included, with their instruments.
    async fn add_ratings(&mut self, service: &Service, session: &Session) -> Result<(), Error> {
        let reader = service.db.reader();
        let mut ratings = Vec::new();
        let candidate = PersonKey { school_id: session.school_id, person_id: session.trainee_id };
        let sittings = exams::list_sittings_of_attempt(reader, candidate, session.id).await?;
        let examined = sittings.into_iter().filter_map(rating_of_examiner);
        for rating in examined.chain(exam_files::list_named_ratings(reader, session.key()).await?) {
            let revision = rating.revision_id;
            let found = instruments::find_instrument_revision(reader, session.school_id, revision).await?;
            let revision = found.ok_or(Error::NotFound)?;
            ratings.push(rating_of(&rating, &revision)?);
            self.0.insert(format!("documents/instrument-{}.toml", revision.sha256), revision.bytes);
        }
        self.add_json("ratings.json", &Value::Array(ratings))
    }
}

/// A course as judged for one person and one exercise.
struct JudgedCourse<'a> {
    sha256: &'a str,
    rule: &'a Mastery,
    exercise_mastered: Option<OffsetDateTime>,
    course_mastered: Option<OffsetDateTime>,
}

impl JudgedCourse<'_> {
    fn statement(&self, curriculum: &TaughtCurriculum, words: ExamWords) -> ExamCourse {
        let time = |at: OffsetDateTime| Moment::from(at).to_string();
        ExamCourse {
            id: curriculum.curriculum_id.clone(),
            title: curriculum.title.clone(),
            sha256: self.sha256.to_owned(),
            rule: (words.rule)(self.rule),
            exercise_mastered_at: self.exercise_mastered.map(time),
            course_mastered_at: self.course_mastered.map(time),
        }
    }
}

/// Judges a course; `None` if neither the current nor the mastered revision has the exercise.
fn judge_course<'a>(
    curriculum: &'a TaughtCurriculum,
    course: &'a Course,
    session: &Session,
    proved: &[ScoredAttempt],
) -> Option<JudgedCourse<'a>> {
    let progress = Progress::of(course, proved);
    let course_mastered = progress.completed_on();
    if let Some((earlier, mastery)) = progress.earlier_in(course) {
        let place = earlier.steps.iter().position(|step| step.exercise == session.exercise_id)?;
        let exercise_mastered = Some(mastery.exercises[place]);
        return Some(JudgedCourse { sha256: &earlier.sha256, rule: &earlier.rule, exercise_mastered, course_mastered });
    }
    let place = course.steps.iter().position(|step| step.exercise == session.exercise_id)?;
    let exercise_mastered = match progress.steps[place].state {
        StepState::Mastered { on } => Some(on),
        _ => None,
    };
    Some(JudgedCourse { sha256: &curriculum.sha256, rule: &course.rule, exercise_mastered, course_mastered })
}

/// Returns the examiner's rating in a sitting; `None` if it is not finished.
fn rating_of_examiner(sitting: Sitting) -> Option<NamedRating> {
    Some(NamedRating {
        round: sitting.exam,
        revision_id: sitting.revision_id,
        rater: sitting.examiner,
        may_know: true,
        generated: false,
        answers: sitting.answers,
        finished_at: sitting.finished_at?,
    })
}

fn rating_of(rating: &NamedRating, revision: &InstrumentRevision) -> Result<Value, Error> {
    let instrument = surveys::read(&revision.bytes)?;
    let items = instrument.items.iter().zip(&rating.answers.0);
    let answers: Vec<Value> = items.map(|(item, answer)| json!({ "item": item.id, "answer": answer })).collect();
    let score = |key: &ScoreKey| {
        let value = questionnaire::score_response(&instrument, key, &rating.answers.0).ok();
        json!({ "score": key.title.in_language("en"), "value": value })
    };
    let scores: Vec<Value> = instrument.scores.iter().map(score).collect();
    Ok(json!({
        "round": rating.round, "instrument": revision.instrument_id, "instrument_sha256": revision.sha256,
        "rater": rating.rater, "rater_may_know_trainee": rating.may_know, "generated": rating.generated,
        "answers": answers, "scores": scores, "finished_at": rating.finished_at,
    }))
}

/// Describes all computed scores of an attempt, and its metrics.
async fn scores_of(service: &Service, session: &Session, computed: &[Score]) -> Result<Value, Error> {
    let metrics = scores::list_score_metrics(service.db.reader(), session.key()).await?;
    let score = |score: &Score| {
        json!({
            "score": score.score, "passed": score.passed, "exercise_id": score.rubric_id,
            "rubric_sha256": score.rubric_sha256, "deductions": score.deductions.0, "hard_fails": score.hard_fails.0,
            "simulator_version": score.simulator_version, "computed_at": score.computed_at,
        })
    };
    Ok(json!({ "computed": computed.iter().map(score).collect::<Vec<_>>(), "metrics": metrics }))
}

/// Describes the decisions of people on the grade, oldest first.
async fn decisions_on(service: &Service, session: &Session, computed: &[Score]) -> Result<Value, Error> {
    let (reader, key) = (service.db.reader(), session.key());
    let regraded = regradings::of_session(reader, key).await?.into_iter().map(|act| {
        let score = computed.iter().find(|score| score.id == act.score_id);
        json!({
            "by": act.by, "reason": act.reason, "score": score.map(|score| score.score),
            "rubric_sha256": score.map(|score| &score.rubric_sha256), "made_at": score.map(|score| score.computed_at),
        })
    });
    let overridden = grades::list_overrides(reader, key).await?.into_iter().map(|made| {
        json!({
            "by": made.by, "reason": made.reason, "score": made.score, "passed": made.passed, "made_at": made.made_at,
        })
    });
    let review = reviews::find_review(reader, key).await?;
    Ok(json!({
        "regradings": regraded.collect::<Vec<_>>(),
        "overrides": overridden.collect::<Vec<_>>(),
        "review": review.map(|review| json!({ "by": review.by, "reviewed_at": review.reviewed_at })),
    }))
}

/// Describes the proofs of an attempt.
async fn proofs_of(service: &Service, session: &Session) -> Result<Value, Error> {
    let reader = service.db.reader();
    let station = match session.signed_by {
        Some(station) => {
            let name = stations::find_station_name(reader, session.school_id, station).await?;
            json!({ "id": station, "name": name })
        }
        None => Value::Null,
    };
    let supervised = supervisions::find_supervision(reader, session.key()).await?;
    Ok(json!({
        "recording_sha256": session.recording_sha256,
        "recording_complete": session.complete,
        "signed_by_station": station,
        "resimulation": session.verify_flagged.map(|differs| json!({
            "identical": !differs,
            "deviation_n": session.verify_deviation_n,
            "event_differences": session.verify_event_differences,
        })),
        "supervised": supervised.map(|there| json!({ "by": there.by, "confirmed_at": there.confirmed_at })),
    }))
}
