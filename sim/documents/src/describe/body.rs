//! The keys of a scene's body.

use anatomy::{AGES_YEARS, WEIGHTS_KG};

use super::{DescribedField, DescribedTable, FieldKind, Text};

const INTERSPACE: DescribedField = DescribedField::new(
    "interspace",
    FieldKind::Choice(&["L1/2", "L2/3", "L3/4", "L4/5", "L5/S1"]),
    "Where the needle enters: the middle between two spinous processes, as palpated",
)
.required();
const POSTURE: DescribedField = DescribedField::new(
    "posture",
    FieldKind::Choice(&["prone", "sitting", "side"]),
    "Face down, sitting with the back bent, or on the side with the knees to the chest",
)
.required();
const SEED: DescribedField = DescribedField::new(
    "seed",
    FieldKind::Integer { min: 0, max: 1_000_000_000 },
    "Seed of the patient, among those of this weight and age",
)
.or(1.0);
const WEIGHT_KG: DescribedField =
    DescribedField::number("weight_kg", "kg", WEIGHTS_KG[0]..=WEIGHTS_KG[1], "Body weight").or(70.0);
const AGE_YEARS: DescribedField =
    DescribedField::number("age_years", "years", AGES_YEARS[0]..=AGES_YEARS[1], "Age").or(40.0);
const OFFSET_MM: DescribedField = DescribedField::new(
    "offset_mm",
    FieldKind::Vector { unit: "mm", len: 2, min: -60.0, max: 60.0 },
    "From there to where the needle enters, to the patient's right and to the head; 0 is the midline approach",
);

/// A body and where the needle enters it.
pub(super) static BODY: DescribedTable = DescribedTable {
    doc: "A lower back from parameters, and the place on its skin that is the scene's origin",
    fields: &[INTERSPACE, POSTURE, SEED, WEIGHT_KG, AGE_YEARS, OFFSET_MM],
};

/// A body that is converted to layers.
pub(super) static ANATOMY: DescribedTable = DescribedTable {
    doc: "A lower back from parameters: it is converted to layers, structures and a skin when the scene is read, and a \
         recording contains these",
    fields: &[
        INTERSPACE, POSTURE, SEED, WEIGHT_KG, AGE_YEARS, OFFSET_MM,
        DescribedField::number(
            "angle_deg",
            "°",
            0.0..=60.0,
            "Planned angle to the normal of the skin, along which the layers are measured; the exercise has the same",
        )
        .or(0.0),
        DescribedField::number(
            "azimuth_deg",
            "°",
            -360.0..=360.0,
            "Direction in which the needle is tilted: 0 to the patient's right, 90 to the head",
        )
        .or(0.0),
        DescribedField::number(
            "introducer_mm",
            "mm",
            0.0..=60.0,
            "Length along the planned needle of an introducer that is already in place: its tissue is felt no more. With scaling = 2",
        )
        .or(0.0),
        DescribedField::text(
            "goal",
            &Text::NAME,
            "Layer that the needle is to reach: a warning names the place where bone blocks the way to it; without a goal, the way through all layers",
        ),
        DescribedField::new(
            "parts",
            FieldKind::Texts(&Text::ID),
            "Parts included as structures, of those within 25 mm of the planned needle: bones, dura, vessels, kidneys; \
             all if left out",
        ),
    ],
};
