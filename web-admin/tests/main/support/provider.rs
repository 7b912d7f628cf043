//! An OpenID Connect provider in the test process. It signs in the user that the test sets, and forges one thing at a time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::{Form, Query, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use data_encoding::BASE64;
use percent_encoding::percent_decode_str;
use platform::clock::Clock;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256, Sha384};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

use super::assertions::{Assertions, ExpectedAssertion};
use super::client::encoded;
pub use super::forgery::{Endpoint, Forgery, Trouble};
use super::forgery::{forge_token, many_groups};
use super::signer::{Algorithm, Signer, encode};

/// The public URL of the service.
pub const ORIGIN: &str = "https://training.example.org";
pub const CLIENT_ID: &str = "stylet";
/// HTTP Basic authentication carries it form-encoded (RFC 6749, section 2.3.1).
pub const CLIENT_SECRET: &str = "a secret/with:signs+and%";

/// The user who signs in at the provider.
#[derive(Clone, Debug)]
pub struct User {
    pub subject: String,
    pub email: Option<String>,
    pub email_verified: Option<bool>,
    pub name: String,
    /// Further claims at userinfo.
    pub claims: Map<String, Value>,
    /// How the user has authenticated: a claim of the token.
    pub amr: Vec<&'static str>,
    /// Seconds since the user has authenticated; `None` if the provider has no `auth_time`.
    pub authenticated_s_ago: Option<i64>,
}

impl User {
    pub fn new(subject: &str, email: &str) -> Self {
        Self {
            subject: subject.to_owned(),
            email: Some(email.to_owned()),
            email_verified: None,
            name: format!("Name of {subject}"),
            claims: Map::new(),
            amr: vec!["pwd"],
            authenticated_s_ago: Some(0),
        }
    }

    /// With a further claim.
    pub fn with(mut self, claim: &str, value: impl Into<Value>) -> Self {
        self.claims.insert(claim.to_owned(), value.into());
        self
    }

    /// With an address that the provider has verified, or denies to have verified.
    pub fn verified(mut self, verified: bool) -> Self {
        self.email_verified = Some(verified);
        self
    }
}

/// An authorization that a code or an access token stands for.
#[derive(Clone)]
struct Grant {
    nonce: String,
    challenge: String,
    redirect_uri: String,
    user: User,
}

struct Inner {
    user: User,
    forgery: Option<Forgery>,
    /// All are published; the last signs.
    signers: Vec<Signer>,
    /// How a client may authenticate.
    methods: Vec<&'static str>,
    /// Public keys of the client.
    client_keys: Value,
    assertions: Assertions,
    codes: BTreeMap<String, Grant>,
    tokens: BTreeMap<String, Grant>,
    requests: BTreeMap<Endpoint, usize>,
    made: usize,
}

struct Shared {
    issuer: String,
    clock: Clock,
    inner: Mutex<Inner>,
}

/// A provider; it ends when dropped.
pub struct Provider {
    /// Host and port.
    pub address: String,
    shared: Arc<Shared>,
    server: JoinHandle<()>,
}

