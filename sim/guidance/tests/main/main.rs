//! Fluoroscopy against closed forms and against parry3d.

mod paths;
mod pictures;
