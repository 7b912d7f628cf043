//! The fields of a curriculum.

use super::{Field, Kind, Presence, Table, Text};

/// A curriculum.
pub(crate) static CURRICULUM: Table = Table {
    doc: "A curriculum: exercises in order, what must be mastered first, and when an exercise is mastered",
    fields: &[
        Field::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision").required(),
        Field::text("title", &Text::LINE, "Title shown to people").required(),
        Field::text("description", &Text::PROSE, "What it teaches").or_text(""),
        Field::new("mastery", Kind::Table(&MASTERY), "When an exercise is mastered").required(),
        Field::new("exercise", Kind::Tables { table: &ENTRY, min: 1, max: 200 }, "Exercises in order").required(),
    ],
};

static MASTERY: Table = Table {
    doc: "passes of the last attempts, or a CUSUM or LC-CUSUM over passes and failures",
    fields: &[
        Field::new("rule", Kind::Choice(&["passes", "cusum", "lc-cusum"]), "Which rule").required(),
        Field::new("passes", Kind::Integer { min: 1, max: 100 }, "Rule passes: how many"),
        Field::new("of", Kind::Integer { min: 1, max: 100 }, "Rule passes: of how many last attempts"),
        Field::number("p0", "", (0.001, 0.999), "Rules cusum, lc-cusum: acceptable failure rate"),
        Field::number("p1", "", (0.001, 0.999), "Rules cusum, lc-cusum: unacceptable failure rate, above p0"),
        Field::number(
            "alpha",
            "",
            (0.001, 0.5),
            "Rules cusum, lc-cusum: type I error; of an lc-cusum, that somebody who fails at p1 is called competent",
        ),
        Field::number("beta", "", (0.001, 0.5), "Rules cusum, lc-cusum: type II error"),
        Field::new(
            "within",
            Kind::Integer { min: 10, max: 200 },
            "Rule lc-cusum: attempts within which alpha holds; 50 where it is left out",
        ),
    ],
};

static ENTRY: Table = Table {
    doc: "An exercise of the curriculum",
    fields: &[
        Field::text("file", &Text::LINE, "Exercise document, relative to this one").required(),
        Field::new("prerequisites", Kind::Texts(&Text::ID), "Ids of exercises to master first").with(Presence::Empty),
        Field::text("survey", &Text::ID, "Id of the instrument shown after each attempt"),
    ],
};
