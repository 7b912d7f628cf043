//! The fields of a curriculum.

use super::{DescribedField, DescribedTable, FieldKind, Presence, Text};

/// A curriculum.
pub(crate) static CURRICULUM: DescribedTable = DescribedTable {
    doc: "A curriculum: exercises in order, their prerequisites, and the rule of mastery",
    fields: &[
        DescribedField::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision")
            .required(),
        DescribedField::said_line("title", "Title shown to people").required(),
        DescribedField::languages(),
        DescribedField::said_prose("description", "Learning objective").or_text(""),
        DescribedField::new("mastery", FieldKind::Table(&MASTERY), "When an exercise is mastered").required(),
        DescribedField::new("exercise", FieldKind::Tables { table: &ENTRY, min: 1, max: 200 }, "Exercises in order")
            .required(),
    ],
};

static MASTERY: DescribedTable = DescribedTable {
    doc: "passes of the last attempts, or a CUSUM or LC-CUSUM over passes and failures",
    fields: &[
        DescribedField::new("rule", FieldKind::Choice(&["passes", "cusum", "lc-cusum"]), "The rule").required(),
        DescribedField::new("passes", FieldKind::Integer { min: 1, max: 100 }, "Rule passes: number of passes"),
        DescribedField::new(
            "of",
            FieldKind::Integer { min: 1, max: 100 },
            "Rule passes: among this many latest attempts",
        ),
        DescribedField::number("p0", "", 0.001..=0.999, "Rules cusum, lc-cusum: acceptable failure rate"),
        DescribedField::number("p1", "", 0.001..=0.999, "Rules cusum, lc-cusum: unacceptable failure rate, above p0"),
        DescribedField::number(
            "alpha",
            "",
            0.001..=0.5,
            "Rules cusum, lc-cusum: type I error; for lc-cusum, calling a trainee competent who fails at p1",
        ),
        DescribedField::number("beta", "", 0.001..=0.5, "Rules cusum, lc-cusum: type II error"),
        DescribedField::new(
            "within",
            FieldKind::Integer { min: 10, max: 200 },
            "Rule lc-cusum: attempts within which alpha holds; 50 if left out",
        ),
    ],
};

static ENTRY: DescribedTable = DescribedTable {
    doc: "An exercise of the curriculum",
    fields: &[
        DescribedField::text("file", &Text::LINE, "Exercise document, relative to this one").required(),
        DescribedField::new("prerequisites", FieldKind::Texts(&Text::ID), "Ids of exercises to master first")
            .with(Presence::Empty),
        DescribedField::text("survey", &Text::ID, "Id of the instrument shown after each attempt"),
    ],
};
