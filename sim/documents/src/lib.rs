//! Documents: scenes, exercises, curricula and instruments in TOML. Parses them, reports errors
//! with their location, and derives the parameters of the law and of the tissue.
//!
//! Documents use millimetres and newtons; [`Scene::specimen_spec`] returns SI.

pub mod check;
pub mod curriculum;
pub mod error;
pub mod exercise;
mod expand;
mod feedback;
mod feel;
pub mod field_case;
pub mod force_case;
pub mod instrument;
pub mod load;
pub mod metrics;
pub mod model;
pub mod patient;
pub mod picture;
pub mod rewrite;
pub mod schema;
pub mod segmentation;

mod describe;
#[cfg(test)]
mod handbook;
mod json;
mod loss;
mod mesh;
mod placing;
mod planned;
mod provenance;
mod read_anatomy;
mod read_curriculum;
mod read_exercise;
mod read_instrument;
mod read_options;
mod read_scene;
mod scaling;
mod scene_body;
mod source;
mod structure_names;
mod suggest;
mod tip;
mod tissue;
mod walk;
mod way;
mod wording;

pub use check::{check_documents, spec_along_path};
pub use curriculum::{Curriculum, MasteryRule};
pub use describe::list_document_languages;
pub use error::{DocumentError, Issue, Remark};
pub use exercise::{CoachingRule, Exercise, ExercisePicture, FluoroscopySettings, HardFail, Required, RubricLine};
pub use feedback::{Channel, Feedback};
pub use feel::TissueFeel;
pub use instrument::Instrument;
pub use law::structures::{Shape, StructureKind, StructureSpec};
pub use load::{Document, DocumentKind, ExerciseBundle};
pub use mesh::write_stl;
pub use model::{
    Needle, NeedleFamily, Scene, SceneFibres, SceneLayer, SceneLayerOptions, SceneSkin, SceneStructure, TissueOptions,
};
pub use patient::Patient;
pub use planned::PlannedNeedle;
pub use provenance::ClassCounts;
pub use scene_body::SceneBody;
pub use schema::document_schema;
pub use segmentation::{SegmentationEntry, SegmentationLabel, SegmentationLabels};
pub use source::{MOST_BYTES, list_named_texts};
pub use structure_names::{SHIPPED_STRUCTURE_NAMES, name_structure};
pub use tip::{NeedleScaling, UnknownScaling};
pub use wording::Wording;
