//! Checks the options of version 3 of the law against each other and against the rest of a scene.

use phrase::{Phrase, phrase};
use serde_json::Value;

use crate::describe::measure;
use crate::walk::Walked;

/// Keys of a layer that require version 3.
const LAYER_KEYS: [&str; 6] = [
    "stiffening_n_per_m2",
    "relaxation",
    "gives_way_at",
    "static_friction_n_per_m",
    "fracture_energy_j_per_m2",
    "fibres",
];
/// Keys of a needle that require version 3.
const NEEDLE_KEYS: [&str; 2] = ["breakaway_mm", "friction_rest_s"];

/// Runs all checks.
pub(crate) fn check_options(doc: &mut Walked) {
    check_version(doc);
    check_rate(doc);
    check_criterion(doc);
    check_static_friction(doc);
    check_fracture(doc);
    check_fibres(doc);
}

/// Refuses options that the law's version does not support; otherwise they would be silently
/// ignored.
fn check_version(doc: &mut Walked) {
    let Some(law) = doc.value["law"].as_i64().filter(|law| *law < 3) else { return };
    let layers = doc.tables("layer").len();
    let of_layers = (0..layers).flat_map(|at| LAYER_KEYS.map(|key| format!("layer[{at}].{key}")));
    let fields: Vec<String> = of_layers.chain(NEEDLE_KEYS.map(|key| format!("needle.{key}"))).collect();
    for field in fields {
        if doc.is_written(&field) {
            let allowed = phrase!("allowed from law = 3; this scene has version {law} of the force law", law = law);
            doc.refuse(&field, phrase!("an option of version 3"), allowed);
        }
    }
}

fn relaxes(layer: &Value) -> bool {
    layer["relaxation"].as_array().is_some_and(|branches| !branches.is_empty())
}

/// Refuses "dent" without relaxation: the two criteria differ only if the boundary relaxes.
fn check_criterion(doc: &mut Walked) {
    let in_vain = |layer: &Value| layer["gives_way_at"] == "dent" && !relaxes(layer);
    let Some(at) = doc.tables("layer").iter().position(in_vain) else { return };
    let allowed = phrase!(
        "allowed: \"force\" without relaxation, because a boundary that does not relax has one dent at each force"
    );
    doc.refuse(&format!("layer[{at}].gives_way_at"), Phrase::Data("\"dent\"".to_owned()), allowed);
}

/// Refuses `rate` together with relaxation: the branches already determine the speed dependence.
fn check_rate(doc: &mut Walked) {
    let Some(at) = doc.tables("layer").iter().position(relaxes) else { return };
    if doc.is_written("rate") {
        let allowed = phrase!(
            "allowed: only one of the two, because relaxation already makes a threshold depend on speed; remove rate \
             or every relaxation"
        );
        doc.refuse("rate", phrase!("together with {field}", field = format!("layer[{at}].relaxation")), allowed);
    }
}

/// Checks that static friction is at least kinetic friction, and that the needle defines when it
/// ends.
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
                "allowed: at least {kinetic} N/m, the friction that remains once the shaft slides",
                kinetic = kinetic_n_per_m
            );
            doc.refuse(&field, Phrase::Data(measure(static_n_per_m, "N/m")), allowed);
        }
        first = first.or(Some(field));
    }
    match first {
        Some(field) if !has_breakaway => {
            let allowed = phrase!(
                "needed with {field}: the sliding distance in mm after which friction is kinetic",
                field = field
            );
            doc.refuse("needle.breakaway_mm", phrase!("missing"), allowed);
        }
        None if has_breakaway => {
            let found = doc.value["needle"]["breakaway_mm"].as_f64().unwrap_or_default();
            let allowed = phrase!("allowed only if a layer has static_friction_n_per_m");
            doc.refuse("needle.breakaway_mm", Phrase::Data(measure(found, "mm")), allowed);
        }
        _ => {}
    }
}

/// Checks that the tip's threshold is given or derived from a fracture energy, which requires a
/// modulus and a sharp tip.
fn check_fracture(doc: &mut Walked) {
    let is_blunt = doc.value["needle"]["tip"] == "blunt";
    for (at, layer) in doc.tables("layer").iter().enumerate() {
        let is_written = |key: &str| doc.is_written(&format!("layer[{at}].{key}"));
        let fields = ["tip_rupture_n", "fracture_energy_j_per_m2", "youngs_modulus_pa"];
        let [has_threshold, has_fracture, has_modulus] = fields.map(is_written);
        let [threshold, fracture, modulus] = fields.map(|key| format!("layer[{at}].{key}"));
        if !has_threshold && !has_fracture {
            let allowed =
                phrase!("allowed: a number from 0 to 100 N; or fracture_energy_j_per_m2, from which it follows");
            doc.refuse(&threshold, phrase!("missing"), allowed);
        }
        let Some(energy) = layer["fracture_energy_j_per_m2"].as_f64() else { continue };
        if has_threshold {
            let allowed =
                phrase!("allowed: only one of the two, because the threshold follows from the fracture energy");
            doc.refuse(&fracture, phrase!("together with {field}", field = threshold), allowed);
        }
        if !has_modulus {
            let allowed = phrase!("needed with {field}: Young's modulus in Pa", field = fracture.as_str());
            doc.refuse(&modulus, phrase!("missing"), allowed);
        }
        if is_blunt {
            let allowed =
                phrase!("allowed only with a sharp tip: a blunt one tears instead of slitting, at tip_rupture_n");
            doc.refuse(&fracture, Phrase::Data(measure(energy, "J/m²")), allowed);
        }
    }
}

/// Checks fibres: they require an edge and, for pretension, a boundary stiffness that the field
/// does not set.
fn check_fibres(doc: &mut Walked) {
    let tip = doc.value["needle"]["tip"].as_str().unwrap_or_default().to_owned();
    let is_coupled = doc.value["tissue"]["coupling"] == "field";
    for (at, layer) in doc.tables("layer").iter().enumerate() {
        if !layer["fibres"].is_object() {
            continue;
        }
        if !["bevel", "tuohy"].contains(&tip.as_str()) {
            let allowed = phrase!("allowed only with tip = \"bevel\" or \"tuohy\", the tips with a single edge");
            doc.refuse(&format!("layer[{at}].fibres"), Phrase::data(format!("tip = \"{tip}\"")), allowed);
        }
        let tension = layer["fibres"]["pretension_n_per_m"].as_f64().unwrap_or_default();
        if is_coupled && tension > 0.0 {
            let allowed = phrase!("allowed: 0 N/m with coupling = \"field\", because the field does not model tension");
            doc.refuse(
                &format!("layer[{at}].fibres.pretension_n_per_m"),
                Phrase::Data(measure(tension, "N/m")),
                allowed,
            );
        }
    }
}
