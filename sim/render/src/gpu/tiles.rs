//! The tiles of the materials: rendered once by the GPU with their mip levels, and combined into
//! array textures.

use wgpu::{
    BindGroup, BindingResource, CommandEncoder, Device, Origin3d, Queue, RenderPipeline, Sampler, TexelCopyTextureInfo,
    Texture, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor, TextureViewDimension,
};

use super::layouts::{Layouts, group};
use super::pipelines::{Shaders, covering};
use super::textures::{TexturePlan, view};

/// Fragment shaders of the tiles: the six materials in the order of
/// [`crate::frame::DrawnMaterial`], and the cut skin.
const MATERIALS: [&str; 7] =
    ["paint_skin", "paint_fat", "paint_muscle", "paint_fascia", "paint_bone", "paint_fluid", "paint_dermis"];
/// Width of a tile, in texels.
const TEXELS: u32 = 512;
/// Number of mip levels, down to 4 texels.
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
    /// Renders the tiles.
    #[must_use]
    pub fn new(device: &Device, queue: &Queue, layouts: &Layouts, shaders: &Shaders) -> Self {
        let layers = MATERIALS.len() as u32;
        let plan = TexturePlan { size: [TEXELS; 2], levels: LEVELS, layers, samples: 1, format: super::FORMAT };
        let textures = [(); 2].map(|()| plan.empty(device, TextureUsages::COPY_DST | TextureUsages::TEXTURE_BINDING));
        let easel = Easel::new(device, layouts, shaders);
        let mut encoder = device.create_command_encoder(&Default::default());
        for (material, painting) in (0..).zip(&easel.painting) {
            easel.paint(&mut encoder, painting);
            for (sheet, texture) in easel.sheets.iter().zip(&textures) {
                sheet.halve(&mut encoder, &easel.halving);
                sheet.copy(&mut encoder, texture, material);
            }
        }
        queue.submit([encoder.finish()]);
        let [albedos, reliefs] = textures.map(|texture| {
            let dimension = Some(TextureViewDimension::D2Array);
            texture.create_view(&TextureViewDescriptor { dimension, ..Default::default() })
        });
        Self { albedos, reliefs }
    }
}

/// Render targets for one material after the other, from which the tiles are copied. OpenGL cannot
/// sample one level of one array layer.
struct Easel {
    /// One pipeline per material.
    painting: [RenderPipeline; MATERIALS.len()],
    relieving: RenderPipeline,
    halving: RenderPipeline,
    heights: TextureView,
    /// The heights, as input of the relief.
    bind: BindGroup,
    /// Colour and relief.
    sheets: [Sheet; 2],
}

/// One image with all mip levels, each a texture of its own.
struct Sheet {
    levels: Vec<(Texture, TextureView)>,
    /// Each level, as input of the next.
    binds: Vec<BindGroup>,
}

impl Easel {
    fn new(device: &Device, layouts: &Layouts, shaders: &Shaders) -> Self {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let heights = view(&TexturePlan::flat([TEXELS; 2], HEIGHTS).empty(device, usage));
        let paint = |entry| covering(device, &shaders.tiles, ["tile_vertex", entry], &[], &[super::FORMAT, HEIGHTS]);
        let relief = ["tile_vertex", "relief_fragment"];
        let halve = ["enlarge_vertex", "enlarge_fragment"];
        Self {
            painting: MATERIALS.map(paint),
            relieving: covering(device, &shaders.tiles, relief, &[&layouts.responses], &[super::FORMAT]),
            halving: covering(device, &shaders.enlarge, halve, &[&layouts.copy], &[super::FORMAT]),
            bind: group(device, &layouts.responses, &[BindingResource::TextureView(&heights)]),
            heights,
            sheets: [(); 2].map(|()| Sheet::new(device, layouts)),
        }
    }

    /// Renders colours and heights of a material, then its relief from the heights.
    fn paint(&self, encoder: &mut CommandEncoder, painting: &RenderPipeline) {
        let [colours, reliefs] = &self.sheets;
        let mut pass = begin(encoder, &[&colours.levels[0].1, &self.heights]);
        pass.set_pipeline(painting);
        pass.draw(0..3, 0..1);
        drop(pass);
        let mut pass = begin(encoder, &[&reliefs.levels[0].1]);
        pass.set_pipeline(&self.relieving);
        pass.set_bind_group(0, &self.bind, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl Sheet {
    fn new(device: &Device, layouts: &Layouts) -> Self {
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        let level = |level: u32| {
            let texture = TexturePlan::flat([TEXELS >> level; 2], super::FORMAT).empty(device, usage);
            let view = view(&texture);
            (texture, view)
        };
        let levels: Vec<_> = (0..LEVELS).map(level).collect();
        let sampler = smooth(device);
        let bind = |(_, source): &(Texture, TextureView)| {
            let resources = [BindingResource::TextureView(source), BindingResource::Sampler(&sampler)];
            group(device, &layouts.copy, &resources)
        };
        Self { binds: levels.iter().map(bind).collect(), levels }
    }

    /// Renders each level from the one above it.
    fn halve(&self, encoder: &mut CommandEncoder, halving: &RenderPipeline) {
        for (bind, (_, below)) in self.binds.iter().zip(&self.levels[1..]) {
            let mut pass = begin(encoder, &[below]);
            pass.set_pipeline(halving);
            pass.set_bind_group(0, bind, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    /// Copies all levels into one layer of an array texture.
    fn copy(&self, encoder: &mut CommandEncoder, texture: &Texture, picture: u32) {
        for (mip_level, (source, _)) in (0..).zip(&self.levels) {
            let origin = Origin3d { z: picture, ..Origin3d::ZERO };
            let onto = TexelCopyTextureInfo { mip_level, origin, ..texture.as_image_copy() };
            encoder.copy_texture_to_texture(source.as_image_copy(), onto, source.size());
        }
    }
}

/// A sampler that is linear within a level, without repeating.
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