impl Provider {
    pub async fn start(clock: &Clock) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let inner = Inner {
            user: User::new("ada", "ada@example.org"),
            forgery: None,
            signers: vec![Signer::new("first", Algorithm::Es256)],
            methods: vec!["client_secret_basic"],
            client_keys: Value::Null,
            assertions: Assertions::default(),
            codes: BTreeMap::new(),
            tokens: BTreeMap::new(),
            requests: BTreeMap::new(),
            made: 0,
        };
        let issuer = format!("http://{address}");
        let shared = Arc::new(Shared { issuer, clock: clock.clone(), inner: Mutex::new(inner) });
        let router = Router::new()
            .route("/.well-known/openid-configuration", get(discovery))
            .route("/keys", get(keys))
            .route("/token", post(token))
            .route("/userinfo", get(userinfo))
            .with_state(Arc::clone(&shared));
        let server = tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        Self { address, shared, server }
    }

    pub fn issuer(&self) -> &str {
        &self.shared.issuer
    }

    /// Stops answering, for good.
    pub async fn stop(&mut self) {
        self.server.abort();
        let _ = (&mut self.server).await;
    }

    pub fn set_user(&self, user: User) {
        self.shared.lock().user = user;
    }

    /// Sets how a client may authenticate.
    pub fn set_methods(&self, methods: &[&'static str]) {
        self.shared.lock().methods = methods.to_vec();
    }

    /// Sets the key set of the client.
    pub fn set_client_keys(&self, keys: Value) {
        self.shared.lock().client_keys = keys;
    }

    pub fn forge(&self, forgery: Forgery) {
        self.shared.lock().forgery = Some(forgery);
    }

    pub fn stop_forging(&self) {
        self.shared.lock().forgery = None;
    }

    /// Publishes a further key and signs with it; the earlier keys stay published.
    pub fn add_key(&self, kid: &str, algorithm: Algorithm) {
        self.shared.lock().signers.push(Signer::new(kid, algorithm));
    }

    /// Replaces all keys by a new one.
    pub fn rotate(&self, kid: &str) {
        self.shared.lock().signers = vec![Signer::new(kid, Algorithm::Es256)];
    }

    /// Number of requests to an endpoint so far.
    pub fn requests(&self, endpoint: Endpoint) -> usize {
        self.shared.lock().requests.get(&endpoint).copied().unwrap_or_default()
    }

    /// Number of requests to all endpoints so far.
    pub fn all_requests(&self) -> usize {
        self.shared.lock().requests.values().sum()
    }

    /// Plays the login page: takes the address to which the service sends the browser, checks it, and returns the address of the service to
    /// which the provider would send the browser back.
    pub fn log_in(&self, authorize_url: &str) -> String {
        let asked = self.check(authorize_url);
        let mut inner = self.shared.lock();
        inner.made += 1;
        let code = format!("code-{}", inner.made);
        let grant = Grant {
            nonce: asked["nonce"].clone(),
            challenge: asked["code_challenge"].clone(),
            redirect_uri: asked["redirect_uri"].clone(),
            user: inner.user.clone(),
        };
        inner.codes.insert(code.clone(), grant);
        callback(&[("code", &code), ("state", &asked["state"]), ("iss", &self.shared.issuer)])
    }

    /// Plays the login page on which the user refuses.
    pub fn deny(&self, authorize_url: &str) -> String {
        let asked = self.check(authorize_url);
        callback(&[("error", "access_denied"), ("state", &asked["state"]), ("iss", &self.shared.issuer)])
    }

    /// Returns the parameters of an authorization request, which is one that the service may send.
    fn check(&self, authorize_url: &str) -> BTreeMap<String, String> {
        assert!(authorize_url.starts_with(&format!("{}/authorize?", self.shared.issuer)), "{authorize_url}");
        let asked = parameters(authorize_url);
        for (name, value) in [
            ("response_type", "code"),
            ("response_mode", "query"),
            ("client_id", CLIENT_ID),
            ("redirect_uri", &format!("{ORIGIN}/sign-in/callback")),
            ("code_challenge_method", "S256"),
        ] {
            assert_eq!(asked.get(name).map(String::as_str), Some(value), "{name} in {authorize_url}");
        }
        assert_eq!(asked["code_challenge"].len(), 43, "{authorize_url}");
        assert!(asked["state"].len() >= 22 && asked["nonce"].len() >= 22, "{authorize_url}");
        assert!(asked["scope"].split(' ').any(|scope| scope == "openid"), "{authorize_url}");
        asked
    }
}

impl Drop for Provider {
    fn drop(&mut self) {
        self.server.abort();
    }
}

