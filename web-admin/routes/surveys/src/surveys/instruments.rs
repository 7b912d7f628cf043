//! `/surveys/instruments`: the instruments of a school, and the editor.

use acts::authoring::instruments::{from_json, publish_written, to_json};
use acts::error::Error;
use acts::surveys;
use axum::extract::{Path, Query, State};
use axum::response::{IntoResponse, Response};
use documents::{DocumentError, Instrument, Issue};
use model::CurrentPerson;
use pages::authoring::draft::say_issue;
use pages::form::{FilledForm, SelectOption};
use pages::surveys::instrument::{EditPage, InstrumentPage, InstrumentPreview, InstrumentsPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, Teacher};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use routes_base::forms::{FormAnswer, PublishedQuery, unix_lines};
use serde::Deserialize;
use store::surveys::instruments;
use store::surveys::instruments::InstrumentRevision;
use store::training::curricula;

/// Template of a new instrument.
const BLANK: &str = r#"id = "my-questionnaire"
title = { en = "My questionnaire" }
languages = ["en"]
duration_min = 1
source = "Who made it, and where it was published"
licence = "Under which terms it may be used"

[[scale]]
id = "agreement"
kind = "likert"
points = 5
first = { en = "Strongly disagree" }
last = { en = "Strongly agree" }

[[item]]
id = "useful"
text = { en = "This exercise was useful." }
scale = "agreement"

[[score]]
id = "usefulness"
title = { en = "Usefulness (1–5)" }
items = ["useful"]
combine = "mean"
"#;

fn instrument_href(id: &str) -> String {
    format!("/surveys/instruments/{id}")
}

pub(super) async fn list_instruments(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<InstrumentsPage, PageError> {
    let all = surveys::list_titled_instruments(&state, person.school_id).await?;
    let row =
        |i: InstrumentRevision| (i.title, instrument_href(&i.instrument_id), i.instrument_id, i.published_at.to_utc());
    Ok(InstrumentsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Surveys),
        instruments: all.into_iter().map(row).collect(),
    })
}

async fn find_current(state: &AppState, person: &CurrentPerson, id: &str) -> Result<InstrumentRevision, PageError> {
    Ok(instruments::find_current_instrument(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?)
}

pub(super) async fn show_instrument(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    Query(shown): Query<PublishedQuery>,
    csrf: Csrf,
) -> Result<InstrumentPage, PageError> {
    let found = find_current(&state, &person, &id).await?;
    let parsed = surveys::revision(&state, person.school_id, found.id).await?.ok_or(Error::NotFound)?;
    Ok(InstrumentPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Surveys),
        href: instrument_href(&id),
        preview: InstrumentPreview::new(&parsed),
        published: shown.published.is_some(),
        courses: curricula::list_taught_curricula(state.db.reader(), person.school_id)
            .await?
            .into_iter()
            .map(|course| SelectOption { value: course.curriculum_id, label: course.title, chosen: false })
            .collect(),
    })
}

/// Serves the published document, as TOML or as JSON.
pub(super) async fn serve_document(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path((id, file)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let found = find_current(&state, &person, &id).await?;
    let (media_type, name, body) = match file.as_str() {
        "document.toml" => ("application/toml", format!("{}.toml", found.instrument_id), found.bytes),
        "document.json" => {
            let json = to_json(&found.bytes)?;
            ("application/json", format!("{}.json", found.instrument_id), json.into_bytes())
        }
        _ => return Err(Error::NotFound.into()),
    };
    Ok(attach_file(media_type, &name, body))
}

pub(super) async fn show_new_instrument(Teacher(person): Teacher, csrf: Csrf) -> Result<EditPage, PageError> {
    Ok(make_editor_page(&person, &csrf, None, FilledForm::new(BLANK.to_owned())))
}

pub(super) async fn show_editor(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    csrf: Csrf,
) -> Result<EditPage, PageError> {
    let found = find_current(&state, &person, &id).await?;
    let text = String::from_utf8_lossy(&found.bytes).into_owned();
    Ok(make_editor_page(&person, &csrf, Some(&id), FilledForm::new(text)))
}

fn make_editor_page(
    person: &CurrentPerson,
    csrf: &Csrf,
    id: Option<&str>,
    form: FilledForm<String, Vec<String>>,
) -> EditPage {
    EditPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Surveys),
        heading: if id.is_some() { tr!("Paste another version") } else { tr!("Paste a questionnaire") },
        action: id.map_or_else(|| "/surveys/instruments/new".to_owned(), |id| format!("{}/edit", instrument_href(id))),
        form,
        preview: None,
    }
}

#[derive(Deserialize)]
pub(super) struct DocumentForm {
    text: String,
    #[serde(rename = "do", default)]
    step: String,
}

pub(super) async fn add_instrument(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<DocumentForm>,
) -> Result<FormAnswer<EditPage>, PageError> {
    store_instrument(&state, &person, &csrf, None, form).await
}

pub(super) async fn change_instrument(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<DocumentForm>,
) -> Result<FormAnswer<EditPage>, PageError> {
    find_current(&state, &person, &id).await?;
    store_instrument(&state, &person, &csrf, Some(&id), form).await
}

/// Parses the text, and publishes it if that was requested and there are no issues.
async fn store_instrument(
    state: &AppState,
    person: &CurrentPerson,
    csrf: &Csrf,
    id: Option<&str>,
    form: DocumentForm,
) -> Result<FormAnswer<EditPage>, PageError> {
    let text = unix_lines(&form.text);
    let refuse =
        |issues| FormAnswer::Refused(make_editor_page(person, csrf, id, FilledForm::refused(text.clone(), issues)));
    let (instrument, bytes) = match read_instrument(&text, id) {
        Ok(read) => read,
        Err(issues) => return Ok(refuse(issues)),
    };
    if form.step != "publish" {
        let page = make_editor_page(person, csrf, id, FilledForm::new(text));
        let page = EditPage { preview: Some(InstrumentPreview::new(&instrument)), ..page };
        return Ok(FormAnswer::Answered(page.into_response()));
    }
    if !publish_written(state, person, &instrument, &bytes, id.is_none()).await? {
        let issues = vec![tr!("id: “{id}” already exists: edit that questionnaire", id = instrument.id)];
        return Ok(refuse(issues));
    }
    Ok(FormAnswer::lead_to(&instrument_href(&instrument.id)))
}

/// Parses an instrument from TOML or JSON; returns it with its TOML, or all issues. An edited
/// instrument must keep its id.
fn read_instrument(text: &str, id: Option<&str>) -> Result<(Instrument, Vec<u8>), Vec<String>> {
    let said = |issue: &Issue| {
        let (place, what) = say_issue(issue);
        format!("{place}: {what}")
    };
    let all = |refused: DocumentError| refused.issues.iter().map(said).collect::<Vec<_>>();
    let is_json = text.trim_start().starts_with('{');
    let toml = if is_json { from_json(text).map_err(all)? } else { text.to_owned() };
    let bytes = toml.into_bytes();
    let instrument = Instrument::from_bytes("document", &bytes).map_err(all)?;
    match id.filter(|id| *id != instrument.id) {
        Some(id) => Err(vec![tr!(
            "id: “{typed}”; allowed: {id}, because a questionnaire keeps its id",
            typed = instrument.id,
            id = id
        )]),
        None => Ok((instrument, bytes)),
    }
}
