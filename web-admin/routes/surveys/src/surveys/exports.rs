//! Exports of a survey: the same rows as on the results page, as files.

use acts::error::Error;
use acts::surveys::instrument_of;
use assessment::questionnaire::Answer;
use axum::extract::{Path, State};
use axum::response::Response;
use documents::Instrument;
use documents::instrument::{Item, ScaleKind};
use futures::stream;
use model::ids::SurveyId;
use model::surveys::Survey;
use model::surveys::results::{ResponseRow, Results, answers_of};
use model::training::due::local;
use pages::school_time::zone_name;
use routes_base::auth::Visitor;
use routes_base::column_names::name_columns;
use routes_base::error::PageError;
use routes_base::export::{CsvCell, attach_file, write_csv};
use routes_base::{AppState, export};
use serde_json::json;
use store::surveys as stored;
use store::surveys::SubmittedResponse;

use super::results::rows_of_responses;
use super::{find_school_survey, owns_survey};

/// Columns with facts about a response, in addition to its answers.
const FACTS: [&str; 9] =
    ["response", "role", "who", "language", "submitted", "exercise", "device", "simulator_version", "pseudonym"];

/// Number of characters of a date such as 2026-11-30.
const ISO_DATE: usize = 10;

/// Responses written per batch.
const AT_ONCE: usize = 500;

/// Columns of the long table.
const LONG: [&str; 11] = [
    "response",
    "role",
    "who",
    "language",
    "submitted",
    "exercise",
    "device",
    "simulator_version",
    "pseudonym",
    "item",
    "answer",
];

/// The data of an export.
struct SurveyExport<'a> {
    survey: &'a Survey,
    instrument: &'a Instrument,
    rows: &'a [ResponseRow<'a>],
}

/// Serves a file of a survey. Individual answers are for its owner only: from them others could
/// reconstruct the groups that are hidden because of their size.
pub(super) async fn serve_export(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, file)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let id = id.parse::<SurveyId>().map_err(|_| Error::NotFound)?;
    let survey = find_school_survey(&state, &person, id).await?;
    let instrument = instrument_of(&state, &survey).await?;
    let owner = owns_survey(&person, &survey);
    let submitted = stored::submitted(state.db.reader(), &survey).await?;
    let name = format!("{}-{}", instrument.id, file.trim_end_matches(".csv"));
    match file.as_str() {
        "answers-wide.csv" | "answers-long.csv" if !owner => {
            return Err(Error::Forbidden(tr!("single answers are visible only to the owner of the survey")).into());
        }
        "answers-wide.csv" => return Ok(wide_table(&name, instrument, submitted)?),
        "answers-long.csv" => {
            return Ok(export::stream_csv(&name, &LONG, stream::iter(long_table(instrument, submitted)))?);
        }
        _ => {}
    }
    let rows = rows_of_responses(&instrument, &submitted);
    let study = SurveyExport { survey: &survey, instrument: &instrument, rows: &rows };
    let (media_type, body) = match file.as_str() {
        "codebook.csv" => ("text/csv; charset=utf-8", study.codebook()?),
        "results.json" => ("application/json", study.results(owner)?),
        _ => return Err(Error::NotFound.into()),
    };
    Ok(attach_file(media_type, &format!("{}-{file}", instrument.id), body))
}

fn write_answer(answer: Option<&Answer>) -> CsvCell {
    match answer {
        None => CsvCell::Empty,
        Some(Answer::Number(number)) => CsvCell::Number(*number),
        Some(Answer::Text(text)) => text.as_str().into(),
        Some(Answer::Several(ids)) => ids.join(";").into(),
    }
}

/// `zone` is the school's time zone, passed explicitly since the file is written after the handler
/// has returned.
fn response_facts(given: &SubmittedResponse, zone: &str) -> Vec<CsvCell> {
    let known = |text: &Option<String>| text.as_deref().map_or(CsvCell::Empty, CsvCell::from);
    vec![
        given.id.to_string().into(),
        given.role.as_str().into(),
        known(&given.who),
        given.language.as_str().into(),
        local(given.submitted_at, zone).machine.chars().take(ISO_DATE).collect::<String>().into(),
        known(&given.exercise_id),
        known(&given.device),
        known(&given.simulator_version),
        known(&given.pseudonym),
    ]
}

/// Returns the column names of the wide table: facts about a response, items, scores.
fn names_of_columns(instrument: &Instrument) -> Vec<String> {
    let items = instrument.items.iter().map(|item| item.id.clone());
    let scores = instrument.scores.iter().map(|key| format!("score_{}", key.id));
    name_columns(&FACTS.map(str::to_owned).into_iter().chain(items).chain(scores).collect::<Vec<_>>())
}

