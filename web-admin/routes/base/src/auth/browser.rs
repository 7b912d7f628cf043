//! What pages are made with besides their own facts: who has asked, the token of their forms, the session, the headers.

use std::net::IpAddr;

use axum::extract::FromRequestParts;
use axum::http::HeaderMap;
use axum::http::request::Parts;
use model::CurrentPerson;
use tower_sessions::Session;

use super::csrf::session_of;
use super::{ClientAddress, Csrf};
use crate::AppState;
use crate::error::PageError;

/// Somebody who has asked for a page, and the token of its forms.
#[derive(Clone, Copy, Debug)]
pub struct Visit<'a> {
    /// Who is signed in.
    pub person: &'a CurrentPerson,
    /// The token of the page's forms.
    pub csrf: &'a Csrf,
}

impl<'a> Visit<'a> {
    /// The visit of a person, whose forms carry a token.
    pub const fn new(person: &'a CurrentPerson, csrf: &'a Csrf) -> Self {
        Self { person, csrf }
    }
}

/// The browser that has sent a request: for pages that keep something in its session.
#[derive(Clone, Debug)]
pub struct Browser {
    /// Its session.
    pub session: Session,
    /// The token of the forms that it gets.
    pub csrf: Csrf,
    /// Its network address.
    pub from: IpAddr,
}

impl FromRequestParts<AppState> for Browser {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &AppState) -> Result<Self, Self::Rejection> {
        let session = session_of(parts, state).await?;
        let csrf = Csrf::from_request_parts(parts, state).await?;
        let ClientAddress(from) = ClientAddress::of(state, &parts.extensions, &parts.headers);
        Ok(Self { session, csrf, from })
    }
}

/// The headers of a request for a page, and the token of the page's forms.
#[derive(Clone, Debug)]
pub struct PageHead {
    /// The token of the page's forms.
    pub csrf: Csrf,
    /// What the browser has sent.
    pub headers: HeaderMap,
}

impl<S: Send + Sync> FromRequestParts<S> for PageHead {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        Ok(Self { csrf: Csrf::from_request_parts(parts, state).await?, headers: parts.headers.clone() })
    }
}