/// Returns the parameters of an address.
pub fn parameters(url: &str) -> BTreeMap<String, String> {
    let uri: Uri = url.parse().unwrap();
    Query::<BTreeMap<String, String>>::try_from_uri(&uri).unwrap().0
}

/// Returns an address of the service with parameters for the callback.
pub fn callback(fields: &[(&str, &str)]) -> String {
    format!("/sign-in/callback?{}", encoded(fields))
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a request and answers it, properly or with the trouble that the test has set.
    fn answer(&self, endpoint: Endpoint, proper: impl FnOnce(&mut Inner) -> Response) -> Response {
        let mut inner = self.lock();
        *inner.requests.entry(endpoint).or_default() += 1;
        let mut response = match &inner.forgery {
            Some(Forgery::At(place, trouble)) if *place == endpoint => trouble.response(),
            _ => proper(&mut inner),
        };
        // A stopped provider answers on no connection that was open before.
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
        response
    }

    /// Makes the ID token of a grant, with the forgery.
    fn id_token(&self, inner: &Inner, grant: &Grant, access_token: &str) -> String {
        let now = self.clock.now().micros() / 1_000_000;
        let user = &grant.user;
        let mut claims = json!({
            "iss": self.issuer, "sub": user.subject, "aud": CLIENT_ID, "nonce": grant.nonce, "iat": now, "exp": now + 300,
            "amr": user.amr,
        });
        if let Some(ago) = user.authenticated_s_ago {
            claims["auth_time"] = json!(now - ago);
        }
        let signer = inner.signers.last().unwrap();
        claims["at_hash"] = at_hash(signer.algorithm, access_token);
        if inner.forgery == Some(Forgery::AccessTokenHash) {
            claims["at_hash"] = at_hash(signer.algorithm, "another access token");
        }
        forge_token(signer, claims, inner.forgery.as_ref(), now)
    }
}

/// The first half of the hash of an access token (OpenID Connect Core, section 3.1.3.6). Absent with EdDSA, whose hash programs disagree on.
fn at_hash(algorithm: Algorithm, access_token: &str) -> Value {
    let token = access_token.as_bytes();
    match algorithm {
        Algorithm::EdDsa => Value::Null,
        Algorithm::Es384 => json!(encode(&Sha384::digest(token)[..24])),
        Algorithm::Rs256 | Algorithm::Ps256 | Algorithm::Es256 => json!(encode(&Sha256::digest(token)[..16])),
    }
}

async fn discovery(State(shared): State<Arc<Shared>>) -> Response {
    shared.answer(Endpoint::Discovery, |inner| {
        let issuer = &shared.issuer;
        let algorithms = Algorithm::ALL.map(Algorithm::name);
        let document = json!({
            "issuer": issuer,
            "authorization_endpoint": format!("{issuer}/authorize"),
            "token_endpoint": format!("{issuer}/token"),
            "userinfo_endpoint": format!("{issuer}/userinfo"),
            "jwks_uri": format!("{issuer}/keys"),
            "response_types_supported": ["code"],
            "response_modes_supported": ["query"],
            "subject_types_supported": ["public"],
            "scopes_supported": ["openid", "profile", "email"],
            "id_token_signing_alg_values_supported": algorithms,
            "token_endpoint_auth_methods_supported": inner.methods,
            "token_endpoint_auth_signing_alg_values_supported": ["RS256"],
            "code_challenge_methods_supported": ["S256"],
            "authorization_response_iss_parameter_supported": true,
        });
        Json(document).into_response()
    })
}

async fn keys(State(shared): State<Arc<Shared>>) -> Response {
    shared.answer(Endpoint::Keys, |inner| {
        let mut keys: Vec<Value> = inner.signers.iter().map(Signer::public_key).collect();
        if inner.forgery == Some(Forgery::ManyKeys) {
            // The id of the right key is not repeated.
            let other = |n| {
                let mut key = keys[0].clone();
                key["kid"] = json!(format!("other-{n}"));
                key
            };
            let others: Vec<Value> = (1..1000).map(other).collect();
            keys.splice(0..0, others);
        }
        Json(json!({ "keys": keys })).into_response()
    })
}

