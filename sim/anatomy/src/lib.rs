//! Bodies: closed meshes of a patient's anatomy, from parameters or from an external segmentation,
//! and the layers along a needle.
//!
//! Pure: equal inputs give identical bits. No clock, thread, file or log; randomness comes from a
//! given seed. Everything is in SI units and in the patient frame: the origin is on the skin where
//! a needle enters, +z points out of the body.

mod body;
mod manifold;
pub mod segmentation;

pub use body::{
    AGES_YEARS, AnatomyPart, Body, BodyEntry, BodyMeasure, BodyMesh, BodyOrder, BodyQuality, BodySide, BodyValues,
    BodyVolume, Contrast, Dimension, LayerOnPath, Level, MidlinePath, Posture, PublishedDimension, Standing, Substance,
    Tissue, WEIGHTS_KG, list_published,
};
pub use manifold::{check_manifold, volume_m3};