/// Formats a value and its label, as `1 = No`. A label with a semicolon, which separates values, is
/// quoted.
fn say_value(id: &str, label: &str) -> String {
    if label.contains([';', '"']) {
        format!("{id} = \"{}\"", label.replace('"', "\"\""))
    } else {
        format!("{id} = {label}")
    }
}

/// Returns a row for each answer, response by response, as an iterator, since there may be millions
/// of them.
fn long_table(
    instrument: Instrument,
    submitted: Vec<SubmittedResponse>,
) -> impl Iterator<Item = anyhow::Result<Vec<Vec<CsvCell>>>> {
    let zone = zone_name();
    submitted.into_iter().map(move |given| {
        let row = |(item, answer): (&Item, &Option<Answer>)| {
            response_facts(&given, &zone)
                .into_iter()
                .chain([item.id.as_str().into(), write_answer(answer.as_ref())])
                .collect()
        };
        Ok(instrument.items.iter().zip(&given.answers.0).map(row).collect())
    })
}

/// Returns a row for each response with its scores, in batches.
fn wide_table(file: &str, instrument: Instrument, submitted: Vec<SubmittedResponse>) -> anyhow::Result<Response> {
    let names = names_of_columns(&instrument);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let zone = zone_name();
    let count = instrument.items.len();
    let row = move |(given, row): (&SubmittedResponse, ResponseRow<'_>)| -> Vec<CsvCell> {
        let answers = (0..count).map(|at| given.answers.0.get(at).and_then(Option::as_ref));
        let scores = row.scores.iter().map(|score| CsvCell::from(*score));
        response_facts(given, &zone).into_iter().chain(answers.map(write_answer)).chain(scores).collect()
    };
    let starts = (0..submitted.len()).step_by(AT_ONCE);
    let some = starts.map(move |from| {
        let part = &submitted[from..submitted.len().min(from + AT_ONCE)];
        Ok(part.iter().zip(rows_of_responses(&instrument, part)).map(&row).collect())
    });
    export::stream_csv(file, &names, stream::iter(some))
}

impl SurveyExport<'_> {
    /// Returns the codebook of the wide table: for every column its name, type and measure in terms
    /// of R and SPSS, label, values, and the id of the instrument's item or score, which may not be
    /// a valid column name.
    fn codebook(&self) -> anyhow::Result<String> {
        let names = names_of_columns(self.instrument);
        let (facts, names) = names.split_at(FACTS.len());
        let (of_items, of_scores) = names.split_at(self.instrument.items.len());
        let row =
            |cells: [&str; 5], id: &str| cells.into_iter().chain(["empty", id]).map(CsvCell::from).collect::<Vec<_>>();
        let mut rows: Vec<Vec<CsvCell>> =
            facts.iter().map(|fact| row([fact, "string", "nominal", fact, ""], "")).collect();
        for (item, name) in self.instrument.items.iter().zip(of_items) {
            let (kind, measure) = match self.instrument.scale(item) {
                Some(ScaleKind::Likert { .. }) => ("numeric", "ordinal"),
                Some(ScaleKind::Slider { .. } | ScaleKind::Number { .. }) => ("numeric", "scale"),
                _ => ("string", "nominal"),
            };
            let values = answers_of(self.instrument, item);
            let values: Vec<String> = values.into_iter().map(|(id, label)| say_value(&id, &label)).collect();
            let label = item.text.in_language(words::current().code());
            rows.push(row([name, kind, measure, label, &values.join("; ")], &item.id));
        }
        for (key, name) in self.instrument.scores.iter().zip(of_scores) {
            let label = key.title.in_language(words::current().code());
            rows.push(row([name, "numeric", "scale", label, ""], &key.id));
        }
        write_csv(&["variable", "type", "measure", "label", "values", "missing", "id"], &rows)
    }

    fn results(&self, owner: bool) -> anyhow::Result<String> {
        let all: Vec<&ResponseRow<'_>> = self.rows.iter().collect();
        let found = Results::new(self.instrument, &all, owner);
        let file = json!({
            "survey": self.survey.title,
            "instrument": self.instrument.id,
            "instrument_sha256": self.instrument.sha256,
            "identity": self.survey.identity,
            "generated": self.survey.generated,
            "results": found,
        });
        Ok(serde_json::to_string_pretty(&file)?)
    }
}
