//! `/admin/retention`: the school's retention period, and the people it affects next.
//! `/people/{id}/hold`: exempts a person from it.

use acts::error::Error;
use acts::operations::schools;
use acts::privacy::retention as retaining;
use acts::privacy::retention::RetentionStep;
use axum::extract::{Query, State};
use axum::response::Redirect;
use model::Moment;
use model::ids::PersonId;
use pages::form::FilledForm;
use pages::privacy::retention::{IdleRow, RetentionForm, RetentionPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::people::directory;
use store::privacy::retention;
use store::privacy::retention::Settings;

/// Maximum number of people listed.
const LISTED: usize = 200;
/// Allowed retention periods, in months.
const MONTHS: std::ops::RangeInclusive<u32> = 3..=240;
/// Allowed warning periods, in days.
const DAYS: std::ops::RangeInclusive<u32> = 7..=365;

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct SavedQuery {
    #[serde(default)]
    saved: bool,
}

pub(super) async fn show_retention(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    Query(SavedQuery { saved }): Query<SavedQuery>,
) -> Result<RetentionPage, PageError> {
    let page = make_retention_page(&state, Visit::new(&person, &csrf), None).await?;
    Ok(RetentionPage { saved, ..page })
}

async fn make_retention_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    sent: Option<FilledForm<RetentionForm>>,
) -> Result<RetentionPage, Error> {
    let (settings, planned) = retaining::plan(state, person.school_id).await?;
    let held = retention::list_held_people(state.db.reader(), person.school_id).await?;
    Ok(RetentionPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        form: sent.unwrap_or_else(|| FilledForm::new(form_of_settings(settings))),
        saved: false,
        more: planned.len().saturating_sub(LISTED),
        rows: planned.into_iter().take(LISTED).map(make_idle_row).collect(),
        held: held.into_iter().map(|(id, name)| (format!("/people/{id}"), name)).collect(),
    })
}

fn form_of_settings(settings: Settings) -> RetentionForm {
    RetentionForm {
        months: settings.months.map(|months| months.to_string()).unwrap_or_default(),
        warn_days: settings.warn_days.to_string(),
        texts: settings.texts,
        recordings: settings.recordings,
    }
}

fn make_idle_row(RetentionStep { idle, step }: RetentionStep) -> IdleRow {
    IdleRow {
        href: format!("/people/{}", idle.id),
        name: idle.name,
        role: idle.role,
        active_at: idle.active_at.to_utc(),
        told_at: idle.told_at.map(Moment::to_utc),
        error: idle.error,
        step,
    }
}

/// Parses the settings; the error explains invalid input.
fn read_settings(form: &RetentionForm) -> Result<Settings, String> {
    let number = |text: &str, allowed: std::ops::RangeInclusive<u32>| {
        text.trim().parse().ok().filter(|number| allowed.contains(number))
    };
    let months =
        match form.months.trim() {
            "" => None,
            typed => Some(number(typed, MONTHS).ok_or_else(|| {
                tr!("months: “{typed}”; allowed: whole months from 3 to 240, or empty", typed = typed)
            })?),
        };
    let typed = form.warn_days.trim();
    let warn_days =
        number(typed, DAYS).ok_or_else(|| tr!("days: “{typed}”; allowed: whole days from 7 to 365", typed = typed))?;
    Ok(Settings { months, warn_days, texts: form.texts, recordings: form.recordings })
}

/// Sets the retention rule.
pub(super) async fn set_retention(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<RetentionForm>,
) -> Result<FormAnswer<RetentionPage>, PageError> {
    let settings = match read_settings(&form) {
        Ok(settings) => settings,
        Err(refused) => {
            let sent = Some(FilledForm::refused(form, refused));
            return Ok(FormAnswer::Refused(make_retention_page(&state, Visit::new(&person, &csrf), sent).await?));
        }
    };
    schools::set_retention(&state, &person, settings).await?;
    Ok(FormAnswer::lead_to("/admin/retention?saved=true"))
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct HoldForm {
    hold: String,
}

/// Exempts a person from the retention rule, or ends the exemption.
pub(super) async fn hold_person(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(form): CsrfForm<HoldForm>,
) -> Result<Redirect, PageError> {
    directory::find_directory_entry(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let held = match form.hold.as_str() {
        "yes" => true,
        "no" => false,
        other => return Err(Error::BadRequest(format!("hold: \"{other}\"; allowed: yes, no")).into()),
    };
    acts::privacy::retention::set_held(&state, &person, id, held).await?;
    Ok(Redirect::to(&format!("/people/{id}?done=changed")))
}
