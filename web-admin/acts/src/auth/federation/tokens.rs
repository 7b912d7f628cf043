//! Exchange of an authorization code for the claims of a person.

use data_encoding::BASE64;
use model::auth::federation::Claims;
use model::auth::sign_in_refusal::SignInRefusal;
use platform::openid::{ASSERTION_TYPE, Discovery, ExpectedToken, TokenAuthentication};
use platform::outgoing::{Call, Content};
use platform::sealing;
use serde::Deserialize;
use serde_json::{Map, Value};
use store::auth::federation::flows::SignInFlow;
use store::auth::federation::providers::SignInProvider;
use url::form_urlencoded::byte_serialize;

use super::client_keys;
use super::documents::{self, DocumentError, refuse};
use crate::service::Service;

/// A code that a provider has issued for a sign-in.
#[derive(Clone, Copy)]
pub(super) struct IssuedCode<'a> {
    pub provider: &'a SignInProvider,
    pub discovery: &'a Discovery,
    pub flow: &'a SignInFlow,
    pub code: &'a str,
}

#[derive(Deserialize)]
struct TokenAnswer {
    id_token: String,
    access_token: Option<String>,
}

impl IssuedCode<'_> {
    /// Exchanges the code, verifies the ID token, and completes its claims from the user
    /// information if a needed one is missing.
    pub(super) async fn read_claims(self, service: &Service) -> Result<Claims, DocumentError> {
        let tokens = self.exchange(service).await?;
        let mut claims = self.verify(service, &tokens).await?;
        if let Some(access) = &tokens.access_token
            && self.lacks_claims(&claims)
        {
            self.complete(service, access, &mut claims).await?;
        }
        Ok(claims)
    }

    async fn exchange(self, service: &Service) -> Result<TokenAnswer, DocumentError> {
        let keys_dir = &service.config.keys_dir;
        let settings = &self.provider.settings;
        let id = self.provider.id.uuid();
        let open = |sealed: &[u8]| {
            let opened = sealing::open(keys_dir, id.as_bytes(), sealed)?;
            String::from_utf8(opened).map_err(anyhow::Error::from)
        };
        let mut form = vec![
            ("grant_type", "authorization_code".to_owned()),
            ("code", self.code.to_owned()),
            ("redirect_uri", super::flows::redirect_uri(service)),
            ("code_verifier", open(&self.flow.pkce_sealed)?),
        ];
        let token_endpoint = &self.discovery.token_endpoint;
        let client_id = &settings.client_id;
        let authorization = match self.discovery.find_authentication(settings.authentication) {
            Some(TokenAuthentication::Header) => {
                // RFC 6749, section 2.3.1: both are form-encoded first.
                let encode = |text: &str| byte_serialize(text.as_bytes()).collect::<String>();
                let both = format!("{}:{}", encode(client_id), encode(&open(&self.provider.sealed_secret)?));
                Some(format!("Basic {}", BASE64.encode(both.as_bytes())))
            }
            Some(TokenAuthentication::Form) => {
                form.extend([("client_id", client_id.clone()), ("client_secret", open(&self.provider.sealed_secret)?)]);
                None
            }
            Some(TokenAuthentication::Assertion) => {
                let key = client_keys::read_signing_key(service).await?;
                let now_s = service.clock.now().micros().div_euclid(1_000_000);
                form.extend([
                    ("client_id", client_id.clone()),
                    ("client_assertion_type", ASSERTION_TYPE.to_owned()),
                    ("client_assertion", key.sign_assertion(client_id, token_endpoint.as_str(), now_s)?),
                ]);
                None
            }
            None => return Err(refuse(SignInRefusal::Code, "no supported method of client authentication")),
        };
        let call = Call::post(token_endpoint.clone(), Content::of_form(&form)).with_authorization(authorization);
        let answer = service.outgoing.send(call).await.map_err(|why| refuse(SignInRefusal::Unreachable, why))?;
        match answer.status {
            200 => serde_json::from_slice(&answer.body)
                .map_err(|error| refuse(SignInRefusal::Malformed, error.to_string())),
            status @ 400..500 => Err(refuse(SignInRefusal::Code, format!("token endpoint: HTTP status {status}"))),
            status => Err(refuse(SignInRefusal::Unreachable, format!("token endpoint: HTTP status {status}"))),
        }
    }

    async fn verify(self, service: &Service, tokens: &TokenAnswer) -> Result<Claims, DocumentError> {
        let settings = &self.provider.settings;
        let expected = ExpectedToken {
            issuer: &settings.issuer,
            client_id: &settings.client_id,
            nonce_sha256: &self.flow.nonce_sha256,
            access_token: tokens.access_token.as_deref(),
            now: service.clock.now(),
        };
        let (school, keys_url) = (self.provider.school_id, self.discovery.jwks_uri.as_str());
        documents::verify_by_keys(service, school, keys_url, &tokens.id_token, &expected).await
    }

    /// Whether a claim is missing that the settings of the provider use.
    fn lacks_claims(self, claims: &Claims) -> bool {
        let settings = &self.provider.settings;
        let optional = [&settings.match_claim, &settings.role_claim].into_iter().flatten().map(String::as_str);
        ["name", "email", &settings.subject_claim].into_iter().chain(optional).any(|name| !claims.0.contains_key(name))
    }

    async fn complete(self, service: &Service, access: &str, claims: &mut Claims) -> Result<(), DocumentError> {
        let Some(url) = self.discovery.userinfo_endpoint.clone() else { return Ok(()) };
        let call = Call::get(url).with_authorization(Some(format!("Bearer {access}")));
        let answer = service.outgoing.send(call).await.map_err(|why| refuse(SignInRefusal::Unreachable, why))?;
        if answer.status != 200 {
            return Err(refuse(SignInRefusal::Unreachable, format!("user information: HTTP status {}", answer.status)));
        }
        let told: Map<String, Value> =
            serde_json::from_slice(&answer.body).map_err(|error| refuse(SignInRefusal::Malformed, error))?;
        if told.get("sub") != claims.0.get("sub") {
            return Err(refuse(SignInRefusal::UserInfo, "user information about somebody else"));
        }
        for (name, value) in told {
            claims.0.entry(name).or_insert(value);
        }
        Ok(())
    }
}
