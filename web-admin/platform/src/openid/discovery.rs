//! Discovery documents (OpenID Connect Discovery 1.0).

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
    /// Methods by which a client authenticates; by default `client_secret_basic`.
    #[serde(default)]
    token_endpoint_auth_methods_supported: Vec<String>,
    /// Whether the answer names the issuer (RFC 9207).
    #[serde(default)]
    pub authorization_response_iss_parameter_supported: bool,
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
    /// Returns the reason, in English, if it is malformed or describes another issuer.
    pub fn parse(body: &[u8], issuer: &str) -> Result<Self, String> {
        let read: Self = serde_json::from_slice(body).map_err(|error| error.to_string())?;
        if read.issuer != issuer {
            return Err(format!("issuer: \"{}\" instead of \"{issuer}\"", read.issuer));
        }
        Ok(read)
    }

    /// Returns whether the secret is sent in the form instead of the header `Authorization`.
    #[must_use]
    pub fn takes_secret_in_form(&self) -> bool {
        let methods = &self.token_endpoint_auth_methods_supported;
        let has = |name: &str| methods.iter().any(|method| method == name);
        has("client_secret_post") && !has("client_secret_basic")
    }

    /// Returns every address of the document.
    pub fn addresses(&self) -> impl Iterator<Item = &Url> {
        [&self.authorization_endpoint, &self.token_endpoint, &self.jwks_uri].into_iter().chain(&self.userinfo_endpoint)
    }
}
