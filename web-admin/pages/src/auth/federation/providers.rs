//! The providers of a school, for its administrators.

use askama::Template;
use askama_web::WebTemplate;
use model::auth::federation::{ClientAuthentication, LocalPasswords, ProvenIdentity, ProviderSettings, RoleMap};
use serde::Deserialize;

use crate::form::{FilledForm, read_ticked_box, read_trimmed_text};
use crate::{Shell, StatusWord, format};

/// The page of a school's providers.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/providers.html")]
pub struct ProvidersPage {
    /// Page frame.
    pub shell: Shell,
    /// The providers.
    pub rows: Vec<ProviderRow>,
    /// The form for a new one.
    pub form: FilledForm<ProviderForm>,
    /// Address to which providers send their answers.
    pub redirect_uri: String,
    /// Address of the public keys of this service.
    pub keys_uri: String,
    /// Who may sign in with a password.
    pub local: LocalPasswords,
    /// Why this rule was not changed.
    pub local_refused: Option<String>,
}

impl ProvidersPage {
    #[expect(clippy::unused_self, reason = "the two pages share a template")]
    const fn needs_secret(&self) -> bool {
        true
    }
}

/// A provider in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProviderRow {
    /// Name.
    pub name: String,
    /// Issuer identifier.
    pub issuer: String,
    /// Address of its page.
    pub href: String,
    /// Whether it is disabled.
    pub disabled: bool,
}

/// The page that changes a provider.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/provider.html")]
pub struct ProviderPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the provider.
    pub title: String,
    /// Address of this page.
    pub href: String,
    /// The form.
    pub form: FilledForm<ProviderForm>,
    /// Address of the public keys of this service.
    pub keys_uri: String,
}

impl ProviderPage {
    #[expect(clippy::unused_self, reason = "the two pages share a template")]
    const fn needs_secret(&self) -> bool {
        false
    }
}

/// Input of the form of a provider; the secret is never shown again.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ProviderForm {
    /// Name on the button.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub name: String,
    /// Issuer identifier.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub issuer: String,
    /// Id of this service at the provider.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub client_id: String,
    /// How this service authenticates: `secret` or `key`.
    #[serde(default = "default_authentication")]
    pub authentication: String,
    /// Scopes, separated by spaces.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub scopes: String,
    /// Claim that identifies a person.
    #[serde(deserialize_with = "read_trimmed_text")]
    pub subject_claim: String,
    /// Claim with the registration number; empty if none.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub match_claim: String,
    /// The provider's addresses are its own.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub addresses_verified: bool,
    /// Its second factor is trusted.
    #[serde(default, deserialize_with = "read_ticked_box")]
    pub second_factor_trusted: bool,
    /// Values of `acr` that count as a second factor, one per line.
    #[serde(default)]
    pub second_factor_acr: String,
    /// `trainee` if unknown people get an account.
    #[serde(default)]
    pub creates: String,
    /// Claim with the roles; empty if none.
    #[serde(default, deserialize_with = "read_trimmed_text")]
    pub role_claim: String,
    /// Roles of new accounts, one `value = role` per line.
    #[serde(default)]
    pub role_map: String,
}

fn default_authentication() -> String {
    ClientAuthentication::default().word().to_owned()
}

impl Default for ProviderForm {
    fn default() -> Self {
        Self::from(&ProviderSettings {
            scopes: "openid profile email".to_owned(),
            subject_claim: "sub".to_owned(),
            ..ProviderSettings::default()
        })
    }
}

impl From<&ProviderSettings> for ProviderForm {
    fn from(settings: &ProviderSettings) -> Self {
        Self {
            name: settings.name.clone(),
            issuer: settings.issuer.clone(),
            client_id: settings.client_id.clone(),
            authentication: settings.authentication.word().to_owned(),
            scopes: settings.scopes.clone(),
            subject_claim: settings.subject_claim.clone(),
            match_claim: settings.match_claim.clone().unwrap_or_default(),
            addresses_verified: settings.addresses_verified,
            second_factor_trusted: settings.second_factor_trusted,
            second_factor_acr: settings.second_factor_acr.join("\n"),
            creates: if settings.creates_trainees { "trainee" } else { "" }.to_owned(),
            role_claim: settings.role_claim.clone().unwrap_or_default(),
            role_map: settings.role_map.to_lines(),
        }
    }
}

