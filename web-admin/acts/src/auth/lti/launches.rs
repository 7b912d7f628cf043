//! A launch from a learning platform: its beginning, and its end.

use std::net::IpAddr;

use model::PersonKey;
use model::auth::deep_linking::DeepLinkingRequest;
use model::auth::federation::{Claims, ProvenIdentity};
use model::auth::lti::{Launch, LoginInitiation, own_target};
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::PlatformLinkId;
use platform::openid::{ExpectedToken, LaunchRequest};
use platform::secret;
use store::auth::lti::courses::DeployedPlatform;
use store::auth::lti::launches::BegunLaunch;
use store::auth::lti::platforms::Platform;
use store::auth::lti::{content_choices, courses, deliveries, launches, platforms};
use store::auth::rate_limits as counts;

use crate::auth::federation::documents::{self, DocumentError, refuse as fail};
use crate::auth::federation::sources::{self, IdentitySource};
use crate::auth::rate_limits;
use crate::error::Error;
use crate::service::Service;

/// Lifetime of a launch that the platform has not confirmed, in s.
pub const LAUNCH_S: i64 = 10 * 60;
/// Lifetime of a choice of content, in s.
const CHOICE_S: i64 = 3600;
/// Maximum number of deployments of a platform.
const MOST_DEPLOYMENTS: u32 = 500;

/// Returns the address at which platforms initiate logins.
#[must_use]
pub fn login_url(service: &Service) -> String {
    format!("{}/lti/login", service.config.address())
}

/// Returns the address to which platforms post launches.
#[must_use]
pub fn launch_url(service: &Service) -> String {
    format!("{}/lti/launch", service.config.address())
}

/// Returns the learning platform that has initiated a login.
///
/// # Errors
/// Fails if the database fails. The inner error is the reason of a refusal.
pub async fn find_initiator(
    service: &Service,
    asked: &LoginInitiation,
) -> Result<Result<Platform, SignInRefusal>, Error> {
    let client_id = Some(asked.client_id.as_str()).filter(|id| !id.is_empty());
    let found = platforms::find_registration(service.db.reader(), &asked.iss, client_id).await?;
    // Without a school there is no audit log to add a row to.
    Ok(found.ok_or(SignInRefusal::Platform))
}

/// A launch that was begun.
#[derive(Clone, Debug)]
pub struct LaunchStart {
    /// Address of the platform to open.
    pub address: String,
    /// State of the launch, which names its cookie.
    pub state: String,
    /// Value of the cookie.
    pub browser_token: String,
}

/// Begins a launch.
///
/// # Errors
/// Fails if the database fails. The inner error is the reason of a refusal, which is in the audit
/// log.
pub async fn begin_launch(
    service: &Service,
    platform: &Platform,
    asked: &LoginInitiation,
) -> Result<Result<LaunchStart, SignInRefusal>, Error> {
    let source = IdentitySource::from(platform);
    let refused = if source.is_disabled {
        Some(SignInRefusal::Disabled)
    } else if !asked.is_acceptable() {
        Some(SignInRefusal::Malformed)
    } else if own_target(&asked.target_link_uri, &service.config.address()).is_none() {
        Some(SignInRefusal::Target)
    } else {
        None
    };
    if let Some(reason) = refused {
        return sources::refuse(service, &source, reason).await;
    }
    let endpoint = match service.outgoing.rules().check(&platform.settings.auth_url) {
        Ok(endpoint) => endpoint,
        Err(why) => return sources::refuse_by(service, &source, fail(SignInRefusal::Unreachable, why)).await,
    };
    let (state, nonce, browser_token) = (secret::random_hex()?, secret::random_hex()?, secret::random_hex()?);
    let now = service.clock.now();
    let message_hint = Some(asked.lti_message_hint.clone()).filter(|hint| !hint.is_empty());
    let begun = BegunLaunch {
        school_id: platform.school_id,
        platform_id: platform.id,
        browser_sha256: secret::token_sha256(&browser_token).to_vec(),
        nonce_sha256: secret::token_sha256(&nonce).to_vec(),
        login_hint: asked.login_hint.clone(),
        message_hint,
        target_link_uri: asked.target_link_uri.clone(),
        expires_at: now.plus_s(LAUNCH_S),
    };
    let mut tx = service.db.write().await?;
    launches::add_launch(&mut tx, &secret::token_sha256(&state), &begun, now).await?;
    tx.commit().await?;
    let request = LaunchRequest {
        client_id: &platform.settings.client_id,
        redirect_uri: &launch_url(service),
        login_hint: &begun.login_hint,
        message_hint: begun.message_hint.as_deref(),
        state: &state,
        nonce: &nonce,
    };
    Ok(Ok(LaunchStart { address: request.address(&endpoint).to_string(), state, browser_token }))
}

