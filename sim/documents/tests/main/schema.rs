//! The JSON Schemas: shipped documents validate, and what the reader refuses on a single field the schema refuses too.
//!
//! Would fail if the schema and the reader drifted apart.

use documents::load::{Document, read_document};
use documents::{DocumentKind, document_schema};
use jsonschema::Validator;
use serde_json::Value;

use crate::support::{EXERCISE, INSTRUMENT, SCENE, folder, read_text, shipped};

fn validator(kind: DocumentKind) -> Validator {
    let schema = document_schema(kind);
    jsonschema::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

fn json(toml: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Table>(toml).unwrap()).unwrap()
}

#[test]
fn every_shipped_document_validates() {
    for path in shipped() {
        let kind = match read_document(&path).unwrap() {
            Document::Scene(_) => DocumentKind::Scene,
            Document::Exercise(_) => DocumentKind::Exercise,
            Document::Curriculum(..) => DocumentKind::Curriculum,
            Document::Instrument(_) => DocumentKind::Instrument,
        };
        let document = json(&std::fs::read_to_string(&path).unwrap());
        let errors: Vec<_> = validator(kind).iter_errors(&document).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{}: {errors:?}", path.display());
    }
}

#[test]
fn what_the_reader_refuses_on_a_field_the_schema_refuses_too() {
    let mutations = [
        (DocumentKind::Scene, SCENE, "thickness_mm = 8.4", "thickness_m = 0.0084"),
        (DocumentKind::Scene, SCENE, "thickness_mm = 8.4", "thickness_mm = -8.4"),
        (DocumentKind::Scene, SCENE, "thickness_mm = 8.4", "thickness_mm = \"8.4\""),
        (DocumentKind::Scene, SCENE, "name = \"fat\"\n", ""),
        (DocumentKind::Scene, SCENE, "name = \"fat\"", "name = \"f.at\""),
        (DocumentKind::Scene, SCENE, "id = \"small\"", "id = \"-small\""),
        (DocumentKind::Scene, SCENE, "diameter_mm = 2.0", "tip = \"sharp\""),
        (DocumentKind::Scene, SCENE, "diameter_mm = 2.0", "flexible = 1"),
        (DocumentKind::Exercise, EXERCISE, "depth_mm = 20", "depth_mm = 0"),
        (DocumentKind::Exercise, EXERCISE, "zero = 4", "zero = 4\nweight = 0"),
        (DocumentKind::Instrument, INSTRUMENT, "points = 5", "points = 1"),
        (DocumentKind::Instrument, INSTRUMENT, "licence = ", "license = "),
        (DocumentKind::Instrument, INSTRUMENT, "combine = \"sum\"", "combine = \"median\""),
        (DocumentKind::Exercise, EXERCISE, "title", "difficulty = 1.5\ntitle"),
        (DocumentKind::Exercise, EXERCISE, "zero = 4", "zero = 4\nversion = 0"),
        (DocumentKind::Exercise, EXERCISE, "[target]", "[required]\nwithdrawn = \"yes\"\n[target]"),
        (DocumentKind::Exercise, EXERCISE, "[target]", "[required]\nwithin_mm = -1\n[target]"),
        (DocumentKind::Exercise, EXERCISE, "[target]", "[entry]\npoint_mm = [1]\n[target]"),
    ];
    for (kind, text, from, to) in mutations {
        assert!(text.contains(from), "{from}");
        let mutated = text.replacen(from, to, 1);
        assert!(read_text(&folder(), &mutated).is_err(), "the reader accepts {to}");
        assert!(validator(kind).is_valid(&json(text)), "the schema refuses the document as it stands");
        assert!(!validator(kind).is_valid(&json(&mutated)), "the schema accepts {to}");
    }
}

#[test]
fn the_schema_gives_unit_range_and_default() {
    let schema = document_schema(DocumentKind::Scene);
    let diameter = &schema["properties"]["needle"]["properties"]["diameter_mm"];
    assert_eq!((diameter["minimum"].as_f64(), diameter["maximum"].as_f64()), (Some(0.1), Some(15.0)));
    assert_eq!(diameter["default"].as_f64(), Some(2.0));
    assert!(diameter["description"].as_str().unwrap().contains("in mm"));
}
