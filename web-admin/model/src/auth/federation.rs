//! Sign-in with accounts of other systems: the providers of a school, and what they say of a person.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use url::Url;

use crate::people::email::{is_email, normalize_email};
use crate::single_line_text;
use crate::{Moment, Role};

/// Maximum length of each text in a provider's settings, in characters.
const LONGEST_SETTING: usize = 500;
/// Maximum number of values in a role map, and of `acr`.
const MOST_VALUES: usize = 50;
/// Maximum length of a name taken from a provider, in characters.
const LONGEST_NAME: usize = 200;
/// Methods in the claim `amr` that count as a second factor (RFC 8176).
const STRONG_METHODS: [&str; 7] = ["mfa", "hwk", "swk", "otp", "fpt", "face", "sc"];
/// Maximum age of a sign-in that proves a person anew, in s.
pub const FRESH_S: i64 = 5 * 60;
/// Permitted difference between the clocks of the provider and of this service, in s.
pub const CLOCK_SKEW_S: i64 = 60;

/// Who may sign in with a password of this service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum LocalPasswords {
    /// Everybody who has one.
    #[default]
    Everybody,
    /// Administrators alone; everybody else signs in by a provider.
    Administrators,
}

impl LocalPasswords {
    /// Every rule.
    pub const ALL: [Self; 2] = [Self::Everybody, Self::Administrators];

    /// Returns the word used in the database and in forms.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Everybody => "everybody",
            Self::Administrators => "administrators",
        }
    }

    /// Returns the rule of a word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rule| rule.word() == word)
    }

    /// Returns whether people with a role may sign in with a password.
    #[must_use]
    pub fn allow(self, role: Role) -> bool {
        self == Self::Everybody || role == Role::Administrator
    }
}

/// How this service authenticates at a provider.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ClientAuthentication {
    /// By a secret of the provider.
    #[default]
    Secret,
    /// By a signature with a key of this service.
    Key,
}

impl ClientAuthentication {
    /// Every way.
    pub const ALL: [Self; 2] = [Self::Secret, Self::Key];

    /// Returns the word used in forms.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Secret => "secret",
            Self::Key => "key",
        }
    }

    /// Returns the way of a word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|way| way.word() == word)
    }
}

/// Purpose of a sign-in at a provider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum FlowPurpose {
    /// Signing in.
    Enter,
    /// Adding the identity to the account of the signed-in person.
    Join,
    /// Proving who is at the keyboard, instead of a password.
    Prove,
    /// Showing an administrator what the provider says.
    Try,
}

/// Protocol by which an identity was confirmed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "lowercase"))]
pub enum IdentityKind {
    /// OpenID Connect: by a provider.
    Oidc,
    /// LTI: by a learning platform.
    Lti,
}

/// How an identity came to belong to a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
#[cfg_attr(feature = "sqlx", sqlx(type_name = "text", rename_all = "snake_case"))]
#[serde(rename_all = "snake_case")]
pub enum IdentityOrigin {
    /// The account was created at its first sign-in.
    Created,
    /// By the registration number, or by a verified address.
    Matched,
    /// By the person, who has proved both accounts.
    Joined,
    /// By an administrator.
    ByAdministrator,
}

/// Settings of a provider, without its secret.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProviderSettings {
    /// Name shown on the button.
    pub name: String,
    /// Issuer identifier: an `https` URL, compared to the byte.
    pub issuer: String,
    /// Id of this service at the provider.
    pub client_id: String,
    /// How this service authenticates there.
    pub authentication: ClientAuthentication,
    /// Scopes, separated by spaces; contain `openid`.
    pub scopes: String,
    /// Claim that identifies a person, usually `sub`.
    pub subject_claim: String,
    /// Claim that contains the registration number.
    pub match_claim: Option<String>,
    /// The provider's addresses are its own: an address identifies its owner.
    pub addresses_verified: bool,
    /// Its second factor replaces the one of this service.
    pub second_factor_trusted: bool,
    /// Values of the claim `acr` that count as a second factor, in addition to the methods in `amr`.
    pub second_factor_acr: Vec<String>,
    /// Unknown people get a new account as trainees.
    pub creates_trainees: bool,
    /// Claim that names a person's roles.
    pub role_claim: Option<String>,
    /// Roles here, by the values of that claim.
    pub role_map: RoleMap,
}

