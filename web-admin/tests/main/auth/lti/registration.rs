//! Dynamic registration. Fails when a platform is registered by anybody but an administrator who was shown what is stored, when it registers
//! itself as another one, or when its token is used twice.

use model::Role;
use platform::outgoing::OutgoingRules;
use serde_json::{Value, json};

use super::{ADMIN, HEAD, frame_ancestors, get_framed};
use crate::auth::federation::{app_calling, fixed_clock, texts};
use crate::support::App;
use crate::support::client::{Answer, Client, csrf_in, encoded};
use crate::support::learning_platform::{LearningPlatform, REGISTRATION_TOKEN};
use crate::support::provider::ORIGIN;

/// A school without learning platforms, and a platform that asks to be registered.
struct World {
    app: App,
    platform: LearningPlatform,
    head: Client,
}

impl World {
    async fn new() -> Self {
        let clock = fixed_clock();
        let platform = LearningPlatform::start(&clock).await;
        let app = app_calling(&clock, vec![platform.address.clone()]).await;
        let school = app.school("North").await;
        app.member(school, Role::Administrator, HEAD).await;
        app.member(school, Role::Instructor, "teacher@example.org").await;
        app.member(school, Role::Trainee, "ada@example.org").await;
        let head = app.signed_in(HEAD).await;
        Self { app, platform, head }
    }

    /// The address that the platform opens.
    fn path(&self) -> String {
        let url = self.platform.configuration_url();
        format!(
            "/lti/register?{}",
            encoded(&[("openid_configuration", &url), ("registration_token", REGISTRATION_TOKEN)])
        )
    }

    /// Presses the button of the page that shows what will be stored.
    async fn confirm(&mut self, page: &str) -> Answer {
        let field = |name: &str| {
            let rest = page.split(&format!("name=\"{name}\" value=\"")).nth(1);
            rest.and_then(|rest| rest.split('"').next()).unwrap_or_else(|| panic!("no {name} in {page}")).to_owned()
        };
        let csrf = csrf_in(page);
        let names = ["openid_configuration", "registration_token", "digest"];
        let values = names.map(field);
        let fields: Vec<_> =
            names.into_iter().zip(values.iter().map(String::as_str)).chain([("csrf", csrf.as_str())]).collect();
        self.head.form(&format!("{ADMIN}/register"), &fields).await
    }

    async fn stored(&self) -> Vec<String> {
        texts(&self.app, "SELECT issuer || ' ' || client_id FROM platforms").await
    }
}

#[tokio::test]
async fn an_administrator_registers_what_was_shown() {
    let mut world = World::new().await;
    let page = world.head.get(&world.path()).await;
    assert_eq!(
        (page.status.as_u16(), page.header("cross-origin-opener-policy")),
        (200, "unsafe-none"),
        "{}",
        page.text()
    );
    let issuer = format!("http://{}", world.platform.address);
    for shown in ["/auth", "/token", "/keys", "/register"] {
        assert!(page.text().contains(&format!("<code>{issuer}{shown}</code>")), "{shown}: {}", page.text());
    }
    assert_eq!((world.stored().await, world.platform.tools()), (vec![], vec![]), "nothing is stored by looking");

    let done = world.confirm(&page.text()).await;
    assert!(done.status == 200 && done.text().contains("Close this window"), "{}", done.text());
    assert!(done.text().contains("<script src=\"/assets/registered.js"));
    assert_eq!(world.stored().await, [format!("{issuer} registered-1")]);
    let [tool] = &world.platform.tools()[..] else { panic!("one registration") };
    for (member, value) in [
        ("application_type", json!("web")),
        ("response_types", json!(["id_token"])),
        ("grant_types", json!(["client_credentials", "implicit"])),
        ("initiate_login_uri", json!(format!("{ORIGIN}/lti/login"))),
        ("redirect_uris", json!([format!("{ORIGIN}/lti/launch")])),
        ("jwks_uri", json!(format!("{ORIGIN}/.well-known/jwks.json"))),
        ("token_endpoint_auth_method", json!("private_key_jwt")),
    ] {
        assert_eq!(tool[member], value, "{member}");
    }
    assert!(tool["scope"].as_str().unwrap().contains("contextmembership.readonly"), "{tool}");
    let own = &tool["https://purl.imsglobal.org/spec/lti-tool-configuration"];
    let messages: Vec<&Value> = own["messages"].as_array().unwrap().iter().map(|message| &message["type"]).collect();
    assert_eq!(messages, ["LtiResourceLinkRequest", "LtiDeepLinkingRequest"]);
    let admitted = "SELECT deployment_id FROM platform_deployments WHERE admitted_at IS NOT NULL";
    assert_eq!(texts(&world.app, admitted).await, ["d7"]);
    let acts = "SELECT action FROM audit_log WHERE action LIKE 'platform.%' ORDER BY seq";
    assert_eq!(texts(&world.app, acts).await, ["platform.added", "platform.deployment_admitted"]);
    assert!(
        texts(&world.app, "SELECT details FROM audit_log").await.iter().all(|row| !row.contains(REGISTRATION_TOKEN))
    );
}

