//! `/exams/{id}`: the candidates of an exam, both ratings, and their agreement.

use std::collections::BTreeSet;

use acts::error::Error;
use acts::scoring::exams;
use acts::surveys;
use assessment::questionnaire::{Answer, score_response};
use axum::extract::State;
use axum::response::Response;
use documents::Instrument;
use documents::instrument::ScoreKey;
use model::ids::{ExamId, PersonId};
use model::scoring::rating::ScoreTable;
use model::search_key::family_sort_key;
use model::{CurrentPerson, Moment, Role};
use pages::scoring::exams::{CandidateRow, ExamPage, SecondRatings, SittingClock};
use pages::scoring::rating::ScoreView;
use pages::{NavPlace, Shell, format};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Teacher};
use routes_base::error::PageError;
use routes_base::export;
use routes_base::export::CsvCell;
use store::scoring::exams as stored;
use store::scoring::exams::{Exam, Sitting};
use store::training::reports;

use super::{attempt_href, exam_href};
use crate::scoring::ratings::round_href;

/// A candidate, with the sitting if it has begun.
struct Candidate {
    id: PersonId,
    name: String,
    sitting: Option<Sitting>,
}

/// Returns the trainees of the cohort and everyone with a sitting, by family name.
async fn list_candidates(state: &AppState, exam: &Exam) -> Result<Vec<Candidate>, Error> {
    let reader = state.db.reader();
    let sittings = stored::list_sittings(reader, exam.school_id, exam.id).await?;
    let begun: BTreeSet<PersonId> = sittings.iter().map(|sitting| sitting.person_id).collect();
    let members = reports::members(reader, exam.school_id, exam.cohort_id, Role::Trainee).await?;
    let waiting = members.into_iter().filter(|member| !begun.contains(&member.id));
    let mut candidates: Vec<Candidate> =
        waiting.map(|member| Candidate { id: member.id, name: member.name, sitting: None }).collect();
    candidates.extend(sittings.into_iter().map(|sitting| Candidate {
        id: sitting.person_id,
        name: sitting.name.clone(),
        sitting: Some(sitting),
    }));
    candidates.sort_by_cached_key(|candidate| (family_sort_key(&candidate.name), candidate.id));
    Ok(candidates)
}

/// An exam as a visitor sees it.
pub(super) struct ExamView {
    /// Whether the visitor is the second rater.
    pub is_second_rater: bool,
    /// Whether the second rater has rated everything, so that ratings are shown.
    has_rated_all: bool,
}

impl ExamView {
    /// Determines what a visitor sees, from all sittings of the exam.
    pub(super) fn new<'a>(
        exam: &Exam,
        person: &CurrentPerson,
        sittings: impl IntoIterator<Item = &'a Sitting>,
    ) -> Self {
        let is_rated = |sitting: &Sitting| sitting.session_id.is_none() || sitting.second_finished_at.is_some();
        Self {
            is_second_rater: exam.second_rater_id == Some(person.id),
            has_rated_all: exam.closed_at.is_some() && sittings.into_iter().all(is_rated),
        }
    }

    /// Whether ratings and the attempt of a sitting are hidden: from the second rater, until the
    /// exam is closed and they have rated this attempt and all others.
    pub(super) fn hides(&self, sitting: Option<&Sitting>) -> bool {
        let is_rated = sitting.is_some_and(|sitting| sitting.second_finished_at.is_some());
        self.is_second_rater && !(self.has_rated_all && is_rated)
    }
}

fn first_score(instrument: &Instrument, key: &ScoreKey, sitting: &Sitting) -> Option<f64> {
    sitting.finished_at?;
    score_response(instrument, key, &sitting.answers).ok()
}

fn second_score(instrument: &Instrument, key: &ScoreKey, sitting: &Sitting) -> Option<f64> {
    sitting.second_finished_at?;
    score_response(instrument, key, &sitting.second_answers).ok()
}

/// Returns the instrument of an exam, and the score by which ratings are compared: its first.
async fn find_instrument(state: &AppState, exam: &Exam) -> Result<(Instrument, ScoreKey), Error> {
    let instrument = surveys::revision(state, exam.school_id, exam.revision_id).await?.ok_or(Error::NotFound)?;
    let key = instrument.scores.first().cloned().ok_or(Error::NotFound)?;
    Ok((instrument, key))
}

