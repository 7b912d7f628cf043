//! Signing in by a school's own OpenID Connect provider. Fails when a forged or stolen answer signs a user in or leaves no row in the audit
//! log, when an address alone opens an account, when a provider can make the service wait, load or connect to an address of the inside, or
//! when a provider that is gone locks the administrators out.

pub(crate) mod administration;
pub(crate) mod answers;
pub(crate) mod client_keys;
pub(crate) mod flows;
pub(crate) mod forgeries;
pub(crate) mod identities;
pub(crate) mod matching;
pub(crate) mod proofs;

use std::collections::{BTreeMap, BTreeSet};

use model::ids::SchoolId;
use model::{Moment, Role};
use platform::clock::Clock;
use platform::outgoing::OutgoingRules;
use serde_json::Value;
use store::people::directory::{self, Details};
use store::people::{self, NewPerson, Person};
use uuid::Uuid;

use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in};
use crate::support::provider::{CLIENT_ID, CLIENT_SECRET, ORIGIN, Provider};

/// Where administrators configure providers.
const ADMIN: &str = "/admin/sign-in";
const HEAD: &str = "head@example.org";
const ADA: &str = "ada@example.org";

/// A school with a provider and an administrator, at a time that stands still.
struct World {
    app: App,
    school: SchoolId,
    provider: Provider,
    /// Id of the provider.
    id: String,
    head: Client,
}

impl World {
    async fn new() -> Self {
        Self::with(&[]).await
    }

    /// With changes to the form of the provider.
    async fn with(changes: &[(&str, &str)]) -> Self {
        let clock = fixed_clock();
        let provider = Provider::start(&clock).await;
        let app = app_for(&clock, &[&provider]).await;
        let school = app.school("North").await;
        app.member(school, Role::Administrator, HEAD).await;
        let mut head = app.signed_in(HEAD).await;
        let id = add(&mut head, provider.issuer(), changes).await;
        Self { app, school, provider, id, head }
    }

    /// Runs a whole flow in a browser; the answer to the callback, or to the button if it leads nowhere.
    async fn enter(&self, browser: &mut Client) -> Answer {
        flow(browser, &self.provider, &self.id).await
    }

    /// Runs a whole flow in a browser of its own.
    async fn enter_anew(&self) -> (Client, Answer) {
        let mut browser = self.app.stranger();
        let answer = self.enter(&mut browser).await;
        (browser, answer)
    }

    /// A person without a password, as an invitation or a roster makes one.
    async fn invited(&self, role: Role, email: &str, number: Option<&str>) -> Person {
        invite(
            &self.app,
            NewPerson { school_id: self.school, role, email, display_name: "Invited", password_hash: "" },
            number,
        )
        .await
    }

    /// How, and under which subject, each identity was made.
    async fn identities(&self) -> Vec<String> {
        texts(&self.app, "SELECT how || ' ' || subject FROM identities ORDER BY made_at, subject").await
    }

    /// Does something with the provider at its page.
    async fn act(&mut self, act: &str) -> Answer {
        let csrf = csrf_in(&self.head.get(ADMIN).await.text());
        self.head.form(&format!("{ADMIN}/{}/{act}", self.id), &[("csrf", &csrf)]).await
    }

    /// Sets who may use local passwords.
    async fn set_local(&mut self, local: &str) -> Answer {
        let csrf = csrf_in(&self.head.get(ADMIN).await.text());
        self.head.form(&format!("{ADMIN}/local"), &[("csrf", &csrf), ("local", local)]).await
    }
}

/// Adds a person without a password, with a registration number.
pub(in crate::auth) async fn invite(app: &App, new: NewPerson<'_>, number: Option<&str>) -> Person {
    let now = app.state.clock.now();
    app.write(async |tx| {
        let person = people::add_person(tx, &new, now).await.unwrap();
        let details = Details { name: new.display_name, email: new.email, registrar_id: number };
        directory::change_details(tx, new.school_id, person.id, details).await.unwrap();
        person
    })
    .await
}

pub(in crate::auth) fn fixed_clock() -> Clock {
    Clock::fixed(Moment::from_micros(1_700_000_000_000_000))
}

/// A service that may send requests to these providers, which are on the loopback interface.
async fn app_for(clock: &Clock, providers: &[&Provider]) -> App {
    app_calling(clock, providers.iter().map(|provider| provider.address.clone()).collect()).await
}

/// A service that may send requests to these hosts and ports, which are on the loopback interface.
pub(in crate::auth) async fn app_calling(clock: &Clock, plain_http: Vec<String>) -> App {
    let change = |config: &mut platform::config::Config| {
        config.public_url = Some(ORIGIN.to_owned());
        config.outgoing = OutgoingRules { plain_http, private_addresses: true };
    };
    App::with(clock.clone(), change).await
}

