//! Tokens of directories that provision people.

use askama::Template;
use askama_web::WebTemplate;
use model::limits::LONGEST_NAME;
use serde::Deserialize;
use time::OffsetDateTime;

use crate::auth::reauthentication::OwnPassword;
use crate::form::{FilledForm, read_ticked_box};
use crate::{Shell, format};

/// The page of a school's directories.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "people/provisioning.html")]
pub struct ProvisioningPage {
    /// Page frame.
    pub shell: Shell,
    /// Address of the SCIM endpoints.
    pub address: String,
    /// The tokens, newest first.
    pub rows: Vec<DirectoryTokenRow>,
    /// The form for a new token.
    pub form: FilledForm<DirectoryTokenForm>,
    /// How the user proves who they are.
    pub own_password: OwnPassword,
    /// The new token, shown once.
    pub made: Option<String>,
}

/// A token in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectoryTokenRow {
    /// Name.
    pub name: String,
    /// Time of creation.
    pub made: OffsetDateTime,
    /// Time of the last use, to the hour.
    pub used: Option<OffsetDateTime>,
    /// Expiry.
    pub expires: OffsetDateTime,
    /// Whether it may disable instructors and administrators.
    pub may_disable_staff: bool,
    /// Address that revokes it.
    pub revoke_href: String,
}

/// Input of the form for a new token; the password is never shown again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct DirectoryTokenForm {
    /// Name.
    pub name: String,
    /// Whether it may disable instructors and administrators.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub may_disable_staff: bool,
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn a_new_token_is_shown_and_the_others_can_be_revoked() {
        let row = |used, may_disable_staff| DirectoryTokenRow {
            name: "Entra <b>".to_owned(),
            made: samples::NOW,
            used,
            expires: samples::NOW,
            may_disable_staff,
            revoke_href: "/admin/provisioning/1/revoke".to_owned(),
        };
        let page = ProvisioningPage {
            shell: samples::shell(Role::Administrator),
            address: "https://stylet.example.org/scim/v2".to_owned(),
            rows: vec![row(None, false), row(Some(samples::NOW), true)],
            form: FilledForm::refused(DirectoryTokenForm::default(), "no".to_owned()),
            own_password: OwnPassword::Known,
            made: Some("abc".repeat(21)),
        };
        let html = samples::keep_page("provisioning", &page);
        assert!(html.contains(&"abc".repeat(21)) && html.contains("Entra &#60;b&#62;"), "{html}");
        assert_eq!(html.matches("/admin/provisioning/1/revoke").count(), 2);
        let none = ProvisioningPage { rows: vec![], made: None, ..page };
        assert!(samples::keep_page("provisioning-none", &none).contains("No directory"));
    }
}
