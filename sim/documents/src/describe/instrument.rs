//! The fields of an instrument: a questionnaire and its scoring key.

use super::{Field, Kind, Presence, Table, Text};

/// A text in the instrument's languages: a field for each language that an instrument may be written in.
macro_rules! in_languages {
    ($doc:literal, $form:expr) => {
        Table {
            doc: $doc,
            fields: &[
                Field::text("en", $form, "In English"),
                Field::text("de", $form, "In German"),
                Field::text("cs", $form, "In Czech"),
                Field::text("da", $form, "In Danish"),
                Field::text("es", $form, "In Spanish"),
                Field::text("fi", $form, "In Finnish"),
                Field::text("fr", $form, "In French"),
                Field::text("it", $form, "In Italian"),
                Field::text("ja", $form, "In Japanese"),
                Field::text("nb", $form, "In Norwegian"),
                Field::text("nl", $form, "In Dutch"),
                Field::text("pl", $form, "In Polish"),
                Field::text("pt", $form, "In Portuguese"),
                Field::text("sv", $form, "In Swedish"),
                Field::text("zh", $form, "In Chinese"),
            ],
        }
    };
}

static LINES: Table = in_languages!("A line of text in each of the instrument's languages", &Text::LINE);
static PROSES: Table = in_languages!("Paragraphs in each of the instrument's languages", &Text::PROSE);

const fn words(key: &'static str, doc: &'static str) -> Field {
    Field::new(key, Kind::Table(&LINES), doc)
}

const fn prose(key: &'static str, doc: &'static str) -> Field {
    Field::new(key, Kind::Table(&PROSES), doc)
}

/// An instrument.
pub(crate) static INSTRUMENT: Table = Table {
    doc: "An instrument: what is asked, how it is answered, and how the answers are scored",
    fields: &[
        Field::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision").required(),
        words("title", "Title shown to people").required(),
        Field::new("languages", Kind::Texts(&Text::ID), "Codes of its languages, the first for whoever speaks none")
            .required(),
        prose("intro", "What to know before the first question"),
        Field::number("duration_min", "min", (0.1, 120.0), "How long it takes").required(),
        Field::text("source", &Text::PROSE, "Who made it, and where it was published").required(),
        Field::text("licence", &Text::PROSE, "Under which terms it may be used").required(),
        Field::new("scale", Kind::Tables { table: &SCALE, min: 1, max: 60 }, "Ways of answering").required(),
        Field::new("section", Kind::Tables { table: &SECTION, min: 0, max: 60 }, "Pages of the form, in order")
            .with(Presence::Empty),
        Field::new("item", Kind::Tables { table: &ITEM, min: 1, max: 300 }, "Questions, in order").required(),
        Field::new("score", Kind::Tables { table: &SCORE, min: 0, max: 60 }, "The scoring key").with(Presence::Empty),
    ],
};

static SCALE: Table = Table {
    doc: "A way of answering, shared by the items that name it",
    fields: &[
        Field::text("id", &Text::ID, "Name for items").required(),
        Field::new(
            "kind",
            Kind::Choice(&["likert", "slider", "pair", "choice", "choices", "number", "text"]),
            "A row of points; a line to set a mark on; one of two items; one option; several options; a number; a text",
        )
        .required(),
        Field::new("points", Kind::Integer { min: 2, max: 11 }, "likert: answers go from 1 to this"),
        Field::new("labels", Kind::Tables { table: &LINES, min: 2, max: 11 }, "likert: a label for each point"),
        words("first", "likert, slider: what the low end means"),
        words("last", "likert, slider: what the high end means"),
        Field::new(
            "relevant_from",
            Kind::Integer { min: 2, max: 11 },
            "likert: answers from here on call an item relevant (content validity)",
        ),
        Field::number("min", "", (-1e9, 1e9), "slider, number: least answer"),
        Field::number("max", "", (-1e9, 1e9), "slider, number: largest answer"),
        Field::number("step", "", (1e-6, 1e9), "slider: distance between two answers"),
        Field::text("unit", &Text::NAME, "number: the unit of the answer"),
        Field::new("option", Kind::Tables { table: &OPTION, min: 2, max: 40 }, "choice, choices: what to choose from"),
        Field::new("max_characters", Kind::Integer { min: 1, max: 10_000 }, "text: how long it may be"),
    ],
};

static OPTION: Table = Table {
    doc: "Something to choose",
    fields: &[Field::text("id", &Text::ID, "What is stored").required(), words("text", "What is read").required()],
};

static SECTION: Table = Table {
    doc: "A page of the form",
    fields: &[
        Field::text("id", &Text::ID, "Name for items").required(),
        words("title", "Its heading").required(),
        prose("text", "What to know before its questions"),
        Field::new("when", Kind::Table(&WHEN), "Asked only after certain answers"),
    ],
};

static WHEN: Table = Table {
    doc: "A condition on an item of an earlier section",
    fields: &[
        Field::text("item", &Text::ID, "The item").required(),
        Field::new("is", Kind::Texts(&Text::ID), "The answers that fulfil it: ids of options, or points").required(),
    ],
};

static ITEM: Table = Table {
    doc: "A question",
    fields: &[
        Field::text("id", &Text::ID, "Name in answers, scores and exports").required(),
        Field::text("section", &Text::ID, "Its section, where there are sections"),
        words("name", "A short name, for results and for pairs"),
        words("text", "The question").required(),
        Field::text("scale", &Text::ID, "How it is answered").required(),
        Field::new("pair", Kind::Texts(&Text::ID), "kind pair: the two items of which one is chosen")
            .with(Presence::Empty),
        Field::new("when", Kind::Table(&WHEN), "Asked only after certain answers"),
    ],
};

static SCORE: Table = Table {
    doc: "A score: (sum or mean of the items, each reversed where it is said and shifted) × factor + offset",
    fields: &[
        Field::text("id", &Text::ID, "Name in results and exports").required(),
        words("title", "Title shown to people").required(),
        Field::new("items", Kind::Texts(&Text::ID), "The items that count").required(),
        Field::new("reversed", Kind::Texts(&Text::ID), "Those of them that count as least + largest − answer")
            .with(Presence::Empty),
        Field::number("shift", "", (-1e6, 1e6), "Added to each item").or(0.0),
        Field::new("combine", Kind::Choice(&["sum", "mean", "pair-weighted"]), "How the items are put together")
            .required(),
        Field::new("pairs", Kind::Texts(&Text::ID), "pair-weighted: an item weighs how often these choose it")
            .with(Presence::Empty),
        Field::number("factor", "", (-1e6, 1e6), "The combination is multiplied by it").or(1.0),
        Field::number("offset", "", (-1e6, 1e6), "Added in the end").or(0.0),
        Field::new(
            "missing",
            Kind::Choice(&["no-score", "mean-of-answered"]),
            "What an item without an answer does: away with the score, or it counts as the mean of the others",
        )
        .or_text("no-score"),
        Field::new("least_answered", Kind::Integer { min: 1, max: 300 }, "mean-of-answered: so many must be answered"),
        Field::new("better", Kind::Choice(&["higher", "lower"]), "Which end is the good one, where there is one"),
    ],
};
