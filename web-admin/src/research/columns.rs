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
    column("started_at", ColumnKind::Text, "start of the attempt, UTC, RFC 3339"),
    column(
        "pseudonym",
        ColumnKind::Text,
        "pseudonym of the trainee; the same in all attempts and recordings of a person",
    ),
    column("role", ColumnKind::Text, "trainee, instructor or administrator"),
    column("exercise_id", ColumnKind::Text, "id of the exercise"),
    column("exercise_sha256", ColumnKind::Text, "SHA-256 of the exercise document, lower-case hexadecimal"),
    column("state", ColumnKind::Text, "pending, scored or refused"),
    optional("score", ColumnKind::Double, "0 to 100, of the grade that counts"),
    optional("passed", ColumnKind::Whole, "1 passed, 0 not passed, of the grade that counts"),
    optional(
        "computed_score",
        ColumnKind::Double,
        "0 to 100, computed; differs from score if an instructor has overridden it",
    ),
    column("duration_s", ColumnKind::Double, "s"),
    column("complete", ColumnKind::Whole, "1 if the recording is complete, 0 if it is truncated"),
    column("device", ColumnKind::Text, "device: a haptic device, or operator: for a virtual hand"),
    column("simulator_version", ColumnKind::Text, "version of the simulator"),
    optional("uncounted", ColumnKind::Text, "why it does not count; empty if it counts"),
];

/// The table of metrics.
pub const METRICS: [ResearchColumn; 6] = [
    column("session", ColumnKind::Text, "id of the attempt"),
    column("metric", ColumnKind::Text, "id of the metric; docs/documents.md defines it"),
    column("version", ColumnKind::Whole, "version of its definition"),
    optional("value", ColumnKind::Double, "in the unit of the unit column; empty if there is no value"),
    column("unit", ColumnKind::Text, "unit of the value; 1 and count for numbers without one"),
    optional("absent", ColumnKind::Text, "why the value is missing"),
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