/// A platform's answer, as the browser posts it.
#[derive(Clone, Copy, Debug)]
pub struct LaunchAnswer<'a> {
    /// State of the launch.
    pub state: &'a str,
    /// The ID token.
    pub id_token: Option<&'a str>,
    /// Error code of the platform.
    pub error: Option<&'a str>,
    /// Token of the launch's cookie, if the browser has sent it.
    pub browser_token: Option<&'a str>,
    /// Client address.
    pub from: IpAddr,
}

/// A launch that the platform has confirmed.
#[derive(Clone, Debug)]
pub struct ConfirmedLaunch {
    /// Learning platform.
    pub platform: Platform,
    /// Whom it has confirmed.
    pub identity: ProvenIdentity,
    /// Path to open.
    pub page: String,
    /// Link of the launch; `None` for a choice of content.
    pub link: Option<PlatformLinkId>,
}

/// Result of a launch that is not refused.
#[derive(Clone, Debug)]
pub enum LaunchOutcome {
    /// The platform has confirmed the user.
    Confirmed(Box<ConfirmedLaunch>),
    /// The browser has not sent the cookie of the launch: it begins again with its parameters.
    Again(Box<(Platform, LoginInitiation)>),
}

/// Finishes a launch. The state is used up even by a refusal, which is in the audit log.
///
/// # Errors
/// Fails if the database fails, or the platform sends too many launches. The inner error is the
/// reason of a refusal.
pub async fn finish_launch(
    service: &Service,
    answer: LaunchAnswer<'_>,
) -> Result<Result<LaunchOutcome, SignInRefusal>, Error> {
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let begun = launches::take_launch(&mut tx, &secret::token_sha256(answer.state)).await?;
    let Some(begun) = begun else {
        // Anybody can send such an answer, so it is only counted.
        counts::count_unknown_sign_in(&mut tx, now).await?;
        tx.commit().await?;
        tracing::warn!(from = %answer.from, "answer of a learning platform without its launch");
        return Ok(Err(SignInRefusal::NoFlow));
    };
    tx.commit().await?;
    let platform = platforms::find_platform(service.db.reader(), begun.school_id, begun.platform_id).await?;
    let platform = platform.ok_or(Error::NotFound)?;
    let source = IdentitySource::from(&platform);
    if begun.expires_at <= now {
        return sources::refuse(service, &source, SignInRefusal::NoFlow).await;
    }
    if source.is_disabled {
        return sources::refuse(service, &source, SignInRefusal::Disabled).await;
    }
    let browser = answer.browser_token.map(secret::token_sha256);
    if browser.is_none_or(|own| own[..] != begun.browser_sha256) {
        let again = LoginInitiation {
            iss: platform.settings.issuer.clone(),
            client_id: platform.settings.client_id.clone(),
            login_hint: begun.login_hint,
            lti_message_hint: begun.message_hint.unwrap_or_default(),
            target_link_uri: begun.target_link_uri,
        };
        return Ok(Ok(LaunchOutcome::Again(Box::new((platform, again)))));
    }
    match read_message(service, &platform, &begun, answer).await {
        Ok(message) => accept(service, platform, message).await,
        Err(error) => sources::refuse_by(service, &source, error).await,
    }
}

/// A verified message of a learning platform.
enum PlatformMessage {
    /// The launch of a link.
    Launch(Launch),
    /// A request for content.
    Choice(DeepLinkingRequest),
}