async fn token(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    Form(form): Form<BTreeMap<String, String>>,
) -> Response {
    let refuse = |status: StatusCode, error: &str| (status, Json(json!({ "error": error }))).into_response();
    shared.answer(Endpoint::Token, |inner| {
        let is_authenticated = match inner.methods.contains(&"private_key_jwt") {
            true => {
                let audience = format!("{}/token", shared.issuer);
                let now_s = shared.clock.now().micros() / 1_000_000;
                let is_named = form.get("client_id").is_some_and(|id| id == CLIENT_ID);
                let expected =
                    ExpectedAssertion { client_id: CLIENT_ID, keys: &inner.client_keys, audience: &audience, now_s };
                is_named && inner.assertions.take(&form, expected)
            }
            false => is_client(&headers),
        };
        if !is_authenticated {
            return refuse(StatusCode::UNAUTHORIZED, "invalid_client");
        }
        let field = |name: &str| form.get(name).map(String::as_str).unwrap_or_default();
        // A code is removed even if the exchange fails.
        let Some(grant) = inner.codes.remove(field("code")) else {
            return refuse(StatusCode::BAD_REQUEST, "invalid_grant");
        };
        let verified = encode(&Sha256::digest(field("code_verifier").as_bytes())) == grant.challenge;
        let is_right = field("grant_type") == "authorization_code" && field("redirect_uri") == grant.redirect_uri;
        if !verified || !is_right {
            return refuse(StatusCode::BAD_REQUEST, "invalid_grant");
        }
        inner.made += 1;
        let access_token = format!("access-{}", inner.made);
        let id_token = shared.id_token(inner, &grant, &access_token);
        inner.tokens.insert(access_token.clone(), grant);
        let granted =
            json!({ "access_token": access_token, "token_type": "Bearer", "expires_in": 300, "id_token": id_token });
        Json(granted).into_response()
    })
}

/// Whether a request authenticates the client by `client_secret_basic`.
fn is_client(headers: &HeaderMap) -> bool {
    let credentials = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok()?.strip_prefix("Basic "));
    let decoded = credentials.and_then(|text| BASE64.decode(text.as_bytes()).ok());
    let Some(text) = decoded.and_then(|bytes| String::from_utf8(bytes).ok()) else { return false };
    let decode = |text: &str| percent_decode_str(&text.replace('+', " ")).decode_utf8_lossy().into_owned();
    text.split_once(':').is_some_and(|(id, secret)| decode(id) == CLIENT_ID && decode(secret) == CLIENT_SECRET)
}

async fn userinfo(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    shared.answer(Endpoint::Userinfo, |inner| {
        let bearer = headers.get(header::AUTHORIZATION).and_then(|value| value.to_str().ok()?.strip_prefix("Bearer "));
        let Some(grant) = bearer.and_then(|token| inner.tokens.get(token)) else {
            return StatusCode::UNAUTHORIZED.into_response();
        };
        let user = &grant.user;
        let mut claims = user.claims.clone();
        claims.insert("sub".to_owned(), json!(user.subject));
        claims.insert("name".to_owned(), json!(user.name));
        claims.extend(user.email.iter().map(|email| ("email".to_owned(), json!(email))));
        claims.extend(user.email_verified.iter().map(|verified| ("email_verified".to_owned(), json!(verified))));
        match inner.forgery {
            Some(Forgery::OtherSubjectAtUserinfo) => drop(claims.insert("sub".to_owned(), json!("somebody-else"))),
            Some(Forgery::ManyClaims) => drop(claims.insert("groups".to_owned(), many_groups())),
            _ => {}
        }
        Json(Value::Object(claims)).into_response()
    })
}
