//! Dynamic registration at a learning platform (LTI Dynamic Registration 1.0).

use data_encoding::HEXLOWER;
use model::CurrentPerson;
use model::auth::platform_registration::{
    PlatformConfiguration, RegisteredTool, RegistrationInitiation, ToolAddresses,
};
use model::ids::PlatformId;
use platform::outgoing::{Call, Content};
use platform::secret;
use store::auth::lti::platforms;

use super::launches::{launch_url, login_url};
use super::platforms::{add_platform, admit_deployment, check_room, check_settings};
use crate::auth::federation::client_keys::keys_uri;
use crate::auth::federation::documents::{self, DocumentError};
use crate::error::Error;
use crate::service::Service;

/// Returns the address at which platforms ask to be registered.
#[must_use]
pub fn register_url(service: &Service) -> String {
    format!("{}/lti/register", service.config.address())
}

/// A learning platform that asks to be registered.
#[derive(Clone, Debug)]
pub struct AskingPlatform {
    /// Its configuration.
    pub configuration: PlatformConfiguration,
    /// Hash of the configuration, so that only the one that was shown is registered.
    pub digest: String,
}

/// Fetches the configuration of a learning platform; stores nothing.
///
/// # Errors
/// Returns [`Error::Unprocessable`] with the reason if the platform cannot be registered.
pub async fn read_configuration(
    service: &Service,
    by: &CurrentPerson,
    asked: &RegistrationInitiation,
) -> Result<AskingPlatform, Error> {
    let address = asked.openid_configuration.as_str();
    let refused = |why| Error::Unprocessable(tr!("configuration: {why}", why = why));
    let url = service.outgoing.rules().check(address).map_err(|why| refused(why.to_string()))?;
    let body = match documents::fetch_anew(service, by.school_id, address).await {
        Ok(body) => body,
        Err(DocumentError::Service(error)) => return Err(error),
        Err(DocumentError::Provider(_, why)) => return Err(refused(why)),
    };
    let configuration = PlatformConfiguration::parse(body.as_bytes(), &url).map_err(Error::Unprocessable)?;
    check_settings(service, &configuration.settings("-"))?;
    for (field, address) in
        [(tr!("issuer"), &configuration.issuer), (tr!("registration URL"), &configuration.registration_endpoint)]
    {
        if let Err(why) = service.outgoing.rules().check(address) {
            return Err(Error::Unprocessable(tr!("{field}: {why}", field = field, why = why)));
        }
    }
    let read = serde_json::to_string(&configuration).map_err(anyhow::Error::from)?;
    Ok(AskingPlatform { configuration, digest: HEXLOWER.encode(&secret::token_sha256(&read)) })
}

/// Registers this service at a learning platform, and the platform here. `digest` is that of the
/// configuration that was shown.
///
/// # Errors
/// Returns [`Error::Unprocessable`] with the reason if the configuration has changed, the platform
/// refuses, or it is registered already.
pub async fn register_platform(
    service: &Service,
    by: &CurrentPerson,
    asked: &RegistrationInitiation,
    digest: &str,
) -> Result<PlatformId, Error> {
    let AskingPlatform { configuration, digest: current } = read_configuration(service, by, asked).await?;
    if current != digest {
        let why = tr!("the learning platform has changed its configuration: check it again");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    check_room(service, by).await?;
    let registered = register_tool(service, by, asked, &configuration).await?;
    let id = add_platform(service, by, &configuration.settings(&registered.client_id)).await?;
    if let Some(deployment) = registered.deployment() {
        let added = platforms::find_platform(service.db.reader(), by.school_id, id).await?.ok_or(Error::NotFound)?;
        let mut tx = service.db.write().await?;
        platforms::add_deployment(&mut tx, &added, &deployment, 1, service.clock.now()).await?;
        tx.commit().await?;
        admit_deployment(service, by, id, &deployment).await?;
    }
    Ok(id)
}

/// Sends the registration to the platform.
async fn register_tool(
    service: &Service,
    by: &CurrentPerson,
    asked: &RegistrationInitiation,
    configuration: &PlatformConfiguration,
) -> Result<RegisteredTool, Error> {
    let refused = |why| Error::Unprocessable(tr!("the learning platform has not registered Stylet: {why}", why = why));
    let rules = service.outgoing.rules();
    let url = rules.check(&configuration.registration_endpoint).map_err(|why| refused(why.to_string()))?;
    service.outgoing.count_document(by.school_id, &url).map_err(|why| refused(why.to_string()))?;
    let tool = ToolAddresses {
        address: &service.config.address(),
        login_url: &login_url(service),
        launch_url: &launch_url(service),
        keys_uri: &keys_uri(service),
    };
    let content = Content { media_type: "application/json", body: tool.registration().to_string().into_bytes() };
    let token = Some(asked.registration_token.as_str()).filter(|token| !token.is_empty());
    let call = Call::post(url, content).with_authorization(token.map(|token| format!("Bearer {token}")));
    let answer = service.outgoing.send(call).await.map_err(|why| refused(why.to_string()))?;
    if !(200..300).contains(&answer.status) {
        return Err(refused(format!("HTTP status {}", answer.status)));
    }
    let registered: Result<RegisteredTool, _> = serde_json::from_slice(&answer.body);
    registered.map_err(|error| refused(error.to_string()))
}
