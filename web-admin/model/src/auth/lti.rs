//! Launches from learning platforms (LTI 1.3): the platforms of a school, and the claims of a launch.

use serde::Deserialize;
use serde_json::{Map, Value};
use url::{Origin, Url};

use crate::auth::federation::{Claims, ProvenIdentity, check_setting};
use crate::auth::sign_in_refusal::SignInRefusal;
use crate::single_line_text;

/// Prefix of the claims of LTI 1.3.
pub(super) const LTI: &str = "https://purl.imsglobal.org/spec/lti/claim/";
/// Claim of Assignment and Grade Services.
const GRADES: &str = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint";
/// Claim of Names and Role Provisioning Services.
const MEMBERS: &str = "https://purl.imsglobal.org/spec/lti-nrps/claim/namesroleservice";
/// Message type of the launch of a link.
const RESOURCE_LINK: &str = "LtiResourceLinkRequest";
/// Version of LTI.
pub(super) const VERSION: &str = "1.3.0";
/// Maximum length of an id, in characters (LTI 1.3, sections 5.3.3 and 5.3.5).
const LONGEST_ID: usize = 255;
/// Maximum length of a title, in characters.
const LONGEST_TITLE: usize = 200;
/// Maximum length of an address, in bytes.
pub(super) const LONGEST_URL: usize = 2000;

/// Maximum length of a hint, in bytes: some are tokens.
const LONGEST_HINT: usize = 4000;

/// Claim of a launch that contains the registration number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "snake_case"))]
pub enum NumberClaim {
    /// `lis.person_sourcedid`, which the platform sets.
    #[cfg_attr(feature = "sqlx", sqlx(rename = "person_sourcedid"))]
    PersonSourcedId,
    /// The custom parameter `student_number`. Some platforms let teachers set custom parameters.
    StudentNumber,
}

impl NumberClaim {
    /// Every claim.
    pub const ALL: [Self; 2] = [Self::PersonSourcedId, Self::StudentNumber];

    /// Returns the word used in the database and in forms.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::PersonSourcedId => "person_sourcedid",
            Self::StudentNumber => "student_number",
        }
    }

    /// Returns the claim of a word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|claim| claim.word() == word)
    }

    fn read(self, claims: &Claims) -> Option<String> {
        let number = match self {
            Self::PersonSourcedId => object(claims, "lis").text("person_sourcedid"),
            Self::StudentNumber => object(claims, "custom").text("student_number"),
        };
        number.filter(|number| Self::is_number(number))
    }

    /// Returns whether a text is a number. A platform that does not know a variable sends its name.
    pub(super) fn is_number(text: &str) -> bool {
        !text.starts_with('$') && text.len() <= 100 && single_line_text::refusal("", text).is_none()
    }
}

/// Registration of this service at a learning platform.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlatformSettings {
    /// Name shown to users.
    pub name: String,
    /// Issuer identifier, compared to the byte.
    pub issuer: String,
    /// Id of this service at the platform.
    pub client_id: String,
    /// Address that confirms a launch.
    pub auth_url: String,
    /// Address that issues access tokens.
    pub token_url: String,
    /// Address of the platform's keys.
    pub keys_url: String,
    /// Audience of requests for access tokens; `None` for the address itself.
    pub token_audience: Option<String>,
    /// Claim that contains the registration number.
    pub number_claim: Option<NumberClaim>,
    /// Unknown people get a new account as trainees.
    pub creates_trainees: bool,
}

impl PlatformSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Returns the reason in the current language, with the field.
    pub fn check(&self) -> Result<(), String> {
        for (field, value) in [(tr!("name"), &self.name), (tr!("client id"), &self.client_id)]
            .into_iter()
            .chain([(tr!("issuer"), &self.issuer)])
            .chain(self.addresses())
        {
            check_setting(field, value)?;
            if value.is_empty() {
                return Err(tr!("{field}: empty; it is required", field = field));
            }
        }
        check_setting(tr!("audience of tokens"), self.token_audience.as_deref().unwrap_or_default())?;
        if self.issuer.contains(char::is_whitespace) {
            return Err(tr!("issuer: “{issuer}”; no spaces are allowed", issuer = self.issuer));
        }
        Ok(())
    }

    /// Returns the name and the value of each address.
    #[must_use]
    pub fn addresses(&self) -> [(&'static str, &String); 3] {
        [
            (tr!("authentication request URL"), &self.auth_url),
            (tr!("access token URL"), &self.token_url),
            (tr!("key set URL"), &self.keys_url),
        ]
    }

    /// Returns the origin of the platform's pages, which may show this service in a frame.
    #[must_use]
    pub fn frame_origin(&self) -> Option<String> {
        web_origin(&self.auth_url)
    }

    /// Returns the issuer of the identities of this registration. Other registrations of the same
    /// issuer, such as other schools on one Canvas, have other identities.
    #[must_use]
    pub fn identity_issuer(&self) -> String {
        // An issuer contains no space.
        format!("{} {}", self.issuer, self.client_id)
    }
}

