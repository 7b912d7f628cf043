//! What relates the options of version 3 of the law to each other and to the rest of a scene.

use phrase::{Phrase, phrase};
use serde_json::Value;

use crate::describe::measure;
use crate::walk::Walked;

/// Keys of a layer that only version 3 has.
const LAYER_KEYS: [&str; 3] = ["stiffening_n_per_m2", "relaxation", "static_friction_n_per_m"];
/// Keys of a needle that only version 3 has.
const NEEDLE_KEYS: [&str; 2] = ["breakaway_mm", "friction_rest_s"];

/// Checks all of it.
pub(crate) fn check_options(doc: &mut Walked) {
    check_version(doc);
    check_rate(doc);
    check_static_friction(doc);
}

/// Options are refused where the law does not know them: a scene that named them in vain would be felt without them.
fn check_version(doc: &mut Walked) {
    let Some(law) = doc.value["law"].as_i64().filter(|law| *law < 3) else { return };
    let layers = doc.tables("layer").len();
    let of_layers = (0..layers).flat_map(|at| LAYER_KEYS.map(|key| format!("layer[{at}].{key}")));
    let fields: Vec<String> = of_layers.chain(NEEDLE_KEYS.map(|key| format!("needle.{key}"))).collect();
    for field in fields {
        if doc.is_written(&field) {
            let allowed = phrase!("allowed: nothing under version {law} of the force law; law = 3 has it", law = law);
            doc.refuse(&field, phrase!("an option of version 3"), allowed);
        }
    }
}

/// The threshold of a boundary that relaxes depends on speed by itself.
fn check_rate(doc: &mut Walked) {
    let relaxes = |layer: &Value| layer["relaxation"].as_array().is_some_and(|branches| !branches.is_empty());
    let Some(at) = doc.tables("layer").iter().position(relaxes) else { return };
    if doc.is_written("rate") {
        let allowed = phrase!(
            "allowed: one of both, for how a threshold depends on speed follows from relaxation; leave out rate or every relaxation"
        );
        doc.refuse("rate", phrase!("beside {field}", field = format!("layer[{at}].relaxation")), allowed);
    }
}

/// Static friction is no less than kinetic, and the needle says when it ends.
fn check_static_friction(doc: &mut Walked) {
    let layers = doc.tables("layer");
    let has_breakaway = doc.is_written("needle.breakaway_mm");
    let mut first = None;
    for (at, layer) in layers.iter().enumerate() {
        let field = format!("layer[{at}].static_friction_n_per_m");
        let Some(static_n_per_m) = layer["static_friction_n_per_m"].as_f64() else { continue };
        let kinetic_n_per_m = layer["friction_n_per_m"].as_f64().unwrap_or_default();
        if static_n_per_m < kinetic_n_per_m {
            let allowed = phrase!(
                "allowed: at least {kinetic} N/m, the friction that is left once the shaft slides",
                kinetic = kinetic_n_per_m
            );
            doc.refuse(&field, Phrase::Data(measure(static_n_per_m, "N/m")), allowed);
        }
        first = first.or(Some(field));
    }
    match first {
        Some(field) if !has_breakaway => {
            let allowed =
                phrase!("needed with {field}: the slid length in mm after which friction is kinetic", field = field);
            doc.refuse("needle.breakaway_mm", phrase!("missing"), allowed);
        }
        None if has_breakaway => {
            let found = doc.value["needle"]["breakaway_mm"].as_f64().unwrap_or_default();
            let allowed = phrase!("allowed: nothing, for no layer has static_friction_n_per_m");
            doc.refuse("needle.breakaway_mm", Phrase::Data(measure(found, "mm")), allowed);
        }
        _ => {}
    }
}
