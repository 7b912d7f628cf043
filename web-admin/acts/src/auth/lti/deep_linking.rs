//! Choice of content for a course of a learning platform (LTI Deep Linking 2.0).

use std::collections::BTreeSet;

use model::auth::deep_linking::{ContentKind, DeepLinkingResponse, LinkableContent};
use model::ids::ContentChoiceId;
use model::{CurrentPerson, PersonKey};
use platform::secret;
use serde_json::json;
use store::audit::AuditEntry;
use store::auth::lti::content_choices::ContentChoice;
use store::auth::lti::platforms::Platform;
use store::auth::lti::{content_choices, platforms};
use store::authoring::exercises;
use store::training::{assignments, curricula};

use super::launches::launch_url;
use crate::auth::federation::client_keys;
use crate::error::Error;
use crate::service::Service;

/// Maximum number of assignments among the content.
const MOST_ASSIGNMENTS: u32 = 200;

/// A choice that a person is about to make.
#[derive(Clone, Debug)]
pub struct OpenChoice {
    /// Learning platform.
    pub platform: Platform,
    /// The choice.
    pub choice: ContentChoice,
    /// What can be chosen, by kind and title.
    pub content: Vec<LinkableContent>,
}

/// Returns a choice that a person has begun by a launch.
///
/// # Errors
/// Fails if there is no such choice, it was made or has expired, or the database fails.
pub async fn find_choice(service: &Service, by: &CurrentPerson, id: ContentChoiceId) -> Result<OpenChoice, Error> {
    let reader = service.db.reader();
    let choice = content_choices::find_choice(reader, PersonKey::from(by), id, service.clock.now()).await?;
    let choice = choice.ok_or(Error::NotFound)?;
    let platform = platforms::find_platform(reader, by.school_id, choice.platform_id).await?;
    let platform = platform.filter(|known| known.disabled_at.is_none()).ok_or(Error::NotFound)?;
    Ok(OpenChoice { platform, choice, content: list_content(service, by).await? })
}

/// Returns the content that a person may link to: the assignments to cohorts that they manage, the
/// courses, and the exercises.
async fn list_content(service: &Service, by: &CurrentPerson) -> Result<Vec<LinkableContent>, Error> {
    let reader = service.db.reader();
    let given = assignments::list_managed_assignments(reader, by, None, MOST_ASSIGNMENTS).await?;
    let given = given.into_iter().filter(|given| given.cohort_id.is_some()).map(|given| LinkableContent {
        kind: ContentKind::Assignment,
        id: given.id.to_string(),
        title: given.title,
        cohort: Some(given.to),
    });
    let plain = |kind, id, title| LinkableContent { kind, id, title, cohort: None };
    let courses = curricula::list_taught_curricula(reader, by.school_id).await?.into_iter();
    let courses = courses.map(|course| plain(ContentKind::Course, course.curriculum_id, course.title));
    let alone = exercises::list_current_exercises(reader, by.school_id).await?.into_iter();
    let alone = alone.map(|exercise| plain(ContentKind::Exercise, exercise.exercise_id, exercise.title));
    Ok(given.chain(courses).chain(alone).collect())
}

/// A signed response, for the browser to post.
#[derive(Clone, Debug)]
pub struct SignedChoice {
    /// Name of the learning platform.
    pub platform: String,
    /// Address to which the browser posts it.
    pub return_url: String,
    /// Origin of that address.
    pub return_origin: String,
    /// The response.
    pub jwt: String,
    /// Number of links in it.
    pub links: usize,
}

/// Makes a choice: signs the response that names the content. No resource id chooses nothing.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if the content may not be chosen; fails as [`find_choice`].
pub async fn choose_content(
    service: &Service,
    by: &CurrentPerson,
    id: ContentChoiceId,
    chosen: &BTreeSet<String>,
) -> Result<SignedChoice, Error> {
    let OpenChoice { platform, choice, mut content } = find_choice(service, by, id).await?;
    content.retain(|content| chosen.contains(&content.resource_id()));
    if content.len() < chosen.len() {
        return Err(Error::Unprocessable(tr!("content: not in the list any more; choose again").to_owned()));
    }
    if content.len() > 1 && !choice.content.accepts_several {
        return Err(Error::Unprocessable(tr!("content: the learning platform takes one link at a time").to_owned()));
    }
    let response = DeepLinkingResponse {
        settings: &platform.settings,
        deployment: &choice.deployment,
        content: &choice.content,
        chosen: &content,
        launch_url: &launch_url(service),
    };
    let key = client_keys::read_signing_key(service).await?;
    let now = service.clock.now();
    let jwt = key.sign(&response.claims(&secret::random_hex()?, now.micros().div_euclid(1_000_000)))?;
    let mut tx = service.db.write().await?;
    if !content_choices::remove_choice(&mut tx, by.school_id, id).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "platform.content_linked", platform.id)
        .with(json!({ "deployment": choice.deployment, "content": chosen }))
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(SignedChoice {
        platform: platform.settings.name,
        return_origin: choice.content.return_origin().ok_or(Error::NotFound)?,
        return_url: choice.content.return_url,
        jwt,
        links: content.len(),
    })
}
