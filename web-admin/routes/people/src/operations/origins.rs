//! `/admin/origins`: other sites whose pages may upload to the school with a token.

use acts::error::Error;
use acts::operations::schools;
use axum::extract::State;
use pages::form::FilledForm;
use pages::operations::origins::{OriginsForm, OriginsPage};
use pages::{NavPlace, Shell};
use platform::config;
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use store::operations::origins;

/// Maximum number of origins of a school.
const MOST: usize = 20;

pub(super) async fn show_origins(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<OriginsPage, PageError> {
    let allowed = origins::list_school_origins(state.db.reader(), person.school_id).await.map_err(Error::from)?;
    let form = FilledForm::new(OriginsForm { origins: allowed.join("\n") });
    Ok(make_origins_page(&state, Visit::new(&person, &csrf), form))
}

fn make_origins_page(state: &AppState, visit: Visit<'_>, form: FilledForm<OriginsForm>) -> OriginsPage {
    OriginsPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Administration),
        form,
        everywhere: state.config.allowed_origins.clone(),
    }
}

pub(super) async fn set_origins(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<OriginsForm>,
) -> Result<FormAnswer<OriginsPage>, PageError> {
    let allowed = match parse_origins(&form.origins) {
        Ok(allowed) => allowed,
        Err(refused) => {
            let form = FilledForm::refused(form, refused);
            return Ok(FormAnswer::Refused(make_origins_page(&state, Visit::new(&person, &csrf), form)));
        }
    };
    schools::set_origins(&state, &person, &allowed).await?;
    Ok(FormAnswer::lead_to("/admin/origins"))
}

/// Parses one origin per line; the error explains an invalid one.
fn parse_origins(text: &str) -> Result<Vec<String>, String> {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    if lines.len() > MOST {
        return Err(tr!("{count} origins; at most {most} are allowed", count = lines.len(), most = MOST));
    }
    let checked = lines.into_iter().map(|line| {
        let refused = |_| {
            tr!(
                "“{value}” is not an origin: enter a scheme and a host, such as https://lab.example.org, without a path",
                value = line.chars().take(100).collect::<String>()
            )
        };
        config::origin(line).map_err(refused)
    });
    checked.collect()
}
