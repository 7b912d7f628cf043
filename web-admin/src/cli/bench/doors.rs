//! Pages that no link leads to, or that exist only after an action. They are created anew for each
//! measurement, since some expire after a day.

use acts::authoring::drafting;
use acts::people::{accounts, roster_import};
use acts::scoring::{ratings, regrading};
use acts::surveys;
use anyhow::Context;
use model::CurrentPerson;
use model::people::roster::RosterRequest;
use model::surveys::Survey;
use store::auth::account_links::Purpose;
use store::authoring::exercises;
use store::operations::fixtures;
use store::scoring::ratings::NewRound;
use store::surveys::instruments;
use store::training::reports;
use store::{people, surveys as asked};

use super::school;
use crate::demo::school::{COHORTS, email_of};
use crate::{AppState, worker};

/// Rows of the roster, the size of a cohort.
const LINES: u32 = 30;
/// Paths that a visitor can open without signing in and without a link.
const OPEN: [&str; 5] = ["/login", "/forgotten", "/metrics", "/healthz", "/readyz"];

/// Paths at which the tour starts, in addition to the home page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Doors {
    /// For the administrator.
    pub administrator: Vec<String>,
    /// For the first instructor of the generated crowd.
    pub instructor: Vec<String>,
    /// For a visitor who is not signed in.
    pub stranger: Vec<String>,
}

/// Creates a draft, a dry run of a roster import, a re-grading of one exercise for the instructor's
/// trainees, an open rating round, an invitation to set a password, and a survey link.
pub(super) async fn open_doors(state: &AppState, administrator: &CurrentPerson) -> anyhow::Result<Doors> {
    let mut doors = Doors { stranger: OPEN.map(str::to_owned).to_vec(), ..Doors::default() };
    let instructor = find_person(state, &fixtures::instructor_email(0)).await?;
    let exercises = exercises::list_current_exercises(state.db.reader(), administrator.school_id).await?;
    let exercise = exercises.first().context("an exercise")?;
    let draft = drafting::open_exercise(state, administrator, &exercise.exercise_id).await?;
    let roster = write_roster();
    let wanted = RosterRequest { cohort: None, remove_missing: true, ..RosterRequest::default() };
    let roster = roster_import::keep(state, administrator, "roster.csv", roster.as_bytes(), &wanted).await?;
    doors.administrator = vec![format!("/drafts/{draft}"), format!("/people/rosters/{roster}")];
    let regrading = regrading::exercise::look(state, &instructor, &exercise.exercise_id, exercise.id).await?;
    worker::work_off_jobs(state).await?;
    let round = open_rating_round(state, &instructor).await?;
    doors.instructor = vec![format!("/drafts/{draft}"), format!("/regradings/{regrading}"), round];
    doors
        .stranger
        .extend([make_invitation(state, administrator).await?, make_survey_link(state, administrator).await?]);
    Ok(doors)
}

async fn find_person(state: &AppState, email: &str) -> anyhow::Result<CurrentPerson> {
    let found = people::find_person_by_email(state.db.reader(), email).await?;
    found.and_then(people::Person::into_current).with_context(|| format!("{email} can sign in"))
}

/// Returns the roster of the crowd's first cohort, with one trainee renamed.
fn write_roster() -> String {
    let line = |place: u32| {
        let name = if place == 0 { "Another Name".to_owned() } else { format!("Generated {place:05}") };
        format!("{},{name},Generated 000\n", fixtures::trainee_email(place))
    };
    "email,name,cohort\n".to_owned() + &(0..LINES).map(line).collect::<String>()
}

/// Opens a round in which the instructor and a second rater rate the latest attempts of the
/// instructor's trainees.
async fn open_rating_round(state: &AppState, instructor: &CurrentPerson) -> anyhow::Result<String> {
    let reader = state.db.reader();
    let instrument =
        instruments::find_current_instrument(reader, instructor.school_id, "global-rating-puncture").await?;
    let latest = reports::latest_taught(reader, instructor).await?;
    let other = find_person(state, &email_of(COHORTS[0].instructor)).await?;
    let new = NewRound {
        revision_id: instrument.context("the instrument that raters use")?.id,
        title: "Attempts to rate".to_owned(),
        generated: true,
        sessions: latest.iter().map(|attempt| attempt.id).collect(),
        raters: vec![instructor.id, other.id],
    };
    Ok(format!("/ratings/{}", ratings::make(state, instructor, &new).await?))
}

/// Creates a password link that is never followed, and returns its path.
async fn make_invitation(state: &AppState, administrator: &CurrentPerson) -> anyhow::Result<String> {
    let address = accounts::make_link(state, administrator.into(), Purpose::Reset).await?;
    Ok(address.strip_prefix(state.config.address().as_str()).unwrap_or(&address).to_owned())
}

/// Returns the path of the form of the survey with many answers.
async fn make_survey_link(state: &AppState, administrator: &CurrentPerson) -> anyhow::Result<String> {
    let all: Vec<Survey> = asked::all(state.db.reader(), administrator.school_id).await?;
    let survey = all.iter().find(|survey| survey.title == school::TITLE).context("a survey that was made here")?;
    let links = surveys::make_links(state, administrator, survey, &["a professional".to_owned()]).await?;
    Ok(format!("/survey/{}", links.first().context("a link")?.token))
}
