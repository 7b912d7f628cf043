//! What lies on the graphics card, and how it is drawn.

pub mod buffers;
pub mod layouts;
pub mod pipelines;
pub mod targets;
pub mod textures;
pub mod tiles;

/// The format of every picture. Shaders write values that are encoded as sRGB, which windows show as they are; a format that the
/// card encodes would do it for every sample instead of every pixel, and blends would be brighter than what is behind them.
pub const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
