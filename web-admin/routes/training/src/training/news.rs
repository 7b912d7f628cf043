//! News for the visitor.

use acts::error::Error;
use acts::letters::notices as told;
use axum::extract::State;
use axum::response::Redirect;
use model::letters::notice::NoticePlace;
use model::{CurrentPerson, Role};
use pages::letters::news::{NewsItem, say_waiting_ratings};
use routes_base::AppState;
use routes_base::auth::{CsrfForm, NoFields, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::letters::notices;
use store::scoring::ratings;
use store::{studies, surveys};

/// Maximum number of news items on the home page.
const SHOWN: u32 = 20;

/// Returns the news for the visitor, newest first.
pub(crate) async fn list_news(state: &AppState, person: &CurrentPerson) -> Result<Vec<NewsItem>, Error> {
    let reader = state.db.reader();
    let asked = studies::list_study_requests(reader, person.into()).await?;
    let mut items: Vec<NewsItem> =
        asked.iter().map(|study| NewsItem::of_study(&study.owner, &study.title, study.created_at.to_utc())).collect();
    if person.role == Role::Trainee {
        for survey in surveys::of_person(reader, person.school_id, person.id, state.clock.now()).await? {
            if !surveys::answered(reader, &survey, person.id, None).await? {
                items.push(NewsItem::of_survey(&survey));
            }
        }
    } else {
        let rounds = ratings::all(reader, person).await?;
        items.extend(rounds.iter().filter(|round| round.own_open > 0).map(|round| NewsItem {
            words: say_waiting_ratings(&round.by, &round.title, round.own_open),
            href: format!("/ratings/{}", round.id),
            at: round.made_at.to_utc(),
        }));
    }
    if person.news > 0 {
        items.extend(NewsItem::list(&notices::list_unread_notices(reader, person.into(), SHOWN).await?));
    }
    Ok(items)
}

/// Marks all news as read.
pub(crate) async fn mark_all_read(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    told::note_read(&state, person, NoticePlace::Everywhere).await?;
    Ok(Redirect::to("/"))
}

#[derive(Debug, Deserialize)]
#[serde(default)]
#[derive(Default)]
pub(crate) struct NewsLetterForm {
    #[serde(deserialize_with = "pages::form::read_ticked_box")]
    mailed: bool,
}

/// Sets whether the visitor receives news by mail.
pub(crate) async fn choose_letters(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(form): CsrfForm<NewsLetterForm>,
) -> Result<Redirect, PageError> {
    told::choose_news_letters(&state, &person, form.mailed).await?;
    Ok(Redirect::to("/account#news"))
}
