//! Intermediate render targets: samples, depth, shadows, and the smaller image of a low quality.

use wgpu::{Device, TextureUsages, TextureView};

use super::FORMAT;
use super::pipelines::{DEPTH, SHADOW};
use super::textures::{TexturePlan, view};
use crate::quality::Quality;

/// Targets of one size and quality.
pub struct Targets {
    /// Multisampled colour, if used.
    pub samples: Option<TextureView>,
    /// The smaller image, if the quality requires one.
    pub small: Option<TextureView>,
    /// Depth and stencil.
    pub depth: TextureView,
    /// Depth in the lamp's view; one texel without shadows.
    pub shadow: TextureView,
}

impl Targets {
    /// Creates the targets for images of a size.
    #[must_use]
    pub fn new(device: &Device, picture: [u32; 2], quality: Quality) -> Self {
        let size = picture.map(|side| ((side as f32 * quality.resolution()).round() as u32).max(1));
        let colour = TexturePlan::flat(size, FORMAT);
        let sampled = TexturePlan { samples: quality.samples(), ..colour };
        let attachment = TextureUsages::RENDER_ATTACHMENT;
        let readable = attachment | TextureUsages::TEXTURE_BINDING;
        let shadow = TexturePlan::flat([quality.shadow_texels().max(1); 2], SHADOW);
        Self {
            samples: (quality.samples() > 1).then(|| view(&sampled.empty(device, attachment))),
            small: (size != picture).then(|| view(&colour.empty(device, readable))),
            depth: view(&TexturePlan { format: DEPTH, ..sampled }.empty(device, attachment)),
            shadow: view(&shadow.empty(device, readable)),
        }
    }
}
