//! `/admin/audit`: searches and exports the audit log.

use std::collections::BTreeMap;
use std::time::Duration;

use acts::error::Error;
use axum::extract::{Query, State};
use axum::response::Response;
use futures::stream;
use model::ids::SchoolId;
use model::training::due::find_day_start;
use pages::audit::{ActObject, ActRow, AuditForm, AuditPage, AuditTheme, describe_act, list_act_details, say_actor};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::encode_in_query;
use routes_base::auth::{Administrator, Csrf};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, stream_csv};
use serde::Deserialize;
use serde_json::json;
use store::audit::search;
use store::audit::search::{
    AuditObject, AuditObjectKind, AuditSearch, FoundActs, SchoolAct, find_audit_place, search_audit_log,
};
use store::operations::schools;

/// Audit entries per page.
const PER_PAGE: u32 = 50;
/// Maximum number of rows of the log scanned for one page.
const WINDOW: u32 = 50_000;
/// Entries read per batch of an export: a long export then keeps neither memory nor the database
/// busy for long.
const AT_ONCE: u32 = 500;
/// Maximum time that an export waits for earlier exports of the same school.
const PATIENCE: Duration = Duration::from_secs(5);
/// Columns of the file.
const NAMES: [&str; 9] =
    ["row", "at", "actor", "action_in_words", "action", "object_name", "object_id", "object_kind", "details"];

/// Paging parameter.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(super) struct BeforeQuery {
    /// Only entries before this position in the log.
    before: Option<i64>,
}

/// A search, and the position in the log before which it continues.
struct AuditPlan {
    search: AuditSearch,
    before: i64,
}

async fn plan_search(state: &AppState, school: SchoolId, form: &AuditForm, limit: u32) -> Result<AuditPlan, Error> {
    let zone = schools::find_time_zone(state.db.reader(), school).await?;
    let day = |said: &str, later: i32| match said {
        "" => Ok(None),
        _ => find_day_start(said, &zone, later)
            .map(Some)
            .ok_or_else(|| Error::BadRequest(tr!("the day: “{typed}”; enter a date like 2026-11-30", typed = said))),
    };
    let themes = match form.theme.as_str() {
        "" => json!([]),
        key => json!(
            AuditTheme::of_key(key)
                .ok_or_else(|| Error::BadRequest(format!("theme: \"{key}\" does not exist")))?
                .actions
        ),
    };
    let before = match day(&form.until, 1)? {
        Some(until) => find_audit_place(state.db.reader(), until).await?,
        None => i64::MAX,
    };
    let (since, words) = (day(&form.since, 0)?, form.words.clone());
    let search = AuditSearch { school, themes: themes.to_string(), words, since, window: WINDOW, limit };
    Ok(AuditPlan { search, before })
}

/// Entries with the names of their objects.
struct NamedActs {
    acts: Vec<SchoolAct>,
    names: BTreeMap<String, AuditObject>,
    before: Option<i64>,
}

async fn find_acts(state: &AppState, AuditPlan { search, before }: &AuditPlan) -> Result<NamedActs, Error> {
    let reader = state.db.reader();
    let FoundActs { acts, before } = search_audit_log(reader, search, *before).await?;
    let ids: Vec<String> = acts.iter().map(|act| act.object.clone()).collect();
    let names = search::name_audit_objects(reader, search.school, &ids).await?;
    Ok(NamedActs { acts, names, before })
}

pub(super) async fn show_audit_log(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    Query(form): Query<AuditForm>,
    Query(query): Query<BeforeQuery>,
) -> Result<AuditPage, PageError> {
    let mut plan = plan_search(&state, person.school_id, &form, PER_PAGE).await?;
    plan.before = query.before.unwrap_or(i64::MAX).min(plan.before);
    let NamedActs { acts, names, before } = find_acts(&state, &plan).await?;
    let is_short = acts.len() < PER_PAGE as usize;
    let read_since = match before.filter(|_| is_short) {
        Some(place) => search::find_row_time(state.db.reader(), place).await?,
        None => None,
    };
    let searched = search_of_form(&form);
    Ok(AuditPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Administration),
        acts: acts.into_iter().map(|act| make_act_row(act, &names)).collect(),
        older: before.map(|before| format!("/admin/audit?{searched}before={before}")),
        file: format!("/admin/audit.csv?{searched}"),
        read_since: read_since.map(model::Moment::to_utc),
        form,
    })
}

