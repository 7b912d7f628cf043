//! Converts label maps from external segmentations to closed meshes, a patient frame, and the
//! layers at an entry.

mod body;
mod contour;
mod entry;
mod error;
mod grid;
mod header;
mod map;
mod mesh;
mod smooth;
mod survey;

pub use body::BODY;
pub use entry::{EntryFrame, LabelRole, MeasuredLayer, measure_layers};
pub use error::SegmentationError;
pub use header::{Orientation, Placement};
pub use map::LabelMap;
pub use mesh::{LabelMesh, MeshRequest, mesh_label};
pub use survey::LabelExtent;