/// A login that a learning platform initiates; the names are those of the protocol.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct LoginInitiation {
    /// Issuer identifier.
    pub iss: String,
    /// Id of this service at the platform; empty if the platform does not send it.
    pub client_id: String,
    /// The user, for the platform.
    pub login_hint: String,
    /// Identifies the message to the platform; empty if the platform sent none.
    pub lti_message_hint: String,
    /// Address of this service to open.
    pub target_link_uri: String,
}

impl LoginInitiation {
    /// Returns whether the required parameters are present, and none is too long to keep.
    #[must_use]
    pub fn is_acceptable(&self) -> bool {
        let hints = [&self.login_hint, &self.lti_message_hint];
        !self.login_hint.is_empty()
            && hints.iter().all(|hint| hint.len() <= LONGEST_HINT)
            && self.target_link_uri.len() <= LONGEST_URL
    }
}

/// The course of a launch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LaunchContext {
    /// Id at the platform.
    pub id: String,
    /// Title.
    pub title: Option<String>,
    /// Address of its members.
    pub members_url: Option<String>,
    /// Address of its line items.
    pub lineitems_url: Option<String>,
}

/// A verified launch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Whom the platform has confirmed.
    pub identity: ProvenIdentity,
    /// Deployment at the platform.
    pub deployment: String,
    /// The course.
    pub context: Option<LaunchContext>,
    /// Id of the link at the platform.
    pub link: String,
    /// Address of the link's line item.
    pub lineitem_url: Option<String>,
    /// Path of this service to open.
    pub page: String,
}

impl Launch {
    /// Reads the claims of a verified ID token. `address` is the public address of this service.
    ///
    /// # Errors
    /// Returns the reason of a refusal.
    pub fn read(settings: &PlatformSettings, claims: &Claims, address: &str) -> Result<Self, SignInRefusal> {
        let message = MessageClaims::read(settings, claims, RESOURCE_LINK, address)?;
        let link = object(claims, "resource_link").text("id").and_then(valid_id).ok_or(SignInRefusal::Malformed)?;
        let chosen = object(claims, "custom").text("stylet");
        let chosen = chosen.and_then(|chosen| own_target(&chosen, address)).filter(|page| page != "/");
        Ok(Self {
            identity: message.identity,
            deployment: message.deployment,
            context: message.context,
            link,
            lineitem_url: Claims(members_of(claims, GRADES)).text("lineitem").filter(|url| is_web_address(url)),
            page: chosen.unwrap_or(message.target),
        })
    }
}

/// The claims that every message of LTI 1.3 has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct MessageClaims {
    /// Whom the platform has confirmed.
    pub(super) identity: ProvenIdentity,
    /// Deployment at the platform.
    pub(super) deployment: String,
    /// The course.
    pub(super) context: Option<LaunchContext>,
    /// Path of this service that the message names.
    target: String,
}

impl MessageClaims {
    /// Reads the claims of a message of a type.
    pub(super) fn read(
        settings: &PlatformSettings,
        claims: &Claims,
        message_type: &str,
        address: &str,
    ) -> Result<Self, SignInRefusal> {
        let named = |name: &str| claims.text(&format!("{LTI}{name}"));
        if !is_message(claims, message_type) || named("version").as_deref() != Some(VERSION) {
            return Err(SignInRefusal::Message);
        }
        let target = named("target_link_uri").ok_or(SignInRefusal::Malformed)?;
        let target = own_target(&target, address).ok_or(SignInRefusal::Target)?;
        let deployment = named("deployment_id").and_then(valid_id).ok_or(SignInRefusal::Malformed)?;
        let subject = claims.exact("sub").and_then(valid_id).ok_or(SignInRefusal::Anonymous)?;
        let identity = read_identity(settings, claims, subject);
        Ok(Self { identity, deployment, context: read_context(claims), target })
    }
}

/// Returns whether a message has a type.
pub(super) fn is_message(claims: &Claims, message_type: &str) -> bool {
    claims.text(&format!("{LTI}message_type")).as_deref() == Some(message_type)
}

