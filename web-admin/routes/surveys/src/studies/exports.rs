//! Exports of a study: a row for each attempt, and a codebook of the columns.

use std::collections::BTreeMap;

use acts::error::Error;
use assessment::catalogue::newest_definition;
use assessment::questionnaire::{Answer, Scorer};
use axum::extract::{Path, State};
use axum::response::Response;
use documents::Instrument;
use documents::instrument::{Combine, ScaleKind, ScoreKey};
use model::surveys::results::answers_of;
use pages::format;
use routes_base::AppState;
use routes_base::auth::Teacher;
use routes_base::column_names::name_columns;
use routes_base::error::PageError;
use routes_base::export::{CsvCell, attach_file, download_csv};
use serde::Serialize;
use serde_json::json;
use store::scoring::scores::MetricOfMany;
use store::studies::StudyAttempt;

use super::find_own_study;
use super::results::{AnsweredSurvey, GatheredStudy};

/// A column of the table, as described in the codebook.
#[derive(Debug, Serialize)]
struct StudyColumn {
    /// ASCII: a letter, then letters, digits and underscores.
    name: String,
    /// Its meaning.
    label: String,
    /// Its unit, if it has one.
    unit: String,
    /// `numeric` or `string`.
    kind: &'static str,
    /// Labels of its values.
    values: BTreeMap<String, String>,
    /// How it is computed.
    formula: String,
    #[serde(skip)]
    cells: Vec<CsvCell>,
}

impl StudyColumn {
    fn new(name: &str, label: &str, kind: &'static str, cells: Vec<CsvCell>) -> Self {
        let (unit, values, formula) = (String::new(), BTreeMap::new(), String::new());
        Self { name: name.to_ascii_lowercase(), label: label.to_owned(), unit, kind, values, formula, cells }
    }
}

