//! Provenance of a layer's numbers: measured, derived from a measurement, or chosen.

use phrase::{Phrase, phrase};
use serde::Serialize;
use serde_json::Value;

use crate::error::Remark;
use crate::model::{NUMBERS, NumberClass, NumberProvenance, Scene, SceneLayer};
use crate::walk::Walked;

/// Numbers of a scene by class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ClassCounts {
    /// Measured numbers.
    pub measured: usize,
    /// Derived numbers.
    pub derived: usize,
    /// Choices; a number without provenance is one.
    pub choices: usize,
}

impl SceneLayer {
    /// Returns the class of a number, a choice if nothing is stated.
    fn class_of(&self, key: &str) -> NumberClass {
        self.provenance.iter().find(|number| number.key == key).map_or(NumberClass::Choice, |number| number.class)
    }
}

impl Scene {
    /// Counts the layers' numbers by class. A number that is 0 has no effect and is not counted.
    #[must_use]
    pub fn count_classes(&self) -> ClassCounts {
        let mut counts = ClassCounts::default();
        for layer in &self.layers {
            for (key, _) in NUMBERS.into_iter().filter(|(_, number)| number(layer) > 0.0) {
                match layer.class_of(key) {
                    NumberClass::Measured => counts.measured += 1,
                    NumberClass::Derived => counts.derived += 1,
                    NumberClass::Choice => counts.choices += 1,
                }
            }
        }
        counts
    }

    /// Lists the numbers that leave the range stated in their provenance.
    #[must_use]
    pub fn list_departed_numbers(&self) -> Vec<Remark> {
        let layers = self.layers.iter().enumerate();
        let numbers = layers.flat_map(|(at, layer)| layer.provenance.iter().map(move |number| (at, layer, number)));
        let departed = numbers.filter_map(|(at, layer, NumberProvenance { key, low, high, .. })| {
            let (_, number) = NUMBERS.iter().find(|(known, _)| known == key)?;
            let value = number(layer);
            let (low, high) = (low.unwrap_or(f64::MIN), high.unwrap_or(f64::MAX));
            let is_inside = (low..=high).contains(&value);
            (!is_inside).then(|| Remark {
                field: format!("layer[{at}].{key}"),
                found: phrase!("{value} leaves its published range", value = value),
                allowed: phrase!("published: {low} to {high}", low = low, high = high),
            })
        });
        departed.collect()
    }
}

/// Checks that each number is named once, and that a measured one states its range.
pub(crate) fn check_provenance(doc: &mut Walked) {
    for (at, layer) in doc.tables("layer").into_iter().enumerate() {
        let numbers = layer["provenance"].as_array().cloned().unwrap_or_default();
        for (index, number) in numbers.iter().enumerate() {
            let place = |key: &str| format!("layer[{at}].provenance[{index}].{key}");
            let is_twice = numbers[..index].iter().any(|other| other["key"] == number["key"]);
            if is_twice {
                let found = Phrase::data(number["key"].as_str().unwrap_or_default());
                doc.refuse(&place("key"), found, phrase!("allowed: each number once"));
            }
            refuse_range(doc, &place, number);
        }
    }
}

/// Refuses a measured number without a range, and a range whose ends are exchanged.
fn refuse_range(doc: &mut Walked, place: &dyn Fn(&str) -> String, number: &Value) {
    let [low, high] = ["low", "high"].map(|key| number[key].as_f64());
    for (key, end) in [("low", low), ("high", high)] {
        if number["class"] == "measured" && end.is_none() {
            let allowed = phrase!("needed by a measured number: the ends of its published range");
            doc.refuse(&place(key), phrase!("missing"), allowed);
        }
    }
    if let Some((low, high)) = low.zip(high).filter(|(low, high)| low > high) {
        let allowed = phrase!("allowed: at most high, {high}", high = high);
        doc.refuse(&place("low"), Phrase::data(low.to_string()), allowed);
    }
}
