//! Issues badges, revokes them when their ground is gone, and publishes status lists.
//!
//! A badge is valid as long as the course counts as mastered by the attempts that counted when it
//! was issued. It is revoked for good when a score was changed so that this no longer holds, when a
//! learning curve withdraws competence, and when the person is erased.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::time::Duration;

use model::ids::SchoolId;
use model::training::badge::{Badge, BadgeSigner, IssuedBadge, IssuerAddress, StatusList, StatusPlace, write_time};
use model::training::certificate::Statement;
use model::training::progress::{Course, Progress, ScoredAttempt};
use model::{CurrentPerson, Needed, PersonKey};
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::recordings::proofs;
use store::training::badges::{BadgeGround, ValidBadge};
use store::training::{badges, practice};

use crate::error::{Error, error_chain};
use crate::replicas::{self, Duty};
use crate::service::Service;
use crate::training::{assignments, certificates};

/// Interval of the checks whether valid badges are still earned.
const EVERY: Duration = Duration::from_secs(3600);
/// Badges read at once.
const BATCH: u32 = 500;
/// How long a status list is valid, in s: within this time an old copy can hide a revocation.
const LIST_VALID_S: i64 = 24 * 3600;

/// Returns this service as an issuer of badges.
///
/// # Errors
/// Fails if the public address has a path.
pub fn issuer(service: &Service) -> Result<IssuerAddress, Error> {
    Ok(IssuerAddress::of(&service.config.address())?)
}

/// Returns the document that names this service's key, for `did:web`.
///
/// # Errors
/// Fails if the key cannot be read.
pub fn did_document(service: &Service) -> Result<Value, Error> {
    Ok(issuer(service)?.did_document(&certificates::signing_key(&service.config.keys_dir)?))
}

/// Returns the badge for what a certificate would state, signed. Issues it if the mastery has no
/// valid badge yet.
///
/// # Errors
/// Fails if the database fails, or the key cannot be read.
pub async fn sign_badge(
    service: &Service,
    by: &CurrentPerson,
    ground: BadgeGround<'_>,
    statement: &Statement,
) -> Result<Value, Error> {
    let issuer = issuer(service)?;
    let badge = Badge::of(statement, &issuer, issue_badge(service, by, ground).await?)?;
    let key = certificates::signing_key(&service.config.keys_dir)?;
    let created = write_time(service.clock.now().to_utc())?;
    Ok(badge.sign(BadgeSigner { issuer: &issuer, key: &key, created: &created })?)
}

