//! SCIM 2.0 (RFC 7643, RFC 7644): users and groups as JSON, filters and patches. Independent of
//! storage and requests.

mod filter;
mod patch;
pub mod schemas;
mod selection;
#[cfg(test)]
mod tests;

use data_encoding::HEXLOWER;
pub use filter::Filter;
pub use patch::PatchRequest;
pub use selection::Selection;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use super::email::{is_email, normalize_email, present_email};
use crate::ids::{CohortId, PersonId};
use crate::{Moment, Role, single_line_text};

/// Maximum length of a text, in characters.
const LONGEST_TEXT: usize = 200;
/// Maximum number of members of a group.
const MOST_MEMBERS: usize = 50_000;

/// A JSON object.
pub type Object = Map<String, Value>;

/// An error answer (RFC 7644, section 3.12).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{detail}")]
pub struct ScimError {
    /// HTTP status.
    pub status: u16,
    /// Keyword of the error, if the standard has one.
    pub kind: Option<&'static str>,
    /// Explanation, in English.
    pub detail: String,
}

impl ScimError {
    /// Creates an error of status 400.
    pub(crate) fn invalid(kind: &'static str, detail: impl Into<String>) -> Self {
        Self { status: 400, kind: Some(kind), detail: detail.into() }
    }

    /// Creates the error for a value that another resource has.
    pub fn taken(detail: impl Into<String>) -> Self {
        Self { status: 409, kind: Some("uniqueness"), detail: detail.into() }
    }

    /// Returns the answer as JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut body = json!({
            "schemas": ["urn:ietf:params:scim:api:messages:2.0:Error"],
            "status": self.status.to_string(),
            "detail": self.detail,
        });
        if let Some(kind) = self.kind {
            body["scimType"] = kind.into();
        }
        body
    }
}

/// Names of attributes as the standard writes them; clients may use any case.
const NAMES: [&str; 21] = [
    "schemas",
    "id",
    "externalId",
    "meta",
    "userName",
    "displayName",
    "name",
    "formatted",
    "givenName",
    "familyName",
    "emails",
    "value",
    "type",
    "primary",
    "active",
    "members",
    "display",
    "$ref",
    "Operations",
    "op",
    "path",
];

/// Returns an attribute's name as the standard writes it.
fn standard_name(name: &str) -> &str {
    NAMES.into_iter().find(|known| known.eq_ignore_ascii_case(name)).unwrap_or(name)
}

/// Writes the names of all attributes as the standard does, and removes nulls.
pub(crate) fn standardize(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let fields = fields.into_iter().filter(|(_, value)| !value.is_null());
            Value::Object(fields.map(|(name, value)| (standard_name(&name).to_owned(), standardize(value))).collect())
        }
        Value::Array(values) => Value::Array(values.into_iter().map(standardize).collect()),
        other => other,
    }
}

/// Parses a resource that a client has sent.
///
/// # Errors
/// If it is not an object.
pub fn read_resource(body: Value) -> Result<Object, ScimError> {
    match standardize(body) {
        Value::Object(fields) => Ok(fields),
        _ => Err(ScimError::invalid("invalidSyntax", "the body must be a JSON object")),
    }
}

/// Returns a text attribute; a missing or blank one is absent.
fn text(fields: &Object, name: &str) -> Result<Option<String>, ScimError> {
    let Some(value) = fields.get(name) else { return Ok(None) };
    let Some(text) = value.as_str() else {
        return Err(ScimError::invalid("invalidValue", format!("{name}: must be a string")));
    };
    let text = single_line_text::tidy(text);
    if text.chars().count() > LONGEST_TEXT {
        return Err(ScimError::invalid("invalidValue", format!("{name}: longer than {LONGEST_TEXT} characters")));
    }
    if single_line_text::strange_in(&text).is_some() {
        return Err(ScimError::invalid("invalidValue", format!("{name}: contains a control character")));
    }
    Ok(Some(text).filter(|text| !text.is_empty()))
}

fn required(fields: &Object, name: &str) -> Result<String, ScimError> {
    text(fields, name)?.ok_or_else(|| ScimError::invalid("invalidValue", format!("{name}: required")))
}

/// Where a resource is served.
#[derive(Clone, Copy, Debug)]
pub struct ScimAddress<'a>(pub &'a str);

/// Completes a resource with its metadata; the version is a hash of its content.
fn complete(mut fields: Object, address: ScimAddress<'_>, kind: &str, path: &str) -> Object {
    let hash = HEXLOWER.encode(&Sha256::digest(Value::Object(fields.clone()).to_string().as_bytes())[..8]);
    let meta = json!({
        "resourceType": kind,
        "location": format!("{}{path}", address.0),
        "version": format!("W/\"{hash}\""),
    });
    fields.insert("meta".to_owned(), meta);
    fields
}

/// A person, as a directory sees them.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "sqlx", derive(sqlx::FromRow))]
pub struct ScimUser {
    /// Id.
    pub id: PersonId,
    /// Unique name.
    pub user_name: String,
    /// Name.
    pub display_name: String,
    /// Registration number.
    pub external_id: Option<String>,
    /// Stored email address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// When the account was disabled.
    pub disabled_at: Option<Moment>,
}

impl ScimUser {
    /// Returns the resource.
    #[must_use]
    pub fn to_json(&self, address: ScimAddress<'_>) -> Object {
        let mut fields = Object::new();
        fields.insert("schemas".to_owned(), json!([schemas::USER]));
        fields.insert("id".to_owned(), json!(self.id));
        fields.insert("userName".to_owned(), json!(self.user_name));
        fields.insert("displayName".to_owned(), json!(self.display_name));
        fields.insert("active".to_owned(), json!(self.disabled_at.is_none()));
        if let Some(number) = &self.external_id {
            fields.insert("externalId".to_owned(), json!(number));
        }
        if let Some(email) = present_email(&self.email) {
            fields.insert("emails".to_owned(), json!([{ "value": email, "type": "work" }]));
        }
        complete(fields, address, "User", &format!("/Users/{}", self.id))
    }
}