/// Roles of new accounts by the values of a claim; never administrator.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RoleMap(BTreeMap<String, Role>);

impl RoleMap {
    /// Parses one `value = role` per line.
    ///
    /// # Errors
    /// Returns the reason in the current language, with the line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut roles = BTreeMap::new();
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let role = match line.rsplit_once('=').map(|(value, role)| (value.trim(), role.trim())) {
                Some((value, "trainee")) if !value.is_empty() => (value, Role::Trainee),
                Some((value, "instructor")) if !value.is_empty() => (value, Role::Instructor),
                _ => {
                    return Err(tr!(
                        "roles: “{line}”; allowed: a value, “=”, and trainee or instructor",
                        line = shorten(line)
                    ));
                }
            };
            roles.insert(role.0.to_owned(), role.1);
        }
        match roles.len() {
            0..=MOST_VALUES => Ok(Self(roles)),
            count => Err(tr!("roles: {count} values; at most {most} are allowed", count = count, most = MOST_VALUES)),
        }
    }

    /// Returns the map as one `value = role` per line.
    #[must_use]
    pub fn to_lines(&self) -> String {
        self.0.iter().map(|(value, role)| format!("{value} = {}\n", role.as_str())).collect()
    }

    /// Returns the highest role among values of the claim; trainee if none is in the map.
    fn find_role(&self, values: &[String]) -> Role {
        let is_instructor = values.iter().any(|value| self.0.get(value) == Some(&Role::Instructor));
        if is_instructor { Role::Instructor } else { Role::Trainee }
    }
}

fn shorten(text: &str) -> String {
    text.chars().take(100).collect()
}

impl ProviderSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Returns the reason in the current language, with the field.
    pub fn check(&self) -> Result<(), String> {
        let required = [
            (tr!("name"), &self.name),
            (tr!("issuer"), &self.issuer),
            (tr!("client id"), &self.client_id),
            (tr!("scopes"), &self.scopes),
            (tr!("claim of the person"), &self.subject_claim),
        ];
        for (field, value) in required {
            check_setting(field, value)?;
            if value.is_empty() {
                return Err(tr!("{field}: empty; it is required", field = field));
            }
        }
        for (field, value) in
            [(tr!("claim of the number"), &self.match_claim), (tr!("claim of the roles"), &self.role_claim)]
        {
            check_setting(field, value.as_deref().unwrap_or_default())?;
        }
        if self.second_factor_acr.len() > MOST_VALUES {
            return Err(tr!("values of acr: more than {most}", most = MOST_VALUES));
        }
        for value in &self.second_factor_acr {
            check_setting(tr!("values of acr"), value)?;
        }
        if !self.scopes.split(' ').any(|scope| scope == "openid") {
            return Err(tr!("scopes: “{scopes}”; openid must be among them", scopes = shorten(&self.scopes)));
        }
        match Url::parse(&self.issuer) {
            Ok(url) if url.host().is_some() && url.query().is_none() && url.fragment().is_none() => Ok(()),
            _ => Err(tr!(
                "issuer: “{issuer}”; allowed: an address such as https://login.example.edu, without “?” and “#”",
                issuer = shorten(&self.issuer)
            )),
        }
    }
}

/// Checks the length and the characters of a setting.
///
/// # Errors
/// Returns the reason in the current language, with the field.
pub(super) fn check_setting(field: &str, value: &str) -> Result<(), String> {
    if value.chars().count() > LONGEST_SETTING {
        return Err(tr!("{field}: longer than {most} characters", field = field, most = LONGEST_SETTING));
    }
    single_line_text::refusal(field, value).map_or(Ok(()), Err)
}

/// Claims of a verified ID token, completed by those of the user information.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Claims(pub Map<String, Value>);