/// Serves a file of a study.
pub(super) async fn serve_export(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path((id, file)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let id = id.parse().map_err(|_| Error::NotFound)?;
    let gathered = GatheredStudy::read(&state, find_own_study(&state, &person, id).await?).await?;
    let columns = columns_of_study(&gathered);
    match file.as_str() {
        "study.csv" => {
            let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
            let rows: Vec<Vec<CsvCell>> = (0..gathered.attempts.len())
                .map(|at| columns.iter().map(|column| column.cells[at].clone()).collect())
                .collect();
            Ok(download_csv("study", &names, &rows)?)
        }
        "study.json" => {
            let body =
                serde_json::to_string_pretty(&codebook_of_study(&gathered, &columns)).map_err(anyhow::Error::from)?;
            Ok(attach_file("application/json", "study.json", body))
        }
        _ => Err(Error::NotFound.into()),
    }
}

fn codebook_of_study(gathered: &GatheredStudy, columns: &[StudyColumn]) -> serde_json::Value {
    let study = &gathered.study;
    let found = |exercise: &store::studies::StudyExercise| {
        (exercise.exercise_id.clone(), gathered.findings(&exercise.exercise_id))
    };
    let answered = |answered: &AnsweredSurvey| {
        json!({
            "instrument": answered.instrument.id,
            "instrument_sha256": answered.instrument.sha256,
            "asked": if answered.survey.at_end { "after the last attempt" } else { "after each attempt" },
            "results": gathered.survey_results(answered),
        })
    };
    json!({
        "title": study.title,
        "generated": study.generated,
        "groups": study.groups.0,
        "experts": study.groups.0.last(),
        "attempts_at_each_exercise": study.attempts,
        "consent": study.consent,
        "controller": study.controller,
        "contact": study.contact,
        "kept_months": study.kept_months,
        "missing": "empty",
        "table": "study.csv: a row for each attempt",
        "columns": columns,
        "findings": gathered.exercises.iter().map(found).collect::<BTreeMap<_, _>>(),
        "findings_note": "Each person is represented by the mean of their attempts; the last group is compared with the first. p from the Mann-Whitney test, p_holm corrected after Holm over all metrics of the exercise, Hedges' g and the area under the curve with 95 % intervals.",
        "surveys": gathered.answered.iter().map(answered).collect::<Vec<_>>(),
    })
}

fn columns_of_study(gathered: &GatheredStudy) -> Vec<StudyColumn> {
    let mut columns = columns_of_participants(gathered);
    columns.extend(columns_of_attempts(&gathered.attempts));
    columns.extend(gathered.metrics.iter().map(|metric| column_of_metric(metric, gathered.attempts.len())));
    for (place, answered) in gathered.answered.iter().enumerate() {
        columns.extend(columns_of_answers(answered, place + 1, &gathered.attempts));
    }
    let wanted: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    for (column, name) in columns.iter_mut().zip(name_columns(&wanted)) {
        column.name = name;
    }
    columns
}

fn columns_of_participants(gathered: &GatheredStudy) -> Vec<StudyColumn> {
    let of_each = |cell: &dyn Fn(&store::studies::StudyParticipant) -> CsvCell| -> Vec<CsvCell> {
        let known = |attempt: &StudyAttempt| gathered.participants.iter().find(|p| p.person_id == attempt.person_id);
        gathered.attempts.iter().map(|attempt| known(attempt).map_or(CsvCell::Empty, cell)).collect()
    };
    let pseudonyms = of_each(&|participant| participant.pseudonym.as_str().into());
    let groups = of_each(&|participant| CsvCell::Number(f64::from(participant.group_place) + 1.0));
    let names = gathered.study.groups.0.iter().enumerate();
    let group = StudyColumn {
        values: names.map(|(at, name)| ((at + 1).to_string(), name.clone())).collect(),
        ..StudyColumn::new("group", "Group, from the least experienced to the experts", "numeric", groups)
    };
    let mut columns = vec![StudyColumn::new("participant", "Pseudonym", "string", pseudonyms), group];
    for (at, question) in gathered.study.questions.0.iter().enumerate() {
        let cells = of_each(&|participant| participant.facts.0.get(at).map_or(CsvCell::Empty, |f| f.as_str().into()));
        columns.push(StudyColumn::new(&format!("fact{}", at + 1), question, "string", cells));
    }
    columns
}

fn columns_of_attempts(attempts: &[StudyAttempt]) -> Vec<StudyColumn> {
    let of_each = |cell: &dyn Fn(&StudyAttempt) -> CsvCell| attempts.iter().map(cell).collect::<Vec<_>>();
    let column = |name: &str, label: &str, kind, cell: &dyn Fn(&StudyAttempt) -> CsvCell| {
        StudyColumn::new(name, label, kind, of_each(cell))
    };
    let passed = StudyColumn {
        values: [("0".to_owned(), "not passed".to_owned()), ("1".to_owned(), "passed".to_owned())].into(),
        ..column("passed", "Passed", "numeric", &|attempt| CsvCell::Number(f64::from(u8::from(attempt.passed))))
    };
    let score = StudyColumn {
        unit: "points of 100".to_owned(),
        formula: "100 minus the points lost by the rubric of the exercise; an override replaces it".to_owned(),
        ..column("score", "Score", "numeric", &|attempt| CsvCell::Number(attempt.score))
    };
    vec![
        column("exercise", "Exercise", "string", &|attempt| attempt.exercise_id.as_str().into()),
        column("attempt", "Attempt at the exercise, from 1", "numeric", &|attempt| {
            CsvCell::Number(attempt.number.into())
        }),
        column("began", "Begin, UTC", "string", &|attempt| {
            format::format_machine_time(attempt.started_at.to_utc()).into()
        }),
        column("session", "Id of the attempt in the service", "string", &|attempt| {
            attempt.session_id.to_string().into()
        }),
        score,
        passed,
    ]
}

fn column_of_metric(metric: &MetricOfMany, attempts: usize) -> StudyColumn {
    let mut cells = vec![CsvCell::Empty; attempts];
    for found in &metric.found.0 {
        if let Some(cell) = cells.get_mut(found.0) {
            *cell = found.value().into();
        }
    }
    StudyColumn {
        unit: metric.unit.clone(),
        formula: newest_definition(&metric.id).map_or("", |known| known.definition).to_owned(),
        ..StudyColumn::new(&format!("m_{}", metric.id), &metric.label, "numeric", cells)
    }
}

/// Returns the columns of a survey: answers and scores, in the row of the attempt after which they
/// were given.
fn columns_of_answers(answered: &AnsweredSurvey, place: usize, attempts: &[StudyAttempt]) -> Vec<StudyColumn> {
    let given = |attempt: &StudyAttempt| {
        let given = answered.submitted.iter().find(|given| given.session_id == Some(attempt.session_id));
        given.map(|given| &given.answers.0)
    };
    let instrument = &answered.instrument;
    let mut columns = Vec::new();
    for (at, item) in instrument.items.iter().enumerate() {
        let cell = |attempt: &StudyAttempt| match given(attempt).and_then(|answers| answers.get(at)?.as_ref()) {
            None => CsvCell::Empty,
            Some(Answer::Number(number)) => CsvCell::Number(*number),
            Some(Answer::Text(text)) => text.as_str().into(),
            Some(Answer::Several(ids)) => ids.join(";").into(),
        };
        let kind = match instrument.scale(item) {
            Some(ScaleKind::Likert { .. } | ScaleKind::Slider { .. } | ScaleKind::Number { .. }) => "numeric",
            _ => "string",
        };
        let (name, text) = (format!("q{place}_{}", item.id), item.text.in_language(words::current().code()));
        columns.push(StudyColumn {
            values: answers_of(instrument, item).into_iter().collect(),
            ..StudyColumn::new(&name, text, kind, attempts.iter().map(cell).collect())
        });
    }
    for (key, scorer) in instrument.scores.iter().zip(Scorer::all(instrument)) {
        let score = |attempt: &StudyAttempt| given(attempt).and_then(|answers| scorer.score(answers).ok()).into();
        let name = format!("s{place}_{}", key.id);
        columns.push(StudyColumn {
            formula: formula_of_score(instrument, key),
            ..StudyColumn::new(
                &name,
                key.title.in_language(words::current().code()),
                "numeric",
                attempts.iter().map(score).collect(),
            )
        });
    }
    columns
}

/// Describes in one line how a score is computed from answers.
fn formula_of_score(instrument: &Instrument, key: &ScoreKey) -> String {
    let reversed = |id: &&String| key.reversed.contains(id);
    let item = |id: &String| if reversed(&id) { format!("reversed({id})") } else { id.clone() };
    let items: Vec<String> = key.items.iter().map(item).collect();
    let combined = match key.combine {
        Combine::Sum => "sum",
        Combine::Mean => "mean",
        Combine::PairWeighted => "mean weighted by the pairs",
    };
    let shift = if key.shift == 0.0 { String::new() } else { format!(", each plus {}", key.shift) };
    let (least, greatest) = assessment::questionnaire::score_range(instrument, key);
    format!(
        "{} * {combined} of ({}){shift}, plus {}; from {least} to {greatest}; reversed: smallest plus largest value minus the answer",
        key.factor,
        items.join(", "),
        key.offset
    )
}
