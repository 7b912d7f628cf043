//! Pages of launches from learning platforms.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::lti::{LoginInitiation, NumberClaim, PlatformSettings};
use serde::Deserialize;
use time::OffsetDateTime;

use crate::form::{FilledForm, SelectOption, read_ticked_box, read_trimmed_text};
use crate::{Shell, StatusWord, assets, format};

/// The page that opens the service in a window of its own, shown in the frame of a learning
/// platform.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/open.html")]
pub struct OpenWindowPage {
    /// Name of the platform.
    pub platform: String,
    /// Parameters with which the launch begins.
    pub asked: LoginInitiation,
}

/// Addresses of this service, to enter at a learning platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlatformEntries {
    /// Address at which the platform initiates a login.
    pub login_url: String,
    /// Address to which the platform posts launches.
    pub launch_url: String,
    /// Address of the public keys.
    pub keys_uri: String,
    /// Address of the dynamic registration.
    pub register_url: String,
}

/// The page of a school's learning platforms.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/platforms.html")]
pub struct PlatformsPage {
    /// Page frame.
    pub shell: Shell,
    /// The platforms.
    pub rows: Vec<PlatformRow>,
    /// The form for a new one.
    pub form: FilledForm<PlatformForm>,
    /// Values to enter at the platform.
    pub entries: PlatformEntries,
}

/// A learning platform in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlatformRow {
    /// Name.
    pub name: String,
    /// Issuer identifier.
    pub issuer: String,
    /// Id of this service there.
    pub client_id: String,
    /// Address of its page.
    pub href: String,
    /// Number of deployments that wait to be admitted.
    pub waiting: usize,
    /// Whether it is disabled.
    pub disabled: bool,
}

impl PlatformRow {
    fn said_waiting(&self) -> String {
        trn!(
            "{count} deployment waits to be admitted",
            "{count} deployments wait to be admitted",
            self.waiting,
            count = self.waiting
        )
    }
}

/// The page of a learning platform.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/platform.html")]
pub struct PlatformPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the platform.
    pub title: String,
    /// Address of this page.
    pub href: String,
    /// The form.
    pub form: FilledForm<PlatformForm>,
    /// Deployments, in the order of their first launches.
    pub deployments: Vec<DeploymentRow>,
    /// Courses, the last launched first.
    pub courses: Vec<CourseRow>,
    /// Why the members of a course were not read.
    pub course_refused: Option<String>,
    /// Values to enter at the platform.
    pub entries: PlatformEntries,
}

/// A deployment of a learning platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeploymentRow {
    /// Id at the platform.
    pub deployment: String,
    /// Time of its first launch.
    pub seen: OffsetDateTime,
    /// When it was admitted.
    pub admitted: Option<OffsetDateTime>,
}

/// A course of a learning platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CourseRow {
    /// Title, or id at the platform.
    pub title: String,
    /// Address of the course here.
    pub href: String,
    /// Time of the last launch.
    pub seen: OffsetDateTime,
    /// The cohorts of the school.
    pub cohorts: Vec<SelectOption>,
    /// Whether the platform shares the members.
    pub has_members: bool,
    /// When the members were last compared with the cohort.
    pub checked: Option<OffsetDateTime>,
    /// Number of differences then; `None` if the members could not be read.
    pub differences: Option<i64>,
}

/// Input of the form of a course.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub struct CourseForm {
    /// Id of the cohort; empty for none.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub cohort: String,
    /// Trainees who have left the course are proposed to leave the cohort.
    #[serde(deserialize_with = "read_ticked_box")]
    pub remove_missing: bool,
    /// The members are read.
    #[serde(deserialize_with = "read_ticked_box")]
    pub read: bool,
}

/// Input of the form of a learning platform.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct PlatformForm {
    /// Name shown to users.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub name: String,
    /// Issuer identifier.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub issuer: String,
    /// Id of this service there.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub client_id: String,
    /// Address that confirms a launch.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub auth_url: String,
    /// Address that issues access tokens.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub token_url: String,
    /// Address of the keys.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub keys_url: String,
    /// Audience of requests for access tokens; empty for the address itself.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub token_audience: String,
    /// Claim with the registration number; empty if none.
    #[serde(default)]
    pub number_claim: String,
    /// Unknown people get an account as trainees.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub creates_trainees: bool,
}

impl Default for PlatformForm {
    fn default() -> Self {
        let number_claim = Some(NumberClaim::PersonSourcedId);
        Self::from(&PlatformSettings { number_claim, ..PlatformSettings::default() })
    }
}

impl From<&PlatformSettings> for PlatformForm {
    fn from(settings: &PlatformSettings) -> Self {
        Self {
            name: settings.name.clone(),
            issuer: settings.issuer.clone(),
            client_id: settings.client_id.clone(),
            auth_url: settings.auth_url.clone(),
            token_url: settings.token_url.clone(),
            keys_url: settings.keys_url.clone(),
            token_audience: settings.token_audience.clone().unwrap_or_default(),
            number_claim: settings.number_claim.map_or("", NumberClaim::word).to_owned(),
            creates_trainees: settings.creates_trainees,
        }
    }
}

