//! What this service supports, as a client discovers it (RFC 7643, sections 5 to 7).

use serde_json::{Value, json};

use super::ScimAddress;

/// Schema of users.
pub const USER: &str = "urn:ietf:params:scim:schemas:core:2.0:User";
/// Schema of groups.
pub const GROUP: &str = "urn:ietf:params:scim:schemas:core:2.0:Group";
/// Maximum number of resources in an answer.
pub const MOST_RESULTS: u32 = 200;

/// Returns the configuration of the service.
#[must_use]
pub fn provider_config(address: ScimAddress<'_>) -> Value {
    json!({
        "schemas": ["urn:ietf:params:scim:schemas:core:2.0:ServiceProviderConfig"],
        "patch": { "supported": true },
        "bulk": { "supported": false, "maxOperations": 0, "maxPayloadSize": 0 },
        "filter": { "supported": true, "maxResults": MOST_RESULTS },
        "changePassword": { "supported": false },
        "sort": { "supported": false },
        "etag": { "supported": true },
        "authenticationSchemes": [{
            "type": "oauthbearertoken",
            "name": "Bearer token",
            "description": "A token that an administrator of the school has created for provisioning.",
        }],
        "meta": { "resourceType": "ServiceProviderConfig", "location": format!("{}/ServiceProviderConfig", address.0) },
    })
}

/// Returns the kinds of resources.
#[must_use]
pub fn resource_types(address: ScimAddress<'_>) -> Vec<Value> {
    let kind = |name: &str, endpoint: &str, schema: &str| {
        json!({
            "schemas": ["urn:ietf:params:scim:schemas:core:2.0:ResourceType"],
            "id": name,
            "name": name,
            "endpoint": endpoint,
            "schema": schema,
            "meta": { "resourceType": "ResourceType", "location": format!("{}/ResourceTypes/{name}", address.0) },
        })
    };
    vec![kind("User", "/Users", USER), kind("Group", "/Groups", GROUP)]
}

/// Characteristics of an attribute that differ from the defaults.
struct Attribute {
    name: &'static str,
    kind: &'static str,
    is_required: bool,
    is_unique: bool,
    is_read_only: bool,
    parts: Vec<Value>,
}

impl Attribute {
    const fn new(name: &'static str, kind: &'static str) -> Self {
        Self { name, kind, is_required: false, is_unique: false, is_read_only: false, parts: Vec::new() }
    }

    fn into_json(self) -> Value {
        let mut described = json!({
            "name": self.name,
            "type": self.kind,
            "multiValued": !self.parts.is_empty(),
            "required": self.is_required,
            "mutability": if self.is_read_only { "readOnly" } else { "readWrite" },
            "returned": "default",
            "description": self.name,
        });
        match self.kind {
            "complex" => described["subAttributes"] = self.parts.into(),
            "string" => {
                described["caseExact"] = false.into();
                described["uniqueness"] = if self.is_unique { "server" } else { "none" }.into();
            }
            "reference" => {
                described["caseExact"] = true.into();
                described["uniqueness"] = "none".into();
                described["referenceTypes"] = json!(["User"]);
            }
            _ => {}
        }
        described
    }
}

/// Returns the schemas: the attributes that are stored.
#[must_use]
pub fn schemas(address: ScimAddress<'_>) -> Vec<Value> {
    let text = |name| Attribute::new(name, "string");
    let of_kind = |name: &'static str, value: &str| {
        let mut described = text(name).into_json();
        described["canonicalValues"] = json!([value]);
        described
    };
    let email = vec![text("value").into_json(), of_kind("type", "work")];
    let member =
        vec![text("value").into_json(), of_kind("type", "User"), Attribute::new("$ref", "reference").into_json()];
    let user = vec![
        Attribute { is_required: true, is_unique: true, ..text("userName") }.into_json(),
        Attribute { is_required: true, ..text("displayName") }.into_json(),
        Attribute { is_required: true, ..Attribute::new("active", "boolean") }.into_json(),
        Attribute { parts: email, ..Attribute::new("emails", "complex") }.into_json(),
    ];
    let group = vec![
        Attribute { is_required: true, is_unique: true, ..text("displayName") }.into_json(),
        Attribute { parts: member, ..Attribute::new("members", "complex") }.into_json(),
    ];
    let schema = |id: &str, name: &str, attributes: Vec<Value>| {
        json!({
            "schemas": ["urn:ietf:params:scim:schemas:core:2.0:Schema"],
            "id": id,
            "name": name,
            "description": name,
            "attributes": attributes,
            "meta": { "resourceType": "Schema", "location": format!("{}/Schemas/{id}", address.0) },
        })
    };
    vec![schema(USER, "User", user), schema(GROUP, "Group", group)]
}
