//! Translates the names of layers, structures and targets from scenes into the reader's language.
//!
//! A scene's author names them in one language. The names used in the shipped scenes have
//! translations; any other name is shown unchanged.

use std::collections::BTreeMap;

use attempt::{AttemptCurve, BoundaryStage, MarkKind};
use documents::{SHIPPED_STRUCTURE_NAMES, name_structure};
use law::axial::Contactor;
use words::Language;

/// Returns the name of a layer, structure or target in the reader's language.
#[must_use]
pub fn say_structure(name: &str) -> String {
    words::phrase(&name_structure(name))
}

/// Returns the curve with its layers, events and structures named in the reader's language.
#[must_use]
pub fn name_layers_of_curve(curve: &AttemptCurve) -> AttemptCurve {
    let mut curve = curve.clone();
    curve.bands.iter_mut().for_each(|band| band.name = say_structure(&band.name));
    curve.marks.iter_mut().for_each(|mark| mark.name = say_structure(&mark.name));
    curve
}

/// Describes an event on the curve.
#[must_use]
pub fn say_event(kind: MarkKind, name: &str) -> String {
    match kind {
        MarkKind::TipRupture => words::phrase(&Contactor::Tip.into_layer(name)),
        MarkKind::RimRupture => words::phrase(&Contactor::Rim.into_layer(name)),
        MarkKind::StructureHit => tr!("hit {name}", name = name),
        MarkKind::Confirm => tr!("position confirmed").to_owned(),
        MarkKind::Contact => tr!("skin touched").to_owned(),
        MarkKind::HubContact => tr!("hub at the skin").to_owned(),
        MarkKind::SkinExit => tr!("needle out").to_owned(),
    }
}

/// Describes a stage of a boundary.
#[must_use]
pub fn stage_meaning(stage: BoundaryStage) -> &'static str {
    match stage {
        BoundaryStage::I => tr!("the tip presses the boundary in"),
        BoundaryStage::II => tr!("the tip is through, the rim not yet there"),
        BoundaryStage::III => tr!("the rim presses the boundary in"),
        BoundaryStage::IV => tr!("the rim is through"),
    }
}

/// Returns the translations of the shipped names for scripts, as a JSON object from the scene's
/// name to the reader's; empty in English, where both are the same.
#[must_use]
pub fn names_for_scripts() -> String {
    let names = SHIPPED_STRUCTURE_NAMES.into_iter().filter(|_| words::current() != Language::ENGLISH);
    let names: BTreeMap<&str, &str> = names.map(|name| (name, words::say(name))).collect();
    // A map of strings always serializes.
    serde_json::to_string(&names).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    //! Shipped names are translated; a school's own names stay unchanged.

    use super::*;

    #[test]
    fn known_names_are_said_and_others_left() {
        let german = Language::named("de").expect("German");
        let names = words::within(german, || [say_structure("skin"), say_structure("my own layer")]);
        assert_eq!(names, ["Haut", "my own layer"]);
        assert_eq!(say_structure("skin"), "skin");
        assert!(words::within(german, names_for_scripts).contains("\"fat\":\"Fett\""));
        assert_eq!(names_for_scripts(), "{}");
    }
}
