//! Members of a course, read from its learning platform (LTI Names and Role Provisioning Services
//! 2.0).

use std::collections::BTreeSet;
use std::time::Duration;

use model::auth::platform_members::{MEMBERS_SCOPE, MEMBERS_TYPE, find_next_page, read_members};
use model::people::roster::{CourseMember, MAX_ROWS};
use platform::clock;
use platform::outgoing::{Answer, CallFailed};
use store::auth::lti::platforms::Platform;
use tokio::time::{Instant, sleep, timeout_at};
use url::Url;

use super::services::{ServiceFailure, ServiceRequest, send_request};
use crate::error::Error;
use crate::service::Service;

/// Maximum number of pages.
const MOST_PAGES: usize = 200;
/// Maximum size of a page, in bytes.
const LARGEST_PAGE: u64 = 1024 * 1024;
/// Number of members that a page should have; a platform may choose another number.
const PAGE_LENGTH: &str = "200";
/// Timeout for all pages: less than a request of a browser may take.
const TIMEOUT: Duration = Duration::from_secs(25);
/// Time to wait if a school has sent many requests to the platform.
const PAUSE: Duration = Duration::from_secs(3);

/// Returns all members of a course, from the address that its launches name.
///
/// # Errors
/// Returns [`Error::Unprocessable`] with the reason if the platform does not answer as it should; then
/// no member is returned, since a part of the course would be missing.
pub async fn read_course(service: &Service, platform: &Platform, address: &str) -> Result<Vec<CourseMember>, Error> {
    let until = Instant::from_std(clock::instant()) + TIMEOUT;
    let read = timeout_at(until, read_pages(service, platform, address)).await;
    let read = read.unwrap_or_else(|_| Err(refuse("the platform took too long")));
    read.map_err(|failure| match failure {
        ServiceFailure::Service(error) => error,
        why => Error::Unprocessable(tr!("the members cannot be read (technical reason, in English: {why})", why = why)),
    })
}

fn refuse(why: impl ToString) -> ServiceFailure {
    ServiceFailure::Call(CallFailed::NoAnswer(why.to_string()))
}

async fn read_pages(
    service: &Service,
    platform: &Platform,
    address: &str,
) -> Result<Vec<CourseMember>, ServiceFailure> {
    let mut page = service.outgoing.rules().check(address)?;
    if !page.query_pairs().any(|(name, _)| name == "limit") {
        page.query_pairs_mut().append_pair("limit", PAGE_LENGTH);
    }
    let (mut members, mut seen) = (Vec::new(), BTreeSet::new());
    for _ in 0..MOST_PAGES {
        if !seen.insert(page.clone()) {
            return Err(refuse("the pages of members form a circle"));
        }
        let answer = fetch_page(service, platform, &page).await?;
        if answer.status != 200 || !answer.is_json {
            return Err(refuse(format!("HTTP status {}, JSON: {}", answer.status, answer.is_json)));
        }
        members.extend(read_members(&answer.body, platform.settings.number_claim).map_err(refuse)?);
        if members.len() > MAX_ROWS {
            return Err(refuse(format!("more than {MAX_ROWS} members")));
        }
        match find_next_page(&answer.link.unwrap_or_default(), &page).map_err(refuse)? {
            Some(next) => page = next,
            None => return Ok(members),
        }
    }
    Err(refuse(format!("more than {MOST_PAGES} pages of members")))
}

/// Fetches a page; waits if the school has sent too many requests.
async fn fetch_page(service: &Service, platform: &Platform, page: &Url) -> Result<Answer, ServiceFailure> {
    let request = ServiceRequest {
        scopes: MEMBERS_SCOPE,
        address: page.as_str(),
        accept: MEMBERS_TYPE,
        content: None,
        largest_answer: LARGEST_PAGE,
    };
    loop {
        match send_request(service, platform, &request).await {
            Err(ServiceFailure::Call(CallFailed::TooMany)) => sleep(PAUSE).await,
            answered => return answered,
        }
    }
}
