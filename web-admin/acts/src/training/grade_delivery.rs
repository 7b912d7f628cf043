//! Sends grades to learning platforms (LTI Assignment and Grade Services 2.0). A grade is read when
//! it is sent, so that the platform gets the newest one. Its timestamp is stored before it is sent:
//! if the service ends in between, the grade is sent again with a later one.

use std::time::Duration;

use model::auth::grade_service::{
    self, DeliveryState, GradedPage, LineItem, SentGrade, SubmittedAttempt, describe_line_item, next_timestamp,
    scores_url, search_url, stamp_message,
};
use model::ids::{AssignmentId, DeliveryId, PlatformId, SessionId};
use model::sending::{retry_delay_s, shorten_answer};
use model::training::assignment::{Assigned, AssignmentOutcome, AssignmentTask, AttemptHistory};
use model::{CurrentPerson, Moment, PersonKey};
use platform::clock;
use platform::outgoing::{Answer, CallFailed, Content};
use serde_json::{Value, json};
use store::audit::{Actor, AuditEntry};
use store::auth::lti::deliveries::{self, DeliveryResult, DueDelivery};
use store::auth::lti::platforms::Platform;
use store::auth::lti::{courses, platforms};
use store::recordings::sessions;
use store::scoring::supervisions;
use store::training::{assignments, practice};
use tokio::task::JoinSet;

use crate::auth::lti::services::{self, ServiceFailure, ServiceRequest};
use crate::error::{Error, error_chain};
use crate::letters::notices;
use crate::replicas::{self, Duty};
use crate::service::Service;

/// Interval between checks for grades to send.
const EVERY: Duration = Duration::from_secs(5);
/// Number of grades read at once.
const BATCH: u32 = 50;
/// How long one platform is served before the others are checked again.
const LONGEST: Duration = Duration::from_secs(20);
/// How long a try may take before the grade is due again, in s: a token, two requests for the line
/// item and the score, each repeated once.
const LEASE_S: i64 = 180;
/// Maximum size of an answer, in bytes.
const LARGEST_ANSWER: u64 = 256 * 1024;

const SCORE_SCOPE: &str = "https://purl.imsglobal.org/spec/lti-ags/scope/score";
const ITEM_SCOPE: &str = "https://purl.imsglobal.org/spec/lti-ags/scope/lineitem";
const SCORE: &str = "application/vnd.ims.lis.v1.score+json";
const ITEM: &str = "application/vnd.ims.lis.v2.lineitem+json";
const ITEMS: &str = "application/vnd.ims.lis.v2.lineitemcontainer+json";

