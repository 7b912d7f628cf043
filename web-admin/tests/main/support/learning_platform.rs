//! A learning platform in the test process. It confirms the user whom the test names, and forges one thing at a time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use platform::clock::Clock;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

use super::forgery::{Forgery, forge_token};
use super::grade_book::{self, GradeBook};
use super::provider::{ORIGIN, parameters};
use super::signer::{Algorithm, Signer};

/// Issuer of every platform of the tests, as all schools on one Canvas have the same.
pub const ISSUER: &str = "https://canvas.example.com";
pub const LTI: &str = "https://purl.imsglobal.org/spec/lti/claim/";
pub const DEEP_LINKING: &str = "https://purl.imsglobal.org/spec/lti-dl/claim/";

/// A message of a launch: the claims beside those of every ID token.
#[derive(Clone, Debug)]
pub struct LaunchMessage(pub Value);

impl LaunchMessage {
    /// A usual launch by a user.
    pub fn by(subject: &str) -> Self {
        Self(json!({
            "sub": subject,
            "name": format!("Name of {subject}"),
            format!("{LTI}message_type"): "LtiResourceLinkRequest",
            format!("{LTI}version"): "1.3.0",
            format!("{LTI}deployment_id"): "1",
            format!("{LTI}target_link_uri"): format!("{ORIGIN}/lti/launch"),
            format!("{LTI}resource_link"): { "id": "link-1", "title": "Puncture" },
            format!("{LTI}context"): { "id": "course-1", "title": "Nursing, first year" },
            format!("{LTI}roles"): ["http://purl.imsglobal.org/vocab/lis/v2/membership#Instructor"],
        }))
    }

    /// A request of a user for content.
    pub fn choice_by(subject: &str) -> Self {
        let asked = json!({
            "deep_link_return_url": "https://canvas.example.com/return?course=5",
            "accept_types": ["link", "ltiResourceLink"],
            "accept_multiple": true,
            "data": "op=321&v=44",
        });
        let message = Self::by(subject).with_lti("message_type", "LtiDeepLinkingRequest");
        message.with_lti("resource_link", Value::Null).with(&format!("{DEEP_LINKING}deep_linking_settings"), asked)
    }

    /// With another setting of a request for content; null leaves it out.
    pub fn with_setting(mut self, setting: &str, value: impl Into<Value>) -> Self {
        self.0[format!("{DEEP_LINKING}deep_linking_settings")][setting] = value.into();
        self
    }

    /// With another claim; null leaves it out.
    pub fn with(mut self, claim: &str, value: impl Into<Value>) -> Self {
        self.0[claim] = value.into();
        self
    }

    /// With another claim of LTI.
    pub fn with_lti(self, claim: &str, value: impl Into<Value>) -> Self {
        self.with(&format!("{LTI}{claim}"), value)
    }
}

struct Shared {
    clock: Clock,
    signer: Mutex<Signer>,
    forgery: Mutex<Option<Forgery>>,
    /// Its configuration for dynamic registration.
    configuration: Mutex<Value>,
    /// The tools that were registered.
    tools: Mutex<Vec<Value>>,
}

impl Shared {
    fn new(clock: &Clock, address: &str) -> Self {
        let at = |path: &str| format!("http://{address}{path}");
        let configuration = json!({
            "issuer": at(""),
            "authorization_endpoint": at("/auth"),
            "token_endpoint": at("/token"),
            "jwks_uri": at("/keys"),
            "registration_endpoint": at("/register"),
            "https://purl.imsglobal.org/spec/lti-platform-configuration": { "product_family_code": "moodle" },
        });
        Self {
            clock: clock.clone(),
            signer: Mutex::new(Signer::new("first", Algorithm::Rs256)),
            forgery: Mutex::default(),
            configuration: Mutex::new(configuration),
            tools: Mutex::default(),
        }
    }
}

/// Token that permits one registration.
pub const REGISTRATION_TOKEN: &str = "registration-token-1";

/// A platform; it ends when dropped.
pub struct LearningPlatform {
    /// Host and port.
    pub address: String,
    pub grades: Arc<GradeBook>,
    shared: Arc<Shared>,
    server: JoinHandle<()>,
}

