//! `/trainees/{id}/transcript`: a printable record of a trainee's work.

use acts::error::Error;
use axum::extract::State;
use model::ids::PersonId;
use pages::training::transcript::{TranscriptCourse, TranscriptPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use store::operations::schools;
use store::people;
use store::training::{practice, reports};

use super::standing;

pub(super) async fn show_transcript(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<TranscriptPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let trainee = reports::trainee(reader, &person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(&state, school).await?;
    let attempts = practice::list_trainee_practice(reader, school, id).await?;
    let progress = standing::progress_in_courses(&courses, &attempts, &state);
    let line = |(at, progress): &(usize, _)| TranscriptCourse::new(&courses[*at].title, &courses[*at].course, progress);
    let own = trainee.id == person.id;
    Ok(TranscriptPage {
        shell: Shell::new(&person, csrf.token(), if own { NavPlace::Home } else { NavPlace::Cohorts }),
        trainee: (trainee.name, if own { "/".to_owned() } else { format!("/trainees/{id}") }),
        school: schools::find_school_name(reader, school).await?,
        registrar_id: people::find_registrar_id(reader, school, id).await?,
        courses: progress.iter().map(line).collect(),
        made_at: state.clock.now().to_utc(),
    })
}