pub(super) async fn show_exam(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<ExamId>,
    csrf: Csrf,
) -> Result<ExamPage, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    let (instrument, key) = find_instrument(&state, &exam).await?;
    let candidates = list_candidates(&state, &exam).await?;
    let sittings: Vec<&Sitting> = candidates.iter().filter_map(|candidate| candidate.sitting.as_ref()).collect();
    let view = ExamView::new(&exam, &person, sittings.iter().copied());
    let pairs = sittings
        .iter()
        .filter(|sitting| sitting.is_sent)
        .map(|sitting| vec![first_score(&instrument, &key, sitting), second_score(&instrument, &key, sitting)]);
    let is_shown = !view.is_second_rater || view.has_rated_all;
    let agreement = is_shown.then(|| ScoreView::new(ScoreTable::new(&instrument, &key, pairs.collect())));
    let second = exam.second_rater.clone().map(|rater| SecondRatings {
        rater,
        round: exam.round_id.map(round_href),
        waiting: sittings.iter().filter(|sitting| sitting.waits_for_request()).count(),
        agreement: agreement.filter(|_| exam.round_id.is_some()),
    });
    let now = state.clock.now();
    let row = |candidate: &Candidate| make_row(candidate, &exam, &view, now);
    let scored = |row: CandidateRow, candidate: &Candidate| match &candidate.sitting {
        Some(sitting) if !row.is_hidden => CandidateRow {
            first: first_score(&instrument, &key, sitting),
            second: second_score(&instrument, &key, sitting),
            ..row
        },
        _ => row,
    };
    Ok(ExamPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Assignments),
        href: exam_href(id),
        cohort: (exam.cohort.clone(), format!("/cohorts/{}", exam.cohort_id)),
        score: key.title.in_language(words::current().code()).to_owned(),
        limit_min: exam.limit_min,
        closed_at: exam.closed_at.map(Moment::to_utc),
        rows: candidates.iter().map(|candidate| scored(row(candidate), candidate)).collect(),
        second,
        is_second_rater: view.is_second_rater,
        now: now.to_utc(),
        title: exam.title,
        exercise: exam.exercise,
        instrument: exam.instrument,
    })
}

/// Returns the row of a candidate without the ratings.
fn make_row(candidate: &Candidate, exam: &Exam, view: &ExamView, now: Moment) -> CandidateRow {
    let sitting = candidate.sitting.as_ref();
    let is_hidden = view.hides(sitting);
    let session = sitting.and_then(|sitting| sitting.session_id).filter(|_| !is_hidden);
    CandidateRow {
        name: candidate.name.clone(),
        href: format!("{}/candidates/{}", exam_href(exam.id), candidate.id),
        clock: sitting.map(|sitting| SittingClock::new(&sitting.times(), now)),
        examiner: sitting.map(|sitting| sitting.examiner.clone()).unwrap_or_default(),
        attempt: session.map(attempt_href),
        is_pending: session.is_some() && sitting.is_some_and(|sitting| !sitting.is_scored),
        is_unsigned: session.is_some() && sitting.is_some_and(|sitting| !sitting.is_signed),
        first: None,
        is_sent: sitting.is_some_and(|sitting| sitting.is_sent),
        second: None,
        is_hidden,
    }
}

/// Exports a row for each candidate, with the examiner's answers and both scores.
pub(super) async fn export_exam(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<ExamId>,
) -> Result<Response, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    if exam.second_rater_id == Some(person.id) {
        return Err(Error::Forbidden(tr!("the second rater does not see the first ratings")).into());
    }
    let (instrument, key) = find_instrument(&state, &exam).await?;
    let pseudonyms = reports::pseudonyms(state.db.reader(), exam.school_id, exam.cohort_id).await?;
    let items = instrument.items.iter().map(|item| item.id.as_str());
    let names: Vec<&str> = ["candidate", "examiner", "begun_at", "finished_at", "late_s", "attempt"]
        .into_iter()
        .chain(items)
        .chain(["first_rating", "second_rating", "difference", "candidate_id", "pseudonym"])
        .collect();
    let rows: Vec<Vec<CsvCell>> = list_candidates(&state, &exam)
        .await?
        .into_iter()
        .map(|candidate| {
            let identity = [
                CsvCell::from(candidate.id.to_string()),
                pseudonyms.get(&candidate.id).map_or(CsvCell::Empty, |pseudonym| CsvCell::from(pseudonym.as_str())),
            ];
            line_of_candidate(&instrument, &key, candidate).into_iter().chain(identity).collect()
        })
        .collect();
    Ok(export::download_csv(&exam.title, &names, &rows).map_err(Error::from)?)
}

fn line_of_candidate(instrument: &Instrument, key: &ScoreKey, candidate: Candidate) -> Vec<CsvCell> {
    let time = |at: Moment| CsvCell::from(format::format_machine_time(at.to_utc()));
    let mut line = vec![CsvCell::from(candidate.name)];
    let Some(sitting) = candidate.sitting else {
        line.resize(instrument.items.len() + 9, CsvCell::Empty);
        return line;
    };
    let finished = sitting.finished_at;
    line.push(CsvCell::from(sitting.examiner.as_str()));
    line.push(time(sitting.begun_at));
    line.push(finished.map_or(CsvCell::Empty, time));
    line.push(CsvCell::from(finished.map(|at| sitting.times().late_s(at).round())));
    line.push(sitting.session_id.map_or(CsvCell::Empty, |id| CsvCell::from(id.to_string())));
    let answer = |at: usize| match sitting.answers.get(at).and_then(Option::as_ref).filter(|_| finished.is_some()) {
        Some(Answer::Number(number)) => CsvCell::from(*number),
        Some(Answer::Text(id)) => CsvCell::from(id.as_str()),
        Some(Answer::Several(ids)) => CsvCell::from(ids.join(" ")),
        None => CsvCell::Empty,
    };
    line.extend((0..instrument.items.len()).map(answer));
    let (first, second) = (first_score(instrument, key, &sitting), second_score(instrument, key, &sitting));
    line.extend([first, second, first.zip(second).map(|(first, second)| second - first)].map(CsvCell::from));
    line
}
