//! Tests of bodies, in one program.

#[cfg(test)]
mod bodies;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod nifti;
#[cfg(test)]
mod segmentation;
