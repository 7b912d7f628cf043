//! `/admin/learning-records`: the learning record store of the school; `/account/learning-records`:
//! consent to it.

use acts::error::Error;
use acts::training::learning_records::stores;
use axum::extract::State;
use axum::response::{Redirect, Response};
use model::training::learning_records::RecordStoreSettings;
use model::{PersonKey, Role};
use pages::form::FilledForm;
use pages::training::learning_records::{
    RecordConsentPage, RecordStoreForm, RecordStorePage, RecordStoreState, SentRecords, StoppedStatementRow,
    describe_consent,
};
use pages::{NavPlace, Shell};
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::training::learning_records;
use store::training::learning_records::RecordStore;

const PAGE: &str = "/admin/learning-records";
const OWN_PAGE: &str = "/account/learning-records";
/// Maximum number of refused statements on the page.
const SHOWN: u32 = 50;

/// Returns the routes of these pages.
pub(super) fn record_routes() -> Routes {
    Routes::new()
        .route(PAGE, get(show_store).merge(post(put_store)))
        .route("/admin/learning-records/disable", post(disable_store))
        .route("/admin/learning-records/retry", post(retry))
        .route("/admin/learning-records/erased.txt", get(list_erased))
        .route(OWN_PAGE, get(show_consent).merge(post(change_consent)))
}

async fn show_store(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<RecordStorePage, PageError> {
    let known = learning_records::find_record_store(state.db.reader(), person.school_id).await?;
    let form = known.as_ref().map(|known| RecordStoreForm::from(&known.settings)).unwrap_or_default();
    Ok(make_page(&state, Visit::new(&person, &csrf), known, FilledForm::new(form)).await?)
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    known: Option<RecordStore>,
    form: FilledForm<RecordStoreForm>,
) -> Result<RecordStorePage, Error> {
    let erased = learning_records::list_statements_of_erased(state.db.reader(), person.school_id).await?;
    let state = match known {
        Some(known) => Some(read_state(state, known).await?),
        None => None,
    };
    let shell = Shell::new(person, csrf.token(), NavPlace::Administration);
    Ok(RecordStorePage { shell, state, form, erased: erased.len() })
}

async fn read_state(state: &AppState, known: RecordStore) -> Result<RecordStoreState, Error> {
    let reader = state.db.reader();
    let counts = learning_records::count_statements(reader, &known).await?;
    let count = |state: &str| counts.iter().find(|count| count.state == state).map_or(0, |count| count.number);
    let stopped = learning_records::list_stopped_statements(reader, &known, SHOWN).await?;
    let row = |statement: learning_records::StoppedStatement| StoppedStatementRow {
        id: statement.id.to_string(),
        made: statement.made_at.to_utc(),
        answer: statement.last_answer,
    };
    Ok(RecordStoreState {
        waiting: count("waiting"),
        sent: count("sent"),
        stopped: count("stopped"),
        rows: stopped.into_iter().map(row).collect(),
        refusal: known.refusal,
    })
}

/// The form of a store, with its password.
#[derive(Deserialize)]
struct SentStore {
    #[serde(flatten)]
    fields: RecordStoreForm,
    #[serde(default)]
    password: String,
}

async fn put_store(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(SentStore { fields, password }): CsrfForm<SentStore>,
) -> Result<FormAnswer<RecordStorePage>, PageError> {
    let put = stores::put_store(&state, &person, RecordStoreSettings::from(&fields), &password).await;
    match split_refusal(put)? {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            let known = learning_records::find_record_store(state.db.reader(), person.school_id).await?;
            let form = FilledForm::refused(fields, why);
            Ok(FormAnswer::Refused(make_page(&state, Visit::new(&person, &csrf), known, form).await?))
        }
    }
}

async fn disable_store(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    stores::disable_store(&state, &person).await?;
    Ok(Redirect::to(PAGE))
}

async fn retry(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    stores::retry(&state, &person).await?;
    Ok(Redirect::to(PAGE))
}

/// Returns the ids of the sent statements about erased people, one on a line.
async fn list_erased(
    State(state): State<AppState>,
    Administrator(person): Administrator,
) -> Result<Response, PageError> {
    let ids = learning_records::list_statements_of_erased(state.db.reader(), person.school_id).await?;
    let text: String = ids.iter().map(|id| format!("{id}\n")).collect();
    Ok(attach_file("text/plain; charset=utf-8", "statements-of-erased-people.txt", text))
}

async fn show_consent(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<RecordConsentPage, PageError> {
    let (reader, key) = (state.db.reader(), PersonKey::from(&person));
    let known = learning_records::find_record_store(reader, person.school_id).await?;
    let asked = match known.filter(|_| person.role == Role::Trainee) {
        None => SentRecords::Nothing,
        Some(RecordStore { settings: RecordStoreSettings { endpoint, ground: Some(ground), names, .. }, .. }) => {
            SentRecords::ByGround { endpoint, ground, names }
        }
        Some(known) => SentRecords::ByConsent {
            wording: describe_consent(&known.settings),
            given: learning_records::may_send(reader, &known, person.id).await?,
        },
    };
    let sent = learning_records::count_sent_statements(reader, key).await?;
    Ok(RecordConsentPage { shell: Shell::new(&person, csrf.token(), NavPlace::Account), asked, sent })
}

#[derive(Deserialize)]
struct ConsentForm {
    #[serde(default)]
    consent: String,
}

async fn change_consent(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(form): CsrfForm<ConsentForm>,
) -> Result<Redirect, PageError> {
    match form.consent.as_str() {
        "given" => {
            if person.role != Role::Trainee {
                return Err(Error::Forbidden(tr!("only trainees have learning records")).into());
            }
            let known = learning_records::find_record_store(state.db.reader(), person.school_id).await?;
            let known = known.ok_or(Error::NotFound)?;
            stores::give_consent(&state, &person, &describe_consent(&known.settings)).await?;
        }
        "withdrawn" => stores::withdraw_consent(&state, &person).await?,
        other => {
            let why = format!("consent: \"{other}\"; allowed: given, withdrawn");
            return Err(Error::BadRequest(why).into());
        }
    }
    Ok(Redirect::to(OWN_PAGE))
}
