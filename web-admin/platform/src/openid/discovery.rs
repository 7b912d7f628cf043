//! Discovery documents (OpenID Connect Discovery 1.0).

use model::auth::federation::ClientAuthentication;
use model::auth::sign_in_refusal::SignInRefusal;
use serde::Deserialize;
use url::Url;

/// The part of a discovery document that this service uses.
#[derive(Clone, Debug, Deserialize)]
pub struct Discovery {
    /// Issuer identifier.
    pub issuer: String,
    /// Address of the provider's sign-in page.
    pub authorization_endpoint: Url,
    /// Address that exchanges a code for tokens.
    pub token_endpoint: Url,
    /// Address of the provider's keys.
    pub jwks_uri: Url,
    /// Address of the user information.
    pub userinfo_endpoint: Option<Url>,
    /// Methods by which a client authenticates.
    #[serde(default = "default_methods")]
    token_endpoint_auth_methods_supported: Vec<String>,
    /// Signature algorithms of a client's assertions; empty if unknown.
    #[serde(default)]
    token_endpoint_auth_signing_alg_values_supported: Vec<String>,
    /// Whether the answer names the issuer (RFC 9207).
    #[serde(default)]
    pub authorization_response_iss_parameter_supported: bool,
}

fn default_methods() -> Vec<String> {
    vec!["client_secret_basic".to_owned()]
}

/// How this service authenticates at a token endpoint (OpenID Connect Core 1.0, section 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenAuthentication {
    /// By the secret, in the header `Authorization`: `client_secret_basic`.
    Header,
    /// By the secret, in the form: `client_secret_post`.
    Form,
    /// By an assertion signed with RS256: `private_key_jwt`.
    Assertion,
}

impl Discovery {
    /// Returns the address of an issuer's document.
    #[must_use]
    pub fn address_of(issuer: &str) -> String {
        format!("{}/.well-known/openid-configuration", issuer.trim_end_matches('/'))
    }

    /// Parses a document.
    ///
    /// # Errors
    /// Returns the reason if it is malformed or describes another issuer, with the detail in English
    /// or that issuer.
    pub fn parse(body: &[u8], issuer: &str) -> Result<Self, (SignInRefusal, String)> {
        let read: Self = serde_json::from_slice(body).map_err(|error| (SignInRefusal::Malformed, error.to_string()))?;
        if read.issuer != issuer {
            return Err((SignInRefusal::Issuer, read.issuer));
        }
        Ok(read)
    }

    /// Returns how this service authenticates by its secret or its key; `None` if the provider does
    /// not support it.
    #[must_use]
    pub fn find_authentication(&self, by: ClientAuthentication) -> Option<TokenAuthentication> {
        let has = |name: &str| self.token_endpoint_auth_methods_supported.iter().any(|method| method == name);
        let algorithms = &self.token_endpoint_auth_signing_alg_values_supported;
        let takes_rs256 = algorithms.is_empty() || algorithms.iter().any(|name| name == "RS256");
        match by {
            ClientAuthentication::Secret if has("client_secret_basic") => Some(TokenAuthentication::Header),
            ClientAuthentication::Secret if has("client_secret_post") => Some(TokenAuthentication::Form),
            ClientAuthentication::Key if has("private_key_jwt") && takes_rs256 => Some(TokenAuthentication::Assertion),
            _ => None,
        }
    }

    /// Returns every address of the document.
    pub fn addresses(&self) -> impl Iterator<Item = &Url> {
        [&self.authorization_endpoint, &self.token_endpoint, &self.jwks_uri].into_iter().chain(&self.userinfo_endpoint)
    }
}