/// Encodes a search as the beginning of a query string.
fn search_of_form(form: &AuditForm) -> String {
    let parts = [("words", &form.words), ("theme", &form.theme), ("since", &form.since), ("until", &form.until)];
    let typed = parts.iter().filter(|(_, value)| !value.is_empty());
    typed.map(|(name, value)| format!("{name}={}&", encode_in_query(value))).collect()
}

fn make_act_row(act: SchoolAct, names: &BTreeMap<String, AuditObject>) -> ActRow {
    let object = match names.get(&act.object) {
        Some(found) => {
            ActObject { name: say_object(found), href: href_of_object(found.kind, &act.object), id: act.object }
        }
        None => ActObject { name: name_of_document(&act.object), href: href_of_document(&act), id: act.object },
    };
    ActRow {
        seq: act.seq,
        at: act.at.to_utc(),
        actor: act.actor_name.unwrap_or_else(|| say_actor(&act.actor)),
        action: act.action,
        object,
        details: list_act_details(&act.details),
    }
}

fn say_object(AuditObject { kind, name }: &AuditObject) -> String {
    match kind {
        AuditObjectKind::Session => tr!("an attempt of {name}", name = name),
        _ => name.clone(),
    }
}

fn href_of_object(kind: AuditObjectKind, id: &str) -> Option<String> {
    let folder = match kind {
        AuditObjectKind::Person => "people",
        AuditObjectKind::Cohort => "cohorts",
        AuditObjectKind::Session => "sessions",
        AuditObjectKind::Survey => "surveys",
        AuditObjectKind::Study => "studies",
        AuditObjectKind::Round => "ratings",
        AuditObjectKind::Segments => "segments",
        AuditObjectKind::Assignment => "assignments",
        AuditObjectKind::School => return Some("/admin".to_owned()),
        AuditObjectKind::Station => return Some("/admin#stations".to_owned()),
    };
    Some(format!("/{folder}/{id}"))
}

/// Returns the name of an object that is not in the database: its id, unless that is a UUID.
fn name_of_document(object: &str) -> String {
    let is_uuid = object.parse::<model::ids::SessionId>().is_ok();
    if is_uuid { "–".to_owned() } else { object.to_owned() }
}

/// Returns the page of an object that is not in the database, if it has one.
fn href_of_document(act: &SchoolAct) -> Option<String> {
    match act.action.split_once('.')?.0 {
        "exercise" => Some(format!("/exercises/{}", act.object)),
        _ => None,
    }
}

/// Exports every entry that matches the search, newest first.
pub(super) async fn download_audit_log(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    Query(form): Query<AuditForm>,
) -> Result<Response, PageError> {
    let plan = plan_search(&state, person.school_id, &form, AT_ONCE).await?;
    let place = state.exports.enter(person.school_id, PATIENCE).await?;
    let rows = stream::try_unfold(Some(plan), move |plan| {
        // Held until the last row is written, or the client disconnects.
        let (state, _held) = (state.clone(), &place);
        async move { next_acts(&state, plan).await }
    });
    Ok(stream_csv("audit-log", &NAMES, rows)?)
}

/// Returns the next rows, and the search for those after them; `None` at the end of the log.
async fn next_acts(
    state: &AppState,
    plan: Option<AuditPlan>,
) -> anyhow::Result<Option<(Vec<Vec<CsvCell>>, Option<AuditPlan>)>> {
    let Some(plan) = plan else { return Ok(None) };
    let NamedActs { acts, names, before } = find_acts(state, &plan).await?;
    let rows = acts.into_iter().map(|act| make_csv_row(act, &names)).collect();
    Ok(Some((rows, before.map(|before| AuditPlan { before, ..plan }))))
}

fn make_csv_row(act: SchoolAct, names: &BTreeMap<String, AuditObject>) -> Vec<CsvCell> {
    let object = names.get(&act.object);
    vec![
        CsvCell::Number(act.seq as f64),
        CsvCell::from(act.at.to_string()),
        CsvCell::from(act.actor_name.unwrap_or_else(|| say_actor(&act.actor))),
        CsvCell::from(describe_act(&act.action).unwrap_or_default()),
        CsvCell::from(act.action),
        object.map_or(CsvCell::Empty, |object| CsvCell::from(object.name.as_str())),
        CsvCell::from(act.object),
        object.map_or(CsvCell::Empty, |object| CsvCell::from(object.kind.word())),
        CsvCell::from(act.details),
    ]
}