/// Sends grades periodically until the future is dropped, which may happen at any time.
pub async fn run(service: Service) {
    loop {
        if let Err(error) = replicas::do_duty(&service, Duty::Grades, send_due_grades(&service)).await {
            tracing::warn!(cause = error_chain(&error), "failed to send grades to learning platforms");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Sends the grades that are due, to each platform one after another.
///
/// # Errors
/// Fails if the database fails; a grade that is not accepted is retried later.
pub async fn send_due_grades(service: &Service) -> Result<(), Error> {
    let mut serving = JoinSet::new();
    for platform in platforms::list_awaiting_grades(service.db.reader(), service.clock.now()).await? {
        let service = service.clone();
        serving.spawn(async move { serve_platform(&service, &platform).await });
    }
    while let Some(served) = serving.join_next().await {
        served.map_err(anyhow::Error::from)??;
    }
    Ok(())
}

async fn serve_platform(service: &Service, platform: &Platform) -> Result<(), Error> {
    let begun = clock::instant();
    loop {
        let (reader, now) = (service.db.reader(), service.clock.now());
        let due = deliveries::list_due_deliveries(reader, platform.school_id, platform.id, now, BATCH).await?;
        if due.is_empty() {
            return Ok(());
        }
        for delivery in due {
            // A platform that does not answer now would delay each of its other grades, too.
            if !deliver(service, platform, &delivery).await? || begun.elapsed() > LONGEST {
                return Ok(());
            }
        }
    }
}

/// A grade and the assignment that it belongs to.
struct ReadGrade {
    grade: SentGrade,
    assignment: Option<AssignmentId>,
    title: String,
}

/// Returns the current grade; `None` if there is none and the platform has none.
async fn read_grade(service: &Service, due: &DueDelivery) -> Result<Option<ReadGrade>, Error> {
    let person = PersonKey { school_id: due.school_id, person_id: due.person_id };
    if due.lineitem_url.is_none() && due.lineitems_url.is_none() {
        return Ok(None);
    }
    let assigned = find_assigned(service, due).await?;
    let outcome = match &assigned {
        Some(assigned) => judge(service, person, assigned).await?,
        None => judge_practice(service, person, due).await?,
    };
    let grade = match outcome {
        AssignmentOutcome::Graded(best) => {
            let attempt = describe_attempt(service, person, best.session).await?;
            SentGrade::Score(best.score, attempt)
        }
        AssignmentOutcome::Unconfirmed(session) => {
            SentGrade::Pending(describe_attempt(service, person, session).await?)
        }
        AssignmentOutcome::None if due.stamped_at.is_some() => SentGrade::Withdrawn,
        AssignmentOutcome::None => return Ok(None),
    };
    let (assignment, title) = assigned.map(|assigned| (assigned.id, assigned.title)).unzip();
    Ok(Some(ReadGrade { grade, assignment, title: title.unwrap_or_default() }))
}

/// Returns the person's assignment that a link means: of an exercise, the latest one.
async fn find_assigned(service: &Service, due: &DueDelivery) -> Result<Option<Assigned>, Error> {
    let Some(page) = GradedPage::of_path(&due.page) else { return Ok(None) };
    let all = assignments::list_trainee_assignments(service.db.reader(), due.school_id, due.person_id).await?;
    let is_meant = |assigned: &Assigned| match (&page, &assigned.task) {
        (GradedPage::Assignment(id), AssignmentTask::Exercise(_)) => assigned.id == *id,
        (GradedPage::Exercise(linked), AssignmentTask::Exercise(exercise)) => linked == exercise,
        // A course has no score.
        (_, AssignmentTask::Course(_)) => false,
    };
    Ok(all.into_iter().rfind(is_meant))
}

async fn judge(service: &Service, person: PersonKey, assigned: &Assigned) -> Result<AssignmentOutcome, Error> {
    let (reader, school) = (service.db.reader(), person.school_id);
    let attempts = practice::list_trainee_practice(reader, school, person.person_id).await?;
    let supervised = match assigned.supervised {
        true => supervisions::list_trainee_supervisions(reader, school, person.person_id).await?,
        false => Vec::new(),
    };
    let tried = AttemptHistory::new(&[], &attempts, service.clock.now());
    Ok(AssignmentOutcome::of(assigned, &tried, &supervised.into_iter().collect()))
}

/// Returns the grade of a link to an exercise that is not assigned to the person.
async fn judge_practice(service: &Service, person: PersonKey, due: &DueDelivery) -> Result<AssignmentOutcome, Error> {
    let Some(GradedPage::Exercise(exercise)) = GradedPage::of_path(&due.page) else {
        return Ok(AssignmentOutcome::None);
    };
    let attempts = practice::list_trainee_practice(service.db.reader(), person.school_id, person.person_id).await?;
    Ok(AssignmentOutcome::of_practice(&attempts, &exercise))
}

async fn describe_attempt(service: &Service, person: PersonKey, id: SessionId) -> Result<SubmittedAttempt, Error> {
    let session = sessions::find_session(service.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let duration_us = (session.duration_s * 1e6) as i64;
    Ok(SubmittedAttempt {
        started_at: session.started_at,
        submitted_at: Moment::from_micros(session.started_at.micros().saturating_add(duration_us)),
        address: format!("{}/sessions/{id}", service.config.address()),
    })
}

/// Why a grade was not accepted.
enum Failure {
    /// Too many requests, or the platform was disabled meanwhile: this is no try.
    Postponed,
    /// The platform has not accepted it: the HTTP status, and its answer or the reason.
    Refused(Option<u16>, String),
    /// An error of this service.
    Service(Error),
}

impl From<ServiceFailure> for Failure {
    fn from(failure: ServiceFailure) -> Self {
        match failure {
            ServiceFailure::Disabled | ServiceFailure::Call(CallFailed::TooMany) => Self::Postponed,
            ServiceFailure::Service(error) => Self::Service(error),
            failure => Self::Refused(None, failure.to_string()),
        }
    }
}

/// Sends a grade if it has changed. Returns false if the platform should be left alone for now.
async fn deliver(service: &Service, platform: &Platform, due: &DueDelivery) -> Result<bool, Error> {
    let read = read_grade(service, due).await?;
    let message = read.as_ref().map(|read| read.grade.message(&due.subject));
    let is_known = message.as_ref() == due.body.as_ref().map(|body| &body.0);
    let Some((read, message)) = read.zip(message).filter(|_| !is_known) else {
        let state = if due.body.is_some() { DeliveryState::Sent } else { DeliveryState::Idle };
        let mut tx = service.db.write().await?;
        deliveries::settle_delivery(&mut tx, due, state).await?;
        tx.commit().await?;
        return Ok(true);
    };
    let now = service.clock.now();
    let timestamp = next_timestamp(now, due.stamped_at);
    let mut tx = service.db.write().await?;
    let is_claimed = deliveries::claim_delivery(&mut tx, due, timestamp, now.plus_s(LEASE_S)).await?;
    tx.commit().await?;
    if !is_claimed {
        return Ok(true);
    }
    let sent = send_message(service, platform, due, &read.title, stamp_message(message.clone(), timestamp)).await;
    note_sent(service, due, &Tried { read: &read, message: &message, timestamp }, sent).await
}

/// A message that was sent.
struct Tried<'a> {
    read: &'a ReadGrade,
    message: &'a Value,
    timestamp: Moment,
}

/// Records the result of a try. Returns false if the platform should be left alone for now.
async fn note_sent(
    service: &Service,
    due: &DueDelivery,
    tried: &Tried<'_>,
    sent: Result<u16, Failure>,
) -> Result<bool, Error> {
    let now = service.clock.now();
    let mut result = DeliveryResult {
        timestamp: tried.timestamp,
        state: DeliveryState::Sent,
        next_run_at: None,
        tries: 0,
        body: None,
        status: None,
        answer: None,
        sent_at: None,
    };
    let goes_on = match sent {
        Ok(status) => {
            (result.body, result.status, result.sent_at) = (Some(tried.message), Some(status), Some(now));
            true
        }
        Err(Failure::Service(error)) => return Err(error),
        Err(Failure::Postponed) => {
            result.body = due.body.as_ref().map(|body| &body.0);
            (result.state, result.next_run_at, result.tries) = (DeliveryState::Waiting, Some(now), due.tries);
            false
        }
        Err(Failure::Refused(status, answer)) => {
            let is_final = status.is_some_and(|status| grade_service::is_final(status, &answer));
            result.tries = due.tries + 1;
            let again = retry_delay_s(result.tries).filter(|_| !is_final).map(|delay_s| now.plus_s(delay_s));
            result.state = if again.is_some() { DeliveryState::Waiting } else { DeliveryState::Stopped };
            (result.next_run_at, result.status, result.answer) = (again, status, Some(answer));
            is_final
        }
    };
    let mut tx = service.db.write().await?;
    let is_new = deliveries::note_result(&mut tx, due, &result).await?;
    if is_new && result.state == DeliveryState::Stopped {
        let details = json!({ "status": result.status, "tries": result.tries });
        AuditEntry::new(due.school_id, Actor::Worker, "platform.grade_refused", due.id)
            .with(details)
            .append(&mut tx, now)
            .await?;
        if let Some(assignment) = tried.read.assignment {
            let trainee = PersonKey { school_id: due.school_id, person_id: due.person_id };
            notices::tell_refused_grade(&mut tx, trainee, assignment, now).await?;
        }
    }
    tx.commit().await?;
    Ok(goes_on)
}

/// Posts a message to the line item of a link, which is found or created if it is not known. Returns
/// the HTTP status.
async fn send_message(
    service: &Service,
    platform: &Platform,
    due: &DueDelivery,
    title: &str,
    message: Value,
) -> Result<u16, Failure> {
    let line_item = match &due.lineitem_url {
        Some(known) => known.clone(),
        None => settle_line_item(service, platform, due, title).await?,
    };
    let address = scores_url(&line_item).ok_or_else(|| Failure::Refused(None, "malformed line item".to_owned()))?;
    let content = Content { media_type: SCORE, body: message.to_string().into_bytes() };
    Ok(ask(service, platform, &request(SCORE_SCOPE, &address, "application/json", Some(content))).await?.status)
}

const fn request<'a>(
    scopes: &'a str,
    address: &'a str,
    accept: &'static str,
    content: Option<Content>,
) -> ServiceRequest<'a> {
    ServiceRequest { scopes, address, accept, content, largest_answer: LARGEST_ANSWER }
}

/// Sends a request; every other answer than a success is a refusal.
async fn ask(service: &Service, platform: &Platform, request: &ServiceRequest<'_>) -> Result<Answer, Failure> {
    let answer = services::send_request(service, platform, request).await?;
    match answer.status {
        200..300 => Ok(answer),
        status => Err(Failure::Refused(Some(status), shorten_answer(&answer.body))),
    }
}

/// Finds the line item of a link, or creates it, and stores its address.
async fn settle_line_item(
    service: &Service,
    platform: &Platform,
    due: &DueDelivery,
    title: &str,
) -> Result<String, Failure> {
    let malformed = || Failure::Refused(None, "malformed line items".to_owned());
    let resource = GradedPage::of_path(&due.page).map(|page| page.resource_id()).ok_or_else(malformed)?;
    let items = due.lineitems_url.as_deref().ok_or_else(malformed)?;
    let search = search_url(items, &resource).ok_or_else(malformed)?;
    let found = ask(service, platform, &request(ITEM_SCOPE, &search, ITEMS, None)).await?;
    let found: Vec<LineItem> = serde_json::from_slice(&found.body).map_err(|_| malformed())?;
    let item = match found.into_iter().find(|item| item.is_for(&resource, &due.resource_link_id)) {
        Some(item) => item,
        None => {
            let label = if title.is_empty() { &resource } else { title };
            let new = describe_line_item(label, &resource, &due.resource_link_id);
            let content = Content { media_type: ITEM, body: new.to_string().into_bytes() };
            let made = ask(service, platform, &request(ITEM_SCOPE, items, ITEM, Some(content))).await?;
            serde_json::from_slice(&made.body).map_err(|_| malformed())?
        }
    };
    store_line_item(service, due, &item.id).await.map_err(Failure::Service)?;
    Ok(item.id)
}

async fn store_line_item(service: &Service, due: &DueDelivery, line_item: &str) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    courses::set_line_item(&mut tx, due.school_id, due.link_id, line_item).await?;
    Ok(tx.commit().await?)
}

/// Has a grade sent again, at the request of an administrator.
///
/// # Errors
/// Fails if no such grade waits or was refused, or the database fails.
pub async fn retry(service: &Service, by: &CurrentPerson, platform: PlatformId, id: DeliveryId) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    if !deliveries::retry_delivery(&mut tx, by.school_id, platform, id).await? {
        return Err(Error::NotFound);
    }
    AuditEntry::by(by, "platform.grade_retried", id).append(&mut tx, service.clock.now()).await?;
    Ok(tx.commit().await?)
}
