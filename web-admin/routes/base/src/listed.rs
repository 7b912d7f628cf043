//! A router that records its paths, so that a test can request each of them.

use std::pin::Pin;
use std::sync::Arc;

use axum::Router;
use axum::extract::Request;
use axum::handler::Handler;
use axum::response::Response;
use axum::routing::{self, MethodRouter};
use utoipa_axum::router::OpenApiRouter;

use crate::AppState;

/// Routes with the list of their paths. Only this module creates a [`Router`], so every route that
/// is served is in the list.
#[derive(Debug, Default)]
pub struct Routes {
    router: Router<AppState>,
    paths: Vec<String>,
}

impl Routes {
    /// Returns an empty list of routes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns described endpoints of the API, at the paths given in their descriptions.
    #[must_use]
    pub fn described(endpoints: OpenApiRouter<AppState>) -> Self {
        let (router, description) = endpoints.split_for_parts();
        Self { router, paths: description.paths.paths.into_keys().collect() }
    }

    /// Adds a path, as [`Router::route`] does.
    #[must_use]
    pub fn route(mut self, path: &str, methods: MethodRouter<AppState>) -> Self {
        self.paths.push(path.to_owned());
        Self { router: self.router.route(path, methods), paths: self.paths }
    }

    /// Adds the routes of another, as [`Router::merge`] does.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        self.paths.extend(other.paths);
        Self { router: self.router.merge(other.router), paths: self.paths }
    }

    /// Adds the routes of another below a path, as [`Router::nest`] does.
    #[must_use]
    pub fn nest(mut self, path: &str, other: Self) -> Self {
        self.paths.extend(other.paths.iter().map(|below| format!("{path}{below}")));
        Self { router: self.router.nest(path, other.router), paths: self.paths }
    }

    /// Adds layers and a fallback around the routes; `wrap` must not add routes, which would be
    /// missing in the list.
    #[must_use]
    pub fn around(self, wrap: impl FnOnce(Router<AppState>) -> Router<AppState>) -> Self {
        Self { router: wrap(self.router), paths: self.paths }
    }

    /// Returns the paths, sorted and unique.
    #[must_use]
    pub fn paths(&self) -> Vec<String> {
        let mut paths = self.paths.clone();
        paths.sort();
        paths.dedup();
        paths
    }

    /// Returns the router.
    pub fn into_router(self) -> Router<AppState> {
        self.router
    }
}

/// The future of a handler's response.
type Answer = Pin<Box<dyn Future<Output = Response> + Send>>;

/// A type-erased handler: axum's code around a handler is compiled once instead of once per
/// handler.
#[derive(Clone)]
struct ErasedHandler(Arc<dyn Fn(Request, AppState) -> Answer + Send + Sync>);

impl ErasedHandler {
    fn new<T: 'static>(handler: impl Handler<T, AppState, Future = Answer>) -> Self {
        Self(Arc::new(move |request, state| handler.clone().call(request, state)))
    }
}

impl Handler<(), AppState> for ErasedHandler {
    type Future = Answer;

    fn call(self, request: Request, state: AppState) -> Answer {
        (self.0)(request, state)
    }
}

/// Routes `GET` and `HEAD` to a handler.
pub fn get<T: 'static>(handler: impl Handler<T, AppState, Future = Answer>) -> MethodRouter<AppState> {
    routing::get(ErasedHandler::new(handler))
}

/// Routes `POST` to a handler.
pub fn post<T: 'static>(handler: impl Handler<T, AppState, Future = Answer>) -> MethodRouter<AppState> {
    routing::post(ErasedHandler::new(handler))
}
