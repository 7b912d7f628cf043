//! Writes fitted layers into the text of a scene. Comments, order, needle and structures are
//! preserved.

use std::fmt::Write as _;
use std::ops::Range;

use law::axial::{AxialSpec, MaxwellBranch};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::DocumentError;
use crate::model::{Scene, SceneLayer};
use crate::source::Source;
use crate::walk;

/// Significant digits of written numbers; the fit is less precise, and the file stays readable.
const DIGITS: usize = 6;

/// A replacement in the text.
struct Edit {
    at: Range<usize>,
    with: String,
}

/// Returns the text of a scene with another id and the numbers of a law's layers, converted to the
/// reference needle. `source` becomes the source of each layer; a layer whose numbers do not change
/// keeps its own.
///
/// # Errors
/// If the text is not TOML.
pub fn rewrite_document(
    text: &str,
    scene: &Scene,
    spec: &AxialSpec,
    id: &str,
    source: &str,
) -> Result<String, DocumentError> {
    let parsed = Source::new("scene", text.as_bytes())?;
    let document = walk::parse_document(&parsed)?;
    let has_rim = scene.needle.tip_to_rim_mm > 0.0;
    let mut edits: Vec<Edit> = edit_document(&document, "id", &quoted_string(id)).into_iter().collect();
    if let Some(DeValue::Table(needle)) = rewrite_value(&document, "needle").map(Spanned::get_ref) {
        edits.extend(
            needle_numbers(scene, spec).into_iter().filter_map(|(key, value)| edit_document(needle, key, &value)),
        );
    }
    let layers = scene.layers.iter().zip(scene.layers_of(spec));
    for (table, (old, new)) in rewrite_tables(&document).zip(layers) {
        let numbers = rewrite_numbers(&new, has_rim);
        if numbers == rewrite_numbers(old, has_rim) {
            continue;
        }
        for (key, value) in numbers {
            edits.extend(edit_document(table, key, &value));
        }
        edits.extend(edit_document(table, "source", &quoted_string(source)));
    }
    edits.sort_by_key(|edit| std::cmp::Reverse(edit.at.start));
    let mut rewritten = text.to_owned();
    edits.into_iter().for_each(|edit| rewritten.replace_range(edit.at, &edit.with));
    Ok(rewritten)
}

/// Returns the needle's numbers that the fit has changed, formatted.
fn needle_numbers(scene: &Scene, spec: &AxialSpec) -> Vec<(&'static str, String)> {
    let (was, slid_mm) = (&scene.needle, spec.breakaway.map(|breakaway| breakaway.slid_m * 1e3));
    let presliding =
        ("presliding_stiffness_n_per_m", spec.presliding_stiffness_n_per_m, was.presliding_stiffness_n_per_m);
    let breakaway = slid_mm.zip(was.breakaway_mm).map(|(now, before)| ("breakaway_mm", now, before));
    let is_changed =
        |(_, now, before): &(&str, f64, f64)| rounded_number(*now).to_bits() != rounded_number(*before).to_bits();
    let numbers = [presliding].into_iter().chain(breakaway).filter(is_changed);
    numbers.map(|(key, now, _)| (key, format!("{:?}", rounded_number(now)))).collect()
}

/// Returns a layer's numbers that a fit sets, formatted. Includes the options that the layer has.
fn rewrite_numbers(layer: &SceneLayer, has_rim: bool) -> Vec<(&'static str, String)> {
    let rim = has_rim.then_some(("rim_rupture_n", layer.rim_rupture_n));
    let options = &layer.options;
    let stiffening =
        (options.stiffening_n_per_m2 > 0.0).then_some(("stiffening_n_per_m2", options.stiffening_n_per_m2));
    // A scene without damping keeps none: the fit does not estimate it.
    let damping = (layer.damping_n_s_per_m2 > 0.0).then_some(("damping_n_s_per_m2", layer.damping_n_s_per_m2));
    let sticking = options.static_friction_n_per_m.map(|value| ("static_friction_n_per_m", value));
    let branch = |branch: &MaxwellBranch| {
        format!("{{ share = {:?}, time_s = {:?} }}", rounded_number(branch.share), rounded_number(branch.time_s))
    };
    let branches: Vec<String> = options.relaxation.iter().map(branch).collect();
    let relaxation = (!branches.is_empty()).then(|| ("relaxation", format!("[{}]", branches.join(", "))));
    let numbers = [
        ("thickness_mm", layer.thickness_mm),
        ("stiffness_n_per_m", layer.stiffness_n_per_m),
        ("tip_rupture_n", layer.tip_rupture_n),
        ("friction_n_per_m", layer.friction_n_per_m),
        ("cutting_n", layer.cutting_n),
    ];
    let numbers = numbers.into_iter().chain(damping).chain(rim).chain(stiffening).chain(sticking);
    numbers.map(|(key, value)| (key, format!("{:?}", rounded_number(value)))).chain(relaxation).collect()
}

fn rewrite_tables<'d, 'i>(document: &'d DeTable<'i>) -> impl Iterator<Item = &'d DeTable<'i>> {
    let layers = rewrite_value(document, "layer").and_then(|layers| match layers.get_ref() {
        DeValue::Array(layers) => Some(layers),
        _ => None,
    });
    layers.into_iter().flat_map(|layers| layers.iter()).filter_map(|layer| match layer.get_ref() {
        DeValue::Table(table) => Some(table),
        _ => None,
    })
}

fn rewrite_value<'d, 'i>(table: &'d DeTable<'i>, key: &str) -> Option<&'d Spanned<DeValue<'i>>> {
    table.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
}

/// Returns an edit that replaces a value, or inserts a new key below the layer's name or the
/// needle's kind.
fn edit_document(table: &DeTable<'_>, key: &str, with: &str) -> Option<Edit> {
    if let Some(old) = rewrite_value(table, key) {
        return Some(Edit { at: old.span(), with: with.to_owned() });
    }
    let below = rewrite_value(table, "name").or_else(|| rewrite_value(table, "kind"))?.span().end;
    Some(Edit { at: below..below, with: format!("\n{key} = {with}") })
}

/// Rounds a number to [`DIGITS`] significant digits.
fn rounded_number(value: f64) -> f64 {
    let text = format!("{value:.*e}", DIGITS - 1);
    text.parse().unwrap_or(value)
}

/// Formats a single-line TOML string.
fn quoted_string(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                // Writing to a string cannot fail.
                let _ = write!(quoted, "\\u{:04x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
