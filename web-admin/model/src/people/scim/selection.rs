//! Which attributes an answer contains (RFC 7644, section 3.4.2.5).

use serde_json::Value;

use super::{Object, standard_name};

/// Attributes that are always returned.
const ALWAYS: [&str; 2] = ["schemas", "id"];

/// The attributes that a client asks for, or those that it does not want.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    only: Option<Vec<String>>,
    without: Vec<String>,
}

fn names(list: &str) -> Vec<String> {
    let name = |name: &str| {
        let name = name.trim();
        let name =
            if name.to_ascii_lowercase().starts_with("urn:") { name.rsplit(':').next().unwrap_or(name) } else { name };
        name.split('.').map(standard_name).collect::<Vec<_>>().join(".")
    };
    list.split(',').map(name).filter(|name| !name.is_empty()).collect()
}

impl Selection {
    /// Parses the parameters `attributes` and `excludedAttributes`.
    #[must_use]
    pub fn parse(only: Option<&str>, without: Option<&str>) -> Self {
        Self { only: only.filter(|list| !list.is_empty()).map(names), without: without.map(names).unwrap_or_default() }
    }

    /// Removes what was not asked for.
    #[must_use]
    pub fn of(&self, mut fields: Object) -> Object {
        fields.retain(|name, value| {
            if ALWAYS.contains(&name.as_str()) {
                return true;
            }
            let parts_in = |list: &[String]| -> Vec<String> {
                let prefix = format!("{name}.");
                list.iter().filter_map(|one| one.strip_prefix(&prefix)).map(str::to_owned).collect()
            };
            if let Some(only) = &self.only
                && !only.contains(name)
            {
                let parts = parts_in(only);
                if parts.is_empty() {
                    return false;
                }
                keep_parts(value, &|part| parts.iter().any(|one| one == part));
            }
            let parts = parts_in(&self.without);
            keep_parts(value, &|part| !parts.iter().any(|one| one == part));
            !self.without.contains(name)
        });
        fields
    }
}

fn keep_parts(value: &mut Value, is_kept: &dyn Fn(&str) -> bool) {
    match value {
        Value::Object(parts) => parts.retain(|name, _| is_kept(name)),
        Value::Array(values) => values.iter_mut().for_each(|one| keep_parts(one, is_kept)),
        _ => {}
    }
}