#[tokio::test]
async fn a_token_registers_once() {
    let mut world = World::new().await;
    let page = world.head.get(&world.path()).await.text();
    assert_eq!(world.confirm(&page).await.status, 200);
    let again = world.confirm(&page).await;
    assert!(again.status == 422 && again.text().contains("HTTP status 401"), "{}", again.text());
    assert_eq!((world.stored().await.len(), world.platform.tools().len()), (1, 1));
}

#[tokio::test]
async fn a_configuration_that_has_changed_is_shown_again() {
    let mut world = World::new().await;
    let page = world.head.get(&world.path()).await.text();
    world.platform.configure("token_endpoint", format!("http://{}/other", world.platform.address));
    let refused = world.confirm(&page).await;
    assert!(refused.status == 422 && refused.text().contains("/other</code>"), "{}", refused.text());
    assert_eq!((world.stored().await, world.platform.tools()), (vec![], vec![]));
    assert_eq!(world.confirm(&refused.text()).await.status, 200);
}

#[tokio::test]
async fn only_an_administrator_registers() {
    let world = World::new().await;
    let path = world.path();
    let page = world.app.stranger().get(&path).await;
    assert!(page.status == 200 && page.text().contains("href=\"/login\""), "{}", page.text());
    for email in ["teacher@example.org", "ada@example.org"] {
        let mut client = world.app.signed_in(email).await;
        assert_eq!(client.get(&path).await.status, 403, "{email}");
        let csrf = csrf_in(&client.get("/account").await.text());
        assert_eq!(client.form(&format!("{ADMIN}/register"), &[("csrf", &csrf)]).await.status, 403, "{email}");
    }
    assert!(world.stored().await.is_empty());
}

#[tokio::test]
async fn in_a_frame_a_registration_opens_a_window() {
    let mut world = World::new().await;
    let path = world.path();
    let page = get_framed(&mut world.head, &path).await;
    assert_eq!(frame_ancestors(&page), format!("http://{}", world.platform.address));
    let html = page.text();
    assert!(
        html.contains("target=\"_blank\"") && html.contains(REGISTRATION_TOKEN) && !html.contains("digest"),
        "{html}"
    );
    let done = world.head.get(&path).await;
    assert_eq!(frame_ancestors(&done), "'none'", "outside of a frame");
}

#[tokio::test]
async fn a_platform_registers_as_itself_and_at_permitted_places() {
    let mut world = World::new().await;
    let own = format!("http://{}", world.platform.address);
    for (name, value) in [
        ("issuer", "https://canvas.example.com"),
        ("issuer", "127.0.0.1"),
        ("authorization_endpoint", "javascript:alert(1)"),
        ("token_endpoint", "http://127.0.0.1:9/token"),
        ("jwks_uri", "file:///etc/passwd"),
        ("registration_endpoint", "http://169.254.169.254/latest"),
    ] {
        let usual = world.head.get(&world.path()).await;
        assert_eq!(usual.status, 200, "{}", usual.text());
        let before = if name == "issuer" { own.clone() } else { format!("{own}/usual") };
        world.platform.configure(name, value);
        let refused = world.head.get(&world.path()).await;
        assert!(refused.status == 422 && !refused.text().contains("digest"), "{name} {value}: {}", refused.text());
        world.platform.configure(name, before);
    }
    for address in ["", "http://127.0.0.1:9/", "https://user@lms.example.edu/", "ftp://lms.example.edu/"] {
        let path = format!("/lti/register?{}", encoded(&[("openid_configuration", address)]));
        assert_eq!(world.head.get(&path).await.status, 422, "{address}");
    }
    assert!(world.stored().await.is_empty());
}

#[tokio::test]
async fn a_private_address_is_not_fetched() {
    let clock = fixed_clock();
    let platform = LearningPlatform::start(&clock).await;
    let plain_http = vec![platform.address.clone()];
    let app = App::with(clock, |config| config.outgoing = OutgoingRules { plain_http, private_addresses: false }).await;
    let school = app.school("North").await;
    app.member(school, Role::Administrator, HEAD).await;
    let mut head = app.signed_in(HEAD).await;
    let path = format!("/lti/register?{}", encoded(&[("openid_configuration", &platform.configuration_url())]));
    let refused = head.get(&path).await;
    assert!(refused.status == 422 && refused.text().contains("not public"), "{}", refused.text());
}
