//! Translatable names of layers, structures and targets.
//!
//! A scene's author names them in one language. The names in the shipped scenes are translated; all
//! other names are the same in every language.

use phrase::{Phrase, sentence};

/// Names in the shipped scenes.
pub const SHIPPED_STRUCTURE_NAMES: [&str; 26] = [
    sentence!("skin"),
    sentence!("fat"),
    sentence!("fascia"),
    sentence!("muscle"),
    sentence!("supraspinous ligament"),
    sentence!("interspinous ligament"),
    sentence!("ligamentum flavum"),
    sentence!("epidural space"),
    sentence!("dura"),
    sentence!("liver capsule"),
    sentence!("liver"),
    sentence!("outer sheet"),
    sentence!("second sheet"),
    sentence!("third sheet"),
    sentence!("inner sheet"),
    sentence!("transverse process"),
    sentence!("lumbar vessel"),
    sentence!("target"),
    sentence!("deep fat"),
    sentence!("cerebrospinal fluid"),
    sentence!("dural sac"),
    sentence!("lumbar vessels"),
    sentence!("vertebra L2"),
    sentence!("vertebra L3"),
    sentence!("vertebra L4"),
    sentence!("vertebra L5"),
];

/// Returns the name of a layer or structure, translated if it is a shipped one.
#[must_use]
pub fn name_structure(name: &str) -> Phrase {
    let shipped = SHIPPED_STRUCTURE_NAMES.into_iter().find(|shipped| *shipped == name);
    shipped.map_or_else(|| Phrase::data(name), Phrase::sentence)
}
