//! Deep linking (LTI Deep Linking 2.0): a teacher chooses content of this service for a course of a
//! learning platform.

use serde_json::{Map, Value, json};

use super::federation::{Claims, ProvenIdentity};
use super::lti::{
    LTI, LaunchContext, MessageClaims, PlatformSettings, VERSION, is_message, is_web_address, members_of, web_origin,
};
use super::sign_in_refusal::SignInRefusal;

/// Message type of the request.
const REQUEST: &str = "LtiDeepLinkingRequest";
/// Message type of the response.
const RESPONSE: &str = "LtiDeepLinkingResponse";
/// Prefix of the claims of deep linking.
const DEEP_LINKING: &str = "https://purl.imsglobal.org/spec/lti-dl/claim/";
/// Type of the content that this service offers.
const LINK: &str = "ltiResourceLink";
/// Maximum length of the platform's data, in bytes: some are tokens.
const LONGEST_DATA: usize = 8000;
/// Lifetime of a response, in s: time to press its button.
const RESPONSE_LIFETIME_S: i64 = 10 * 60;
/// Points of a line item.
const MOST_POINTS: u32 = 100;

/// What the platform accepts, and where it takes the response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContentRequest {
    /// Address to which the browser posts the response.
    pub return_url: String,
    /// Data of the platform, returned unchanged.
    pub data: Option<String>,
    /// Whether several links are accepted.
    pub accepts_several: bool,
    /// Whether line items are accepted.
    pub accepts_line_items: bool,
}

impl ContentRequest {
    /// Returns the origin to which the browser posts the response.
    #[must_use]
    pub fn return_origin(&self) -> Option<String> {
        web_origin(&self.return_url)
    }
}

/// A verified request for content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeepLinkingRequest {
    /// Whom the platform has confirmed.
    pub identity: ProvenIdentity,
    /// Deployment at the platform.
    pub deployment: String,
    /// The course.
    pub context: Option<LaunchContext>,
    /// What the platform accepts.
    pub content: ContentRequest,
}

impl DeepLinkingRequest {
    /// Returns whether a message is a request for content.
    #[must_use]
    pub fn is_request(claims: &Claims) -> bool {
        is_message(claims, REQUEST)
    }

    /// Reads the claims of a verified ID token. `address` is the public address of this service.
    ///
    /// # Errors
    /// Returns the reason of a refusal.
    pub fn read(settings: &PlatformSettings, claims: &Claims, address: &str) -> Result<Self, SignInRefusal> {
        let message = MessageClaims::read(settings, claims, REQUEST, address)?;
        let asked = Claims(members_of(claims, &format!("{DEEP_LINKING}deep_linking_settings")));
        if !asked.list("accept_types").iter().any(|accepted| accepted == LINK) {
            return Err(SignInRefusal::Content);
        }
        let return_url = asked.exact("deep_link_return_url").filter(|url| is_web_address(url));
        let data = asked.exact("data");
        if data.as_ref().is_some_and(|data| data.len() > LONGEST_DATA) {
            return Err(SignInRefusal::Malformed);
        }
        Ok(Self {
            identity: message.identity,
            deployment: message.deployment,
            context: message.context,
            content: ContentRequest {
                return_url: return_url.ok_or(SignInRefusal::Malformed)?,
                data,
                accepts_several: asked.is_true("accept_multiple"),
                // Platforms that ignore line items may leave the setting out.
                accepts_line_items: asked.0.get("accept_lineitem").is_none() || asked.is_true("accept_lineitem"),
            },
        })
    }
}

/// Content of this service that can be linked to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkableContent {
    /// Kind.
    pub kind: ContentKind,
    /// Id among its kind.
    pub id: String,
    /// Title.
    pub title: String,
    /// Cohort of an assignment.
    pub cohort: Option<String>,
}

/// Kind of content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ContentKind {
    /// An assignment of a cohort.
    Assignment,
    /// A course.
    Course,
    /// An exercise.
    Exercise,
}

impl ContentKind {
    /// Every kind, as listed.
    pub const ALL: [Self; 3] = [Self::Assignment, Self::Course, Self::Exercise];

    /// Returns the word used in forms and resource ids.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Assignment => "assignment",
            Self::Course => "course",
            Self::Exercise => "exercise",
        }
    }
}

impl LinkableContent {
    /// Returns the id by which the platform finds the line item of the content again.
    #[must_use]
    pub fn resource_id(&self) -> String {
        format!("{}:{}", self.kind.word(), self.id)
    }

    /// Returns the path that a link to the content opens.
    #[must_use]
    pub fn page(&self) -> String {
        match self.kind {
            ContentKind::Assignment => format!("/assignments/{}", self.id),
            ContentKind::Course => "/curricula".to_owned(),
            ContentKind::Exercise => format!("/exercises/{}", self.id),
        }
    }

    fn item(&self, launch_url: &str, has_line_item: bool) -> Value {
        let mut item = json!({
            "type": LINK, "url": launch_url, "title": self.title, "custom": { "stylet": self.page() },
        });
        // A course has no grade: its column would stay empty.
        if has_line_item && self.kind != ContentKind::Course {
            item["lineItem"] =
                json!({ "label": self.title, "scoreMaximum": MOST_POINTS, "resourceId": self.resource_id() });
        }
        item
    }
}

/// A response to be signed.
#[derive(Clone, Copy, Debug)]
pub struct DeepLinkingResponse<'a> {
    /// Settings of the platform.
    pub settings: &'a PlatformSettings,
    /// Deployment at the platform.
    pub deployment: &'a str,
    /// What the platform accepts.
    pub content: &'a ContentRequest,
    /// The chosen content.
    pub chosen: &'a [LinkableContent],
    /// Address to which platforms post launches.
    pub launch_url: &'a str,
}

