//! Compares scenes with published measurements: inside the range, outside, or not comparable, with
//! the reason.
//!
//! No parameter is tuned here. A figure stays in the list whether or not a scene agrees with it,
//! and its source states whether it was read or recalled. Everything is in SI units unless a name
//! contains another unit.

mod compare;
mod curve;
mod figures;
mod insertion;
mod picture;
mod quantity;
mod shipped;
mod sources;
mod table;
mod text;
mod words;

pub use compare::{
    Agreement, DossierLine, Incomparable, SceneDossier, compare_scene, count_inside, make_dossiers, measure_scene,
};
pub use curve::{CURVE_AXES, CurveWords, draw_force_curve, profile_force_n};
pub use figures::{FIGURES, PublishedFigure, PublishedRange};
pub use insertion::insertion_speed_m_per_s;
pub use picture::draw_dossier;
pub use quantity::MeasuredQuantity;
pub use shipped::{SHIPPED_SCENES, find_shipped_scene, read_shipped_scenes};
pub use sources::{MeasurementSource, Provenance};
pub use table::write_dossier_table;
pub use text::{summarise_dossiers, write_dossier_text};
pub use words::describe_line;
