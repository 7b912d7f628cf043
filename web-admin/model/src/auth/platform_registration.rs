//! Dynamic registration at a learning platform (LTI Dynamic Registration 1.0).

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use url::Url;

use super::lti::{NumberClaim, PlatformSettings, web_origin};
use crate::single_line_text;

/// Claim with the configuration of a tool.
const TOOL: &str = "https://purl.imsglobal.org/spec/lti-tool-configuration";
/// Scopes of the services that this service uses.
const SCOPES: [&str; 4] = [
    "https://purl.imsglobal.org/spec/lti-ags/scope/lineitem",
    "https://purl.imsglobal.org/spec/lti-ags/scope/score",
    "https://purl.imsglobal.org/spec/lti-ags/scope/result.readonly",
    "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly",
];

/// A registration that a platform initiates; the names are those of the protocol.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct RegistrationInitiation {
    /// Address of the platform's configuration.
    pub openid_configuration: String,
    /// Token that permits the registration; empty if the platform sent none.
    pub registration_token: String,
}

/// The part of a platform's configuration that this service uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlatformConfiguration {
    /// Issuer identifier.
    pub issuer: String,
    /// Address that confirms a launch.
    pub authorization_endpoint: String,
    /// Address that issues access tokens.
    pub token_endpoint: String,
    /// Address of the keys.
    pub jwks_uri: String,
    /// Address that registers a tool.
    pub registration_endpoint: String,
    /// Audience of requests for access tokens.
    #[serde(default)]
    pub authorization_server: Option<String>,
    /// About the platform.
    #[serde(default, rename = "https://purl.imsglobal.org/spec/lti-platform-configuration")]
    about: AboutPlatform,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct AboutPlatform {
    product_family_code: String,
}

impl PlatformConfiguration {
    /// Parses the configuration that was fetched from an address.
    ///
    /// # Errors
    /// Returns the reason in the current language.
    pub fn parse(body: &[u8], address: &Url) -> Result<Self, String> {
        let read: Self = serde_json::from_slice(body).map_err(|error| {
            tr!("the configuration cannot be read (technical reason, in English: {why})", why = error)
        })?;
        let issuer = Url::parse(&read.issuer).ok();
        // Else any platform could register itself as another one.
        if issuer.as_ref().and_then(Url::host) != address.host() {
            return Err(tr!(
                "issuer: “{issuer}”; its host must be that of the configuration, {host}",
                issuer = read.issuer.chars().take(200).collect::<String>(),
                host = address.host_str().unwrap_or_default()
            ));
        }
        Ok(read)
    }

    /// Returns the settings of a client that the platform has registered.
    #[must_use]
    pub fn settings(&self, client_id: &str) -> PlatformSettings {
        let host = Url::parse(&self.issuer).ok().and_then(|url| url.host_str().map(str::to_owned)).unwrap_or_default();
        let product = single_line_text::on_one_line(&self.about.product_family_code);
        let product: String = single_line_text::tidy(&product).chars().take(60).collect();
        PlatformSettings {
            name: if product.is_empty() { host } else { format!("{product} ({host})") },
            issuer: self.issuer.clone(),
            client_id: client_id.to_owned(),
            auth_url: self.authorization_endpoint.clone(),
            token_url: self.token_endpoint.clone(),
            keys_url: self.jwks_uri.clone(),
            token_audience: self.authorization_server.clone().filter(|audience| *audience != self.token_endpoint),
            number_claim: Some(NumberClaim::PersonSourcedId),
            creates_trainees: false,
        }
    }
}

/// Addresses of this service, for its registration.
#[derive(Clone, Copy, Debug)]
pub struct ToolAddresses<'a> {
    /// Public address.
    pub address: &'a str,
    /// Address at which platforms initiate logins.
    pub login_url: &'a str,
    /// Address to which platforms post launches.
    pub launch_url: &'a str,
    /// Address of the public keys.
    pub keys_uri: &'a str,
}