impl DeepLinkingResponse<'_> {
    /// Returns the claims of the response (LTI Deep Linking 2.0, section 4.5).
    #[must_use]
    pub fn claims(&self, nonce: &str, now_s: i64) -> Value {
        let items = self.chosen.iter().map(|chosen| chosen.item(self.launch_url, self.content.accepts_line_items));
        let mut claims = Map::from_iter([
            ("iss".to_owned(), json!(self.settings.client_id)),
            ("aud".to_owned(), json!(self.settings.issuer)),
            ("nonce".to_owned(), json!(nonce)),
            ("iat".to_owned(), json!(now_s)),
            ("exp".to_owned(), json!(now_s + RESPONSE_LIFETIME_S)),
            (format!("{LTI}message_type"), json!(RESPONSE)),
            (format!("{LTI}version"), json!(VERSION)),
            (format!("{LTI}deployment_id"), json!(self.deployment)),
            (format!("{DEEP_LINKING}content_items"), items.collect()),
        ]);
        if let Some(data) = &self.content.data {
            claims.insert(format!("{DEEP_LINKING}data"), json!(data));
        }
        Value::Object(claims)
    }
}

#[cfg(test)]
mod tests {
    use super::super::lti::LONGEST_URL;
    use super::*;

    const ADDRESS: &str = "https://training.example.org";

    fn settings() -> PlatformSettings {
        PlatformSettings {
            issuer: "https://lms.example.edu".to_owned(),
            client_id: "a1".to_owned(),
            ..PlatformSettings::default()
        }
    }

    fn read(changes: &[(&str, Value)]) -> Result<DeepLinkingRequest, SignInRefusal> {
        let mut asked = json!({
            "deep_link_return_url": "https://lms.example.edu/return?id=7",
            "accept_types": ["link", "ltiResourceLink"],
            "data": " op=1 ",
        });
        for (name, value) in changes {
            asked[*name] = value.clone();
        }
        let claims = json!({
            "sub": "7",
            format!("{LTI}message_type"): REQUEST,
            format!("{LTI}version"): VERSION,
            format!("{LTI}deployment_id"): "1",
            format!("{LTI}target_link_uri"): format!("{ADDRESS}/lti/launch"),
            format!("{DEEP_LINKING}deep_linking_settings"): asked,
        });
        DeepLinkingRequest::read(&settings(), &Claims(claims.as_object().cloned().unwrap()), ADDRESS)
    }

    #[test]
    fn a_request_says_what_the_platform_accepts() {
        let content = read(&[]).unwrap().content;
        assert_eq!(content.return_url, "https://lms.example.edu/return?id=7");
        assert_eq!(content.data.as_deref(), Some(" op=1 "), "unchanged");
        assert!(!content.accepts_several && content.accepts_line_items);
        let content = read(&[("accept_lineitem", json!(false)), ("accept_multiple", json!(true))]).unwrap().content;
        assert!(content.accepts_several && !content.accepts_line_items);
    }

    #[test]
    fn a_request_that_cannot_be_answered_is_refused() {
        for (change, reason) in [
            (("accept_types", json!(["link", "html"])), SignInRefusal::Content),
            (("accept_types", Value::Null), SignInRefusal::Content),
            (("deep_link_return_url", Value::Null), SignInRefusal::Malformed),
            (("deep_link_return_url", json!("javascript:alert(1)")), SignInRefusal::Malformed),
            (
                ("deep_link_return_url", json!(format!("https://a/{}", "x".repeat(LONGEST_URL)))),
                SignInRefusal::Malformed,
            ),
            (("data", json!("x".repeat(LONGEST_DATA + 1))), SignInRefusal::Malformed),
        ] {
            assert_eq!(read(std::slice::from_ref(&change)).map(drop), Err(reason), "{}", change.0);
        }
    }

    #[test]
    fn a_response_names_page_and_line_item() {
        let content = read(&[]).unwrap().content;
        let chosen = |kind| LinkableContent { kind, id: "x".to_owned(), title: "T".to_owned(), cohort: None };
        let response = DeepLinkingResponse {
            settings: &settings(),
            deployment: "1",
            content: &content,
            chosen: &ContentKind::ALL.map(chosen),
            launch_url: "https://training.example.org/lti/launch",
        };
        let claims = response.claims("n", 1000);
        let items = &claims[format!("{DEEP_LINKING}content_items")];
        for (item, (page, resource)) in items.as_array().unwrap().iter().zip([
            ("/assignments/x", "assignment:x"),
            ("/curricula", "course:x"),
            ("/exercises/x", "exercise:x"),
        ]) {
            assert_eq!((&item["custom"]["stylet"], &item["type"]), (&json!(page), &json!(LINK)));
            let line_item = json!({ "label": "T", "scoreMaximum": 100, "resourceId": resource });
            assert_eq!(item.get("lineItem"), Some(&line_item).filter(|_| page != "/curricula"));
        }
        assert_eq!((&claims["iss"], &claims["aud"]), (&json!("a1"), &json!("https://lms.example.edu")));
        assert_eq!(claims[format!("{DEEP_LINKING}data")], json!(" op=1 "));
        let without = ContentRequest { accepts_line_items: false, data: None, ..content.clone() };
        let claims = DeepLinkingResponse { content: &without, ..response }.claims("n", 1000);
        assert!(!claims.to_string().contains("lineItem") && !claims.to_string().contains("lti-dl/claim/data"));
    }
}
