//! `/surveys/{id}/results`, and the themes of comments.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::surveys;
use acts::surveys::{Theme, instrument_of};
use assessment::questionnaire::{Answer, Scorer};
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use documents::Instrument;
use documents::instrument::ScaleKind;
use model::ids::{ResponseId, SurveyId};
use model::single_line_text;
use model::surveys::Survey;
use model::surveys::groups::{LEAST, ResponseGroups};
use model::surveys::results::{ResponseRow, Results, correlation, score_group};
use pages::charts::Extent;
use pages::school_time::to_school_time;
use pages::surveys::results::{
    AskedLine, CommentBlock, ResultsPage, ScatteredScore, ScatteredScores, SplitScore, SplitScores, SurveyComment,
};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::surveys as stored;
use store::surveys::{SubmittedResponse, Tag};
use time::OffsetDateTime;

use super::{find_school_survey, owns_survey};

/// Metrics of an attempt that scores can be correlated with: parameter value and title.
const METRICS: [(&str, &str); 5] = [
    ("peak_force_n", sentence!("peak force (N)")),
    ("score", sentence!("score of the attempt")),
    ("overshoot_mm", sentence!("overshoot (mm)")),
    ("lateral_peak_n", sentence!("lateral force (N)")),
    ("time_total_s", sentence!("time (s)")),
];

/// Facts by which scores can be split: parameter value and title.
const WAYS: [(&str, &str); 4] = [
    ("month", sentence!("month")),
    ("exercise", sentence!("exercise")),
    ("simulator", sentence!("simulator version")),
    ("device", sentence!("device")),
];

/// Maximum number of comments shown per item; exports contain all.
const MOST_COMMENTS: usize = 500;

#[derive(Deserialize)]
pub(super) struct ResultsQuery {
    #[serde(default)]
    by: String,
    #[serde(default)]
    metric: String,
}

/// Converts submitted responses to rows for the analysis.
pub(crate) fn rows_of_responses<'a>(
    instrument: &Instrument,
    submitted: &'a [SubmittedResponse],
) -> Vec<ResponseRow<'a>> {
    let scorers = Scorer::all(instrument);
    let row = |given: &'a SubmittedResponse| ResponseRow {
        id: given.id,
        role: &given.role,
        attempt: [given.exercise_id.as_deref(), given.device.as_deref(), given.simulator_version.as_deref()],
        month: month_of_response(to_school_time(given.submitted_at.to_utc())),
        answers: &given.answers.0,
        scores: scorers.iter().map(|scorer| scorer.score(&given.answers.0).ok()).collect(),
    };
    submitted.iter().map(row).collect()
}

fn month_of_response(at: OffsetDateTime) -> String {
    format!("{}-{:02}", at.year(), u8::from(at.month()))
}

pub(super) async fn show_results(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SurveyId>,
    csrf: Csrf,
    Query(choice): Query<ResultsQuery>,
) -> Result<ResultsPage, PageError> {
    let survey = find_school_survey(&state, &person, id).await?;
    let reader = state.db.reader();
    let instrument = instrument_of(&state, &survey).await?;
    let submitted = stored::submitted(reader, &survey).await?;
    let owner = owns_survey(&person, &survey);
    let all = rows_of_responses(&instrument, &submitted);
    let all: Vec<&ResponseRow<'_>> = all.iter().collect();
    let visible = ResponseGroups::new(&all, |row| Some(row.role.to_owned()), owner).all();
    let tags = stored::tags(reader, &survey).await?;
    let metric = METRICS.iter().find(|(word, _)| *word == choice.metric).unwrap_or(&METRICS[0]).0;
    let figures = stored::attempts(reader, &survey, metric).await?;
    Ok(ResultsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Surveys),
        asked: count_asked(&state, &survey).await?,
        results: Results::new(&instrument, &all, owner),
        split: split_scores(&instrument, &visible, &choice.by, owner),
        against: scatter_scores(&instrument, &visible, metric, &figures),
        comments: comment_blocks(&instrument, &submitted, &visible, &tags, owner),
        tags: if owner { count_themes(&tags) } else { Vec::new() },
        survey: (survey.title.clone(), format!("/surveys/{id}")),
        instrument: survey.instrument.clone(),
        identity: survey.identity,
        generated: survey.generated,
        owner,
    })
}

async fn count_asked(state: &AppState, survey: &Survey) -> Result<Vec<AskedLine>, Error> {
    let counts = stored::counts(state.db.reader(), survey, state.clock.now()).await?;
    let mut lines = Vec::new();
    if counts.links > 0 {
        lines.push(AskedLine {
            who: tr!("Professionals, by link"),
            asked: counts.links,
            answered: counts.links_answered,
        });
    }
    if survey.after_attempts {
        lines.push(AskedLine {
            who: tr!("After an attempt"),
            asked: counts.attempts,
            answered: counts.people_answered,
        });
    } else if counts.people > 0 || counts.people_answered > 0 {
        lines.push(AskedLine {
            who: tr!("Trainees of its cohorts"),
            asked: counts.people,
            answered: counts.people_answered,
        });
    }
    Ok(lines)
}

