//! `/ratings`: rating rounds and their results.

use acts::error::Error;
use acts::letters::notices;
use acts::scoring::ratings;
use acts::surveys;
use assessment::questionnaire::{Answer, score_response};
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use documents::Instrument;
use model::ids::{PersonId, RatingId, RoundId, SessionId};
use model::letters::notice::NoticePlace;
use model::scoring::rating::{RatingAnswers, tables};
use model::{CurrentPerson, Moment, Role};
use pages::scoring::rating::{OwnRating, RatedAttemptRow, RaterRow, RatingsPage, RoundPage, RoundRow, ScoreView};
use pages::{NavPlace, Shell, format};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher};
use routes_base::error::PageError;
use routes_base::export::CsvCell as Column;
use routes_base::{AppState, Routes, export, get, post};
use store::scoring::ratings as stored;
use store::scoring::ratings::{Rating, RatingCell, Round};

pub(super) mod make;
pub(super) mod rate;

pub(crate) fn rating_routes() -> Routes {
    Routes::new()
        .route("/ratings", get(list_ratings).merge(post(make::make_round)))
        .route("/ratings/new", get(make::show_new_round))
        .route("/ratings/{id}", get(show_round))
        .route("/ratings/{id}/ratings.csv", get(export_round))
        .route("/ratings/{id}/withdraw", post(withdraw_round))
        .route("/rate/{id}", get(rate::show_rating).merge(post(rate::act_on_rating)))
}

async fn list_ratings(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<RatingsPage, PageError> {
    let rounds = stored::all(state.db.reader(), &person).await?;
    let row = |round: Round| RoundRow {
        href: round_href(round.id),
        made_at: round.made_at.to_utc(),
        finished: (round.finished, round.ratings),
        own: (round.own - round.own_open, round.own),
        title: round.title,
        instrument: round.instrument,
        by: round.by,
        generated: round.generated,
    };
    let shell = Shell::new(&person, csrf.token(), NavPlace::Review);
    Ok(RatingsPage { shell, rounds: rounds.into_iter().map(row).collect() })
}

pub(super) fn round_href(round: RoundId) -> String {
    format!("/ratings/{round}")
}

/// Returns a round that the visitor owns or takes part in.
async fn find_round(state: &AppState, person: &CurrentPerson, id: RoundId) -> Result<Round, Error> {
    stored::find(state.db.reader(), person, id).await?.ok_or(Error::NotFound)
}

/// Whether the visitor is in charge of a round; all others who take part are only raters.
fn owns_round(person: &CurrentPerson, round: &Round) -> bool {
    person.role == Role::Administrator || round.made_by == person.id
}

fn own_ratings(ratings: &[Rating], current: Option<RatingId>) -> Vec<OwnRating> {
    let own = |rating: &Rating| OwnRating {
        href: format!("/rate/{}", rating.id),
        current: Some(rating.id) == current,
        finished: rating.finished_at.is_some(),
    };
    ratings.iter().map(own).collect()
}

async fn show_round(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RoundId>,
    csrf: Csrf,
) -> Result<RoundPage, PageError> {
    let round = find_round(&state, &person, id).await?;
    let person = notices::note_read(&state, person, NoticePlace::Round(id)).await?;
    let owner = owns_round(&person, &round);
    let cells = stored::cells(state.db.reader(), &person, &round).await?;
    let table = RatingsTable::of(&cells);
    // Raters with open ratings do not see the ratings of others; the progress of the raters is
    // shown to the owner only.
    let found = if round.own_open == 0 {
        let instrument_of_round = instrument_of_round(&state, &round).await?;
        let scores = tables(&instrument_of_round, &table.attempts, &table.raters, &table.given);
        Some((table.rows(&cells, owner), scores.into_iter().map(ScoreView::new).collect()))
    } else {
        None
    };
    let own = stored::own(state.db.reader(), &person, id).await?;
    Ok(RoundPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Review),
        href: round_href(id),
        instrument: round.instrument,
        title: round.title,
        by: round.by,
        made_at: round.made_at.to_utc(),
        generated: round.generated,
        owner,
        own: own_ratings(&own, None),
        raters: if owner || found.is_some() { table.progress(&cells) } else { Vec::new() },
        found,
    })
}

async fn instrument_of_round(state: &AppState, round: &Round) -> Result<Instrument, Error> {
    surveys::revision(state, round.school_id, round.revision_id).await?.ok_or(Error::NotFound)
}

/// Ratings by attempt and rater, in the order of the query.
struct RatingsTable<'a> {
    attempts: Vec<SessionId>,
    raters: Vec<PersonId>,
    given: Vec<RatingAnswers<'a>>,
}

impl<'a> RatingsTable<'a> {
    fn of(cells: &'a [RatingCell]) -> Self {
        let mut table = Self { attempts: Vec::new(), raters: Vec::new(), given: Vec::new() };
        for cell in cells {
            if table.attempts.last() != Some(&cell.session_id) {
                table.attempts.push(cell.session_id);
            }
            if !table.raters.contains(&cell.rater_id) {
                table.raters.push(cell.rater_id);
            }
            let answers = cell.finished_at.map(|_| &cell.answers[..]);
            table.given.push(RatingAnswers { session: cell.session_id, rater: cell.rater_id, answers });
        }
        table
    }

