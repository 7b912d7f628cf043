//! Launches from learning platforms by LTI 1.3. Fails when a forged or stolen launch signs a user in or leaves no row in the audit log, when two
//! schools with one issuer mix, when another page than the one that opens a window may be shown in a frame, or when a launch opens an account
//! because of the session in the browser, or of an email address. Grades: see [`grades`].

pub(crate) mod administration;
pub(crate) mod deep_linking;
pub(crate) mod forgeries;
pub(crate) mod grades;
pub(crate) mod launches;
pub(crate) mod people;
pub(crate) mod registration;
pub(crate) mod rosters;

use std::collections::BTreeMap;

use axum::body::Body;
use axum::http::{Request, header};
use model::Role;
use model::auth::federation::{IdentityKind, IdentityOrigin};
use model::ids::{IdentityId, SchoolId};
use platform::clock::Clock;
use store::auth::federation::identities::{self, IssuedSubject, NewIdentity};

use super::federation::{app_calling, authorize_url, fixed_clock, is_signed_in, reason_in, texts};
use crate::support::client::{Answer, Client, csrf_in, encoded};
use crate::support::learning_platform::{ISSUER, LaunchMessage, LearningPlatform};
use crate::support::provider::ORIGIN;
use crate::support::{App, Member};

/// Where administrators register learning platforms.
const ADMIN: &str = "/admin/platforms";
const HEAD: &str = "head@example.org";
const ADA: &str = "ada@example.org";
const CLIENT: &str = "client-1";

/// A school with a learning platform, whose deployment `1` is admitted, and an administrator, at a time that stands still.
struct World {
    app: App,
    school: SchoolId,
    platform: LearningPlatform,
    /// Id of the registration.
    id: String,
    head: Client,
}

impl World {
    async fn new() -> Self {
        Self::with(&[]).await
    }

    /// With changes to the form of the registration.
    async fn with(changes: &[(&str, &str)]) -> Self {
        Self::calling(changes, Vec::new()).await
    }

    /// With changes to the form of the registration, and further hosts to which the service may send requests.
    async fn calling(changes: &[(&str, &str)], mut hosts: Vec<String>) -> Self {
        let clock = fixed_clock();
        let platform = LearningPlatform::start(&clock).await;
        hosts.push(platform.address.clone());
        let app = app_calling(&clock, hosts).await;
        let school = app.school("North").await;
        app.member(school, Role::Administrator, HEAD).await;
        let mut head = app.signed_in(HEAD).await;
        let id = add(&mut head, &platform, changes).await;
        let mut world = Self { app, school, platform, id, head };
        assert_eq!(refusal(&world.launch_anew(&LaunchMessage::by("first")).await.1), "deployment");
        world.admit("1").await;
        world
    }

    fn clock(&self) -> &Clock {
        &self.app.state.clock
    }

    /// Begins a launch; the address at the platform to which the browser is sent.
    async fn begin(&self, browser: &mut Client) -> String {
        authorize_url(&browser.get(&login(&[])).await)
    }

    /// Runs a whole launch in a browser.
    async fn launch(&self, browser: &mut Client, message: &LaunchMessage) -> Answer {
        let url = self.begin(browser).await;
        post(browser, &self.platform.confirm(&url, message)).await
    }

    /// Runs a whole launch in a browser of its own.
    async fn launch_anew(&self, message: &LaunchMessage) -> (Client, Answer) {
        let mut browser = self.app.stranger();
        let answer = self.launch(&mut browser, message).await;
        (browser, answer)
    }

    /// Admits a deployment at the page of the registration.
    async fn admit(&mut self, deployment: &str) {
        let own = format!("{ADMIN}/{}", self.id);
        let page = self.head.get(&own).await.text();
        let field = format!("name=\"deployment\" value=\"{deployment}\"");
        assert!(page.contains(&field), "{deployment} waits: {page}");
        let fields = [("csrf", csrf_in(&page)), ("deployment", deployment.to_owned())];
        let fields = fields.each_ref().map(|(name, value)| (*name, value.as_str()));
        let admitted = self.head.form(&format!("{own}/admit"), &fields).await;
        assert_eq!((admitted.status.as_u16(), admitted.header("location")), (303, own.as_str()));
        assert!(!self.head.get(&own).await.text().contains(&field));
    }

    /// Adds a person whom the platform calls `subject`.
    async fn known(&self, role: Role, email: &str, subject: &str) -> Member {
        let member = self.app.member(self.school, role, email).await;
        let now = self.clock().now();
        let issuer = format!("{ISSUER} {CLIENT}");
        let of = IssuedSubject { school_id: self.school, kind: IdentityKind::Lti, issuer: &issuer, subject };
        let (id, how) = (IdentityId::made_at(now), IdentityOrigin::ByAdministrator);
        let new = NewIdentity { id, person_id: member.person.id, of, how, made_by: None, at: now };
        assert!(self.app.write(async |tx| identities::add_identity(tx, new).await.unwrap()).await);
        member
    }

    /// Does something with the registration at the page of all.
    async fn act(&mut self, act: &str) -> Answer {
        let csrf = csrf_in(&self.head.get(ADMIN).await.text());
        self.head.form(&format!("{ADMIN}/{}/{act}", self.id), &[("csrf", &csrf)]).await
    }

