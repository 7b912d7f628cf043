//! JSON Schema (draft 2020-12) of a document, derived from the description that its reader uses.

use serde_json::{Map, Value, json};

use crate::describe::{
    CURRICULUM, DescribedField, DescribedTable, EXERCISE, FieldKind, INSTRUMENT, Presence, SCENE, Text,
};
use crate::load::DocumentKind;

/// Returns the schema of a kind of document.
///
/// It covers single fields. Relations between fields or files (unique names, metric ids, cycles,
/// sound thresholds) are checked only by `stylet check`.
#[must_use]
pub fn document_schema(kind: DocumentKind) -> Value {
    let (name, description) = match kind {
        DocumentKind::Scene => ("scene", &SCENE),
        DocumentKind::Exercise => ("exercise", &EXERCISE),
        DocumentKind::Curriculum => ("curriculum", &CURRICULUM),
        DocumentKind::Instrument => ("instrument", &INSTRUMENT),
    };
    let mut schema = table_schema(description);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(format!("Stylet {name}"));
    schema
}

fn table_schema(table: &DescribedTable) -> Value {
    let required: Vec<_> =
        table.fields.iter().filter(|f| matches!(f.presence, Presence::Required)).map(|f| f.key).collect();
    let properties: Map<_, _> = table.fields.iter().map(|f| (f.key.to_owned(), field_schema(f))).collect();
    json!({
        "type": "object",
        "description": table.doc,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

fn field_schema(field: &DescribedField) -> Value {
    let mut schema = kind_schema(&field.kind);
    schema["description"] = match field.unit() {
        "" => json!(format!("{}.", field.doc)),
        unit => json!(format!("{}; in {unit}.", field.doc)),
    };
    match field.presence {
        Presence::Number(n) if matches!(field.kind, FieldKind::Integer { .. }) => schema["default"] = json!(n as i64),
        Presence::Number(n) => schema["default"] = json!(n),
        Presence::Text(t) => schema["default"] = json!(t),
        Presence::Flag(f) => schema["default"] = json!(f),
        Presence::Required | Presence::Optional | Presence::Empty => {}
    }
    schema
}

fn kind_schema(kind: &FieldKind) -> Value {
    match kind {
        FieldKind::Number { min, max, .. } => range_schema(*min, *max),
        FieldKind::Integer { min, max } => json!({"type": "integer", "minimum": min, "maximum": max}),
        FieldKind::Flag => json!({"type": "boolean"}),
        FieldKind::Text(form) => schema_text(form),
        FieldKind::Words { text, table } => json!({"anyOf": [schema_text(text), table_schema(table)]}),
        FieldKind::Choice(words) => json!({"enum": words}),
        FieldKind::Vector { len, min, max, .. } => {
            json!({"type": "array", "items": range_schema(*min, *max), "minItems": len, "maxItems": len})
        }
        FieldKind::Texts(form) => json!({"type": "array", "items": schema_text(form)}),
        FieldKind::Table(inner) => table_schema(inner),
        FieldKind::Tables { table: inner, min, max } => {
            json!({"type": "array", "items": table_schema(inner), "minItems": min, "maxItems": max})
        }
    }
}

fn range_schema(min: f64, max: f64) -> Value {
    json!({"type": "number", "minimum": min, "maximum": max})
}

fn schema_text(form: &Text) -> Value {
    let mut schema = json!({"type": "string", "minLength": form.min, "maxLength": form.max});
    if !form.pattern.is_empty() {
        schema["pattern"] = json!(form.pattern);
    }
    schema
}
