//! Bodies: closed meshes of what lies in a patient, from numbers or from somebody else's segmentation, and the layers along a needle.
//!
//! Pure: the same numbers give the same bits. No clock, thread, file or log; what is random comes from a seed that is given. Everything is in
//! SI units and in the patient frame: the origin is on the skin where a needle enters, +z points out of the body.

mod body;
mod manifold;
pub mod segmentation;

pub use body::{
    AGES_YEARS, AnatomyPart, Body, BodyEntry, BodyMeasure, BodyMesh, BodyOrder, BodyQuality, BodySide, BodyValues,
    Dimension, LayerOnPath, Level, MidlinePath, Posture, PublishedDimension, Standing, Tissue, WEIGHTS_KG,
    list_published,
};
pub use manifold::{check_manifold, volume_m3};