    /// How, and under which subject, each identity was made.
    async fn identities(&self) -> Vec<String> {
        texts(&self.app, "SELECT kind || ' ' || how || ' ' || subject FROM identities ORDER BY made_at, subject").await
    }

    /// The reasons of all refusals but that of the first launch, from the audit log.
    async fn reasons(&self) -> Vec<String> {
        let query = "SELECT details FROM audit_log WHERE action = 'sign_in.launch_refused' ORDER BY seq";
        texts(&self.app, query).await.iter().skip(1).map(|details| reason_in(details)).collect()
    }

    /// Asserts that an answer refuses for a reason, that the reason is the only new row after `before`, and that the browser is not signed in.
    async fn assert_refused(&self, browser: &mut Client, answer: &Answer, before: usize) -> String {
        let reason = refusal(answer);
        let reasons = self.reasons().await;
        assert_eq!(reasons.len(), before + 1, "one row for each refusal: {reasons:?}");
        assert_eq!(reasons.last(), Some(&reason));
        assert!(!is_signed_in(browser).await, "{reason}");
        reason
    }
}

/// The reason that a page of refusal shows.
fn refusal(answer: &Answer) -> String {
    let page = answer.text();
    assert!([403, 503].contains(&answer.status.as_u16()), "{}: {page}", answer.status);
    let code = page.split("this code: ").nth(1).unwrap_or_else(|| panic!("no code in {page}"));
    code.split('<').next().unwrap().to_owned()
}

/// Address to which platforms post launches.
fn launch_address() -> String {
    format!("{ORIGIN}/lti/launch")
}

/// Address at which a platform initiates a login, with changes to its usual parameters; an empty one is left out.
fn login(changes: &[(&str, &str)]) -> String {
    let target = launch_address();
    let mut fields = BTreeMap::from([
        ("iss", ISSUER),
        ("client_id", CLIENT),
        ("login_hint", "user-7"),
        ("lti_message_hint", "message-9"),
        ("target_link_uri", target.as_str()),
    ]);
    fields.extend(changes.iter().copied());
    let fields: Vec<_> = fields.into_iter().filter(|(_, value)| !value.is_empty()).collect();
    format!("/lti/login?{}", encoded(&fields))
}

/// Posts a form from the platform's site: of the browser's cookies, those of launches alone come along.
async fn post(browser: &mut Client, fields: &[(&'static str, String)]) -> Answer {
    let all = browser.cookie.take().unwrap_or_default();
    let (sent, kept): (Vec<_>, Vec<_>) =
        all.split("; ").filter(|pair| !pair.is_empty()).partition(|pair| pair.starts_with("__Host-lti-"));
    browser.cookie = Some(sent.join("; ")).filter(|sent| !sent.is_empty());
    let fields: Vec<_> = fields.iter().map(|(name, value)| (*name, value.as_str())).collect();
    let answer = browser.form("/lti/launch", &fields).await;
    let new = browser.cookie.take().unwrap_or_default();
    let name = |pair: &str| pair.split('=').next().unwrap_or_default().to_owned();
    let is_replaced = |pair: &str| new.split("; ").any(|known| name(known) == name(pair));
    let all = kept.into_iter().filter(|pair| !is_replaced(pair)).chain(new.split("; ")).filter(|pair| !pair.is_empty());
    browser.cookie = Some(all.collect::<Vec<_>>().join("; ")).filter(|all| !all.is_empty());
    answer
}

/// Loads an address as a browser does in a frame.
async fn get_framed(browser: &mut Client, path: &str) -> Answer {
    let request = Request::get(path).header("sec-fetch-dest", "iframe").body(Body::empty()).unwrap();
    browser.send(request).await
}

/// The sources that may show an answer in a frame.
fn frame_ancestors(answer: &Answer) -> String {
    let policy = answer.header(header::CONTENT_SECURITY_POLICY.as_str());
    let named = policy.split(';').find_map(|rule| rule.trim().strip_prefix("frame-ancestors "));
    named.unwrap_or_else(|| panic!("no frame-ancestors in {policy:?}")).to_owned()
}

/// Sends the form of a registration, with changes to its usual fields.
async fn send_platform(head: &mut Client, path: &str, platform: &LearningPlatform, changes: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&head.get(path).await.text());
    let urls = platform.fields();
    let mut fields = BTreeMap::from([
        ("csrf", csrf.as_str()),
        ("name", "Canvas"),
        ("issuer", ISSUER),
        ("client_id", CLIENT),
        ("token_audience", ""),
        ("number_claim", ""),
    ]);
    fields.extend(urls.iter().map(|(name, value)| (*name, value.as_str())));
    fields.extend(changes.iter().copied());
    head.form(path, &fields.into_iter().collect::<Vec<_>>()).await
}

/// Registers a platform; returns the id of the registration.
async fn add(head: &mut Client, platform: &LearningPlatform, changes: &[(&str, &str)]) -> String {
    let added = send_platform(head, ADMIN, platform, changes).await;
    assert_eq!(added.status, 303, "{}", added.text());
    let id = added.header("location").strip_prefix(&format!("{ADMIN}/")).expect("the page of the registration");
    id.to_owned()
}