impl Claims {
    /// Returns a claim as text: a non-empty string, a number, or the first element of a list.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        self.list(name).into_iter().next()
    }

    /// Returns a non-empty claim to the byte, or a number as text.
    pub(super) fn exact(&self, name: &str) -> Option<String> {
        match self.0.get(name)? {
            Value::String(text) if !text.trim().is_empty() => Some(text.clone()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        }
    }

    /// Returns a claim as a list of texts; a single value is a list of one.
    #[must_use]
    pub fn list(&self, name: &str) -> Vec<String> {
        let values = match self.0.get(name) {
            Some(Value::Array(values)) => values.as_slice(),
            Some(value) => std::slice::from_ref(value),
            None => &[],
        };
        let text = |value: &Value| match value {
            Value::String(text) => Some(text.trim().to_owned()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        };
        values.iter().filter_map(text).filter(|text| !text.is_empty()).collect()
    }

    /// Returns whether a claim is true; some providers send it as text.
    #[must_use]
    pub fn is_true(&self, name: &str) -> bool {
        matches!(self.0.get(name), Some(Value::Bool(true))) || self.text(name).as_deref() == Some("true")
    }

    /// Returns a claim as a time in seconds since 1970.
    #[must_use]
    pub fn time_s(&self, name: &str) -> Option<i64> {
        self.0.get(name).and_then(|value| value.as_i64().or_else(|| Some(value.as_f64()?.floor() as i64)))
    }

    /// Returns whether the user has signed in at the provider within the last five minutes.
    #[must_use]
    pub fn is_fresh(&self, now: Moment) -> bool {
        let now_s = now.micros().div_euclid(1_000_000);
        self.time_s("auth_time").is_some_and(|at| at <= now_s + CLOCK_SKEW_S && now_s - at <= FRESH_S + CLOCK_SKEW_S)
    }
}

/// A person as their provider describes them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProvenIdentity {
    /// The provider's issuer identifier.
    pub issuer: String,
    /// Stable id of the person at the provider.
    pub subject: String,
    /// Name; the address or the id if the provider sends none.
    pub name: String,
    /// Email address, normalized.
    pub email: Option<String>,
    /// Whether the address belongs to the person.
    pub email_verified: bool,
    /// Registration number.
    pub number: Option<String>,
    /// Role of a new account.
    pub role: Role,
    /// Whether the person has used a second factor that replaces the one of this service.
    pub has_second_factor: bool,
}

impl ProvenIdentity {
    /// Reads the claims of a person by the settings of the provider. Returns `None` if the claim
    /// that identifies the person is missing.
    #[must_use]
    pub fn read(settings: &ProviderSettings, claims: &Claims) -> Option<Self> {
        let subject = claims.exact(&settings.subject_claim).filter(|subject| subject.len() <= LONGEST_SETTING)?;
        let number = settings.match_claim.as_ref().and_then(|claim| claims.text(claim));
        let roles = settings.role_claim.as_ref().map(|claim| claims.list(claim)).unwrap_or_default();
        let is_strong = |method: &String| STRONG_METHODS.contains(&method.as_str());
        let is_listed = |context: &String| settings.second_factor_acr.contains(context);
        let described = Self::describe(claims, subject);
        Some(Self {
            issuer: settings.issuer.clone(),
            email_verified: described.email.is_some()
                && (settings.addresses_verified || claims.is_true("email_verified")),
            number: number.filter(|number| single_line_text::refusal("", number).is_none() && number.len() <= 100),
            role: settings.role_map.find_role(&roles),
            has_second_factor: settings.second_factor_trusted
                && (claims.list("amr").iter().any(is_strong) || claims.list("acr").iter().any(is_listed)),
            ..described
        })
    }

