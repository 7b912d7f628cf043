//! GPU resources and pipelines.

pub mod buffers;
pub mod layouts;
pub mod pipelines;
pub mod targets;
pub mod textures;
pub mod tiles;

/// The format of every image. Shaders write sRGB-encoded values, which windows show unchanged; an
/// sRGB format would encode every sample instead of every pixel, and blending would be brighter
/// than the background.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
