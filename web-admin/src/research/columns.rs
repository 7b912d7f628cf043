//! The tables of a research export. Each column is declared once, for the file and for the
//! codebook.

use recording::tables::{Column, ColumnKind};
use serde_json::{Value, json};

/// A column and its description.
pub struct ResearchColumn {
    name: &'static str,
    kind: ColumnKind,
    optional: bool,
    tells: &'static str,
}

const fn column(name: &'static str, kind: ColumnKind, tells: &'static str) -> ResearchColumn {
    ResearchColumn { name, kind, optional: false, tells }
}

const fn optional(name: &'static str, kind: ColumnKind, tells: &'static str) -> ResearchColumn {
    ResearchColumn { name, kind, optional: true, tells }
}

/// The table of attempts.
pub const ATTEMPTS: [ResearchColumn; 15] = [
    column("session", ColumnKind::Text, "id of the attempt; joins the tables"),
    column("started_at", ColumnKind::Text, "when it began, UTC, RFC 3339"),
    column(
        "pseudonym",
        ColumnKind::Text,
        "whose it is; the same for all attempts of a person, and in their recordings",
    ),
    column("role", ColumnKind::Text, "trainee, instructor or administrator"),
    column("exercise_id", ColumnKind::Text, "what was attempted"),
    column("exercise_sha256", ColumnKind::Text, "hash of the exercise that was attempted, lower-case hexadecimal"),
    column("state", ColumnKind::Text, "pending, scored or refused"),
    optional("score", ColumnKind::Double, "0 to 100, by the grade that counts"),
    optional("passed", ColumnKind::Whole, "1 passed, 0 not, by the grade that counts"),
    optional(
        "computed_score",
        ColumnKind::Double,
        "0 to 100, computed; another than score where somebody has put one in its place",
    ),
    column("duration_s", ColumnKind::Double, "s"),
    column("complete", ColumnKind::Whole, "1 where the recording has its end, 0 where it was cut"),
    column("device", ColumnKind::Text, "with what: a haptic device, or operator: for a virtual hand"),
    column("simulator_version", ColumnKind::Text, "by which program"),
    optional("uncounted", ColumnKind::Text, "why it counts nowhere; empty where it counts"),
];

/// The table of metrics.
pub const METRICS: [ResearchColumn; 6] = [
    column("session", ColumnKind::Text, "id of the attempt"),
    column("metric", ColumnKind::Text, "id of the metric; docs/documents.md defines it"),
    column("version", ColumnKind::Whole, "version of its definition"),
    optional("value", ColumnKind::Double, "in the unit beside it; empty where there is none"),
    column("unit", ColumnKind::Text, "unit of the value; 1 and count for numbers without one"),
    optional("absent", ColumnKind::Text, "why there is no value"),
];

/// The column that precedes the columns of a recording's samples.
pub const SESSION: ResearchColumn = column("session", ColumnKind::Text, "id of the attempt");

impl ResearchColumn {
    /// Returns the column as declared in the file.
    #[must_use]
    pub fn of_file(&self) -> Column {
        Column { name: self.name.to_owned(), kind: self.kind, optional: self.optional }
    }

    fn describe(&self) -> Value {
        let kind = match self.kind {
            ColumnKind::Double | ColumnKind::Float => "number",
            ColumnKind::Whole => "whole number",
            ColumnKind::Text => "text",
        };
        json!({ "name": self.name, "kind": kind, "may_be_empty": self.optional, "tells": self.tells })
    }
}

/// Returns the columns of a file, in order.
#[must_use]
pub fn columns_of_file(columns: &[ResearchColumn]) -> Vec<Column> {
    columns.iter().map(ResearchColumn::of_file).collect()
}

/// Returns the codebook's section on a table.
#[must_use]
pub fn describe_columns(columns: &[ResearchColumn]) -> Value {
    columns.iter().map(ResearchColumn::describe).collect()
}