fn split_scores(instrument: &Instrument, rows: &[&ResponseRow<'_>], by: &str, owner: bool) -> SplitScores {
    let chosen = WAYS.iter().find(|(word, _)| *word == by).unwrap_or(&WAYS[0]).0;
    let name = |row: &ResponseRow<'_>| match chosen {
        "exercise" => row.attempt[0].map(str::to_owned),
        "device" => row.attempt[1].map(str::to_owned),
        "simulator" => row.attempt[2].map(str::to_owned),
        _ => Some(row.month.clone()),
    };
    // Roles are never pooled, so each group contains responses of one role.
    let groups =
        ResponseGroups::new(rows, |row| name(row).map(|name| format!("{name} · {}", words::known(row.role))), owner);
    let score = |(at, key): (usize, &documents::instrument::ScoreKey)| {
        let (least, greatest) = assessment::questionnaire::score_range(instrument, key);
        SplitScore {
            title: key.title.in_language(words::current().code()).to_owned(),
            range: Extent::new(least, greatest),
            groups: groups.shown.iter().map(|(name, rows)| score_group(name, rows, at)).collect(),
        }
    };
    SplitScores {
        ways: WAYS.iter().map(|(word, title)| (*word, words::say(title), *word == chosen)).collect(),
        scores: instrument.scores.iter().enumerate().map(score).collect(),
        hidden: groups.hidden,
    }
}

fn scatter_scores(
    instrument: &Instrument,
    rows: &[&ResponseRow<'_>],
    metric: &str,
    figures: &[stored::ResponseMetric],
) -> ScatteredScores {
    let by_response: BTreeMap<ResponseId, f64> =
        figures.iter().map(|figure| (figure.response_id, figure.value)).collect();
    let score = |(at, key): (usize, &documents::instrument::ScoreKey)| {
        let pair = |row: &&ResponseRow<'_>| Some((*by_response.get(&row.id)?, row.scores[at]?));
        let points: Vec<(f64, f64)> = rows.iter().filter_map(pair).collect();
        ScatteredScore {
            title: key.title.in_language(words::current().code()).to_owned(),
            rho: correlation(&points),
            points: if points.len() >= LEAST { points } else { Vec::new() },
        }
    };
    let scores =
        if figures.is_empty() { Vec::new() } else { instrument.scores.iter().enumerate().map(score).collect() };
    ScatteredScores { metrics: METRICS.iter().map(|(word, title)| (*word, *title, *word == metric)).collect(), scores }
}

fn comment_blocks(
    instrument: &Instrument,
    submitted: &[SubmittedResponse],
    visible: &[&ResponseRow<'_>],
    tags: &[Tag],
    owner: bool,
) -> Vec<CommentBlock> {
    let seen: BTreeMap<ResponseId, ()> = visible.iter().map(|row| (row.id, ())).collect();
    let texts = instrument.items.iter().enumerate();
    let texts = texts.filter(|(_, item)| matches!(instrument.scale(item), Some(ScaleKind::Text { .. })));
    let block = |(at, item): (usize, &documents::instrument::Item)| {
        let given = submitted.iter().filter(|given| seen.contains_key(&given.id));
        let comment = |given: &SubmittedResponse| match given.answers.0.get(at) {
            Some(Some(Answer::Text(text))) => Some(make_comment(given, &item.id, text, tags, owner)),
            _ => None,
        };
        let found: Vec<SurveyComment> = given.filter_map(comment).take(MOST_COMMENTS).collect();
        CommentBlock {
            item: item.id.clone(),
            text: item.text.in_language(words::current().code()).to_owned(),
            comments: (owner || found.len() >= LEAST).then_some(found),
        }
    };
    texts.map(block).collect()
}

fn make_comment(given: &SubmittedResponse, item: &str, text: &str, tags: &[Tag], owner: bool) -> SurveyComment {
    let own = tags.iter().filter(|tag| tag.response_id == given.id && tag.item_id == item);
    let who = given.who.as_ref().filter(|_| owner).map_or_else(String::new, |who| format!(" · {who}"));
    SurveyComment {
        response: given.id.to_string(),
        who: format!("{}{who}", given.role),
        text: text.to_owned(),
        tags: own.map(|tag| tag.tag.clone()).collect(),
    }
}

fn count_themes(tags: &[Tag]) -> Vec<(String, usize)> {
    let mut counted: BTreeMap<&str, usize> = BTreeMap::new();
    for tag in tags {
        *counted.entry(&tag.tag).or_default() += 1;
    }
    counted.into_iter().map(|(tag, n)| (tag.to_owned(), n)).collect()
}

#[derive(Deserialize)]
pub(super) struct TagForm {
    response: ResponseId,
    item: String,
    tag: String,
    #[serde(rename = "do", default)]
    step: String,
}

/// Adds a theme to a comment, or removes it.
pub(super) async fn tag_comment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SurveyId>,
    CsrfForm(form): CsrfForm<TagForm>,
) -> Result<Response, PageError> {
    let survey = find_school_survey(&state, &person, id).await?;
    if !owns_survey(&person, &survey) {
        return Err(Error::Forbidden(tr!("only the owner of the survey can assign themes")).into());
    }
    let tag = form.tag.trim().to_lowercase();
    let length = tag.chars().count();
    if let Some(why) = single_line_text::refusal(tr!("theme"), &tag) {
        return Err(Error::BadRequest(why).into());
    }
    if !(1..=60).contains(&length) {
        return Err(Error::BadRequest(tr!("theme: {length} characters; allowed: 1 to 60", length = length)).into());
    }
    let _place = (form.response, form.item.as_str());
    let theme = Theme { response: form.response, item: &form.item, tag: &tag };
    surveys::set_theme(&state, &person, &survey, theme, form.step != "remove").await?;
    Ok((StatusCode::SEE_OTHER, Redirect::to(&format!("/surveys/{id}/results#comments"))).into_response())
}
