//! Every route of the service, and the layers around them.

use std::time::Duration;

use acts::auth::web_sessions::WebSessions;
use acts::error::Error;
use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::Response;
use routes_base::auth::{refuse_nul, require_person, settle_stranger};
use routes_base::error::{ApiError, PageError};
use routes_base::language::settle_language;
use routes_base::{AppState, Routes, get};
use tower_http::CompressionLevel;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{DefaultPredicate, NotForContentType, Predicate};
use tower_http::set_header::SetResponseHeaderLayer;
use tower_http::timeout::{RequestBodyTimeoutLayer, TimeoutLayer};
use tower_sessions::cookie::SameSite;
use tower_sessions::{Expiry, SessionManagerLayer};

mod assets;
mod flash_messages;
pub mod health;
mod well_known;

/// Blocks content of other origins, framing, and forms that submit elsewhere.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self' data:; \
     connect-src 'self'; font-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'";

/// Browser features that no page uses.
const PERMISSIONS_POLICY: &str = "accelerometer=(), camera=(), display-capture=(), geolocation=(), gyroscope=(), magnetometer=(), \
     microphone=(), midi=(), payment=(), serial=(), usb=()";

/// Maximum duration of a request for a page, including a slow form submission.
const PAGE_TIMEOUT: Duration = Duration::from_secs(30);
/// Maximum duration of an API call, and of one that uploads a recording over a slow connection.
const CALL_TIMEOUT: Duration = Duration::from_secs(60);
const UPLOAD_TIMEOUT: Duration = Duration::from_secs(3600);

/// Returns the router of the whole service.
pub fn router(state: AppState) -> Router {
    with_headers(all_routes(&state).into_router(), &state).with_state(state)
}

/// Returns every route of the service.
#[must_use]
pub fn all_routes(state: &AppState) -> Routes {
    // Layers also wrap the fallback: an anonymous visitor is asked to sign in at every address,
    // whether it exists or not.
    let signed_in = page_routes().around(|pages| {
        pages
            .fallback(nothing_here)
            .layer(from_fn_with_state(state.clone(), flash_messages::show_flash_messages))
            .layer(from_fn_with_state(state.clone(), require_person))
    });
    // A recording is compressed already, and a range of it must remain a range of its bytes.
    let packable = DefaultPredicate::new().and(NotForContentType::new("application/octet-stream"));
    signed_in
        .merge(routes_people::sign_in_routes())
        .merge(routes_surveys::survey_link_routes())
        .merge(routes_scoring::linked_routes())
        .route("/assets/{file}", get(assets::serve_asset))
        .around(|all| all.layer(from_fn(refuse_nul_in_address)))
        .around(|all| all.layer(from_fn(settle_language)))
        .around(|all| all.layer(from_fn_with_state(state.clone(), settle_stranger)))
        .around(|all| all.layer(TimeoutLayer::with_status_code(StatusCode::REQUEST_TIMEOUT, PAGE_TIMEOUT)))
        .nest("/api/v1", routes_api::api_routes(state).around(|api| api.layer(from_fn(limit_call))))
        .nest("/scim/v2", routes_api::scim_routes(state).around(|scim| scim.layer(from_fn(limit_call))))
        .around(|all| all.layer(with_cookies(state)))
        .merge(health::health_routes())
        .merge(well_known::well_known_routes())
        .merge(routes_training::calendar_routes())
        .around(|all| {
            all.layer(from_fn_with_state(state.clone(), health::count_requests))
                // Higher levels would save a tenth of the size for several times the time.
                .layer(CompressionLayer::new().quality(CompressionLevel::Fastest).compress_when(packable))
                // Twice the limit of the upload handlers, so that their own error comes first.
                .layer(RequestBodyTimeoutLayer::new(2 * state.config.upload_silence))
                .layer(CatchPanicLayer::new())
        })
}

/// Returns the pages for signed-in people.
fn page_routes() -> Routes {
    routes_training::training_routes()
        .merge(routes_people::people_routes())
        .merge(routes_scoring::scoring_routes())
        .merge(routes_surveys::survey_routes())
}

/// Refuses an address that contains U+0000, as in forms: no text may contain it, and PostgreSQL
/// rejects it.
async fn refuse_nul_in_address(request: Request, next: Next) -> Result<Response, PageError> {
    const NUL: &str = "%00";
    match request.uri() {
        address if address.path().contains(NUL) => Err(PageError(Error::NotFound)),
        address if address.query().is_some_and(|asked| asked.contains(NUL)) => Err(PageError(refuse_nul())),
        _ => Ok(next.run(request).await),
    }
}

/// Ends a call that takes too long, be it a slow body or slow work.
async fn limit_call(request: Request, next: Next) -> Result<Response, ApiError> {
    let brings = matches!(*request.method(), Method::POST | Method::PATCH)
        && (request.uri().path() == "/sessions" || request.uri().path().starts_with("/uploads"));
    let limit = if brings { UPLOAD_TIMEOUT } else { CALL_TIMEOUT };
    tokio::time::timeout(limit, next.run(request)).await.map_err(|_| ApiError(Error::Timeout))
}

async fn nothing_here(_: Request) -> PageError {
    PageError(Error::NotFound)
}

fn with_cookies(state: &AppState) -> SessionManagerLayer<WebSessions> {
    SessionManagerLayer::new(WebSessions::new(state.db.clone(), state.clock.clone()))
        // Behind TLS bound to this exact host, so that no neighbouring subdomain can set it.
        .with_name(if state.config.behind_tls { "__Host-stylet_session" } else { "stylet_session" })
        .with_http_only(true)
        .with_same_site(SameSite::Lax)
        .with_secure(state.config.behind_tls)
        // The service decides when the session expires: [`routes_base::auth::start_session`].
        .with_expiry(Expiry::OnSessionEnd)
}

fn with_headers(app: Router<AppState>, state: &AppState) -> Router<AppState> {
    let always = |name: HeaderName, value: &'static str| {
        SetResponseHeaderLayer::if_not_present(name, HeaderValue::from_static(value))
    };
    let app = app
        .layer(always(header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY))
        .layer(always(header::X_CONTENT_TYPE_OPTIONS, "nosniff"))
        .layer(always(header::REFERRER_POLICY, "same-origin"))
        .layer(always(HeaderName::from_static("permissions-policy"), PERMISSIONS_POLICY))
        .layer(always(HeaderName::from_static("cross-origin-opener-policy"), "same-origin"))
        .layer(always(HeaderName::from_static("cross-origin-resource-policy"), "same-origin"))
        // A page contains personal data: neither a proxy nor a shared computer may cache it.
        .layer(always(header::CACHE_CONTROL, "no-store"));
    if state.config.behind_tls {
        return app.layer(always(header::STRICT_TRANSPORT_SECURITY, "max-age=31536000"));
    }
    app
}
