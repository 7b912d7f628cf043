//! `stylet schema`: prints the JSON Schema of a document.

use clap::ValueEnum;

use crate::exit::Outcome;
use crate::output;

/// Print the JSON Schema of a kind of document
#[derive(clap::Args)]
#[command(after_help = "Example:\n  stylet schema scene > scene.schema.json")]
pub struct SchemaArgs {
    /// Kind of document
    kind: SchemaKind,
}

/// The kinds of documents that have a schema.
#[derive(Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// Layers, needle and structures
    Scene,
    /// The task in a scene and its rubric
    Exercise,
    /// A course of exercises
    Curriculum,
    /// A questionnaire and its scoring key
    Instrument,
}

/// Runs the command.
pub fn run(args: &SchemaArgs) -> Outcome {
    let kind = match args.kind {
        SchemaKind::Scene => documents::DocumentKind::Scene,
        SchemaKind::Exercise => documents::DocumentKind::Exercise,
        SchemaKind::Curriculum => documents::DocumentKind::Curriculum,
        SchemaKind::Instrument => documents::DocumentKind::Instrument,
    };
    output::print_json(&documents::document_schema(kind))
}
