//! A school's logo: uploaded and removed on the settings page, shown on every page of the school.

use acts::error::Error;
use acts::operations::schools as settling;
use axum::extract::State;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::{IntoResponse, Redirect, Response};
use pages::form::FilledForm;
use pages::operations::settings::SettingsPage;
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf, CsrfFileForm, CsrfForm, NoFields, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use store::operations::logos;

use super::settings::make_settings_page;

/// Maximum size of a logo file, in bytes.
pub(super) const MOST_LOGO_BYTES: usize = 4 * 1024 * 1024;
/// The address changes with the logo, so browsers may cache it; it belongs to a school, so shared
/// caches must not.
const FOREVER: &str = "private, max-age=31536000, immutable";
/// A picture loads nothing, runs nothing and cannot act as a page of the service.
const NOTHING_ELSE: &str = "default-src 'none'; sandbox";

/// Serves the logo of the visitor's school.
pub(super) async fn serve_logo(State(state): State<AppState>, Visitor(person): Visitor) -> Result<Response, PageError> {
    let logo = logos::find_logo(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let logo = logo.ok_or(Error::NotFound)?;
    let headers =
        [(CONTENT_TYPE, logo.media_type.as_str()), (CONTENT_SECURITY_POLICY, NOTHING_ELSE), (CACHE_CONTROL, FOREVER)];
    Ok((headers, logo.bytes).into_response())
}

pub(super) async fn put_logo(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfFileForm { file, .. }: CsrfFileForm<MOST_LOGO_BYTES>,
) -> Result<FormAnswer<SettingsPage>, PageError> {
    let taken = if file.is_cut {
        Err(tr!("the logo: the file is too large; at most {most} bytes are allowed", most = MOST_LOGO_BYTES))
    } else {
        split_refusal(settling::put_logo(&state, &person, file.bytes).await)?
    };
    match taken {
        Ok(()) => Ok(FormAnswer::lead_to("/admin/settings?saved=true#logo")),
        Err(why) => {
            let page = make_settings_page(&state, Visit::new(&person, &csrf), None).await?;
            let form = FilledForm::refused(page.form.typed, why);
            Ok(FormAnswer::Refused(SettingsPage { form, ..page }))
        }
    }
}

pub(super) async fn remove_logo(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    settling::remove_logo(&state, &person).await?;
    Ok(Redirect::to("/admin/settings?saved=true#logo"))
}
