//! Verification of ID tokens (OpenID Connect Core 1.0, section 3.1.3.7).

use data_encoding::BASE64URL_NOPAD;
use jsonwebtoken::jwk::{Jwk, PublicKeyUse};
use jsonwebtoken::{Algorithm, DecodingKey, Validation, decode};
use model::Moment;
use model::auth::federation::{CLOCK_SKEW_S, Claims};
use model::auth::sign_in_refusal::SignInRefusal;
use ring::digest::{SHA256, SHA384, SHA512, digest};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::signatures;
use crate::secret;

/// Maximum age of a token, in s.
const OLDEST_S: i64 = 10 * 60;

/// Keys of a provider.
#[derive(Clone, Debug, Default)]
pub struct KeySet(Vec<Jwk>);

impl KeySet {
    /// Parses a JSON Web Key Set; keys of unknown kinds are left out.
    ///
    /// # Errors
    /// Returns the reason, in English.
    pub fn parse(body: &[u8]) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Keys {
            keys: Vec<Value>,
        }
        let read: Keys = serde_json::from_slice(body).map_err(|error| error.to_string())?;
        Ok(Self(read.keys.into_iter().filter_map(|key| serde_json::from_value(key).ok()).collect()))
    }

    /// Returns the key with an id. A token without one is accepted only if there is a single key.
    fn find(&self, id: Option<&str>) -> Option<&Jwk> {
        let is_for_signing = |key: &&Jwk| !matches!(key.common.public_key_use, Some(PublicKeyUse::Encryption));
        let mut signing = self.0.iter().filter(is_for_signing);
        match id {
            Some(id) => signing.find(|key| key.common.key_id.as_deref() == Some(id)),
            None => signing.next().filter(|_| signing.next().is_none()),
        }
    }
}

/// What a token must agree with.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedToken<'a> {
    /// Issuer identifier.
    pub issuer: &'a str,
    /// Id of this service at the provider.
    pub client_id: &'a str,
    /// SHA-256 of the nonce.
    pub nonce_sha256: &'a [u8],
    /// The access token that came with it.
    pub access_token: Option<&'a str>,
    /// Time of the verification.
    pub now: Moment,
}

#[derive(Deserialize)]
struct TokenHeader {
    alg: String,
    kid: Option<String>,
}

/// Verifies an ID token and returns its claims.
///
/// # Errors
/// Returns the reason. [`SignInRefusal::Key`] means that the keys do not contain the one of the
/// token: fetch them again.
pub fn verify_id_token(token: &str, keys: &KeySet, expected: &ExpectedToken<'_>) -> Result<Claims, SignInRefusal> {
    let header = token.split('.').next().unwrap_or_default();
    let header = BASE64URL_NOPAD.decode(header.as_bytes()).map_err(|_| SignInRefusal::Malformed)?;
    let header: TokenHeader = serde_json::from_slice(&header).map_err(|_| SignInRefusal::Malformed)?;
    let algorithm = match header.alg.as_str() {
        "RS256" => Algorithm::RS256,
        "PS256" => Algorithm::PS256,
        "ES256" => Algorithm::ES256,
        "ES384" => Algorithm::ES384,
        "EdDSA" => Algorithm::EdDSA,
        _ => return Err(SignInRefusal::Algorithm),
    };
    let key = keys.find(header.kid.as_deref()).ok_or(SignInRefusal::Key)?;
    if key.common.key_algorithm.is_some_and(|named| named.to_string() != header.alg) {
        return Err(SignInRefusal::Algorithm);
    }
    let key = DecodingKey::from_jwk(key).map_err(|_| SignInRefusal::Algorithm)?;
    if key.family() != algorithm.family() {
        return Err(SignInRefusal::Algorithm);
    }
    let claims = read_signed_claims(token, &key, algorithm)?;
    check_claims(&claims, expected)?;
    if let (Some(access), Some(hash)) = (expected.access_token, claims.text("at_hash"))
        && hash != hash_access_token(access, algorithm)
    {
        return Err(SignInRefusal::AccessToken);
    }
    Ok(claims)
}

fn read_signed_claims(token: &str, key: &DecodingKey, algorithm: Algorithm) -> Result<Claims, SignInRefusal> {
    signatures::install_ring();
    let mut validation = Validation::new(algorithm);
    // Claims are checked below: by this service's clock, and each with its own reason.
    validation.required_spec_claims.clear();
    validation.validate_exp = false;
    validation.validate_aud = false;
    match decode::<Map<String, Value>>(token, key, &validation) {
        Ok(read) => Ok(Claims(read.claims)),
        Err(error) if signatures::is_about_signature(&error) => Err(SignInRefusal::Signature),
        Err(_) => Err(SignInRefusal::Malformed),
    }
}

fn check_claims(claims: &Claims, expected: &ExpectedToken<'_>) -> Result<(), SignInRefusal> {
    let is = |name: &str, value: &str| claims.0.get(name).and_then(Value::as_str) == Some(value);
    if !is("iss", expected.issuer) {
        return Err(SignInRefusal::Issuer);
    }
    let audience = claims.list("aud");
    let is_authorized = match claims.0.contains_key("azp") {
        true => is("azp", expected.client_id),
        false => audience.len() == 1,
    };
    if !is_authorized || !audience.iter().any(|one| one == expected.client_id) {
        return Err(SignInRefusal::Audience);
    }
    let nonce = claims.0.get("nonce").and_then(Value::as_str).unwrap_or_default();
    if secret::token_sha256(nonce) != expected.nonce_sha256 {
        return Err(SignInRefusal::Nonce);
    }
    check_times(claims, expected.now.micros().div_euclid(1_000_000))?;
    match claims.0.get("sub").and_then(Value::as_str) {
        Some(subject) if !subject.is_empty() => Ok(()),
        _ => Err(SignInRefusal::Subject),
    }
}

fn check_times(claims: &Claims, now_s: i64) -> Result<(), SignInRefusal> {
    let (Some(expires), Some(issued)) = (claims.time_s("exp"), claims.time_s("iat")) else {
        return Err(SignInRefusal::Malformed);
    };
    let not_before = match claims.0.contains_key("nbf") {
        true => claims.time_s("nbf").ok_or(SignInRefusal::Malformed)?,
        false => issued,
    };
    if issued.max(not_before) > now_s + CLOCK_SKEW_S {
        Err(SignInRefusal::FromTheFuture)
    } else if expires <= now_s - CLOCK_SKEW_S {
        Err(SignInRefusal::Expired)
    } else if issued < now_s - OLDEST_S - CLOCK_SKEW_S {
        Err(SignInRefusal::TooOld)
    } else {
        Ok(())
    }
}

/// Returns the expected `at_hash`: the left half of the access token's hash.
fn hash_access_token(access: &str, algorithm: Algorithm) -> String {
    let hash = match algorithm {
        Algorithm::ES384 => &SHA384,
        Algorithm::EdDSA => &SHA512,
        _ => &SHA256,
    };
    let hash = digest(hash, access.as_bytes());
    BASE64URL_NOPAD.encode(&hash.as_ref()[..hash.as_ref().len() / 2])
}