impl ToolAddresses<'_> {
    /// Returns the request that registers this service (LTI Dynamic Registration 1.0, section 3.5).
    #[must_use]
    pub fn registration(&self) -> Value {
        let origin = web_origin(self.address).unwrap_or_default();
        let domain = origin.split_once("://").map_or("", |(_, domain)| domain);
        json!({
            "application_type": "web",
            "response_types": ["id_token"],
            "grant_types": ["client_credentials", "implicit"],
            "initiate_login_uri": self.login_url,
            "redirect_uris": [self.launch_url],
            "client_name": "Stylet",
            "jwks_uri": self.keys_uri,
            "token_endpoint_auth_method": "private_key_jwt",
            "scope": SCOPES.join(" "),
            TOOL: {
                "domain": domain,
                "target_link_uri": self.launch_url,
                "claims": ["iss", "sub", "name", "given_name", "family_name", "email"],
                "messages": [
                    { "type": "LtiResourceLinkRequest" },
                    { "type": "LtiDeepLinkingRequest", "target_link_uri": self.launch_url, "label": "Stylet" },
                ],
            },
        })
    }
}

/// A client that a platform has registered.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct RegisteredTool {
    /// Id of this service at the platform.
    pub client_id: String,
    #[serde(default, rename = "https://purl.imsglobal.org/spec/lti-tool-configuration")]
    tool: RegisteredDeployment,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
struct RegisteredDeployment {
    deployment_id: Option<Value>,
}

impl RegisteredTool {
    /// Returns the deployment that the platform has made.
    #[must_use]
    pub fn deployment(&self) -> Option<String> {
        match self.tool.deployment_id.as_ref()? {
            Value::String(id) if !id.is_empty() && id.len() <= 255 => Some(id.clone()),
            Value::Number(id) => Some(id.to_string()),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(issuer: &str) -> Result<PlatformConfiguration, String> {
        let body = json!({
            "issuer": issuer,
            "authorization_endpoint": "https://lms.example.edu/auth",
            "token_endpoint": "https://lms.example.edu/token",
            "jwks_uri": "https://lms.example.edu/keys",
            "registration_endpoint": "https://lms.example.edu/register",
            "authorization_server": "https://lms.example.edu",
            "https://purl.imsglobal.org/spec/lti-platform-configuration": { "product_family_code": "moodle", "version": "4" },
        });
        let address = Url::parse("https://lms.example.edu/mod/lti/openid-configuration.php").unwrap();
        PlatformConfiguration::parse(body.to_string().as_bytes(), &address)
    }

    #[test]
    fn a_configuration_is_of_its_own_host() {
        for other in ["https://evil.example", "https://lms.example.edu.evil.example", "https://example.edu", "lms", ""]
        {
            assert!(parse(other).is_err_and(|why| why.contains("lms.example.edu")), "{other}");
        }
        let settings = parse("https://lms.example.edu").unwrap().settings("a1");
        assert_eq!((settings.name.as_str(), settings.client_id.as_str()), ("moodle (lms.example.edu)", "a1"));
        assert_eq!(settings.token_audience.as_deref(), Some("https://lms.example.edu"));
        assert_eq!(settings.check(), Ok(()));
        let address = Url::parse("https://lms.example.edu/").unwrap();
        assert!(PlatformConfiguration::parse(b"{}", &address).is_err());
    }

    #[test]
    fn a_registration_names_what_the_service_uses() {
        let tool = ToolAddresses {
            address: "https://training.example.org",
            login_url: "https://training.example.org/lti/login",
            launch_url: "https://training.example.org/lti/launch",
            keys_uri: "https://training.example.org/.well-known/jwks.json",
        };
        let registration = tool.registration();
        assert_eq!(registration[TOOL]["domain"], "training.example.org");
        assert_eq!(registration["redirect_uris"], json!(["https://training.example.org/lti/launch"]));
        assert_eq!(registration["scope"].as_str().unwrap().split(' ').count(), SCOPES.len());
    }

    #[test]
    fn an_answer_may_name_a_deployment() {
        let deployment = |tool: Value| {
            let answer = json!({ "client_id": "a1", TOOL: tool });
            serde_json::from_value::<RegisteredTool>(answer).unwrap().deployment()
        };
        assert_eq!(deployment(json!({ "deployment_id": "7" })).as_deref(), Some("7"));
        assert_eq!(deployment(json!({ "deployment_id": 7 })).as_deref(), Some("7"));
        assert_eq!(deployment(json!({ "deployment_id": "" })), None);
        assert_eq!(deployment(json!({})), None);
    }
}
