//! Patches (RFC 7644, section 3.5.2), with the paths that Entra and Okta send.

use serde_json::{Value, json};

use super::filter::Filter;
use super::{Object, ScimError, standard_name, standardize};

/// Maximum number of operations in a request.
const MOST_OPERATIONS: usize = 1000;

/// The operations of a request.
#[derive(Clone, Debug)]
pub struct PatchRequest(Vec<Operation>);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verb {
    Add,
    Replace,
    Remove,
}

#[derive(Clone, Debug)]
struct Operation {
    verb: Verb,
    path: Option<String>,
    value: Option<Value>,
}

/// An attribute, some of its values, a part of it.
struct AttributePath {
    attribute: String,
    chosen: Option<Filter>,
    part: Option<String>,
}

fn bad_path(path: &str) -> ScimError {
    let shown: String = path.chars().take(100).collect();
    ScimError::invalid("invalidPath", format!("path: \"{shown}\""))
}

impl AttributePath {
    /// Parses `attribute`, `attribute.part`, `attribute[filter]` or `attribute[filter].part`, also
    /// behind the name of a schema.
    fn parse(path: &str) -> Result<Self, ScimError> {
        let start = path.find('[').unwrap_or(path.len());
        let (head, rest) = path.split_at(start);
        let head = match head.rfind(':') {
            // A schema's name contains a point: 2.0.
            Some(colon) if head.to_ascii_lowercase().starts_with("urn:") => &head[colon + 1..],
            _ => head,
        };
        let is_name =
            |name: &str| !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "$_-".contains(c));
        let owned = |name: &str| is_name(name).then(|| standard_name(name).to_owned()).ok_or_else(|| bad_path(path));
        if rest.is_empty() {
            return match head.split_once('.') {
                Some((attribute, part)) => {
                    Ok(Self { attribute: owned(attribute)?, chosen: None, part: Some(owned(part)?) })
                }
                None => Ok(Self { attribute: owned(head)?, chosen: None, part: None }),
            };
        }
        let (filter, after) = rest[1..].rsplit_once(']').ok_or_else(|| bad_path(path))?;
        let part = match after.strip_prefix('.') {
            Some(part) => Some(owned(part)?),
            None if after.is_empty() => None,
            None => return Err(bad_path(path)),
        };
        Ok(Self { attribute: owned(head)?, chosen: Some(Filter::parse(filter)?), part })
    }
}

impl PatchRequest {
    /// Parses a request.
    ///
    /// # Errors
    /// If it is malformed.
    pub fn read(body: Value) -> Result<Self, ScimError> {
        let malformed = |what: &str| ScimError::invalid("invalidSyntax", what.to_owned());
        let body = standardize(body);
        let Some(Value::Array(operations)) = body.get("Operations") else {
            return Err(malformed("Operations: must be an array"));
        };
        if operations.len() > MOST_OPERATIONS {
            return Err(ScimError::invalid("tooMany", format!("Operations: more than {MOST_OPERATIONS}")));
        }
        let read = |operation: &Value| {
            let verb = match operation.get("op").and_then(Value::as_str).map(str::to_ascii_lowercase).as_deref() {
                Some("add") => Verb::Add,
                Some("replace") => Verb::Replace,
                Some("remove") => Verb::Remove,
                _ => return Err(malformed("op: must be add, replace or remove")),
            };
            let path = match operation.get("path") {
                Some(Value::String(path)) => Some(path.clone()),
                None => None,
                Some(_) => return Err(malformed("path: must be a string")),
            };
            Ok(Operation { verb, path, value: operation.get("value").cloned() })
        };
        operations.iter().map(read).collect::<Result<_, _>>().map(Self)
    }

    /// Applies the operations to a resource, in order.
    ///
    /// # Errors
    /// If a path or a value is invalid.
    pub fn apply(self, fields: &mut Object) -> Result<(), ScimError> {
        for Operation { verb, path, value } in self.0 {
            match path {
                Some(path) => apply_at(fields, verb, &AttributePath::parse(&path)?, value)?,
                None => {
                    let Some(Value::Object(values)) = value else {
                        return Err(ScimError::invalid("noTarget", "an operation without a path needs an object"));
                    };
                    for (path, value) in values {
                        apply_at(fields, verb, &AttributePath::parse(&path)?, Some(value))?;
                    }
                }
            }
        }
        Ok(())
    }
}

