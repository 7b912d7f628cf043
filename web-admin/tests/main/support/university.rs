//! The systems of a university that a school uses: an OpenID provider, a directory, a learning platform.

use model::auth::deep_linking::{ContentRequest, DeepLinkingRequest};
use model::auth::federation::{Claims, IdentityKind, IdentityOrigin, ProvenIdentity, ProviderSettings};
use model::auth::lti::{Launch, LaunchContext, PlatformSettings};
use model::ids::{
    ContentChoiceId, DeliveryId, IdentityId, PlatformContextId, PlatformId, ProviderId, ProvisioningTokenId,
};
use model::{PersonKey, Role};
use platform::secret;
use serde_json::json;
use store::auth::federation::identities::{IssuedSubject, NewIdentity};
use store::auth::federation::providers::NewProvider;
use store::auth::federation::{identities, providers};
use store::auth::lti::courses::DeployedPlatform;
use store::auth::lti::platforms::{self, NewPlatform, Platform};
use store::auth::lti::{content_choices, courses, deliveries};
use store::people::provisioning::{self, ProvisioningToken};

use super::{App, Member};

/// Token of the directory.
pub const DIRECTORY: &str = "directory";

/// Adds a provider at an address that may not be asked, a trainee's identity there, a directory, a learning platform with a course and a grade
/// for it, and the choice of content that a teacher has begun there; returns their ids by name.
pub async fn add_systems(app: &App, own: &Member, teacher: &Member) -> [(&'static str, String); 6] {
    let (school_id, now) = (own.person.school_id, app.state.clock.now());
    let settings = ProviderSettings {
        name: "North".to_owned(),
        issuer: "https://127.0.0.1:9".to_owned(),
        client_id: "stylet".to_owned(),
        scopes: "openid".to_owned(),
        subject_claim: "sub".to_owned(),
        ..ProviderSettings::default()
    };
    let (provider, identity) = (ProviderId::made_at(now), IdentityId::made_at(now));
    app.write(async |tx| {
        let new = NewProvider { id: provider, school_id, settings: &settings, sealed_secret: b"sealed" };
        providers::put_provider(tx, new, now).await.unwrap();
        let of = IssuedSubject { school_id, kind: IdentityKind::Oidc, issuer: &settings.issuer, subject: "own" };
        let how = IdentityOrigin::ByAdministrator;
        let new = NewIdentity { id: identity, person_id: own.person.id, of, how, made_by: None, at: now };
        identities::add_identity(tx, new).await.unwrap();
    })
    .await;
    let token = ProvisioningToken {
        id: ProvisioningTokenId::made_at(now),
        school_id,
        name: "Directory".to_owned(),
        may_disable_staff: false,
        made_at: now,
        expires_at: now.plus_s(86_400),
        last_used_at: None,
    };
    app.write(async |tx| provisioning::add_token(tx, &token, &secret::token_sha256(DIRECTORY)).await.unwrap()).await;
    let (platform, delivery) = learning_platform(app, own).await;
    let course = course_of(app, &platform).await;
    let choice = content_choice(app, &platform, teacher).await;
    [
        ("provider", provider.to_string()),
        ("identity", identity.to_string()),
        ("platform", platform.id.to_string()),
        ("delivery", delivery.to_string()),
        ("choice", choice.to_string()),
        ("lms_course", course.to_string()),
    ]
}

/// A learning platform of the school, with a deployment that waits, and a grade of the trainee that waits.
async fn learning_platform(app: &App, own: &Member) -> (Platform, DeliveryId) {
    let school_id = own.person.school_id;
    let (id, now) = (PlatformId::made_at(app.state.clock.now()), app.state.clock.now());
    let settings = PlatformSettings {
        name: "Moodle".to_owned(),
        issuer: "https://lms.example.edu".to_owned(),
        client_id: "stylet".to_owned(),
        auth_url: "https://lms.example.edu/auth".to_owned(),
        token_url: "https://lms.example.edu/token".to_owned(),
        keys_url: "https://lms.example.edu/keys".to_owned(),
        ..PlatformSettings::default()
    };
    app.write(async |tx| {
        platforms::put_platform(tx, NewPlatform { id, school_id, settings: &settings }, now).await.unwrap();
        let platform = platforms::find_platform(&mut *tx, school_id, id).await.unwrap().unwrap();
        platforms::add_deployment(tx, &platform, "1", 1, now).await.unwrap();
        let launch = launch();
        courses::put_launch(tx, &platform, &launch, now).await.unwrap();
        let link = courses::find_link(&mut *tx, &platform, &launch).await.unwrap().unwrap();
        let person = PersonKey { school_id, person_id: own.person.id };
        deliveries::put_delivery(tx, link, person, "own", now).await.unwrap();
        let due = deliveries::list_due_deliveries(&mut *tx, school_id, id, now, 1).await.unwrap();
        (platform, due[0].id)
    })
    .await
}

/// A course of a platform.
async fn course_of(app: &App, platform: &Platform) -> PlatformContextId {
    let context = LaunchContext { id: "5".to_owned(), title: None, members_url: None, lineitems_url: None };
    let deployed = DeployedPlatform { platform, deployment: "1" };
    let now = app.state.clock.now();
    app.write(async |tx| courses::put_context(tx, deployed, &context, now).await.unwrap()).await
}

/// A choice of content that a person has begun at a platform.
async fn content_choice(app: &App, platform: &Platform, by: &Member) -> ContentChoiceId {
    let (school_id, now) = (platform.school_id, app.state.clock.now());
    let issuer = platform.settings.identity_issuer();
    let asked = DeepLinkingRequest {
        identity: ProvenIdentity {
            issuer: issuer.clone(),
            subject: "teacher".to_owned(),
            name: "Teacher".to_owned(),
            email: None,
            email_verified: false,
            number: None,
            role: Role::Trainee,
            has_second_factor: false,
        },
        deployment: "1".to_owned(),
        context: None,
        content: ContentRequest {
            return_url: "https://lms.example.edu/return".to_owned(),
            data: None,
            accepts_several: false,
            accepts_line_items: false,
        },
    };
    app.write(async |tx| {
        let of = IssuedSubject { school_id, kind: IdentityKind::Lti, issuer: &issuer, subject: "teacher" };
        let (id, how) = (IdentityId::made_at(now), IdentityOrigin::ByAdministrator);
        identities::add_identity(tx, NewIdentity { id, person_id: by.person.id, of, how, made_by: None, at: now })
            .await
            .unwrap();
        content_choices::add_choice(tx, platform, &asked, now.plus_s(3600), now).await.unwrap()
    })
    .await
}

/// A launch of an exercise, whose grade the platform takes.
fn launch() -> Launch {
    let settings = PlatformSettings::default();
    let claims = json!({
        "sub": "own",
        "https://purl.imsglobal.org/spec/lti/claim/message_type": "LtiResourceLinkRequest",
        "https://purl.imsglobal.org/spec/lti/claim/version": "1.3.0",
        "https://purl.imsglobal.org/spec/lti/claim/deployment_id": "1",
        "https://purl.imsglobal.org/spec/lti/claim/target_link_uri": "https://training.example.org/exercises/feel-the-layers",
        "https://purl.imsglobal.org/spec/lti/claim/resource_link": { "id": "1" },
        "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint": { "lineitem": "https://lms.example.edu/items/1" },
    });
    let claims = Claims(claims.as_object().cloned().unwrap());
    Launch::read(&settings, &claims, "https://training.example.org").unwrap()
}
