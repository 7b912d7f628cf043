//! `/account/calendar`: the address of one's calendar. `/calendar/{secret}.ics`: the calendar, without
//! cookies.

use acts::error::Error;
use acts::training::calendar_feeds;
use acts::training::calendar_feeds::{DueItem, DueKind};
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG};
use axum::response::{IntoResponse, Redirect, Response};
use model::PersonKey;
use model::training::calendar::{CalendarEvent, write_calendar};
use pages::training::calendar_feed::CalendarFeedPage;
use pages::{NavPlace, Shell};
use routes_base::auth::{ClientAddress, Csrf, CsrfForm, NoFields, Visitor};
use routes_base::caching::answer_not_modified;
use routes_base::error::{ApiError, PageError};
use routes_base::{AppState, Routes, get, post};
use store::training::calendar_feeds as stored;
use words::Language;

/// A revoked address must end at the next request.
const ASK_AGAIN: &str = "private, no-cache";

/// Returns the routes for signed-in people.
pub(super) fn own_calendar_routes() -> Routes {
    Routes::new()
        .route("/account/calendar", get(show_calendar_feed).merge(post(make_calendar_feed)))
        .route("/account/calendar/revoke", post(revoke_calendar_feed))
}

/// Returns the route of calendars.
pub(crate) fn calendar_routes() -> Routes {
    Routes::new().route("/calendar/{file}", get(serve_calendar))
}

async fn show_calendar_feed(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<CalendarFeedPage, PageError> {
    let made_at = stored::find_feed_time(state.db.reader(), (&person).into()).await?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Account);
    Ok(CalendarFeedPage { shell, made_at: made_at.map(|at| at.to_utc()), address: None })
}

/// Creates an address and renders it directly: with a redirect it would have to be stored until it
/// is shown.
async fn make_calendar_feed(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<CalendarFeedPage, PageError> {
    let secret = calendar_feeds::make_feed(&state, &person).await?;
    Ok(CalendarFeedPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Account),
        made_at: Some(state.clock.now().to_utc()),
        address: Some(format!("{}/calendar/{secret}.ics", state.config.address())),
    })
}

async fn revoke_calendar_feed(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    calendar_feeds::revoke_feed(&state, &person).await?;
    Ok(Redirect::to("/account/calendar"))
}

async fn serve_calendar(
    State(state): State<AppState>,
    ClientAddress(address): ClientAddress,
    Path(file): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let secret = file.strip_suffix(".ics").ok_or(Error::NotFound)?;
    let owner = calendar_feeds::find_owner(&state, address, secret).await?;
    let key = PersonKey { school_id: owner.school_id, person_id: owner.person_id };
    let items = calendar_feeds::list_due_items(&state, key).await?;
    let language = owner.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    let calendar = words::within(language, || {
        let events: Vec<CalendarEvent> =
            items.iter().map(|item| event_of(item, key, &state.config.address())).collect();
        write_calendar(&tr!("Due dates at {school}", school = owner.school), &events)
    });
    let tag = calendar_feeds::entity_tag(&calendar);
    if let Some(answer) = answer_not_modified(&headers, &tag, ASK_AGAIN) {
        return Ok(answer);
    }
    let headers = [(ETAG, tag.as_str()), (CACHE_CONTROL, ASK_AGAIN), (CONTENT_TYPE, "text/calendar; charset=utf-8")];
    Ok((headers, calendar).into_response())
}

fn event_of(item: &DueItem, owner: PersonKey, address: &str) -> CalendarEvent {
    let (summary, page) = match item.kind {
        DueKind::Assignment => (tr!("Due: {title}", title = item.title), "/assignments".to_owned()),
        DueKind::Marking => (tr!("Mark pops: {title}", title = item.title), format!("/segments/{}", item.id)),
        DueKind::Survey => (tr!("Survey closes: {title}", title = item.title), format!("/surveys/{}", item.id)),
    };
    CalendarEvent {
        // The due date of one assignment differs between people.
        uid: format!("{}-{}@stylet", item.id, owner.person_id),
        sequence: item.extended_days,
        changed_at: item.made_at,
        due_at: item.due_at,
        summary,
        url: format!("{address}{page}"),
    }
}
