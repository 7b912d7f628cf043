//! Tests of bodies, in one program.

mod hostile;
mod nifti;
mod segmentation;
