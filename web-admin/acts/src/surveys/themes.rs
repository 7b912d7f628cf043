//! Themes that the owner of a survey puts on what was answered in free words.

use model::CurrentPerson;
use model::ids::ResponseId;
use model::survey::Survey;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::surveys;

use crate::error::Error;
use crate::service::Service;

/// A theme on an answer.
#[derive(Clone, Copy, Debug)]
pub struct Theme<'a> {
    /// The response that it is in.
    pub response: ResponseId,
    /// The item that was answered.
    pub item: &'a str,
    /// The theme, in lower case.
    pub tag: &'a str,
}

/// Puts a theme on an answer, or takes it away.
///
/// # Errors
/// [`Error::NotFound`] when there is no such answer, or nothing to take away; else when the database fails.
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
