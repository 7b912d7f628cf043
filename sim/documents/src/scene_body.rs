//! The body of a scene and the place where the needle enters it.

use anatomy::{Body, BodyEntry, BodyOrder, Level, Posture};
use phrase::Phrase;
use serde::Deserialize;
use toml::{Table, Value};

/// A body from parameters, and the place on its skin that is the scene's origin.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SceneBody {
    /// Interspace where the needle enters, as palpated: L1/2 to L5/S1.
    pub interspace: String,
    /// Posture: prone, sitting or side.
    pub posture: String,
    /// Seed of the patient.
    pub seed: u64,
    /// Body weight, in kg.
    pub weight_kg: f64,
    /// Age, in years.
    pub age_years: f64,
    /// From the interspace to the entry, to the patient's right and to the head, in mm.
    #[serde(default)]
    pub offset_mm: [f64; 2],
}

impl SceneBody {
    /// The body as a table of a document.
    pub(crate) fn table(&self) -> Table {
        let Self { interspace, posture, seed, weight_kg, age_years, offset_mm } = self.clone();
        let values = [
            ("interspace", Value::String(interspace)),
            ("posture", Value::String(posture)),
            ("seed", Value::Integer(seed.cast_signed())),
            ("weight_kg", Value::Float(weight_kg)),
            ("age_years", Value::Float(age_years)),
            ("offset_mm", Value::Array(offset_mm.map(Value::Float).to_vec())),
        ];
        values.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
    }

    /// Builds the body and enters it.
    ///
    /// # Errors
    /// If no body has these numbers.
    pub fn enter(&self) -> Result<(Body, BodyEntry), Phrase> {
        let posture = Posture::named(&self.posture).unwrap_or(Posture::Prone);
        let level = Level::above(&self.interspace).unwrap_or(Level::L3);
        let Self { seed, weight_kg, age_years, .. } = *self;
        let body = Body::new(&BodyOrder { posture, seed, weight_kg, age_years })?;
        let [right_mm, head_mm] = self.offset_mm;
        let entry = body.enter(level, right_mm / 1e3, head_mm / 1e3);
        Ok((body, entry))
    }
}