impl LearningPlatform {
    pub async fn start(clock: &Clock) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let shared = Arc::new(Shared::new(clock, &address));
        let router = Router::new()
            .route("/keys", get(keys))
            .route("/openid-configuration", get(configuration))
            .route("/register", post(register))
            .with_state(Arc::clone(&shared));
        let grades = Arc::new(GradeBook::new(&address, clock));
        let router = router.merge(grade_book::routes(&grades));
        let server = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { address, grades, shared, server }
    }

    pub fn auth_url(&self) -> String {
        format!("http://{}/auth", self.address)
    }

    /// The fields of its registration here.
    pub fn fields(&self) -> [(&'static str, String); 3] {
        let address = |path| format!("http://{}/{path}", self.address);
        [("auth_url", self.auth_url()), ("token_url", address("token")), ("keys_url", address("keys"))]
    }

    /// Address of its configuration.
    pub fn configuration_url(&self) -> String {
        format!("http://{}/openid-configuration", self.address)
    }

    /// Changes its configuration.
    pub fn configure(&self, name: &str, value: impl Into<Value>) {
        self.shared.configuration.lock().unwrap_or_else(PoisonError::into_inner)[name] = value.into();
    }

    /// The tools that were registered.
    pub fn tools(&self) -> Vec<Value> {
        self.shared.tools.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn forge(&self, forgery: Option<Forgery>) {
        *self.shared.forgery.lock().unwrap_or_else(PoisonError::into_inner) = forgery;
    }

    /// Replaces the key by a new one.
    pub fn rotate(&self, kid: &str) {
        *self.shared.signer.lock().unwrap_or_else(PoisonError::into_inner) = Signer::new(kid, Algorithm::Es256);
    }

    /// Plays the authorization endpoint: takes the address to which the service sends the browser, checks it, and returns the form that the
    /// browser posts.
    pub fn confirm(&self, auth_url: &str, message: &LaunchMessage) -> Vec<(&'static str, String)> {
        let asked = self.check(auth_url);
        let now = self.shared.clock.now().micros() / 1_000_000;
        let mut claims = message.0.clone();
        for (name, value) in [
            ("iss", json!(ISSUER)),
            ("aud", json!(asked["client_id"])),
            ("nonce", json!(asked["nonce"])),
            ("iat", json!(now)),
            ("exp", json!(now + 300)),
        ] {
            claims[name] = value;
        }
        let signer = self.shared.signer.lock().unwrap_or_else(PoisonError::into_inner);
        let forgery = self.shared.forgery.lock().unwrap_or_else(PoisonError::into_inner);
        let token = forge_token(&signer, claims, forgery.as_ref(), now);
        vec![("state", asked["state"].clone()), ("id_token", token)]
    }

    /// Returns the parameters of an authorization request, which is one that the service may send.
    pub fn check(&self, auth_url: &str) -> BTreeMap<String, String> {
        assert!(auth_url.starts_with(&format!("{}?", self.auth_url())), "{auth_url}");
        let asked = parameters(auth_url);
        for (name, value) in [
            ("scope", "openid"),
            ("response_type", "id_token"),
            ("response_mode", "form_post"),
            ("prompt", "none"),
            ("redirect_uri", &format!("{ORIGIN}/lti/launch")),
        ] {
            assert_eq!(asked.get(name).map(String::as_str), Some(value), "{name} in {auth_url}");
        }
        assert!(asked["state"].len() >= 22 && asked["nonce"].len() >= 22, "{auth_url}");
        asked
    }
}

impl Drop for LearningPlatform {
    fn drop(&mut self) {
        self.server.abort();
    }
}

async fn keys(State(shared): State<Arc<Shared>>) -> Json<Value> {
    let signer = shared.signer.lock().unwrap_or_else(PoisonError::into_inner);
    Json(json!({ "keys": [signer.public_key()] }))
}

async fn configuration(State(shared): State<Arc<Shared>>) -> Json<Value> {
    Json(shared.configuration.lock().unwrap_or_else(PoisonError::into_inner).clone())
}

/// Registers one tool for the token, as a client with a deployment.
async fn register(State(shared): State<Arc<Shared>>, headers: HeaderMap, Json(tool): Json<Value>) -> Response {
    let mut tools = shared.tools.lock().unwrap_or_else(PoisonError::into_inner);
    let token = format!("Bearer {REGISTRATION_TOKEN}");
    if headers.get("authorization").is_none_or(|sent| *sent != token) || !tools.is_empty() {
        return StatusCode::UNAUTHORIZED.into_response();
    }
    let mut registered = tool.clone();
    registered["client_id"] = json!("registered-1");
    registered["https://purl.imsglobal.org/spec/lti-tool-configuration"]["deployment_id"] = json!("d7");
    tools.push(tool);
    (StatusCode::CREATED, Json(registered)).into_response()
}
