//! What relates the options of version 3 of the law to each other and to the rest of a scene.

use phrase::{Phrase, phrase};
use serde_json::Value;

use crate::describe::measure;
use crate::walk::Walked;

/// Keys of a layer that only version 3 has.
const LAYER_KEYS: [&str; 6] = [
    "stiffening_n_per_m2",
    "relaxation",
    "gives_way_at",
    "static_friction_n_per_m",
    "fracture_energy_j_per_m2",
    "fibres",
];
/// Keys of a needle that only version 3 has.
const NEEDLE_KEYS: [&str; 2] = ["breakaway_mm", "friction_rest_s"];

/// Checks all of it.
pub(crate) fn check_options(doc: &mut Walked) {
    check_version(doc);
    check_rate(doc);
    check_criterion(doc);
    check_static_friction(doc);
    check_fracture(doc);
    check_fibres(doc);
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

fn relaxes(layer: &Value) -> bool {
    layer["relaxation"].as_array().is_some_and(|branches| !branches.is_empty())
}

/// What gives way at a dent differs from what gives way at a force by its branches alone.
fn check_criterion(doc: &mut Walked) {
    let in_vain = |layer: &Value| layer["gives_way_at"] == "dent" && !relaxes(layer);
    let Some(at) = doc.tables("layer").iter().position(in_vain) else { return };
    let allowed =
        phrase!("allowed: \"force\" without relaxation, for a boundary that does not relax has one dent at one force");
    doc.refuse(&format!("layer[{at}].gives_way_at"), Phrase::Data("\"dent\"".to_owned()), allowed);
}

/// How a boundary that relaxes depends on speed follows from its branches.
fn check_rate(doc: &mut Walked) {
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

/// The tip's threshold is written or follows from the fracture energy, which takes a modulus and a sharp tip.
fn check_fracture(doc: &mut Walked) {
    let is_blunt = doc.value["needle"]["tip"] == "blunt";
    for (at, layer) in doc.tables("layer").iter().enumerate() {
        let is_written = |key: &str| doc.is_written(&format!("layer[{at}].{key}"));
        let fields = ["tip_rupture_n", "fracture_energy_j_per_m2", "youngs_modulus_pa"];
        let [has_threshold, has_fracture, has_modulus] = fields.map(is_written);
        let [threshold, fracture, modulus] = fields.map(|key| format!("layer[{at}].{key}"));
        if !has_threshold && !has_fracture {
            let allowed =
                phrase!("allowed: a number from 0 to 100 N; or fracture_energy_j_per_m2, that it follows from");
            doc.refuse(&threshold, phrase!("missing"), allowed);
        }
        let Some(energy) = layer["fracture_energy_j_per_m2"].as_f64() else { continue };
        if has_threshold {
            let allowed = phrase!("allowed: one of both, for the threshold follows from the fracture energy");
            doc.refuse(&fracture, phrase!("beside {field}", field = threshold), allowed);
        }
        if !has_modulus {
            let allowed = phrase!("needed with {field}: Young's modulus in Pa", field = fracture.as_str());
            doc.refuse(&modulus, phrase!("missing"), allowed);
        }
        if is_blunt {
            let allowed =
                phrase!("allowed: nothing under a blunt tip, which tears instead of slitting; tip_rupture_n says when");
            doc.refuse(&fracture, Phrase::Data(measure(energy, "J/m²")), allowed);
        }
    }
}

/// Fibres ask for an edge, and for a stiffness of their own to add the tension to.
fn check_fibres(doc: &mut Walked) {
    let tip = doc.value["needle"]["tip"].as_str().unwrap_or_default().to_owned();
    let is_coupled = doc.value["tissue"]["coupling"] == "field";
    for (at, layer) in doc.tables("layer").iter().enumerate() {
        if !layer["fibres"].is_object() {
            continue;
        }
        if tip != "bevel" {
            let allowed = phrase!("allowed: nothing under this tip, for only tip = \"bevel\" has one edge to turn");
            doc.refuse(&format!("layer[{at}].fibres"), Phrase::data(format!("tip = \"{tip}\"")), allowed);
        }
        let tension = layer["fibres"]["pretension_n_per_m"].as_f64().unwrap_or_default();
        if is_coupled && tension > 0.0 {
            let allowed = phrase!("allowed: 0 N/m with coupling = \"field\", for the field knows no tension");
            doc.refuse(
                &format!("layer[{at}].fibres.pretension_n_per_m"),
                Phrase::Data(measure(tension, "N/m")),
                allowed,
            );
        }
    }
}
