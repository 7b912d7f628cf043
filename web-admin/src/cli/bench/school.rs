//! The school on which pages are measured: the demonstration, a generated crowd, and a survey with
//! many answers.

use std::fmt::Write;

use acts::operations::fixtures;
use acts::operations::fixtures::GeneratedSurvey;
use acts::replicas;
use anyhow::Context;
use platform::clock::Clock;
use platform::config::Config;
use store::people;
use store::surveys::{self as stored};

use super::PASSWORD;
use super::doors::{self, Doors};
use crate::demo::school::{ADMINISTRATOR, email_of};
use crate::demo::{self, Demonstration};
use crate::{AppState, routes};

/// Number of responses to the survey.
pub(super) const RESPONSES: usize = 5_000;
/// Number of items of its instrument.
pub(super) const ITEMS: usize = 30;

/// Title of the survey.
pub(super) const TITLE: &str = "Generated answers";

/// A school that is ready to be served.
pub(super) struct BenchSchool {
    /// Every route of the service.
    pub routes: Vec<String>,
    /// Path of the survey with many answers.
    pub survey: String,
    /// Starting addresses of the tour, in addition to the home page.
    pub doors: Doors,
    /// Name and version of its database engine.
    pub engine: String,
    /// Size of its database, in bytes.
    pub database_bytes: i64,
}

/// Creates the school, or opens an existing one.
pub(super) async fn prepare_school(config: &Config, trainees: u32) -> anyhow::Result<BenchSchool> {
    if !config.data_dir.exists() {
        make_crowd(config, trainees).await?;
    }
    let state = AppState::open(config.clone(), Clock::system()).await?;
    let administrator = find_administrator(&state).await?;
    let surveys = stored::all(state.db.reader(), administrator.school_id).await?;
    let survey = surveys.iter().find(|survey| survey.title == TITLE).context("a survey that was made here")?;
    let survey = format!("/surveys/{}", survey.id);
    let administrator = administrator.into_current().context("an administrator who can sign in")?;
    let doors = doors::open_doors(&state, &administrator).await?;
    let routes = routes::all_routes(&state).paths();
    let (engine, database_bytes) = (state.db.engine_version().await?, state.db.size().await?);
    let school = BenchSchool { routes, survey, doors, engine, database_bytes };
    // Flushes the generated data: written back during the measurement, it would delay responses by
    // up to half a second.
    state.db.settle().await?;
    replicas::leave(&state).await?;
    state.db.close().await;
    Ok(school)
}

async fn find_administrator(state: &AppState) -> anyhow::Result<people::Person> {
    let found = people::find_person_by_email(state.db.reader(), &email_of(ADMINISTRATOR)).await?;
    found.context("a demonstration has an administrator")
}

async fn make_crowd(config: &Config, trainees: u32) -> anyhow::Result<()> {
    // All or nothing: an interrupted run is started over.
    let unfinished = config.data_dir.with_extension("unfinished");
    if unfinished.exists() {
        std::fs::remove_dir_all(&unfinished)?;
    }
    config.database.make_anew().await?;
    let made_in = Config { database: config.database.clone(), ..Config::in_folder(&unfinished) };
    let state = AppState::open(made_in, Clock::system()).await?;
    let wanted = Demonstration { weeks: 1, password: PASSWORD.to_owned(), seed: 1, crowd: trainees };
    demo::make_demonstration(&state, &wanted).await?;
    let owner = find_administrator(&state).await?;
    let survey =
        GeneratedSurvey { owner: &owner, title: TITLE, document: &instrument_document(), responses: RESPONSES };
    fixtures::ask_nobody(&state, survey).await?;
    replicas::leave(&state).await?;
    state.db.close().await;
    std::fs::rename(&unfinished, &config.data_dir).context("the finished school cannot be given its name")
}

/// Returns an instrument of thirty items in three scores.
fn instrument_document() -> String {
    let mut text = String::from(
        "id = \"long\"\ntitle = { en = \"Long\" }\nlanguages = [\"en\"]\nduration_min = 5\nsource = \"generated\"\n\
         licence = \"any\"\n[[scale]]\nid = \"agree\"\nkind = \"likert\"\npoints = 5\n",
    );
    for item in 0..ITEMS {
        // Writing to a `String` cannot fail.
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