    /// Reads the name and the address of a trainee whom an issuer, which the caller adds, calls
    /// `subject`.
    pub(super) fn describe(claims: &Claims, subject: String) -> Self {
        let email = claims.text("email").map(|email| normalize_email(&email)).filter(|email| is_email(email));
        let full_name = || Some(format!("{} {}", claims.text("given_name")?, claims.text("family_name")?));
        let name = claims.text("name").or_else(full_name).or_else(|| claims.text("preferred_username"));
        let name = name.or_else(|| email.clone()).unwrap_or_else(|| subject.clone());
        Self {
            issuer: String::new(),
            name: single_line_text::tidy(&single_line_text::on_one_line(&name)).chars().take(LONGEST_NAME).collect(),
            subject,
            email,
            email_verified: false,
            number: None,
            role: Role::Trainee,
            has_second_factor: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn settings() -> ProviderSettings {
        ProviderSettings {
            name: "North".to_owned(),
            issuer: "https://login.example.edu".to_owned(),
            client_id: "stylet".to_owned(),
            scopes: "openid profile email".to_owned(),
            subject_claim: "sub".to_owned(),
            match_claim: Some("eppn".to_owned()),
            role_claim: Some("affiliation".to_owned()),
            role_map: RoleMap::parse("staff = instructor\nstudent=trainee").unwrap(),
            ..ProviderSettings::default()
        }
    }

    fn claims(value: Value) -> Claims {
        Claims(value.as_object().cloned().unwrap())
    }

    #[test]
    fn settings_are_checked_with_the_field() {
        assert_eq!(settings().check(), Ok(()));
        let bad = [
            ProviderSettings { name: String::new(), ..settings() },
            ProviderSettings { issuer: "login.example.edu".to_owned(), ..settings() },
            ProviderSettings { issuer: "https://login.example.edu?x=1".to_owned(), ..settings() },
            ProviderSettings { scopes: "profile".to_owned(), ..settings() },
            ProviderSettings { client_id: "a\nb".to_owned(), ..settings() },
            ProviderSettings { match_claim: Some("x".repeat(501)), ..settings() },
        ];
        for (settings, field) in bad.iter().zip(["name", "issuer", "issuer", "scopes", "client id", "number"]) {
            assert!(settings.check().unwrap_err().contains(field), "{settings:?}");
        }
        for bad in ["staff = administrator", "staff", "= trainee"] {
            assert!(RoleMap::parse(bad).unwrap_err().contains(bad), "{bad}");
        }
        let text = "a=b = instructor\n";
        assert_eq!(RoleMap::parse(text).unwrap().to_lines(), text);
    }

    #[test]
    fn claims_describe_a_person() {
        let told = claims(json!({
            "sub": "1", "given_name": "Ada", "family_name": "Lovelace", "email": "ADA@example.edu", "email_verified": "true",
            "eppn": [7], "affiliation": ["member", "staff"], "amr": ["pwd", "otp"]
        }));
        let read = ProvenIdentity::read(&settings(), &told).unwrap();
        assert_eq!((read.name.as_str(), read.email.as_deref()), ("Ada Lovelace", Some("ada@example.edu")));
        assert_eq!((read.number.as_deref(), read.role, read.email_verified), (Some("7"), Role::Instructor, true));
        assert!(!read.has_second_factor, "the school does not trust it");
        let trusting = ProviderSettings { second_factor_trusted: true, ..settings() };
        assert!(ProvenIdentity::read(&trusting, &told).unwrap().has_second_factor);
        let bare = ProvenIdentity::read(&settings(), &claims(json!({ "sub": "x1" }))).unwrap();
        assert_eq!((bare.name.as_str(), bare.email, bare.role), ("x1", None, Role::Trainee));
        for nobody in [json!({}), json!({ "sub": "" }), json!({ "sub": null }), json!({ "sub": "x".repeat(501) })] {
            assert_eq!(ProvenIdentity::read(&settings(), &claims(nobody)), None);
        }
    }

    #[test]
    fn only_a_recent_sign_in_proves_anew() {
        let now = Moment::from_micros(1_700_000_000_000_000);
        for (at, fresh) in [(0, true), (-299, true), (-400, false), (30, true), (90, false)] {
            let told = claims(json!({ "auth_time": 1_700_000_000_i64 + at }));
            assert_eq!(told.is_fresh(now), fresh, "{at}");
        }
        assert!(!claims(json!({})).is_fresh(now));
    }
}