impl PlatformForm {
    /// Returns the settings.
    ///
    /// # Errors
    /// Returns the reason if a choice is not allowed.
    pub fn read(&self) -> Result<PlatformSettings, String> {
        let number_claim = match self.number_claim.as_str() {
            "" => None,
            word => Some(NumberClaim::of_word(word).ok_or_else(|| {
                let allowed = NumberClaim::ALL.map(NumberClaim::word).join(", ");
                tr!("registration number: “{choice}”; allowed: empty, {allowed}", choice = word, allowed = allowed)
            })?),
        };
        Ok(PlatformSettings {
            name: self.name.clone(),
            issuer: self.issuer.clone(),
            client_id: self.client_id.clone(),
            auth_url: self.auth_url.clone(),
            token_url: self.token_url.clone(),
            keys_url: self.keys_url.clone(),
            token_audience: Some(self.token_audience.clone()).filter(|audience| !audience.is_empty()),
            number_claim,
            creates_trainees: self.creates_trainees,
        })
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    const ADDRESS: &str = "https://training.example.edu";

    fn entries() -> PlatformEntries {
        PlatformEntries {
            login_url: format!("{ADDRESS}/lti/login"),
            launch_url: format!("{ADDRESS}/lti/launch"),
            keys_uri: format!("{ADDRESS}/.well-known/jwks.json"),
            register_url: format!("{ADDRESS}/lti/register"),
        }
    }

    fn typed() -> PlatformForm {
        PlatformForm {
            name: "Moodle".to_owned(),
            issuer: "https://lms.example.edu".to_owned(),
            client_id: "<b>a1".to_owned(),
            creates_trainees: true,
            ..PlatformForm::default()
        }
    }

    #[test]
    fn the_window_page_repeats_the_parameters() {
        let asked = LoginInitiation {
            iss: "https://lms.example.edu".to_owned(),
            login_hint: "\"><script>7".to_owned(),
            target_link_uri: format!("{ADDRESS}/lti/launch"),
            ..LoginInitiation::default()
        };
        let page = OpenWindowPage { platform: "Moodle <b>".to_owned(), asked };
        let html = samples::keep_page("lti-open", &page);
        assert!(html.contains("value=\"&#34;&#62;&#60;script&#62;7\"") && !html.contains("<script>7"), "{html}");
        assert!(html.contains("target=\"_blank\"") && html.contains("Moodle &#60;b&#62;"), "{html}");
        assert!(!html.contains("client_id"), "a parameter that was not sent");
    }

    #[test]
    fn a_form_keeps_what_was_typed() {
        let typed = typed();
        assert_eq!(PlatformForm::from(&typed.read().unwrap()), typed);
        assert!(PlatformForm { number_claim: "email".to_owned(), ..typed.clone() }.read().is_err());
        let row = |disabled| PlatformRow {
            name: "Moodle".to_owned(),
            issuer: "https://lms.example.edu".to_owned(),
            client_id: "a1".to_owned(),
            href: "/admin/platforms/1".to_owned(),
            waiting: 2,
            disabled,
        };
        let page = PlatformsPage {
            shell: samples::shell(Role::Administrator),
            rows: vec![row(false), row(true)],
            form: FilledForm::refused(typed, "no".to_owned()),
            entries: entries(),
        };
        let html = samples::keep_page("platforms", &page);
        assert!(html.contains("&#60;b&#62;a1") && html.contains("/admin/platforms/1/enable"), "{html}");
        assert!(html.contains("2 deployments wait") && html.contains("/.well-known/jwks.json"), "{html}");
    }

    #[test]
    fn deployments_that_wait_have_a_button() {
        let row = |deployment: &str, admitted| DeploymentRow {
            deployment: deployment.to_owned(),
            seen: samples::NOW,
            admitted,
        };
        let course = |has_members| CourseRow {
            title: "<b>Nursing".to_owned(),
            href: "/admin/platforms/1/courses/2".to_owned(),
            seen: samples::NOW,
            cohorts: vec![SelectOption { value: "3".to_owned(), label: "Spring".to_owned(), chosen: true }],
            has_members,
            checked: Some(samples::NOW),
            differences: has_members.then_some(3),
        };
        let page = |deployments| PlatformPage {
            shell: samples::shell(Role::Administrator),
            title: "Moodle".to_owned(),
            href: "/admin/platforms/1".to_owned(),
            form: FilledForm::new(typed()),
            deployments,
            courses: vec![course(true), course(false)],
            course_refused: Some("no".to_owned()),
            entries: entries(),
        };
        let html = samples::keep_page("platform", &page(vec![row("1\"", None), row("2", Some(samples::NOW))]));
        assert_eq!(html.matches("/admin/platforms/1/admit").count(), 1, "{html}");
        assert!(html.contains("value=\"1&#34;\""), "{html}");
        assert!(html.contains("&#60;b&#62;Nursing") && html.contains("value=\"3\" selected"), "{html}");
        assert!(html.contains("3 differences from") && html.contains("could not be read"), "{html}");
        assert_eq!(html.matches("name=\"read\"").count(), 1, "the platform shares the members of one course");
        assert!(!samples::keep_page("platform-new", &page(vec![])).contains("/admit"));
    }
}
