//! Documents of providers: fetched once for everybody who waits, kept for an hour.

use model::Moment;
use model::auth::federation::Claims;
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::SchoolId;
use platform::openid::{Discovery, ExpectedToken, KeySet, verify_id_token};
use platform::outgoing::{Answer, Call, CallFailed};
use platform::secret;
use store::auth::federation::providers;
use store::auth::federation::providers::ProviderDocument;
use url::Url;

use crate::error::Error;
use crate::service::Service;

/// How long a document is used, in s.
const LIFETIME_S: i64 = 3600;
/// Minimum time between two fetches of a key set because of an unknown key, in s.
const REFETCH_S: i64 = 60;

/// Why a document is not available.
#[derive(Debug)]
pub(in crate::auth) enum DocumentError {
    /// The provider does not answer as it should; the reason, in English.
    Provider(SignInRefusal, String),
    /// An error of this service.
    Service(Error),
}

impl<E: Into<Error>> From<E> for DocumentError {
    fn from(error: E) -> Self {
        Self::Service(error.into())
    }
}

/// Creates the error of a provider; `why` is in English.
pub(in crate::auth) fn refuse(reason: SignInRefusal, why: impl ToString) -> DocumentError {
    DocumentError::Provider(reason, why.to_string())
}

fn unreachable(why: impl ToString) -> DocumentError {
    refuse(SignInRefusal::Unreachable, why)
}

fn malformed(why: impl ToString) -> DocumentError {
    refuse(SignInRefusal::Malformed, why)
}

/// Returns the discovery document of an issuer, fetched now with `anew`; every address in it is
/// permitted.
pub(in crate::auth) async fn read_discovery(
    service: &Service,
    school: SchoolId,
    issuer: &str,
    anew: bool,
) -> Result<Discovery, DocumentError> {
    let oldest = service.clock.now().plus_s(if anew { 0 } else { -LIFETIME_S });
    let body = fetch(service, school, &Discovery::address_of(issuer), oldest).await?;
    let discovery = Discovery::parse(body.as_bytes(), issuer).map_err(|(reason, why)| refuse(reason, why))?;
    for address in discovery.addresses() {
        service.outgoing.rules().check(address.as_str()).map_err(unreachable)?;
    }
    Ok(discovery)
}

/// Returns the keys at an address. With `anew`, they were fetched within the last minute.
async fn read_keys(service: &Service, school: SchoolId, address: &str, anew: bool) -> Result<KeySet, DocumentError> {
    let lifetime_s = if anew { REFETCH_S } else { LIFETIME_S };
    let oldest = service.clock.now().plus_s(-lifetime_s);
    let body = fetch(service, school, address, oldest).await?;
    KeySet::parse(body.as_bytes()).map_err(malformed)
}

/// Verifies an ID token by the keys at an address, and returns its claims. An unknown key makes the
/// service fetch them again.
pub(in crate::auth) async fn verify_by_keys(
    service: &Service,
    school: SchoolId,
    keys_url: &str,
    id_token: &str,
    expected: &ExpectedToken<'_>,
) -> Result<Claims, DocumentError> {
    let keys = read_keys(service, school, keys_url, false).await?;
    let verified = match verify_id_token(id_token, &keys, expected) {
        Err(SignInRefusal::Key) => {
            let keys = read_keys(service, school, keys_url, true).await?;
            verify_id_token(id_token, &keys, expected)
        }
        verified => verified,
    };
    verified.map_err(|reason| refuse(reason, "ID token"))
}

/// Returns the document at an address, fetched after `oldest`.
async fn fetch(service: &Service, school: SchoolId, address: &str, oldest: Moment) -> Result<String, DocumentError> {
    let url_sha256 = secret::token_sha256(address);
    let kept = async || {
        let found = providers::find_document(service.db.reader(), &url_sha256).await?;
        Ok::<_, DocumentError>(found.filter(|found| found.fetched_at > oldest).map(|found| found.body))
    };
    if let Some(body) = kept().await? {
        return Ok(body);
    }
    let turn = service.outgoing.document_turn(address);
    let _turn = turn.lock().await;
    if let Some(body) = kept().await? {
        return Ok(body);
    }
    let body = fetch_anew(service, school, address).await?;
    let document = ProviderDocument { body, fetched_at: service.clock.now() };
    let mut tx = service.db.write().await?;
    providers::put_document(&mut tx, address, &url_sha256, &document).await?;
    tx.commit().await?;
    Ok(document.body)
}

/// Returns the document at an address, fetched now and not kept.
pub(in crate::auth) async fn fetch_anew(
    service: &Service,
    school: SchoolId,
    address: &str,
) -> Result<String, DocumentError> {
    let url = service.outgoing.rules().check(address).map_err(unreachable)?;
    service.outgoing.count_document(school, &url).map_err(unreachable)?;
    let answer = get_document(service, url).await.map_err(unreachable)?;
    if answer.status != 200 || !answer.is_json {
        return Err(unreachable(format!("HTTP status {}, JSON: {}", answer.status, answer.is_json)));
    }
    String::from_utf8(answer.body).map_err(malformed)
}

/// Fetches a document, following one redirect on the same host.
async fn get_document(service: &Service, url: Url) -> Result<Answer, CallFailed> {
    let get = |url| service.outgoing.send(Call::get(url));
    let answer = get(url.clone()).await?;
    let Some(location) = answer.location.as_ref().filter(|_| (300..400).contains(&answer.status)) else {
        return Ok(answer);
    };
    let target = url.join(location).map_err(|error| CallFailed::Address(error.to_string()))?;
    if target.host() != url.host() || target.port_or_known_default() != url.port_or_known_default() {
        return Err(CallFailed::Address("a redirect to another host".to_owned()));
    }
    get(service.outgoing.rules().check(target.as_str())?).await
}