/// Sends the form of a provider, with changes to its usual fields.
async fn send_provider(head: &mut Client, path: &str, issuer: &str, changes: &[(&str, &str)]) -> Answer {
    let csrf = csrf_in(&head.get(path).await.text());
    let mut fields = BTreeMap::from([
        ("csrf", csrf.as_str()),
        ("name", "University"),
        ("issuer", issuer),
        ("client_id", CLIENT_ID),
        ("client_secret", CLIENT_SECRET),
        ("scopes", "openid profile email"),
        ("subject_claim", "sub"),
        ("match_claim", ""),
        ("creates", ""),
        ("role_claim", ""),
        ("role_map", ""),
    ]);
    fields.extend(changes.iter().copied());
    head.form(path, &fields.into_iter().collect::<Vec<_>>()).await
}

/// Adds a provider; returns its id.
async fn add(head: &mut Client, issuer: &str, changes: &[(&str, &str)]) -> String {
    let before = ids(&head.get(ADMIN).await.text());
    let added = send_provider(head, ADMIN, issuer, changes).await;
    assert_eq!((added.status.as_u16(), added.header("location")), (303, ADMIN), "{}", added.text());
    let after = ids(&head.get(ADMIN).await.text());
    let mut new = after.difference(&before);
    let id = new.next().expect("the list shows the new provider").clone();
    assert_eq!(new.next(), None);
    id
}

/// Ids of the providers that a page of administrators links to.
fn ids(page: &str) -> BTreeSet<String> {
    let start = format!("{ADMIN}/");
    let starts = page.split(&start).skip(1).filter_map(|rest| rest.get(..36));
    starts.filter(|id| Uuid::parse_str(id).is_ok()).map(str::to_owned).collect()
}

/// Presses the button of a provider on the sign-in page.
async fn press(browser: &mut Client, id: &str, next: &str) -> Answer {
    let csrf = browser.csrf().await;
    browser.form(&format!("/sign-in/{id}"), &[("csrf", &csrf), ("next", next)]).await
}

/// Returns the address at the provider to which a page sends the browser, by header and by link.
pub(in crate::auth) fn authorize_url(begun: &Answer) -> String {
    assert_eq!(begun.status, 200, "{}", begun.text());
    let refresh = begun.header("refresh");
    let url = refresh.strip_prefix("0; url=").unwrap_or_else(|| panic!("the header Refresh is {refresh:?}"));
    let page = begun.text();
    let is_linked = |and| page.contains(&format!("href=\"{}\"", url.replace('&', and)));
    assert!(["&", "&amp;", "&#38;"].into_iter().any(is_linked), "{page}");
    url.to_owned()
}

/// Runs a whole flow; the answer to the callback, or to the button if it leads nowhere.
async fn flow(browser: &mut Client, provider: &Provider, id: &str) -> Answer {
    let begun = press(browser, id, "/").await;
    if begun.status != 200 {
        return begun;
    }
    browser.get(&provider.log_in(&authorize_url(&begun))).await
}

/// Whether a browser is signed in.
pub(in crate::auth) async fn is_signed_in(browser: &mut Client) -> bool {
    browser.get("/").await.status == 200
}

/// Whether a browser is signed in as a person.
pub(in crate::auth) async fn is_signed_in_as(browser: &mut Client, person: &Person) -> bool {
    let page = browser.get("/account").await;
    page.status == 200 && page.text().contains(&person.pseudonym)
}

/// Rows of one text each.
pub(in crate::auth) async fn texts(app: &App, query: &'static str) -> Vec<String> {
    sqlx::query_scalar(query).fetch_all(app.state.db.reader()).await.unwrap()
}

/// The reasons of all refusals, from the audit log; no row contains a token.
async fn reasons(app: &App) -> Vec<String> {
    let query = "SELECT details FROM audit_log WHERE action = 'sign_in.provider_refused' ORDER BY seq";
    texts(app, query).await.iter().map(|details| reason_in(details)).collect()
}

/// The reason in the details of a refusal, which contain no token.
pub(in crate::auth) fn reason_in(details: &str) -> String {
    assert!(!details.contains("eyJ") && !details.contains("code-"), "{details}");
    let details: Value = serde_json::from_str(details).unwrap();
    details["reason"].as_str().unwrap_or_else(|| panic!("no reason in {details}")).to_owned()
}

/// Asserts that an answer refuses for a reason, that the reason is the only new row, and that the browser is not signed in. `before` is the
/// number of earlier refusals.
async fn assert_refused(app: &App, browser: &mut Client, answer: &Answer, before: usize) -> String {
    let status = answer.status.as_u16();
    assert!([400, 401, 403, 503].contains(&status), "{status}: {}", answer.text());
    let reasons = reasons(app).await;
    assert_eq!(reasons.len(), before + 1, "one row for each refusal: {reasons:?}");
    assert!(!is_signed_in(browser).await, "{reasons:?}");
    let reason = reasons.last().unwrap().clone();
    assert_eq!(status == 503, reason == "unreachable", "{status} for {reason}");
    reason
}
