//! A client of the router: a cookie jar, a token, and answers read whole.

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, Method, Request, StatusCode, header};
use serde_json::Value;
use tower::ServiceExt;

/// Somebody who sends requests.
#[derive(Clone)]
pub struct Client {
    router: Router,
    /// As a browser sends them: `name=value; name=value`.
    pub cookie: Option<String>,
    pub token: Option<String>,
}

/// An answer, read whole.
#[derive(Debug)]
pub struct Answer {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// The first address in the page that begins with `prefix`.
    pub fn link(&self, prefix: &str) -> String {
        let page = self.text();
        let rest = page.split(&format!("href=\"{prefix}")).nth(1).expect("a link");
        format!("{prefix}{}", rest.split('"').next().unwrap_or_default())
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {}", self.text()))
    }

    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    /// Refused with a status, as a problem.
    pub fn is_problem(&self, status: u16, word: &str) {
        assert_eq!(self.status, status, "{}", self.text());
        assert_eq!(self.header("content-type"), "application/problem+json");
        let problem = self.json();
        assert_eq!(problem["status"], status);
        assert!(problem["detail"].as_str().unwrap().contains(word), "{problem}");
    }
}

/// A file in a form.
#[derive(Clone, Copy, Debug)]
pub struct SentFile<'a> {
    /// Field of the form.
    pub field: &'a str,
    /// Name of the file.
    pub name: &'a str,
    pub bytes: &'a [u8],
}

impl Client {
    pub fn new(router: Router) -> Self {
        Self { router, cookie: None, token: None }
    }

    pub async fn send(&mut self, mut request: Request<Body>) -> Answer {
        let headers = request.headers_mut();
        if let Some(token) = &self.token {
            headers.insert(header::AUTHORIZATION, format!("Bearer {token}").parse().unwrap());
        }
        if let Some(cookie) = &self.cookie {
            headers.insert(header::COOKIE, cookie.parse().unwrap());
        }
        let response = self.router.clone().oneshot(request).await.unwrap();
        let (parts, body) = response.into_parts();
        for set in parts.headers.get_all(header::SET_COOKIE) {
            self.keep(set.to_str().unwrap());
        }
        let body = axum::body::to_bytes(body, usize::MAX).await.unwrap().to_vec();
        Answer { status: parts.status, headers: parts.headers, body }
    }

    /// Keeps a cookie, or throws it away where it is empty; the choice of a language is nobody's here.
    fn keep(&mut self, set: &str) {
        let pair = set.split(';').next().unwrap();
        let (name, value) = pair.split_once('=').unwrap();
        if name.ends_with("stylet_language") {
            return;
        }
        let kept = self.cookie.iter().flat_map(|all| all.split("; "));
        let mut kept: Vec<_> = kept.filter(|pair| pair.split_once('=').unwrap().0 != name).map(str::to_owned).collect();
        if !value.is_empty() {
            kept.push(pair.to_owned());
        }
        self.cookie = Some(kept.join("; ")).filter(|all| !all.is_empty());
    }

    /// The value of a cookie, by the end of its name.
    pub fn cookie_named(&self, name: &str) -> Option<String> {
        let pairs = self.cookie.as_deref()?.split("; ").filter_map(|pair| pair.split_once('='));
        pairs.into_iter().find(|(known, _)| known.ends_with(name)).map(|(_, value)| value.to_owned())
    }

    pub async fn request(&mut self, method: Method, path: &str) -> Answer {
        self.send(Request::builder().method(method).uri(path).body(Body::empty()).unwrap()).await
    }

    pub async fn get(&mut self, path: &str) -> Answer {
        self.request(Method::GET, path).await
    }

    /// Sends a form as a browser would.
    pub async fn form(&mut self, path: &str, fields: &[(&str, &str)]) -> Answer {
        let request = Request::post(path)
            .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
            .body(Body::from(encoded(fields)))
            .unwrap();
        self.send(request).await
    }

    /// Sends a form with a file as a browser would.
    pub async fn form_with_file(&mut self, path: &str, fields: &[(&str, &str)], file: SentFile<'_>) -> Answer {
        let part = |name: &str| format!("--XX\r\nContent-Disposition: form-data; name=\"{name}\"");
        let mut body = Vec::new();
        for (name, value) in fields {
            body.extend(format!("{}\r\n\r\n{value}\r\n", part(name)).bytes());
        }
        body.extend(format!("{}; filename=\"{}\"\r\n\r\n", part(file.field), file.name).bytes());
        body.extend(file.bytes);
        body.extend(b"\r\n--XX--\r\n");
        let request = Request::post(path).header(header::CONTENT_TYPE, "multipart/form-data; boundary=XX");
        self.send(request.body(Body::from(body)).unwrap()).await
    }

    pub async fn upload(&mut self, recording: &[u8]) -> Answer {
        let request = Request::post("/api/v1/sessions")
            .header(header::CONTENT_TYPE, "application/octet-stream")
            .body(Body::from(recording.to_vec()))
            .unwrap();
        self.send(request).await
    }

    /// The CSRF token of the sign-in page.
    pub async fn csrf(&mut self) -> String {
        let page = self.get("/login").await;
        assert_eq!(page.status, 200, "{}", page.text());
        csrf_in(&page.text())
    }

    pub async fn sign_in(&mut self, email: &str, password: &str) -> Answer {
        let csrf = self.csrf().await;
        self.form("/login", &[("csrf", &csrf), ("email", email), ("password", password)]).await
    }
}

/// Fields as a form or an address carries them.
pub fn encoded(fields: &[(&str, &str)]) -> String {
    let byte = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    let escape = |text: &str| text.bytes().map(byte).collect::<String>();
    fields.iter().map(|(name, value)| format!("{name}={}", escape(value))).collect::<Vec<_>>().join("&")
}

/// The value of the hidden field `csrf`.
/// A page without its token, which looks different each time.
pub fn without_csrf(page: &str) -> String {
    page.replace(&csrf_in(page), "")
}

pub fn csrf_in(page: &str) -> String {
    let field = page.split("name=\"csrf\"").nth(1).unwrap_or_else(|| panic!("no csrf field in {page}"));
    field.split("value=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
}
