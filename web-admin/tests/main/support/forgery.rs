//! What a provider of the tests does wrong, one thing at a time.

use std::convert::Infallible;
use std::time::Duration;

use axum::body::{Body, Bytes};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures::stream;

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
