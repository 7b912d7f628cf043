//! Translatable names of layers, structures and targets.
//!
//! A scene's author names them in one language. The names in the shipped scenes are translated; all
//! other names are the same in every language.

use phrase::{Phrase, phrase, sentence};

/// Names in the shipped scenes.
pub const SHIPPED_STRUCTURE_NAMES: [&str; 41] = [
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
    sentence!("introducer"),
    sentence!("anterior epidural space"),
    sentence!("ligament"),
    sentence!("kidney"),
    sentence!("calyx"),
    sentence!("incised skin"),
    sentence!("subcutaneous fat"),
    sentence!("preperitoneal fat"),
    sentence!("peritoneum"),
    sentence!("abdominal cavity"),
    sentence!("small bowel"),
    sentence!("cranial loop of bowel"),
    sentence!("caudal loop of bowel"),
    sentence!("aorta"),
    sentence!("vena cava"),
];

/// Returns the name of a layer or structure, translated if it is a shipped one, also with a number:
/// a body's second layer of the dura is `dura 2`.
#[must_use]
pub fn name_structure(name: &str) -> Phrase {
    let shipped = |name: &str| SHIPPED_STRUCTURE_NAMES.into_iter().find(|shipped| *shipped == name);
    let numbered = name.rsplit_once(' ').and_then(|(own, number)| Some((shipped(own)?, number.parse::<u32>().ok()?)));
    match (shipped(name), numbered) {
        (Some(name), _) => Phrase::sentence(name),
        (None, Some((own, number))) => {
            phrase!("{layer} {number}", layer = Phrase::sentence(own), number = f64::from(number))
        }
        (None, None) => Phrase::data(name),
    }
}