/// Returns the page that an address of this service names, if it is on this host: an exercise, an
/// assignment, the courses, or the home page for every other path.
#[must_use]
pub fn own_target(target: &str, address: &str) -> Option<String> {
    let own = Url::parse(address).ok()?;
    let url = own.join(target).ok()?;
    if url.origin() != own.origin() || !url.username().is_empty() || url.password().is_some() {
        return None;
    }
    let path = url.path();
    let is_id = |id: &str| !id.is_empty() && id.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b));
    let is_named = ["/exercises/", "/assignments/"].iter().any(|start| path.strip_prefix(start).is_some_and(is_id));
    Some(if is_named || path == "/curricula" { path.to_owned() } else { "/".to_owned() })
}

/// Returns a claim that is an object, or an empty one.
pub(super) fn members_of(claims: &Claims, name: &str) -> Map<String, Value> {
    claims.0.get(name).and_then(Value::as_object).cloned().unwrap_or_default()
}

/// Returns a claim of LTI that is an object, or an empty one.
fn object(claims: &Claims, name: &str) -> Claims {
    Claims(members_of(claims, &format!("{LTI}{name}")))
}

/// Returns the origin of an address of the web.
#[must_use]
pub fn web_origin(address: &str) -> Option<String> {
    let origin = Url::parse(address).ok()?.origin();
    Some(origin).filter(Origin::is_tuple).map(|origin| origin.ascii_serialization())
}

/// Returns an id that is short enough and on one line.
pub(super) fn valid_id(id: String) -> Option<String> {
    let is_valid = id.chars().count() <= LONGEST_ID && single_line_text::refusal("", &id).is_none();
    is_valid.then_some(id)
}

/// Returns whether a text is an address of the web that is not too long to keep.
pub(super) fn is_web_address(address: &str) -> bool {
    address.len() <= LONGEST_URL && Url::parse(address).is_ok_and(|url| matches!(url.scheme(), "https" | "http"))
}

fn read_context(claims: &Claims) -> Option<LaunchContext> {
    let (context, grades) = (object(claims, "context"), Claims(members_of(claims, GRADES)));
    let title = context.text("title").or_else(|| context.text("label"));
    Some(LaunchContext {
        id: context.text("id").and_then(valid_id)?,
        title: title.map(|title| single_line_text::on_one_line(&title).chars().take(LONGEST_TITLE).collect()),
        members_url: Claims(members_of(claims, MEMBERS))
            .text("context_memberships_url")
            .filter(|url| is_web_address(url)),
        lineitems_url: grades.text("lineitems").filter(|url| is_web_address(url)),
    })
}

