//! Pages of the dynamic registration at a learning platform.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::lti::PlatformSettings;
use model::auth::platform_registration::RegistrationInitiation;

use crate::{Shell, assets, format};

/// The page that opens the registration in a window of its own, shown in the frame of a learning
/// platform.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/open_registration.html")]
pub struct OpenRegistrationPage {
    /// Parameters with which the registration begins.
    pub asked: RegistrationInitiation,
}

/// The page that asks an administrator to sign in.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/sign_in_to_register.html")]
pub struct SignInToRegisterPage {}

/// What a registration will store.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AskedRegistration {
    /// Settings, without the client id.
    pub settings: PlatformSettings,
    /// Address that registers a tool.
    pub registration_url: String,
    /// Hash of the configuration.
    pub digest: String,
}

/// The page on which an administrator registers a learning platform that asks for it.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/register.html")]
pub struct RegisterPlatformPage {
    /// Page frame.
    pub shell: Shell,
    /// Parameters of the registration.
    pub asked: RegistrationInitiation,
    /// What will be stored; `None` if the platform cannot be registered.
    pub platform: Option<AskedRegistration>,
    /// Why it cannot be registered, or was not.
    pub refused: Option<String>,
}

/// The page after a registration.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/lti/registered.html")]
pub struct RegisteredPlatformPage {
    /// Address of the registration's page.
    pub href: String,
}

impl RegisteredPlatformPage {
    fn script(&self) -> String {
        assets::asset_address("registered.js")
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    fn asked() -> RegistrationInitiation {
        RegistrationInitiation {
            openid_configuration: "https://lms.example.edu/openid?a=1&b=\"".to_owned(),
            registration_token: "t1".to_owned(),
        }
    }

    #[test]
    fn the_page_shows_what_will_be_stored() {
        let settings = PlatformSettings {
            name: "Moodle <b>".to_owned(),
            issuer: "https://lms.example.edu".to_owned(),
            auth_url: "https://lms.example.edu/auth".to_owned(),
            ..PlatformSettings::default()
        };
        let registration_url = "https://lms.example.edu/register".to_owned();
        let platform = Some(AskedRegistration { settings, registration_url, digest: "d1".to_owned() });
        let shell = samples::shell(Role::Administrator);
        let html = samples::keep_page(
            "lti-register",
            &RegisterPlatformPage { shell, asked: asked(), platform, refused: None },
        );
        assert!(html.contains("Moodle &#60;b&#62;") && html.contains("https://lms.example.edu/auth"), "{html}");
        assert!(html.contains("name=\"digest\" value=\"d1\"") && html.contains("value=\"t1\""), "{html}");
        let shell = samples::shell(Role::Administrator);
        let refused = Some("no".to_owned());
        let page = RegisterPlatformPage { shell, asked: asked(), platform: None, refused };
        assert!(!samples::keep_page("lti-register-refused", &page).contains("/admin/platforms/register"));
    }

    #[test]
    fn other_pages_say_what_to_do_next() {
        let html = samples::keep_page("lti-open-registration", &OpenRegistrationPage { asked: asked() });
        assert!(html.contains("target=\"_blank\"") && html.contains("a=1&#38;b=&#34;"), "{html}");
        let html = samples::keep_page("lti-sign-in-to-register", &SignInToRegisterPage {});
        assert!(html.contains("href=\"/login\""), "{html}");
        let html =
            samples::keep_page("lti-registered", &RegisteredPlatformPage { href: "/admin/platforms/1".to_owned() });
        assert!(html.contains("/assets/registered.js") && html.contains("Close this window"), "{html}");
    }
}