    fn progress(&self, cells: &[RatingCell]) -> Vec<RaterRow> {
        let row = |rater: &PersonId| {
            let own = || cells.iter().filter(|cell| cell.rater_id == *rater);
            RaterRow {
                name: own().next().map_or_else(String::new, |cell| cell.rater.clone()),
                finished: own().filter(|cell| cell.finished_at.is_some()).count(),
                may_know: own().filter(|cell| cell.may_know).count(),
                of: own().count(),
            }
        };
        self.raters.iter().map(row).collect()
    }

    fn rows(&self, cells: &[RatingCell], owner: bool) -> Vec<RatedAttemptRow> {
        let row = |attempt: &SessionId| {
            let cell = cells.iter().find(|cell| cell.session_id == *attempt)?;
            let link = |name: &String| (name.clone(), format!("/sessions/{attempt}/grade"));
            Some(RatedAttemptRow {
                trainee: cell.trainee.as_ref().map(link),
                exercise: cell.exercise.clone(),
                started_at: known_ratings(owner, cell).then(|| cell.started_at.to_utc()),
            })
        };
        self.attempts.iter().filter_map(row).collect()
    }
}

/// Whether the visitor may know the attempt of a rating: they own the round, or may see the trainee
/// anyway.
fn known_ratings(owner: bool, cell: &RatingCell) -> bool {
    owner || cell.trainee.is_some()
}

/// Exports a row for each rating, with every answer and score.
async fn export_round(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RoundId>,
) -> Result<Response, PageError> {
    let round = find_round(&state, &person, id).await?;
    if round.own_open > 0 {
        let why = tr!("you see the other ratings when you have finished your own");
        return Err(Error::Conflict(why.to_owned()).into());
    }
    let instrument = instrument_of_round(&state, &round).await?;
    let cells = stored::cells(state.db.reader(), &person, &round).await?;
    let items = instrument.items.iter().map(|item| item.id.as_str());
    let scores = instrument.scores.iter().map(|key| key.id.as_str());
    let names: Vec<&str> = ["attempt", "trainee", "exercise", "started_at", "rater", "finished_at"]
        .into_iter()
        .chain(items)
        .chain(scores)
        .chain(["trainee_id", "pseudonym", "rater_id", "may_know"])
        .collect();
    let (table, owner) = (RatingsTable::of(&cells), owns_round(&person, &round));
    let place =
        |cell: &RatingCell| table.attempts.iter().position(|attempt| *attempt == cell.session_id).unwrap_or(0) + 1;
    let shown = |cell: &RatingCell| known_ratings(owner, cell).then_some(cell.started_at).ok_or_else(|| place(cell));
    let rows: Vec<Vec<Column>> = cells.iter().map(|cell| line_of_rating(&instrument, cell, shown(cell))).collect();
    Ok(export::download_csv(&round.title, &names, &rows).map_err(Error::from)?)
}

/// Formats a rating as a row; an attempt that must stay anonymous is given by its position in the
/// round only.
fn line_of_rating(instrument: &Instrument, cell: &RatingCell, shown: Result<Moment, usize>) -> Vec<Column> {
    let time = |at: Moment| format::format_machine_time(at.to_utc());
    let mut line = vec![
        Column::from(shown.map_or_else(|place| place.to_string(), |_| cell.session_id.to_string())),
        cell.trainee.as_ref().map_or(Column::Empty, |name| Column::from(name.as_str())),
        Column::from(cell.exercise.as_str()),
        shown.map_or(Column::Empty, |at| Column::from(time(at))),
        Column::from(cell.rater.as_str()),
        cell.finished_at.map_or(Column::Empty, |at| Column::from(time(at))),
    ];
    let finished = cell.finished_at.is_some();
    let answer = |at: usize| match cell.answers.get(at)?.as_ref().filter(|_| finished)? {
        Answer::Number(number) => Some(Column::from(*number)),
        Answer::Text(text) => Some(Column::from(text.as_str())),
        Answer::Several(ids) => Some(Column::from(ids.join(" "))),
    };
    line.extend((0..instrument.items.len()).map(|at| answer(at).unwrap_or(Column::Empty)));
    let scored = |key| score_response(instrument, key, &cell.answers).ok().filter(|_| finished);
    line.extend(instrument.scores.iter().map(|key| Column::from(scored(key))));
    // Names are not unique.
    line.push(cell.trainee_id.map_or(Column::Empty, |id| Column::from(id.to_string())));
    line.push(cell.pseudonym.as_deref().map_or(Column::Empty, Column::from));
    line.push(Column::from(cell.rater_id.to_string()));
    line.push(Column::from(cell.may_know));
    line
}

async fn withdraw_round(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RoundId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let round = find_round(&state, &person, id).await?;
    if !owns_round(&person, &round) {
        return Err(Error::Forbidden(tr!("a round can be withdrawn only by the person who requested it")).into());
    }
    ratings::withdraw(&state, &person, &round).await?;
    Ok(Redirect::to("/ratings").into_response())
}