async fn issue_badge(service: &Service, by: &CurrentPerson, ground: BadgeGround<'_>) -> Result<IssuedBadge, Error> {
    let issued = |badge: badges::StoredBadge| IssuedBadge {
        id: badge.id,
        person: ground.person.person_id,
        place: StatusPlace::numbered(badge.place),
    };
    if let Some(known) = badges::find_badge(service.db.reader(), ground).await? {
        return Ok(issued(known));
    }
    let mut tx = service.db.write().await?;
    // Another request may have issued it in the meantime.
    if let Some(known) = badges::find_badge(&mut *tx, ground).await? {
        return Ok(issued(known));
    }
    let now = service.clock.now();
    let badge = badges::add_badge(&mut tx, ground, now).await?;
    let details = json!({
        "badge": badge.id,
        "place": badge.place,
        "curriculum_id": ground.curriculum_id,
        "sha256": ground.curriculum_sha256,
    });
    AuditEntry::by(by, "badge.issued", ground.person.person_id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(issued(badge))
}

/// Returns a signed status list; `None` if no badge has a place in it, except for the first list.
///
/// # Errors
/// Fails if the database fails, or the key cannot be read.
pub async fn publish_status_list(service: &Service, list: u64) -> Result<Option<Value>, Error> {
    let (Some(first), Some(next)) = (StatusPlace::of(list, 0), StatusPlace::of(list.saturating_add(1), 0)) else {
        return Ok(None);
    };
    let reader = service.db.reader();
    if list > 0 && !badges::is_place_taken(reader, first.number()).await? {
        return Ok(None);
    }
    let revoked = badges::list_revoked_places(reader, first.number(), next.number()).await?;
    let (issuer, now) = (issuer(service)?, service.clock.now());
    let published = StatusList {
        issuer: &issuer,
        list,
        revoked: revoked.into_iter().map(StatusPlace::numbered).collect(),
        valid_from: write_time(now.to_utc())?,
        valid_until: write_time(now.plus_s(LIST_VALID_S).to_utc())?,
    };
    let key = certificates::signing_key(&service.config.keys_dir)?;
    let signer = BadgeSigner { issuer: &issuer, key: &key, created: &published.valid_from };
    Ok(Some(published.sign(signer)?))
}

/// Returns the attempts of a trainee that have sufficient evidence, among those given.
///
/// # Errors
/// Fails if the database fails.
pub async fn list_proved_attempts(
    service: &Service,
    trainee: PersonKey,
    needed: Needed,
    attempts: &[ScoredAttempt],
) -> Result<Vec<ScoredAttempt>, Error> {
    let PersonKey { school_id, person_id } = trainee;
    let enough = proofs::list_proved_sessions(service.db.reader(), school_id, person_id, needed).await?;
    Ok(attempts.iter().filter(|attempt| enough.contains(&attempt.session)).cloned().collect())
}

/// Revokes the badges that are no longer earned, once an hour until the future is dropped.
pub async fn run(service: Service) {
    loop {
        let revoke = async { revoke_lost_badges(&service).await.map(drop) };
        if let Err(error) = replicas::do_duty(&service, Duty::Badges, revoke).await {
            tracing::warn!(cause = error_chain(&error), "failed to check badges");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Revokes the badges that are no longer earned. Returns their number.
///
/// # Errors
/// Fails if the database fails.
pub async fn revoke_lost_badges(service: &Service) -> Result<u32, Error> {
    let mut taught: BTreeMap<SchoolId, BTreeMap<String, Course>> = BTreeMap::new();
    let (mut from, mut revoked) = (0, 0);
    loop {
        let valid = badges::list_valid_badges(service.db.reader(), from, BATCH).await?;
        let Some(last) = valid.last() else { return Ok(revoked) };
        from = last.place + 1;
        for badge in &valid {
            let courses = match taught.entry(badge.school_id) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(school) => school.insert(taught_courses(service, badge.school_id).await?),
            };
            // A course that is not taught any more cannot be judged: its badges stay valid.
            let Some(course) = courses.get(&badge.curriculum_id) else { continue };
            if !is_still_mastered(service, badge, course).await? && revoke_lost_badge(service, badge).await? {
                revoked += 1;
            }
        }
    }
}

/// Returns the courses that a school teaches, by their ids.
async fn taught_courses(service: &Service, school: SchoolId) -> Result<BTreeMap<String, Course>, Error> {
    let courses = assignments::taught_curricula(service, school).await?.into_iter();
    Ok(courses.map(|(curriculum, course)| (curriculum.curriculum_id, course)).collect())
}

async fn is_still_mastered(service: &Service, badge: &ValidBadge, course: &Course) -> Result<bool, Error> {
    let person = person_of(badge);
    let attempts = practice::list_trainee_practice(service.db.reader(), person.school_id, person.person_id).await?;
    let proved = list_proved_attempts(service, person, badge.needed, &attempts).await?;
    Ok(Progress::of(course, &proved).complete())
}

async fn revoke_lost_badge(service: &Service, badge: &ValidBadge) -> Result<bool, Error> {
    let mut tx = service.db.write().await?;
    let now = service.clock.now();
    if !badges::revoke_badge(&mut tx, badge.place, now).await? {
        return Ok(false);
    }
    let details = json!({ "place": badge.place, "curriculum_id": badge.curriculum_id });
    AuditEntry::new(badge.school_id, Actor::Worker, "badge.revoked", badge.person_id)
        .with(details)
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(true)
}

const fn person_of(badge: &ValidBadge) -> PersonKey {
    PersonKey { school_id: badge.school_id, person_id: badge.person_id }
}
