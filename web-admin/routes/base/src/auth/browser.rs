//! The parts of a request that pages need: the person, the CSRF token, the session, the headers.

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

/// A signed-in person who requests a page, and the token of its forms.
#[derive(Clone, Copy, Debug)]
pub struct Visit<'a> {
    /// The signed-in person.
    pub person: &'a CurrentPerson,
    /// The token of the page's forms.
    pub csrf: &'a Csrf,
}

impl<'a> Visit<'a> {
    /// Returns the visit of a person, with the token for their forms.
    pub const fn new(person: &'a CurrentPerson, csrf: &'a Csrf) -> Self {
        Self { person, csrf }
    }
}

/// The browser that sent a request, for pages that store data in its session.
#[derive(Clone, Debug)]
pub struct Browser {
    /// Its session.
    pub session: Session,
    /// The token of the forms sent to it.
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
    /// The request headers.
    pub headers: HeaderMap,
}

impl<S: Send + Sync> FromRequestParts<S> for PageHead {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        Ok(Self { csrf: Csrf::from_request_parts(parts, state).await?, headers: parts.headers.clone() })
    }
}
