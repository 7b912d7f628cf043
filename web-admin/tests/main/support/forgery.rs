//! What a provider of the tests does wrong, one thing at a time.

use std::convert::Infallible;
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures::stream;
use ring::hmac;
use serde_json::{Value, json};

use super::signer::{Signer, encode};

/// One of the provider's addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Endpoint {
    Discovery,
    Keys,
    Token,
    Userinfo,
}

/// How an endpoint fails to answer properly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    NotJson,
    /// A byte a second.
    Slow,
    /// An answer without an end.
    Endless,
    RedirectTo(String),
    /// Status 500.
    Broken,
}

/// The one thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Forgery {
    Issuer,
    Audience,
    /// Two audiences without an authorized party.
    SeveralAudiences,
    AuthorizedParty,
    Nonce,
    NoNonce,
    /// `alg` is `none`, and the signature is empty.
    NoAlgorithm,
    /// HS256 with the public key as the secret.
    PublicKeyAsSecret,
    UnknownKey,
    /// Signed by another key under the id of the published one.
    AnotherKey,
    Expired,
    IssuedInTheFuture,
    NotYetValid,
    TooOld,
    EmptySubject,
    NoSubject,
    OtherSubjectAtUserinfo,
    /// A token of two parts.
    TwoParts,
    /// `at_hash` of another access token.
    AccessTokenHash,
    /// Nothing is wrong: the only audience is in a list, as some programs write it.
    AudienceInList,
    /// 40 kB of claims in the token and at userinfo.
    ManyClaims,
    /// 1 000 keys, the right one last.
    ManyKeys,
    At(Endpoint, Trouble),
}

impl Trouble {
    pub fn response(&self) -> Response {
        let json = [(header::CONTENT_TYPE, "application/json")];
        match self {
            Self::NotJson => ([(header::CONTENT_TYPE, "text/html")], "<p>Under maintenance</p>").into_response(),
            Self::Broken => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
            Self::RedirectTo(target) => (StatusCode::FOUND, [(header::LOCATION, target.as_str())]).into_response(),
            Self::Slow => (json, pieces(Duration::from_secs(1), " ")).into_response(),
            Self::Endless => (json, pieces(Duration::ZERO, &" ".repeat(16 * 1024))).into_response(),
        }
    }
}

/// A body without an end: a piece, a pause, and so on.
fn pieces(pause: Duration, piece: &str) -> Body {
    let piece = Bytes::from(piece.to_owned());
    Body::from_stream(stream::unfold(piece, move |piece| async move {
        tokio::time::sleep(pause).await;
        Some((Ok::<_, Infallible>(piece.clone()), piece))
    }))
}

/// Makes a token of claims, with the one thing that is wrong. `now` is in s; a claim that is null is left out.
pub fn forge_token(signer: &Signer, mut claims: Value, forgery: Option<&Forgery>, now: i64) -> String {
    let client = claims["aud"].clone();
    let mut head = json!({ "typ": "JWT", "alg": signer.algorithm.name(), "kid": signer.kid });
    match forgery {
        Some(Forgery::Issuer) => claims["iss"] = json!("https://provider.example.net"),
        Some(Forgery::Audience) => claims["aud"] = json!("another-client"),
        Some(Forgery::SeveralAudiences) => claims["aud"] = json!([client, "another-client"]),
        Some(Forgery::AudienceInList) => claims["aud"] = json!([client]),
        Some(Forgery::AuthorizedParty) => {
            claims["aud"] = json!([client, "another-client"]);
            claims["azp"] = json!("another-client");
        }
        Some(Forgery::Nonce) => claims["nonce"] = json!("bm9uY2Ugb2YgYW5vdGhlciBmbG93"),
        Some(Forgery::NoNonce) => claims["nonce"] = Value::Null,
        Some(Forgery::NoAlgorithm) => head["alg"] = json!("none"),
        Some(Forgery::PublicKeyAsSecret) => head["alg"] = json!("HS256"),
        Some(Forgery::UnknownKey) => head["kid"] = json!("unknown"),
        Some(Forgery::Expired) => claims["exp"] = json!(now - 61),
        Some(Forgery::IssuedInTheFuture) => claims["iat"] = json!(now + 120),
        Some(Forgery::NotYetValid) => claims["nbf"] = json!(now + 120),
        Some(Forgery::TooOld) => claims["iat"] = json!(now - 700),
        Some(Forgery::EmptySubject) => claims["sub"] = json!(""),
        Some(Forgery::NoSubject) => claims["sub"] = Value::Null,
        Some(Forgery::ManyClaims) => claims["groups"] = many_groups(),
        _ => {}
    }
    if let Value::Object(members) = &mut claims {
        members.retain(|_, value| !value.is_null());
    }
    let signed = format!("{}.{}", encode(head.to_string().as_bytes()), encode(claims.to_string().as_bytes()));
    let signature = match forgery {
        Some(Forgery::TwoParts) => return signed,
        Some(Forgery::NoAlgorithm) => Vec::new(),
        Some(Forgery::PublicKeyAsSecret) => {
            let secret = hmac::Key::new(hmac::HMAC_SHA256, signer.public_bytes());
            hmac::sign(&secret, signed.as_bytes()).as_ref().to_vec()
        }
        Some(Forgery::AnotherKey) => Signer::new(&signer.kid, signer.algorithm).sign(signed.as_bytes()),
        _ => signer.sign(signed.as_bytes()),
    };
    format!("{signed}.{}", encode(&signature))
}

/// Group names of 40 kB in all.
pub fn many_groups() -> Value {
    json!((0..2000).map(|n| format!("group-number-{n:04}")).collect::<Vec<_>>())
}
