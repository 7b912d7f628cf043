//! Compares scenes with published measurements: inside the range, outside, or not comparable, with
//! the reason.
//!
//! No parameter is tuned here. A figure stays in the list whether or not a scene agrees with it,
//! and its source states whether it was read or recalled. Everything is in SI units unless a name
//! contains another unit.

mod compare;
mod figures;
mod insertion;
mod picture;
mod shipped;
mod sources;
mod table;
mod text;
mod words;

pub use compare::{Agreement, DossierLine, Incomparable, SceneDossier, compare_scene, make_dossiers};
pub use figures::{FIGURES, MeasuredQuantity, PublishedFigure, PublishedRange};
pub use picture::draw_dossier;
pub use shipped::{SHIPPED_SCENES, read_shipped_scenes};
pub use sources::{HowKnown, MeasurementSource};
pub use table::write_dossier_table;
pub use text::{list_comparison_lines, write_dossier_text};