impl PlatformMessage {
    fn read(service: &Service, platform: &Platform, claims: &Claims) -> Result<Self, DocumentError> {
        let (settings, address) = (&platform.settings, service.config.address());
        let refused = |reason| fail(reason, "claims of the launch");
        if !DeepLinkingRequest::is_request(claims) {
            return Launch::read(settings, claims, &address).map(Self::Launch).map_err(refused);
        }
        let asked = DeepLinkingRequest::read(settings, claims, &address).map_err(refused)?;
        // The browser opens this address, so only its form is checked.
        let returns = service.outgoing.rules().check(&asked.content.return_url);
        returns.map_err(|why| fail(SignInRefusal::Malformed, why))?;
        Ok(Self::Choice(asked))
    }

    fn deployment(&self) -> &str {
        match self {
            Self::Launch(launch) => &launch.deployment,
            Self::Choice(asked) => &asked.deployment,
        }
    }
}

/// Verifies the ID token of a launch and reads its claims.
async fn read_message(
    service: &Service,
    platform: &Platform,
    begun: &BegunLaunch,
    answer: LaunchAnswer<'_>,
) -> Result<PlatformMessage, DocumentError> {
    if let Some(error) = answer.error {
        return Err(fail(SignInRefusal::Denied, error.chars().take(40).collect::<String>()));
    }
    let Some(id_token) = answer.id_token else {
        return Err(fail(SignInRefusal::Malformed, "an answer without an ID token"));
    };
    let settings = &platform.settings;
    let expected = ExpectedToken {
        issuer: &settings.issuer,
        client_id: &settings.client_id,
        nonce_sha256: &begun.nonce_sha256,
        access_token: None,
        now: service.clock.now(),
    };
    let verified =
        documents::verify_by_keys(service, platform.school_id, &settings.keys_url, id_token, &expected).await;
    let claims = match verified {
        // A platform names no subject in an anonymous launch.
        Err(DocumentError::Provider(SignInRefusal::Subject, why)) => Err(fail(SignInRefusal::Anonymous, why)),
        verified => verified,
    }?;
    PlatformMessage::read(service, platform, &claims)
}

/// Records the person of a launch, whose grades are sent to the platform from now on if the link has
/// grades.
///
/// # Errors
/// Fails if the database fails.
pub async fn note_user(service: &Service, link: PlatformLinkId, person: PersonKey, subject: &str) -> Result<(), Error> {
    let mut tx = service.db.write().await?;
    deliveries::put_delivery(&mut tx, link, person, subject, service.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Takes a verified message, if its deployment is admitted.
async fn accept(
    service: &Service,
    platform: Platform,
    message: PlatformMessage,
) -> Result<Result<LaunchOutcome, SignInRefusal>, Error> {
    rate_limits::take_launch(service, platform.id).await?;
    let now = service.clock.now();
    let mut tx = service.db.write().await?;
    let deployment = message.deployment();
    let known = platforms::find_deployment(&mut *tx, platform.id, deployment).await?;
    if known.is_none_or(|known| known.admitted_at.is_none()) {
        platforms::add_deployment(&mut tx, &platform, deployment, MOST_DEPLOYMENTS, now).await?;
        tx.commit().await?;
        return sources::refuse(service, &IdentitySource::from(&platform), SignInRefusal::Deployment).await;
    }
    let (identity, page, link) = match message {
        PlatformMessage::Launch(launch) => {
            courses::put_launch(&mut tx, &platform, &launch, now).await?;
            let link = courses::find_link(&mut *tx, &platform, &launch).await?;
            (launch.identity, launch.page, link)
        }
        PlatformMessage::Choice(asked) => {
            if let Some(context) = &asked.context {
                let deployed = DeployedPlatform { platform: &platform, deployment: &asked.deployment };
                courses::put_context(&mut tx, deployed, context, now).await?;
            }
            let choice = content_choices::add_choice(&mut tx, &platform, &asked, now.plus_s(CHOICE_S), now).await?;
            (asked.identity, format!("/lti/deep-link/{choice}"), None)
        }
    };
    tx.commit().await?;
    Ok(Ok(LaunchOutcome::Confirmed(Box::new(ConfirmedLaunch { platform, identity, page, link }))))
}