fn read_identity(settings: &PlatformSettings, claims: &Claims, subject: String) -> ProvenIdentity {
    ProvenIdentity {
        issuer: settings.identity_issuer(),
        number: settings.number_claim.and_then(|claim| claim.read(claims)),
        // A platform's addresses may be its users' own input.
        email_verified: false,
        ..ProvenIdentity::describe(claims, subject)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    const ADDRESS: &str = "https://training.example.org";

    fn settings() -> PlatformSettings {
        PlatformSettings {
            name: "Moodle".to_owned(),
            issuer: "https://lms.example.edu".to_owned(),
            client_id: "a1".to_owned(),
            auth_url: "https://lms.example.edu/auth".to_owned(),
            token_url: "https://lms.example.edu/token".to_owned(),
            keys_url: "https://lms.example.edu/keys".to_owned(),
            number_claim: Some(NumberClaim::PersonSourcedId),
            ..PlatformSettings::default()
        }
    }

    fn launch(changes: &[(&str, Value)]) -> Claims {
        let mut claims = json!({
            "sub": "7", "name": "Ada", "email": "ada@example.edu", "email_verified": true,
            "https://purl.imsglobal.org/spec/lti/claim/message_type": "LtiResourceLinkRequest",
            "https://purl.imsglobal.org/spec/lti/claim/version": "1.3.0",
            "https://purl.imsglobal.org/spec/lti/claim/deployment_id": "1",
            "https://purl.imsglobal.org/spec/lti/claim/target_link_uri": "https://training.example.org/lti/launch",
            "https://purl.imsglobal.org/spec/lti/claim/resource_link": { "id": "12" },
            "https://purl.imsglobal.org/spec/lti/claim/context": { "id": "5", "label": "N1" },
            "https://purl.imsglobal.org/spec/lti/claim/lis": { "person_sourcedid": "4711" },
        });
        for (name, value) in changes {
            let name = if name.contains('/') || *name == "sub" { (*name).to_owned() } else { format!("{LTI}{name}") };
            claims[name] = value.clone();
        }
        Claims(claims.as_object().cloned().unwrap())
    }

    fn read(changes: &[(&str, Value)]) -> Result<Launch, SignInRefusal> {
        Launch::read(&settings(), &launch(changes), ADDRESS)
    }

    #[test]
    fn settings_are_checked_with_the_field() {
        assert_eq!(settings().check(), Ok(()));
        let bad = [
            PlatformSettings { name: String::new(), ..settings() },
            PlatformSettings { issuer: "https://lms.example.edu x".to_owned(), ..settings() },
            PlatformSettings { client_id: "a\nb".to_owned(), ..settings() },
            PlatformSettings { auth_url: String::new(), ..settings() },
            PlatformSettings { keys_url: "x".repeat(501), ..settings() },
        ];
        for (settings, field) in bad.iter().zip(["name", "issuer", "client id", "authentication", "key set"]) {
            assert!(settings.check().unwrap_err().contains(field), "{settings:?}");
        }
    }

    #[test]
    fn a_launch_describes_person_course_and_link() {
        let launch = read(&[
            (GRADES, json!({ "lineitems": "https://lms.example.edu/items", "lineitem": "javascript:alert(1)" })),
            (MEMBERS, json!({ "context_memberships_url": "https://lms.example.edu/members" })),
        ])
        .unwrap();
        let identity = &launch.identity;
        assert_eq!((identity.subject.as_str(), identity.number.as_deref()), ("7", Some("4711")));
        assert_eq!(identity.issuer, "https://lms.example.edu a1");
        assert!(!identity.email_verified && !identity.has_second_factor);
        let context = launch.context.unwrap();
        assert_eq!((context.id.as_str(), context.title.as_deref()), ("5", Some("N1")));
        assert_eq!(context.members_url.as_deref(), Some("https://lms.example.edu/members"));
        assert_eq!(context.lineitems_url.as_deref(), Some("https://lms.example.edu/items"));
        assert_eq!((launch.link.as_str(), launch.lineitem_url, launch.page.as_str()), ("12", None, "/"));
    }

    #[test]
    fn other_messages_and_places_are_refused() {
        for (change, reason) in [
            (("message_type", json!("LtiDeepLinkingRequest")), SignInRefusal::Message),
            (("version", json!("1.1.0")), SignInRefusal::Message),
            (("target_link_uri", json!("https://evil.example/lti/launch")), SignInRefusal::Target),
            (("target_link_uri", json!("https://training.example.org.evil.example/")), SignInRefusal::Target),
            (("target_link_uri", json!("http://training.example.org/")), SignInRefusal::Target),
            (("target_link_uri", json!("//evil.example/")), SignInRefusal::Target),
            (("target_link_uri", Value::Null), SignInRefusal::Malformed),
            (("deployment_id", Value::Null), SignInRefusal::Malformed),
            (("deployment_id", json!("x".repeat(256))), SignInRefusal::Malformed),
            (("resource_link", json!({})), SignInRefusal::Malformed),
            (("sub", Value::Null), SignInRefusal::Anonymous),
        ] {
            assert_eq!(read(std::slice::from_ref(&change)), Err(reason), "{change:?}");
        }
    }

    #[test]
    fn the_page_is_an_exercise_the_courses_or_home() {
        let exercise = "/exercises/feel-the-layers";
        let whole = format!("{ADDRESS}{exercise}?lms=1#x");
        for (custom, page) in [
            (json!(exercise), exercise),
            (json!(whole), exercise),
            (json!("/curricula"), "/curricula"),
            (json!("/assignments/0190b5d8-7c4b-7000"), "/assignments/0190b5d8-7c4b-7000"),
            (json!("/assignments"), "/"),
            (json!("/logout"), "/"),
            (json!("/exercises/feel-the-layers/draft"), "/"),
            (json!("/exercises/../logout"), "/"),
            (json!("/exercises/a%2Fb"), "/"),
            (json!("https://evil.example/exercises/1"), "/"),
            (json!("$Custom.stylet"), "/"),
            (json!(7), "/"),
        ] {
            let opened = read(&[("custom", json!({ "stylet": custom }))]).unwrap().page;
            assert_eq!(opened, page, "{custom}");
        }
        let linked = read(&[("target_link_uri", json!(whole))]).unwrap().page;
        assert_eq!(linked, exercise);
    }

    #[test]
    fn an_unknown_variable_is_no_number() {
        let number = |value| read(&[("lis", json!({ "person_sourcedid": value }))]).unwrap().identity.number;
        assert_eq!(number(json!("$Person.sourcedId")), None);
        assert_eq!(number(json!(" 4712 ")).as_deref(), Some("4712"));
        let custom = [("custom", json!({ "student_number": "9" }))];
        assert_eq!(read(&custom).unwrap().identity.number.as_deref(), Some("4711"), "not the configured claim");
        let settings = PlatformSettings { number_claim: Some(NumberClaim::StudentNumber), ..settings() };
        let other = Launch::read(&settings, &launch(&custom), ADDRESS).unwrap();
        assert_eq!(other.identity.number.as_deref(), Some("9"));
    }
}