fn apply_at(fields: &mut Object, verb: Verb, path: &AttributePath, value: Option<Value>) -> Result<(), ScimError> {
    if verb != Verb::Remove && value.is_none() {
        return Err(ScimError::invalid("invalidValue", "value: required"));
    }
    let AttributePath { attribute, chosen, part } = path;
    match (chosen, part) {
        (None, None) => apply_to_attribute(fields, verb, attribute, value),
        (None, Some(part)) => {
            let found = fields.entry(attribute.clone()).or_insert_with(|| empty(attribute));
            match found {
                Value::Array(values) => {
                    if values.is_empty() && verb != Verb::Remove {
                        values.push(json!({}));
                    }
                    values.iter_mut().for_each(|one| set_part(one, verb, part, value.as_ref()));
                }
                one => set_part(one, verb, part, value.as_ref()),
            }
        }
        (Some(chosen), part) => {
            let found = fields.entry(attribute.clone()).or_insert_with(|| json!([]));
            let Value::Array(values) = found else {
                return Err(ScimError::invalid("invalidPath", format!("{attribute}: has a single value")));
            };
            apply_to_chosen(values, verb, chosen, part.as_deref(), value);
        }
    }
    // A list without values is an attribute without a value.
    if fields.get(attribute).is_some_and(|left| left.as_array().is_some_and(Vec::is_empty)) {
        fields.remove(attribute);
    }
    Ok(())
}

fn empty(attribute: &str) -> Value {
    if matches!(attribute, "emails" | "members") { json!([]) } else { json!({}) }
}

fn apply_to_attribute(fields: &mut Object, verb: Verb, attribute: &str, value: Option<Value>) {
    let listed = |value: Value| match value {
        Value::Array(values) => values,
        one => vec![one],
    };
    match (verb, fields.get_mut(attribute), value) {
        // Members are removed by a list of them, too.
        (Verb::Remove, Some(Value::Array(values)), Some(gone)) => {
            let gone = listed(gone);
            values.retain(|one| !gone.iter().any(|gone| is_same(one, gone)));
        }
        (Verb::Remove, _, _) => {
            fields.remove(attribute);
        }
        (Verb::Add, Some(Value::Array(values)), Some(new)) => {
            for new in listed(new) {
                values.retain(|one| !is_same(one, &new));
                if new.get("primary") == Some(&Value::Bool(true)) {
                    values.iter_mut().for_each(|one| one["primary"] = false.into());
                }
                values.push(new);
            }
        }
        (Verb::Add, Some(Value::Object(parts)), Some(Value::Object(new))) => parts.extend(new),
        (_, _, Some(new)) => {
            let new = if matches!(attribute, "emails" | "members") { Value::Array(listed(new)) } else { new };
            fields.insert(attribute.to_owned(), new);
        }
        (_, _, None) => {}
    }
}

/// Values of a list are the same if their `value` is.
fn is_same(one: &Value, other: &Value) -> bool {
    match (one.get("value"), other.get("value")) {
        (Some(one), Some(other)) => one == other,
        _ => one == other,
    }
}

fn apply_to_chosen(values: &mut Vec<Value>, verb: Verb, chosen: &Filter, part: Option<&str>, value: Option<Value>) {
    let is_chosen = |one: &Value| one.as_object().is_some_and(|fields| chosen.matches(fields));
    match (verb, part) {
        (Verb::Remove, None) => values.retain(|one| !is_chosen(one)),
        (Verb::Remove, Some(part)) => {
            values.iter_mut().filter(|one| is_chosen(one)).for_each(|one| set_part(one, verb, part, None));
        }
        (_, part) => {
            if !values.iter().any(is_chosen) {
                let fields = chosen.0.iter().map(|one| (one.attribute.clone(), one.value.clone()));
                values.push(Value::Object(fields.collect()));
            }
            let value = value.unwrap_or_default();
            for one in values.iter_mut().filter(|one| is_chosen(one)) {
                match (part, one.as_object_mut(), &value) {
                    (Some(part), _, value) => set_part(one, verb, part, Some(value)),
                    (None, Some(fields), Value::Object(new)) => fields.extend(new.clone()),
                    (None, _, _) => {}
                }
            }
        }
    }
}

fn set_part(one: &mut Value, verb: Verb, part: &str, value: Option<&Value>) {
    let Some(fields) = one.as_object_mut() else { return };
    match value.filter(|_| verb != Verb::Remove) {
        Some(value) => fields.insert(part.to_owned(), value.clone()),
        None => fields.remove(part),
    };
}
