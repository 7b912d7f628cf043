//! The materials' tiles: drawn once by the graphics card, then halved level by level.

use wgpu::{
    CommandEncoder, Device, Queue, Sampler, Texture, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension,
};

use super::layouts::{Layouts, group};
use super::pipelines::{Shaders, covering};
use super::textures::{Plan, view};

/// Pictures: the six materials, and skin cut through.
const MATERIALS: u32 = 7;
/// Width of a tile, in texels.
const TEXELS: u32 = 512;
/// Levels of detail, down to 4 texels.
const LEVELS: u32 = 8;
const HEIGHTS: TextureFormat = TextureFormat::Rgba16Float;

/// Colour and relief of every material.
pub struct Tiles {
    /// Colours.
    pub albedos: TextureView,
    /// Slope, roughness and openness.
    pub reliefs: TextureView,
}

impl Tiles {
    /// Draws them.
    #[must_use]
    pub fn new(device: &Device, queue: &Queue, layouts: &Layouts, shaders: &Shaders) -> Self {
        let plan = Plan { size: [TEXELS; 2], levels: LEVELS, layers: MATERIALS, samples: 1, format: super::FORMAT };
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let textures = [plan.empty(device, usage), plan.empty(device, usage)];
        let mut encoder = device.create_command_encoder(&Default::default());
        paint(device, &mut encoder, (layouts, shaders), &textures);
        for texture in &textures {
            halve(device, &mut encoder, (layouts, shaders), texture);
        }
        queue.submit([encoder.finish()]);
        let [albedos, reliefs] = textures.map(|texture| {
            let dimension = Some(TextureViewDimension::D2Array);
            texture.create_view(&TextureViewDescriptor { dimension, ..Default::default() })
        });
        Self { albedos, reliefs }
    }
}

/// One level of one picture of a texture.
fn level(texture: &Texture, layer: u32, level: u32) -> TextureView {
    texture.create_view(&TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// Colours and heights of a material, then its relief from the heights.
fn paint(
    device: &Device,
    encoder: &mut CommandEncoder,
    (layouts, shaders): (&Layouts, &Shaders),
    textures: &[Texture; 2],
) {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    let heights = view(&Plan::flat([TEXELS; 2], HEIGHTS).empty(device, usage));
    let bind = group(device, &layouts.responses, &[wgpu::BindingResource::TextureView(&heights)]);
    let painting =
        covering(device, &shaders.tiles, ["tile_vertex", "paint_fragment"], (&[], &[super::FORMAT, HEIGHTS]));
    let relief = ["tile_vertex", "relief_fragment"];
    let relieving = covering(device, &shaders.tiles, relief, (&[&layouts.responses], &[super::FORMAT]));
    for material in 0..MATERIALS {
        let mut pass = begin(encoder, &[&level(&textures[0], material, 0), &heights]);
        pass.set_pipeline(&painting);
        pass.draw(0..3, material..material + 1);
        drop(pass);
        let mut pass = begin(encoder, &[&level(&textures[1], material, 0)]);
        pass.set_pipeline(&relieving);
        pass.set_bind_group(0, &bind, &[]);
        pass.draw(0..3, 0..1);
    }
}

fn halve(device: &Device, encoder: &mut CommandEncoder, (layouts, shaders): (&Layouts, &Shaders), texture: &Texture) {
    let pipeline = covering(
        device,
        &shaders.enlarge,
        ["enlarge_vertex", "enlarge_fragment"],
        (&[&layouts.copy], &[texture.format()]),
    );
    let sampler = smooth(device);
    for layer in 0..MATERIALS {
        for below in 1..LEVELS {
            let source = level(texture, layer, below - 1);
            let resources = [wgpu::BindingResource::TextureView(&source), wgpu::BindingResource::Sampler(&sampler)];
            let bind = group(device, &layouts.copy, &resources);
            let mut pass = begin(encoder, &[&level(texture, layer, below)]);
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// Linear within a level, without repeating.
pub fn smooth(device: &Device) -> Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

fn begin<'a>(encoder: &'a mut CommandEncoder, views: &[&TextureView]) -> wgpu::RenderPass<'a> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
    let attachments: Vec<_> = views
        .iter()
        .map(|view| Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }))
        .collect();
    encoder
        .begin_render_pass(&wgpu::RenderPassDescriptor { color_attachments: &attachments, ..Default::default() })
        .forget_lifetime()
}
