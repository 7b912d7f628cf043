//! The fields of an instrument: a questionnaire and its scoring key.

use super::{DescribedField, DescribedTable, FieldKind, Presence, Text};

/// A table of texts: one field for each language that an instrument may be written in.
macro_rules! in_languages {
    ($doc:literal, $form:expr) => {
        DescribedTable {
            doc: $doc,
            fields: &[
                DescribedField::text("en", $form, "In English"),
                DescribedField::text("de", $form, "In German"),
                DescribedField::text("cs", $form, "In Czech"),
                DescribedField::text("da", $form, "In Danish"),
                DescribedField::text("es", $form, "In Spanish"),
                DescribedField::text("fi", $form, "In Finnish"),
                DescribedField::text("fr", $form, "In French"),
                DescribedField::text("it", $form, "In Italian"),
                DescribedField::text("ja", $form, "In Japanese"),
                DescribedField::text("nb", $form, "In Norwegian"),
                DescribedField::text("nl", $form, "In Dutch"),
                DescribedField::text("pl", $form, "In Polish"),
                DescribedField::text("pt", $form, "In Portuguese"),
                DescribedField::text("sv", $form, "In Swedish"),
                DescribedField::text("zh", $form, "In Chinese"),
            ],
        }
    };
}

pub(super) static LINES: DescribedTable =
    in_languages!("A line of text in each of the document's languages", &Text::LINE);
pub(super) static PROSES: DescribedTable =
    in_languages!("Paragraphs in each of the document's languages", &Text::PROSE);

/// Returns the codes of the languages in which a document may be written.
pub fn list_document_languages() -> impl Iterator<Item = &'static str> {
    LINES.fields.iter().map(|field| field.key)
}

const fn words(key: &'static str, doc: &'static str) -> DescribedField {
    DescribedField::new(key, FieldKind::Table(&LINES), doc)
}

const fn prose(key: &'static str, doc: &'static str) -> DescribedField {
    DescribedField::new(key, FieldKind::Table(&PROSES), doc)
}

/// An instrument.
pub(crate) static INSTRUMENT: DescribedTable = DescribedTable {
    doc: "An instrument: questions, answer scales and scoring",
    fields: &[
        DescribedField::text("id", &Text::ID, "Identifier; with the SHA-256 of the bytes it names a revision")
            .required(),
        words("title", "Title shown to people").required(),
        DescribedField::new(
            "languages",
            FieldKind::Texts(&Text::ID),
            "Codes of its languages; the first is the fallback",
        )
        .required(),
        prose("intro", "Introduction before the first question"),
        DescribedField::number("duration_min", "min", 0.1..=120.0, "How long it takes").required(),
        DescribedField::text("source", &Text::PROSE, "Authors and publication").required(),
        DescribedField::text("licence", &Text::PROSE, "Terms of use").required(),
        DescribedField::new("scale", FieldKind::Tables { table: &SCALE, min: 1, max: 60 }, "Ways of answering")
            .required(),
        DescribedField::new(
            "section",
            FieldKind::Tables { table: &SECTION, min: 0, max: 60 },
            "Pages of the form, in order",
        )
        .with(Presence::Empty),
        DescribedField::new("item", FieldKind::Tables { table: &ITEM, min: 1, max: 300 }, "Questions, in order")
            .required(),
        DescribedField::new("score", FieldKind::Tables { table: &SCORE, min: 0, max: 60 }, "The scoring key")
            .with(Presence::Empty),
    ],
};