impl ProviderForm {
    /// Returns the settings.
    ///
    /// # Errors
    /// Returns the reason if a role or a choice is not allowed.
    pub fn read(&self) -> Result<ProviderSettings, String> {
        let creates_trainees = match self.creates.as_str() {
            "" => false,
            "trainee" => true,
            other => return Err(tr!("new people: “{choice}”; allowed: empty, trainee", choice = other)),
        };
        let authentication = ClientAuthentication::of_word(&self.authentication)
            .ok_or_else(|| tr!("authentication: “{choice}”; allowed: secret, key", choice = self.authentication))?;
        let acr = self.second_factor_acr.lines().map(str::trim).filter(|value| !value.is_empty());
        let optional = |text: &String| Some(text.clone()).filter(|text| !text.is_empty());
        Ok(ProviderSettings {
            name: self.name.clone(),
            issuer: self.issuer.clone(),
            client_id: self.client_id.clone(),
            authentication,
            scopes: self.scopes.split_whitespace().collect::<Vec<_>>().join(" "),
            subject_claim: self.subject_claim.clone(),
            match_claim: optional(&self.match_claim),
            addresses_verified: self.addresses_verified,
            second_factor_trusted: self.second_factor_trusted,
            second_factor_acr: acr.map(str::to_owned).collect(),
            creates_trainees,
            role_claim: optional(&self.role_claim),
            role_map: RoleMap::parse(&self.role_map)?,
        })
    }
}

/// The page that shows the claims of a provider to an administrator.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/claims.html")]
pub struct ClaimsPage {
    /// Page frame.
    pub shell: Shell,
    /// Name of the provider.
    pub provider: String,
    /// The person as this service reads the claims.
    pub identity: ProvenIdentity,
    /// Name and value of each claim.
    pub claims: Vec<(String, String)>,
}

#[cfg(test)]
mod tests {
    use model::Role;
    use model::auth::federation::Claims;
    use serde_json::json;

    use super::*;
    use crate::samples;

    fn shell() -> Shell {
        samples::shell(Role::Administrator)
    }

    #[test]
    fn a_form_keeps_what_was_typed_and_no_secret() {
        let typed = ProviderForm {
            name: "North".to_owned(),
            issuer: "https://login.example.edu".to_owned(),
            role_map: "staff = instructor\n".to_owned(),
            creates: "trainee".to_owned(),
            addresses_verified: true,
            ..ProviderForm::default()
        };
        let settings = typed.read().unwrap();
        assert_eq!(ProviderForm::from(&settings), typed);
        assert!(ProviderForm { creates: "administrator".to_owned(), ..typed.clone() }.read().is_err());
        let row = |disabled| ProviderRow {
            name: "North".to_owned(),
            issuer: "https://login.example.edu".to_owned(),
            href: "/admin/sign-in/1".to_owned(),
            disabled,
        };
        let page = ProvidersPage {
            shell: shell(),
            rows: vec![row(false), row(true)],
            form: FilledForm::refused(typed.clone(), "no".to_owned()),
            redirect_uri: "https://stylet.example.edu/sign-in/callback".to_owned(),
            keys_uri: "https://stylet.example.edu/.well-known/jwks.json".to_owned(),
            local: LocalPasswords::Administrators,
            local_refused: Some("no".to_owned()),
        };
        let html = samples::keep_page("providers", &page);
        assert!(html.contains("staff = instructor") && html.contains("/admin/sign-in/1/enable"), "{html}");
        let page = ProviderPage {
            shell: shell(),
            title: "North".to_owned(),
            href: "/admin/sign-in/1".to_owned(),
            form: FilledForm::new(typed),
            keys_uri: "https://stylet.example.edu/.well-known/jwks.json".to_owned(),
        };
        assert!(samples::keep_page("provider", &page).contains("keep the stored one"));
    }

    #[test]
    fn claims_are_shown_as_text() {
        let claims = json!({ "sub": "1", "name": "<b>Ana" }).as_object().cloned().unwrap();
        let identity = ProvenIdentity::read(&ProviderForm::default().read().unwrap(), &Claims(claims.clone())).unwrap();
        let claims = claims.into_iter().map(|(name, value)| (name, value.to_string())).collect();
        let page = ClaimsPage { shell: shell(), provider: "North".to_owned(), identity, claims };
        assert!(samples::keep_page("claims", &page).contains("&#60;b&#62;Ana"));
    }
}
