//! Visitors who request pages, all signed in but one.

use anyhow::{Context, ensure};
use axum::body::{Body, Bytes, to_bytes};
use axum::http::{Request, Response, StatusCode, header};
use hyper_util::client::legacy::Client;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::TokioExecutor;
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use store::operations::fixtures;

use super::PASSWORD;
use super::doors::Doors;
use crate::demo::school::{self, ADMINISTRATOR, COHORTS, LEARNERS};

/// Number of trainees and of instructors of the crowd that visit, spread evenly over all of them.
const OF_EACH: u32 = 4;
/// Trainees per instructor of the crowd: four cohorts of thirty.
const TRAINEES_OF_AN_INSTRUCTOR: u32 = 120;

/// A visitor.
#[derive(Clone)]
pub(super) struct BenchVisitor {
    /// Role, in one word.
    pub role: &'static str,
    /// Starting addresses.
    pub begins: Vec<String>,
    url: String,
    cookie: String,
    client: Client<HttpConnector, Body>,
}

/// A response, read completely.
pub(super) struct PageAnswer {
    pub status: StatusCode,
    pub body: Bytes,
}

/// Starting addresses of every visitor: the home page and two searches for people.
const HOME: [&str; 3] = ["/", "/people?q=instructor", "/people?q=generated+00042"];

/// Signs in the demonstration's administrator, one instructor and one trainee of it, and some
/// instructors and trainees of the crowd. An anonymous visitor comes last.
pub(super) async fn sign_in(url: &str, trainees: u32, doors: Doors) -> anyhow::Result<Vec<BenchVisitor>> {
    let instructors = trainees.div_ceil(TRAINEES_OF_AN_INSTRUCTOR);
    let mut people = vec![
        ("administrator", school::email_of(ADMINISTRATOR)),
        ("instructor", school::email_of(COHORTS[0].instructor)),
        ("trainee", school::email_of(LEARNERS[0].name)),
    ];
    people.extend(spread_visitors(instructors).map(|place| ("instructor", fixtures::instructor_email(place))));
    people.extend(spread_visitors(trainees).map(|place| ("trainee", fixtures::trainee_email(place))));
    let mut visitors = Vec::new();
    for (role, email) in people {
        let home = HOME.map(str::to_owned).into_iter();
        let own = match role {
            "administrator" => doors.administrator.clone(),
            _ if email == fixtures::instructor_email(0) => doors.instructor.clone(),
            _ => Vec::new(),
        };
        let mut visitor = BenchVisitor::new(role, url, home.chain(own).collect());
        visitor.sign_in(&email).await.with_context(|| format!("{email} cannot sign in"))?;
        visitors.push(visitor);
    }
    visitors.push(BenchVisitor::new("stranger", url, doors.stranger));
    Ok(visitors)
}

/// Returns at most [`OF_EACH`] indices, spread evenly over `0..of`.
fn spread_visitors(of: u32) -> impl Iterator<Item = u32> {
    let many = OF_EACH.min(of);
    (0..many).map(move |n| n * (of / many))
}

impl BenchVisitor {
    /// Creates a visitor who is not signed in yet.
    pub(super) fn new(role: &'static str, url: &str, begins: Vec<String>) -> Self {
        let client = Client::builder(TokioExecutor::new()).build_http();
        Self { role, begins, url: url.to_owned(), cookie: String::new(), client }
    }

    /// Requests a page with an `Accept-Encoding` (`gzip`, or `identity` for none), and reads the
    /// response completely.
    pub(super) async fn ask(&self, path: &str, encoding: &str) -> anyhow::Result<PageAnswer> {
        let request = Request::get(format!("{}{path}", self.url))
            .header(header::COOKIE, &self.cookie)
            .header(header::ACCEPT_ENCODING, encoding)
            .body(Body::empty())?;
        let answer = self.client.request(request).await?;
        let status = answer.status();
        Ok(PageAnswer { status, body: to_bytes(Body::new(answer.into_body()), usize::MAX).await? })
    }

    async fn sign_in(&mut self, email: &str) -> anyhow::Result<()> {
        let page = self.client.request(Request::get(format!("{}/login", self.url)).body(Body::empty())?).await?;
        self.cookie = cookie_of_answer(&page)?;
        let page = to_bytes(Body::new(page.into_body()), usize::MAX).await?;
        let page = String::from_utf8_lossy(&page);
        let csrf = page.split("name=\"csrf\" value=\"").nth(1).and_then(|rest| rest.split('"').next());
        let fields = [("csrf", csrf.context("a form to sign in with")?), ("email", email), ("password", PASSWORD)];
        let escaped = |text| utf8_percent_encode(text, NON_ALPHANUMERIC).to_string();
        let form: Vec<String> = fields.iter().map(|(name, value)| format!("{name}={}", escaped(value))).collect();
        let request = Request::post(format!("{}/login", self.url))
            .header(header::COOKIE, &self.cookie)
            .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
            .body(Body::from(form.join("&")))?;
        let answer = self.client.request(request).await?;
        ensure!(answer.status() == StatusCode::SEE_OTHER, "answered {}", answer.status());
        self.cookie = cookie_of_answer(&answer)?;
        Ok(())
    }
}

/// Returns the cookie that a response sets: that of a form, or that of a session.
fn cookie_of_answer<B>(answer: &Response<B>) -> anyhow::Result<String> {
    let set = answer.headers().get_all(header::SET_COOKIE).iter().filter_map(|value| value.to_str().ok());
    let mut ours = set.filter(|set| set.starts_with("stylet_"));
    let pair = ours.next().and_then(|set| set.split(';').next());
    Ok(pair.context("an answer that sets no cookie")?.to_owned())
}
