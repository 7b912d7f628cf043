//! `/admin/origins`: other sites whose pages may upload to the school with a token.

use acts::schools;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use serde::Deserialize;

use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Administrator, Csrf, CsrfForm};
use acts::config;
use acts::error::Error;
use pages::origins::OriginsPage;
use pages::{NavPlace, Shell};
use store::origins;

/// Most origins that a school allows.
const MOST: usize = 20;

pub(super) async fn show_origins(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<OriginsPage, PageError> {
    let allowed = origins::list_school_origins(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Administration);
    Ok(OriginsPage {
        shell,
        typed: allowed.join("\n"),
        everywhere: state.config.allowed_origins.clone(),
        refused: None,
    })
}

#[derive(Deserialize)]
pub(super) struct OriginsForm {
    origins: String,
}

pub(super) async fn set_origins(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<OriginsForm>,
) -> Result<Response, PageError> {
    let allowed = match parse_origins(&form.origins) {
        Ok(allowed) => allowed,
        Err(refused) => {
            let shell = Shell::new(&person, csrf.token(), NavPlace::Administration);
            let everywhere = state.config.allowed_origins.clone();
            let page = OriginsPage { shell, typed: form.origins, everywhere, refused: Some(refused) };
            return Ok((StatusCode::UNPROCESSABLE_ENTITY, page).into_response());
        }
    };
    schools::set_origins(&state, &person, &allowed).await?;
    Ok(Redirect::to("/admin/origins").into_response())
}

/// An origin a line; why not, in words.
fn parse_origins(text: &str) -> Result<Vec<String>, String> {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    if lines.len() > MOST {
        return Err(tr!("{count} origins; at most {most} are allowed", count = lines.len(), most = MOST));
    }
    let checked = lines.into_iter().map(|line| {
        let refused = |_| {
            tr!(
                "“{value}” is no origin: a scheme and a host, as https://lab.example.org, without a path",
                value = line.chars().take(100).collect::<String>()
            )
        };
        config::origin(line).map_err(refused)
    });
    checked.collect()
}
