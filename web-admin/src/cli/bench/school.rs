//! The school that pages are measured on: the demonstration, a generated crowd, and a survey with many answers.

use std::fmt::Write;
use std::path::Path;

use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::Instrument;
use sqlx::types::Json;
use uuid::Uuid;

use super::PASSWORD;
use super::doors::{self, Doors};
use crate::AppState;
use crate::demo::school::{ADMINISTRATOR, email};
use crate::demo::{self, Demonstration};
use crate::routes;
use acts::clock::Clock;
use acts::config::Config;
use acts::secret;
use acts::surveys;
use model::survey::{Identity, ResponseState};
use store::audit::Actor;
use store::people;
use store::surveys::{self as stored, NewResponse, NewSurvey, Response, Submission};
use store::{Write as Transaction, instruments};

/// Responses to the survey.
pub(super) const RESPONSES: usize = 5_000;
/// Items of its instrument.
pub(super) const ITEMS: usize = 30;

/// Title of the survey.
pub(super) const TITLE: &str = "Generated answers";

/// A school that is ready to be served.
pub(super) struct School {
    /// Every route that the service answers.
    pub routes: Vec<String>,
    /// The page of the survey with many answers.
    pub survey: String,
    /// Where the tour begins, beside everybody's home.
    pub doors: Doors,
}

/// Makes the school in a folder, or takes the one that is there.
pub(super) async fn prepare(folder: &Path, trainees: u32) -> anyhow::Result<School> {
    if !folder.exists() {
        make(folder, trainees).await?;
    }
    let state = AppState::open(Config::in_folder(folder), Clock::system()).await?;
    let administrator = administrator(&state).await?;
    let surveys = stored::all(state.db.reader(), administrator.school_id).await?;
    let survey = surveys.iter().find(|survey| survey.title == TITLE).context("a survey that was made here")?;
    let survey = format!("/surveys/{}", survey.id);
    let administrator = administrator.into_current().context("an administrator who can sign in")?;
    let doors = doors::open(&state, &administrator).await?;
    let school = School { routes: routes::routes(&state).paths(), survey, doors };
    state.db.close().await;
    Ok(school)
}

async fn administrator(state: &AppState) -> anyhow::Result<people::Person> {
    let found = people::by_email(state.db.reader(), &email(ADMINISTRATOR)).await?;
    found.context("a demonstration has an administrator")
}

async fn make(folder: &Path, trainees: u32) -> anyhow::Result<()> {
    // Whole or not at all: one that was interrupted is begun anew.
    let unfinished = folder.with_extension("unfinished");
    if unfinished.exists() {
        std::fs::remove_dir_all(&unfinished)?;
    }
    let state = AppState::open(Config::in_folder(&unfinished), Clock::system()).await?;
    let wanted = Demonstration { weeks: 1, password: PASSWORD.to_owned(), seed: 1, crowd: trainees };
    demo::make(&state, &wanted).await?;
    let owner = administrator(&state).await?;
    let mut tx = state.db.write().await?;
    ask(&state, &mut tx, &owner).await?;
    tx.commit().await?;
    state.db.close().await;
    std::fs::rename(&unfinished, folder).context("the finished school cannot be given its name")
}

/// An instrument of thirty items in three scores.
fn document() -> String {
    let mut text = String::from(
        "id = \"long\"\ntitle = { en = \"Long\" }\nlanguages = [\"en\"]\nduration_min = 5\nsource = \"generated\"\n\
         licence = \"any\"\n[[scale]]\nid = \"agree\"\nkind = \"likert\"\npoints = 5\n",
    );
    for item in 0..ITEMS {
        // Writing to a text cannot fail.
        let _ = write!(text, "[[item]]\nid = \"q{item}\"\ntext = {{ en = \"Question {item}\" }}\nscale = \"agree\"\n");
    }
    for score in 0..3 {
        let items: Vec<String> = (0..ITEMS / 3).map(|n| format!("\"q{}\"", score * (ITEMS / 3) + n)).collect();
        let items = items.join(", ");
        let head = format!("[[score]]\nid = \"s{score}\"\ntitle = {{ en = \"Score {score}\" }}\n");
        let _ = write!(text, "{head}items = [{items}]\ncombine = \"mean\"\n");
    }
    text
}

/// A survey of the administrator's, and its answers.
async fn ask(state: &AppState, tx: &mut Transaction, owner: &people::Person) -> anyhow::Result<()> {
    let (now, text, school_id) = (state.clock.now(), document(), owner.school_id);
    let instrument = Instrument::from_bytes("long", text.as_bytes())?;
    let published = (&instrument, text.as_bytes());
    surveys::publish_text(tx, school_id, published, (Actor::CommandLine, now)).await?;
    let revision = instruments::current(&mut **tx, school_id, "long").await?.context("what was just published")?;
    let new = NewSurvey {
        school_id,
        revision_id: revision.id,
        title: TITLE,
        owner_id: Some(owner.id),
        identity: Identity::Anonymous,
        after_attempts: false,
        generated: true,
        opens_at: now,
        closes_at: None,
    };
    let survey_id = stored::insert(tx, &new, now).await?;
    for place in 0..RESPONSES {
        answer(state, tx, (school_id, survey_id), place).await?;
    }
    Ok(())
}

async fn answer(
    state: &AppState,
    tx: &mut Transaction,
    (school_id, survey_id): (Uuid, Uuid),
    place: usize,
) -> anyhow::Result<()> {
    let now = state.clock.now();
    let new = NewResponse {
        school_id,
        survey_id,
        token_sha256: secret::token_sha256(&format!("generated {place}")),
        role: if place.is_multiple_of(2) { "professional" } else { "trainee" },
        label: None,
        person_id: None,
        session_id: None,
        language: "en",
        consented_at: Some(now),
        expires_at: None,
    };
    let point = |item: usize| Some(Answer::Number(((place * 7 + item * place) % 5 + 1) as f64));
    let response = Response {
        id: stored::add(tx, &new).await?,
        school_id,
        survey_id,
        state: ResponseState::Begun,
        person_id: None,
        session_id: None,
        language: "en".to_owned(),
        answers: Json((0..ITEMS).map(point).collect()),
        expires_at: None,
    };
    stored::put_answers(tx, &response, now).await?;
    stored::submit(tx, Submission { response: &response, identity: Identity::Anonymous, at: now }).await?;
    Ok(())
}
