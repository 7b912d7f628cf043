//! The client of OpenID Connect (OpenID Connect Core 1.0, authorization code flow) and of LTI 1.3:
//! addresses, discovery documents, and verification of ID tokens. Without input and output.

mod access_tokens;
mod client_key;
mod discovery;
mod id_token;
mod launch;
mod signatures;

pub use access_tokens::{AccessTokens, TokenUse};
pub use client_key::{ASSERTION_TYPE, ClientKey, NewClientKey};
pub use discovery::{Discovery, TokenAuthentication};
pub use id_token::{ExpectedToken, KeySet, verify_id_token};
pub use launch::LaunchRequest;

use data_encoding::BASE64URL_NOPAD;
use sha2::{Digest, Sha256};
use url::Url;

use crate::secret;

/// Parameters of a sign-in at a provider.
#[derive(Clone, Debug)]
pub struct FlowSecrets {
    /// Ties the answer to the sign-in.
    pub state: String,
    /// Ties the ID token to the sign-in.
    pub nonce: String,
    /// Ties the authorization code to this service (PKCE, RFC 7636).
    pub code_verifier: String,
}

impl FlowSecrets {
    /// Draws new secrets.
    ///
    /// # Errors
    /// Fails if the operating system's random source fails.
    pub fn random() -> anyhow::Result<Self> {
        Ok(Self { state: secret::random_hex()?, nonce: secret::random_hex()?, code_verifier: secret::random_hex()? })
    }
}

/// A request to the authorization endpoint.
#[derive(Clone, Copy, Debug)]
pub struct AuthorizationRequest<'a> {
    /// Id of this service at the provider.
    pub client_id: &'a str,
    /// Address to which the provider sends its answer.
    pub redirect_uri: &'a str,
    /// Scopes, separated by spaces.
    pub scopes: &'a str,
    /// Whether the user must sign in at the provider again.
    pub anew: bool,
}

impl AuthorizationRequest<'_> {
    /// Returns the address to which the browser is sent.
    #[must_use]
    pub fn address(&self, discovery: &Discovery, secrets: &FlowSecrets) -> Url {
        let mut url = discovery.authorization_endpoint.clone();
        let challenge = BASE64URL_NOPAD.encode(&Sha256::digest(secrets.code_verifier.as_bytes()));
        let mut query = url.query_pairs_mut();
        query
            .append_pair("response_type", "code")
            .append_pair("response_mode", "query")
            .append_pair("client_id", self.client_id)
            .append_pair("redirect_uri", self.redirect_uri)
            .append_pair("scope", self.scopes)
            .append_pair("state", &secrets.state)
            .append_pair("nonce", &secrets.nonce)
            .append_pair("code_challenge", &challenge)
            .append_pair("code_challenge_method", "S256");
        if self.anew {
            query.append_pair("prompt", "login").append_pair("max_age", "0");
        }
        drop(query);
        url
    }
}
