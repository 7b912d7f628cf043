//! `/admin/platforms/{id}/deliveries`: grades for a learning platform.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::training::grade_delivery;
use axum::extract::{Query, State};
use axum::response::Redirect;
use model::auth::grade_service::{DeliveryState, GradedPage};
use model::ids::{DeliveryId, PlatformId, SchoolId};
use pages::auth::deliveries::{DeliveriesPage, DeliveryRow};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields};
use routes_base::error::PageError;
use serde::Deserialize;
use store::auth::lti::deliveries::{self, DeliveryQuery, ShownDelivery};
use store::auth::lti::platforms;
use store::authoring::exercises;
use store::training::assignments;

/// Number of grades on a page.
const PER_PAGE: u32 = 50;

#[derive(Deserialize)]
pub(super) struct DeliveriesQuery {
    state: Option<String>,
    after: Option<DeliveryId>,
}

pub(super) async fn show_deliveries(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(id): PathId<PlatformId>,
    Query(query): Query<DeliveriesQuery>,
) -> Result<DeliveriesPage, PageError> {
    let reader = state.db.reader();
    let known = platforms::find_platform(reader, person.school_id, id).await?.ok_or(Error::NotFound)?;
    let shown = query.state.as_deref().and_then(DeliveryState::of_word).unwrap_or(DeliveryState::Stopped);
    let part = DeliveryQuery {
        school_id: person.school_id,
        platform_id: id,
        state: shown,
        after: query.after.unwrap_or_else(DeliveryId::nil),
        limit: PER_PAGE + 1,
    };
    let mut found = deliveries::list_deliveries(reader, part).await?;
    let has_more = found.len() > PER_PAGE as usize;
    found.truncate(PER_PAGE as usize);
    let titles = find_titles(&state, person.school_id, &found).await?;
    let href = format!("/admin/platforms/{id}");
    Ok(DeliveriesPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        platform: known.settings.name,
        shown,
        next: found.last().filter(|_| has_more).map(|last| last.id.to_string()),
        rows: found.into_iter().map(|delivery| make_row(&href, &titles, delivery)).collect(),
        href,
    })
}

/// Returns the titles of the exercises and assignments that links open, by path. Those that are no
/// longer taught are missing.
async fn find_titles(
    state: &AppState,
    school: SchoolId,
    rows: &[ShownDelivery],
) -> Result<BTreeMap<String, String>, PageError> {
    let (reader, mut titles) = (state.db.reader(), BTreeMap::new());
    for row in rows {
        if titles.contains_key(&row.page) {
            continue;
        }
        let title = match GradedPage::of_path(&row.page) {
            Some(GradedPage::Exercise(id)) => {
                exercises::find_current_revision(reader, school, &id).await?.map(|exercise| exercise.title)
            }
            Some(GradedPage::Assignment(id)) => {
                assignments::find_assignment(reader, school, id).await?.map(|assigned| assigned.title)
            }
            None => None,
        };
        titles.extend(title.map(|title| (row.page.clone(), title)));
    }
    Ok(titles)
}

fn make_row(href: &str, titles: &BTreeMap<String, String>, delivery: ShownDelivery) -> DeliveryRow {
    DeliveryRow {
        title: titles.get(&delivery.page).unwrap_or(&delivery.page).clone(),
        name: delivery.name,
        trainee: format!("/trainees/{}", delivery.person_id),
        page: delivery.page,
        tries: delivery.tries,
        // A changed grade is due at once, not at a time.
        next: delivery.next_run_at.filter(|at| at.micros() > 0).map(|at| at.to_utc()),
        status: delivery.last_status,
        answer: delivery.last_answer,
        sent: delivery.sent_at.map(|at| at.to_utc()),
        retry: format!("{href}/deliveries/{}/retry", delivery.id),
    }
}

/// Path of a grade of a platform.
#[derive(Deserialize)]
pub(super) struct DeliveryPath {
    id: PlatformId,
    delivery: DeliveryId,
}

pub(super) async fn retry_delivery(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(path): PathId<DeliveryPath>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    grade_delivery::retry(&state, &person, path.id, path.delivery).await?;
    Ok(Redirect::to(&format!("/admin/platforms/{}/deliveries", path.id)))
}