/// What a directory wants a person to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WantedUser {
    /// Unique name.
    pub user_name: String,
    /// Name.
    pub display_name: String,
    /// Registration number.
    pub external_id: Option<String>,
    /// Email address, normalized.
    pub email: Option<String>,
    /// Whether the account is enabled.
    pub active: bool,
}

impl WantedUser {
    /// Reads a resource. `before` is the person that it replaces: if only the parts of the name have
    /// changed, they become the displayed name.
    ///
    /// # Errors
    /// If an attribute is missing or invalid.
    pub fn read(fields: &Object, before: Option<&ScimUser>) -> Result<Self, ScimError> {
        let user_name = required(fields, "userName")?;
        let parts = match fields.get("name") {
            Some(Value::Object(parts)) => join_name(parts)?,
            _ => None,
        };
        let displayed = text(fields, "displayName")?;
        let is_kept = before.is_some_and(|before| displayed.as_ref() == Some(&before.display_name));
        let display_name = if is_kept { parts.or(displayed) } else { displayed.or(parts) };
        let email = match read_email(fields)? {
            None if before.is_none() && is_email(&normalize_email(&user_name)) => Some(normalize_email(&user_name)),
            email => email,
        };
        Ok(Self {
            display_name: display_name.unwrap_or_else(|| user_name.clone()),
            user_name,
            external_id: text(fields, "externalId")?,
            email,
            active: read_active(fields)?,
        })
    }
}

fn join_name(parts: &Object) -> Result<Option<String>, ScimError> {
    let (given, family) = (text(parts, "givenName")?, text(parts, "familyName")?);
    let both: Vec<String> = given.into_iter().chain(family).collect();
    Ok(if both.is_empty() { text(parts, "formatted")? } else { Some(both.join(" ")) })
}

fn read_email(fields: &Object) -> Result<Option<String>, ScimError> {
    let emails = match fields.get("emails") {
        Some(Value::Array(emails)) => emails.as_slice(),
        None => return Ok(None),
        Some(_) => return Err(ScimError::invalid("invalidValue", "emails: must be an array")),
    };
    let is_primary = |email: &&Value| email.get("primary").and_then(Value::as_bool) == Some(true);
    let Some(email) = emails.iter().find(is_primary).or_else(|| emails.first()) else { return Ok(None) };
    let Some(value) = email.get("value").and_then(Value::as_str) else { return Ok(None) };
    let value = normalize_email(value);
    match is_email(&value) {
        true => Ok(Some(value)),
        false => Err(ScimError::invalid("invalidValue", "emails: not an email address")),
    }
}

/// Some clients send booleans as text.
fn read_active(fields: &Object) -> Result<bool, ScimError> {
    match fields.get("active") {
        None => Ok(true),
        Some(Value::Bool(active)) => Ok(*active),
        Some(Value::String(text)) if text.eq_ignore_ascii_case("true") => Ok(true),
        Some(Value::String(text)) if text.eq_ignore_ascii_case("false") => Ok(false),
        Some(_) => Err(ScimError::invalid("invalidValue", "active: must be true or false")),
    }
}

/// A cohort, as a directory sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScimGroup {
    /// Id.
    pub id: CohortId,
    /// Name.
    pub name: String,
    /// Id in the directory.
    pub external_id: Option<String>,
    /// Trainees of the cohort, by id.
    pub members: Vec<PersonId>,
}

impl ScimGroup {
    /// Returns the resource.
    #[must_use]
    pub fn to_json(&self, address: ScimAddress<'_>) -> Object {
        let mut fields = Object::new();
        fields.insert("schemas".to_owned(), json!([schemas::GROUP]));
        fields.insert("id".to_owned(), json!(self.id));
        fields.insert("displayName".to_owned(), json!(self.name));
        if let Some(external) = &self.external_id {
            fields.insert("externalId".to_owned(), json!(external));
        }
        if !self.members.is_empty() {
            let member =
                |id: &PersonId| json!({ "value": id, "type": "User", "$ref": format!("{}/Users/{id}", address.0) });
            fields.insert("members".to_owned(), self.members.iter().map(member).collect());
        }
        complete(fields, address, "Group", &format!("/Groups/{}", self.id))
    }
}

/// What a directory wants a cohort to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WantedGroup {
    /// Name.
    pub name: String,
    /// Id in the directory.
    pub external_id: Option<String>,
    /// People in it; only trainees become members.
    pub members: Vec<PersonId>,
}

impl WantedGroup {
    /// Reads a resource.
    ///
    /// # Errors
    /// If an attribute is missing or invalid.
    pub fn read(fields: &Object) -> Result<Self, ScimError> {
        let members = match fields.get("members") {
            Some(Value::Array(members)) => members.as_slice(),
            None => &[],
            Some(_) => return Err(ScimError::invalid("invalidValue", "members: must be an array")),
        };
        if members.len() > MOST_MEMBERS {
            return Err(ScimError::invalid("tooMany", format!("members: more than {MOST_MEMBERS}")));
        }
        let member = |member: &Value| {
            let id = member.get("value").and_then(Value::as_str).and_then(|id| id.parse().ok());
            id.ok_or_else(|| ScimError::invalid("invalidValue", "members: value must be the id of a user"))
        };
        Ok(Self {
            name: required(fields, "displayName")?,
            external_id: text(fields, "externalId")?,
            members: members.iter().map(member).collect::<Result<_, _>>()?,
        })
    }
}
