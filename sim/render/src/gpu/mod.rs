//! What lies on the graphics card, and how it is drawn.

pub mod buffers;
pub mod layouts;
pub mod pipelines;
pub mod targets;
pub mod textures;
pub mod tiles;

/// The colours' format of every picture. Shaders write linear light, the card encodes it.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