static SCALE: DescribedTable = DescribedTable {
    doc: "An answer scale, shared by the items that refer to it",
    fields: &[
        DescribedField::text("id", &Text::ID, "Name for items").required(),
        DescribedField::new(
            "kind",
            FieldKind::Choice(&["likert", "slider", "pair", "choice", "choices", "number", "text"]),
            "A row of points; a line to mark; one of two items; one option; several options; a number; a text",
        )
        .required(),
        DescribedField::new("points", FieldKind::Integer { min: 2, max: 11 }, "likert: answers go from 1 to this"),
        DescribedField::new(
            "labels",
            FieldKind::Tables { table: &LINES, min: 2, max: 11 },
            "likert: a label for each point",
        ),
        words("first", "likert, slider: meaning of the low end"),
        words("last", "likert, slider: meaning of the high end"),
        DescribedField::new(
            "relevant_from",
            FieldKind::Integer { min: 2, max: 11 },
            "likert: answers from this point on rate an item as relevant (content validity)",
        ),
        DescribedField::number("min", "", -1e9..=1e9, "slider, number: least answer"),
        DescribedField::number("max", "", -1e9..=1e9, "slider, number: largest answer"),
        DescribedField::number("step", "", 1e-6..=1e9, "slider: distance between two answers"),
        DescribedField::text("unit", &Text::NAME, "number: the unit of the answer"),
        DescribedField::new(
            "option",
            FieldKind::Tables { table: &OPTION, min: 2, max: 40 },
            "choice, choices: the options",
        ),
        DescribedField::new("max_characters", FieldKind::Integer { min: 1, max: 10_000 }, "text: maximum length"),
    ],
};

static OPTION: DescribedTable = DescribedTable {
    doc: "An option",
    fields: &[
        DescribedField::text("id", &Text::ID, "Stored value").required(),
        words("text", "Displayed text").required(),
    ],
};

static SECTION: DescribedTable = DescribedTable {
    doc: "A page of the form",
    fields: &[
        DescribedField::text("id", &Text::ID, "Name for items").required(),
        words("title", "Its heading").required(),
        prose("text", "What to know before its questions"),
        DescribedField::new("when", FieldKind::Table(&WHEN), "Asked only after certain answers"),
    ],
};

static WHEN: DescribedTable = DescribedTable {
    doc: "A condition on an item of an earlier section",
    fields: &[
        DescribedField::text("item", &Text::ID, "The item").required(),
        DescribedField::new("is", FieldKind::Texts(&Text::ID), "The answers that meet it: ids of options, or points")
            .required(),
    ],
};

static ITEM: DescribedTable = DescribedTable {
    doc: "A question",
    fields: &[
        DescribedField::text("id", &Text::ID, "Name in answers, scores and exports").required(),
        DescribedField::text("section", &Text::ID, "Its section, if there are sections"),
        words("name", "A short name, for results and for pairs"),
        words("text", "The question").required(),
        DescribedField::text("scale", &Text::ID, "How it is answered").required(),
        DescribedField::new("pair", FieldKind::Texts(&Text::ID), "kind pair: the two items of which one is chosen")
            .with(Presence::Empty),
        DescribedField::new("when", FieldKind::Table(&WHEN), "Asked only after certain answers"),
    ],
};

static SCORE: DescribedTable = DescribedTable {
    doc: "A score: (sum or mean of the items, each shifted, and reversed if listed) × factor + offset",
    fields: &[
        DescribedField::text("id", &Text::ID, "Name in results and exports").required(),
        words("title", "Title shown to people").required(),
        DescribedField::new("items", FieldKind::Texts(&Text::ID), "The items that count").required(),
        DescribedField::new(
            "reversed",
            FieldKind::Texts(&Text::ID),
            "Reversed items, which count as least + largest − answer",
        )
        .with(Presence::Empty),
        DescribedField::number("shift", "", -1e6..=1e6, "Added to each item").or(0.0),
        DescribedField::new(
            "combine",
            FieldKind::Choice(&["sum", "mean", "pair-weighted"]),
            "How the items are combined",
        )
        .required(),
        DescribedField::new(
            "pairs",
            FieldKind::Texts(&Text::ID),
            "pair-weighted: an item's weight is how often these choose it",
        )
        .with(Presence::Empty),
        DescribedField::number("factor", "", -1e6..=1e6, "Factor of the combination").or(1.0),
        DescribedField::number("offset", "", -1e6..=1e6, "Added in the end").or(0.0),
        DescribedField::new(
            "missing",
            FieldKind::Choice(&["no-score", "mean-of-answered"]),
            "Effect of a missing answer: no score, or the item counts as the mean of the others",
        )
        .or_text("no-score"),
        DescribedField::new(
            "least_answered",
            FieldKind::Integer { min: 1, max: 300 },
            "mean-of-answered: minimum number of answers",
        ),
        DescribedField::new("better", FieldKind::Choice(&["higher", "lower"]), "Which end is better, if one is"),
    ],
};
