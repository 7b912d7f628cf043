//! The renderer: turns a frame of plain data into pixels.

mod adapters;
pub mod camera;
mod drape;
mod field;
pub mod frame;
mod gpu;
mod headless;
mod meshes;
mod placement;
mod quality;
mod renderer;
mod scene_block;
mod skin;
mod wounds;

pub use adapters::{AdapterError, AdapterName, adapters, usable_adapter};
pub use gpu::FORMAT;
pub use headless::{Headless, PictureError};
pub use quality::{Governor, Quality};
pub use renderer::{Renderer, StageError};
