//! The bind group layouts of the shaders.

use wgpu::{
    BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType, BufferBindingType, Device,
    SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension,
};

/// The bind group layouts.
pub struct Layouts {
    /// The frame's uniforms, the skin's shape, the field.
    pub scene: BindGroupLayout,
    /// The materials' tiles and the shadow map.
    pub materials: BindGroupLayout,
    /// The field's responses.
    pub responses: BindGroupLayout,
    /// A texture and a sampler.
    pub copy: BindGroupLayout,
}

impl Layouts {
    /// Creates the layouts.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        let unfiltered = texture(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2);
        let bits = texture(TextureSampleType::Uint, TextureViewDimension::D2);
        let filtered = |dimension| texture(TextureSampleType::Float { filterable: true }, dimension);
        let uniform =
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
        let filtering = BindingType::Sampler(SamplerBindingType::Filtering);
        let tiles = filtered(TextureViewDimension::D2Array);
        let depth = texture(TextureSampleType::Depth, TextureViewDimension::D2);
        let comparison = BindingType::Sampler(SamplerBindingType::Comparison);
        Self {
            scene: layout(device, "scene", &[uniform, unfiltered, bits]),
            materials: layout(device, "materials", &[tiles, tiles, filtering, depth, comparison]),
            responses: layout(device, "responses", &[unfiltered]),
            copy: layout(device, "copy", &[filtered(TextureViewDimension::D2), filtering]),
        }
    }
}

fn texture(sample_type: TextureSampleType, view_dimension: TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

fn layout(device: &Device, label: &str, bindings: &[BindingType]) -> BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(bindings)
        .map(|(binding, ty)| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: *ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Creates a bind group with resources in the order of its layout.
#[must_use]
pub fn group(device: &Device, layout: &BindGroupLayout, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
