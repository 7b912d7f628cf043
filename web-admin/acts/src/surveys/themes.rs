//! Themes with which the owner of a survey codes free-text answers.

use model::CurrentPerson;
use model::ids::ResponseId;
use model::surveys::Survey;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::surveys;

use crate::error::Error;
use crate::service::Service;

/// A theme of an answer.
#[derive(Clone, Copy, Debug)]
pub struct Theme<'a> {
    /// The response.
    pub response: ResponseId,
    /// Id of the item.
    pub item: &'a str,
    /// The theme, in lower case.
    pub tag: &'a str,
}

/// Adds a theme to an answer, or removes it.
///
/// # Errors
/// Returns [`Error::NotFound`] if there is no such answer, or no such theme to remove; fails if the
/// database fails.
pub async fn set_theme(
    state: &Service,
    by: &CurrentPerson,
    survey: &Survey,
    Theme { response, item, tag }: Theme<'_>,
    is_on: bool,
) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    let (done, action) = if is_on {
        (surveys::add_tag(&mut tx, survey, response, item, tag).await?, "survey.tagged")
    } else {
        (surveys::remove_tag(&mut tx, survey, response, item, tag).await?, "survey.tag_removed")
    };
    if !done {
        return Err(Error::NotFound);
    }
    AuditEntry::new(survey.school_id, Actor::Person(by.id), action, survey.id)
        .with(json!({ "response": response, "item": item, "tag": tag }))
        .append(&mut tx, state.clock.now())
        .await?;
    Ok(tx.commit().await?)
}
